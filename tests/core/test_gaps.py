"""Markers that are hidden by turns, so that no frame shows them all."""

import csv

import numpy as np
import pytest

from core.data import RingDown
from core.gaps import bridged
from core.pipeline import calibrate_case
from core.shutter import rung
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


def test_what_wanders_and_is_told_at_nought_is_bridged_as_it_wanders():
    time = np.arange(90) / 30
    true = swings(time) + np.outer(time, [3.0, 0.0, -2.0])
    values = true.copy()
    values[10:50, 0] = values[40:, 1] = values[:30, 2] = np.nan
    slow = np.stack([np.ones(90), time], axis=1)
    filled, _ = bridged(values, swings(time), slow=slow)
    assert filled == pytest.approx(true)


def test_nothing_of_what_is_not_used_is_told():
    """Nor does a marker that is not seen there leave a hole."""
    time = np.arange(90) / 30
    use, values = time < 2, swings(time)
    values[~use, 0] += 10
    values[use, 1] = np.nan
    values[:30, 0] = np.nan
    filled, frames = bridged(values, swings(time), use)
    assert frames.all() and filled[use] == pytest.approx(swings(time)[use])


def test_most_of_the_frames_that_are_used_must_be_whole():
    values = swings(np.arange(90) / 30)
    values[:40:2, 1] = values[1:40:2, 0] = np.nan
    _, frames = bridged(values, np.zeros((90, 3)), np.arange(90) < 40)
    assert frames.all()


def test_late_rows_are_bridged_by_what_they_show():
    """Of a swing of 4 Hz, rows at a tenth, half and nine tenths of a readout of 30 ms."""
    time, late = np.arange(90) / 30, 0.03 * np.array([0.1, 0.5, 0.9])
    amplitude = np.array([[1.0, 2.0j, -0.5]])
    ring = RingDown(
        np.full(1, 4.0), np.full(1, 0.02), amplitude, np.arange(3.0), np.ones(3), np.eye(2)
    )
    pole = 2 * np.pi * 4.0 * (-0.02 + 1j * np.sqrt(1 - 0.02**2))
    shown = [
        (a * np.exp(pole * (time + d))).real + c
        for c, (a, d) in enumerate(zip(amplitude[0], late, strict=True))
    ]
    assert rung(ring, time, late) == pytest.approx(np.transpose(shown))


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
