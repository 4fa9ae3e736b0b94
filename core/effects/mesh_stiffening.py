"""The mesh is too coarse for the higher modes: they ring too high even where the first is right.

Law         lambda_k = (1 + s_k) lambda_k of the converged mesh; s_k is computed by refinement
Tells       every pitch lies high beside the first one's, the more the shorter its waves
Looks like  compliant_pin and graded_stiffness, if it were fitted; so it never is
Source      Chen, Levin, Kaufman, Ascher and Pai, SCA 2019; core/stiffening.py has the estimate
"""

import numpy as np

from .base import Effect

SHOWN = 0.02  # relative, of a pitch beside the first one's, from which it is said


def told(stiff: np.ndarray, modes: tuple, frequency: np.ndarray) -> str:
    """A line on what this mesh puts too high of the measured `modes` (indices into `stiff` (m,)).

    frequency (K,) Hz: where they were measured.
    """
    if None in modes:
        return ""
    beside = np.sqrt((1 + stiff[list(modes)]) / (1 + stiff[modes[0]])) - 1
    k = int(np.argmax(np.abs(beside)))
    if abs(beside[k]) < SHOWN:
        return ""
    way = "high" if beside[k] > 0 else "low"
    return (
        f"mesh_stiffening: with the first mode right, this mesh rings the one at "
        f"{frequency[k]:.4g} Hz {abs(beside[k]):.1%} too {way}. It was computed and taken out of "
        "the comparison; a bake plays the measured pitch."
    )


EFFECT = Effect(
    name="mesh_stiffening",
    layer="computed",
    parameters=(),
    twins=(),
    settle="calibrate once more with twice as many tetrahedra: what changes is the mesh",
)
