"""Everything that was found, as the report of the contract."""

import numpy as np

from .advice import advise
from .dac import SURE
from .data import Estimate
from .effects import DAMPING, MODAL_EFFECTS, perspective
from .joint import Heard
from .law import TimeFit
from .match import ACROSS, likeness
from .parameters import inflation, parameters
from .report import estimate, estimate_of
from .residual import Error, errors, noise_share
from .sufficiency import at_a_bound, bends_the_body, loud
from .verdict import Verdict, probabilities, probability


def told_modes(
    heard: Heard, found: TimeFit, computed_pitch: np.ndarray, true: np.ndarray
) -> list[dict]:
    """The report's modes, strongest first.

    computed_pitch (m,) Hz: of the computed modes, as the body is found to be. `true` (K,) Hz: the
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
        if j is not None and np.isnan(computed_pitch[j]):  # its weight would make it fall
            j = mac = None
        out.append(
            {
                "natural_frequency_hz": estimate(f, f - spread[0], f + spread[0]),
                "damping_ratio": estimate(z, max(z - spread[1], 0.0), z + spread[1]),
                "amplitude_m": size[k],
                "model_frequency_hz": None if j is None else float(computed_pitch[j]),
                "mac": None if mac is None else float(np.clip(mac, 0, 1)),
            }
        )
    return out


def told_effects(verdict: Verdict, extra: list[dict]) -> list[dict]:
    """The report's effects: of the time layer from the final fit, then `extra` ones."""
    out = []
    final = verdict.final
    own = [c.names[-1] for c in verdict.effects]
    by_name = {e.name: i for i, e in enumerate(final.law.effects)}
    for name, twins in zip(own, verdict.twins, strict=True):
        out.append(
            {
                "name": name,
                "parameters": parameters(final, by_name[name])
                if name in by_name
                else _damping(final, name),
                "probability": probability(verdict, name),
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
            {"name": n, "share": float(min(s, 1))}
            for n, s in (*verdict.minor, *extra["minor"])
            if n not in names  # in part it may be one that the body's modes take up
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


def told_sizes(found: TimeFit) -> str:
    """That what was found fits only in another body; empty where it fits in this one."""
    if not bends_the_body(found):
        return ""
    off = found.sizes_off[loud(found)].max()
    return (
        f"What was found fits only where modes move {100 * off:.0f}% more or less than the body's "
        "do: something else acts, or mesh, density or pins are not the object's."
    )


def told_bounds(found: TimeFit, declared: TimeFit) -> str:
    """Which of what was found would have to be as strong as nothing is; empty where none would."""
    beyond = at_a_bound(found, declared)
    if not beyond:
        return ""
    return f"{' and '.join(beyond)} would have to be as strong as nothing is: something else acts."


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
