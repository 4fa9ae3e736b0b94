"""What rings above all computed modes is waited for, and nothing else is."""

import numpy as np
import pytest

from core.case import read_case
from core.data import RingDown, poles
from core.listen import listen_from
from core.match import select
from core.outlived import FADED, burst, outlived
from core.pipeline import calibrate_case
from tests.core.test_timefit import RATE, channels
from tests.truth import make

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


def left_by(shape, lasting, seed=0):
    """What a fit of a mode at 6 Hz leaves: a motion that dies in `lasting` s, and noise."""
    rng = np.random.default_rng(seed)
    burst = 60 * np.exp(-TIME / lasting) * np.cos(2 * np.pi * 31.0 * TIME)
    return rng.standard_normal((len(TIME), MARKERS)) + np.outer(burst, shape)


@pytest.mark.parametrize("seed", range(3))
def test_only_what_dies_within_part_of_a_swing_and_moves_otherwise_is_brief(seed):
    rng = np.random.default_rng(seed)
    first, other = np.linalg.qr(rng.standard_normal((MARKERS, 2)))[0].T
    period, on = 1 / LOW[0][0], np.arange(MARKERS) < MARKERS - 2
    first, other = np.where(on, first, 0.0), np.where(on, other, 0.0)
    brief, known = left_by(other, 0.02), (first[None], on, period)
    assert burst(brief, TIME, *known) == pytest.approx(0.35 * period)
    assert burst(left_by(first, 0.02), TIME, *known) == 0.0  # a stop on its way
    hidden = left_by(2 * first, 0.02)
    weight = np.sort(first[on] ** 2)
    hidden[:, first**2 > weight[np.cumsum(weight) < 0.25].max()] = np.nan
    assert burst(hidden, TIME, *known) == 0.0  # the same behind a hand
    assert burst(brief, TIME, np.array([first, other]), on, period) == 0.0  # lost frames
    assert burst(left_by(other, 0.2), TIME, *known) == 0.0  # a mode that can be heard
    assert burst(brief, TIME, first[None], on, TIME[-1] / 2) == 0.0  # too little would stay
    assert burst(brief, TIME + period, *known) == 0.0  # it began later
    shaken = brief.copy()
    shaken[:20, ~on] += 9.0
    assert burst(shaken, TIME, *known) == 0.0  # a knock of the table


def test_noise_is_never_taken_for_a_burst():
    first = np.ones((1, MARKERS)) / np.sqrt(MARKERS)
    for seed in range(200):
        noise = left_by(0 * first[0], 0.02, seed)
        assert burst(noise, TIME, first, np.ones(MARKERS, bool), 1 / LOW[0][0]) == 0.0


@pytest.mark.slow
def test_a_release_that_rings_many_fast_modes_at_once_lacks_no_effect(tmp_path):
    """Twenty of them, each too brief to be heard by itself; they once passed for a stop."""
    truth = make("null", 92, tmp_path)
    head, *rows = (tmp_path / "tracks.csv").read_text().splitlines()
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    rate = truth["fps"]
    release = read_case(tmp_path / "case.toml").takes[0].recording.start
    since = np.arange(len(values)) / rate - release
    rng = np.random.default_rng(3)
    for f in np.linspace(0.15, 0.45, 20) * rate:
        shape = rng.standard_normal(values.shape[1]) * 12 * truth["sigma"]
        shape[[not name.startswith("m") for name in head.split(",")]] = 0.0
        ring = np.exp(-60.0 * since) * np.cos(2 * np.pi * f * since + rng.uniform(0, 6.28))
        values += np.outer(np.where(since >= 0, ring, 0.0), shape)
    np.savetxt(tmp_path / "tracks.csv", values, delimiter=",", header=head, comments="")
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
    assert any("were left out" in line for line in report["warnings"])
