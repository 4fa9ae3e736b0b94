"""Sums over what there is, channel by channel."""

import numpy as np
import pytest

from core.normal_equations import coefficients_of, normal


@pytest.mark.parametrize("share", [0.0, 0.03, 0.7])
@pytest.mark.parametrize("delayed", [False, True])
def test_normal_equations_hold_what_a_channel_has_and_no_more(share, delayed):
    """Whether few samples are missing, most are, or none is; and where no channel has any."""
    rng = np.random.default_rng(4)
    B, C, T, n = 3, 4, 60, 5
    basis = rng.normal(size=(B, C if delayed else 1, T, n))
    use = rng.random((T, C)) >= share
    use[50:], use[:, 3] = False, use[:, 2]
    values = np.where(use, rng.normal(size=(T, C)), np.nan)
    gram, right, of = normal(basis, values, use)
    assert gram.shape[1] == (C if delayed else 3 if share else 1)
    barred = np.zeros((C, n), bool)
    barred[1, 2] = True
    found = coefficients_of(gram, right, of, barred)
    for b in range(B):
        for c in range(C):
            own, y = basis[b, c if delayed else 0, use[:, c]], values[use[:, c], c]
            assert gram[b, of[c]] == pytest.approx(own.T @ own)
            assert right[b, c] == pytest.approx(own.T @ y)
            free = ~barred[c]
            assert found[b, c, ~free] == pytest.approx(0, abs=1e-9)
            least = np.linalg.lstsq(own[:, free], y, rcond=None)[0]
            assert found[b, c, free] == pytest.approx(least, rel=1e-6)


def test_what_has_died_before_a_channel_begins_keeps_its_digits():
    """Off the whole of a column that was large before, what is left would be rounding."""
    t = np.linspace(0, 1, 80)
    basis = np.stack([np.exp(-60 * t), np.cos(9 * t)], axis=1)[None, None]
    use = np.ones((80, 2), bool)
    use[:35, 1] = False
    gram, _, of = normal(basis, np.ones((80, 2)), use)
    own = basis[0, 0, 35:]
    assert gram[0, of[1]] == pytest.approx(own.T @ own, rel=1e-9, abs=0)
