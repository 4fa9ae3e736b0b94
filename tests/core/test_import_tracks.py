"""Tables of other programs, by what their coordinates mean."""

import numpy as np
import pytest

from core.case import read_case
from core.errors import CoreError, RecordingError
from core.import_tracks import import_tracks


def written(tmp_path, text):
    path = tmp_path / "tracks.csv"
    path.write_text(text)
    return path


def test_deeplabcuts_wide_form_gives_points_in_pixels_and_leaves_guesses_out(tmp_path):
    path = written(
        tmp_path,
        "scorer,net,net,net,net,net,net\n"
        "bodyparts,tip,tip,tip,base,base,base\n"
        "coords,x,y,likelihood,x,y,likelihood\n"
        "0,100.5,40.25,0.99,10,20,0.98\n"
        "1,101.5,41.25,0.2,11,21,0.97\n",
    )
    found = import_tracks(path)
    assert found.names == ("tip", "base")
    assert found.kind == "deeplabcut"
    assert found.values[0].tolist() == [[100.5, 40.25], [10, 20]]
    assert np.isnan(found.values[1, 0]).all()
    assert found.values[1, 1].tolist() == [11, 21]
    assert found.frames.tolist() == [0, 1]


def test_blenders_shares_are_turned_upside_down_and_muted_samples_left_out(tmp_path):
    path = written(
        tmp_path,
        "name,frame,x,y,mute\na,1,0.5,0.75,0\na,2,0.25,0.5,1\nb,2,0.0025,0.995,0\n",
    )
    found = import_tracks(path, (200, 100))
    assert found.names == ("a", "b")
    assert found.frames.tolist() == [1, 2]
    # the centre of the first pixel, half a pixel off the corner, is (0, 0)
    assert np.allclose(found.values[0, 0], [99.5, 24.5])
    assert np.allclose(found.values[1, 1], [0, 0])
    assert np.isnan(found.values[1, 0]).all()
    assert np.isnan(found.values[0, 1]).all()
    with pytest.raises(RecordingError, match="Give its size"):
        import_tracks(path)


def test_trackers_tables_have_times_or_frames_and_names_above(tmp_path):
    path = written(tmp_path, "mass A\t\t\nt\tx\ty\n0.0\t1,5\t2.5\n0.1\t\t3.5\n")
    found = import_tracks(path)
    assert found.kind == "tracker"
    assert found.time.tolist() == [0, 0.1]
    assert found.values[0, 0].tolist() == [1.5, 2.5]
    assert np.isnan(found.values[1, 0, 0])
    two = import_tracks(written(tmp_path, ",left,,right,\nframe,x,y,x,y\n0,1,2,3,4\n1,2,3,4,5\n"))
    assert two.names == ("left", "right")
    assert two.frames.tolist() == [0, 1]
    assert two.values[1].tolist() == [[2, 3], [4, 5]]


CASE = """\
name = "beam"
[object]
mesh = "beam.obj"
density = 1070.0
[[pin]]
vertices = [0, 2, 3]
[recording]
tracks = "tracks.csv"
capture_fps = 50.0
[camera]
kind = "orthographic"
metres_per_pixel = 0.001
right = [1, 0, 0]
down = [0, 0, -1]
principal_point = [100, 50]
image_size = [200, 100]
[[marker]]
name = "tip"
position = [0.1, 0, 0]
"""
FORMS = {  # a tip at (110, 20) px, then (111, 21), a frame missing, (113, 23)
    "deeplabcut": "scorer,n,n,n\nbodyparts,tip,tip,tip\ncoords,x,y,likelihood\n"
    "7,110,20,1\n8,111,21,1\n10,113,23,1\n",
    "blender": "name,frame,x,y\n"
    + "".join(f"tip,{7 + k},{(110.5 + k) / 200},{1 - (20.5 + k) / 100}\n" for k in (0, 1, 3)),
    "tracker": "tip,,\nframe,pixelx,pixely\n7,110,20\n8,111,21\n10,113,23\n",
    "own": "time,tip.u,tip.v\n0,110,20\n0.02,111,21\n0.06,113,23\n",
}


@pytest.mark.parametrize("form", FORMS)
def test_a_case_takes_tracks_in_the_form_of_other_programs(tmp_path, form):
    (tmp_path / "beam.obj").write_text(
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    (tmp_path / "case.toml").write_text(CASE)
    written(tmp_path, FORMS[form])
    recording = read_case(tmp_path).takes[0].recording
    assert np.allclose(recording.values[:, 0], [[110, 20], [111, 21], [113, 23]])
    assert np.allclose(recording.time, [0, 0.02, 0.06])
    (tmp_path / "case.toml").write_text(CASE.replace('"tip"', '"tipp"'))
    with pytest.raises(CoreError, match=r"tracks\.csv: .*tip"):
        read_case(tmp_path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "0 rows"),
        ("a,b,c\n1,2,3\n", "its header is a, b, c"),
        ("t,x,y\n0,1,two\n", 'row 2: "two" is not a number'),
        ("scorer,n,n\nbodyparts,tip,tip\ncoords,x,likelihood\n0,1,1\n", "column tip y is missing"),
    ],
)
def test_tables_that_are_no_tracks_are_refused_by_what_is_wrong(tmp_path, text, words):
    with pytest.raises(RecordingError, match=words):
        import_tracks(written(tmp_path, text))
    with pytest.raises(RecordingError, match="no such file"):
        import_tracks(tmp_path / "absent.csv")
