"""The picture of a calibration: motion, what is left, pitches, and what was missing."""

from pathlib import Path

import numpy as np

from .files import written_whole
from .residual import errors

INK, BLUE, RED, GREY, GREEN = "#222222", "#2563a8", "#c2452d", "#9a9a9a", "#3b8a5a"


def plot_calibration(result, path: str | Path) -> None:
    """Draw `result` (core.pipeline.Result) at `path`, in the format of its suffix, or not at all.

    Measured and predicted motion of the marker and axis that move most, the residual before and
    after below it on one scale, computed pitches against measured, the misfit by signature, and the
    ranking of effects.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 8.2), layout="constrained")
    FigureCanvasAgg(figure)
    figure.get_layout_engine().set(rect=(0.005, 0.012, 0.99, 0.983), h_pad=0.06)
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
        figure.savefig(draft, dpi=110)


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
    curves = ((declared, RED, "before"), (final, GREEN, "after"))
    if declared is final or np.array_equal(declared.predicted[index], final.predicted[index]):
        curves = ((final, GREEN, "before and after, nothing was added"),)
    for found, color, name in curves:
        left = factor * (data.values - found.predicted[index])[:, c]
        text = f"{name}: {errors(found).held_out:.3g} held out"
        below.plot(data.time, left, color=color, lw=0.9, label=text)
    below.axhspan(-factor * data.sigma[c], factor * data.sigma[c], color=GREY, alpha=0.3, lw=0)
    for axes in (top, below):
        axes.axhline(0, color=GREY, lw=0.5)
        if not data.fit.all():
            axes.axvspan(data.time[data.fit][-1], data.time[-1], color="#f3efe6", zorder=-5)
    low, high = below.get_ylim()
    below.set_ylim(low, high + 0.2 * (high - low))  # room for the legend
    below.set_ylabel(f"what is left, {unit}")
    below.set_xlabel("s after the release; shaded: held out, never fitted")
    below.legend(loc="upper right", fontsize=8, frameon=False, ncols=2)


def _pitches(axes, result) -> None:
    modes = sorted(result.report["modes"], key=lambda m: m["natural_frequency_hz"]["value"])
    labels, reach = [], 1.0
    for i, mode in enumerate(modes):
        f = mode["natural_frequency_hz"]["value"]
        low, high = (100 * (x / f - 1) for x in mode["natural_frequency_hz"]["ci95"])
        axes.errorbar(i - 0.12, 0, [[max(-low, 0)], [max(high, 0)]], fmt="o", color=BLUE, capsize=4,
                      label="measured, 95 %" if i == 0 else None)  # fmt: skip
        labels.append(f"{f:.3g} Hz\n{100 * mode['damping_ratio']['value']:.2g} %")
        if mode["model_frequency_hz"]:
            off = 100 * (mode["model_frequency_hz"] / f - 1)
            known = any(label == "computed" for label in axes.get_legend_handles_labels()[1])
            axes.plot(
                i + 0.12, off, "D", mfc="none", color=RED, label=None if known else "computed"
            )
            reach = max(reach, abs(off))
        else:
            labels[-1] += "\nnone computed"
    axes.axhline(0, color=GREY, lw=0.5)
    axes.set_xticks(range(len(modes)), labels)
    axes.set_xlim(-0.6, max(len(modes) - 0.4, 0.6))
    axes.set_ylim(-1.3 * reach, 1.8 * reach)
    axes.set_title("pitch off the measured one, %; damping ratio below", fontsize=9, loc="left")
    axes.legend(fontsize=8, frameon=False, loc="upper left", ncols=2)


def _budget(axes, result) -> None:
    shares = result.report["diagnosis"]["budget"]
    after = result.budget_after
    names = [n for n in shares if max(shares[n], after.get(n, 0)) > 0.01]
    if not names:
        _say(axes, "nothing is left")
    rows = np.arange(len(names))
    before = [shares[n] for n in names]
    ratio = result.left_after  # energy after over before
    rest = [ratio * after.get(n, 0) for n in names]
    if np.allclose(before, rest, rtol=1e-3, atol=1e-6):
        axes.barh(rows, rest, 0.6, color=GREEN, label="before and after")
    else:
        axes.barh(rows - 0.2, before, 0.38, color=RED, label="before")
        axes.barh(rows + 0.2, rest, 0.38, color=GREEN, label="after")
    axes.set_yticks(rows, [n.replace("_", " ") for n in names])
    axes.set_ylim(max(len(names), 4) - 0.4, -0.6)  # few bars stay slim
    axes.set_xlim(left=0)
    axes.set_title("where the misfit sits, share of its energy before", fontsize=9, loc="left")
    if names:
        axes.legend(fontsize=8, frameon=False, loc="lower right")


def _ranking(axes, result) -> None:
    diagnosis = result.report["diagnosis"]
    ranking, found = diagnosis["ranking"][:7], [e["name"] for e in diagnosis["effects"]]
    alone = "probability, if one effect acts alone"  # of two none may be likely so
    title = alone if len(found) > 1 else "probability of single effects"
    axes.set_title(title, fontsize=9, loc="left")
    if not ranking:
        adequate = diagnosis["verdict"] == "adequate"
        _say(axes, "nothing is missing" if adequate else "none was tried")
        return
    rows = np.arange(len(ranking))
    axes.barh(rows, [r["probability"] for r in ranking], 0.6, color=BLUE)
    axes.set_yticks(rows, [r["name"].replace("_", " ") for r in ranking])
    for label, row in zip(axes.get_yticklabels(), ranking, strict=True):
        label.set_fontweight("bold" if row["name"] in found else "normal")
    axes.set_ylim(max(len(ranking), 4) - 0.4, -0.6)
    axes.set_xlim(0, 1)


def _say(axes, text: str) -> None:
    """One plain line where there is nothing to draw."""
    axes.text(0.5, 0.5, text, ha="center", va="center", color=GREY, transform=axes.transAxes)
    axes.set_axis_off()
