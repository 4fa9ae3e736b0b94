"""Markers that are hidden by turns, so that no frame shows them all."""

import csv

import numpy as np
import pytest

from core.gaps import bridged
from core.pipeline import calibrate_case
from tests.truth import make


def swings(time):
    return np.exp(-time)[:, None] * np.cos(6 * time)[:, None] * [1.0, -2.0, 0.5]


def test_what_is_missing_is_as_it_is_told_but_for_a_constant():
    time = np.arange(90) / 30
    true = swings(time) + np.array([5.0, 0.0, 640.0])
    values = true.copy()
    values[np.arange(90), np.arange(90) % 3] = np.nan
    filled, frames = bridged(values, swings(time))
    assert frames.all() and filled == pytest.approx(true)
    assert np.isnan(values).sum() == 90


def test_where_most_frames_are_whole_these_are_enough():
    values = swings(np.arange(90) / 30)
    values[:40, 1] = np.nan
    filled, frames = bridged(values, np.zeros((90, 3)))
    assert filled is values and frames.tolist() == [False] * 40 + [True] * 50


def hide_by_turns(path):
    """Markers, a third of them in every frame."""
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    names = [column.split(".")[0] for column in head]
    order = list(dict.fromkeys(name for name in names if name != "time"))
    for n, row in enumerate(rows):
        hidden = order[n % 3 :: 3]
        row[:] = ["" if name in hidden else cell for name, cell in zip(names, row, strict=True)]
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed", "verdict", "named"),
    [("null", 173205, "adequate", []), ("compliant_pin", 161803, "explained", ["compliant_pin"])],
)
def test_a_recording_in_which_no_frame_is_whole_tells_the_same(
    kind, seed, verdict, named, tmp_path
):
    truth = make(kind, seed, tmp_path)
    for path in tmp_path.glob("tracks*.csv"):
        hide_by_turns(path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == verdict
    assert [effect["name"] for effect in report["diagnosis"]["effects"]] == named
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.03)
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
