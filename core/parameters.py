"""An effect's numbers in the contract's units, each with an interval."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from .dac import SURE
from .effects import perspective
from .effects.base import Setting
from .law import TimeFit, unpack
from .report import estimate

UNSURE = 10.0  # relative standard deviation of a size, at most
STRUCK = 0.05  # of its speed's share, squared, up to which a body is all but straight: 13 degrees
PUSHED = 1.0  # the same of a body that was seen at rest before: it was held nowhere
STANDS = 0.3  # of the swing's rms, by which a body that is held stands off at least
SOON = 1e-3  # rad of the first mode, over which a slope is taken
DEAD = np.exp(-2)  # of what a mode was at the release: where less is left, what it was is a guess


def inflation(found: TimeFit) -> float:
    """What the covariance is multiplied by: misfit beyond noise is coloured, not independent.

    A residual that follows the motion repeats itself within a quarter of a period, so its samples
    count as one each such time.
    """
    data = found.law.takes[found.law.fitted[0]]
    together = max(np.pi / 2 / found.law.setting.omega[0] / data.frame, 1.0)
    return 1.0 + max(found.chi2 / max(found.samples, 1) - 1, 0.0) * together


def parameters(found: TimeFit, index: int) -> dict:
    """The contract's parameters of effect number `index` with intervals by the delta method."""
    law = found.law
    effect, theta = law.effects[index], found.theta[index][0]
    if effect.report is None:
        return {}
    shape = found.column_shapes()[index]
    setting = as_fitted(found)
    a, b, _ = law.sizes()
    at = a + b + sum(len(t[0]) for t in found.theta[:index])
    where = [*range(at, at + len(theta)), *([setting.pair] if effect.parts else [])]
    block = found.covariance[np.ix_(where, where)] * inflation(found)
    value = effect.report(theta, setting, shape)
    steps = 1e-4 * (1 + np.abs(theta))
    slopes = {name: np.zeros(len(where)) for name in value}
    if effect.parts:  # one is told from the other one of the pair, which is fitted along
        beside = effect.report(theta, _with_pair(setting, 1e-6), shape)
        for name, other in beside.items():
            slopes[name][-1] = (other - value[name]) / 1e-6
    for i, step in enumerate(steps[: len(effect.low)]):
        moved = theta.copy()
        moved[i] += step
        for name, other in effect.report(moved, setting, shape).items():
            if isinstance(other, float | np.floating):
                slopes[name][i] = (other - value[name]) / step
    doubt = _doubt_of_sizes(found, index, shape)
    if len(doubt):  # the shapes' sizes are uncertain too: more columns, independent of theta
        block = block_diag(block, doubt)
        for name, one in value.items():
            if not isinstance(one, float | np.floating):
                slopes[name] = None
        for grown in 1 + 1e-4 * np.eye(len(doubt)):
            for name, other in effect.report(theta, setting, shape * grown).items():
                if slopes[name] is not None:
                    slopes[name] = np.r_[slopes[name], (other - value[name]) / 1e-4]
    units = {p.name: p for p in effect.parameters}
    told = {
        name: _told(one, slopes[name], block, units[name])
        for name, one in value.items()
        if not (isinstance(one, float | np.floating) and not np.isfinite(one))
    }
    own = len(effect.low)
    spread = np.sqrt(np.maximum(np.diag(block), 0))[own : min(len(theta), own + law.modes - 1)]
    return _widened(told, units, _others(effect, theta, (setting, shape, spread)))


def _with_pair(setting: Setting, more: float) -> Setting:
    """The same where the pitch of the mode that has a partner is relatively so much more."""
    moved = np.arange(len(setting.pitches)) == setting.pair
    return replace(setting, pitches=setting.pitches * np.exp(more * moved))


def as_fitted(found: TimeFit) -> Setting:
    """What is known of the motion once it is fitted."""
    return replace(
        found.law.setting,
        **_release(found),
        pitches=found.frequency,
        near=perspective.near(found),
    )


def _others(effect, theta, known):
    """The effect as it would be told of every place where its force may act, and of what else
    looks the same.
    """
    setting, shape, spread = known
    own = len(effect.low)
    if effect.alike is not None:
        yield from effect.alike(theta, setting, shape)
    if effect.force:
        couples = theta[own : own + len(spread)]
        for lever, place in zip(*setting.able(couples, spread), strict=True):
            there = replace(setting, levers=np.array([lever]), places=place[None])
            yield effect.report(np.r_[theta[:own], place], there, shape)


def _widened(told: dict, known: dict, others) -> dict:
    """The parameters with intervals that hold them as told in the `others`, equally unsure."""
    others, out = list(others), {}
    for name, one in told.items():
        out[name] = one
        if one["ci95"] is not None and one["value"]:
            changes = np.array([1.0, *(other[name] / one["value"] for other in others)])
            ends = np.outer(one["ci95"], changes[np.isfinite(changes)])
            ends = np.clip(ends, known[name].low, known[name].high)
            out[name] = estimate(one["value"], ends.min(), ends.max(), one["unit"])
    return out


def _release(found: TimeFit) -> dict:
    """The `pose` (C,) m where the swinging part of the first fitted take turned round when it was
    let go, and the `blow` (C,) m s by which it was set going where it was struck.

    The first frame may be a little later: a mode's size, not its place there, tells how far it was
    held. Where it is so much later that a mode has died meanwhile, nothing is known of that one.
    """
    law, shapes = found.law, found.shapes
    omega, _, start, _ = unpack(law, found.parameters[None], 0)
    omega, (place, speed) = omega[0], start[0]
    instants = np.array([[0.0, SOON / omega[0], law.takes[law.fitted[0]].time[0]]])
    alive = np.exp(-found.damping_ratio * omega * instants[0, 2]) > DEAD
    place, speed = np.where(alive, (place, speed), 0.0)
    at, turning = law.own * law.condition[law.fitted[0]] + law.modes, list(law.turning)
    turned = found.coefficients[:, at : at + len(turning)] / omega[turning]  # what moves as speeds
    pose = np.copysign(np.hypot(place, speed / omega), place) @ shapes
    there = place @ shapes + turned @ speed[turning]
    across = (speed / omega) @ shapes - turned @ (place * omega)[turning]
    blow = (speed / omega**2) @ shapes - turned @ place[turning]
    for effect, theta, shape in zip(law.effects, found.theta, found.column_shapes(), strict=True):
        if effect.phased and effect.of_release:
            waves = effect.columns(theta, law.setting, instants, found.motions[0][None, :3])
            first, soon, then = waves[0]
            if np.linalg.norm(then) > DEAD * np.linalg.norm(first):
                slope = shape @ (soon - first) / instants[0, 1]
                pitch = np.linalg.norm(soon - first) / instants[0, 1]  # of a cosine and a sine
                pose, there = pose + shape @ first, there + shape @ first
                across, blow = across + slope / pitch, blow + slope / pitch**2
    struck = there @ there < _straight(found) * (across @ across)
    return {"pose": pose, "blow": blow if struck else None}


def _straight(found: TimeFit) -> float:
    """`PUSHED` where the body was seen before the first fitted take as it hangs at rest, nought
    where it stood elsewhere; unseen `STRUCK`, and little where no start is shown, for it may begin
    in the midst of a swing.
    """
    law = found.law
    data = law.takes[law.fitted[0]]
    if not np.isfinite(data.quiet).any():
        return STRUCK if data.take.recording.start is not None else STRUCK / 10
    rest = found.rest()
    swing = np.linalg.norm(found.motions[0].std(axis=0)[:, None] * found.shapes, axis=0)
    off = np.where(data.support | ~np.isfinite(data.quiet), 0.0, data.quiet - rest)
    return 0.0 if np.linalg.norm(off) > STANDS * np.linalg.norm(swing) else PUSHED


def _doubt_of_sizes(found: TimeFit, index: int, shape: np.ndarray) -> np.ndarray:
    """(q, q) relative covariance of the sizes of an effect's own shapes (C, q); empty without."""
    law = found.law
    effect = law.effects[index]
    data = law.takes[law.fitted[0]]
    if not effect.columns or not shape.any():
        return np.zeros((0, 0))
    columns = effect.columns(
        found.theta[index], law.setting, data.time[None], found.motions[0][None]
    )[0][data.fit]
    columns = columns - columns.mean(axis=0)
    noise = inflation(found) * ((law.reference[0] * data.sigma) ** 2).sum()
    doubt = noise * np.linalg.pinv(columns.T @ columns)
    sizes = law.reference[0] @ shape
    sizes = np.copysign(np.maximum(np.abs(sizes), np.sqrt(np.diag(doubt)) / UNSURE), sizes)
    return doubt / np.outer(sizes, sizes)


def _told(value, slope, block, parameter) -> dict:
    if isinstance(value, list):
        return {"value": value, "ci95": None, "unit": parameter.unit}
    if slope is None:
        return estimate(value, value, value, parameter.unit)
    spread = np.sqrt(max(slope @ block @ slope, 0.0))
    half = SURE * float(np.hypot(spread, parameter.form * abs(value)))
    if not np.isfinite(half):
        half = abs(float(value))
    value = float(np.clip(value, parameter.low, parameter.high))
    low = max(value - half, parameter.low)
    high = min(value + half, parameter.high)
    return estimate(value, float(low), float(high), parameter.unit)
