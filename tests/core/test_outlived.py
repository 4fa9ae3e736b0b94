"""What rings above all computed modes is waited for, and nothing else is."""

import numpy as np
import pytest

from core.data import RingDown, poles
from core.listen import listen_from
from core.match import select
from core.outlived import FADED, outlived
from tests.core.test_timefit import RATE, channels

TIME = np.arange(5 * RATE) / RATE
LOW = np.array([6.0, 9.0]), np.array([0.02, 0.025])
HIGH = np.array([21.0, 27.0, 33.0, 41.0]), np.array([0.03, 0.04, 0.045, 0.05])
NOISE, TOP, MARKERS = 0.01, 15.0, 12


def ringing(frequency, damping_ratio, shapes, seed=0):
    """The channels and the ring-down of modes let go at the release; the first two are low."""
    pole = poles(frequency, damping_ratio)
    clean = (np.exp(np.outer(TIME, pole)) @ shapes).real
    loud = np.random.default_rng(seed).standard_normal(clean.shape)
    count = len(frequency)
    ring = RingDown(
        frequency,
        damping_ratio,
        shapes.astype(complex),
        np.zeros(MARKERS),
        np.full(MARKERS, NOISE),
        np.eye(2 * count),
    )
    return channels(clean + NOISE * loud, NOISE, TIME), ring


def many(high=4, loss=1.0, along=0.0, seed=0):
    """Two low modes and so many high ones, `along` the first one's shape and damped `loss` fold."""
    rng = np.random.default_rng(seed)
    shapes = rng.standard_normal((2 + high, MARKERS)) * np.r_[1.0, 0.6, np.full(high, 0.4)][:, None]
    shapes[2:] = (1 - along) * shapes[2:] + along * shapes[0]
    frequency = np.r_[LOW[0], HIGH[0][:high]]
    damping_ratio = np.r_[LOW[1], loss * HIGH[1][:high]]
    data, ring = ringing(frequency, damping_ratio, shapes, seed)
    return data, ring, outlived(data, ring, select(ring, (0, 1)), TOP)


@pytest.mark.parametrize("seed", range(4))
def test_high_modes_are_waited_for_until_they_are_noise(seed):
    data, ring, when = many(seed=seed)
    envelope = np.exp(poles(ring.frequency, ring.damping_ratio).real * when)
    left = np.linalg.norm(np.abs(ring.amplitude) * envelope[:, None] / NOISE, axis=1)
    assert left[2:].max() == pytest.approx(FADED, rel=1e-6)
    assert envelope[0] > np.exp(-0.9)
    later, heard = listen_from(data, ring, when)
    assert later.time[0] == pytest.approx(when, abs=1 / RATE)
    for k, f in enumerate(LOW[0]):  # as they were at the release
        at = np.argmin(np.abs(heard.frequency - f))
        assert heard.frequency[at] == pytest.approx(f, rel=0.003)
        off = np.linalg.norm(heard.amplitude[at] - ring.amplitude[k])
        assert off < 0.1 * np.linalg.norm(ring.amplitude[k])
    assert heard.t0 == 0.0
    assert not (heard.frequency > TOP).sum() > 1


@pytest.mark.parametrize(
    ("why", "other"),
    [
        ("a few are fitted", {"high": 2}),
        ("overtones move as the first mode does", {"along": 0.97}),
        ("companions of a force die at once", {"loss": 8.0}),
        ("what is driven lasts", {"loss": 0.02}),
    ],
)
def test_nothing_else_is_waited_for(why, other):
    assert many(**other)[2] == 0.0, why


def test_the_strongest_mode_is_not_let_die():
    """High modes damped as little as may be would last as long as itself."""
    _, ring, when = many(loss=0.35)
    assert when == pytest.approx(0.9 / -poles(*LOW).real[0], rel=1e-6)


def test_a_take_that_is_silent_then_stays_whole():
    data, ring, _ = many()
    assert listen_from(data, ring, TIME[-5]) == (data, ring)
