"""The polygon's lowest modes and the triangle's holding force, as meshes get finer.

The triangle has sides of 1; its top is moved by (0.2, 0.1), its two lower corners are held, all
other nodes are free, strain is plane and Y = 1: with these the published forces come out.
"""

import numpy as np

from .eigen import lowest_eigenpairs
from .elements.linear import laplacian, scalar_mass, stiffness
from .elements.simplex import each_axis
from .factorization import factorize
from .plane_mesh import polygon_mesh, refined

POLYGON = np.array(  # the demonstration of distmesh
    [
        *((-0.4, -0.5), (0.4, -0.2), (0.4, -0.7), (1.5, -0.4), (0.9, 0.1)),
        *((1.6, 0.8), (0.5, 0.5), (0.2, 1.0), (0.1, 0.4), (-0.7, 0.7)),
    ]
)
EDGES = (0.20, 0.15, 0.10, 0.05)
NU = 0.48
TRIANGLE = np.array([(0, 0), (1, 0), (0.5, np.sqrt(0.75))])
MOVED = np.array([0.2, 0.1])


def widest_corner(polygon: np.ndarray) -> float:
    """The largest inner angle, rad; corners run counter-clockwise."""
    before, after = np.roll(polygon, 1, axis=0) - polygon, np.roll(polygon, -1, axis=0) - polygon
    turn = np.arctan2(*before.T[::-1]) - np.arctan2(*after.T[::-1])
    return float((turn % (2 * np.pi)).max())


def scalar_modes(nodes: np.ndarray, cells: np.ndarray, count: int):
    """Eigenvalues (m,) and vectors (N, m) of -∇²u = λu on a free body."""
    return lowest_eigenpairs(laplacian(nodes, cells), scalar_mass(nodes, cells), count, nodes)


def plane_strain_modes(nodes: np.ndarray, cells: np.ndarray, count: int):
    """Eigenvalues (m,) and vectors (2N, m) of the free body, Y = ρ = 1, ν = 0.48."""
    mass = each_axis(scalar_mass(nodes, cells), 2)
    return lowest_eigenpairs(stiffness(nodes, cells, NU), mass, count, np.repeat(nodes, 2, axis=0))


def extrapolate(coarse: float, fine: float, power: float) -> float:
    """Limit of values with an error as h^power, from h and h/2."""
    return fine - (coarse - fine) / (2**power - 1)


def study_polygon() -> tuple[dict, dict]:
    """Numbers, and for drawing {h: (nodes, cells, lowest elastic mode (N, 2))}."""
    rows, drawn = [], {}
    for h in EDGES:
        nodes, cells = polygon_mesh(POLYGON, h)
        scalar = scalar_modes(nodes, cells, 2)[0][1]  # after the constant
        values, vectors = plane_strain_modes(nodes, cells, 4)  # after three rigid motions
        drawn[h] = nodes, cells, vectors[:, 3].reshape(-1, 2)
        rows.append({"h": h, "triangles": len(cells), "scalar": scalar, "elastic": values[3]})
    nested, mesh = [], drawn[0.10][:2]
    for _ in range(4):
        nested.append(float(scalar_modes(*mesh, 2)[0][1]))
        mesh = refined(*mesh)
    power = 2 * np.pi / widest_corner(POLYGON)
    a, b, c = nested[-3:]
    return {
        "table": [{k: float(v) if k != "triangles" else v for k, v in r.items()} for r in rows],
        "nested_scalar": nested,
        "widest_corner_degrees": float(np.degrees(widest_corner(POLYGON))),
        "power_of_h": float(power),
        "power_measured": float(np.log2((a - b) / (b - c))),
        "scalar_limit": extrapolate(b, c, power),
    }, drawn


def holding_force(nodes: np.ndarray, cells: np.ndarray, nu: float):
    """Force (2,) per unit of depth that keeps node 2 moved, nodes 0 and 1 held; and u (N, 2)."""
    K = stiffness(nodes, cells, nu).tocsr()
    held, u = np.arange(6), np.zeros(2 * len(nodes))
    u[4:6] = MOVED
    free = np.arange(6, len(u))
    if free.size:
        u[free] = factorize(K[free][:, free].tocsc()).solve(-(K[free] @ u))
    return (K[held] @ u)[4:6], u.reshape(-1, 2)


def study_triangle(levels: int = 7) -> tuple[dict, list]:
    """Sizes of the force under refinement by Poisson ratio, and what to draw of ν = 0.48."""
    out, drawn = {}, []
    for nu in (0.3, 0.48):
        nodes, cells, forces = TRIANGLE, np.array([(0, 1, 2)]), []
        for level in range(levels):
            force, u = holding_force(nodes, cells, nu)
            forces.append(float(np.linalg.norm(force)))
            if nu == 0.48 and level < 4:
                drawn.append((nodes, cells, u, force))
            nodes, cells = refined(nodes, cells)
        out[f"{nu:g}"] = {
            "force": forces,
            "growth_of_compliance": np.diff(1 / np.array(forces)).tolist(),
        }
    return out, drawn
