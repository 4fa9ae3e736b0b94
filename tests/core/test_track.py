"""Tracks against places that are known exactly."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from core.errors import Cancelled, RecordingError
from core.track import track
from core.track_copies import doubled_frames
from core.track_points import pick_points
from core.track_steady import relative_to
from tests.core.clips import POINTS, SIZE, Swing, Texture, film, store

FRAMES = np.arange(50)


def errors(tmp_path, codec="", swing=None, **filming):
    swing = swing or Swing()
    tracks = track(store(tmp_path, film(swing, FRAMES, **filming), codec), POINTS, capture_fps=30)
    return tracks, tracks.values - swing.places(POINTS, FRAMES)


def rms(error):
    return float(np.sqrt(np.nanmean(error**2)))


def test_without_noise_a_turning_stretching_texture_is_followed_to_a_hundredth_of_a_pixel(tmp_path):
    tracks, error = errors(tmp_path)
    assert np.isfinite(error).all()
    assert rms(error) < 0.01
    assert not tracks.warnings


def test_a_turn_of_a_radian_is_followed(tmp_path):
    tracks, error = errors(tmp_path, swing=Swing(rate=0.25, turn=1.0), noise=1)
    assert np.isfinite(error).all()
    assert rms(error) < 0.02


def test_a_rolling_shutter_shows_every_point_at_the_instant_of_its_row(tmp_path):
    swing, readout = Swing(turn=0, stretch=0), 0.8  # frames, first to last row
    rows = np.arange(SIZE[1])
    pictures = [rolled(swing, k + readout * rows / SIZE[1]) for k in FRAMES]
    tracks = track(store(tmp_path, pictures), POINTS, capture_fps=30)
    late = readout * tracks.values[..., 1] / SIZE[1]  # what a prediction with `readout` does
    truth = np.empty_like(tracks.values)
    for k, frame in enumerate(FRAMES):
        for n, point in enumerate(POINTS):
            start = swing.at(readout * point[1] / SIZE[1])[1]  # where the first frame saw it
            truth[k, n] = point + swing.at(frame + late[k, n])[1] - start
    assert rms(tracks.values - truth) < 0.03
    assert rms(tracks.values - swing.places(POINTS, FRAMES)) > 0.5


def rolled(swing, times):
    """A picture (height, width) each of whose rows was taken at its own instant."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]].astype(float)
    push = np.array([swing.at(t)[1] for t in times])
    grey = Texture()(x - push[:, :1], y - push[:, 1:])
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


def test_points_between_pixels_are_where_they_were_said_to_be(tmp_path):
    still = Swing(shift=0, turn=0, stretch=0)
    pictures = film(still, FRAMES[:15])
    tracks = track(store(tmp_path, pictures), POINTS, capture_fps=30)
    assert np.abs(tracks.values - POINTS).max() < 1e-6


@pytest.mark.parametrize("turned", [0, 1, 2, 3])
def test_a_picture_turned_by_quarters_gives_the_turned_tracks(tmp_path, turned):
    pictures = film(Swing(), FRAMES[:20], noise=1)
    width, height = SIZE
    inside = POINTS - (np.array([width, height]) - 1) / 2
    turn = np.linalg.matrix_power(np.array([[0, 1], [-1, 0]]), turned)  # np.rot90 with v down
    size = (width, height) if turned % 2 == 0 else (height, width)
    points = inside @ turn.T + (np.array(size) - 1) / 2
    plain = track(store(tmp_path, pictures), POINTS, capture_fps=30)
    path = tmp_path / "turned"
    path.mkdir()
    seen = track(store(path, [np.rot90(p, turned) for p in pictures]), points, capture_fps=30)
    back = (seen.values - (np.array(size) - 1) / 2) @ turn + (np.array([width, height]) - 1) / 2
    assert np.abs(back - plain.values).max() < 0.02


def test_twice_the_noise_is_twice_the_error_and_sigma_says_so(tmp_path):
    scatter, said = [], []
    for noise in (2.0, 4.0):
        folder = tmp_path / str(noise)
        folder.mkdir()
        tracks, error = errors(folder, noise=noise)
        error = error[1:] - error[1:].mean(axis=0)  # the template's own noise is a constant
        scatter.append(rms(error))
        said.append(rms(tracks.sigma))
        pulls = error / tracks.sigma[1:, :, None]
        assert 0.8 < pulls.std() < 1.25
    assert 1.7 < scatter[1] / scatter[0] < 2.3
    assert 1.7 < said[1] / said[0] < 2.3
    assert max(scatter) < 0.03


@pytest.mark.parametrize("codec", ["mp4v", "MJPG"])
def test_compression_costs_precision_and_sigma_says_so(tmp_path, codec):
    tracks, error = errors(tmp_path, codec)
    plain = tmp_path / "plain"
    plain.mkdir()
    _, exact = errors(plain)
    error = error[1:] - error[1:].mean(axis=0)
    assert rms(exact) < rms(error) < 0.03
    assert 0.7 < (error / tracks.sigma[1:, :, None]).std() < 1.4


def test_blur_costs_precision(tmp_path):
    folders = [tmp_path / name for name in ("sharp", "blurred")]
    for folder in folders:
        folder.mkdir()
    sharp = rms(errors(folders[0], noise=2)[1])
    blurred = rms(errors(folders[1], noise=2, blur=1.5)[1])
    assert 1.2 * sharp < blurred < 0.05


def test_a_covered_point_is_lost_and_found_again_where_it_is(tmp_path):
    swing = Swing()
    pictures = film(swing, FRAMES, noise=1)
    for k in range(20, 32):
        pictures[k][20:62, 28:72] = 90  # over the second point
    tracks = track(store(tmp_path, pictures), POINTS, capture_fps=30)
    error = tracks.values - swing.places(POINTS, FRAMES)
    assert np.isnan(tracks.values[22:32, 1, 0]).all()
    assert np.isfinite(tracks.values[37:, 1]).all()
    assert np.isnan(tracks.sigma[25, 1])
    assert np.nanmax(np.abs(error[:, 1])) < 0.3
    assert np.isfinite(tracks.values[:, 2]).all()
    assert any("point 2 was lost" in warning for warning in tracks.warnings)


def test_a_change_of_light_moves_nothing(tmp_path):
    swing = Swing()
    pictures = film(swing, FRAMES)
    lit = [np.round(p * (1 - 0.004 * k) + 0.3 * k).astype(np.uint8) for k, p in enumerate(pictures)]
    tracks = track(store(tmp_path, lit), POINTS, capture_fps=30)
    assert rms(tracks.values - swing.places(POINTS, FRAMES)) < 0.02


def test_points_given_at_the_start_are_followed_before_it_too(tmp_path):
    swing = Swing(turn=0, stretch=0)
    path = store(tmp_path, film(swing, FRAMES[:30]))
    there = swing.places(POINTS, FRAMES)[12]
    tracks = track(path, there, capture_fps=30, start=12 / 30, stop=20 / 30)
    assert tracks.time[0] == 0
    assert 20 / 30 <= tracks.time[-1] <= 23 / 30
    truth = swing.places(POINTS, FRAMES[: len(tracks.time)])
    assert rms(tracks.values - truth) < 0.02


def test_a_static_reference_takes_out_a_turning_shaking_camera(tmp_path):
    moving = Swing()
    tracks = track(store(tmp_path, film(moving, FRAMES)), POINTS, capture_fps=30)
    reference = np.array([True, True, False, True, False])
    steady = relative_to(tracks, reference)
    assert len(steady.points) == 2
    assert np.abs(steady.values - POINTS[~reference]).max() < 0.03
    assert np.abs(tracks.values[:, ~reference] - POINTS[~reference]).max() > 3
    assert (steady.sigma > tracks.sigma[:, ~reference]).all()
    with pytest.raises(RecordingError, match="static references"):
        relative_to(tracks, np.zeros(5, bool))


def test_points_are_picked_where_texture_moves(tmp_path):
    pictures = film(Swing(turn=0, stretch=0), FRAMES, noise=1)
    still = pictures[0].copy()
    rng = np.random.default_rng(3)
    for picture in pictures:
        noise = rng.standard_normal(still.shape)
        picture[:, :80] = np.clip(still + noise, 0, 255)[:, :80]
    points = pick_points(store(tmp_path, pictures))
    assert len(points) >= 2
    assert (points[:, 0] > 70).all()


def test_a_clip_in_which_nothing_moves_has_no_points_to_pick(tmp_path):
    pictures = film(Swing(shift=0, turn=0, stretch=0), FRAMES, noise=2)
    with pytest.raises(RecordingError, match="no motion"):
        pick_points(store(tmp_path, pictures))


def test_points_outside_or_without_features_are_refused_with_what_is_there(tmp_path):
    pictures = film(Swing(), FRAMES[:15])
    for picture in pictures:
        picture[60:, :60] = 100
        picture[:60, 100:] = np.where(np.arange(60)[None] < 30, 60, 200)
    path = store(tmp_path, pictures)
    with pytest.raises(RecordingError, match=r"point 2 at \(170, 30\) px is outside .* 160 x 120"):
        track(path, [[50, 30], [170, 30]], capture_fps=30)
    with pytest.raises(RecordingError, match=r"point 1 at .* is featureless.*contrast 0 "):
        track(path, [[25, 95]], capture_fps=30)
    edge = track(path, [[130, 30]], capture_fps=30)
    assert "straight edge" in edge.warnings[0]


def test_losing_every_point_is_refused(tmp_path):
    pictures = film(Swing(), FRAMES[:8])
    rng = np.random.default_rng(1)
    pictures += [rng.integers(0, 255, SIZE[::-1], np.uint8) for _ in range(20)]
    with pytest.raises(RecordingError, match="all 5 points were lost after frame 7"):
        track(store(tmp_path, pictures), POINTS, capture_fps=30)


def test_progress_goes_up_to_the_end_and_may_stop_the_work(tmp_path):
    path = store(tmp_path, film(Swing(), FRAMES[:45]))
    seen = []
    track(path, POINTS, capture_fps=30, progress=lambda share, text: seen.append(share))
    assert seen == sorted(seen)
    assert 0 <= seen[0] < 0.1 < 0.8 < seen[-1] <= 1

    def stop(share, text):
        raise Cancelled("stopped")

    with pytest.raises(Cancelled):
        track(path, POINTS, capture_fps=30, progress=stop)


@pytest.mark.parametrize("fast", [True, False])
def test_doubled_frames_are_left_out_and_the_clock_is_that_of_the_motion(tmp_path, fast):
    swing = Swing(rate=0.35, turn=0, stretch=0)
    doubled = [11, 23, 42]
    instants = FRAMES.astype(float)
    if fast:  # time went on: what the copy hides is lost
        instants[doubled] -= 1
    else:  # a copy was put in: all later frames come one later
        instants = np.array([k - sum(d <= k for d in doubled) for k in FRAMES], float)
    pictures = film(swing, instants)
    tracks = track(store(tmp_path, pictures), POINTS, capture_fps=30)
    assert len(tracks.time) == len(FRAMES) - 3
    assert not set(doubled) & set(tracks.frames.tolist())
    truth = swing.places(POINTS, tracks.time * 30)
    assert rms(tracks.values - truth) < 0.02
    assert any("3 doubled frames" in warning for warning in tracks.warnings)


def test_a_frame_that_a_codec_left_as_it_was_stops_no_clock():
    t = np.arange(40.0)
    rng = np.random.default_rng(0)
    change, stopped = np.where(t == 20, 0.001, 1.0), []
    for noise in (0.0, 0.02):
        moved = np.sin(0.8 * (t - (t > 20) * 0.75))[:, None, None] * np.ones((40, 3, 2))
        moved[20] = moved[19]  # its neighbours speak neither for going on nor for standing still
        moved = moved + noise * rng.standard_normal(moved.shape)
        stopped.append(doubled_frames(t, moved, change)[1])
    assert not any(stopped)


def test_turning_points_are_no_doubled_frames(tmp_path):
    swing = Swing(rate=2 * np.pi / 8, turn=0, stretch=0)
    times = FRAMES + 0.5  # two frames either side of every turning point look the same
    shifted = replace(swing, shift=2.0)
    tracks = track(store(tmp_path, film(shifted, times)), POINTS, capture_fps=30)
    assert len(tracks.time) == len(FRAMES)


def test_lucas_kanade_alone_is_worse_than_the_refinement(tmp_path):
    swing = Swing()
    pictures = film(swing, FRAMES, noise=2)
    tracks = track(store(tmp_path, pictures), POINTS, capture_fps=30)
    begin = POINTS.astype(np.float32).reshape(-1, 1, 2)
    last, plain = begin.copy(), []
    for picture in pictures:
        last, _, _ = cv2.calcOpticalFlowPyrLK(
            pictures[0], picture, begin, last.copy(), winSize=(31, 31), flags=4
        )
        plain.append(last[:, 0])
    truth = swing.places(POINTS, FRAMES)
    assert rms(tracks.values - truth) < 0.5 * rms(np.array(plain) - truth)
