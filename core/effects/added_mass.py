"""A lumped mass that nobody declared: a marker, a load, glue.

Law         M <- M + m N(x)^T N(x), x the place, N the shape functions
            one that hangs on a thread goes along with gravity's direction only; between it and
            the body is a spring, as much as gives under a narrower seat
Tells       every pitch drops, that of a mode with a node at x stays; under gravity the sag grows;
            a hanging one leaves the swing across gravity as it was
Looks like  graded_stiffness, compliant_pin; a take with a known mass on top settles it
Source      Rayleigh, The Theory of Sound, vol. 1, ch. IV; Johnson, Contact Mechanics (1985), ch. 3
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from ..boundary import boundary
from ..data import Load, Surface
from ..elasticity import add_loads, lump_operator, lump_radius, surface_quadrature
from ..factorization import Factorization, factorize
from ..surface import closest_point
from .base import KNOWN, Effect, Family, Parameter, reduced_basis

PLACES = 40  # on the surface, far apart
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
    search = Search(_spread(on, PLACES), sizes, SEATS[:1], WIDTHS[:1], reach)
    return (_family(Bearer.of(body), search),)


@dataclass(frozen=True, eq=False)
class Bearer:
    """The body that bears the lump: its modes, and its stiffness factorized once."""

    body: object
    modes: np.ndarray  # (3P, m) mass-orthonormal
    stiffness: np.ndarray  # (m, m) between them, at 1 Pa
    factor: Factorization

    @classmethod
    def of(cls, body) -> "Bearer":
        model, free = body.model, body.model.free
        modes = reduced_basis([body.modes.shapes.reshape(model.mass.shape[0], -1)], model.mass)
        factor = factorize(model.stiffness[free][:, free])
        return cls(body, modes, modes.T @ (model.stiffness @ modes), factor)

    @property
    def mass(self) -> float:
        """kg."""
        return self.body.bare.mesh.volume * self.body.bare.material.density

    def give(self, pushes) -> np.ndarray:
        """(3P, k) how it gives to forces (k, 3P), beside its modes; as large as these."""
        model, free = self.body.model, self.body.model.free
        static = np.zeros((pushes.shape[1], pushes.shape[0]))
        static[free] = self.factor.solve(pushes[:, free].T.toarray())
        for _ in range(2):
            size = np.sqrt(_powers(static, model.mass))
            static = np.where(size > KNOWN * size.max(), static / np.maximum(size, 1e-300), 0.0)
            static -= self.modes @ (self.modes.T @ (model.mass @ static))
        return static


def _powers(vectors: np.ndarray, mass) -> np.ndarray:
    return np.einsum("ij,ij->j", vectors, mass @ vectors)


@dataclass(frozen=True, eq=False)
class Search:
    """Where a lump is looked for: at first all over the body, then ever nearer around a place."""

    places: np.ndarray  # (n, 3) m; after the first time the best one so far comes first
    sizes: np.ndarray  # logarithms of masses over the body's
    seats: tuple
    widths: tuple
    reach: float  # m, how far off it is looked for next
    first: bool = True
    walks: int = 0  # times that it was looked for so far off
    halvings: int = 0
    last: bool = False

    def around(self, bearer: Bearer, place: int, mass: float):
        """The next one, with the lump at that place; mass over the body's, a logarithm."""
        centre, heavy = self.places[place], bearer.mass * np.exp(mass)
        moved = (place > 0 or self.first) and self.walks < WALKS
        reach, halvings = self.reach / (1 if moved else 2), self.halvings + (not moved)
        around = _around(bearer.body.model.mesh, centre, reach)
        last = halvings > HALVINGS or reach < CLOSE * lump_radius(heavy)
        return Search(
            places=np.vstack([centre, _spread(around, NEAR)]) if len(around) else centre[None],
            sizes=mass + np.linspace(-1, 1, 5) * (0.25 if last else 0.5),
            seats=SEATS if last else SEATS[::2],
            widths=WIDTHS if last else WIDTHS[:1],
            reach=reach,
            first=False,
            walks=self.walks + 1 if moved else 0,
            halvings=halvings,
            last=last,
        )


def _family(bearer: Bearer, search: Search) -> Family:
    """The body with a lump at each of the places, in its modes and how it gives there: as near as a
    part in ten thousand (MacNeal, Computers & Structures 1 (1971) 581).
    """
    body, own = bearer.body, bearer.mass
    radii = lump_radius(own * np.exp(np.mean(search.sizes))) * np.array(search.widths)
    on = [lump_operator(body.model, search.places, radius) for radius in radii]
    basis = np.hstack([bearer.modes, *(bearer.give(operator) for operator in on)])
    spots = [
        _spots(bearer, basis, operator, 3 * len(search.places) * n) for n, operator in enumerate(on)
    ]
    gravity = body.case.takes[0].gravity
    down = None if gravity is None else gravity / max(np.linalg.norm(gravity), 1e-300)

    def spot(theta):
        return spots[int(theta[2])][int(theta[0])]

    def matrices(theta):
        """Of the body and the lump's own three displacements, on springs between them."""
        along = np.outer(down, down) if theta[1] else np.eye(3)
        here, spring = spot(theta), radii[int(theta[2])] / np.exp(theta[3])
        N, s = along @ here.motion, len(here.stiffness)
        inertia = own * np.exp(theta[4]) * (along + STILL * (np.eye(3) - along))
        stiffness, mass = np.empty((s + 3, s + 3)), np.eye(s + 3)
        stiffness[:s, :s] = here.stiffness + spring * N.T @ N
        stiffness[s:, :s] = -spring * N
        stiffness[:s, s:] = stiffness[s:, :s].T
        stiffness[s:, s:] = spring * np.eye(3)
        mass[s:, s:] = inertia
        return stiffness, mass

    def within(theta):
        part = spot(theta).part
        return np.hstack([part, np.zeros((len(part), 3))])

    def report(theta, youngs_modulus):
        place = search.places[int(theta[0])]
        return {"mass": own * np.exp(theta[4]), "position": place.tolist()}

    def weight(theta, gravity):
        return np.r_[np.zeros(len(spot(theta).stiffness)), own * np.exp(theta[4]) * gravity]

    def nearer(theta):
        return _family(bearer, search.around(bearer, int(theta[0]), theta[4]))

    places, hangs = range(len(search.places)), range(1 if down is None else 2)
    widths, seats = range(len(radii)), np.log(search.seats)
    grid = np.array(list(product(places, hangs, widths, seats, search.sizes)))
    low = np.array([0, 0, 0, np.log(SEATS[0]), np.log(1e-4)])
    high = np.array([len(places) - 1, 1, len(radii) - 1, np.log(SOFTEST), np.log(HEAVIEST)])
    return Family(
        basis, matrices, grid, low, high, report, weight, within=within,
        frozen=3, unknowns=4, nearer=None if search.last else nearer, size=lambda theta: theta[4],
        choices=10 if search.first or search.last else 1,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Spot:
    """The body as it gives to what sits at one place; the basis is mass-orthonormal."""

    part: np.ndarray  # (r, s) of the family's basis
    stiffness: np.ndarray  # (s, s)
    motion: np.ndarray  # (3, s) of the place


def _spots(bearer: Bearer, basis: np.ndarray, operator, first: int) -> list[_Spot]:
    """Of each place whose motion is a row of the operator (3n, 3P); the give there begins with
    column `first` after the modes.
    """
    model, m = bearer.body.model, bearer.modes.shape[1]
    give = basis[:, m + first : m + first + operator.shape[0]]
    heavy, stiff, moves = model.mass @ give, model.stiffness @ give, operator @ basis[:, :m]
    across = bearer.modes.T @ stiff
    out = []
    for at in range(0, give.shape[1], 3):
        own = slice(at, at + 3)
        w, v = np.linalg.eigh(give[:, own].T @ heavy[:, own])
        turn = v[:, w > KNOWN] / np.sqrt(w[w > KNOWN])
        s = m + turn.shape[1]
        part, stiffness = np.zeros((basis.shape[1], s)), np.empty((s, s))
        part[:m, :m] = np.eye(m)
        part[m + first + at : m + first + at + 3, m:] = turn
        stiffness[:m, :m] = bearer.stiffness
        stiffness[:m, m:] = across[:, own] @ turn
        stiffness[m:, :m] = stiffness[:m, m:].T
        stiffness[m:, m:] = turn.T @ (give[:, own].T @ stiff[:, own]) @ turn
        motion = np.hstack([moves[own], (operator[own] @ give[:, own]) @ turn])
        out.append(_Spot(part, stiffness, motion))
    return out


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
