"""A mesh and a material made into matrices, held, loaded, pulled and read at places.

Displacements u are (P, 3) m or flattened (3P,), x0 y0 z0 x1 ...
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from .boundary import boundary, face_points
from .data import ElasticModel, Load, Material, Surface, TetMesh, replace
from .elements import ELEMENTS
from .elements.mass import averaged, lumped
from .elements.simplex import averages, each_axis, gradients, quadrature
from .errors import DataError
from .factorization import factorize
from .interpolate import cross_blocks, gradient_at, interpolation, patch_means, rotation_operator
from .nearest import locate, nearest_face

HAIR = 0.1  # edge lengths by which meshing may move a point off the pinned part of the surface
LUMP = 7800.0  # kg/m3: what lumped masses are made of, which says how wide they sit
FEWEST = 6  # points of the skin that a lumped mass sits on at least


def assemble(
    mesh: TetMesh,
    material: Material,
    element: str = "p2",
    *,
    stiffness_scale: np.ndarray | None = None,
    mass: str = "consistent",
) -> ElasticModel:
    """The free body: stiffness at Y = 1 Pa, mass in kg, nothing held.

    `stiffness_scale` (T,) multiplies Young's modulus of each tetrahedron. `mass`: "consistent",
    "lumped" (diagonal) or "averaged" (half of both). Raises DataError for an unknown element or
    mass, or a scale that is not positive.
    """
    if element not in ELEMENTS:
        raise DataError(f'assemble: element "{element}"; one of {", ".join(ELEMENTS)} is needed.')
    scale = np.ones(len(mesh.tets)) if stiffness_scale is None else np.asarray(stiffness_scale)
    if scale.shape != (len(mesh.tets),) or not (scale > 0).all():
        raise DataError(
            f"assemble: stiffness_scale has shape {scale.shape}; one number above 0 for each of "
            f"{len(mesh.tets)} tetrahedra is needed."
        )
    masses = {"consistent": lambda M: M, "lumped": lumped, "averaged": averaged}
    if mass not in masses:
        raise DataError(f'assemble: mass "{mass}"; one of {", ".join(masses)} is needed.')
    m = ELEMENTS[element].build(mesh, scale)
    return ElasticModel(
        mesh,
        material,
        element,
        m.points,
        m.shear,
        m.bulk,
        masses[mass](m.mass) * material.density,
        np.zeros(len(m.points), bool),
    )


def hold(
    model: ElasticModel, surface: Surface, pinned_vertices: np.ndarray, regions: tuple = ()
) -> ElasticModel:
    """The body with the pinned part of the artist's surface held.

    A boundary point is held when it is nearer to the pinned triangles (all three `pinned_vertices`
    (V,) bool) than to the rest of the surface, but for a hair; when the closest point of the
    surface, or it itself, lies in a region (`contains` (n, 3) -> (n,) bool), which also serves
    triangles that straddle it; or when it is the nearest point to a pinned vertex that has no
    pinned triangle.
    Raises DataError when nothing or everything is held.
    """
    pins = np.asarray(pinned_vertices, bool)
    outside = face_points(model)
    places = model.points[outside]
    size = boundary(model.mesh).edge_length
    held = held_part(surface, pins, regions)(places, HAIR * size)
    lone = np.flatnonzero(
        pins & ~np.isin(np.arange(len(pins)), surface.faces[_whole(surface, pins, regions)])
    )
    if lone.size:
        distance, nearest = cKDTree(places).query(surface.vertices[lone])
        held[nearest[distance <= size]] = True
    return hold_points(model, outside[held])


def held_part(surface: Surface, pinned_vertices: np.ndarray, regions: tuple = ()) -> Callable:
    """(places (n, 3) m, hair m) -> (n,) bool: what `hold` holds, but for single vertices; hair is
    how far beside a pinned triangle still counts.
    """
    whole = _whole(surface, pinned_vertices, regions)

    def held(places: np.ndarray, hair: float = 0.0) -> np.ndarray:
        face, bary, gap = nearest_face(places, surface.vertices, surface.faces)
        closest = np.einsum("nk,nki->ni", bary, surface.vertices[surface.faces[face]])
        out = np.zeros(len(places), bool)
        for region in regions:
            out |= region.contains(closest) | region.contains(places)
        if whole.any():
            out |= nearest_face(places, surface.vertices, surface.faces[whole])[2] <= gap + hair
        return out

    return held


def _whole(surface: Surface, pins: np.ndarray, regions: tuple) -> np.ndarray:
    """(F,) bool: triangles that are pinned altogether."""
    whole = np.asarray(pins, bool)[surface.faces].all(axis=1)
    if regions:  # corners held at two ends do not hold the side between them
        middles = surface.vertices[surface.faces].mean(axis=1)
        whole &= np.logical_or.reduce([region.contains(middles) for region in regions])
    return whole


def hold_points(model: ElasticModel, points: np.ndarray) -> ElasticModel:
    """The body with the points of these indices held. Raises DataError for none or all of them."""
    pinned = np.zeros(len(model.points), bool)
    pinned[points] = True
    if not pinned.any():
        raise DataError(
            "Pins: they hold no point of the body. Make a pin's region larger, or move it onto "
            "the surface; coordinates are in metres, object axes."
        )
    if pinned[face_points(model)].all():
        raise DataError("Pins: they hold the whole surface, nothing can move. Make them smaller.")
    return replace(model, pinned=pinned)


def loose_motions(model: ElasticModel) -> int:
    """Rigid motions that the pins leave: 0, 1 about a line, 3 about a point, 6 without pins."""
    if not model.pinned.any():
        return 6
    places = model.points[model.pinned]
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    spread = np.append(spread, [0, 0, 0])[:2] > 1e-6 * np.ptp(model.points, axis=0).max()
    return {0: 3, 1: 1, 2: 0}[int(spread.sum())]


@dataclass(frozen=True)
class Seat:
    """How lumped masses sit, which a case does not say."""

    width: float  # of the patch under a mass, over the radius of a ball of that mass
    over_foot: bool  # reaching over an edge to where it was said to be, not in its patch's middle
    hangs: bool = False  # on a thread: it goes along with gravity's direction only


PLAIN = Seat(1.0, True)
UNKNOWN = (PLAIN, Seat(0.5, True), Seat(1.0, False))  # what is assumed, and what may be as well
HUNG = tuple(replace(seat, hangs=True) for seat in UNKNOWN)  # the same of loads that hang


def add_loads(
    model: ElasticModel,
    loads: tuple[Load, ...],
    seat: Seat = PLAIN,
    gravity: np.ndarray | None = None,
) -> ElasticModel:
    """The body with lumped masses fixed to it: M + Σ m NᵀN, N the mean motion under the load.

    gravity (3,): along which they go where they hang.
    """
    mass = model.mass
    for load in loads:
        N = load_operator(model, load, seat, gravity)
        mass = mass + load.mass * (N.T @ N)
    return replace(model, mass=mass.tocsr())


def load_operator(
    model: ElasticModel, load: Load, seat: Seat, gravity: np.ndarray | None = None
) -> sparse.csr_matrix:
    """(3, 3P): displacement (m) of a load that sits so; (1, 3P) along `gravity` where it hangs."""
    radius = seat.width * lump_radius(load.mass)
    moved = lump_operator(model, load.position[None], radius, over_foot=seat.over_foot)
    if not seat.hangs:
        return moved
    return sparse.csr_matrix(gravity / np.linalg.norm(gravity)) @ moved


def lump_radius(mass: float) -> float:
    """m, of a sphere of that mass (kg): a case says where a lump sits, and never how wide."""
    return (3 * mass / (4 * np.pi * LUMP)) ** (1 / 3)


def buried(model: ElasticModel, positions: np.ndarray, radius: float) -> np.ndarray:
    """(n,) bool: which places (n, 3) m lie deeper inside than `radius` (m)."""
    nodes, tets = model.mesh.nodes, model.mesh.tets
    depth = nearest_face(positions, nodes, boundary(model.mesh).corners)[2]
    return (locate(positions, nodes, tets)[0] >= 0) & (depth > radius)


def lump_operator(
    model: ElasticModel, positions: np.ndarray, radius: float, *, over_foot: bool = True
) -> sparse.csr_matrix:
    """(3n, 3P): as `point_operator`, of what sits on a patch of surface and turns with it.

    Under a mass on a point the body gives way without limit as the mesh gets finer, and no pitch
    converges; on a patch that all meshes share they do (Johnson, Contact Mechanics, ch. 3).
    Places (n, 3) m deeper inside than the patch's `radius` (m) keep their own motion.
    """
    x = np.asarray(positions, float).reshape(-1, 3)
    skin = boundary(model.mesh)
    face, weights, _ = nearest_face(x, model.mesh.nodes, skin.corners)
    foot = np.einsum("nk,nki->ni", weights, model.mesh.nodes[skin.corners[face]])
    on, _, areas = surface_quadrature(model)
    places = (on @ model.points.ravel()).reshape(-1, 3)
    gap = np.linalg.norm(places - foot[:, None], axis=2)
    least = 1.01 * np.partition(gap, FEWEST, axis=1)[:, FEWEST, None]
    share = areas * np.maximum(1 - (gap / np.maximum(radius, least)) ** 2, 0)
    share /= share.sum(axis=1, keepdims=True)
    turn = patch_means(skin, face, foot) @ rotation_operator(model, skin)
    lever = cross_blocks(-(x - (share @ places if over_foot else foot))) @ turn
    operator = each_axis(sparse.csr_matrix(share)) @ on + lever
    keep = sparse.diags(np.repeat(buried(model, x, radius).astype(float), 3))
    return ((operator - keep @ operator) + keep @ point_operator(model, x)).tocsr()


def point_operator(model: ElasticModel, positions: np.ndarray) -> sparse.csr_matrix:
    """(3n, 3P): displacement (m) of places (n, 3) m from those of the points.

    In the body the shape functions. Off it a place moves rigidly with the nearest piece of
    surface: u(x) = u(p) + w × (x - p), w = ½ curl u averaged over a patch of surface round p, so
    that a marker on a post beside an edge does not turn with one triangle.
    """
    x = np.asarray(positions, float).reshape(-1, 3)
    tet, bary = locate(x, model.mesh.nodes, model.mesh.tets)
    off = np.flatnonzero(tet < 0)
    skin = boundary(model.mesh)
    if not off.size:
        return interpolation(model, tet, bary)
    face, weights, _ = nearest_face(x[off], model.mesh.nodes, skin.corners)
    tet[off], bary[off] = skin.tet[face], skin.barycentric(face, weights)
    operator = interpolation(model, tet, bary)
    foot = np.einsum("nk,nki->ni", weights, model.mesh.nodes[skin.corners[face]])
    turn = patch_means(skin, face, foot) @ rotation_operator(model, skin)
    lever = cross_blocks(-(x[off] - foot)) @ turn
    spread = sparse.csr_matrix(
        (np.ones(off.size), (off, np.arange(off.size))), shape=(len(x), off.size)
    )
    return (operator + each_axis(spread) @ lever).tocsr()


def gravity_force(model: ElasticModel, g: np.ndarray) -> np.ndarray:
    """(3P,) N: the weight of body and loads under the acceleration `g` (3,) m/s2."""
    return model.mass @ np.tile(np.asarray(g, float), len(model.points))


def static(model: ElasticModel, force: np.ndarray, youngs_modulus: float) -> np.ndarray:
    """(P, 3) m: small displacement under `force` (3P,) N, or (P, 3, n) under n of them (3P, n).

    Raises DataError when nothing is held.
    """
    if loose_motions(model):
        raise DataError("static: the pins leave the body free to move as a whole. Pin an area.")
    free = model.free
    factor = factorize(model.stiffness[free][:, free], np.repeat(model.points, 3, axis=0)[free])
    u = np.zeros_like(force, float)
    u[free] = factor.solve(np.asarray(force, float)[free]) / youngs_modulus
    return u.reshape(-1, 3, *u.shape[1:])


def surface_quadrature(model: ElasticModel) -> tuple[sparse.csr_matrix, np.ndarray, np.ndarray]:
    """Points over the skin: operator (3q, 3P) to them, outward normals (q, 3), areas (q,) m2."""
    operator, normals, areas, _ = _surface_points(model)
    return operator, normals, areas


def _surface_points(model: ElasticModel):
    """As `surface_quadrature`, and the face (q,) that each point lies on."""
    skin = boundary(model.mesh)
    bary, weight = quadrature(2, 2 * ELEMENTS[model.element].degree)
    face = np.repeat(np.arange(len(skin.tet)), len(weight))
    where = skin.barycentric(face, np.tile(bary, (len(skin.tet), 1)))
    operator = interpolation(model, skin.tet[face], where)
    return operator, skin.normals[face], np.outer(skin.areas, weight).ravel(), face


def surface_springs(model: ElasticModel, held: np.ndarray) -> sparse.csr_matrix:
    """(3P, 3P) m2 = N/m per N/m3: ∫ NᵀN over the boundary triangles whose points are all `held`.

    Raises DataError when no whole triangle is held.
    """
    points = face_points(model, each=True)
    on = np.asarray(held, bool)[points].all(axis=1)
    if not on.any():
        raise DataError(
            "Pins: no whole triangle of the mesh is held, so they have no area to give. Make the "
            "pinned region larger or the mesh finer."
        )
    operator, _, areas, face = _surface_points(model)
    weight = np.repeat(areas * on[face], 3)
    out = (operator.T @ sparse.diags(weight) @ operator).tocsr()
    out.eliminate_zeros()
    return out


def geometric_stiffness(model: ElasticModel, displacement: np.ndarray) -> sparse.csr_matrix:
    """(3P, 3P) 1/m: initial-stress matrix ∫ ∇N_a·σ ∇N_b I of the linear stress of `displacement`.

    At Y = 1 Pa: multiply by the Young's modulus at which `displacement` (P, 3) m was found.
    Source: Zienkiewicz & Taylor, The Finite Element Method, vol. 2, ch. 11.
    """
    element = ELEMENTS[model.element]
    mesh, u = model.mesh, np.asarray(displacement, float)
    bary, weight = quadrature(3, max(0, 3 * (element.degree - 1)))
    volume, _ = gradients(mesh.nodes, mesh.tets)
    smoothed = None
    if element.domains or element.mixed:
        shared = element.domains(mesh)[1] if element.domains else mesh.tets
        mean, _ = averages(shared, volume)
        cells, g = gradient_at(model, np.arange(len(volume)), np.full((len(volume), 4), 0.25))
        own = np.einsum("tki,tki->t", u[cells], g)
        smoothed = (mean @ own)[shared].mean(axis=1)
    everyone, total = np.arange(len(mesh.tets)), 0
    for x, w in zip(bary, weight, strict=True):
        cells, g = gradient_at(model, everyone, np.broadcast_to(x, (len(mesh.tets), 4)))
        stress = _stress(np.einsum("tki,tkj->tij", u[cells], g), smoothed, model.material)
        total = total + (w * volume)[:, None, None] * (g @ stress @ g.transpose(0, 2, 1))
    n = cells.shape[1]
    rows, columns = np.repeat(cells, n, axis=1).ravel(), np.tile(cells, (1, n)).ravel()
    count = len(model.points)
    return each_axis(sparse.csr_matrix((total.ravel(), (rows, columns)), shape=(count, count)))


def _stress(gradient: np.ndarray, dilatation: np.ndarray | None, material: Material) -> np.ndarray:
    """Linear stress (n, 3, 3) at Y = 1 Pa of displacement gradients (n, 3, 3)."""
    nu = material.poisson_ratio
    strain = (gradient + gradient.transpose(0, 2, 1)) / 2
    trace = np.trace(strain, axis1=1, axis2=2)
    volumetric = trace if dilatation is None else dilatation
    mu, kappa = 1 / (2 * (1 + nu)), 1 / (3 * (1 - 2 * nu))
    return 2 * mu * strain + (kappa * volumetric - 2 / 3 * mu * trace)[:, None, None] * np.eye(3)
