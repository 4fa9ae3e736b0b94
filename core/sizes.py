"""How pitches move where an object is a little larger along one axis than it is said to be.

Law         d log w = xᵀ(dK - w² dM)x / (2 w² xᵀMx), x the shape before: what it is off by then
            counts in the second order, though as the slenderness squared
Source      Rayleigh, The Theory of Sound, vol. 1, 88
"""

import numpy as np

from .body import Body
from .data import replace
from .elasticity import assemble

STEP = 1e-6  # relative, of a size


def size_slopes(body: Body) -> np.ndarray:
    """(3, m) relative change of the pitch of each of a body's modes per relative change of its size
    along x, y and z of the object's axes. Without loads.
    """
    bare, shapes = body.bare, body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])

    def square(model):
        stiff, heavy = (
            np.einsum("im,im->m", shapes, matrix @ shapes)
            for matrix in (model.stiffness, model.mass)
        )
        return stiff / heavy

    own, out = square(bare), []
    for axis in np.eye(3):
        mesh = replace(bare.mesh, nodes=bare.mesh.nodes * (1 + STEP * axis))
        other = assemble(mesh, bare.material, bare.element)
        out.append(np.log(square(other) / own) / (2 * STEP))
    return np.array(out)
