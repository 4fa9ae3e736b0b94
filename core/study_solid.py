"""A bar of ten to one, clamped at one end: how far each element's pitch is off, and after DAC.

Structured meshes, n by n cells across and 10 n along, six tetrahedra a cell; the error is that of
the frequency. The reference is cubic tetrahedra.
"""

from itertools import permutations

import numpy as np

from .data import Material, TetMesh, replace, tet_volumes
from .elasticity import assemble, hold_points
from .elements import dg
from .modes import solve_modes

SIZE = np.array([10.0, 1.0, 1.0])
RATIOS = (0.3, 0.49)
PLAN = {"p1": (1, 2, 4), "p1_smoothed": (1, 2, 4), "p2": (1, 2), "dg": (1, 2)}
MODES = 10


def bar(n: int) -> TetMesh:
    """The bar with n x n cells across."""
    counts = np.array([10, 1, 1]) * n
    axes = [np.linspace(0, s, k + 1) for s, k in zip(SIZE, counts, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 1, 3)
    strides = np.array([(n + 1) ** 2, n + 1, 1])
    steps = [np.eye(3, dtype=int)[list(order)].cumsum(axis=0) for order in permutations(range(3))]
    paths = np.concatenate([np.zeros((6, 1, 3), int), steps], axis=1)
    tets = ((cells[:, None] + paths) @ strides).reshape(-1, 4)
    flipped = tet_volumes(nodes, tets) < 0
    tets[flipped] = tets[flipped][:, [1, 0, 2, 3]]
    return TetMesh(nodes, tets)


def pitches(n: int, element: str, nu: float, penalty: float | None = None):
    """Frequencies (m,) Hz at Y = ρ = 1 and the number of unknowns; `penalty` is for `dg` only."""
    model = assemble(bar(n), Material(1.0, nu), element)
    if penalty is not None:
        matrices = dg.build(model.mesh, np.ones(len(model.mesh.tets)), penalty)
        model = replace(model, shear=matrices.shear, bulk=matrices.bulk)
    model = hold_points(model, np.flatnonzero(model.points[:, 0] < 1e-9))
    return solve_modes(model, MODES).frequency, model.free.size


def errors(frequency: np.ndarray, reference: np.ndarray) -> dict:
    """Per cent: of the first frequency, and the worst of the next after DAC on the first."""
    ratio = frequency / reference
    return {
        "first_percent": float(100 * (ratio[0] - 1)),
        "worst_after_dac_percent": float(100 * np.abs(ratio[1:] / ratio[0] - 1).max()),
    }


def study_locking(progress=None) -> dict:
    """{element: {nu: [{n, unknowns, errors}]}}, and `dg` again with other penalties."""
    say = progress or (lambda share, text: None)
    reference = {}
    for nu in RATIOS:
        say(0.0, f"3-D bar: reference, Poisson ratio {nu}")
        reference[nu] = pitches(2, "p3", nu)[0]
    jobs = [(e, nu, n) for e, ns in PLAN.items() for nu in RATIOS for n in ns]
    out = {e: {f"{nu:g}": [] for nu in RATIOS} for e in PLAN}
    for k, (element, nu, n) in enumerate(jobs):
        say(k / len(jobs), f"3-D bar: {element}, Poisson ratio {nu}, {n} across")
        frequency, unknowns = pitches(n, element, nu)
        row = {"n": n, "unknowns": unknowns, **errors(frequency, reference[nu])}
        out[element][f"{nu:g}"].append(row)
    out["dg_penalty"] = [
        {"penalty": p, **errors(pitches(1, "dg", 0.3, p)[0], reference[0.3])}
        for p in (dg.PENALTY, 2 * dg.PENALTY, 100 * dg.PENALTY)
    ]
    return out
