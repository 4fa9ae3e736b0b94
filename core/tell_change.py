"""A change of the body, as the report tells it."""

import numpy as np

from .body_error import body_error
from .compare import Hypothesis
from .dac import SURE
from .ground import Ground
from .joint import Heard
from .modal_layer import Suspect
from .report import estimate
from .verdict import Verdict

CLEAR = 3.0  # times the noise of a sample, from which a sag tells of a clock
NEARLY = 0.8  # of the best one's gain makes a twin


def told_change(best: Suspect, ranked: list[Suspect]) -> dict:
    """The report's effect; `ranked`: all suspects, best evidence first, `best` among them."""
    gain = max(best.evidence, 1e-9)
    twins = [s.effect.name for s in ranked if s is not best and s.evidence >= NEARLY * gain]
    return {
        "name": best.effect.name,
        "parameters": _parameters(best),
        "probability": _chances(ranked)[ranked.index(best)],
        "twins": twins,
    }


def ranking(ranked: list[Suspect], verdict: Verdict, ground: Ground) -> list[dict]:
    """The report's rows of the suspects, best evidence first."""
    return [
        {
            "name": s.effect.name,
            "held_out": body_error(verdict.damped, ground, s.hypothesis).held_out,
            "probability": p,
        }
        for s, p in zip(ranked, _chances(ranked), strict=True)
    ]


def modulus_spans(one: Suspect, ground: Ground, heard: Heard) -> dict[int, tuple[float, float]]:
    """By computed mode, the least and the most Young's modulus over the best one, as far as the
    effect is known, and as the sag says otherwise.
    """
    (least, most), by_sag = one.moduli, sag_span(ground, one.hypothesis)
    return {j: (least[k] * by_sag[0], most[k] * by_sag[1]) for k, j in enumerate(heard.match.modes)}


def mesh_pitches(best: Suspect, heard: Heard, stiff: np.ndarray) -> dict[int, float]:
    """Hz at 1 Pa of every measured mode's computed partner with the effect in the body.

    stiff (m,): how much too great this mesh's eigenvalues are, relatively.
    """
    found, own = best.hypothesis, best.hypothesis.pitches
    return {
        j: float(own[k] * np.sqrt(1 + stiff[min(found.modes[k], len(stiff) - 1)]))
        for k, j in enumerate(heard.match.modes)
    }


def body_lines(ground: Ground, body: Hypothesis) -> list[str]:
    """What is told of a body beside its name: its sag, and which pitches are read as folded."""
    seen = ground.measured.frequency
    folded = [
        f"{seen[k]:.4g} Hz is taken for {body.read[k]:.4g} Hz, which looks the same at "
        f"{1 / ground.data.frame:.4g} frames/s: of the two the body as told has only that."
        for k in body.folded
    ]
    return [*sag_lines(ground, body), *folded]


def sag_lines(ground: Ground, body: Hypothesis) -> list[str]:
    """How far the marker that sags most does so, measured and as the body would; and, where that
    is further off than a sag is known, which clock would make both agree.
    """
    if body.sag is None:
        return []
    at = int(np.argmax(np.abs(ground.measured.sag)))
    name = ground.data.take.recording.markers[ground.data.marker[at]].name
    unit = "px" if ground.data.take.recording.camera else "m"
    line = (
        f"Sag of {name}: {abs(ground.measured.sag[at]):.4g} {unit} measured, "
        f"{abs(body.sag[at]):.4g} {unit} predicted."
    )
    rate = _rate(ground, body)
    if rate != 1:
        line += f" A capture rate {rate:.3g} times the declared one would mend that"
        other = "place of one of the takes" if ground.turned else "shape without weight"
        line += f", and so would another {other}; Young's modulus goes by the pitches."
    return [line]


def sag_span(ground: Ground, body: Hypothesis) -> tuple[float, float]:
    """The least and the most Young's modulus over what a pitch tells, as the sag says otherwise."""
    square = _rate(ground, body) ** 2
    return min(square, 1.0), max(square, 1.0)


def _rate(ground: Ground, body: Hypothesis) -> float:
    """The capture rate over the declared one with which sag and pitches would agree, one where they
    do as far as a sag is known.
    """
    if body.sag is None or not (power := body.sag @ body.sag) > 0:
        return 1.0
    at = int(np.argmax(np.abs(ground.measured.sag)))
    ratio = (ground.measured.sag @ body.sag) / power
    seen = abs(ground.measured.sag[at]) > CLEAR * ground.data.sigma[at]
    off = seen and ratio > 0 and abs(np.log(ratio)) > SURE * ground.measured.sag_error
    return float(ratio**-0.5) if off else 1.0


def _parameters(one: Suspect) -> dict:
    """Value and the range over the 95 % region, widened by how far real things keep to the law."""
    value = one.told
    others = [report for _, report, _ in one.near]
    known = {p.name: p for p in one.effect.parameters}
    out = {}
    for name, number in value.items():
        all_of = np.array([np.asarray(o[name], float) for o in [*others, value]])
        low, high = all_of.min(axis=0), all_of.max(axis=0)
        own = known[name]
        if np.ndim(number) == 0:
            form = SURE * own.form * abs(number)
            low = max(number - np.hypot(number - low, form), own.low)
            high = min(number + np.hypot(high - number, form), own.high)
        out[name] = estimate(number, low, high, own.unit)
    return out


def _chances(ranked: list[Suspect]) -> list[float]:
    weight = np.exp((np.array([s.evidence for s in ranked]) - ranked[0].evidence) / 4)
    return [float(w) for w in weight / weight.sum()]
