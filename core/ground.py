"""What was measured of the body, beside the body as it is declared."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import beta

from .baseline import px_per_metre, real_shapes
from .body import Body
from .camera_layer import true_frequency
from .channels import Channels
from .compare import PITCH_FLOOR, SHAPE_FLOOR, Hypothesis, Measured, compare, rematched
from .diagnosis import Verdict
from .effects import relaxation, split_modes
from .effects.aliasing import is_folded, unfolded
from .effects.further_mode import is_a_mode, of_take, pitch_of
from .elasticity import gravity_force, static
from .joint import Heard
from .law import TimeFit, replace
from .match import CHANCE, PAIR, SURE, dies_alike, likeness
from .tell import as_fitted, inflation, parameters

UNSURE = 2.0  # of a pitch's standard deviation, by which it is off: a faint pole may be two modes
LOUD = 0.3  # of the strongest mode's motion, rms, from which one that was not matched counts
OWN = 0.4  # likeness to a computed mode from which a fainter one does too
UNSEEN = 0.05  # of the most that a mode moves: one that moves less, where it is seen, is not known
SPILL = 0.3  # of what is left in a channel may have gone into a mode's shape
BIASED = 0.5  # of the most that effects in time moved a pitch by, that all may be off by
SETTLED = 0.05  # of the sag: error of geometry, density and a creep that nothing shows
CREPT = 0.15  # the same where a creep may be at work
TILTED = 1.4  # of the sag over the length: how far a cantilever's end turns


@dataclass(frozen=True, eq=False)
class Ground:
    """What every suspect is fitted on."""

    body: Body
    data: Channels
    measured: Measured
    base: Hypothesis
    shrink: np.ndarray  # (m,) converged over computed eigenvalues
    doubt: np.ndarray  # (m,) relative error of an eigenvalue, and of how a load sits
    damping_ratio: np.ndarray  # (K,) of the measured modes, without what acts in time
    pull: np.ndarray | None = None  # (3P,) N, the body's own weight where the sag is known


def ground_of(heard: Heard, verdict: Verdict, stiff, sigma) -> Ground | None:
    final = verdict.final
    data = final.law.takes[final.law.fitted[0]]
    body = heard.body
    further = [_unfolded(one, body.seen(data), heard, final) for one in further_modes(verdict)]
    further = _of_the_body(further, body.seen(data), heard)
    model_error = sigma[list(heard.match.modes)]
    model_error = np.r_[model_error, np.full(len(further), sigma.max())]
    at = [*range(final.law.modes), *(one.at for one in further)]
    spread = np.sqrt(np.maximum(np.diag(final.covariance)[at], 0) * inflation(final))
    bias = BIASED * max(moved(final, verdict.damped), _bent(final))
    error = np.sqrt((UNSURE * spread) ** 2 + bias**2 + (0.5 * model_error) ** 2 + PITCH_FLOOR**2)
    middle, pair = split_modes.middle(final), final.law.setting.pair
    error[pair] = np.hypot(error[pair], split_modes.doubt(final))
    error[: final.law.modes] = np.hypot(error[: final.law.modes], _blurred(heard, final))
    pitches = np.r_[true_frequency(heard, final), [one.frequency for one in further]]
    pitches[pair] *= middle
    samples = max(int(data.fit.sum()), 1)
    shapes = np.vstack([final.shapes, *(one.shape for one in further)])
    size = np.abs(shapes).max(axis=1, keepdims=True)
    swing = np.array([*(u.std() for u in final.motions[0].T), *(one.swing for one in further)])
    left = (data.values - final.predicted[final.law.fitted[0]])[data.fit]
    rest = SPILL * np.sqrt(np.nanmean(left**2, axis=0)) / np.maximum(swing[:, None], 1e-300)
    noise = data.sigma / np.maximum(swing[:, None], 1e-300) / np.sqrt(samples / 2)
    shape_error = np.sqrt(noise**2 + rest**2 + (SHAPE_FLOOR * size) ** 2)
    shape_error = np.where(data.support, 1e12, shape_error)
    sag, pull, unit = None, None, None
    case = body.case
    if case.shape == "unloaded" and case.takes[0].gravity is not None:
        offset = final.coefficients[:, final.law.own * final.law.conditions]
        sag = np.where(data.support, 0.0, offset - data.rest)
        pull = gravity_force(body.model, case.takes[0].gravity)
        unit = body.seen(data, static(body.model, pull, 1.0)[:, :, None])[0]
        length = np.ptp(body.model.points, axis=0).max()
        tilt = TILTED * np.abs(sag).max() / px_per_metre(data) / length
        shape_error = np.hypot(shape_error, tilt * size)  # it swings about where it hangs
    measured = Measured(
        pitches,
        error,
        shapes,
        shape_error,
        sag,
        softer(final)[0],
        CREPT if creeps(verdict) else SETTLED,
    )
    shrink = 1 / (1 + stiff)
    values = (2 * np.pi * body.modes.frequency) ** 2 * shrink
    base = compare(measured, values, body.seen(data), unit)
    if base is None:
        return None
    base = rematched(measured, values, body.seen(data), unit, base)
    if middle != 1:
        measured = parted(measured, base.modes, body.modes.frequency, (pair, middle - 1))
        base = rematched(
            measured,
            values,
            body.seen(data),
            unit,
            compare(measured, values, body.seen(data), unit) or base,
        )
    ratios = np.r_[verdict.damped.damping_ratio, [one.damping_ratio for one in further]]
    return Ground(body, data, measured, base, shrink, sigma, ratios, pull)


def parted(measured: Measured, modes: tuple, own: np.ndarray, split: tuple) -> Measured:
    """The measurements where a pair of the body (computed pitches `own` (m,) Hz) is parted, whose
    middle was taken: what parts one pair parts the others, this way or that.

    split: the number of that pair's mode, and half of what it is parted by, relatively.
    """
    pair, half = split
    paired = (np.abs(own[:, None] / own[list(modes)] - 1) < PAIR).sum(axis=0) > 1
    paired[pair] = False
    error = np.where(paired, np.hypot(measured.error, half), measured.error)
    return replace(measured, error=error)


def _blurred(heard: Heard, final: TimeFit) -> np.ndarray:
    """(K,) relative, how far computed modes that were not matched lie from each mode but the
    strongest, those within its half-width, or its width where it is heard between the two: they may
    sound as one.
    """
    own, matched = heard.body.modes.frequency, list(heard.match.modes)
    strongest = int(np.argmax(final.swings))
    scaled = np.log(own / own[matched[strongest]] * final.frequency[strongest])
    at, heard_at = scaled[matched][:, None], np.log(final.frequency)[:, None]
    others = np.delete(scaled, matched)
    gaps, half = np.abs(others - at), final.damping_ratio[:, None]
    between = (heard_at - at) * (others - heard_at) > 0
    far = np.where(gaps < np.where(between, 2 * half, half), gaps, 0.0).max(axis=1)
    far[strongest] = 0.0
    return far


@dataclass(frozen=True, eq=False)
class FurtherMode:
    """A mode that no computed one was matched to."""

    frequency: float  # Hz
    damping_ratio: float
    shape: np.ndarray  # (C,)
    swing: float  # rms of what the shape is multiplied by
    loud: float  # motion over that of the strongest matched mode, rms
    at: int  # of its pitch among the fit's parameters


def further_modes(verdict: Verdict) -> list[FurtherMode]:
    """The further modes of a take in which nothing acts in time but a pair that is parted."""
    final = verdict.final
    law = final.law
    if acts(final, but=split_modes.EFFECT.name):
        return []
    data = law.takes[law.fitted[0]]
    known = np.sqrt(((final.motions[0].std(axis=0)[:, None] * final.shapes) ** 2).sum(axis=1))
    shapes, first = final.column_shapes(), sum(law.sizes()[:2])
    out = []
    for i, effect, theta in of_take(final, 0):
        if is_a_mode(effect, theta):
            own = final.theta[i], law.setting, data.time[None], final.motions[0][None]
            swing = float(effect.columns(*own)[0].std(axis=0).mean())
            real = real_shapes((shapes[i] @ np.array([1, -1j]))[None])[0][0]
            loud = float(swing * np.linalg.norm(real) / known.max())
            at = first + sum(t.shape[1] for t in final.theta[:i])
            out.append(FurtherMode(pitch_of(effect, theta), float(theta[1]), real, swing, loud, at))
    return out


def _unfolded(one: FurtherMode, seen: np.ndarray, heard: Heard, final: TimeFit) -> FurtherMode:
    """The mode as it is, where what shows is the fold of the computed one that it is most like."""
    data, frequency = final.law.takes[final.law.fitted[0]], heard.body.modes.frequency
    own, rate = true_frequency(heard, final), 1 / data.frame
    computed = frequency * own[0] / frequency[heard.match.modes[0]]
    free = [j for j in range(len(computed)) if j not in heard.match.modes]
    best = max(free, key=lambda j: likeness(one.shape, seen, frequency, j), default=None)
    z = one.damping_ratio
    damped = one.frequency * np.sqrt(1 - z**2)
    if best is None or likeness(one.shape, seen, frequency, best) < SURE:
        return one
    if not is_folded(damped, computed[best], rate):
        return one
    true = float(np.hypot(unfolded(damped, computed[best], rate), z * one.frequency))
    if not dies_alike(one.frequency, z, true, (own[0], None, final.damping_ratio[0])):
        return one
    return replace(one, frequency=true, damping_ratio=z * one.frequency / true)


def _of_the_body(further: list[FurtherMode], seen: np.ndarray, heard: Heard) -> list[FurtherMode]:
    """Those that tell of the body: whatever is loud, for a body that is as declared shows no loud
    mode that it does not have, and what moves as one of its modes (m, C) that was not matched.
    """
    size = np.linalg.norm(seen, axis=1)
    free = [j for j in np.flatnonzero(size > UNSEEN * size.max()) if j not in heard.match.modes]
    frequency = heard.body.modes.frequency
    return [
        one
        for one in further
        if one.loud > LOUD or any(_moves_as(one.shape, seen, frequency, j, len(free)) for j in free)
    ]


def _moves_as(shape: np.ndarray, seen: np.ndarray, frequency: np.ndarray, j: int, of: int) -> bool:
    """Whether a shape is that of mode j, as one that is none would not be by chance with any `of`
    so many: its likeness to k directions among C is then of the Beta distribution.
    """
    k = (np.abs(frequency / frequency[j] - 1) < PAIR).sum()
    alike, channels = likeness(shape, seen, frequency, j), (np.abs(seen) > 0).any(axis=0).sum()
    if alike <= OWN or channels <= k:
        return False
    return bool(of * beta.sf(alike, k / 2, (channels - k) / 2) < CHANCE)


def moved(final: TimeFit, declared: TimeFit) -> float:
    """The most, relatively, that the effects in time moved a pitch by."""
    return float(np.abs(np.log(final.frequency / declared.frequency)).max())


def _bent(final: TimeFit) -> float:
    """How far the pitches of the two sides of an uneven stiffness lie from their middle."""
    told = [
        parameters(final, i)["ratio"]["value"]
        for i, effect in enumerate(final.law.effects)
        if effect.name == "asymmetric_stiffness"
    ]
    return float(np.log(max(told, default=1.0)) / 4)


def acts(final: TimeFit, but: str = "") -> bool:
    """Whether an effect in time, declared or found, is in the fit; `but` names one not counted."""
    return any(e.layer in ("time", "camera") and e.name != but for e in final.law.effects)


def creeps(verdict: Verdict) -> bool:
    """Whether something moves the mean that may be a creep, which goes on after the recording."""
    there = [effect.name for effect in verdict.final.law.effects]
    return "relaxation" in [*there, *(t for ts in verdict.twins for t in ts)]


def softer(final: TimeFit) -> tuple[float, float]:
    """Static over dynamic stiffness where a relaxation was found, and the least that it may be."""
    shapes = final.column_shapes()
    for i, effect in enumerate(final.law.effects):
        if effect.name == "relaxation":
            returned = relaxation.returns(as_fitted(final), shapes[i])
            stiff, time = relaxation.branches(final.theta[i][0], returned)
            turns = (2 * np.pi * final.frequency[0] * time) ** 2
            follows = (stiff * turns / (1 + turns)).sum() / max(stiff.sum(), 1e-300)
            told = parameters(final, i)["ratio"]
            return tuple(1 / (1 + ratio * follows) for ratio in (told["value"], told["ci95"][1]))
    return 1.0, 1.0
