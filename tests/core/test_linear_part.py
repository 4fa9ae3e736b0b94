"""The linear part of the law: sums over what there is, channel by channel."""

import numpy as np
import pytest

from core.linear_part import _normal


@pytest.mark.parametrize("share", [0.0, 0.03, 0.7])
@pytest.mark.parametrize("delayed", [False, True])
def test_normal_equations_hold_what_a_channel_has_and_no_more(share, delayed):
    """Whether few samples are missing, most are, or none is; and where no channel has any."""
    rng = np.random.default_rng(4)
    B, C, T, n = 3, 4, 60, 5
    basis = rng.normal(size=(B, C if delayed else 1, T, n))
    use = rng.random((T, C)) >= share
    use[50:] = False
    values = np.where(use, rng.normal(size=(T, C)), np.nan)
    gram, right = _normal(basis, values, use)
    for b in range(B):
        for c in range(C):
            own = basis[b, c if delayed else 0, use[:, c]]
            assert gram[b, c % gram.shape[1]] == pytest.approx(own.T @ own)
            assert right[b, c] == pytest.approx(own.T @ values[use[:, c], c])
