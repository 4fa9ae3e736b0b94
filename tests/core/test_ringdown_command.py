"""The modes of a clip alone: planted ones, measured ones, and what a clip cannot say."""

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from core.aliases import aliases
from core.errors import RecordingError
from core.ringdown_command import ringdown_command
from core.video import open_video, read_frames
from tests.core.clips import POINTS, Swing, film, store

FORKS = Path(__file__).resolve().parents[3] / "shared" / "measured" / "tuning_fork"
FPS = 120.0
OMEGA, DECAY = 0.25, 0.01  # a frame
PULL = np.array([4.0, 2.0])  # px


@dataclass(frozen=True)
class OneMode(Swing):
    """A shift that swings at `OMEGA` and dies at `DECAY`."""

    def at(self, t):
        return np.eye(2), PULL * np.exp(-DECAY * t) * np.sin(OMEGA * t)


def ringing(tmp_path, frames, noise) -> Path:
    return store(tmp_path, film(OneMode(), range(frames), noise=noise))


def test_a_planted_mode_is_found_within_its_interval(tmp_path):
    path = ringing(tmp_path, 160, noise=2)
    report = ringdown_command(path, FPS, POINTS, out=tmp_path / "ringdown.json")
    mode = report["modes"][0]
    written = json.loads((tmp_path / "ringdown.json").read_text())["modes"][0]
    assert written["amplitude_px"] == pytest.approx(mode["amplitude_px"])
    natural = np.hypot(OMEGA, DECAY) * FPS
    for name, truth in (
        ("natural_frequency_hz", natural / (2 * np.pi)),
        ("damping_ratio", DECAY * FPS / natural),
    ):
        low, high = mode[name]["ci95"]
        assert low < high < low + 0.05 * truth
        half = (high - low) / 2
        assert abs(mode[name]["value"] - truth) < 2 * half
    assert mode["amplitude_px"] == pytest.approx(np.hypot(*PULL), rel=0.05)
    assert mode["aliases_hz"] == []
    assert len(report["modes"]) == 1


def test_points_need_not_be_given_and_the_preview_shows_more_motion(tmp_path):
    path = ringing(tmp_path, 90, noise=1)
    out = tmp_path / "mode.avi"
    picture = tmp_path / "ringdown.png"
    report = ringdown_command(path, FPS, magnify=out, plot=picture)
    assert report["modes"][0]["natural_frequency_hz"]["value"] == pytest.approx(
        np.hypot(OMEGA, DECAY) * FPS / (2 * np.pi), rel=0.01
    )
    assert picture.stat().st_size > 20_000
    assert cv2.imread(str(picture)).std() > 10
    frames = list(read_frames(open_video(out)))
    assert len(frames) == 90


def test_what_is_seen_near_half_the_rate_may_be_a_fold():
    assert aliases(122.0, 0.0, 250.0)[0] == pytest.approx(128.0)
    assert aliases(30.0, 0.0, 1000.0) == []
    slow, fork = 0.1, 128.0  # a fork at 127.9 frames/s looks like a body that hardly swings
    ratio = 4e-4 * fork / np.hypot(slow, 4e-4 * fork)
    assert fork == pytest.approx(aliases(np.hypot(slow, 4e-4 * fork), ratio, fork - slow)[1])
    assert aliases(30.0, 0.0, 1000.0, doubted=True)[:2] == pytest.approx([970, 1030])
    decay = 5.0  # Hz: the envelope is sampled as it is, only the oscillation folds
    seen, true = np.hypot(100, decay), np.hypot(150, decay)
    assert true == pytest.approx(aliases(seen, decay / seen, 250.0)[0])


def test_a_file_that_plays_faster_than_declared_makes_every_pitch_doubtful(tmp_path):
    path = store(tmp_path, film(OneMode(), range(160), noise=2), "MJPG", fps=120)
    (mode,) = ringdown_command(path, FPS / 2, POINTS)["modes"]
    natural = np.hypot(OMEGA, DECAY) * FPS / 2
    assert mode["aliases_hz"][0] == pytest.approx(FPS / 2 - natural / (2 * np.pi), rel=0.01)
    assert ringdown_command(path, FPS, POINTS)["modes"][0]["aliases_hz"] == []


def test_a_still_clip_and_a_clip_of_one_period_are_refused(tmp_path):
    still = tmp_path / "still"
    still.mkdir()
    path = store(still, film(Swing(shift=0, turn=0, stretch=0), np.arange(40), noise=1))
    with pytest.raises(RecordingError, match="no motion"):
        ringdown_command(path, FPS, POINTS)
    with pytest.raises(RecordingError, match="no motion"):
        ringdown_command(path, FPS)
    short = tmp_path / "short"
    short.mkdir()
    path = store(short, film(Swing(rate=0.1, turn=0, stretch=0), np.arange(50)))
    with pytest.raises(RecordingError, match=r"period|vibration|noise"):
        ringdown_command(path, FPS, POINTS)


@pytest.mark.skipif(not FORKS.is_dir(), reason="../shared/measured/tuning_fork is not there")
@pytest.mark.parametrize(
    ("pitch", "fps"),
    [
        (128, 250),
        pytest.param(64, 500, marks=pytest.mark.slow),
        pytest.param(32, 1000, marks=pytest.mark.slow),
    ],
)
def test_a_filmed_tuning_fork_has_its_pitch(pitch, fps):
    path = FORKS / f"tuning_hz{pitch}_fps{fps}_50-1_640x420.mp4"
    check_fork(ringdown_command(path, fps), pitch, fps)


def check_fork(report, pitch, fps):
    mode = report["modes"][0]
    seen = mode["natural_frequency_hz"]["value"]
    if pitch < fps / 2:
        assert seen == pytest.approx(pitch, rel=1e-3)
    else:
        assert seen == pytest.approx(fps - pitch, rel=1e-3)
        assert mode["aliases_hz"][0] == pytest.approx(pitch, rel=1e-3)
    assert any("container says 50 frames/s, which contradicts" in w for w in report["warnings"])
    assert 0 < mode["damping_ratio"]["value"] < 0.01
