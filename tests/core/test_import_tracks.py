"""Tables of other programs, by what their coordinates mean."""

import numpy as np
import pytest

from core.errors import RecordingError
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
