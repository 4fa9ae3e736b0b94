"""Points' share in the modes with honest intervals, shaking cameras, rolling shutters, folds."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from core.command import main
from core.data import poles
from core.deflection import polar
from core.ringdown_command import ringdown_command, ringdown_json
from core.track import Tracks
from core.video import Video
from core.video_modes import modes_of
from tests.core.clips import SIZE, Texture, store

FPS = 100.0
CLIP = Video(Path("made.mp4"), (640, 480), None, 300)
F, Z = np.array([6.0, 14.5]), np.array([0.012, 0.02])
POLES = poles(F, Z)
PLACES = np.array([[100.0, 60], [220, 130], [300, 400], [500, 240]])


def amplitudes(seed=5):
    """(2, 8) complex px: two modes at four points, u and v."""
    rng = np.random.default_rng(seed)
    real, imaginary = rng.uniform(-4, 4, (2, 2, 8))
    return real + 1j * imaginary


def planted(amplitude, noise, *, seed, readout=0.0, frames=300):
    time = np.arange(frames) / FPS
    rest = PLACES.ravel()
    late = readout * np.repeat(PLACES[:, 1], 2) / CLIP.size[1]
    swing = np.exp(POLES[:, None, None] * (time[:, None] + late))
    values = rest + np.einsum("mc,mtc->tc", amplitude, swing).real
    values = values + noise * np.random.default_rng(seed).standard_normal(values.shape)
    sigma = np.full((frames, len(PLACES)), noise)
    return Tracks(time, values.reshape(frames, -1, 2), sigma, PLACES, np.arange(frames))


def test_intervals_of_the_deflection_hold_the_truth_in_95_of_100_cases():
    truth, inside, pulls = amplitudes(), [], []
    for seed in range(60):
        modes = modes_of(planted(truth, 0.3, seed=seed), CLIP, FPS)
        order = np.argmin(np.abs(modes.ringdown.frequency - F[:, None]), axis=1)
        for k, at in enumerate(order):
            for c in range(8):
                found, spread = modes.ringdown.amplitude[at, c], modes.covariance[at, c]
                off = found - truth[k, c] * np.exp(POLES[k] * modes.ringdown.t0)
                off = np.array([off.real, off.imag])
                pulls.append(off @ np.linalg.solve(spread, off) / 2)
        (row,) = [
            r for r in ringdown_json(modes)["modes"] if r["natural_frequency_hz"]["value"] < 9
        ]
        for point, told in enumerate(row["deflection"]):
            for axis, name in enumerate("uv"):
                true = truth[0, 2 * point + axis] * np.exp(POLES[0] * modes.ringdown.t0)
                low, high = told[name]["amplitude_px"]["ci95"]
                inside.append(low < abs(true) < high)
                middle, (low, high) = (told[name]["phase_rad"][n] for n in ("value", "ci95"))
                inside.append(abs(np.angle(true / np.exp(1j * middle))) < (high - low) / 2)
    assert 0.9 < np.mean(pulls) < 1.15
    assert 0.93 < np.mean(inside) < 0.975


def test_a_phase_that_noise_hides_may_be_any():
    amplitude, phase = polar(0.1 + 0.05j, 0.04 * np.eye(2))
    assert amplitude[1] == 0 and amplitude[2] > 0.4
    assert phase[1:] == (-np.pi, np.pi)
    amplitude, phase = polar(-3 + 0.02j, np.diag([0.01, 0.04]))
    assert amplitude[2] - amplitude[0] == pytest.approx(1.96 * 0.1, rel=1e-3)
    assert phase[2] - phase[0] == pytest.approx(1.96 * 0.2 / 3, rel=1e-3)


def test_a_known_readout_brings_all_rows_to_one_instant():
    truth = amplitudes()
    rolled = planted(truth, 0.01, seed=1, readout=0.008)
    for readout, close in ((0.0, False), (0.008, True)):
        modes = modes_of(rolled, CLIP, FPS, readout=readout)
        order = np.argmin(np.abs(modes.ringdown.frequency - F[:, None]), axis=1)
        wanted = truth * np.exp(POLES * modes.ringdown.t0)[:, None]
        error = np.abs(modes.ringdown.amplitude[order] - wanted).max()
        assert (error < 0.03) == close
        assert close or error > 0.5


@dataclass(frozen=True)
class Shaken:
    """A texture whose right half swings on a left half that stands still, before a shaky camera."""

    turn: float = 0.0  # rad
    zoom: float = 0.0

    def camera(self, k):
        """Similarity (a, b) of complex pixels about the picture's centre, at frame k."""
        a = np.exp(1j * self.turn * np.sin(0.11 * k)) * (1 + self.zoom * np.sin(0.07 * k))
        return a, 3 * np.sin(0.17 * k) + 2.5j * np.sin(0.23 * k) + 1.5 * np.sin(0.031 * k)

    def swing(self, k):
        return (2.0 + 1.0j) * np.exp(-0.008 * k) * np.sin(0.4 * k)

    def picture(self, k, rng):
        a, b = self.camera(k)
        y, x = np.mgrid[: SIZE[1], : SIZE[0]].astype(float)
        middle = complex(*SIZE) / 2
        place = (x + 1j * y - middle - b) / a + middle
        moved = place - self.swing(k)
        left, right = Texture(seed=1), Texture(seed=2)
        grey = np.where(
            place.real < SIZE[0] / 2, left(place.real, place.imag), right(moved.real, moved.imag)
        )
        return np.clip(np.round(grey + rng.standard_normal(grey.shape)), 0, 255).astype(np.uint8)


STATIC = [[25, 25], [55, 95], [25, 92], [57, 30]]


@pytest.mark.parametrize(("shaken", "count"), [(Shaken(), 1), (Shaken(0.01, 0.006), 4)])
def test_static_points_take_the_cameras_shake_out_of_a_clip(tmp_path, capsys, shaken, count):
    rng = np.random.default_rng(0)
    path = store(tmp_path, [shaken.picture(k, rng) for k in range(170)])
    line = ["ringdown", str(path), "--capture-fps", "60", "--point", "120,35", "--point", "118,85"]
    fixed = [part for u, v in STATIC[:count] for part in ("--static", f"{u},{v}")]
    out = tmp_path / "ringdown.json"
    assert main([*line, *fixed, "--out", str(out)]) == 0
    assert "pitch, Hz" in capsys.readouterr().out
    report = ringdown_command(path, 60.0, [[120, 35], [118, 85]], static=STATIC[:count])
    natural = np.hypot(0.4, 0.008) * 60 / (2 * np.pi)
    (mode,) = report["modes"]
    assert mode["natural_frequency_hz"]["value"] == pytest.approx(natural, rel=2e-3)
    assert mode["damping_ratio"]["value"] == pytest.approx(0.008 / 0.4, rel=0.1)
    assert mode["amplitude_px"] == pytest.approx(np.hypot(2, 1), rel=0.03)
    assert len(mode["deflection"]) == 2
    shaky = ringdown_command(path, 60.0, [[120, 35], [118, 85]])["modes"]
    assert len(shaky) > 1 or shaky[0]["natural_frequency_hz"]["value"] < 0.9 * natural


def test_points_are_picked_where_something_moves_beside_the_static_ones(tmp_path):
    rng = np.random.default_rng(0)
    path = store(tmp_path, [Shaken().picture(k, rng) for k in range(120)])
    report = ringdown_command(path, 60.0, static=STATIC[:1])
    at = [one["pixel"][0] for one in report["modes"][0]["deflection"]]
    assert len(at) > 4 and min(at) > SIZE[0] / 2 - 20  # a window reaches 15 px


def test_tones_and_overtones_are_named_and_are_no_modes():
    truth = 20 * amplitudes()
    tracks = planted(truth, 0.05, seed=3, frames=500)
    time = tracks.time[:, None, None]
    hum = np.array([0.4, -0.3]) * np.sin(2 * np.pi * 21.3 * time)
    over = 0.8 * (np.exp(3 * POLES[0] * time) * 1j).real
    both = Tracks(time[:, 0, 0], tracks.values + hum + over, tracks.sigma, PLACES, tracks.frames)
    modes = modes_of(both, CLIP, FPS)
    assert np.allclose(np.sort(modes.ringdown.frequency), F, rtol=1e-3)
    (told,) = [w for w in modes.warnings if "no mode of a free swing" in w]
    assert "21.3 Hz is not seen to decay" in told
    assert "18 Hz is an overtone" in told
    assert len(modes_of(tracks, CLIP, FPS).warnings) == 0
