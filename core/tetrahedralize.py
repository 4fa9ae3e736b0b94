"""A surface cut into about as many tetrahedra as were asked for."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .data import Surface, TetMesh, tet_volumes
from .errors import MeshError
from .surface import closest_point, in_morton_order, simplified
from .tet_search import WITHIN, Size, Trial, chosen, next_guess, settled
from .tetwild import Crashed, TookTooLong, run_tetwild, stop_if
from .volume_match import fitted

TRIALS = 8
LAST_CRASH = 2  # trial from which a crash is an answer, not a reason for a finer epsilon
VOLUME_TOLERANCE = 5e-3


@dataclass(frozen=True)
class TetReport:
    """How a tetrahedralization went."""

    asked: int  # tetrahedra
    tets: int
    volume_error: float | None  # (mesh - surface) / surface; None where that has none
    worst_quality: float  # 0 flat .. 1 regular, of the worst tetrahedron
    trials: int
    seconds: float

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know, one line each."""
        out = ()
        if not 1 / (1 + WITHIN) <= self.tets / self.asked <= 1 + WITHIN:
            nearer = "or more, or smooth the mesh" if self.tets > self.asked else "or less"
            out += (
                f"Tetrahedra: {self.tets} where {self.asked} were asked for, the nearest that was "
                f"reached in {self.trials} trials. Ask for {self.tets} {nearer}.",
            )
        if self.volume_error is not None and abs(self.volume_error) > VOLUME_TOLERANCE:
            out += (
                f"Tetrahedra: their volume, and so the mass, is {self.volume_error:+.1%} off the "
                "surface's. Ask for more elements.",
            )
        return out


def tetrahedralize(
    surface: Surface,
    elements: int,
    *,
    progress: Callable[[float, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    time_limit: float = 300.0,
    volume_tolerance: float = VOLUME_TOLERANCE,
) -> tuple[TetMesh, TetReport]:
    """The solid within `surface` as `elements` tetrahedra within 25 %, and how it went.

    Runs pytetwild in a child process, a few times with other edge lengths. Where the object's
    detail allows no such number, the nearest one reached; look at the report's `tets`. Not
    deterministic: keep what it returns (tets.py). Raises MeshError, one line, for a surface
    without inside, a crash, or after `time_limit` s; Cancelled soon after cancelled() is true.
    """
    if elements < 1:
        raise MeshError(f"elements: {elements}; a number of at least 1 is needed.")
    start = time.monotonic()
    size = Size.of(surface)
    trials: list[Trial] = []
    while len(trials) < TRIALS and not settled(trials, elements, volume_tolerance):
        stop_if(cancelled)
        if progress is not None:
            progress(len(trials) / (len(trials) + 2), said(trials, elements))
        edge, epsilon = next_guess(trials, elements, size)
        try:
            trials.append(
                attempt(surface, elements, size, (edge, epsilon), cancelled, start + time_limit)
            )
        except TookTooLong:
            if not any(trial.count for trial in trials):
                raise
            break
        except Crashed:
            if len(trials) >= LAST_CRASH:
                raise
            trials.append(Trial(edge, epsilon, None, None))
    best = chosen(trials, elements)
    if progress is not None:
        progress(1.0, f"{best.count} tetrahedra")
    quality = float(tet_quality(best.mesh).min())
    seconds = time.monotonic() - start
    return best.mesh, TetReport(elements, best.count, best.error, quality, len(trials), seconds)


def attempt(surface, elements, size, lengths, cancelled, deadline) -> Trial:
    """One run with `lengths` = (edge, epsilon) in m, its volume made that of the surface."""
    edge, epsilon = lengths
    nodes, tets = run_tetwild(
        thinned(surface, elements, epsilon),
        edge / size.diagonal,
        epsilon / size.diagonal,
        cancelled=cancelled,
        deadline=deadline,
    )
    mesh = solid(nodes, tets)
    if mesh is None or size.volume is None:
        return Trial(edge, epsilon, mesh, None)
    mesh = fitted(mesh, surface, size.volume)
    return Trial(edge, epsilon, mesh, mesh.volume / size.volume - 1)


def thinned(surface: Surface, elements: int, epsilon: float) -> Surface:
    """In Morton order, and without detail far below what `elements` tetrahedra can show."""
    ordered = in_morton_order(surface)
    faces = max(2 * elements, 500)
    while 2 * faces < len(surface.faces):
        fewer = simplified(ordered, faces)
        sample = surface.vertices[:: max(1, len(surface.vertices) // 2000)]
        if np.quantile(closest_point(fewer, sample)[2], 0.95) < epsilon:
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
