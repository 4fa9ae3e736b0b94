"""What a fit foretells is off by as much as what it cannot know says."""

import numpy as np
import pytest

from core.foretold import doubt
from tests.core.test_timefit import AMPLITUDE, SHAPE, TIME, W, channels, declared

SEEDS = 40


@pytest.mark.parametrize("noise", [0.02, 0.2], ids=["quiet", "noisy"])
def test_a_held_out_misfit_is_the_noise_and_the_doubt_on_average(noise):
    """Of many recordings of one swing; what they do not differ in, the model knows."""
    clean = np.outer(AMPLITUDE * np.exp(-0.02 * W * TIME) * np.cos(W * TIME), SHAPE)
    over, told = [], []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        values = clean + noise * AMPLITUDE * rng.standard_normal(clean.shape)
        found = declared(channels(values, sigma=noise * AMPLITUDE))
        true = (found.predicted[0] - clean)[~found.law.takes[0].fit] / (noise * AMPLITUDE)
        over.append((true**2).sum())
        told.append(doubt(found))
    assert np.mean(told) == pytest.approx(np.mean(over), rel=0.35)
