"""Markers that too few frames show of what is fitted."""

import numpy as np
import pytest

from core.case import read_case
from core.data import replace
from core.lost import without_lost
from core.ringdown import find_release
from tests.truth import make


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A case of two takes, each of some 500 frames from its `start` on."""
    folder = tmp_path_factory.mktemp("filmed")
    make("null", 173205, folder)
    return read_case(folder / "case.toml")


def lost_in(case, at, names, begin=0.0, end=1.0, **also):
    """The case whose take `at` shows these markers only in that part of its frames."""
    takes = list(case.takes)
    recording = takes[at].recording
    values, rows = recording.values.copy(), np.arange(len(recording.time))
    away = (rows < begin * len(rows)) | (rows >= end * len(rows))
    for n, marker in enumerate(recording.markers):
        if marker.name in names:
            values[away, n] = np.nan
    takes[at] = replace(takes[at], recording=replace(recording, values=values), **also)
    return replace(case, takes=tuple(takes))


def names_of(case):
    return {marker.name for take in case.takes for marker in take.recording.markers}


@pytest.mark.parametrize("at", [0, 1])
@pytest.mark.parametrize(
    ("begin", "end"),
    [(0.0, 0.09), (0.7, 1.0), (0.65, 1.0)],
    ids=["soon lost", "late", "just before"],
)
def test_a_marker_that_hardly_shows_where_it_is_fitted_is_left_out_of_all_takes(
    filmed, at, begin, end
):
    case = without_lost(lost_in(filmed, at, ["m3"], begin, end), find_release)
    assert names_of(filmed) - names_of(case) == {"m3"}
    (line,) = case.takes[at].recording.warnings
    assert "m3" in line and not case.takes[1 - at].recording.warnings
    for take, before in zip(case.takes, filmed.takes, strict=True):
        kept = [m.name != "m3" for m in before.recording.markers]
        np.testing.assert_array_equal(take.recording.values, before.recording.values[:, kept])


def test_a_marker_that_shows_long_enough_or_need_only_be_foretold_stays(filmed):
    for case in (
        filmed,
        lost_in(filmed, 0, ["m3"], 0.3, 0.6),
        lost_in(filmed, 1, ["m3"], 0.0, 0.01, held_out=True),
    ):
        assert without_lost(case, find_release) is case


def test_without_any_marker_the_case_stays_as_it_is(filmed):
    on = [m.name for m in filmed.takes[0].recording.markers if m.on == "object"]
    case = lost_in(filmed, 0, on, 0.0, 0.05)
    assert without_lost(case, find_release) is case


@pytest.mark.parametrize("given", [True, False], ids=["at a given start", "at one that is heard"])
def test_a_marker_that_is_hidden_until_the_release_stays(filmed, given):
    """After fifteen seconds of rest, which the window that is fitted leaves out."""
    recording = filmed.takes[0].recording
    step = np.median(np.diff(recording.time))
    rest = np.arange(-3600, 0) * step + recording.time[0]
    still = np.nanmean(recording.values[recording.time < recording.start], axis=0)
    noise = 0.02 * np.random.default_rng(4).standard_normal((3600, *still.shape))
    longer = replace(
        recording,
        time=np.r_[rest, recording.time],
        values=np.concatenate([still + noise, recording.values]),
        sigma=None,
        start=recording.start if given else None,
    )
    takes = (replace(filmed.takes[0], recording=longer), filmed.takes[1])
    case = lost_in(replace(filmed, takes=takes), 0, ["m3"], 3600 / len(longer.time))
    assert without_lost(case, find_release) is case


def test_a_later_take_that_lost_most_of_them_takes_none_from_the_first(filmed):
    on = [m.name for m in filmed.takes[0].recording.markers if m.on == "object"]
    case = lost_in(filmed, 1, on[1:], 0.0, 0.05)
    assert without_lost(case, find_release) is case
