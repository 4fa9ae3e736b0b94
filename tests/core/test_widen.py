"""Where a search begins with more modes than a fit has."""

from types import SimpleNamespace

import numpy as np

from core.widen import begun


def test_further_modes_begin_behind_the_others_of_every_set_of_pitches_and_take():
    """Two modes heard, two more; two sets of pitches, three takes, in one of which the first mode
    is silent.
    """
    pitches = np.log([[3.0, 5.0], [2.0, 4.0]])
    ratios = np.array([[0.1, 0.002], [0.05, 0.03]])
    starts = np.array(
        [[[1.0, 2.0], [3.0, 4.0]], [[0.0, 5.0], [0.0, 6.0]], [[7.0, 8.0], [9.0, 1.0]]]
    )
    outer = np.concatenate([np.stack([pitches, ratios], axis=1).ravel(), starts.ravel()])
    law = SimpleNamespace(modes=2, sizes=lambda: (8, 12, 3))
    found = SimpleNamespace(law=law, parameters=np.r_[outer, 1.0, 2.0, 3.0])
    more = np.log([2.0, 3.0])
    p = begun(found, more, lambda own: own.min(), lambda own: (0.1 * np.hypot(*own).max(), 0.0))
    a, b = p[:16].reshape(2, 2, 4), p[16:].reshape(3, 2, 4)
    assert np.allclose(a[:, 0], np.hstack([pitches, pitches[:, :1] + more]))
    assert np.allclose(a[:, 1], np.hstack([ratios, [[0.002] * 2, [0.03] * 2]]))
    assert (b[:, :, :2] == starts).all()
    assert np.allclose(b[:, 0, 2:], 0.1 * np.hypot(*starts.swapaxes(0, 1)).max(axis=1)[:, None])
    assert (b[:, 0, 2:] > 0).all() and (b[:, 1, 2:] == 0).all()
