"""tracks.csv: numbers arrive where they belong, and a wrong cell is named by row and column."""

import numpy as np
import pytest

from core.errors import CaseError
from core.tracks_csv import read_tracks, unrounded

GOOD = ["time,b.x,b.y,b.z,a.x,a.y,a.z"] + [f"{k / 50},{k},2,3,4,{k}.5,6" for k in range(5)]


@pytest.fixture
def read(tmp_path):
    def read(lines, names=("a", "b")):
        path = tmp_path / "tracks.csv"
        path.write_bytes("\n".join(lines).encode() if isinstance(lines, list) else lines)
        return read_tracks(path, names)

    return read


def changed(row, old, new):
    lines = list(GOOD)
    assert old in lines[row]
    lines[row] = lines[row].replace(old, new, 1)
    return lines


def test_columns_are_found_by_name_whatever_their_order(read):
    tracks = read(GOOD)
    assert tracks.values.shape == (5, 2, 3) and tracks.warnings == ()
    np.testing.assert_array_equal(tracks.values[2], [[4, 2.5, 6], [2, 2, 3]])
    np.testing.assert_allclose(tracks.time, np.arange(5) / 50)


def test_an_empty_cell_is_a_missing_sample_and_nothing_else_is(read):
    values = read(changed(3, ",2,3,4,", ",,3,4,")).values
    assert np.argwhere(np.isnan(values)).tolist() == [[2, 1, 1]]


def test_pixels_have_two_axes_and_time_may_be_left_out(read):
    tracks = read(["a.u,a.v"] + [f"{k},7" for k in range(4)], ("a",))
    assert tracks.time is None and tracks.values.shape == (4, 1, 2)


def test_a_pixel_may_be_a_million_but_not_ten_thousand_million(read):
    lines = ["a.u,a.v"] + [f"{k},2e6" for k in range(4)]
    assert read(lines, ("a",)).values[0, 0, 1] == 2e6
    with pytest.raises(CaseError, match=r"line 3, column a\.v: 1e10 is beyond 1e\+09 px"):
        read([*lines[:2], "1,1e10", *lines[3:]], ("a",))


def test_byte_order_marks_blank_lines_and_spaces_do_no_harm(read):
    text = ("\ufeff" + "\r\n".join([GOOD[0].replace(",", " , "), *GOOD[1:], "", ""])).encode()
    np.testing.assert_array_equal(read(text).values, read(GOOD).values)
    np.testing.assert_array_equal(read(text).time, read(GOOD).time)


def test_a_frame_in_which_nothing_was_seen_takes_its_time(read):
    """Without written instants the rows are counted; empty ones at the end say nothing."""
    lines = ["a.u,a.v", "1,2", ",", ",", "  ", "", "3,4", "4,5", ",", ","]
    values = read(lines, ("a",)).values
    assert np.isnan(values[:, 0, 0]).tolist() == [False, True, True, False, False]
    timed = [*GOOD[:3], ",,,,,,", *GOOD[3:]]
    np.testing.assert_array_equal(read(timed).values, read(GOOD).values)


def test_columns_of_no_marker_are_left_out_with_a_warning(read):
    (warning,) = read(GOOD, ("a",)).warnings
    assert "b.x" in warning and "tracks.csv" in warning


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (changed(0, "a.y", "a.q"), ["a.y", "missing", "a.q"]),
        (changed(0, "a.y", "a.x"), ["a.x", "twice"]),
        (changed(2, ",2,", ",two,"), ["line 3", "column b.y", "two"]),
        (changed(2, ",2,", ",2_0,"), ["line 3", "column b.y", "2_0"]),
        (changed(2, ",2,", ",inf,"), ["line 3", "column b.y", "inf"]),
        (changed(2, ",2,", ",nan,"), ["line 3", "column b.y", "nan", "empty"]),
        (changed(2, ",2,", ",NaN,"), ["line 3", "column b.y", "NaN"]),
        (changed(2, ",2,", ",1e300,"), ["line 3", "column b.y", "1e300", "1e+06 m"]),
        (changed(4, "0.06", "1e300"), ["line 5", "column time", "1e+09 s"]),
        (changed(4, "0.06", "0.01"), ["line 5", "0.01 s", "0.04 s"]),
        (changed(4, "0.06", "0.04"), ["line 5", "grow"]),
        (changed(4, "0.06", ""), ["line 5", "time is empty"]),
        (changed(4, ",2,", ","), ["line 5", "6 cells", "7"]),
        (GOOD[:3], ["2 frames", "3"]),
        (GOOD[:1], ["0 frames"]),
        ([""], ["empty"]),
        ([GOOD[0]] + [f"{k / 50},1,2,3,4,5,6" for k in range(5)], ["no marker moves"]),
        ([GOOD[0]] + [f"{k / 50},,,,,," for k in range(5)], ["every sample is missing"]),
        ([GOOD[0]] + [f"{k / 50},1,2,{k},,," for k in range(5)], ["marker a", "0 samples"]),
        ([line.replace(",", ";") for line in GOOD], ["semicolons", "commas"]),
        (b"\xff\xfe\x00\x80\x81", ["text"]),
    ],
)
def test_a_wrong_table_is_refused_by_row_and_column(read, lines, words):
    with pytest.raises(CaseError) as caught:
        read(lines)
    for word in ["tracks.csv", *words]:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize("rate", [24, 59.94, 240])
@pytest.mark.parametrize("digits", [3, 4, 6])
def test_instants_that_were_written_rounded_are_the_frames_own(rate, digits):
    frame = np.delete(np.arange(400), [37, 38, 200])  # three were lost
    even = 0.25 + frame / rate
    assert np.abs(unrounded(np.round(even, digits)) - even).max() < 2e-4 / rate + 1e-5


def test_instants_that_are_uneven_stay_as_they_are():
    time = np.round(np.cumsum(np.random.default_rng(1).uniform(0.03, 0.05, 200)), 3)
    assert np.array_equal(unrounded(time), time)
    exact = np.arange(100) / 120
    assert np.array_equal(unrounded(exact), exact)
