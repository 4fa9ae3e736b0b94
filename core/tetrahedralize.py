"""A surface cut into about as many tetrahedra as were asked for."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .data import Surface, TetMesh, tet_volumes
from .errors import MeshError
from .surface import (
    closest_point,
    diagonal,
    enclosed_volume,
    face_areas,
    in_morton_order,
    is_closed,
    simplified,
)
from .tetwild import run_tetwild

WITHIN = 0.25  # of the number asked for
GOOD_ENOUGH = 0.2  # stops the search; the tetrahedralizer scatters by some per cent anyway
TRIALS = 10


@dataclass(frozen=True)
class TetReport:
    """How a tetrahedralization went."""

    asked: int  # tetrahedra
    tets: int
    volume_error: float | None  # (mesh - surface) / surface; None for a surface that is not closed
    worst_quality: float  # 0 flat .. 1 regular, of the worst tetrahedron
    trials: int
    seconds: float


def tetrahedralize(
    surface: Surface,
    elements: int,
    *,
    progress: Callable[[float, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    time_limit: float = 300.0,
    volume_tolerance: float = 5e-3,
) -> tuple[TetMesh, TetReport]:
    """The solid within `surface` as `elements` tetrahedra within 25 %, and how it went.

    Runs pytetwild in a child process, a few times with other edge lengths. Where the object's
    detail allows no such number, the nearest one reached; look at the report's `tets`. Not
    deterministic: keep what it returns (`save_tets`). Raises MeshError, one line, for a surface
    without inside, a crash, or after `time_limit` s; Cancelled soon after cancelled() is true.
    """
    if elements < 1:
        raise MeshError(f"elements: {elements}; a number of at least 1 is needed.")
    start = time.monotonic()
    size = Size.of(surface)
    edge, epsilon = first_guess(size, elements)
    trials: list[Trial] = []
    while len(trials) < TRIALS and not settled(trials, elements, volume_tolerance):
        if progress is not None:
            progress(len(trials) / (len(trials) + 2), said(trials, elements))
        if trials:
            edge, epsilon = next_guess(trials, elements, size, volume_tolerance)
        nodes, tets = run_tetwild(
            thinned(surface, elements, epsilon),
            edge / size.diagonal,
            epsilon / size.diagonal,
            cancelled=cancelled,
            deadline=start + time_limit,
        )
        mesh = solid(nodes, tets)
        trials.append(Trial(edge, epsilon, mesh, volume_error(mesh, size.volume)))
    best = chosen(trials, elements, volume_tolerance)
    if progress is not None:
        progress(1.0, f"{best.count} tetrahedra")
    quality = float(tet_quality(best.mesh).min())
    seconds = time.monotonic() - start
    return best.mesh, TetReport(elements, best.count, best.error, quality, len(trials), seconds)


@dataclass(frozen=True)
class Size:
    """What of a surface decides how many tetrahedra it takes."""

    diagonal: float  # m
    area: float  # m2
    volume: float | None  # m3, None where the surface is not closed
    thickness: float  # m, of a plate with this volume and area

    @classmethod
    def of(cls, surface: Surface) -> "Size":
        area, volume = float(face_areas(surface).sum()), enclosed_volume(surface)
        closed = is_closed(surface) and volume > 0
        return cls(diagonal(surface), area, volume if closed else None, 2 * volume / area)


@dataclass(frozen=True)
class Trial:
    """One run: edge length and epsilon in m, what came out (None: nothing), its volume error."""

    edge: float
    epsilon: float
    mesh: TetMesh | None
    error: float | None

    @property
    def count(self) -> int:
        return len(self.mesh.tets) if self.mesh else 0


def first_guess(size: Size, elements: int) -> tuple[float, float]:
    """Edge length and epsilon, m; pytetwild makes 8 V / l^3 within and A / l^2 at the surface."""
    edges = np.geomspace(1e-3, 0.5, 400) * size.diagonal
    count = 4 * size.area * size.thickness / edges**3 + size.area / edges**2
    edge = float(np.interp(-np.log(elements), -np.log(count), edges))
    return edge, float(np.clip(0.06 * edge, 2e-4 * size.diagonal, thin_enough(size, 0.1)))


def thin_enough(size: Size, share: float) -> float:
    """The largest epsilon (m) for a plate of this thickness; well above it fTetWild crashes."""
    return max(share * size.thickness, 3e-4 * size.diagonal)


def next_guess(
    trials: list[Trial], elements: int, size: Size, tolerance: float
) -> tuple[float, float]:
    """Edge length and epsilon, m, from the runs so far: count ~ edge^-p, p from the last two."""
    last = trials[-1]
    if last.count == 0:
        return 0.7 * last.edge, 0.5 * last.epsilon
    if off(last, elements) < GOOD_ENOUGH:
        return 1.1 * last.edge, 0.5 * last.epsilon  # the volume is what was wrong
    same = [t for t in trials if t.epsilon == last.epsilon and t.count]
    above = [t for t in same if t.count >= elements]
    below = [t for t in same if t.count < elements]
    if above and below:
        a, b = min(above, key=lambda t: t.count), max(below, key=lambda t: t.count)
        share = np.log(a.count / elements) / np.log(a.count / b.count)
        return float(a.edge ** (1 - share) * b.edge**share), last.epsilon
    power = 2.5
    if len(same) > 1 and same[-1].edge != same[-2].edge:
        power = -np.log(same[-1].count / same[-2].count) / np.log(same[-1].edge / same[-2].edge)
    epsilon, most = last.epsilon, thin_enough(size, 0.25)
    if power < 0.7 and last.count > elements and epsilon < most:
        return last.edge, min(2 * epsilon, most)  # detail, not edge length, drives the count
    step = (last.count / elements) ** (1 / np.clip(power, 1, 4))
    return float(min(last.edge * np.clip(step, 0.3, 3), 0.9 * size.diagonal)), epsilon


def off(trial: Trial, elements: int) -> float:
    """How far its count is from the number asked for, as a ratio minus 1."""
    return np.inf if not trial.count else max(trial.count / elements, elements / trial.count) - 1


def settled(trials: list[Trial], elements: int, tolerance: float) -> bool:
    """Whether some run has the count and the volume."""
    return any(off(t, elements) < GOOD_ENOUGH and right(t, tolerance) for t in trials)


def right(trial: Trial, tolerance: float) -> bool:
    """Whether its volume, where there is one to compare with, is that of the surface."""
    return trial.error is None or abs(trial.error) <= tolerance


def chosen(trials: list[Trial], elements: int, tolerance: float) -> Trial:
    """Within the count the best volume, else the nearest count. Raises MeshError without any."""
    solids = [t for t in trials if t.count]
    if not solids:
        raise MeshError(
            "Tetrahedralization: the surface encloses nothing that could be filled. "
            "Give it thickness, or close its holes."
        )
    fitting = [t for t in solids if max(t.count / elements, elements / t.count) <= 1 + WITHIN]
    if fitting:
        return min(fitting, key=lambda t: abs(t.error or 0))
    return min(solids, key=lambda t: off(t, elements))


def thinned(surface: Surface, elements: int, epsilon: float) -> Surface:
    """In Morton order, and without detail far below what `elements` tetrahedra can show."""
    ordered = in_morton_order(surface)
    faces = max(4 * elements, 2000)
    while 2 * faces < len(surface.faces):
        fewer = simplified(ordered, faces)
        sample = surface.vertices[:: max(1, len(surface.vertices) // 2000)]
        if closest_point(fewer, sample)[2].max() < epsilon:
            return in_morton_order(fewer)
        faces *= 2
    return ordered


def solid(nodes: np.ndarray, tets: np.ndarray) -> TetMesh | None:
    """Positive tetrahedra and the nodes that they use; None where there are none."""
    tets = tets[tet_volumes(nodes, tets) > 0] if len(tets) else tets
    if not len(tets):
        return None
    used, tets = np.unique(tets, return_inverse=True)
    return TetMesh(nodes[used], tets.reshape(-1, 4))


def volume_error(mesh: TetMesh | None, volume: float | None) -> float | None:
    """(mesh - surface) / surface, None where one of them has no volume."""
    return None if mesh is None or volume is None else mesh.volume / volume - 1


def tet_quality(mesh: TetMesh) -> np.ndarray:
    """(T,) 12 (3 V)^(2/3) / sum of squared edges: 1 regular, 0 flat (Liu & Joe, BIT 34, 1994)."""
    edges = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
    corners = mesh.nodes[mesh.tets]
    squares = ((corners[:, edges[:, 0]] - corners[:, edges[:, 1]]) ** 2).sum(axis=(1, 2))
    return 12 * (3 * tet_volumes(mesh.nodes, mesh.tets)) ** (2 / 3) / squares


def said(trials: list[Trial], elements: int) -> str:
    """One line for a progress bar."""
    before = f"{trials[-1].count} so far, " if trials else ""
    return f"cutting into tetrahedra: {before}{elements} wanted"
