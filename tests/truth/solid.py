"""Triquadratic (27-node) hexahedra on mapped lattices: the matrices of the filmed body.

Own code from the textbook (Zienkiewicz, Taylor, The Finite Element Method, vol. 1, ch. 6-8).
Nothing here is shared with the code under test, which uses tetrahedra.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

GAUSS = np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])
WEIGHT = np.array([5.0, 8.0, 5.0]) / 9
FULL = (GAUSS, WEIGHT)
REDUCED = (np.array([-1.0, 1.0]) / np.sqrt(3), np.ones(2))


@dataclass(frozen=True, eq=False)
class Lattice:
    """Cells of 3 x 3 x 3 nodes on a box lattice, each coordinate in 0..1."""

    nodes: np.ndarray  # (N, 3) unit coordinates
    cells: np.ndarray  # (H, 27) rows of `nodes`; local index 9 i + 3 j + k
    faces: np.ndarray  # (F, 9) boundary faces, rows of `nodes`, seen anticlockwise from outside


def lattice(counts: tuple[int, int, int], keep=None) -> Lattice:
    """Cut the unit box in `counts` cells; `keep(centre (H, 3)) -> (H,)` leaves some out."""
    nx, ny, nz = counts
    axes = [np.linspace(0, 1, 2 * n + 1) for n in counts]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    corner = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(
        -1, 3
    )
    step = np.stack(np.meshgrid(*3 * [np.arange(3)], indexing="ij"), -1).reshape(-1, 3)
    at = 2 * corner[:, None] + step
    cells = number[at[..., 0], at[..., 1], at[..., 2]]
    if keep is not None:
        cells = cells[keep((corner + 0.5) / counts)]
    used, cells = np.unique(cells, return_inverse=True)
    cells = cells.reshape(-1, 27)
    return Lattice(grid.reshape(-1, 3)[used], cells, boundary(cells))


def boundary(cells: np.ndarray) -> np.ndarray:
    """Faces (F, 9) that belong to one cell only, in rows of 3 x 3."""
    local = np.arange(27).reshape(3, 3, 3)
    sides = [local[0].T, local[2], local[:, 0], local[:, 2].T, local[:, :, 0].T, local[:, :, 2]]
    faces = np.concatenate([cells[:, side.ravel()] for side in sides])
    key = np.sort(faces, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def triangles(faces: np.ndarray) -> np.ndarray:
    """Eight triangles (8 F, 3) of every 9-node face."""
    square = faces.reshape(-1, 3, 3)
    out = []
    for i in (0, 1):
        for j in (0, 1):
            a, b = square[:, i, j], square[:, i + 1, j]
            c, d = square[:, i + 1, j + 1], square[:, i, j + 1]
            out += [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    return np.concatenate(out)


def quadratic(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lagrange functions on -1, 0, 1 and their slopes at `s` (g,): (g, 3) each."""
    value = np.stack([s * (s - 1) / 2, 1 - s**2, s * (s + 1) / 2], 1)
    slope = np.stack([s - 0.5, -2 * s, s + 0.5], 1)
    return value, slope


def reference(rule) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """N (G, 27), dN (G, 27, 3) and weights (G,) of a Gauss rule (points, weights) cubed."""
    n, d = quadratic(rule[0])
    N = np.einsum("ai,bj,ck->abcijk", n, n, n).reshape(-1, 27)
    dN = np.stack(
        [
            np.einsum("ai,bj,ck->abcijk", *three).reshape(-1, 27)
            for three in ((d, n, n), (n, d, n), (n, n, d))
        ],
        -1,
    )
    return N, dN, np.einsum("a,b,c->abc", *3 * [rule[1]]).ravel()


def gradients(nodes: np.ndarray, cells: np.ndarray, rule=FULL):
    """Yield per Gauss point: N (27,), dN/dx (H, 27, 3), weight times det J (H,)."""
    N, dN, weight = reference(rule)
    x = nodes[cells]
    for g in range(len(N)):
        J = np.einsum("hai,aj->hij", x, dN[g])
        det = np.linalg.det(J)
        if not (det > 0).all():
            raise ValueError(f"solid: {np.sum(det <= 0)} cells are folded. Change the mapping.")
        yield N[g], np.einsum("aj,hji->hai", dN[g], np.linalg.inv(J)), weight[g] * det


def matrices(nodes, cells, poisson: float, modulus=None) -> tuple:
    """Stiffness at 1 Pa and mass at 1 kg/m3, both (3N, 3N); modulus(x (H, 3)) -> (H,) varies E.

    The volumetric part is integrated at 2 x 2 x 2 points: with 3 x 3 x 3 nearly incompressible
    cells come out some per cent too stiff (Malkus, Hughes 1978).
    """
    count, size = len(cells), 81
    K = np.zeros((count, 27, 3, 27, 3))
    M = np.zeros((count, 27, 27))
    bulk, mu = 1 / (3 * (1 - 2 * poisson)), 0.5 / (1 + poisson)

    def weigh(N, w):
        return w if modulus is None else w * modulus(np.einsum("a,hai->hi", N, nodes[cells]))

    for N, B, w in gradients(nodes, cells):
        M += w[:, None, None] * np.outer(N, N)
        BB = np.einsum("hai,hbj->haibj", mu * B * weigh(N, w)[:, None, None], B)
        K += BB.transpose(0, 1, 4, 3, 2) - 2 / 3 * BB
        dot = np.einsum("haibi->hab", BB)
        for i in range(3):
            K[:, :, i, :, i] += dot
    for N, B, w in gradients(nodes, cells, REDUCED):
        K += np.einsum("hai,hbj->haibj", bulk * B * weigh(N, w)[:, None, None], B)
    dof = (3 * cells[:, :, None] + np.arange(3)).reshape(count, size)
    full = scatter(K.reshape(count, size, size), dof, 3 * len(nodes))
    mass = scatter(M, cells, len(nodes))
    return full, sparse.kron(mass, sparse.eye(3), format="csr")


def bent(nodes, cells, poisson: float, u: np.ndarray) -> tuple[np.ndarray, sparse.csr_matrix]:
    """Inner force (3N,) and tangent (3N, 3N) at the displacement `u` (3N,), E = 1 Pa.

    St. Venant-Kirchhoff: S = lam tr(E) I + 2 mu E, E = (F^T F - I) / 2 (Bonet, Wood, ch. 6).
    """
    lam = poisson / ((1 + poisson) * (1 - 2 * poisson))
    mu = 0.5 / (1 + poisson)
    count = len(cells)
    K, inner = np.zeros((count, 27, 3, 27, 3)), np.zeros((count, 27, 3))
    local = u.reshape(-1, 3)[cells]
    for _, B, w in gradients(nodes, cells):
        F = np.eye(3) + np.einsum("hai,haJ->hiJ", local, B)
        E = (np.einsum("hiI,hiJ->hIJ", F, F) - np.eye(3)) / 2
        S = lam * np.einsum("hII->h", E)[:, None, None] * np.eye(3) + 2 * mu * E
        FB = np.einsum("hiI,haI->hai", F, B)
        inner += w[:, None, None] * np.einsum("hiI,hIJ,haJ->hai", F, S, B)
        pair = np.einsum("hai,hbj->haibj", FB * w[:, None, None], FB)
        K += lam * pair + mu * pair.transpose(0, 1, 4, 3, 2)
        dot = w[:, None, None] * np.einsum("haJ,hbJ->hab", B, B)
        K += mu * np.einsum("hij,hab->haibj", np.einsum("hiI,hjI->hij", F, F), dot)
        pressed = np.einsum("haI,hIJ,hbJ->hab", B, S * w[:, None, None], B)
        for i in range(3):
            K[:, :, i, :, i] += pressed
    dof = (3 * cells[:, :, None] + np.arange(3)).reshape(count, 81)
    out = np.zeros(3 * len(nodes))
    np.add.at(out, dof, inner.reshape(count, 81))
    return out, scatter(K.reshape(count, 81, 81), dof, len(out))


def scatter(blocks: np.ndarray, dof: np.ndarray, size: int) -> sparse.csr_matrix:
    """Sum element blocks (H, n, n) into one sparse matrix."""
    n = dof.shape[1]
    row = np.repeat(dof, n, axis=1).ravel()
    column = np.tile(dof, (1, n)).ravel()
    return sparse.csr_matrix((blocks.ravel(), (row, column)), shape=(size, size))


def area_vectors(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(N, 3) m2: outward area that belongs to each node, from the 3 x 3 Gauss points of faces."""
    n, d = quadratic(GAUSS)
    out = np.zeros((len(nodes), 3))
    x = nodes[faces]
    for a in range(3):
        for b in range(3):
            N = np.outer(n[a], n[b]).ravel()
            du = np.einsum("fci,c->fi", x, np.outer(d[a], n[b]).ravel())
            dv = np.einsum("fci,c->fi", x, np.outer(n[a], d[b]).ravel())
            area = WEIGHT[a] * WEIGHT[b] * np.cross(du, dv)
            np.add.at(out, faces, N[None, :, None] * area[:, None])
    return out


def middle_areas(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F, 3) m2: outward area of each 9-node face, to be taken at its middle node."""
    return np.array([area_vectors(nodes, face[None])[face].sum(0) for face in faces])
