"""Jumps of a tracker for one frame are left out, and nothing else; rounding counts as noise."""

import numpy as np
import pytest

from core.glitches import without_glitches
from core.noise_floor import rounding_noise

RATE = 120.0


def _swing(seed: int, frames: int = 360, noise: float = 5e-5):
    """Instants (T,) and two modes' ring-down (T, 4, 3) m in white noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / RATE
    one = np.exp(-1.0 * t) * np.cos(2 * np.pi * 5 * t)
    two = np.exp(-2.5 * t) * np.sin(2 * np.pi * 11 * t)
    values = 8e-3 * one[:, None, None] * rng.normal(size=(4, 3))
    values = values + 3e-3 * two[:, None, None] * rng.normal(size=(4, 3))
    return t, values + rng.normal(0, noise, values.shape), rng


@pytest.mark.parametrize("seed", range(3))
def test_samples_thrown_out_of_place_are_found(seed):
    t, values, rng = _swing(seed)
    frames = rng.choice(np.arange(120, 355, 9), 12, replace=False)
    markers = rng.integers(0, 4, 12)
    values[frames, markers] += 2e-2 * np.sign(rng.normal(size=(12, 3)))
    out, count = without_glitches(t, values)
    gone = np.isnan(out).any(axis=2)
    assert gone[frames, markers].all() and gone.sum() == count.sum() == 12
    assert (out[~gone] == values[~gone]).all()


def test_noise_alone_is_no_jump():
    lost = sum(without_glitches(*_swing(seed)[:2])[1].sum() for seed in range(10))
    assert lost == 0


def test_gaps_and_uneven_instants_are_no_jumps():
    rng = np.random.default_rng(3)
    t = (np.arange(360) + rng.uniform(-0.3, 0.3, 360)) / RATE
    wave = np.exp(-t) * np.cos(2 * np.pi * 12 * t)
    values = 8e-3 * wave[:, None, None] * rng.normal(size=(2, 3))
    values += rng.normal(0, 1e-6, values.shape)
    values[rng.integers(0, 340, 8)[:, None] + np.arange(12), 1] = np.nan
    assert without_glitches(t, values)[1].sum() == 0


def test_a_brief_knock_is_no_jump():
    t, values, _ = _swing(6, noise=1e-4)
    values[:, 0, 0] = 1e-4 * np.random.default_rng(2).normal(size=len(t))
    for width, frame in ((1.5, 60.3), (2.0, 130.1), (2.0, 200.4), (2.5, 280.2)):
        values[:, 0, 0] += 0.05 * np.exp(-(((np.arange(len(t)) - frame) / width) ** 2))
    assert without_glitches(t, values)[1].sum() == 0


def test_a_stop_is_no_jump():
    t = np.arange(600) / RATE
    bounced = np.abs(np.cos(2 * np.pi * 3.1 * t)) * np.exp(-0.5 * t) * 5e-3
    bounced += np.random.default_rng(1).normal(0, 1e-6, len(t))
    assert without_glitches(t, bounced[:, None, None])[1].sum() == 0


def test_frames_shown_twice_or_lost_are_no_jumps():
    t, values, _ = _swing(4, noise=1e-6)
    values[100] = values[99]
    values[201:] = np.roll(values, -3, axis=0)[201:]
    assert without_glitches(t[:350], values[:350])[1].sum() == 0


def test_rounding_is_no_jump_and_makes_noise():
    t, values, _ = _swing(5, noise=2e-5)
    step = 1e-3
    rounded = step * np.rint(values / step)
    assert without_glitches(t, rounded)[1].sum() == 0
    off = (rounded - values).reshape(len(t), -1)[:120].std(axis=0)
    told = rounding_noise(rounded.reshape(len(t), -1))
    assert np.allclose(told, step / np.sqrt(12))
    assert np.abs(off.mean() / told.mean() - 1) < 0.15
    assert not rounding_noise(values.reshape(len(t), -1)).any()
    still = np.r_[np.full(299, 0.2), 0.25, np.full(60, 0.2)]  # knocked once, not rounded
    assert not rounding_noise(still[:, None]).any()
