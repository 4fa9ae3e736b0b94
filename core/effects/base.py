"""What an effect is: one frozen noun that each file of this folder fills in."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

UNSURE = 0.1  # of the most that a place shares in a higher mode, that computed shapes are off
FAINT = 3.0  # standard deviations that an effect's strength is away from nought at least
PLACES = 16  # on the body, beside the reference, where a search for a force may begin
FINE = 32  # steps per period of the first mode; only added forces see them, smooth ones squared
KNOWN = 1e-7  # of a motion that a basis has not, below which it is rounding
INSTANT = 16  # part of a step, over which a carried motion has one speed
UNCLEAR = 0.05  # of the clearest combination of modes: what is seen less is not told apart
SAME_SHAPE = 0.7  # share of a second motion along a mode's shape that makes it a mere companion


@dataclass(frozen=True)
class Parameter:
    """One number of an effect, as the report gives it."""

    name: str
    unit: str
    low: float
    high: float
    form: float = 0.05  # relative standard deviation by which no real thing keeps to the law


@dataclass(frozen=True, eq=False)
class Carried:
    """What the modes of a take do that is no ring-down, and that forces feel as well."""

    paths: list  # [time (N,) s -> (N, K) m, ...]
    known: dict = field(default_factory=dict)

    def at(self, step: float, count: int) -> tuple[np.ndarray, np.ndarray]:
        """u and u' (N, K) at N = `count` + 1 steps of `step` s."""
        if (step, count) not in self.known:
            time, near = step * np.arange(count + 1), step / INSTANT
            u, later, before = (
                sum(path(t) for path in self.paths) for t in (time, time + near, time - near)
            )
            self.known[step, count] = u, (later - before) / (2 * near)
        return self.known[step, count]


@dataclass(frozen=True, eq=False)
class Setting:
    """What the hooks of the time layer are told about the motion; metres at the reference.

    The reference is the place and direction of the marker that moves most; x = sum_k couple_k u_k
    is its displacement, and a force f modal_mass there accelerates u_k by f couple_k masses_k.
    """

    omega: np.ndarray  # (K,) rad/s natural, of the declared fit
    zeta: np.ndarray  # (K,)
    couple: np.ndarray  # (K,)
    places: np.ndarray  # (Q, K - 1) couples of places on the body over that of the first mode
    levers: np.ndarray  # (Q,) motion of those places in the first mode over the reference's
    planes: np.ndarray  # (Q', 2, K - 1) couples of some places, along mode 1's way there and across
    skin: np.ndarray  # (K, 3S) motion of points all over the surface per m of u_k: x, y, then z
    facing: np.ndarray  # (K, S) motion of those points along the surface's normal there
    wind: np.ndarray  # (3S, K) as `skin`, times each point's share of the drag's work and `masses`
    amplitude: float  # m, of the first mode at the reference at release
    masses: np.ndarray  # (K,) first modal mass over each
    modal_mass: float  # kg of the first mode, normalised at the reference; NaN = not known
    drag_area: float  # m2, integral of |S|^3 over the surface seen from the motion; NaN = not known
    duration: float  # s, of the longest fitted part
    reference: np.ndarray  # (K, C) reference_k . shape = m at the reference
    reach: float = 1.0  # m that the marker that moves most does per m of the reference, mode 1
    support: Callable | None = None  # Hz -> (C, 3) complex, seen motion per m that it swings
    towards: np.ndarray | None = None  # (C,) seen motion times motion towards the camera, per m2
    behind: float = 0.0  # m that the object's middle is further from the camera than its markers'
    pose: np.ndarray | None = None  # (C,) what swings, at the release; known once it is fitted
    blow: np.ndarray | None = None  # (C,) s, speeds over omega^2 if it was struck; known then
    pitches: np.ndarray | None = None  # (K,) Hz; known once they are fitted
    carried: tuple = ()  # per fitted take, `Carried`; known once it is fitted
    near: object | None = None  # a camera's Nearness, where the rest places show it without doubt
    steps: int = FINE  # of a march, per period of the first mode
    paired: bool = True  # a mode has a degenerate partner that was not matched
    symmetric: bool = True  # the two are one pair by the body's symmetry, which something may part
    pair: int = 0  # of the modes, which one that is
    pair_gap: float | None = None  # relative, that the body itself parts the two by, if known

    def able(self, couples: np.ndarray, spread: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) levers of the places that `couples` (K - 1,) may be, and (n, K - 1) those places.

        spread (K - 1,): standard deviations.
        """
        if not len(self.levers):
            return np.ones(1), couples[None]
        wide = np.hypot(spread, UNSURE * np.abs(self.places).max(axis=0, initial=0.0))
        far = (((self.places - couples) / np.maximum(wide, 1e-12)) ** 2).sum(axis=1)
        near = far <= max(far.min(), 4.0 * max(len(couples), 1))
        return self.levers[near], self.places[near]

    @property
    def stiffer(self) -> float:
        """Stiffness of the declared fit's first mode over that of the final one."""
        if self.pitches is None:
            return 1.0
        return float(self.omega[0] / (2 * np.pi * self.pitches[0])) ** 2

    def lever(self, couples: np.ndarray) -> float:
        """Motion, over the reference's in mode 1, that the known places which `couples` may be have
        in the mean, each counted by its own: what hardly moves is hardly rubbed. Where one mode
        tells nothing of the place, that of the one that moves most.
        """
        if not len(self.levers) or not len(couples):
            return float(self.levers.max(initial=0.0)) or 1.0
        levers, _ = self.able(couples, np.zeros(len(couples)))
        return float((levers**2).sum() / levers.sum())


@dataclass(frozen=True, eq=False)
class Effect:
    """A physical effect. Empty hooks are not its business.

    Time layer, in inner parameters theta (B, p), which are dimensionless (see each file):
      force(theta, setting) -> (State -> (B,))        at one place on the body, per first modal
          mass; where the place is (its share in the higher modes) is fitted too; what it returns
          is called once a step, and may remember. With two `axes`: (2, B), of a State with (2, B)
      acceleration(theta, setting) -> (State -> (K, B))  the same, spread over the modes by itself
      columns(theta, setting, time, u) -> (B, T, q)   motion with a free shape
      beside(theta, omega, zeta, time) -> (B, T, q)   the same, of the modes' own pitches (B, K) as
          they are fitted; it goes before `columns`, which must be as many
      beside_in(take) -> `beside` there               where takes differ in it
      clock(theta, setting, time, take) -> (B, T)     instants at which the model is seen in it
      delay(theta, setting, row) -> (B, C, T)         s, later sight of samples on rows (C, T)
      starts(setting, residual) -> list of theta      where the fit begins
      otherwise(theta (p,)) -> list of theta   what its own numbers, as found with few of the body's
          modes, may be with more of them
      report(theta, setting, shape) -> {name: value}   the contract's parameters; shape (C, q) is
          how strongly each channel shows the columns
      carries(found, i, take) -> (time (N,) -> (N, K))   what effect number i of a fit makes the
          modes do, m, which other effects' forces feel
      alike(theta, setting, shape) -> [{name: value}, ...]   the same, as far from that as what a
          recording cannot show lets it be
    """

    name: str
    layer: str  # "time" | "modal" | "camera" | "computed"; "pair" and "mode" are the body's own
    parameters: tuple[Parameter, ...]
    twins: tuple[str, ...]
    settle: str  # the experiment that would separate it from its twins
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    starts: Callable | None = None
    otherwise: Callable | None = None
    force: Callable | None = None
    places: int = PLACES
    axes: int = 1  # of the force at its place; mode 1 moves that along the first one alone
    acceleration: Callable | None = None
    scales: bool = False  # theta's first number is the strength, either way of which it may act
    damps: bool = False  # what it takes away, a fit without it puts down to the damping ratios
    sudden: bool = False  # so stiff at some instants that it is always marched in FINE steps
    bends: bool = False  # the pitch, by how far it swings, and about another place otherwise
    grows: bool = False  # with time, so that half of a record hardly shows it
    parts: bool = False  # a pair that was heard as one: theta[0] is the other's pitch over that
    columns: Callable | None = None
    beside: Callable | None = None
    beside_in: Callable | None = None
    carries: Callable | None = None
    channels: Callable | None = None  # (theta, setting, take) -> (C,) bool: who has the columns
    clock: Callable | None = None
    delay: Callable | None = None
    report: Callable | None = None
    alike: Callable | None = None
    of_release: bool = False  # the columns belong to how it was let go, and scale with that
    phased: bool = False  # two columns, cos and sin of one swing, whose phase each take has anew
    free: int = 0  # numbers that it takes from the record itself
    given: Callable | None = None  # (take index) -> (T, C), known motion taken off
    veto: Callable | None = None  # (TimeFit) -> why what was fitted is not this effect, or ""
    rival: Callable | None = None  # (TimeFit) -> a plainer Effect that must do worse, or None
    requires: Callable | None = None  # (setting, takes) -> reason why not, or ""
    change_model: Callable | None = None  # modal layer
    nonlinear: bool = False  # modal: its stiffness changes with the swing, which no mode can say
    nothing: tuple[str, float] | None = None  # modal: the parameter, and its value without effect
    families: Callable | None = None  # modal layer: (body, solve) -> Families, each in turn

    @property
    def marched(self) -> bool:
        """Whether the motion has to be simulated with it."""
        return bool(self.force or self.acceleration)


class State(Protocol):
    """A batch of motions at one instant; arrays are good for that instant only."""

    u: np.ndarray  # (K, B) m
    v: np.ndarray  # (K, B) m/s
    t: float  # s
    h: float  # s, the step
    x: np.ndarray  # (B,) m at the effect's place, as mode 1 moves the reference; (2, B) of two axes
    dx: np.ndarray  # the same, m/s


@dataclass(frozen=True, eq=False)
class Family:
    """A body that depends on a modal effect's parameters, reduced to a basis that spans them.

    The basis holds modes solved at several values of the parameters (Noor and Peters, AIAA J. 18
    (1980) 455), or what the change makes of them, so that any value between costs a small dense
    eigenproblem.
    """

    basis: np.ndarray  # (3P, r)
    matrices: Callable  # theta (p,) -> stiffness (s, s) at 1 Pa, mass (s, s)
    grid: np.ndarray  # (n, p) where the search begins
    low: np.ndarray  # (p,)
    high: np.ndarray  # (p,)
    report: Callable  # (theta, youngs_modulus) -> {name: value}
    weight: Callable | None = None  # (theta, gravity) -> (s,) N beside the body's own
    within: Callable | None = None  # theta -> (r, s) what of the basis each of those s unknowns
    # moves, nothing by one that is no motion of the body; without it they are the basis, s = r
    frozen: int = 0  # leading entries of theta that are choices, not numbers
    unknowns: int = 1
    choices: int = 10  # places or forms whose numbers are refined
    rough: bool = False  # of these numbers only the last one
    nearer: Callable | None = None  # thetas, best first -> Families that look closer round some
    size: Callable | None = None  # theta -> how much of the effect it is, where choices may tie


def reduced_basis(parts: list[np.ndarray], mass) -> np.ndarray:
    """(3P, r) mass-orthonormal basis of all columns of `parts` [(3P, n), ...].

    Part by part, what is new in each being scaled up: what stiffens a slender body moves little.
    """
    basis = np.zeros((len(parts[0]), 0))
    for part in parts:
        X = part / np.sqrt(np.einsum("ij,ij->j", part, mass @ part))
        for _ in range(2):
            X = X - basis @ (basis.T @ (mass @ X))
            size = np.sqrt(np.einsum("ij,ij->j", X, mass @ X))
            X = X[:, size > KNOWN] / size[size > KNOWN]
        w, v = np.linalg.eigh(X.T @ (mass @ X))
        keep = w > KNOWN
        basis = np.hstack([basis, X @ (v[:, keep] / np.sqrt(w[keep]))])
    return basis


def as_declared(beside: Callable) -> Callable:
    """The hook `columns` of an effect with the hook `beside`: the same at the declared pitches."""

    def columns(theta, setting, time, u):
        pitches = (np.tile(one, (len(theta), 1)) for one in (setting.omega, setting.zeta))
        return beside(theta, *pitches, time)

    return columns


def is_one(time: np.ndarray) -> bool:
    """Whether all rows (B, T) are the same, as those of a broadcast array are."""
    return time.strides[0] == 0 or not np.ptp(time, axis=0).any()


def ring(omega: np.ndarray, zeta: np.ndarray, time: np.ndarray) -> np.ndarray:
    """cos and sin (B, T, 2) of a free swing; omega and zeta (B, 1), time (B, T)."""
    if len(time) > 1 and is_one(time):  # most of a batch moves something else
        each, of = np.unique((omega + 1j * zeta)[:, 0], return_inverse=True)
        if len(each) < len(time):
            return ring(each.real[:, None], each.imag[:, None], time[: len(each)])[of]
    phase = omega * np.sqrt(1 - zeta**2) * time
    fall = np.exp(-zeta * omega * time)
    return np.stack([fall * np.cos(phase), fall * np.sin(phase)], axis=2)


def of_takes(takes: tuple):
    """The hook `channels` of a motion that only the body in these takes (Take) has, where others
    carry other loads; None where all takes have it.
    """
    return (lambda setting, data: np.full(len(data.sigma), data.take in takes)) if takes else None


def unlike_damping(found, k: int, pitch: int = 0) -> float:
    """By how much, at least, the last effect's damping ratio, its second number, is another than
    that of mode k of takes with that `pitch` (as in the law): the distance of their logarithms,
    less three of its standard deviations; 0 where no mode has one.
    """
    if found.law.damping == "none":
        return 0.0
    at = found.law.modes * (2 * pitch + 1) + (k if found.law.damping == "free" else 0)
    z, own = found.theta[-1][0][1], max(found.parameters[at], 1e-6)
    slope = np.zeros(len(found.parameters))
    slope[len(found.parameters) - len(found.theta[-1][0]) + 1] = 1 / z
    slope[at] = -1 / own
    variance = slope @ found.covariance @ slope * max(found.chi2 / found.samples, 1.0)
    return float(abs(np.log(z / own)) - FAINT * np.sqrt(max(variance, 0.0)))


def companion(found, k: int, condition: int = 0, take: int = 0) -> str:
    """Why the last effect's columns are no motion of another direction than mode k; or "".

    condition, take: whose shape of that mode counts, and whose columns, as in the law.
    """
    alike = shared(found, k, condition, take)
    return f"its shape is that of mode {k + 1}" if alike > SAME_SHAPE else ""


def along_modes(found, seen: np.ndarray, take: int) -> np.ndarray:
    """(K, q) how much of each mode is in what the channels see, (C, q), of a fitted take."""
    data = found.law.takes[found.law.fitted[take]]
    on = ~data.support
    shapes, sigma = found.shapes_of(take)[:, on] / data.sigma[on], data.sigma[on, None]
    return np.linalg.lstsq(shapes.T, seen[on] / sigma, rcond=UNCLEAR)[0]


def shared(found, k: int, condition: int = 0, take: int = 0) -> float:
    """Share, as energy, of the last effect's columns that goes along mode k's shape."""
    first = found.coefficients[:, k + found.law.own * condition]
    first = first / np.linalg.norm(first)
    second = found.column_shapes(take)[-1]
    return float(((first @ second) ** 2).sum() / max((second**2).sum(), 1e-300))


def too_faint(found) -> str:
    """Why the last effect, whose first number is its strength, is none; or ""."""
    theta = found.theta[-1][0]
    at = len(found.parameters) - len(theta)
    spread = np.sqrt(max(found.covariance[at, at] * max(found.chi2 / found.samples, 1.0), 0.0))
    return "its strength may be nought" if abs(theta[0]) < FAINT * spread else ""
