"""What a fit foretells is off by as much as what it cannot know says."""

import numpy as np
import pytest

from core import foretold
from core.data import replace
from core.foretold import doubt
from core.residual import NOISY, misfit
from core.sufficiency import fails
from tests.core.test_timefit import AMPLITUDE, SHAPE, TIME, W, channels, declared

SEEDS = 40


def recorded(noise, seed, seen=2 / 3, clean=1.0):
    """(Channels, (T, C) without noise) of a swing that hardly dies, of which the first part is
    fitted; `clean` (T,) goes with it.
    """
    swing = AMPLITUDE * clean * np.exp(-0.004 * W * TIME) * np.cos(W * TIME)
    values, rng = np.outer(swing, SHAPE), np.random.default_rng(seed)
    sigma = noise * AMPLITUDE
    data = channels(values + sigma * rng.standard_normal(values.shape), sigma=sigma)
    return replace(data, fit=seen * TIME[-1] >= TIME), values


@pytest.mark.parametrize("noise", [0.02, 0.2], ids=["quiet", "noisy"])
@pytest.mark.parametrize("seen", [0.4, 2 / 3], ids=["briefly seen", "seen"])
def test_what_is_foretold_is_off_by_the_doubt_on_average(noise, seen, monkeypatch):
    over, told, pitch = [], [], []
    for seed in range(SEEDS):
        data, clean = recorded(noise, seed, seen)
        found = declared(data)
        off = (found.predicted[0] - clean)[~data.fit] / (noise * AMPLITUDE)
        over.append((off**2).sum())
        told.append(doubt(found))
        with monkeypatch.context() as patched:
            patched.setattr(foretold, "_of_shapes", lambda *_: 0.0)
            pitch.append(doubt(found))
    assert np.mean(told) == pytest.approx(np.mean(over), rel=0.35)
    if seen < 0.5:  # what pitch and damping do, where that is most of it
        assert np.mean(pitch) > 0.6 * np.mean(told)


def test_only_what_the_fitted_part_could_have_told_is_a_failure():
    raw = wrong = right = 0
    for seed in range(SEEDS):
        data, _ = recorded(0.1, seed, 0.12)
        found = declared(data)
        left, count = misfit(found.law.takes, found.predicted, True)
        raw += left > NOISY * count
        wrong += fails(found)
        bent, _ = recorded(0.1, seed, 0.5, clean=1 - 0.6 * (TIME > 2.5))
        right += fails(declared(bent))
    assert raw > 0.25 * SEEDS and wrong < 0.5 * raw
    assert right == SEEDS
