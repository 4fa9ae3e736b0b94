"""The law that the tracks are fitted by, and what a fit of it knows."""

from dataclasses import dataclass, replace  # noqa: F401  (replace is re-exported)
from functools import cached_property

import numpy as np

from .channels import Channels
from .effects.base import Effect, Setting

SAME = 1e-6  # relative difference of two computed pitches that are one
TRUST = 20.0  # 1 / 0.05: computed modes' sizes are known to five per cent, their masses to ten
FARTHEST = 30.0  # most that a place moves in a higher mode over the first
BEYOND = 1.5  # times the most that any known place does: computed shapes are not exact


@dataclass(frozen=True, eq=False)
class Elsewhere:
    """How a take whose loads or gravity no fitted take has differs from the first fitted one."""

    pitch: np.ndarray  # (K,) log of each mode's pitch over that in the first
    shapes: tuple  # (K, C) of the first, and its own, channels' unit per metre at the reference
    sag: np.ndarray  # (C,) of the first at 1 Pa, in the channels' unit; nought where not known
    more: np.ndarray  # (C,) what its own sag is more
    held: bool  # the places are those without a sag, from where both may have been let go
    omega: float  # rad/s, of the first mode in the first at 1 Pa

    @property
    def strength(self) -> float:
        """How far it was held, over that of the first one, where both were."""
        return float(1 + self.more @ self.sag / (self.sag @ self.sag))

    @property
    def rings_alike(self) -> bool:
        """Whether the body has the same pitches in both."""
        return bool((np.abs(self.pitch) < SAME).all())


@dataclass(frozen=True, eq=False)
class Law:
    """What is fitted: how many modes, how they lose energy, with which effects."""

    takes: tuple[Channels, ...]
    condition: tuple[int, ...]  # per take: whose shapes it shares
    pitch: tuple[int, ...]  # per take: which loads and gravity; pitch and damping are shared
    reference: np.ndarray  # (K, C) weights: reference_k . S_k = 1, to 1/trust but for the first
    setting: Setting
    damping: str = "free"  # "free" | "common" | "none"
    effects: tuple[Effect, ...] = ()
    turning: tuple[int, ...] = ()  # modes of a degenerate pair, whose motion may be an ellipse
    ways: tuple[np.ndarray, ...] = ()  # (C, w) of each mode, how what sounds as one with it is seen
    trust: float = TRUST  # weight that keeps the other modes' shapes at one at their references
    gauges: tuple[np.ndarray, ...] = ()  # the reference of every condition, where there are more
    tied: tuple[tuple[int, float], ...] = ()  # (mode, log of its computed pitch over the first's)
    elsewhere: tuple[Elsewhere | None, ...] = ()  # per take; none where a fitted one is like it

    def gauge(self, condition: int) -> np.ndarray:
        """(K, C) weights that keep a condition's shapes at one."""
        return self.gauges[condition] if self.gauges else self.reference

    @property
    def modes(self) -> int:
        return len(self.reference)

    @property
    def conditions(self) -> int:
        """How many sets of shapes there are."""
        return max(self.condition[i] for i in self.fitted) + 1

    @property
    def own(self) -> int:
        """Columns of one condition's modes: one each, two for those that may turn."""
        return self.modes + len(self.turning)

    @property
    def fitted(self) -> list[int]:
        """Takes that take part in the fit."""
        return [i for i, t in enumerate(self.takes) if not t.take.held_out]

    def loaded_alike(self, fitted: int) -> tuple:
        """The takes with the loads of that fitted one; none where all have the same."""
        own = self.pitch[self.fitted[fitted]]
        if len({self.pitch[i] for i in self.fitted}) == 1:
            return ()
        pairs = zip(self.takes, self.pitch, strict=True)
        return tuple(data.take for data, pitch in pairs if pitch == own)

    def sizes(self) -> tuple[int, int, int]:
        """Numbers of parameters for pitch and damping, starts, effects."""
        inner = sum(numbers(e, self.modes) for e in self.effects)
        pitches = max(self.pitch[i] for i in self.fitted) + 1
        return 2 * self.modes * pitches, 2 * self.modes * len(self.fitted), inner


@dataclass(frozen=True, eq=False)
class TimeFit:
    """A fitted law, with what it leaves."""

    law: Law
    parameters: np.ndarray
    covariance: np.ndarray
    coefficients: np.ndarray  # (C, nb)
    predicted: tuple[np.ndarray, ...]  # per take (T, C), fit and held-out part
    chi2: float  # over the fitted samples, with what holds the references
    samples: int
    unknowns: float  # a force's columns count as much as they tell, at most
    residuals: np.ndarray  # (R,) noise units
    jacobian: np.ndarray  # (R, p)
    motions: tuple[np.ndarray, ...] = ()  # per fitted take (T, K) u

    @property
    def frequency(self) -> np.ndarray:
        """(K,) Hz natural, of the first condition"""
        return np.exp(self.parameters[: self.law.modes])

    def pitches(self, take: int) -> np.ndarray:
        """(K,) Hz of the modes in the fitted take of that number."""
        at = 2 * self.law.modes * self.law.pitch[self.law.fitted[take]]
        return np.exp(self.parameters[at : at + self.law.modes])

    @property
    def damping_ratio(self) -> np.ndarray:
        """(K,) in the first condition"""
        return self._damping(0)

    def damping_ratios(self, take: int) -> np.ndarray:
        """(K,) of the modes in the fitted take of that number."""
        return self._damping(self.law.pitch[self.law.fitted[take]])

    def _damping(self, pitch: int) -> np.ndarray:
        K = self.law.modes
        if self.law.damping == "none":
            return np.zeros(K)
        z = self.parameters[2 * K * pitch + K : 2 * K * (pitch + 1)]
        return np.full(K, z[0]) if self.law.damping == "common" else z

    @cached_property
    def tangents(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q (R, p), r (p, p), scale (p,): the Jacobian is q r, each column times its scale."""
        scale = np.linalg.norm(self.jacobian, axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        return *np.linalg.qr(self.jacobian / scale), scale

    @property
    def theta(self) -> list[np.ndarray]:
        """Inner parameters, one array an effect."""
        a, b, _ = self.law.sizes()
        return split_inner(self.law, self.parameters[None, a + b :])

    def missed(self, take: int) -> np.ndarray:
        """(T, C) what the fitted take of that number has that the fit has not, in its unit."""
        index = self.law.fitted[take]
        return self.law.takes[index].values - self.predicted[index]

    def rest(self, take: int = 0) -> np.ndarray:
        """(C,) where the channels come to rest in the fitted take of that number."""
        law = self.law
        return self.coefficients[:, law.own * law.conditions + take * (1 + sum(widths(law)))]

    def column_shapes(self, take: int = 0) -> list[np.ndarray]:
        """(C, q) of every effect, from fitted take number `take`; q may be 0."""
        law = self.law
        each = widths(law)
        at = law.own * law.conditions + take * (1 + sum(each)) + 1
        out = {}
        for effect in with_columns(law):
            width = each[law.effects.index(effect)]
            out[law.effects.index(effect)] = self.coefficients[:, at : at + width]
            at += width
        none = np.zeros((len(self.coefficients), 0))
        return [out.get(i, none) for i in range(len(law.effects))]

    @property
    def swings(self) -> list[float]:
        """(K,) m, the most that each mode moves its reference in the first fitted take."""
        return [float(u) for u in (self._at_reference * np.abs(self.motions[0])).max(axis=0)]

    @property
    def loudest(self) -> int:
        """Which mode moves its reference most in the first fitted take, rms: one that starts large
        and dies at once may be none.
        """
        return int(np.argmax(self._at_reference * np.sqrt((self.motions[0] ** 2).mean(axis=0))))

    @property
    def _at_reference(self) -> np.ndarray:
        """(K,) |m| that each mode moves its reference by, per m of its motion."""
        return np.abs(np.einsum("kc,kc->k", self.law.gauge(0), self.shapes))

    @property
    def sizes_off(self) -> np.ndarray:
        """(K,) how far each mode's shape is from its size in the body, relative, in the first
        condition: what a force does in others is worked out by the references of this one.
        """
        return np.abs(1 - np.einsum("kc,kc->k", self.law.gauge(0), self.shapes))

    def shapes_of(self, take: int) -> np.ndarray:
        """(K, C) in the fitted take of that number, as `shapes`."""
        at = self.law.own * self.law.condition[self.law.fitted[take]]
        return self.coefficients[:, at : at + self.law.modes].T

    @property
    def shapes(self) -> np.ndarray:
        """(K, C) of the first condition, channels' unit per metre at the reference."""
        return self.coefficients[:, : self.law.modes].T


def numbers(effect: Effect, modes: int) -> int:
    """How many inner parameters it has: its own, and where a force sits."""
    return len(effect.low) + (effect.axes * (modes - 1) if effect.force else 0)


def bounds(effect: Effect, modes: int, places=None) -> tuple[np.ndarray, np.ndarray]:
    """Of the inner parameters: its own, then where a force sits, by its share in higher modes.

    places (Q, modes - 1): those shares where they are known, first the reference's, which alone
    tells nothing; no place has a much larger one.
    """
    spread = np.full(modes - 1 if effect.force else 0, FARTHEST)
    if len(spread) and places is not None and len(places) > 1:
        spread = np.minimum(spread, BEYOND * np.abs(places).max(axis=0))
    spread = np.tile(spread, effect.axes)
    return np.r_[effect.low, -spread], np.r_[effect.high, spread]


def with_columns(law: Law) -> list[Effect]:
    """The effects that have columns, in the order of these: forces' traces first."""
    return [e for e in law.effects if e.force] + [e for e in law.effects if e.columns]


def widths(law: Law) -> list[int]:
    """Columns of every effect, by asking it for two instants."""
    some, u = np.zeros((1, 2)), np.zeros((1, 2, law.modes))
    out = []
    for effect in law.effects:
        low, high = bounds(effect, law.modes)
        middle = ((low + high) / 2)[None]
        width = effect.columns(middle, law.setting, some, u).shape[2] if effect.columns else 0
        out.append(width + (effect.axes if effect.force else 0))
    return out


def split_inner(law: Law, theta):
    out, at = [], 0
    for effect in law.effects:
        width = numbers(effect, law.modes)
        out.append(theta[:, at : at + width])
        at += width
    return out


def unpack(law: Law, P: np.ndarray, take: int):
    """omega (B, K), zeta (B, K), start (B, 2, K), thetas of the fitted take number `take`."""
    K = law.modes
    a, b, _ = law.sizes()
    at = 2 * K * law.pitch[law.fitted[take]]
    omega = 2 * np.pi * np.exp(P[:, at : at + K])
    zeta = P[:, at + K : at + 2 * K]
    if law.damping == "common":
        zeta = np.repeat(zeta[:, :1], K, axis=1)
    if law.damping == "none":
        zeta = np.zeros_like(zeta)
    start = P[:, a + 2 * K * take : a + 2 * K * (take + 1)].reshape(-1, 2, K)
    start = start * np.stack([np.ones_like(omega), omega], axis=1)
    return omega, zeta, start, split_inner(law, P[:, a + b :])
