"""The markers of a case in its video."""

import numpy as np
import pytest

from core.data import Camera, Marker
from core.errors import RecordingError
from core.track import track_recording
from tests.core.clips import POINTS, Swing, film, store

FRAMES = np.arange(20)
CAMERA = Camera("orthographic", np.eye(3), np.zeros(3), 1000.0, [80, 60], (160, 120), 0.01)


def markers(points):
    return tuple(Marker(f"m{k}", [0, 0, 0], pixel=tuple(p)) for k, p in enumerate(points))


def test_markers_are_followed_from_their_pixels_and_nothing_is_resampled(tmp_path):
    swing = Swing()
    path = store(tmp_path, film(swing, FRAMES))
    found = track_recording(path, markers(POINTS), CAMERA, 240.0, start=0.0, stop=0.07)
    assert [marker.name for marker in found.markers] == ["m0", "m1", "m2", "m3", "m4"]
    assert np.allclose(found.time, FRAMES[: len(found.time)] / 240)
    assert found.time[-1] >= found.stop == 0.07
    truth = swing.places(POINTS, FRAMES[: len(found.time)])
    assert np.abs(found.values - truth).max() < 0.03
    assert (found.sigma > 0).all()
    assert found.camera.readout == 0.01  # left to the prediction
    assert found.capture_fps == 240


def test_another_size_of_picture_is_said(tmp_path):
    path = store(tmp_path, film(Swing(), FRAMES))
    other = Camera("orthographic", np.eye(3), np.zeros(3), 1000.0, [160, 120], (320, 240))
    found = track_recording(path, markers(POINTS), other, 30.0)
    assert any("160 x 120 px, [camera] says 320 x 240" in w for w in found.warnings)


def test_a_marker_without_pixel_or_on_an_edge_is_refused_by_name(tmp_path):
    pictures = film(Swing(), FRAMES)
    for picture in pictures:
        picture[:70, 90:] = np.where(np.arange(70)[None] < 35, 60, 200)
    path = store(tmp_path, pictures)
    with pytest.raises(RecordingError, match="marker bare has no pixel"):
        track_recording(path, (Marker("bare", [0, 0, 0]),), CAMERA, 30.0)
    with pytest.raises(RecordingError, match=r"marker m0 at .* lies on a straight edge"):
        track_recording(path, markers([[125, 35]]), CAMERA, 30.0)
