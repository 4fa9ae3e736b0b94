"""The pictures of the study."""

from pathlib import Path

import numpy as np

from .files import written_whole

INK, BLUE, RED, GREY, GREEN = "#222222", "#2563a8", "#c2452d", "#9a9a9a", "#3b8a5a"
DPI = 90


def _figure(width: float, height: float):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _save(figure, path: Path) -> None:
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8, color=GREY)
        axes.title.set_fontsize(10)
    with written_whole(path) as draft:
        figure.savefig(draft, format="png", dpi=DPI)


def draw_line(line: dict, path: Path) -> None:
    """Eigenvalues over the exact ones at n = 16; the first as n grows; the next ones after DAC."""
    figure = _figure(11, 3.4)
    spectrum, first, after = figure.subplots(1, 3)
    at16, exact = line["eigenvalues"]["16"], np.array(line["eigenvalues"]["16"]["exact"])
    mode = np.arange(1, len(exact) + 1)
    kinds = (
        ("elements", BLUE, "o-", "elements"),
        ("conjecture", GREY, "--", "the conjecture"),
        ("averaged_mass", GREEN, "s-", "elements, averaged mass"),
        ("differences", RED, "^-", "differences"),
    )
    for key, colour, style, label in kinds:
        spectrum.plot(mode, np.array(at16[key]) / exact, style, color=colour, label=label, ms=3)
    spectrum.axhline(1, color=INK, lw=0.8)
    spectrum.set(title="16 cells: eigenvalue over the exact one", xlabel="mode")
    spectrum.legend(fontsize=7, frameon=False)
    for key, colour, style, label in kinds:
        rows = [
            (int(n), abs(e[key][0] / e["exact"][0] - 1)) for n, e in line["eigenvalues"].items()
        ]
        first.loglog(*np.transpose(rows), style, color=colour, label=label, ms=4)
    first.set(title="error of the first eigenvalue", xlabel="cells")
    first.set_xticks([2, 4, 8, 16], ["2", "4", "8", "16"], minor=False)
    first.minorticks_off()
    dac = line["dac_on_the_first"]
    for k, (colour, name) in enumerate(zip((GREEN, BLUE, RED), ("1", "2", "3"), strict=True)):
        left = [row["frequency_percent"][k] for row in dac.values()]
        after.plot([int(n) for n in dac], left, "o-", color=colour, label=f"mode {name}", ms=4)
    after.set(title="frequency after DAC on mode 1, % off", xlabel="cells", xticks=[4, 8, 16])
    after.legend(fontsize=7, frameon=False)
    _save(figure, path)


def draw_polygon(polygon: dict, modes: dict, path: Path) -> None:
    """The lowest elastic mode on the coarsest and the finest mesh, and both eigenvalues."""
    figure = _figure(11, 3.6)
    left, middle, right = figure.subplots(1, 3, width_ratios=(1, 1, 0.8))
    values = {row["h"]: row["elastic"] for row in polygon["table"]}
    sign = None
    for axes, h in ((left, max(modes)), (middle, min(modes))):
        nodes, cells, mode = modes[h]
        if sign is None:
            sign, first = 1.0, (nodes, mode)
        else:  # the same swing on both meshes: compare at the polygon's first corner
            near = np.linalg.norm(nodes - first[0][0], axis=1).argmin()
            sign = np.sign(mode[near] @ first[1][0]) or 1.0
        swing = np.linalg.norm(mode, axis=1)
        moved = nodes + 0.25 * sign * mode / swing.max()
        axes.triplot(*nodes.T, cells, color=GREY, lw=0.3)
        axes.tripcolor(*moved.T, cells, swing / swing.max(), cmap="viridis")
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(f"h = {h:g}, {len(cells)} triangles: λ = {values[h]:.4f}")
    h = np.array([row["h"] for row in polygon["table"]])
    scalar = np.array([row["scalar"] for row in polygon["table"]]) / polygon["scalar_limit"]
    right.plot(h, scalar, "o-", color=BLUE, ms=4, label="scalar, over its limit")
    elastic = np.array([row["elastic"] for row in polygon["table"]])
    right.plot(h, elastic / elastic[-1], "s-", color=RED, ms=4, label="elastic, over the finest")
    right.axhline(1, color=INK, lw=0.8)
    right.set(title="first eigenvalue", xlabel="h", xlim=(0, None))
    right.legend(fontsize=7, frameon=False)
    _save(figure, path)


def draw_triangle(triangle: dict, bent: list, path: Path) -> None:
    """The deformed triangle with the force that holds it, and that force under refinement."""
    figure = _figure(11, 3.2)
    *shapes, sizes = figure.subplots(1, 5, width_ratios=(1, 1, 1, 1, 1.5))
    largest = np.linalg.norm(bent[0][3])
    for axes, (nodes, cells, u, force) in zip(shapes, bent, strict=True):
        moved, size = nodes + u, np.linalg.norm(force)
        axes.triplot(*nodes.T, cells, color="#d9b44a", lw=0.6)
        axes.triplot(*moved.T, cells, color=BLUE, lw=0.8)
        arrow = 0.5 * force / largest
        axes.annotate(
            "",
            xy=moved[2] + arrow,
            xytext=moved[2],
            arrowprops={"arrowstyle": "-|>", "color": RED, "lw": 1.5, "shrinkA": 0, "shrinkB": 0},
        )
        axes.set(xlim=(-0.05, 1.3), ylim=(-0.1, 1.55))
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(f"force {size:.3g}")
    for nu, colour in (("0.3", BLUE), ("0.48", RED)):
        force = triangle[nu]["force"]
        sizes.semilogy(range(len(force)), force, "o-", color=colour, ms=4, label=f"ν = {nu}")
    sizes.set(title="force to hold the top", xlabel="refinements")
    sizes.legend(fontsize=8, frameon=False)
    _save(figure, path)


def draw_locking(locking: dict, path: Path) -> None:
    """Error of the first frequency, and the worst after DAC, against unknowns."""
    figure = _figure(11, 3.6)
    axes = figure.subplots(1, 4, sharex=True)
    colours = {"p1": RED, "p1_smoothed": GREEN, "p2": BLUE, "dg": GREY}
    titles = {
        "first_percent": "first frequency, %",
        "worst_after_dac_percent": "after DAC, worst, %",
    }
    pairs = [(nu, key) for nu in ("0.3", "0.49") for key in titles]
    for ax, (nu, key) in zip(axes, pairs, strict=True):
        for element, colour in colours.items():
            rows = locking[element][nu]
            unknowns = [row["unknowns"] for row in rows]
            error = [abs(row[key]) for row in rows]
            ax.loglog(unknowns, error, "o-", color=colour, ms=4, label=element)
        ax.set(title=f"ν = {nu}: {titles[key]}", xlabel="unknowns", ylim=(0.1, 500))
    axes[0].legend(fontsize=7, frameon=False)
    _save(figure, path)
