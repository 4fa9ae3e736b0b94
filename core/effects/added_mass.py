"""A lumped mass that nobody declared: a marker, a load, glue.

Law         M <- M + m N(x)^T N(x), x the place, N the shape functions
            one that hangs on a thread goes along with gravity's direction only; between it and
            the body is a spring, as much as gives under a narrower seat
Tells       every pitch drops, that of a mode with a node at x stays; under gravity the sag grows;
            a hanging one leaves the swing across gravity as it was
Looks like  graded_stiffness, compliant_pin; a take with a known mass on top settles it
Source      Rayleigh, The Theory of Sound, vol. 1, ch. IV; Johnson, Contact Mechanics (1985), ch. 3
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from ..boundary import boundary
from ..data import Load, Surface
from ..elasticity import add_loads, lump_operator, lump_radius, surface_quadrature
from ..factorization import Factorization, factorize
from ..surface import closest_point
from .base import Effect, Family, Parameter, reduced_basis

PLACES = 40  # on the surface, far apart
RESPONSES = 10  # of them whose local give is in the basis
NEAR = 12  # places around the best one, where it is looked for again
WALKS = 3  # times at most that it is looked for as far off, before half as far
HALVINGS = 4  # at most of how far that is, before the last look around
CLOSE = 0.15  # of its patch's radius, nearer than which it need not be looked for
AROUND = 24  # directions in which it is looked for there
WIDTHS = (1.0, 2.0)  # of its patch over a ball of steel's; a narrower one gives more
SEATS = (0.01, 0.5, 1.5, 3.0)  # give of the seat, over that of the modulus times the patch's radius
SOFTEST = 5.0  # of them
HEAVIEST = 5.0  # times the body's own mass
STILL = 1e-6  # share of a hanging lump's inertia that is left across gravity


def change_model(model, theta):
    """The same body with theta = (mass kg, x, y, z m) fixed to it."""
    return add_loads(model, (Load(float(theta[0]), np.asarray(theta[1:4])),))


def families(body, solve):
    """Masses over the surface; theta = (place, hangs 0 or 1, width, log of the seat's give,
    log of the mass over the body's).

    How wide a lump sits, and so how much gives under it, is no part of the answer, but what it may
    be widens the answer's interval.
    """
    sizes = np.log(np.geomspace(2e-3, 2.0, 8))
    at, _, areas = surface_quadrature(body.model)
    on, reach = (at @ body.model.points.ravel()).reshape(-1, 3), np.sqrt(areas.sum() / PLACES)
    places = _spread(on, PLACES)
    free = body.model.free
    bearer = Bearer(body, solve, factorize(body.model.stiffness[free][:, free]))
    search = Search(places, sizes, places[:RESPONSES], (), SEATS[:1], WIDTHS[:1], reach)
    return (_family(bearer, search),)


@dataclass(frozen=True, eq=False)
class Bearer:
    """The body that bears the lump, its stiffness factorized once: a mass changes none of it."""

    body: object
    solve: Callable
    factor: Factorization

    @property
    def mass(self) -> float:
        """kg."""
        return self.body.bare.mesh.volume * self.body.bare.material.density

    def modes(self, mass: float, place: np.ndarray) -> np.ndarray:
        """(3P, n) about the lowest with a lump of `mass` kg."""
        heavy = change_model(self.body.model, (mass, *place))
        return self.solve(heavy, self.body.modes.shapes.shape[2], self.factor)

    def give(self, pushes) -> np.ndarray:
        """(3P, k) m how it gives to forces (k, 3P) at 1 Pa, where it does at all."""
        free = self.body.model.free
        static = np.zeros((pushes.shape[1], pushes.shape[0]))
        static[free] = self.factor.solve(pushes[:, free].T.toarray())
        return static[:, np.linalg.norm(static, axis=0) > 0]


@dataclass(frozen=True, eq=False)
class Search:
    """Where a lump is looked for: at first all over the body, then ever nearer around a place."""

    places: np.ndarray  # (n, 3) m; after the first time the best one so far comes first
    sizes: np.ndarray  # logarithms of masses over the body's
    giving: np.ndarray  # (k, 3) m, places whose give is in the basis
    modes: tuple  # more shapes for the basis
    seats: tuple
    widths: tuple
    reach: float  # m, how far off it is looked for next
    walks: int = 0  # times that it was looked for so far off
    halvings: int = 0
    last: bool = False

    def around(self, bearer: Bearer, place: int, mass: float):
        """The next one, with the lump at that place; mass over the body's, a logarithm."""
        centre, heavy = self.places[place], bearer.mass * np.exp(mass)
        moved = (place > 0 or not self.modes) and self.walks < WALKS
        reach, halvings = self.reach / (1 if moved else 2), self.halvings + (not moved)
        around = _around(bearer.body.model.mesh, centre, reach)
        last = halvings > HALVINGS or reach < CLOSE * lump_radius(heavy)
        some = np.vstack([centre, _spread(around, NEAR)]) if len(around) else centre[None]
        modes = self.modes
        if place > 0 or not modes:
            modes = (bearer.modes(heavy, centre),)
        sizes = mass + np.linspace(-1, 1, 5) * (0.25 if last else 0.5)
        walks = self.walks + 1 if moved else 0
        return Search(
            places=some,
            sizes=sizes,
            giving=some,
            modes=modes,
            seats=SEATS if last else SEATS[::2],
            widths=WIDTHS if last else WIDTHS[:1],
            reach=reach,
            walks=walks,
            halvings=halvings,
            last=last,
        )


def _family(bearer: Bearer, search: Search) -> Family:
    body, model, own = bearer.body, bearer.body.model, bearer.mass
    radii = lump_radius(own * np.exp(np.mean(search.sizes))) * np.array(search.widths)
    basis = [body.modes.shapes.reshape(-1, body.modes.shapes.shape[2]), *search.modes]
    for radius in radii:
        basis.append(bearer.give(lump_operator(model, search.giving, radius)))
    basis = reduced_basis(basis, model.mass)
    K, r = basis.T @ (model.stiffness @ basis), basis.shape[1]
    at = [
        (lump_operator(model, search.places, radius) @ basis).reshape(len(search.places), 3, r)
        for radius in radii
    ]
    gravity = body.case.takes[0].gravity
    down = None if gravity is None else gravity / max(np.linalg.norm(gravity), 1e-300)

    def matrices(theta):
        """Of the body and the lump's own three displacements, on springs between them."""
        along = np.outer(down, down) if theta[1] else np.eye(3)
        width = int(theta[2])
        N, spring = along @ at[width][int(theta[0])], radii[width] / np.exp(theta[3])
        inertia = own * np.exp(theta[4]) * (along + STILL * (np.eye(3) - along))
        stiffness, mass = np.empty((r + 3, r + 3)), np.eye(r + 3)
        stiffness[:r, :r] = K + spring * N.T @ N
        stiffness[r:, :r] = -spring * N
        stiffness[:r, r:] = stiffness[r:, :r].T
        stiffness[r:, r:] = spring * np.eye(3)
        mass[r:, r:] = inertia
        return stiffness, mass

    def report(theta, youngs_modulus):
        place = search.places[int(theta[0])]
        return {"mass": own * np.exp(theta[4]), "position": place.tolist()}

    def weight(theta, gravity):
        return np.r_[np.zeros(r), own * np.exp(theta[4]) * gravity]

    def nearer(theta):
        return _family(bearer, search.around(bearer, int(theta[0]), theta[4]))

    places, hangs = range(len(search.places)), range(1 if down is None else 2)
    widths, seats = range(len(radii)), np.log(search.seats)
    grid = np.array(list(product(places, hangs, widths, seats, search.sizes)))
    low = np.array([0, 0, 0, np.log(SEATS[0]), np.log(1e-4)])
    high = np.array([len(places) - 1, 1, len(radii) - 1, np.log(SOFTEST), np.log(HEAVIEST)])
    return Family(
        np.hstack([basis, np.zeros((len(basis), 3))]), matrices, grid, low, high, report, weight,
        frozen=3, unknowns=4, nearer=None if search.last else nearer, size=lambda theta: theta[4],
        choices=1 if search.modes and not search.last else 10,
    )  # fmt: skip


def _around(mesh, centre: np.ndarray, reach: float) -> np.ndarray:
    """(n, 3) m, points of a mesh's surface on all sides of one of them, about `reach` off and half
    of that.
    """
    turn = np.arange(AROUND) * np.pi * (3 - np.sqrt(5))  # a Fibonacci sphere
    height = 1 - (2 * np.arange(AROUND) + 1) / AROUND
    level = np.sqrt(1 - height**2)
    way = np.column_stack([level * np.cos(turn), level * np.sin(turn), height])
    skin = Surface(mesh.nodes, boundary(mesh).corners)
    points = np.unique(closest_point(skin, centre + reach * np.vstack([way, way / 2]))[0], axis=0)
    return points[np.linalg.norm(points - centre, axis=1) > reach / 4]


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
