"""Clips in the form that phones write them: held upright, ten bits, wandering rate, trimmed."""

import numpy as np
import pytest

from core.errors import RecordingError
from core.track import track
from core.video import open_video, read_frames
from tests.core.clips import Swing
from tests.core.phone_clips import COUNT, FOLDER, RATE, SIZE, TRIMMED, pictures, stamps

INSIDE = np.array([[64.0, 48], [40, 60], [90, 35]])  # px, as the sensor sees them


def upright(points):
    """Pixels of the picture turned a quarter to the left: its right edge becomes the top."""
    return np.stack([points[..., 1], SIZE[0] - 1 - points[..., 0]], -1)


def upside_down(points):
    return np.array(SIZE) - 1 - points


def test_a_clip_held_upright_is_shown_upright_at_its_own_instants():
    frames = list(read_frames(video := open_video(FOLDER / "hevc.mov")))
    assert video.size == frames[0].grey.shape[::-1] == SIZE[::-1]
    assert len(frames) == COUNT
    for frame, picture in zip(frames, pictures(), strict=True):
        assert np.abs(frame.grey.astype(int) - np.rot90(picture)).mean() < 5
    seen = np.array([frame.stamp for frame in frames])
    assert np.abs(np.diff(seen) - np.diff(stamps())).max() < 2e-4


def test_points_of_ten_bit_hevc_at_a_wandering_rate_are_where_and_when_they_were():
    tracks = track(FOLDER / "hevc.mov", upright(INSIDE), capture_fps=RATE)
    assert np.abs(tracks.time - (stamps() - stamps()[0])).max() < 2e-3
    truth = upright(Swing().places(INSIDE, np.arange(COUNT)))
    assert np.sqrt(np.nanmean((tracks.values - truth) ** 2)) < 0.15
    assert any("variable frame rate" in warning for warning in tracks.warnings)


def test_a_trimmed_clip_is_whole_and_starts_where_it_was_cut():
    start = Swing().places(INSIDE, np.arange(TRIMMED, COUNT))
    tracks = track(FOLDER / "h264.mp4", upside_down(start[0]), capture_fps=RATE)
    assert tracks.warnings == ()  # the frames cut away are no damage
    assert len(tracks.time) == COUNT - TRIMMED
    assert np.sqrt(np.nanmean((tracks.values - upside_down(start)) ** 2)) < 0.15


def test_a_codec_that_cannot_be_decoded_is_named_with_what_to_do():
    with pytest.raises(RecordingError, match=r"av1\.mp4: .*codec is AV01.*H\.264") as refusal:
        open_video(FOLDER / "av1.mp4")
    assert "\n" not in str(refusal.value)
