"""The picture of a calibration stays whole when there is little to draw."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from core import plot
from core.residual import Error

MODE = {
    "natural_frequency_hz": {"value": 5.0, "ci95": [4.99, 5.01]},
    "damping_ratio": {"value": 0.03},
    "model_frequency_hz": 5.02,
}
RACE = [{"name": "relaxation", "probability": 0.9}, {"name": "contact", "probability": 0.1}]


def fitted(time, values, shift):
    on = np.ones(len(time), bool)
    recording = SimpleNamespace(values=values[:, None], markers=[SimpleNamespace(name="tip")])
    data = SimpleNamespace(
        time=time, values=values, support=np.zeros(3, bool), sigma=np.full(3, 1e-5),
        marker=np.zeros(3, int), fit=on & (time < 2), take=SimpleNamespace(recording=recording),
    )  # fmt: skip
    law = SimpleNamespace(takes=[data], fitted=[0])
    return SimpleNamespace(law=law, predicted=[values + shift])


def result(*, added=(), ranking=(), modes=1, budget=None):
    time = np.arange(300) / 100
    swing = np.exp(-time) * np.cos(31 * time)
    values = np.stack([1e-3 * swing, 1e-4 * swing, 5e-3 * swing], axis=1)
    declared = fitted(time, values, 1e-5)
    final = fitted(time, values, 1e-6) if added else declared
    verdict = "explained" if added else "adequate"
    report = {
        "case": "bar", "modes": [MODE] * modes, "youngs_modulus": {"material": {"value": 1e5}},
        "error": {"before": 0.05, "after": 0.05, "floor": 0.048},
        "diagnosis": {"verdict": verdict, "effects": [{"name": n} for n in added],
                      "ranking": list(ranking), "budget": budget or {"other": 1.0}},
    }  # fmt: skip
    chain = SimpleNamespace(chain=[(None, declared)], final=final)
    return SimpleNamespace(
        report=report, verdict=chain, budget_after=report["diagnosis"]["budget"], left_after=1.0
    )


@pytest.fixture
def drawn(monkeypatch, tmp_path):
    """Draws and gives the figure; matplotlib may not warn."""
    monkeypatch.setattr(plot, "errors", lambda _: Error(0.05, 0.05))
    kept, save = [], Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda f, *a, **k: (kept.append(f), save(f, *a, **k))[1])

    def draw(what, name="r.png"):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            plot.plot_calibration(what, tmp_path / name)
        return kept[-1], (tmp_path / name).read_bytes()

    return draw


@pytest.mark.parametrize("ranking", [(), RACE])
@pytest.mark.parametrize("modes", [1, 2, 9])
def test_no_label_lies_on_a_title_however_little_there_is(drawn, ranking, modes):
    figure, _ = drawn(result(ranking=ranking, modes=modes, added=ranking and ["relaxation"]))
    _, below, *panels = figure.axes
    label = below.xaxis.label.get_window_extent()
    for axes in panels:
        assert not label.overlaps(axes._left_title.get_window_extent())
        assert axes.get_window_extent().height > 100


def test_no_ranking_is_one_plain_line(drawn):
    last = drawn(result())[0].axes[-1]
    assert [text.get_text() for text in last.texts] == ["nothing is missing"]
    assert not last.axison


def test_curves_that_coincide_are_drawn_once_and_others_twice(drawn):
    def labels(figure):
        return figure.axes[1].get_legend_handles_labels()[1]

    assert len(labels(drawn(result())[0])) == 1
    assert len(labels(drawn(result(added=["relaxation"]))[0])) == 2


def test_a_computed_pitch_stands_at_its_distance_from_the_measured_one(drawn):
    panel = drawn(result())[0].axes[2]
    (diamond,) = (line for line in panel.lines if line.get_marker() == "D")
    assert diamond.get_ydata()[0] == pytest.approx(0.4)
    low, high = panel.get_ylim()
    assert low < 0 < 0.4 < high < 10


def test_a_picture_has_the_format_of_its_suffix(drawn):
    assert drawn(result())[1].startswith(b"\x89PNG")
    assert b"<svg" in drawn(result(), "r.svg")[1]


@pytest.mark.parametrize("added", [["relaxation"], ["relaxation", "contact"]])
def test_what_was_found_stands_out_and_two_are_not_told_as_one(drawn, added):
    ranking = [*RACE, {"name": "air_drag", "probability": 0.0}]
    axes = drawn(result(added=added, ranking=ranking))[0].axes[-1]
    assert ("acts alone" in axes.get_title("left")) is (len(added) > 1)
    bold = [t.get_text() for t in axes.get_yticklabels() if t.get_fontweight() == "bold"]
    assert bold == added
