"""The preview moves what the mode moves, by the factor, and nothing else."""

from dataclasses import dataclass

import numpy as np
import pytest

from core.data import RingDown
from core.errors import RecordingError
from core.magnify import magnify_mode, mode_motion, spread_weights, warped
from core.track import track
from core.video import open_video, read_frames
from tests.core.clips import POINTS, Swing, film, store

FRAMES = np.arange(30)


@dataclass(frozen=True)
class Sideways(Swing):
    """A fifth of a pixel, twelve frames a period."""

    def at(self, t):
        return np.eye(2), np.array([0.2 * np.sin(2 * np.pi * t / 12), 0])


def test_a_warped_picture_is_tracked_to_where_it_was_warped(tmp_path):
    picture = film(Swing(), [0])[0]
    push = np.array([3.25, -1.5])
    weights = spread_weights(POINTS[:1], picture.shape[::-1])
    pictures = [warped(picture, weights @ (k / 14 * push)[None]) for k in range(15)]
    seen = track(store(tmp_path, pictures), POINTS[:1], capture_fps=30)
    share = weights[round(60 / 8), round(80 / 8)] @ np.ones(1)
    assert np.allclose(seen.values[-1, 0] - POINTS[0], share * push, atol=0.1)


def test_shares_sum_to_nearly_one_at_points_and_to_nothing_far_away():
    weights = spread_weights(np.array([[16.0, 16.0], [48.0, 16.0]]), (320, 320))
    assert 0.85 < weights[2, 2].sum() <= 1
    assert weights[2, 2, 0] > 0.5
    assert weights[38, 38].sum() < 1e-6


def test_the_mode_swings_as_its_pole_says_and_only_after_the_release(tmp_path):
    tracks = track(store(tmp_path, film(Swing(), FRAMES)), POINTS, capture_fps=30)
    amplitude = np.zeros((1, 10), complex)
    amplitude[0, 0], amplitude[0, 1] = 2.0, 1j
    ring = RingDown([3.0], [0.0], amplitude, np.zeros(10), np.ones(10), np.eye(2), t0=0.2)
    motion = mode_motion(tracks, ring, 0)
    t = tracks.time - 0.2
    assert np.allclose(motion[:6], 0)
    assert np.allclose(motion[6:, 0, 0], 2 * np.cos(2 * np.pi * 3 * t[6:]))
    assert np.allclose(motion[6:, 0, 1], -np.sin(2 * np.pi * 3 * t[6:]))
    assert np.allclose(motion[:, 1:], 0)


def test_the_magnified_motion_is_the_factor_times_the_motion(tmp_path):
    clip = store(tmp_path, film(Sideways(), FRAMES))
    tracks = track(clip, POINTS, capture_fps=30)
    amplitude = np.zeros((1, 10), complex)
    amplitude[0, ::2] = -0.2j  # Re(-i exp(i w t)) = sin w t
    ring = RingDown([2.5], [0.0], amplitude, np.zeros(10), np.ones(10), np.eye(2))
    out = tmp_path / "mode.avi"
    factor = magnify_mode(open_video(clip), tracks, ring, out)
    assert factor == pytest.approx(0.02 * 160 / 0.2)
    assert len(list(read_frames(open_video(out)))) == 30
    seen = track(out, POINTS[:1], capture_fps=30)
    grown = np.ptp(seen.values[:, 0, 0]) / np.ptp(tracks.values[:, 0, 0])
    assert 0.8 * factor < grown < 1.05 * factor
    with pytest.raises(RecordingError, match="no such video can be written"):
        magnify_mode(open_video(clip), tracks, ring, tmp_path / "mode.txt")
