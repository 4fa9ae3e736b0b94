"""The search for an edge length and an epsilon that give the number of tetrahedra asked for."""

from dataclasses import dataclass

import numpy as np

from .data import Surface, TetMesh
from .errors import MeshError
from .surface import diagonal, enclosed_volume, face_areas, is_closed
from .volume_match import has_inside, solid_volume

WITHIN = 0.25  # of the number asked for
GOOD_ENOUGH = 0.2  # stops the search: the next run would scatter as far
PATIENCE = 3  # runs after which any number within `WITHIN` will do


@dataclass(frozen=True)
class Size:
    """What of a surface decides how many tetrahedra it takes."""

    diagonal: float  # m
    area: float  # m2
    volume: float | None  # m3, None where the surface is open or overlaps itself
    thickness: float  # m, of a plate with this volume and area

    @classmethod
    def of(cls, surface: Surface) -> "Size":
        """Raises MeshError for a sheet."""
        area = float(face_areas(surface).sum())
        closed = is_closed(surface)
        if not closed and not has_inside(surface):
            raise MeshError(
                "Tetrahedralization: the surface is a sheet and encloses nothing. "
                "Give it thickness, or close it."
            )
        volume = solid_volume(surface) if closed else None
        return cls(diagonal(surface), area, volume, 2 * enclosed_volume(surface) / area)


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
    """Edge length and epsilon, m; pytetwild makes 8 V / l^3 within and 6 A / l^2 outside."""
    edges = np.geomspace(1e-3, 0.5, 400) * size.diagonal
    count = 4 * size.area * size.thickness / edges**3 + 6 * size.area / edges**2
    edge = float(np.interp(-np.log(elements), -np.log(count), edges))
    return edge, float(np.clip(0.08 * edge, 2e-4 * size.diagonal, thin_enough(size, 0.2)))


def thin_enough(size: Size, share: float) -> float:
    """The largest epsilon (m) for a plate of this thickness; well above it fTetWild crashes."""
    return max(share * size.thickness, 3e-4 * size.diagonal)


def next_guess(trials: list[Trial], elements: int, size: Size) -> tuple[float, float]:
    """Edge length and epsilon, m, from the runs so far: count ~ edge^-p, p from the last two."""
    if not trials:
        return first_guess(size, elements)
    last = trials[-1]
    if last.count == 0:
        return 0.7 * last.edge, 0.5 * last.epsilon
    if off(last, elements) < GOOD_ENOUGH:
        return 1.1 * last.edge, 0.5 * last.epsilon  # the volume is what was wrong
    ratio, most = last.epsilon / last.edge, thin_enough(size, 0.35)
    if detail_drives(trials, elements):
        return last.edge, min(2 * last.epsilon, most)
    solids = [t for t in trials if t.count]
    above = [t for t in solids if t.count >= elements]
    below = [t for t in solids if t.count < elements]
    if above and below:
        a, b = min(above, key=lambda t: t.count), max(below, key=lambda t: t.count)
        share = np.log(a.count / elements) / np.log(a.count / b.count)
        edge = float(a.edge ** (1 - share) * b.edge**share)
        return edge, min(float(a.epsilon ** (1 - share) * b.epsilon**share), most)
    step = (last.count / elements) ** (1 / np.clip(power(trials), 1.5, 4))
    edge = float(min(last.edge * np.clip(step, 0.4, 1.8), 0.9 * size.diagonal))
    return edge, min(ratio * edge, max(last.epsilon, thin_enough(size, 0.2)))


def power(trials: list[Trial]) -> float:
    """p of count ~ edge^-p from the last two runs; 2.5 before there are two."""
    solids = [t for t in trials if t.count]
    a, b = solids[-2:] if len(solids) > 1 else (solids[-1], solids[-1])
    return 2.5 if a.edge == b.edge else float(-np.log(b.count / a.count) / np.log(b.edge / a.edge))


def detail_drives(trials: list[Trial], elements: int) -> bool:
    """Whether there are too many although the edge grew: the surface's detail asks for them."""
    counts = [t.count for t in trials if t.count]
    return len(counts) > 1 and min(counts) > elements and power(trials) < 0.7


def stuck(trials: list[Trial], elements: int) -> bool:
    """Whether neither edge nor epsilon takes any tetrahedra away: three runs within a tenth."""
    counts = [t.count for t in trials[-3:] if t.count]
    return len(counts) == 3 and min(counts) > elements and max(counts) < 1.1 * min(counts)


def off(trial: Trial, elements: int) -> float:
    """How far its count is from the number asked for, as a ratio minus 1."""
    return np.inf if not trial.count else max(trial.count / elements, elements / trial.count) - 1


def settled(trials: list[Trial], elements: int, tolerance: float) -> bool:
    """Whether some run has the count and the volume, or no more can be had."""
    near = GOOD_ENOUGH if len(trials) < PATIENCE else WITHIN
    fits = any(off(t, elements) <= near and right(t, tolerance) for t in trials)
    return fits or stuck(trials, elements)


def right(trial: Trial, tolerance: float) -> bool:
    """Whether its volume, where there is one to compare with, is that of the surface."""
    return trial.error is None or abs(trial.error) <= tolerance


def chosen(trials: list[Trial], elements: int) -> Trial:
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
