"""A surface: read, measured, put in order and thinned."""

from pathlib import Path

import numpy as np

from .data import Surface
from .errors import DataError, MeshError
from .nearest import nearest_face
from .surface_files import read_triangles

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


def read_surface(path: Path | str, length_unit: str = "m") -> Surface:
    """The mesh file `path` (.obj, .stl, .ply) in metres; `length_unit` is "m", "cm" or "mm".

    Vertices keep the file's order (.stl: equal corners welded, in order of appearance). Open,
    dirty and self-intersecting surfaces are fine. Raises MeshError, one line, for a file that is
    absent, empty, not a mesh, without faces or area, or with numbers that are not finite.
    """
    path = Path(path)
    if length_unit not in METRES:
        raise MeshError(f'length_unit: "{length_unit}"; "m", "cm" or "mm" is needed.')
    vertices, faces = read_triangles(path)
    if not len(faces):
        raise MeshError(
            f"{path.name}: {len(vertices)} vertices and no faces; a surface is needed. "
            "Export the mesh with its faces."
        )
    if not np.isfinite(vertices).all():
        raise MeshError(f"{path.name}: some coordinates are not finite numbers. Export it again.")
    try:
        surface = Surface(METRES[length_unit] * vertices, faces)
    except DataError as error:
        raise MeshError(f"{path.name}: {error} Export the mesh again.") from error
    if not encloses_something(surface):
        raise MeshError(
            f"{path.name}: its faces enclose no volume (all in one plane or at one place); "
            "a solid is needed. Give it thickness."
        )
    return surface


def encloses_something(surface: Surface) -> bool:
    """Whether the vertices that faces use are not all in one plane."""
    used = surface.vertices[np.unique(surface.faces)]
    spread = np.linalg.svd(used - used.mean(axis=0), compute_uv=False)
    return bool(spread[0] > 0 and spread[2] > 1e-9 * spread[0])


def bounding_box(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner (3,), (3,) m of what the faces use."""
    used = surface.vertices[np.unique(surface.faces)]
    return used.min(axis=0), used.max(axis=0)


def diagonal(surface: Surface) -> float:
    """Length of the bounding box's diagonal, m."""
    low, high = bounding_box(surface)
    return float(np.linalg.norm(high - low))


def face_areas(surface: Surface) -> np.ndarray:
    """(F,) m2"""
    a, b, c = (surface.vertices[surface.faces[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def enclosed_volume(surface: Surface) -> float:
    """Volume by the divergence theorem, m3; positive whichever way the faces look.

    Meaningful for a closed surface whose faces agree on what is outside.
    """
    origin = surface.vertices[surface.faces].mean(axis=(0, 1))
    a, b, c = (surface.vertices[surface.faces[:, i]] - origin for i in range(3))
    return abs(float(np.einsum("fi,fi->", np.cross(a, b), c))) / 6


def is_closed(surface: Surface) -> bool:
    """Whether every edge is met by two faces that run along it in opposite ways."""
    faces = surface.faces
    here = np.sort(faces, axis=1)
    faces = faces[(here[:, 0] != here[:, 1]) & (here[:, 1] != here[:, 2])]
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    count = len(surface.vertices)
    forward = np.sort(edges[:, 0] * count + edges[:, 1])
    backward = np.sort(edges[:, 1] * count + edges[:, 0])
    return bool(len(forward)) and np.array_equal(forward, backward)


def closest_point(surface: Surface, points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closest places of the surface to `points` (n, 3) m: (n, 3) m, their face (n,), distance m."""
    points = np.asarray(points, float).reshape(-1, 3)
    face, weights, distance = nearest_face(points, surface.vertices, surface.faces)
    corners = surface.vertices[surface.faces[face]]
    return np.einsum("nk,nki->ni", weights, corners), face, distance


def morton_codes(points: np.ndarray) -> np.ndarray:
    """(n,) place of each point (n, 3) on a Z-order curve through their box, 21 bits an axis."""
    low, size = points.min(axis=0), max(float(np.ptp(points, axis=0).max()), 1e-300)
    x = np.minimum((points - low) / size * (1 << 21), (1 << 21) - 1).astype(np.uint64)
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x[:, 0] | (x[:, 1] << np.uint64(1)) | (x[:, 2] << np.uint64(2))


def in_morton_order(surface: Surface) -> Surface:
    """The same surface, vertices and faces along a Z-order curve, unused vertices dropped.

    fTetWild's Python wrapper leaves out the reordering that its own program does; a scan with
    scattered indices takes ten times longer without.
    """
    used = np.unique(surface.faces)
    order = used[np.argsort(morton_codes(surface.vertices[used]), kind="stable")]
    place = np.zeros(len(surface.vertices), int)
    place[order] = np.arange(len(order))
    vertices, faces = surface.vertices[order], place[surface.faces]
    centres = vertices[faces].mean(axis=1)
    return Surface(vertices, faces[np.argsort(morton_codes(centres), kind="stable")])


def simplified(surface: Surface, faces: int) -> Surface:
    """About `faces` triangles of the same shape, by quadric edge collapse (fast-simplification).

    Raises MeshError when the package is not there.
    """
    if faces >= len(surface.faces):
        return surface
    try:
        import fast_simplification
    except ImportError as error:
        raise MeshError(
            "fast-simplification is not installed. Install the package, or decimate the mesh."
        ) from error
    vertices, kept = fast_simplification.simplify(
        np.array(surface.vertices),
        np.array(surface.faces, np.int32),
        target_count=faces,
    )
    return Surface(vertices, kept) if len(kept) else surface
