"""The stiffness varies along the object: cured unevenly, filled, drier on one side.

Law         E(s) = E (1 + (r - 1) s), s from 0 at the near (held) end to 1 at the far end of an axis
Tells       ratios of pitches and the curvature of the shapes change
Looks like  compliant_pin, added_mass; a second way of holding it settles it
Source      Elishakoff, Eigenvalues of Inhomogeneous Structures (2005), ch. 1
"""

import numpy as np

from ..data import replace
from ..elasticity import assemble
from .base import Effect, Family, Parameter, reduced_basis

RATIOS = (0.3, 0.6, 1.8, 3.5)


def _along(model, axis):
    """(T,) place of each tetrahedron from the held end (0) to the far end (1) of `axis`."""
    s = model.points @ axis
    centres = model.mesh.nodes[model.mesh.tets].mean(axis=1) @ axis
    held = s[model.pinned].mean() if model.pinned.any() else s.min()
    if s.max() - held < held - s.min():
        s, centres, held = -s, -centres, -held
    return np.clip((centres - held) / max(s.max() - held, 1e-12), 0, 1)


def change_model(model, theta):
    """theta = (ratio, axis x, y, z)."""
    share = _along(model, np.asarray(theta[1:4], float))
    scaled = assemble(
        model.mesh, model.material, model.element, stiffness_scale=1 + (theta[0] - 1) * share
    )
    return replace(model, shear=scaled.shear, bulk=scaled.bulk)


def family(body, solve):
    """Gradients along the body's own axes; theta = (axis, log of ratio)."""
    model = body.model
    spread = model.points - model.points.mean(axis=0)
    axes = np.linalg.svd(spread, full_matrices=False)[2]
    modes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    parts, ends = [modes], []
    for axis in axes:
        double = change_model(model, (2.0, *axis))
        shear, bulk = double.shear - model.shear, double.bulk - model.bulk
        for ratio in RATIOS:
            by = ratio - 1
            graded = replace(model, shear=model.shear + by * shear, bulk=model.bulk + by * bulk)
            parts.append(solve(graded, 6))
        ends.append(double.stiffness - model.stiffness)
    basis = reduced_basis(parts, model.mass)
    K = basis.T @ (model.stiffness @ basis)
    slopes = [basis.T @ (end @ basis) for end in ends]
    M = np.eye(basis.shape[1])

    def matrices(theta):
        return K + (np.exp(theta[1]) - 1) * slopes[int(theta[0])], M

    def report(theta, young):
        return {"ratio": float(np.exp(theta[1])), "axis": axes[int(theta[0])].tolist()}

    steps = np.log(np.geomspace(0.15, 6.5, 14))
    grid = np.array([(i, s) for i in range(3) for s in steps])
    low, high = np.array([0, np.log(0.1)]), np.array([2, np.log(10.0)])
    return Family(basis, matrices, grid, low, high, report, frozen=1, unknowns=2)


EFFECT = Effect(
    name="graded_stiffness",
    layer="modal",
    parameters=(Parameter("ratio", "1", 0.0, 1e3), Parameter("axis", "1", -1.0, 1.0)),
    twins=("compliant_pin", "added_mass"),
    settle="hold it by the other end and film again",
    change_model=change_model,
    family=family,
)
