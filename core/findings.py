"""The verdict on the whole: what the time layer found, and what pitches and shapes add to it."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2 as chi2_law

from .baseline import px_per_metre
from .camera_layer import camera_effects, true_frequency
from .diagnosis import MATERIAL, Verdict
from .elasticity import gravity_force, static
from .joint import Heard
from .law import TimeFit
from .match import mac
from .modal_layer import (
    PIECES,
    PITCH_FLOOR,
    SHAPE_FLOOR,
    Ground,
    Hypothesis,
    Measured,
    Suspect,
    compare,
    rematched,
    suspects,
)
from .report import estimate
from .residual import errors, nrmse
from .tell import inflation, parameters

DOUBT = 1e-3  # chance below which pitches and shapes do not fit the declared body
EVIDENCE = 10.0  # gain in BIC (Kass and Raftery 1995: very strong)
ENOUGH = 0.6  # share of the misfit that an effect of the body must take
NEARLY = 0.8  # of the best one's gain makes a twin
CLEAR = 6.0  # misfit per piece above which no known effect is a finding in itself
OUTWEIGHS = 4.5  # body's misfit over that in time, above which the latter decides nothing
BENT = 0.95  # MAC below which a computed shape is not the measured one
SPILL = 0.3  # of what is left in a channel may have gone into a mode's shape
BIASED = 0.5  # of the most that effects in time moved a pitch by, that all may be off by
SHOWN = 1.5  # times the error of free modes, from which the body's pitches and shapes show
MENDED = 0.8  # of the declared body's error, held out or fitted, that is left at most
LEFT = 0.5  # of what that error has beyond free modes', rms: more, and something else is there
SETTLED = 0.05  # of the sag: error of geometry, density and a creep that nothing shows
CREPT = 0.15  # the same where a creep may be at work
TILTED = 1.4  # of the sag over the length: how far a cantilever's end turns
PULLED = 3.0  # standard deviations beyond which a prediction keeps to the model


@dataclass(frozen=True, eq=False)
class Findings:
    """What the modal layer adds to the report."""

    verdict: str
    effects: list
    ranking: list
    advice: list
    warnings: list
    before: tuple | None = None  # (None, held-out, fit) of the declared body
    rows: tuple = ()  # further rows of the chain
    misfit: tuple[float, float] = (0.0, 0.0)  # of pitches and of shapes, declared body
    # effects in time that the found change of the body makes needless
    instead: tuple[str, ...] = ()
    mesh_pitch: dict | None = None  # computed mode -> Hz at 1 Pa with the effect
    stiffer: float = 1.0  # dynamic over static stiffness of the first mode
    minor: tuple = ()  # (name, share of the motion) of the camera's effects that are too small

    def mesh_frequency(self, own: float, j: int) -> float:
        """Hz at 1 Pa of computed mode j with the found effect of the body in it."""
        return own if not self.mesh_pitch else self.mesh_pitch.get(j, own)

    def budget(self, shares: dict[str, float]) -> dict[str, float]:
        """The time layer's budget with the energy that the declared body's own error adds."""
        if self.before is None:
            return shares
        pitch, shape = self.misfit
        whole = 0.5 * (pitch + shape) + 1e-300
        body = {"frequency ratios": 0.5 * pitch / whole * 0.5, "shapes": 0.5 * shape / whole * 0.5}
        rest = 1 - sum(body.values())
        return {name: share * rest for name, share in shares.items()} | body


def examine(heard: Heard, verdict: Verdict, stiff: np.ndarray, sigma: np.ndarray) -> Findings:
    """What pitches, shapes and rest places say beside the time layer's verdict."""
    found = _examine_body(heard, verdict, stiff, sigma)
    if verdict.verdict == "refused":
        return found
    seen = camera_effects(heard, verdict)
    large = [one for one in seen if one.share >= MATERIAL]
    if not large:
        return replace(found, minor=tuple((o.effect["name"], o.share) for o in seen))
    rows = [] if found.before or verdict.effects else [(None, *large[0].before)]
    return replace(
        found,
        verdict="explained" if found.verdict == "adequate" else found.verdict,
        effects=[*found.effects, *(one.effect for one in large)],
        minor=tuple((o.effect["name"], o.share) for o in seen if o not in large),
        before=found.before or (rows[0] if rows else None),
        rows=(*found.rows, *((o.effect["name"], *errors(verdict.final)) for o in large if rows)),
    )


def _examine_body(heard: Heard, verdict: Verdict, stiff, sigma) -> Findings:
    """Compare the final fit's pitches and shapes with the body's, and name what would mend them."""
    plain = Findings(verdict.verdict, [], [], [], [], stiffer=1 / _softer(verdict.final))
    condition = heard.condition[verdict.final.law.fitted[0]]
    if heard.turns[condition] is None or verdict.verdict == "refused":
        return replace(plain, advice=[verdict.why] if verdict.why else [])
    ground = _ground(heard, verdict, stiff, sigma)
    if ground is None:
        return plain
    base, K = ground.base, len(ground.measured.frequency)
    pieces = K * PIECES + (K - 1) + (ground.pull is not None)
    plain = replace(plain, warnings=_sag_lines(ground))
    marched = any(e.marched for e in verdict.final.law.effects)
    if marched and base.modes != heard.match.modes:
        return plain  # what acts in time has bent the shapes beyond knowing which mode is which
    ratios = max(len(base.pitch_pull) - 1, 1)
    doubt = DOUBT**2 if verdict.effects else DOUBT  # a second cause needs to be clearer
    if chi2_law.sf((base.pitch_pull**2).sum(), ratios) > doubt:
        return plain  # shapes alone, bent by whatever acts in time, name nothing
    known = heard.body.case.declared
    if heard.body.case.takes[0].loads:  # how these sit would be taken for another mass
        known = (*known, "added_mass")
    ranked = suspects(ground, known)
    over = base.chi2 - pieces
    good = [
        s
        for s in ranked
        if s.evidence > EVIDENCE
        and base.chi2 - s.hypothesis.chi2 > ENOUGH * over
        and not _may_be_nothing(s)
    ]
    before = _row(None, heard, verdict, ground, base)
    row = _row(good[0].effect.name, heard, verdict, ground, good[0].hypothesis) if good else None
    misfit = (float((base.pitch_pull**2).sum()), float(base.shape_chi2.sum()))
    free = errors(verdict.chain[0][1])
    if not good or not _mends(row, before, free):
        if base.chi2 < CLEAR * pieces:
            line = "Pitches or shapes differ a little from the body's; no known effect mends them."
            return replace(plain, warnings=[*plain.warnings, line])
        return replace(plain, verdict="unexplained", before=before, misfit=misfit)
    best = good[0]
    outweighed = before[2] > OUTWEIGHS * free[1]
    clear = verdict.verdict != "unexplained" or outweighed
    found = "explained" if clear and _leaves(row, before, free) <= LEFT else "unexplained"
    return replace(
        plain,
        verdict=found,
        effects=[_told(best, ranked)],
        ranking=_ranking(ranked, heard, verdict, ground),
        before=before,
        rows=(row,),
        misfit=misfit,
        instead=("split_modes",),  # a changed body parts its own pairs
        mesh_pitch=_mesh_pitch(best, heard, stiff),
    )


def _ground(heard: Heard, verdict: Verdict, stiff, sigma) -> Ground | None:
    final = verdict.final
    data = final.law.takes[final.law.fitted[0]]
    K, body = final.law.modes, heard.body
    j = list(heard.match.modes)
    spread = np.sqrt(np.maximum(np.diag(final.covariance)[:K], 0) * inflation(final))
    bias = BIASED * max(_moved(final, heard.declared), _bent(final))
    error = np.sqrt(spread**2 + bias**2 + (0.5 * sigma[j]) ** 2 + PITCH_FLOOR**2)
    samples = max(int(data.fit.sum()), 1)
    size = np.abs(final.shapes).max(axis=1, keepdims=True)
    swing = np.array([u.std() for u in final.motions[0].T])
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
        true_frequency(heard, final),
        error,
        final.shapes,
        shape_error,
        sag,
        _softer(final),
        CREPT if _creeps(verdict) else SETTLED,
    )
    shrink = 1 / (1 + stiff)
    values = (2 * np.pi * body.modes.frequency) ** 2 * shrink
    base = compare(measured, values, body.seen(data), unit)
    if base is None:
        return None
    base = rematched(measured, values, body.seen(data), unit, base)
    return Ground(body, data, measured, base, shrink, pull)


def _moved(final: TimeFit, declared: TimeFit) -> float:
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


def _creeps(verdict: Verdict) -> bool:
    """Whether something moves the mean that may be a creep, which goes on after the recording."""
    told = [c.names[-1] for c in verdict.effects] + [t for ts in verdict.twins for t in ts]
    return "relaxation" in told


def _softer(final: TimeFit) -> float:
    """Static over dynamic stiffness where a relaxation was found."""
    for i, effect in enumerate(final.law.effects):
        if effect.name == "relaxation":
            told = parameters(final, i)
            turns = (2 * np.pi * final.frequency[0] * told["time"]["value"]) ** 2
            return 1 / (1 + told["ratio"]["value"] * turns / (1 + turns))
    return 1.0


def _sag_lines(ground: Ground) -> list[str]:
    if ground.base.sag is None:
        return []
    at = int(np.argmax(np.abs(ground.measured.sag)))
    name = ground.data.take.recording.markers[ground.data.marker[at]].name
    unit = "px" if ground.data.take.recording.camera else "m"
    return [
        f"Sag of {name}: {abs(ground.measured.sag[at]):.4g} {unit} measured, "
        f"{abs(ground.base.sag[at]):.4g} {unit} predicted."
    ]


def _row(name, heard: Heard, verdict: Verdict, ground: Ground, found: Hypothesis) -> tuple:
    """(name, held-out, fit): the time layer's declared fit with the body's pitches and shapes."""
    declared = verdict.chain[0][1]
    law, data = declared.law, ground.data
    pulls = np.abs(found.pitch_pull[: len(found.frequency)])
    f = np.where(pulls > PULLED, found.frequency, declared.frequency)
    bent = np.array([mac(a, b) < BENT for a, b in zip(found.shapes, declared.shapes, strict=True)])
    shapes = np.where(bent[:, None], found.shapes, declared.shapes)
    index = law.fitted[0]
    free = _bound(declared, declared.frequency, declared.shapes, data)
    change = _bound(declared, f, shapes, data) - free
    predicted = list(declared.predicted)
    predicted[index] = predicted[index] + change
    return name, nrmse(law.takes, predicted, True), nrmse(law.takes, predicted, False)


def _bound(declared: TimeFit, frequency, shapes, data) -> np.ndarray:
    """(T, C) best linear ring-down with these pitches and shapes, fitted where it may be."""
    z = declared.damping_ratio
    w = 2 * np.pi * frequency
    phase = np.outer(data.time, w * np.sqrt(1 - z**2))
    fall = np.exp(-np.outer(data.time, z * w))
    waves = np.hstack([fall * np.cos(phase), fall * np.sin(phase)])  # (T, 2K)
    use = data.fit & np.isfinite(data.values).all(axis=1)
    mean = waves[use].mean(axis=0)
    both = np.vstack([shapes, shapes]) / data.sigma  # (2K, C)
    y = (data.values[use] - data.values[use].mean(axis=0)) / data.sigma
    centred = waves[use] - mean
    gram = (centred.T @ centred) * (both @ both.T)
    right = np.einsum("tk,tc,kc->k", centred, y, both)
    a = np.linalg.lstsq(gram, right, rcond=None)[0]
    return ((waves - mean) * a) @ (both * data.sigma) + data.values[use].mean(axis=0)


def _mends(row: tuple, before: tuple, free: tuple[float, float]) -> bool:
    """Whether what the declared body misses more than free modes do is less with the effect.

    Each (name, held-out, fit) but `free` (held-out, fit). What does not show there is no test.
    """
    shown = [(row[k], before[k]) for k in (1, 2) if before[k] > SHOWN * free[k - 1]]
    return not shown or any(after < MENDED * was for after, was in shown)


def _leaves(row: tuple, before: tuple, free: tuple[float, float]) -> float:
    """Share that is left of the error, rms, that the declared body shows beyond free modes: held
    out or fitted, the larger one.
    """
    over = [
        max(row[k] ** 2 - free[k - 1] ** 2, 0) / (before[k] ** 2 - free[k - 1] ** 2)
        for k in (1, 2)
        if before[k] > SHOWN * free[k - 1]
    ]
    return float(np.sqrt(max(over, default=0.0)))


def _may_be_nothing(suspect: Suspect) -> bool:
    """Whether its interval holds the value that changes nothing: not even its sign is known."""
    if suspect.effect.nothing is None:
        return False
    name, value = suspect.effect.nothing
    values = [report[name] for _, report in suspect.near]
    return min(values) < value < max(values)


def _told(best: Suspect, ranked: list[Suspect]) -> dict:
    gain = max(best.evidence, 1e-9)
    twins = [s.effect.name for s in ranked if s is not best and s.evidence >= NEARLY * gain]
    return {
        "name": best.effect.name,
        "parameters": _parameters(best),
        "probability": _chances(ranked)[ranked.index(best)],
        "twins": twins,
    }


def _parameters(one: Suspect) -> dict:
    """Value and the range over all grid points within the 95 % region."""
    value = one.told
    others = [report for _, report in one.near]
    units = {p.name: p.unit for p in one.effect.parameters}
    out = {}
    for name, number in value.items():
        all_of = np.array([np.asarray(o[name], float) for o in [*others, value]])
        low, high = all_of.min(axis=0), all_of.max(axis=0)
        out[name] = estimate(number, low, high, units[name])
    return out


def _chances(ranked: list[Suspect]) -> list[float]:
    weight = np.exp((np.array([s.evidence for s in ranked]) - ranked[0].evidence) / 4)
    return [float(w) for w in weight / weight.sum()]


def _ranking(ranked, heard, verdict, ground) -> list[dict]:
    chances = _chances(ranked)
    return [
        {
            "name": s.effect.name,
            "held_out": _row(s.effect.name, heard, verdict, ground, s.hypothesis)[1],
            "probability": p,
        }
        for s, p in zip(ranked, chances, strict=True)
    ]


def _mesh_pitch(best: Suspect, heard: Heard, stiff: np.ndarray) -> dict:
    """Hz at 1 Pa of every measured mode's computed partner with the effect in the body."""
    found = best.hypothesis
    own = found.frequency / np.sqrt(found.modulus)
    return {
        j: float(own[k] * np.sqrt(1 + stiff[min(found.modes[k], len(stiff) - 1)]))
        for k, j in enumerate(heard.match.modes)
    }
