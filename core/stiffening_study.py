"""Which resolution do I need: stiffening of several meshes and elements, with what each costs."""

import json
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from .data import ElasticModel, Material, Surface, TetMesh
from .elasticity import assemble, held_part, hold
from .errors import CaseError
from .files import written_whole
from .modes import solve_modes
from .pins import Box, Region, Sphere, held_vertices, vertices_region
from .rim import along_rim
from .stiffening import converged_eigenvalues, stiffening
from .surface import read_surface
from .tetrahedralize import tetrahedralize

Progress = Callable[[float, str], None]
EVERY_ELEMENT = ("p1", "p1_smoothed", "p2", "p2_mixed")


@dataclass(frozen=True)
class Row:
    """One element on one mesh."""

    tets: int
    element: str
    unknowns: int
    seconds: float  # from mesh to modes
    pitch_error: tuple[float, ...]  # f / f_converged - 1 of each of the lowest modes
    sigma: tuple[float, ...]  # one standard deviation of that


def study_mesh(
    build: Callable[[TetMesh, str], ElasticModel], mesh: TetMesh, elements: tuple, count: int
) -> list[Row]:
    """How far the lowest `count` frequencies of each element lie from the converged ones."""
    limit = converged_eigenvalues(build, mesh, count)
    rows = []
    for element in elements:
        start = time.perf_counter()
        model = build(mesh, element)
        modes = solve_modes(model, min(count, model.free.size - 1))
        seconds = time.perf_counter() - start
        ratio, sigma = stiffening(model, modes, limit)
        error = np.sqrt(np.maximum(1 + ratio, 0)) - 1
        spread = sigma / (2 * (1 + error))
        rows.append(
            Row(
                len(mesh.tets),
                element,
                int(model.free.size),
                seconds,
                tuple(error.tolist()),
                tuple(spread.tolist()),
            )
        )
    return rows


def study(
    cut: Callable[[int], TetMesh],
    build: Callable[[TetMesh, str], ElasticModel],
    resolutions: tuple[int, ...],
    *,
    elements: tuple[str, ...] = EVERY_ELEMENT,
    count: int = 5,
    progress: Progress | None = None,
) -> list[Row]:
    """`study_mesh` at several numbers of tetrahedra, coarsest first; `cut` makes such a mesh."""
    rows = []
    for step, asked in enumerate(sorted(resolutions)):
        if progress:
            progress(step / len(resolutions), f"{asked} tetrahedra")
        rows += study_mesh(build, cut(asked), elements, count)
    return rows


def table(rows: list[Row]) -> str:
    """The rows as text: pitch of the lowest modes against the converged one, in per cent."""
    head = (
        f"{'tets':>7} {'element':<12} {'unknowns':>9} {'seconds':>8}   too high (%), mode 1, 2, ..."
    )
    lines = [head]
    for row in rows:
        errors = "  ".join(
            f"{100 * e:+6.2f}±{100 * s:.2f}"
            for e, s in zip(row.pitch_error, row.sigma, strict=True)
        )
        cost = f"{row.unknowns:9d} {row.seconds:8.2f}"
        lines.append(f"{row.tets:7d} {row.element:<12} {cost}   {errors}")
    return "\n".join(lines)


def plot(rows: list[Row], path: Path) -> None:
    """Pitch error of the first mode against tetrahedra and against seconds."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 2, sharey=True)
    for element in dict.fromkeys(row.element for row in rows):
        mine = [row for row in rows if row.element == element]
        error = [100 * abs(row.pitch_error[0]) for row in mine]
        bars = [100 * row.sigma[0] for row in mine]
        for axis, x in zip(axes, ([r.tets for r in mine], [r.seconds for r in mine]), strict=True):
            axis.errorbar(x, error, yerr=bars, marker="o", capsize=3, label=element)
    for axis, label in zip(axes, ("tetrahedra", "seconds from mesh to modes"), strict=True):
        axis.set(xscale="log", yscale="log", xlabel=label)
        axis.axhline(2, color="0.7", linewidth=1, zorder=0)
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("first pitch off the converged one (%)")
    axes[1].legend(frameon=False)
    with written_whole(path) as draft:
        figure.savefig(draft, dpi=130)


def parse_pin(text: str, surface: Surface) -> Region:
    """A region from box=xmin,ymin,zmin,xmax,ymax,zmax, sphere=x,y,z,r or vertices=0,1,2.

    Raises CaseError, one line, for anything else.
    """
    kind, _, values = text.partition("=")
    try:
        numbers = np.array([float(value) for value in values.split(",")])
    except ValueError:
        numbers = np.zeros(0)
    if kind == "box" and numbers.size == 6:
        return Box(numbers[:3], numbers[3:])
    if kind == "sphere" and numbers.size == 4:
        return Sphere(numbers[:3], float(numbers[3]))
    if kind == "vertices" and numbers.size and (numbers == numbers.astype(int)).all():
        return vertices_region(surface, numbers.astype(int), "--pins")
    raise CaseError(
        f'--pins: "{text}"; box=xmin,ymin,zmin,xmax,ymax,zmax, sphere=x,y,z,radius or '
        "vertices=0,1,2 (m, object axes) is needed."
    )


def add_arguments(parser: ArgumentParser) -> None:
    """What `python -m core stiffening` takes."""
    parser.add_argument("mesh", type=Path, help="surface: .obj, .stl or .ply")
    parser.add_argument(
        "--pins",
        action="append",
        required=True,
        metavar="REGION",
        help="what is held: box=xmin,ymin,zmin,xmax,ymax,zmax, sphere=x,y,z,r or vertices=0,1,2",
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for table and picture")
    parser.add_argument(
        "--length-unit", default="m", choices=("m", "cm", "mm"), help="of the file (default m)"
    )
    parser.add_argument("--poisson-ratio", type=float, default=0.48, help="default 0.48")
    parser.add_argument("--elements", default="500,1500,4000", help="numbers of tetrahedra")
    parser.add_argument(
        "--modes",
        type=int,
        default=5,
        choices=range(1, 21),
        metavar="N",
        help="1 to 20 (default 5)",
    )


def stiffening_main(args: Namespace, progress: Progress | None = None) -> str:
    """Study a mesh file; write stiffening.json and stiffening.png; return the table.

    Raises CoreError, one line, for input that cannot be studied.
    """
    surface = read_surface(args.mesh, args.length_unit)
    regions = tuple(parse_pin(text, surface) for text in args.pins)
    pinned = held_vertices(surface, regions)
    material = Material(1000.0, args.poisson_ratio)  # ratios do not depend on the density
    resolutions = _resolutions(args.elements)

    def build(mesh: TetMesh, element: str) -> ElasticModel:
        return hold(assemble(mesh, material, element), surface, pinned, regions)

    held = held_part(surface, pinned, regions)

    def cut(asked: int) -> TetMesh:
        return along_rim(tetrahedralize(surface, asked)[0], held)

    rows = study(cut, build, resolutions, count=args.modes, progress=progress)
    args.out.mkdir(parents=True, exist_ok=True)
    with written_whole(args.out / "stiffening.json") as draft:
        draft.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    plot(rows, args.out / "stiffening.png")
    return table(rows)


def _resolutions(text: str) -> tuple[int, ...]:
    try:
        numbers = tuple(int(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if not numbers or min(numbers) < 1:
        raise CaseError(f'--elements: "{text}"; whole numbers such as 500,1500,4000 are needed.')
    return numbers
