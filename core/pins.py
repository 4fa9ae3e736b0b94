"""Where an object is held: regions of space, meant on its surface."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .data import Surface, seal
from .errors import CaseError
from .surface import bounding_box, closest_point, diagonal

THIN = 1e-4  # of the object's diagonal: what holds less across is a line, or a point
HAIR = 1e-6  # of the object's diagonal: what rounding of units and of file formats can move


@dataclass(frozen=True, eq=False)
class Box:
    """All places with min <= x <= max, object axes."""

    min: np.ndarray  # (3,) m
    max: np.ndarray  # (3,) m
    hair: float = 0.0  # m, how far outside still counts

    def __post_init__(self):
        seal(self, "min", float, (3,))
        seal(self, "max", float, (3,))

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(n,) bool: which of `points` (n, 3) m are held."""
        x = np.asarray(points, float)
        return ((x >= self.min - self.hair) & (x <= self.max + self.hair)).all(axis=-1)

    def meets(self, surface: Surface) -> bool:
        """Whether any part of the surface is held: separating axes of box and triangle, exact.

        Source: T. Akenine-Moeller, Fast 3D triangle-box overlap testing, JGT 6(1), 2001.
        """
        if self.contains(surface.vertices[surface.faces]).any():
            return True
        half = (self.max - self.min) / 2 + self.hair
        corner = surface.vertices[surface.faces] - (self.min + self.max) / 2  # (F, 3, 3)
        edge = np.roll(corner, -1, axis=1) - corner
        unit = np.broadcast_to(np.eye(3), corner.shape)
        across = np.cross(edge[:, :, None], np.eye(3)).reshape(-1, 9, 3)
        normal = np.cross(edge[:, 0], edge[:, 1])[:, None]
        axis = np.concatenate([unit, across, normal], axis=1)  # (F, 13, 3)
        shadow = axis @ corner.transpose(0, 2, 1)  # (F, 13, corner)
        reach = np.abs(axis) @ half
        return bool(((shadow.max(2) >= -reach) & (shadow.min(2) <= reach)).all(axis=1).any())


@dataclass(frozen=True, eq=False)
class Sphere:
    """All places no further than `radius` from `centre`."""

    centre: np.ndarray  # (3,) m
    radius: float  # m
    hair: float = 0.0  # m, how far outside still counts

    def __post_init__(self):
        seal(self, "centre", float, (3,))

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(n,) bool: which of `points` (n, 3) m are held."""
        away = np.linalg.norm(np.asarray(points, float) - self.centre, axis=-1)
        return away <= self.radius + self.hair

    def meets(self, surface: Surface) -> bool:
        """Whether any part of the surface is held."""
        return bool(closest_point(surface, self.centre)[2][0] <= self.radius + self.hair)


@dataclass(frozen=True, eq=False)
class Vertices:
    """Named vertices of the surface, and the triangles that have all three corners among them."""

    indices: np.ndarray  # (k,) rows of the surface's vertices
    patch: Surface  # all vertices, and those triangles
    hair: float = 0.0  # m, how far off still counts

    def __post_init__(self):
        seal(self, "indices", int, (None,))

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(n,) bool: which of `points` (n, 3) m are held."""
        x = np.asarray(points, float)
        away = cKDTree(self.patch.vertices[self.indices]).query(x)[0]
        corner = self.patch.vertices[self.patch.faces]
        longest = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(initial=0)
        near = np.flatnonzero((away > self.hair) & (away <= longest + self.hair))
        if len(near) and longest > 0:  # further than an edge from all corners is off the patch
            away[near] = np.minimum(away[near], closest_point(self.patch, x[near])[2])
        return away <= self.hair

    def meets(self, surface: Surface) -> bool:
        """Whether any part of the surface is held: named vertices always are."""
        return True


Region = Box | Sphere | Vertices


def vertices_region(surface: Surface, indices: np.ndarray, where: str) -> Vertices:
    """The region of the surface's vertices `indices` (k,). Raises CaseError for one not there."""
    count = len(surface.vertices)
    if indices.max() >= count:
        raise CaseError(
            f"{where} vertices: {indices.max()} does not exist, the mesh has {count}; 0 to "
            f"{count - 1} are needed. Count from 0."
        )
    chosen = np.zeros(count, bool)
    chosen[indices] = True
    whole = surface.faces[chosen[surface.faces].all(axis=1)]
    return Vertices(indices, Surface(surface.vertices, whole), HAIR * diagonal(surface))


def _check_wide(surface: Surface, region: Region, name: str) -> None:
    """Raises CaseError where what `region` holds of the surface lies on one line or point."""
    inside = surface.vertices[region.contains(surface.vertices)]
    if not _spans(inside, surface) and not isinstance(region, Vertices):
        inside = np.concatenate([inside, _places_held(surface, region)])
    if _spans(inside, surface):
        return
    single = len(inside) < 2 or np.ptp(inside, axis=0).max() < THIN * diagonal(surface)
    what = "a single place" if single else "one line"
    raise CaseError(
        f"{name} holds {what} of the surface only; three vertices that are not on one line, or "
        "a patch of it, are needed. Make the region larger."
    )


def _spans(points: np.ndarray, surface: Surface) -> bool:
    """Whether `points` (n, 3) m are off one line by more than THIN of the surface's diagonal."""
    if len(points) < 3:
        return False
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(extent[1] > THIN * diagonal(surface))


def _places_held(surface: Surface, region: Box | Sphere) -> np.ndarray:
    """(n, 3) m, places of the surface within `region`: on a grid, and nearest to its inside."""
    low, high = bounding_box(surface)
    if isinstance(region, Sphere):
        low = np.maximum(low, region.centre - region.radius)
        high = np.minimum(high, region.centre + region.radius)
    else:
        low, high = np.maximum(low, region.min), np.minimum(high, region.max)
    steps = np.linspace(0, 1, 7)
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    near = closest_point(surface, low + grid * (high - low))[0]
    points = np.concatenate([near, spread(surface).reshape(-1, 3)])
    return points[region.contains(points)]


def held_vertices(surface: Surface, regions: tuple[Region, ...]) -> np.ndarray:
    """(V,) bool: vertices of the surface within any region.

    Raises CaseError when a region meets no part of the surface, or only a line or a point of it
    (which holds a solid the less, the finer its mesh), or all of it is held. A box that
    cuts a large triangle between its corners holds something, though no vertex.
    """
    for k, region in enumerate(regions):
        if not region.meets(surface):
            low, high = bounding_box(surface)
            raise CaseError(
                f"[[pin]] {k + 1} holds nothing: no part of the surface is in it. The object "
                f"reaches from {_place(low)} to {_place(high)} m. Move the region, or check "
                "length_unit."
            )
        _check_wide(surface, region, f"[[pin]] {k + 1}")
    held = np.zeros(len(surface.vertices), bool)
    covered = np.zeros(len(surface.faces), bool)
    points = spread(surface)  # (F, w, 3)
    covering = np.zeros(points.shape[:2], bool)
    for region in regions:
        if isinstance(region, Vertices):  # exact and quick: no search for the nearest triangle
            held[region.indices] = True
            covered |= np.isin(surface.faces, region.indices).all(axis=1)
        else:
            held |= region.contains(surface.vertices)
            covering |= region.contains(points)
    if (covered | covering.all(axis=1)).all() and held[np.unique(surface.faces)].all():
        raise CaseError(
            "[[pin]]: the whole surface is held, nothing is left to move. Make the regions "
            "smaller, or check length_unit."
        )
    return held


def spread(surface: Surface) -> np.ndarray:
    """Points (F, w, 3) m on a regular grid inside each triangle: about 20,000 in all, or F."""
    order = int(np.clip(np.sqrt(40_000 / len(surface.faces)), 1, 60))
    i, j = np.divmod(np.arange(order * order), order)
    i, j = i[i + j < order], j[i + j < order]
    u, v = (i + 1 / 3) / order, (j + 1 / 3) / order
    weight = np.stack([1 - u - v, u, v], axis=1)
    return np.einsum("wc,fcx->fwx", weight, surface.vertices[surface.faces])


def _place(x: np.ndarray) -> str:
    return "(" + ", ".join(f"{one:.4g}" for one in x) + ")"
