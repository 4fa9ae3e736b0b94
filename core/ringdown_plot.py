"""A picture of a ring-down: the motion, its spectrum, and the poles that stay."""

from pathlib import Path

import numpy as np

from .files import written_whole
from .pencil import evenly
from .ringdown import Heard
from .stabilization import stabilization

INK, MEASURED, FITTED, FAINT = "#222222", "#4477aa", "#ee6677", "#bbbbbb"


def plot_ringdown(heard: Heard, path: str | Path) -> None:
    """Write a PNG: motion over time, spectrum, stabilization diagram with the modes marked."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 8), layout="constrained")
    FigureCanvasAgg(figure)
    motion, spectrum, poles = figure.subplots(3, 1, height_ratios=[3, 2, 2])
    direction = _direction(heard)
    _draw_motion(motion, heard, direction)
    _draw_spectrum(spectrum, heard, direction)
    _draw_poles(poles, heard)
    poles.sharex(spectrum)
    for axes in (motion, spectrum, poles):
        axes.spines[["top", "right"]].set_visible(False)
    with written_whole(path) as draft:
        figure.savefig(draft, format="png", dpi=130)


def _direction(heard: Heard) -> tuple[int, np.ndarray]:
    """The point that moves most in the strongest mode, and the unit vector along which it does."""
    deflection = heard.deflection[0]
    point = int(np.argmax(np.linalg.norm(deflection, axis=1)))
    a = deflection[point]
    u, _, _ = np.linalg.svd(np.stack([a.real, a.imag], axis=1))
    return point, u[:, 0] * np.sign(u[np.argmax(np.abs(u[:, 0])), 0])


def _draw_motion(axes, heard: Heard, direction) -> None:
    point, along = direction
    channels = slice(point * len(along), (point + 1) * len(along))
    rest = heard.ring.offset[channels] @ along
    axes.plot(heard.time, heard.values[:, point] @ along - rest, color=MEASURED, lw=1.2)
    fine = np.linspace(heard.start, heard.stop, 4000)
    fitted = heard.ring.predict(fine)[:, channels] @ along - rest
    axes.plot(fine, fitted, color=FITTED, lw=0.8)
    axes.axvspan(heard.start, heard.stop, color=FAINT, alpha=0.2, lw=0)
    axes.set_xlim(heard.time[0], heard.time[-1])
    axes.set_xlabel("time, s")
    axes.set_ylabel(f"displacement, {heard.unit}")
    axes.set_title(
        f"point {heard.points[point] + 1} along its strongest motion: measured (blue), "
        f"{len(heard.ring.frequency)} modes (red)",
        loc="left",
        fontsize=10,
    )


def _draw_spectrum(axes, heard: Heard, direction) -> None:
    inside = (heard.time >= heard.start - 1e-9) & (heard.time <= heard.stop + 1e-9)
    point, along = direction
    dt, even = evenly(heard.time[inside], (heard.values[inside, point] @ along)[:, None])
    even = even[:, 0] - even.mean()
    window = np.hanning(len(even))
    size = np.abs(np.fft.rfft(even * window, 4 * len(even))) * 2 / window.sum()
    axes.semilogy(np.fft.rfftfreq(4 * len(even), dt), size + 1e-12, color=MEASURED, lw=1)
    axes.set_ylim(bottom=max(np.percentile(size, 2) / 2, 1e-12))
    for k, f in enumerate(heard.ring.frequency):
        axes.axvline(f, color=FITTED, lw=0.8)
        axes.annotate(
            f" {f:.4g} Hz\n ζ {heard.ring.damping_ratio[k]:.3g}",
            (f, 0.97 - 0.22 * (k % 4)),
            xycoords=("data", "axes fraction"),
            va="top",
            fontsize=8,
            color=INK,
        )
    axes.set_ylabel(f"spectrum, {heard.unit}")


def _draw_poles(axes, heard: Heard) -> None:
    inside = (heard.time >= heard.start - 1e-9) & (heard.time <= heard.stop + 1e-9)
    found = stabilization(heard.time[inside], heard.values[inside].reshape(inside.sum(), -1))
    shaky = ~found.stable
    axes.plot(found.frequency[shaky], found.order[shaky], "x", color=FAINT, ms=3)
    axes.plot(found.frequency[found.stable], found.order[found.stable], "o", color=MEASURED, ms=3)
    for f, s in zip(heard.ring.frequency, heard.ring.frequency_sigma, strict=True):
        axes.axvspan(f - 2 * s, f + 2 * s, color=FITTED, alpha=0.4)
    axes.set_xlim(0, heard.fps / 2)
    axes.set_xlabel("frequency, Hz")
    axes.set_ylabel("order asked of the pencil")
    axes.set_title("poles: dots stay from one order to the next", loc="left", fontsize=10)
