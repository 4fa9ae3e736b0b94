"""From Blender: the object as the calibration sees it, in metres and its own axes."""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ..core.data import Surface
from ..core.errors import MeshError
from . import marks


@dataclass(frozen=True, eq=False)
class Axes:
    """world = place + unit^-1 turn (stretch local), split by polar decomposition.

    The case's axes are the object's own, unturned; its lengths are true ones.
    """

    stretch: np.ndarray  # (3, 3) metres per local unit, without rotation
    turn: np.ndarray  # (3, 3) proper rotation, case axes to world axes
    place: np.ndarray  # (3,) world units, where the object's origin is
    unit: float  # metres per world unit

    @property
    def local(self) -> np.ndarray:
        """(3, 3) local units per metre."""
        return np.linalg.inv(self.stretch)

    def to_world(self, metres: np.ndarray) -> np.ndarray:
        """Places (n, 3) of the case in world units."""
        return self.place + metres @ self.turn.T / self.unit

    def from_world(self, places: np.ndarray) -> np.ndarray:
        """Places (n, 3) in world units as the case's metres."""
        return (np.asarray(places, float) - self.place) @ self.turn * self.unit


def axes(obj: bpy.types.Object, scene: bpy.types.Scene) -> Axes:
    """How the object's coordinates become metres: scale, parents and the scene's unit together.

    Raises MeshError when a scale of zero leaves the object without volume.
    """
    settings = scene.unit_settings
    unit = settings.scale_length if settings.system != "NONE" else 1.0
    matrix = np.array(obj.matrix_world, float)
    left, size, right = np.linalg.svd(matrix[:3, :3])
    if size.min() <= 1e-9 * max(size.max(), 1e-30):
        raise MeshError(f'Object "{obj.name}": its scale is 0 along an axis. Give it a scale.')
    turn = left @ right
    stretch = unit * (right.T * size) @ right
    if np.linalg.det(turn) < 0:  # a mirrored object: the mirror belongs to the shape
        turn, stretch = -turn, -stretch
    return Axes(stretch, turn, matrix[:3, 3], unit)


def surface(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Surface:
    """The object's evaluated rest shape in metres: its modifiers on, what Ringdown baked off.

    Raises MeshError when it is not a mesh or has no faces.
    """
    if obj.type != "MESH":
        raise MeshError(f'Object "{obj.name}": it is a {obj.type.lower()}; a mesh is needed.')
    with marks.silenced(obj):
        depsgraph.update()
        evaluated = obj.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh()
        try:
            found = axes(obj, depsgraph.scene)
            vertices, faces = _arrays(mesh)
        finally:
            evaluated.to_mesh_clear()
    depsgraph.update()
    if not len(faces):
        raise MeshError(f'Object "{obj.name}": it has no faces. Pick a mesh with a surface.')
    return Surface(vertices @ found.stretch.T, faces)


def pinned(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> np.ndarray:
    """(V,) bool: vertices of the evaluated rest shape that the pins hold by half or more."""
    with marks.silenced(obj):
        depsgraph.update()
        evaluated = obj.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh()
        try:
            return held(obj, mesh)
        finally:
            evaluated.to_mesh_clear()


def held(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> np.ndarray:
    """(V,) bool for the vertices of `mesh`, which has the object's vertex groups."""
    found = np.zeros(len(mesh.vertices), bool)
    group = obj.vertex_groups.get(obj.ringdown.pins)
    if group is not None:
        found[:] = [
            any(g.group == group.index and g.weight >= 0.5 for g in vertex.groups)
            for vertex in mesh.vertices
        ]
    return found


def _arrays(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    mesh.calc_loop_triangles()
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", vertices)
    faces = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", faces)
    return vertices.reshape(-1, 3).astype(float), faces.reshape(-1, 3)


def rest(obj: bpy.types.Object) -> np.ndarray:
    """(V, 3) local coordinates of the mesh itself, before shape keys and modifiers."""
    keys = obj.data.shape_keys
    points = keys.reference_key.points if keys else obj.data.vertices
    found = np.empty(3 * len(points), np.float32)
    points.foreach_get("co", found)
    return found.reshape(-1, 3)


def attachment(obj: bpy.types.Object, calibrated: Surface, found: Axes) -> tuple:
    """Which three calibrated vertices each vertex of the mesh follows (V, 3), and its shares.

    Equal counts are the same vertices; else (a subdivision changed them) each follows the nearest
    place of the surface.
    """
    points = rest(obj)
    if len(points) == len(calibrated.vertices):
        rows = np.repeat(np.arange(len(points))[:, None], 3, axis=1)
        return rows, np.tile([1.0, 0.0, 0.0], (len(points), 1))
    return nearest(calibrated, points @ found.stretch.T)


def nearest(target: Surface, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows (n, 3) of the triangle nearest to each place (n, 3) m, and its shares (n, 3)."""
    tree = BVHTree.FromPolygons(target.vertices.tolist(), target.faces.tolist())
    hits = [tree.find_nearest(Vector(place)) for place in places.tolist()]
    rows = target.faces[[hit[2] for hit in hits]]
    foot = np.array([hit[0] for hit in hits])
    a, b, c = (target.vertices[rows[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.maximum((normal**2).sum(axis=1), 1e-300)
    v = (np.cross(foot - a, c - a) * normal).sum(axis=1) / area
    w = (np.cross(b - a, foot - a) * normal).sum(axis=1) / area
    return rows, np.stack([1 - v - w, v, w], axis=1)
