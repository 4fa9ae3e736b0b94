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

from core.elasticity import assemble
from tests.bench.peers import RUBBER, scikit_fem_parts
from tests.core.solids import block


def ours(mesh, element):
    start = time.process_time()
    model = assemble(mesh, RUBBER, element)
    K = model.stiffness
    return time.process_time() - start, K, model.mass


def scikit_fem(mesh, element):
    _, basis, stiffness, mass = scikit_fem_parts(mesh, element)
    start = time.process_time()
    space = basis()
    K, M = stiffness.assemble(space), mass.assemble(space)
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
