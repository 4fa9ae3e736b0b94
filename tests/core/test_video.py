"""Clips as they are found on disk: whole, broken, irregular, mislabelled."""

import struct

import cv2
import numpy as np
import pytest

from core.errors import RecordingError
from core.track import track
from core.track_clock import frame_times, rate_warnings
from core.video import frame_at, open_video, read_frames
from core.video_tags import capture_rate_tag
from tests.core.clips import POINTS, SIZE, Swing, film, store

FRAMES = np.arange(40)


@pytest.fixture(scope="module")
def pictures():
    return film(Swing(), FRAMES)


@pytest.mark.parametrize("codec", ["", "mp4v", "MJPG"])
def test_a_clip_gives_all_its_frames_in_order_with_their_stamps(tmp_path, pictures, codec):
    video = open_video(store(tmp_path, pictures, codec, fps=25))
    frames = list(read_frames(video))
    assert [frame.index for frame in frames] == list(range(40))
    assert video.size == SIZE
    assert video.count == 40
    assert video.rate == (None if codec == "" else 25)
    step = 1.0 if codec == "" else 1 / 25
    assert np.allclose(np.diff([frame.stamp for frame in frames]), step, atol=1e-4)
    errors = [np.abs(f.grey.astype(int) - p).mean() for f, p in zip(frames, pictures, strict=True)]
    assert max(errors) < (1e-9 if codec == "" else 6)


def test_a_frame_asked_for_is_that_frame(tmp_path, pictures):
    video = open_video(store(tmp_path, pictures))
    assert (frame_at(video, 17).grey == pictures[17]).all()
    assert [frame.index for frame in read_frames(video, 35)] == [35, 36, 37, 38, 39]
    with pytest.raises(RecordingError, match="frame 40 cannot be read"):
        frame_at(video, 40)


def test_a_reader_that_is_left_early_ends_its_thread(tmp_path, pictures):
    import threading

    before = threading.active_count()
    frames = read_frames(open_video(store(tmp_path, pictures)))
    next(frames)
    frames.close()
    assert threading.active_count() == before


def test_what_is_not_a_clip_is_refused_in_one_line(tmp_path, pictures):
    text = tmp_path / "notes.mp4"
    text.write_text("not a video at all")
    empty = tmp_path / "empty"
    empty.mkdir()
    one = tmp_path / "one"
    one.mkdir()
    cv2.imwrite(str(one / "f_0001.png"), pictures[0])
    short = tmp_path / "short"
    short.mkdir()
    single = store(short, pictures[:1], "MJPG")
    refusals = {
        tmp_path / "absent.mp4": "no such file",
        text: "not a video",
        empty: "no pictures",
        one: "one frame",
        single: "one frame",
        one / "f_0001.png": "one picture, a clip is needed",
    }
    for path, words in refusals.items():
        with pytest.raises(RecordingError, match=words) as refusal:
            open_video(path)
        assert "\n" not in str(refusal.value)
    some = store(tmp_path, pictures[:5])
    with pytest.raises(RecordingError, match="5 frames; 12 are needed"):
        track(some, POINTS, capture_fps=30)


def test_a_clip_cut_off_is_used_as_far_as_it_goes_and_says_so(tmp_path, pictures):
    path = store(tmp_path, pictures, "MJPG")
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * 0.6)])
    tracks = track(path, POINTS, capture_fps=30)
    assert 15 < len(tracks.time) < 30
    error = tracks.values - Swing().places(POINTS, tracks.frames)
    assert np.sqrt(np.nanmean(error**2)) < 0.03
    assert any("could be read; the file is damaged" in warning for warning in tracks.warnings)


def test_of_a_clip_that_is_damaged_in_the_middle_the_whole_part_is_used(tmp_path, pictures):
    path = store(tmp_path, pictures, "MJPG")
    data = bytearray(path.read_bytes())
    at = int(0.6 * len(data))
    noise = np.random.default_rng(0).integers(0, 255, len(data) // 8, np.uint8)
    data[at : at + len(noise)] = noise.tobytes()
    path.write_bytes(data)
    tracks = track(path, POINTS, capture_fps=30)
    assert 15 < len(tracks.time) < 26
    assert np.allclose(tracks.time, FRAMES[: len(tracks.time)] / 30)
    error = tracks.values - Swing().places(POINTS, tracks.frames)
    assert np.sqrt(np.nanmean(error**2)) < 0.03
    assert any(
        "some are missing after frame 22. What comes before" in warning
        for warning in tracks.warnings
    )


def test_a_hole_in_a_clip_is_a_hole_in_time(tmp_path, pictures):
    path = store(tmp_path, pictures)
    for k in (13, 14, 30):
        (path / f"f_{k:04d}.png").unlink()
    tracks = track(path, POINTS, capture_fps=30)
    kept = np.delete(FRAMES, [13, 14, 30])
    assert np.allclose(tracks.time, kept / 30)
    assert np.abs(tracks.values - Swing().places(POINTS, kept)).max() < 0.1
    assert any("3 frames were dropped in 2 places" in warning for warning in tracks.warnings)


def test_pictures_of_two_sizes_are_no_clip(tmp_path, pictures):
    path = store(tmp_path, pictures)
    cv2.imwrite(str(path / "f_0020.png"), pictures[20][:-8])
    with pytest.raises(RecordingError, match="160 x 112 px, the frame before had 160 x 120"):
        track(path, POINTS, capture_fps=30)


def test_stamps_rounded_to_the_containers_tick_are_a_grid():
    exact = np.arange(400) / 240
    for tick in (1e-3, 1 / 600, 1 / 90000):
        clock = frame_times(np.round(exact / tick) * tick, 240.0)
        assert np.allclose(clock.time, exact, atol=1e-12)
        assert clock.warnings == ()


def test_a_rounded_grid_still_shows_dropped_frames():
    exact = np.delete(np.arange(300) / 240, [50, 51, 120])
    clock = frame_times(np.round(exact * 1000) / 1000, 240.0)
    assert np.allclose(clock.time, exact, atol=1e-12)
    assert "3 frames were dropped in 2 places, the first after frame 49" in clock.warnings[0]


def test_a_variable_rate_keeps_its_own_instants():
    rng = np.random.default_rng(4)
    steps = rng.uniform(0.8, 1.2, 200) / 30
    stamps = np.concatenate([[0], np.cumsum(steps)])
    clock = frame_times(stamps, 30.0)
    assert np.allclose(clock.time, stamps)
    assert "variable frame rate" in clock.warnings[0]
    slowed = frame_times(8 * stamps, 30.0)  # played eight times slower than it was filmed
    assert np.allclose(slowed.time, stamps, rtol=0.02, atol=1e-3)


def test_slow_motion_is_timed_by_the_capture_rate_and_its_container_contradicts(tmp_path, pictures):
    path = store(tmp_path, pictures, "mp4v", fps=50)
    tracks = track(path, POINTS, capture_fps=1000)
    assert np.allclose(np.diff(tracks.time), 1e-3)
    assert any("50 frames/s, which contradicts" in warning for warning in tracks.warnings)
    agreed = track(path, POINTS, capture_fps=50)
    assert agreed.warnings == ()


@pytest.mark.parametrize("rate", [0, -30, np.nan, np.inf])
def test_a_capture_rate_that_is_none_is_refused(tmp_path, pictures, rate):
    with pytest.raises(RecordingError, match="capture_fps"):
        track(store(tmp_path, pictures), POINTS, capture_fps=rate)


def test_a_capture_rate_in_the_metadata_is_read_and_compared(tmp_path, pictures):
    path = store(tmp_path, pictures, "mp4v", fps=30)
    assert capture_rate_tag(path) is None
    tagged = tmp_path / "tagged.mp4"
    tagged.write_bytes(with_rate(path.read_bytes(), 240.0))
    assert capture_rate_tag(tagged) == 240
    video = open_video(tagged)
    stamps = FRAMES / 30
    assert rate_warnings(video, 240.0, stamps) == ()  # slow motion, and the file says so itself
    said = rate_warnings(video, 120.0, stamps)
    assert "its metadata say it was captured at 240 frames/s" in said[0]


def with_rate(mp4: bytes, rate: float) -> bytes:
    """`mp4` (moov last) with the key that Android's recorder writes."""

    def atom(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I4s", 8 + len(content), name) + content

    key = b"com.android.capture.fps"
    named = struct.pack(">I4s", 8 + len(key), b"mdta") + key
    keys = atom(b"keys", struct.pack(">II", 0, 1) + named)
    value = atom(b"data", struct.pack(">II", 23, 0) + struct.pack(">f", rate))
    entry = struct.pack(">II", 8 + len(value), 1) + value
    handler = atom(b"hdlr", bytes(8) + b"mdta" + bytes(13))
    meta = atom(b"meta", handler + keys + atom(b"ilst", entry))
    at = mp4.rindex(b"moov") - 4
    size = struct.unpack_from(">I", mp4, at)[0]
    assert at + size == len(mp4)
    return mp4[:at] + struct.pack(">I", size + len(meta)) + mp4[at + 4 :] + meta
