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
from ..elasticity import PLAIN, Seat, add_loads, lump_operator, lump_radius, surface_quadrature
from ..factorization import Factorization, factorize
from ..surface import closest_point
from .base import KNOWN, Effect, Family, Parameter, reduced_basis

PLACES = 60  # on the surface, far apart
STARTS = 2  # of them, the best ones, around which it is looked for again
NEAR = 8  # places around one, where it is
MIDWAY = 3  # lumps there whose mass is looked for between the steps of a grid
OUTER = 0.6  # of how far off it is looked for: where it is farther, it is looked for so once more
WALKS = 3  # times at most that it is looked for as far off, before half as far
WITHIN = 0.5  # of its patch's radius, nearer than which it counts how it sits
CLOSE = 0.15  # the same, of the last look
AROUND = 24  # directions in which it is looked for there
# how it may sit, once the place is nearly known
SITS = (PLAIN, Seat(2.0, True), *(Seat(width, False) for width in (0.5, 1.25, 1.5, 2.0)))
KEPT = 3  # of them, for the last look
GIVES = (0.01, 0.5, 1.5, 3.0)  # of the seat, over that of the modulus times the patch's radius
SOFTEST = 5.0  # of them
LIGHTEST, HEAVIEST = 1e-4, 5.0  # times the body's own mass
STILL = 1e-6  # share of a hanging lump's inertia that is left across gravity


def change_model(model, theta):
    """The same body with theta = (mass kg, x, y, z m) fixed to it."""
    return add_loads(model, (Load(float(theta[0]), np.asarray(theta[1:4])),))


def families(body, solve):
    """Masses over the surface; theta = (place, hangs 0 or 1, how it sits, log of the seat's give,
    log of the mass over the body's).

    How a lump sits, and so how much gives under it, is no part of the answer, but what it may be
    widens the answer's interval.
    """
    sizes = np.log(np.geomspace(2e-3, 2.0, 8))
    at, _, areas = surface_quadrature(body.model)
    on, reach = (at @ body.model.points.ravel()).reshape(-1, 3), np.sqrt(areas.sum() / PLACES)
    search = Search(_spread(on, PLACES), sizes, GIVES[:1], SITS[:1], reach)
    return (_family(Bearer.of(body), search),)


@dataclass(frozen=True, eq=False)
class Bearer:
    """The body that bears the lump: its modes, and its stiffness factorized once."""

    body: object
    modes: np.ndarray  # (3P, m) mass-orthonormal
    heavy: np.ndarray  # (3P, m) mass times these
    stiff: np.ndarray  # (3P, m) stiffness at 1 Pa times these
    factor: Factorization

    @classmethod
    def of(cls, body) -> "Bearer":
        model, free = body.model, body.model.free
        modes = reduced_basis([body.modes.shapes.reshape(model.mass.shape[0], -1)], model.mass)
        factor = factorize(model.stiffness[free][:, free])
        return cls(body, modes, model.mass @ modes, model.stiffness @ modes, factor)

    @property
    def mass(self) -> float:
        """kg."""
        return self.body.bare.mesh.volume * self.body.bare.material.density

    def give(self, pushes) -> "_Give":
        """How it gives to forces (k, 3P), beside its modes; as large as these."""
        model, free = self.body.model, self.body.model.free
        stiff, static = np.zeros((2, *pushes.shape[::-1]))
        stiff[free] = pushes[:, free].T.toarray()
        static[free] = self.factor.solve(stiff[free])
        heavy = model.mass @ static
        for _ in range(2):
            size = np.sqrt(np.maximum(np.einsum("ij,ij->j", static, heavy), 0.0))
            scale = np.where(size > KNOWN * size.max(), 1 / np.maximum(size, 1e-300), 0.0)
            own = self.modes.T @ heavy
            static = (static - self.modes @ own) * scale
            heavy = (heavy - self.heavy @ own) * scale
            stiff = (stiff - self.stiff @ own) * scale
        return _Give(static, heavy, stiff)


@dataclass(frozen=True, eq=False)
class _Give:
    """(3P, k) each: how a body gives, and its mass and its stiffness times that."""

    static: np.ndarray
    heavy: np.ndarray
    stiff: np.ndarray


@dataclass(frozen=True, eq=False)
class Search:
    """Where a lump is looked for: at first all over the body, then ever nearer around a place."""

    places: np.ndarray  # (n, 3) m; after the first time the best one so far comes first
    sizes: np.ndarray  # logarithms of masses over the body's
    gives: tuple
    sits: tuple[Seat, ...]
    reach: float  # m, how far off the places lie; the first ones from one another
    first: bool = True
    walks: int = 0  # times that it was looked for so far off
    settled: bool = False  # how it sits counts
    last: bool = False

    def chosen(self, thetas: list) -> list:
        """Of the lumps (thetas, best first) those that it is looked for around, each by itself."""
        out = thetas[:1]
        for theta in thetas:
            off = self.places[[int(one[0]) for one in out]] - self.places[int(theta[0])]
            if np.linalg.norm(off, axis=1).min() > self.reach and len(out) < STARTS:
                out.append(theta)
        return out

    def around(self, bearer: Bearer, thetas: list) -> "Search":
        """The next one, around the first of the lumps."""
        place, mass = int(thetas[0][0]), thetas[0][4]
        patch = lump_radius(bearer.mass * np.exp(mass))
        off = np.linalg.norm(self.places[place] - self.places[0])
        moved = (self.first or off > OUTER * self.reach) and self.walks < WALKS
        reach = self.reach / (1 if moved else 2)
        settles = not self.settled and reach < WITHIN * patch
        if settles or self.settled:
            reach = min(reach, (CLOSE if self.settled else WITHIN) * patch)
        around = _around(bearer.body.model.mesh, self.places[place], reach)
        centre = self.places[place][None]
        sizes = mass + np.linspace(-1, 1, 5) * (0.25 if self.settled else 0.5)
        kept = tuple(dict.fromkeys(self.sits[int(one[2])] for one in thetas))[:KEPT]
        return Search(
            places=np.vstack([centre, _spread(around, NEAR)]) if len(around) else centre,
            sizes=np.unique(np.clip(sizes, np.log(LIGHTEST), np.log(HEAVIEST))),
            gives=GIVES if self.settled else GIVES[::2],
            sits=kept if self.settled else SITS if settles else SITS[:1],
            reach=reach,
            first=False,
            walks=self.walks + 1 if moved else 1,
            settled=settles,
            last=self.settled,
        )


def _family(bearer: Bearer, search: Search) -> Family:
    """The body with a lump at each of the places, in its modes and how it gives there: as near as a
    part in ten thousand (MacNeal, Computers & Structures 1 (1971) 581).
    """
    body, own = bearer.body, bearer.mass
    radii = lump_radius(own * np.exp(np.mean(search.sizes))) * np.array(
        [sits.width for sits in search.sits]
    )
    on = [
        lump_operator(body.model, search.places, radius, over_foot=sits.over_foot)
        for radius, sits in zip(radii, search.sits, strict=True)
    ]
    gives = [bearer.give(operator) for operator in on]
    basis = np.hstack([bearer.modes, *(give.static for give in gives)])
    spots = [
        _spots(bearer, give, operator, 3 * len(search.places) * n, basis.shape[1])
        for n, (give, operator) in enumerate(zip(gives, on, strict=True))
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

    def nearer(thetas):
        begins = [[one] for one in search.chosen(thetas)] if search.first else [thetas]
        return [_family(bearer, search.around(bearer, some)) for some in begins]

    places, hangs = range(len(search.places)), range(1 if down is None else 2)
    grid = np.array(
        list(product(places, hangs, range(len(radii)), np.log(search.gives), search.sizes))
    )
    low = np.array([0, 0, 0, np.log(GIVES[0]), np.log(LIGHTEST)])
    high = np.array([len(places) - 1, 1, len(radii) - 1, np.log(SOFTEST), np.log(HEAVIEST)])
    return Family(
        basis, matrices, grid, low, high, report, weight, within=within,
        frozen=3, unknowns=4, nearer=None if search.last else nearer, size=lambda theta: theta[4],
        choices=10 if search.first or search.last else MIDWAY,
        rough=not (search.settled or search.last),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Spot:
    """The body as it gives to what sits at one place; the basis is mass-orthonormal."""

    part: np.ndarray  # (r, s) of the family's basis
    stiffness: np.ndarray  # (s, s)
    motion: np.ndarray  # (3, s) of the place


def _spots(bearer: Bearer, give: _Give, operator, first: int, size: int) -> list[_Spot]:
    """Of each place whose motion is a row of the operator (3n, 3P); the give there begins with
    column `first` after the modes, in a basis of that `size`.
    """
    m, moves = bearer.modes.shape[1], operator @ np.hstack([bearer.modes, give.static])
    modal, across = bearer.modes.T @ bearer.stiff, bearer.modes.T @ give.stiff
    out = []
    for at in range(0, operator.shape[0], 3):
        own, here = slice(at, at + 3), give.static[:, at : at + 3]
        w, v = np.linalg.eigh(here.T @ give.heavy[:, own])
        turn = v[:, w > KNOWN] / np.sqrt(w[w > KNOWN])
        s = m + turn.shape[1]
        part, stiffness = np.zeros((size, s)), np.empty((s, s))
        part[:m, :m] = np.eye(m)
        part[m + first + at : m + first + at + 3, m:] = turn
        stiffness[:m, :m] = modal
        stiffness[:m, m:] = across[:, own] @ turn
        stiffness[m:, :m] = stiffness[:m, m:].T
        stiffness[m:, m:] = turn.T @ (here.T @ give.stiff[:, own]) @ turn
        motion = np.hstack([moves[own, :m], moves[own, m + at : m + at + 3] @ turn])
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


def outweighs(effects: list[dict], own: float) -> bool:
    """Whether the mass found among the report's effects is more than the body's `own`, kg."""
    return _found(effects) > own


def _found(effects: list[dict]) -> float:
    """kg"""
    return sum(e["parameters"]["mass"]["value"] for e in effects if e["name"] == "added_mass")


def told(effects: list[dict], own: float) -> str:
    """A line where the mass found among the report's effects is more than the body's `own`, kg."""
    found = _found(effects)
    if not found > own:
        return ""
    return (
        f"added_mass: {found:.3g} kg is more than the {own:.3g} kg of the body itself. Check the "
        "density and the length unit; if both are right, weigh what is on it."
    )


EFFECT = Effect(
    name="added_mass",
    layer="modal",
    parameters=(Parameter("mass", "kg", 0.0, 1e3), Parameter("position", "m", -1e3, 1e3)),
    twins=("graded_stiffness", "compliant_pin"),
    settle="weigh it, or hang a known mass on the same place and film again",
    change_model=change_model,
    families=families,
)
