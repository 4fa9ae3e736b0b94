"""The noise floor against planted noise under motion that no linear model describes."""

import numpy as np
import pytest

from core.noise_floor import noise_floor

FORCES = {
    "linear": lambda x, v: 0.0,
    "duffing": lambda x, v: -0.5 * x**3,
    "friction": lambda x, v: -0.03 * np.tanh(v / 0.1),
    "asymmetry": lambda x, v: -0.3 * x**2,
}


def wobble(force, frames, per_period, damping):
    """(frames,) displacement in x'' = -x - 2 z x' + force(x, x'), released from 1."""
    steps = 40
    h = 2 * np.pi / per_period / steps
    x, v, out = 1.0, 0.0, np.empty(frames)
    for i in range(frames):
        out[i] = x
        for _ in range(steps):
            middle_v = v + h / 2 * (force(x, v) - x - 2 * damping * v)
            middle_x = x + h / 2 * v
            x += h * middle_v
            v += h * (force(middle_x, middle_v) - middle_x - 2 * damping * middle_v)
    return out


@pytest.mark.parametrize("kind", FORCES)
@pytest.mark.parametrize(("frames", "channels"), [(120, 3), (250, 12), (600, 36)])
def test_planted_noise_is_found_whatever_moves(kind, frames, channels):
    rng = np.random.default_rng(frames)
    motion = np.outer(wobble(FORCES[kind], frames, 17, 0.03), rng.standard_normal(channels))
    drift = np.outer(np.linspace(0, 1, frames) ** 2, rng.standard_normal(channels))
    for decibel in (20, 35, 50):
        level = np.sqrt(np.mean(motion**2)) * 10 ** (-decibel / 20)
        level = level * rng.uniform(0.6, 1.6, channels)
        y = motion + 0.1 * drift + level * rng.standard_normal(motion.shape)
        ratio = noise_floor(np.arange(frames) / 60, y) / level
        assert abs(np.median(ratio) - 1) < 0.2
        assert np.mean(np.abs(ratio - 1) < 0.2) > 0.8


def test_a_few_missing_frames_leave_the_floor_where_it_is():
    rng = np.random.default_rng(1)
    y = np.outer(wobble(FORCES["linear"], 400, 20, 0.02), np.ones(4))
    y = y + 0.01 * rng.standard_normal(y.shape)
    y[rng.random(y.shape) < 0.1] = np.nan
    assert np.allclose(noise_floor(np.arange(400) / 60, y), 0.01, rtol=0.2)


def test_a_channel_that_stands_still_has_no_noise():
    assert (noise_floor(np.arange(100) / 30, np.ones((100, 2))) < 1e-14).all()


@pytest.mark.parametrize(("missing", "jitter"), [(0.3, 0.0), (0.05, 0.0), (0.0, 0.4)])
def test_gaps_and_uneven_instants_do_not_change_the_level(missing, jitter):
    rng, sigma, found = np.random.default_rng(3), 5e-6, []
    for _ in range(6):
        time = (np.arange(480) + rng.uniform(-jitter, jitter, 480)) / 120
        y = 5e-3 * np.exp(-time) * np.cos(2 * np.pi * 5 * time)
        y += 1e-3 * np.exp(-2 * time) * np.cos(2 * np.pi * 22 * time)
        y += sigma * rng.standard_normal(480)
        y[rng.random(480) < missing] = np.nan
        found.append(noise_floor(time, y[:, None])[0])
    assert 0.92 < np.mean(found) / sigma < 1.08


@pytest.mark.parametrize("written", ["to the microsecond", "with gaps"])
def test_motion_near_half_the_frame_rate_is_no_noise(written):
    rng, sigma = np.random.default_rng(8), 2e-4
    time = np.arange(900) / 60
    y = sum(np.exp(-0.4 * time) * np.cos(2 * np.pi * f * time) for f in (3.1, 16.0, 23.7, 27.9))
    y = y[:, None] * np.array([1.0, 0.4, -0.7]) + sigma * rng.standard_normal((900, 3))
    if written == "with gaps":
        y[[40, 500, 777], 1] = np.nan
    else:
        time = np.round(time, 6)
    assert noise_floor(time, y) == pytest.approx(np.full(3, sigma), rel=0.25)


@pytest.mark.parametrize("jumps", [(130,), (60, 250, 290)])
def test_time_that_jumps_is_no_noise(jumps):
    rng = np.random.default_rng(len(jumps))
    motion = wobble(FORCES["linear"], 420, 17, 0.01)
    kept = np.arange(420)
    for at in jumps:
        kept = np.delete(kept, slice(at, at + 3))
    y = np.outer(motion[kept], rng.uniform(0.5, 1.0, 8))
    y = y + 1e-3 * rng.standard_normal(y.shape)
    found = noise_floor(np.arange(len(y)) / 120, y)
    assert np.median(found) == pytest.approx(1e-3, rel=0.35)


def test_noise_that_falls_as_the_motion_dies_is_not_that_of_its_end():
    rng = np.random.default_rng(7)
    motion = wobble(FORCES["linear"], 420, 17, 0.02)
    falls = np.exp(-np.arange(420) / 120)
    noise = 1e-3 * falls[:, None] * rng.standard_normal((420, 8))
    found = noise_floor(np.arange(420) / 120, motion[:, None] + noise)
    assert (found > 0.6 * np.sqrt(np.mean(noise**2))).all()


def test_a_track_in_whole_steps_that_rests_first_keeps_their_noise():
    motion = np.r_[np.zeros(220), wobble(FORCES["linear"], 200, 17, 0.01)]
    steps = np.round(motion[:, None] * np.linspace(20.0, 40.0, 8))
    assert (noise_floor(np.arange(420) / 120, steps) > 0.05).all()
