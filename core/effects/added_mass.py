"""A lumped mass that nobody declared: a marker, a load, glue.

Law         M <- M + m N(x)^T N(x), x the place, N the shape functions
            one that hangs on a thread goes along with gravity's direction only
Tells       every pitch drops, that of a mode with a node at x stays; under gravity the sag grows;
            a hanging one leaves the swing across gravity as it was
Looks like  graded_stiffness, compliant_pin; a take with a known mass on top settles it
Source      Rayleigh, The Theory of Sound, vol. 1, ch. IV
"""

from itertools import product

import numpy as np

from ..data import Load
from ..elasticity import add_loads, lump_operator, lump_radius, surface_quadrature
from ..factorization import factorize
from .base import Effect, Family, Parameter, reduced_basis

PLACES = 40  # on the surface, far apart
RESPONSES = 10  # of them whose local give is in the basis
NEAR = 24  # places around the best one, where it is looked for again
GIVING = 8  # of them whose local give is in the basis
WIDTHS = (1.0, 0.5)  # of the usual patch
DEPTH = 2  # times that the search closes in
HEAVIEST = 5.0  # times the body's own mass


def change_model(model, theta):
    """The same body with theta = (mass kg, x, y, z m) fixed to it."""
    return add_loads(model, (Load(float(theta[0]), np.asarray(theta[1:4])),))


def families(body, solve):
    """Masses over the surface; theta = (place, hangs 0 or 1, width, log of mass over the body's).

    How wide a lump sits is no part of the answer, but what it may be widens the answer's interval.
    """
    places = _spread(body.case.surface.vertices, PLACES)
    sizes = np.log(np.geomspace(2e-3, 2.0, 8))
    return (_family(body, solve, (places, sizes, places[:RESPONSES], ())),)


def _family(body, solve, search, depth: int = 0):
    """`search`: places (n, 3), logs of masses, places whose give is in the basis, more modes."""
    model = body.model
    places, sizes, giving, more = search
    own = body.bare.mesh.volume * body.bare.material.density
    radius = lump_radius(own * np.exp(np.mean(sizes)))
    widths = WIDTHS if depth else WIDTHS[:1]
    factor = factorize(model.stiffness[model.free][:, model.free])
    basis = [body.modes.shapes.reshape(-1, body.modes.shapes.shape[2]), *more]
    for width in widths:
        pushes = lump_operator(model, giving, width * radius)[:, model.free].T.toarray()
        static = np.zeros((3 * len(model.points), pushes.shape[1]))
        static[model.free] = factor.solve(pushes)
        basis.append(static[:, np.linalg.norm(static, axis=0) > 0])
    basis = reduced_basis(basis, model.mass)
    K, M = basis.T @ (model.stiffness @ basis), np.eye(basis.shape[1])
    at = [
        (lump_operator(model, places, width * radius) @ basis).reshape(len(places), 3, -1)
        for width in widths
    ]
    gravity = body.case.takes[0].gravity
    down = None if gravity is None else gravity / max(np.linalg.norm(gravity), 1e-300)

    def matrices(theta):
        N = at[int(theta[2])][int(theta[0])]
        N = down[None] @ N if theta[1] else N
        return K, M + own * np.exp(theta[3]) * N.T @ N

    def report(theta, youngs_modulus):
        return {"mass": own * np.exp(theta[3]), "position": places[int(theta[0])].tolist()}

    def weight(theta, gravity):
        return own * np.exp(theta[3]) * (at[int(theta[2])][int(theta[0])].T @ gravity)

    def nearer(theta):
        """Places around the best one, with what the body gives there in the basis."""
        centre, mass = places[int(theta[0])], theta[3]
        vertices = body.case.surface.vertices
        gap = np.linalg.norm(vertices - centre, axis=1)
        reach = 2.0 * np.sqrt(surface_quadrature(model)[2].sum() / PLACES) / 2**depth
        around = _spread(vertices[gap <= reach], NEAR) if (gap <= reach).any() else centre[None]
        around = np.vstack([centre, around])
        heavy = solve(
            change_model(model, (own * np.exp(mass), *centre)), body.modes.shapes.shape[2]
        )
        found = (around, mass + np.linspace(-0.5, 0.5, 5) / 2**depth, around[:GIVING], (heavy,))
        return _family(body, solve, found, depth + 1)

    hangs = range(1 if down is None else 2)
    grid = np.array(list(product(range(len(places)), hangs, range(len(widths)), sizes)))
    low = np.array([0, 0, 0, np.log(1e-4)])
    high = np.array([len(places) - 1, 1, 1, np.log(HEAVIEST)])
    return Family(
        basis, matrices, grid, low, high, report, weight, frozen=3, unknowns=3,
        nearer=nearer if depth < DEPTH else None, size=lambda theta: theta[3],
    )  # fmt: skip


def _spread(vertices: np.ndarray, count: int) -> np.ndarray:
    """(count, 3) of the vertices, each next one farthest from those before."""
    chosen = [int(np.argmax(np.linalg.norm(vertices - vertices.mean(axis=0), axis=1)))]
    gap = np.linalg.norm(vertices - vertices[chosen[0]], axis=1)
    while len(chosen) < min(count, len(vertices)):
        chosen.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(vertices - vertices[chosen[-1]], axis=1))
    return vertices[chosen]


EFFECT = Effect(
    name="added_mass",
    layer="modal",
    parameters=(Parameter("mass", "kg", 0.0, 1e3), Parameter("position", "m", -1e3, 1e3)),
    twins=("graded_stiffness", "compliant_pin"),
    settle="weigh it, or hang a known mass on the same place and film again",
    change_model=change_model,
    families=families,
)
