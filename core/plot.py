"""The picture of a calibration: motion, what is left, pitches, and what was missing."""

from pathlib import Path

import numpy as np

from .diagnosis import errors
from .files import written_whole

INK, BLUE, RED, GREY, GREEN = "#222222", "#2563a8", "#c2452d", "#9a9a9a", "#3b8a5a"


def plot_calibration(result, path: str | Path) -> None:
    """Draw `result` (core.pipeline.Result) as a .png at `path`, whole or not at all.

    Measured and predicted motion of the marker and axis that move most, the residual before and
    after below it on one scale, pitches measured and computed, the misfit by signature, and the
    ranking of effects.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 8.2), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(3, 3, height_ratios=(1.25, 1, 1.1))
    top = figure.add_subplot(grid[0, :])
    below = figure.add_subplot(grid[1, :], sharex=top)
    _motion(top, below, result)
    _pitches(figure.add_subplot(grid[2, 0]), result)
    _budget(figure.add_subplot(grid[2, 1]), result)
    _ranking(figure.add_subplot(grid[2, 2]), result)
    figure.suptitle(_headline(result), fontsize=12, color=INK, ha="left", x=0.01)
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8, color=GREY)
    with written_whole(path) as draft:
        figure.savefig(draft, format="png", dpi=110)


def _headline(result) -> str:
    report = result.report
    found = [e["name"].replace("_", " ") for e in report["diagnosis"]["effects"]]
    missing = " and ".join(found) if found else "nothing named"
    modulus = report["youngs_modulus"]["material"]["value"]
    error = report["error"]
    return (
        f"{report['case']}: {report['diagnosis']['verdict']}, {missing}; E = {modulus:.4g} Pa; "
        f"held-out error {error['before']:.3g} to {error['after']:.3g}, noise {error['floor']:.2g}"
    )


def _motion(top, below, result) -> None:
    verdict = result.verdict
    declared, final = verdict.chain[0][1], verdict.final
    data = final.law.takes[final.law.fitted[0]]
    index = final.law.fitted[0]
    moving = np.where(data.support, 0, np.nanstd(data.values, axis=0))
    c = int(np.argmax(moving))
    d = data.take.recording.values.shape[2]
    marker = data.take.recording.markers[data.marker[c]].name
    unit, factor = ("mm", 1e3) if d == 3 else ("px", 1.0)
    axis = "xyz"[c % 3] if d == 3 else "uv"[c % 2]
    rest = np.nanmean(data.values[:, c])
    scale = lambda values: factor * (values[:, c] - rest)  # noqa: E731
    top.plot(data.time, scale(data.values), ".", color=GREY, ms=3, label="measured")
    top.plot(data.time, scale(final.predicted[index]), color=BLUE, lw=1, label="predicted")
    top.set_ylabel(f"{marker} {axis}, {unit}")
    top.legend(loc="upper right", fontsize=8, frameon=False, ncols=2)
    for found, color, name in ((declared, RED, "before"), (final, GREEN, "after")):
        left = factor * (data.values - found.predicted[index])[:, c]
        text = f"{name}: {errors(found)[0]:.3g} held out"
        below.plot(data.time, left, color=color, lw=0.9, label=text)
    below.axhspan(-factor * data.sigma[c], factor * data.sigma[c], color=GREY, alpha=0.3, lw=0)
    for axes in (top, below):
        axes.axhline(0, color=GREY, lw=0.5)
        if not data.fit.all():
            axes.axvspan(data.time[data.fit][-1], data.time[-1], color="#f3efe6", zorder=-5)
    below.set_ylabel(f"what is left, {unit}")
    below.set_xlabel("s after the release; shaded: held out, never fitted")
    below.legend(loc="upper right", fontsize=8, frameon=False, ncols=2)


def _pitches(axes, result) -> None:
    modes = sorted(result.report["modes"], key=lambda m: m["natural_frequency_hz"]["value"])
    for i, mode in enumerate(modes):
        f = mode["natural_frequency_hz"]["value"]
        axes.plot(i - 0.12, f, "o", color=BLUE, label="measured" if i == 0 else None)
        if mode["model_frequency_hz"]:
            axes.plot(i + 0.12, mode["model_frequency_hz"], "D", mfc="none", color=RED,
                      label="computed" if i == 0 else None)  # fmt: skip
        axes.annotate(f"{100 * mode['damping_ratio']['value']:.1f} %", (i, f), fontsize=8,
                      textcoords="offset points", xytext=(0, 8), ha="center")  # fmt: skip
    axes.set_xticks(range(len(modes)), [f"mode {i + 1}" for i in range(len(modes))])
    axes.set_xlim(-0.6, max(len(modes) - 0.4, 0.6))
    axes.set_ylim(0, axes.get_ylim()[1] * 1.15)
    axes.set_title("pitch, Hz, and damping ratio", fontsize=9, loc="left")
    axes.legend(fontsize=8, frameon=False, loc="upper left")


def _budget(axes, result) -> None:
    shares = result.report["diagnosis"]["budget"]
    after = result.budget_after
    names = [n for n in shares if max(shares[n], after.get(n, 0)) > 0.01]
    rows = np.arange(len(names))
    axes.barh(rows + 0.2, [shares[n] for n in names], 0.38, color=RED, label="before")
    ratio = result.left_after  # energy after over before
    rest = [ratio * after.get(n, 0) for n in names]
    axes.barh(rows - 0.2, rest, 0.38, color=GREEN, label="after")
    axes.set_yticks(rows, names)
    axes.invert_yaxis()
    axes.set_title("where the misfit sits, share of its energy before", fontsize=9, loc="left")
    axes.legend(fontsize=8, frameon=False)


def _ranking(axes, result) -> None:
    ranking = result.report["diagnosis"]["ranking"][:7]
    rows = np.arange(len(ranking))
    axes.barh(rows, [r["probability"] for r in ranking], 0.6, color=BLUE)
    axes.set_yticks(rows, [r["name"].replace("_", " ") for r in ranking])
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_title("probability of single effects", fontsize=9, loc="left")
    if not ranking:
        axes.text(0.5, 0.5, "nothing stands out", ha="center", va="center", color=GREY)
        axes.set_yticks([])
