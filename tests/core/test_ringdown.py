"""The release is found where it was planted; intervals of real recordings stand a bootstrap."""

from pathlib import Path

import numpy as np
import pytest

from core.errors import RecordingError
from core.harmonic_inversion import fit_poles, invert
from core.ringdown import find_release
from core.stabilization import stabilization

MEASURED = Path(__file__).parents[3] / "shared" / "measured"
FPS = 60
CLIP = np.arange(8 * FPS) / FPS
OMEGA = 2 * np.pi * 3.0


def let_go(t, release, amplitude=1.0, damping_ratio=0.03):
    """(T,) held at `amplitude`, then ringing at 3 Hz."""
    since = np.maximum(t - release, 0)
    swing = np.cos(OMEGA * since) + damping_ratio * np.sin(OMEGA * since)
    return amplitude * np.exp(-damping_ratio * OMEGA * since) * swing


def struck(t, instant, amplitude=1.0):
    """(T,) at rest, then ringing at 3 Hz."""
    since = np.maximum(t - instant, 0)
    return amplitude * np.exp(-0.03 * OMEGA * since) * np.sin(OMEGA * since)


def pulled(t):
    return np.where(t < 2, np.clip(t - 0.5, 0, 1), let_go(t, 2.0))


def shaky_hand(t):
    hand = 1 + 0.15 * np.sin(2 * np.pi * 0.8 * t) + 0.05 * np.sin(2 * np.pi * 2.3 * t)
    return np.where(t < 2, hand, let_go(t, 2.0))


def with_brief_modes(t):
    since = np.maximum(t - 2, 0)
    brief = sum(
        a * np.exp(-0.05 * 2 * np.pi * f * since) * np.sin(2 * np.pi * f * since)
        for a, f in ((0.3, 9.0), (0.15, 17.0))
    )
    return let_go(t, 2.0) + brief


RELEASES = {
    "held": (lambda t: let_go(t, 2.0), 2.0),
    "pulled": (pulled, 2.0),
    "shaky hand": (shaky_hand, 2.0),
    "with brief modes": (with_brief_modes, 2.0),
    "struck": (lambda t: struck(t, 1.5), 1.5),
    "ringing from the first frame": (lambda t: let_go(t, 0.0), 0.0),
    "struck again": (lambda t: let_go(t, 1.0) + struck(t, 5.0, 0.5), 1.0),
}


@pytest.mark.parametrize("how", RELEASES)
@pytest.mark.parametrize(("decibel", "frames"), [(20, 3), (45, 1)])
def test_the_release_is_found_to_a_frame_or_what_noise_hides(how, decibel, frames):
    motion, release = RELEASES[how]
    for seed in range(3):
        rng = np.random.default_rng(seed)
        y = np.outer(motion(CLIP), rng.standard_normal(4))
        y += np.sqrt(np.mean(y**2)) * 10 ** (-decibel / 20) * rng.standard_normal(y.shape)
        start, _ = find_release(CLIP, y)
        assert abs(start - release) * FPS < frames + 0.01


def test_a_quiet_camera_finds_the_release_to_the_frame_however_slowly_it_swings():
    """A few held frames at the top of a slow swing are off by less than brief modes may be."""
    time = np.arange(300) / (27 * 3.0)  # 27 frames a swing
    for seed in range(12):
        y = np.outer(let_go(time, time[36], damping_ratio=0.05), [1.0, 0.7, 0.5, 0.3, -0.2])
        noise = np.random.default_rng(seed).standard_normal(y.shape)
        start, _ = find_release(time, y + 0.003 * np.sqrt(np.mean(y**2)) * noise)
        assert np.searchsorted(time, start - 1e-9) == 36


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_what_is_held_still_is_not_free_however_little_of_it_is_at_one_pitch(seed):
    """Two modes whose pitches fall by two fifths: no sinusoids tell what comes before, and the
    first two swings may be given up for that.
    """
    since = np.maximum(CLIP - 1.0, 0)
    phase = OMEGA * (since - 0.4 * since**2 / (2 * since[-1]))
    rng = np.random.default_rng(seed)
    y = np.zeros((len(CLIP), 4))
    for ratio, size in ((1.0, 1.0), (2.4, 0.4)):
        swing = size * np.exp(-0.006 * ratio * OMEGA * since) * np.cos(ratio * phase)
        y += np.outer(swing, rng.standard_normal(4))
    y += 0.03 * np.sqrt(np.mean(y**2)) * rng.standard_normal(y.shape)
    start, _ = find_release(CLIP, y)
    assert -1.01 < (start - 1.0) * FPS < 2 * FPS / 3


@pytest.mark.parametrize(
    ("decibel", "damping_ratio", "beside", "turned"),
    [(20, 0.002, 0.9, 0.6), (30, 0.002, 0.9, 0.6), (6, 0.0005, 0.0, 0.0), (8, 0.0005, 0.0, 0.0)],
)
def test_what_beats_or_turns_round_is_not_held(decibel, damping_ratio, beside, turned):
    """In all channels alike, from the first frame on: two near pitches, and a swing in much noise
    whose turning points are quiet.
    """
    swing = np.cos(OMEGA * CLIP) + beside * np.cos(1.1 * OMEGA * CLIP + np.pi * turned)
    y = np.outer(np.exp(-damping_ratio * OMEGA * CLIP) * swing, np.ones(4))
    for seed in range(2):
        noise = np.random.default_rng(seed).standard_normal(y.shape)
        y_seen = y + np.sqrt(np.mean(y**2)) * 10 ** (-decibel / 20) * noise
        start, _ = find_release(CLIP, y_seen)
        assert start * FPS < 1.01


@pytest.mark.parametrize("swings", [2.6, 3.2, 3.8, 4.4, 5.5, 8.0])
def test_a_struck_object_was_still_however_few_of_its_swings_were_filmed(swings):
    """So few hardly die away, as what is driven does not; and their energy is uneven."""
    pitches, fps = np.array([1.5516, 4.037, 12.1]), 240
    shapes = np.array([[1.0, 0.7, 0.4, 0.2], [0.1, -0.2, 0.1, 0.3], [-0.3, 0.1, 0.3, 0.2]])
    time = np.arange(int((0.41 + swings / pitches[0]) * fps)) / fps
    after = np.maximum(time - 0.41, 0)[:, None]
    waves = np.exp(-0.04 * pitches * after) * np.sin(2 * np.pi * pitches * after)
    y = waves @ shapes
    for seed in range(4):
        noise = np.random.default_rng(seed).standard_normal(y.shape)
        start, _ = find_release(time, y + 0.004 * noise)
        assert abs(start - 0.41) * fps < 4


def test_a_second_blow_ends_the_ring_down():
    rng = np.random.default_rng(0)
    y = (let_go(CLIP, 1.0) + struck(CLIP, 5.0, 0.5))[:, None] + 0.003 * rng.standard_normal(
        (480, 3)
    )
    _, stop = find_release(CLIP, y)
    assert 4.0 < stop < 5.0


def test_what_beats_with_a_drive_is_not_struck_again():
    """At twice its pitch, the drive makes the energy of a period rise and fall from half swing to
    half swing, fourfold, while the free motion dies.
    """
    t = np.arange(4 * FPS) / FPS
    free = np.exp(-0.7 * t) * np.sin(2 * np.pi * 5.0 * t)
    driven = 0.35 * np.sin(2 * np.pi * 10.05 * t)
    y = (free + driven)[:, None] + 0.005 * np.random.default_rng(1).standard_normal((len(t), 3))
    _, stop = find_release(t, y)
    assert stop > 3.5


def test_a_tail_of_noise_is_cut_off():
    rng = np.random.default_rng(0)
    y = let_go(CLIP, 1.0, damping_ratio=0.1)[:, None] + 0.01 * rng.standard_normal((480, 3))
    _, stop = find_release(CLIP, y)
    sunk = 1.0 + np.log(100) / (0.1 * OMEGA)  # where the amplitude is that of the noise
    assert sunk < stop < 6.0


def test_a_jump_of_a_tracker_is_not_a_release():
    rng = np.random.default_rng(1)
    y = np.outer(let_go(CLIP, 2.0), [1.0, 0.7, -0.4]) + 0.01 * rng.standard_normal((480, 3))
    y[30, 0] += 40.0
    start, _ = find_release(CLIP, y)
    assert abs(start - 2.0) * FPS < 2


def test_a_record_at_rest_has_no_release():
    with pytest.raises(RecordingError, match="nothing moves"):
        find_release(CLIP, np.random.default_rng(0).standard_normal((480, 4)))


def test_true_poles_stay_and_noise_wanders_in_a_stabilization_diagram():
    rng = np.random.default_rng(0)
    y = np.outer(let_go(CLIP, 0.0), [1.0, 0.5]) + 0.01 * rng.standard_normal((480, 2))
    found = stabilization(CLIP, y, most=30)
    near = np.abs(found.frequency - 3.0) < 0.02
    assert np.mean(found.stable[near & (found.order > 4)]) > 0.8
    assert set(found.order[near]) >= set(range(4, 31, 2))
    assert np.mean(found.stable[~near]) < 0.5


def real_take(name, start, stop):
    folder = MEASURED / name
    if not folder.exists():
        pytest.skip(f"the measured recordings are not beside the project ({folder.name})")
    rows = np.genfromtxt(folder / "tracks.csv", delimiter=",", skip_header=1)
    inside = (rows[:, 0] >= start) & (rows[:, 0] <= stop)
    return rows[inside, 0], rows[inside, 1:10]  # three markers on the tip


def test_a_real_beam_rings_where_simple_fits_saw_it():
    found = invert(*real_take("silicone_beam_gravity_a", 0.76, 3.36))
    assert abs(found.frequency[0] - 7.74) < 0.05
    assert abs(found.damping_ratio[0] - 0.05) < 0.01


def test_the_release_of_a_real_beam_is_when_its_support_left():
    start, stop = find_release(*real_take("silicone_beam_gravity_a", 0.0, 9.0))
    assert 0.70 <= start <= 0.80
    assert stop > 3.0


@pytest.mark.parametrize(
    ("name", "start", "stop", "pitch"),
    [("silicone_beam_gravity_a", 0.76, 3.36, 7.74), ("silicone_beam_load52_a", 0.49, 3.09, 4.35)],
)
def test_a_bootstrap_by_whole_periods_confirms_the_interval(name, start, stop, pitch):
    time, y = real_take(name, start, stop)
    slow = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, len(time)), 3)[:, 1:]

    def fitted(signals):
        return fit_poles(time, signals, [pitch], [0.05], extra_basis=slow)

    found = fitted(y)
    columns = np.column_stack([np.ones(len(time)), slow, *phases(time, found)])
    residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    period = round(1 / found.frequency[0] / np.median(np.diff(time)))
    again = []
    for seed in range(60):
        signs = np.random.default_rng(seed).choice([-1, 1], len(time) // period + 1)
        flipped = residual * np.repeat(signs, period)[: len(time), None]
        drawn = fitted(y - residual + flipped)
        again.append([drawn.frequency[0], drawn.damping_ratio[0]])
    ratio = np.std(again, axis=0) / [found.frequency_sigma[0], found.damping_sigma[0]]
    assert ((ratio > 0.4) & (ratio < 1.4)).all()


def phases(time, found):
    """Real and imaginary part of the mode over time."""
    z = found.damping_ratio[0]
    w = 2 * np.pi * found.frequency[0]
    swing = np.exp((-z + 1j * np.sqrt(1 - z**2)) * w * (time - time[0]))
    return swing.real, swing.imag


def test_a_driven_record_is_taken_whole():
    t = np.arange(4 * FPS) / FPS
    driven = 0.5 * np.sin(2 * np.pi * 5.0 * t + 0.4)
    noise = 0.01 * np.random.default_rng(1).standard_normal((len(t), 3))
    y = np.outer(let_go(t, 0.0, 0.5), [1.0, 0.6, 0.3]) + np.outer(driven, [1.0, 0.5, 0.4])
    first, last = find_release(t, y + noise)
    assert first < 0.3 and last > 3.5
