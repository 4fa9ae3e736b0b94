"""Assembly of stiffness and mass: ours against scikit-fem, one thread each.

    pip install scikit-fem; python tests/bench/assembly.py

Prints CPU seconds, ratios, and the largest difference of the matrices.
"""

import os
import sys
import time
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

from core.data import Material
from core.elasticity import assemble
from tests.core.solids import block

RUBBER = Material(1000.0, 0.3)


def ours(mesh, element):
    start = time.process_time()
    model = assemble(mesh, RUBBER, element)
    K = model.stiffness
    return time.process_time() - start, K, model.mass


def scikit_fem(mesh, element):
    import skfem
    from skfem.helpers import ddot, dot, eye, sym_grad, trace
    from skfem.models.elasticity import lame_parameters

    lam, mu = lame_parameters(1.0, RUBBER.poisson_ratio)
    cells = skfem.MeshTet(mesh.nodes.T.copy(), mesh.tets.T.copy())
    scalar = skfem.ElementTetP1() if element == "p1" else skfem.ElementTetP2()

    @skfem.BilinearForm
    def stiffness(u, v, _):
        strain = sym_grad(u)
        return ddot(2 * mu * strain + eye(lam * trace(strain), 3), sym_grad(v))

    @skfem.BilinearForm
    def mass(u, v, _):
        return RUBBER.density * dot(u, v)

    start = time.process_time()
    basis = skfem.Basis(cells, skfem.ElementVector(scalar))
    K, M = stiffness.assemble(basis), mass.assemble(basis)
    return time.process_time() - start, K, M


def invariants(K, M):
    """Numbers that do not depend on the order of the unknowns."""
    return np.array([abs(K).sum(), K.diagonal().sum(), M.sum(), M.diagonal().sum()])


if __name__ == "__main__":
    for element, counts in (("p1", (47, 19, 19)), ("p2", (40, 9, 9))):
        mesh = block(counts, (1.0, 0.2, 0.2), jitter=0.1)
        seconds, K, M = ours(mesh, element)
        theirs, K2, M2 = scikit_fem(mesh, element)
        a, b = invariants(K, M), invariants(K2, M2)
        print(
            f"{element}: {len(mesh.tets)} tets, {K.shape[0]} unknowns: ours {seconds:.2f} s, "
            f"scikit-fem {theirs:.2f} s ({theirs / seconds:.1f}x), "
            f"sums of entries differ by {np.abs(a / b - 1).max():.0e}",
            flush=True,
        )
