"""Everything that was found, as the report of the contract."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from .advice import advise
from .dac import SURE
from .data import Estimate
from .effects import DAMPING, MODAL_EFFECTS, perspective
from .effects.base import Setting
from .joint import Heard
from .law import TimeFit, unpack
from .match import ACROSS, likeness
from .report import estimate, estimate_of
from .residual import Error, errors, noise_share
from .verdict import Verdict, probabilities

CLEARLY = 0.8  # MAC from which a shape is clearly a computed one's
UNSURE = 10.0  # relative standard deviation of a size, at most
DEAD = np.exp(-2)  # of what a mode was at the release: where less is left, what it was is a guess


def inflation(found: TimeFit) -> float:
    """What the covariance is multiplied by: misfit beyond noise is coloured, not independent.

    A residual that follows the motion repeats itself within a quarter of a period, so its samples
    count as one each such time.
    """
    data = found.law.takes[found.law.fitted[0]]
    together = max(np.pi / 2 / found.law.setting.omega[0] / data.frame, 1.0)
    return 1.0 + max(found.chi2 / max(found.samples, 1) - 1, 0.0) * together


def told_modes(
    heard: Heard, found: TimeFit, computed_pitch: Callable, true: np.ndarray
) -> list[dict]:
    """The report's modes, strongest first.

    computed_pitch(j) -> Hz of computed mode j as the body is found to be. `true` (K,) Hz: the
    measured pitches, unfolded where the frame rate folded them.
    """
    K = found.law.modes
    sigma = np.sqrt(np.maximum(np.diag(found.covariance), 0) * inflation(found))
    body, data = heard.body, found.law.takes[found.law.fitted[0]]
    seen = body.seen(data)
    size = found.swings
    out = []
    for k in np.argsort([-s for s in size]):
        f, fold = true[k], found.frequency[k] / true[k]
        z = found.damping_ratio[k] * fold
        spread = SURE * f * fold * sigma[k], SURE * fold * sigma[K + k]
        j = heard.match.modes[k]
        mac = None if j is None else likeness(found.shapes[k], seen, body.modes.frequency, j)
        if mac is not None and mac < ACROSS and size[k] < max(size):  # it has become another one
            j = mac = None
        out.append(
            {
                "natural_frequency_hz": estimate(f, f - spread[0], f + spread[0]),
                "damping_ratio": estimate(z, max(z - spread[1], 0.0), z + spread[1]),
                "amplitude_m": size[k],
                "model_frequency_hz": None if j is None else computed_pitch(j),
                "mac": None if mac is None else float(np.clip(mac, 0, 1)),
            }
        )
    return out


def each_modulus(heard: Heard, found: TimeFit, true: np.ndarray) -> list[float]:
    """Pa, of the declared body by the pitch of each mode alone whose shape is clearly a computed
    one's; `true` (K,) Hz, its pitches as the modulus that is told makes them.
    """
    body = heard.body
    seen = body.seen(found.law.takes[found.law.fitted[0]])
    out = []
    for k, j in enumerate(heard.match.modes):
        if j is not None and likeness(found.shapes[k], seen, body.modes.frequency, j) > CLEARLY:
            out.append(float((true[k] / body.modes.frequency[j]) ** 2))
    return out


def told_effects(verdict: Verdict, extra: list[dict]) -> list[dict]:
    """The report's effects: of the time layer from the final fit, then `extra` ones."""
    out = []
    final = verdict.final
    own = [c.names[-1] for c in verdict.effects]
    by_name = {e.name: i for i, e in enumerate(final.law.effects)}
    likely = dict(
        zip(
            [c.names[0] for c in verdict.ranked],
            probabilities(list(verdict.ranked), verdict.chain[0][1]),
            strict=True,
        )
    )
    for name, twins in zip(own, verdict.twins, strict=True):
        out.append(
            {
                "name": name,
                "parameters": parameters(final, by_name[name])
                if name in by_name
                else _damping(final, name),
                "probability": float(likely.get(name, 0.5)),
                "twins": list(twins),
            }
        )
    return out + extra


def _damping(found: TimeFit, name: str) -> dict:
    """Parameters of a law of damping, which is the fit's own and no effect added to it."""
    if name not in DAMPING:
        return {}
    law, K = DAMPING[name], found.law.modes
    sigma = np.sqrt(np.maximum(np.diag(found.covariance)[K : 2 * K], 0) * inflation(found))
    out = {}
    for parameter in law.EFFECT.parameters:
        value, spread = law.report(found, sigma)[parameter.name]
        half = SURE * np.hypot(spread, parameter.form * value)
        low = np.maximum(value - half, parameter.low)
        out[parameter.name] = estimate(value, low, value + half, parameter.unit)
    return out


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
    block = found.covariance[at : at + len(theta), at : at + len(theta)] * inflation(found)
    value = effect.report(theta, setting, shape)
    steps = 1e-4 * (1 + np.abs(theta))
    slopes = {name: np.zeros(len(theta)) for name in value}
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
    spread = np.sqrt(np.diag(block))[own : min(len(theta), own + law.modes - 1)]
    return _widened(told, units, _others(effect, theta, (setting, shape, spread)))


def as_fitted(found: TimeFit) -> Setting:
    """What is known of the motion once it is fitted."""
    return replace(
        found.law.setting,
        pose=_pose(found),
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


def _pose(found: TimeFit) -> np.ndarray:
    """(C,) where the swinging part of the first fitted take turned round when it was let go.

    The first frame may be a little later: a mode's size, not its place there, tells how far it was.
    Where it is so much later that a mode has died meanwhile, nothing is known of that one.
    """
    law = found.law
    instants = np.array([[0.0, law.takes[law.fitted[0]].time[0]]])
    omega, _, first, _ = unpack(law, found.parameters[None], 0)
    place, speed = first[0, 0], first[0, 1] / omega[0]
    alive = np.exp(-found.damping_ratio * omega[0] * instants[0, 1]) > DEAD
    pose = np.where(alive, np.copysign(np.hypot(place, speed), place), 0.0) @ found.shapes
    for effect, theta, shape in zip(law.effects, found.theta, found.column_shapes(), strict=True):
        if effect.layer in ("pair", "mode"):
            waves = effect.columns(theta, law.setting, instants, found.motions[0][None, :2])
            first, then = waves[0]
            if np.linalg.norm(then) > DEAD * np.linalg.norm(first):
                pose = pose + shape @ first
    return pose


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


def told_error(
    verdict: Verdict,
    before: Error | None,
    tail: list[tuple[str, Error]],
    instead=(),
    far: TimeFit | None = None,
) -> dict:
    """The report's error: `before` replaces the row of the declared body where its own pitches
    and shapes leave more.

    `tail` are rows (name, error) of effects outside the time layer, put before those in
    it. What the effects named `instead` take belongs to the last of them. `far`: the declared fit
    as the camera was declared, where all others see through a nearer one.
    """
    takes, laws = verdict.final.law.takes, verdict.laws
    rows = [(name, errors(found)) for name, found in verdict.chain[: laws + 1]]
    if before is not None:
        rows[-1] = (rows[-1][0], before)
    rows += tail
    for name, found in verdict.chain[laws + 1 :]:
        if name in instead:
            rows[-1] = (rows[-1][0], errors(found))
        else:
            rows.append((name, errors(found)))
    if far is not None:
        rows[0] = (perspective.EFFECT.name, rows[0][1])
        rows.insert(0, (None, errors(far)))
    after = rows[-1][1]
    told = {
        "floor": noise_share(takes, True),
        "before": rows[0][1].held_out,
        "after": after.held_out,
        "chain": [{"added": name, "held_out": e.held_out, "fit": e.fit} for name, e in rows],
    }
    if len(takes) == 1:
        return told
    each = [{"take": name, "held_out": held, "fit": fit} for name, held, fit in after.each]
    return told | {"takes": each}


def told_diagnosis(heard: Heard, verdict: Verdict, extra: dict) -> dict:
    """The report's diagnosis; `extra` has what the modal layer adds."""
    effects = told_effects(verdict, extra["effects"])
    effects = [e for e in effects if e["name"] not in extra["instead"]]
    effects = sorted(effects, key=lambda e: _turn(e["name"]))
    names = [e["name"] for e in effects]
    twins = [t for e in effects for t in e["twins"]]
    chances = probabilities(list(verdict.ranked), verdict.chain[0][1])
    ranking = [
        {"name": c.names[0], "held_out": errors(c.found).held_out, "probability": float(p)}
        for c, p in zip(verdict.ranked, chances, strict=True)
    ]
    return {
        "verdict": extra["verdict"],
        "effects": effects,
        "ranking": extra["ranking"] + ranking,
        "budget": extra["budget"],
        "advice": extra["advice"] + advise(names, twins, len(heard.match.modes), extra["verdict"]),
        "minor": [
            {"name": n, "share": float(min(s, 1))} for n, s in (*verdict.minor, *extra["minor"])
        ],
    }


def _turn(name: str) -> int:
    """Laws of damping come first and then changes of the body, as in the error's chain."""
    if name in DAMPING:
        return 0
    return 1 if any(e.name == name for e in MODAL_EFFECTS) else 2


def told_modulus(apparent: Estimate, material: Estimate) -> dict:
    """The report's two Young's moduli."""
    return {"apparent": estimate_of(apparent), "material": estimate_of(material)}


def told_claim(claim: float | None, found: Estimate) -> str:
    """How the material's Young's modulus compares with the claimed one (Pa); empty without one."""
    if not claim:
        return ""
    off = found.value / claim - 1
    where = "within" if found.low <= claim <= found.high else "outside"
    return (
        f"Young's modulus is {abs(off):.1%} {'above' if off > 0 else 'below'} the claimed "
        f"{claim:.4g} Pa, which is {where} its interval."
    )


def told_without(names: list[str], modulus: tuple, damping: tuple) -> str:
    """How the found effects bias what is calibrated: Young's modulus (Pa) and the damping ratio of
    the strongest mode, each without them and with them; empty where there are none.
    """
    if not names:
        return ""
    return (
        f"Without {' and '.join(names)} Young's modulus would be {modulus[0]:.4g} Pa, not "
        f"{modulus[1]:.4g} Pa, and the damping ratio {damping[0]:.3g}, not {damping[1]:.3g}."
    )
