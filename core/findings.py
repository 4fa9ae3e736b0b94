"""The verdict on the whole: what the time layer found, and what pitches and shapes add to it."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2 as chi2_law

from .body import Body
from .body_error import body_error, leaves, mends, misleads
from .camera_layer import camera_effects
from .compare import PIECES, Hypothesis, Measured
from .dac import SURE
from .ground import Ground, ground_of, moved
from .joint import Heard
from .law import TimeFit
from .match import PAIR
from .modal_layer import Suspect, suspects
from .report import estimate
from .residual import FAR_OFF, Error, errors, strays
from .stranger import strangers, told
from .sufficiency import ASTRAY, CLEARLY, gained
from .turned import weighs
from .twins import creeps, softer
from .unmatched import acts
from .verdict import Verdict

DOUBT = 1e-3  # chance below which pitches and shapes do not fit the declared body
FITS = 0.05  # chance from which they fit a changed one
SLIGHT = 0.01  # of the motion, rms, and of a pitch, up to which what acts in time is a trifle
EVIDENCE = 10.0  # gain in BIC (Kass and Raftery 1995: very strong)
ENOUGH = 0.6  # share of the misfit that an effect of the body must take
NEARLY = 0.8  # of the best one's gain makes a twin
CLEAR = 6.0  # misfit per piece above which no known effect is a finding in itself
OUTWEIGHS = 4.5  # body's misfit over that in time, above which the latter decides nothing
DIFFERS = "Pitches, shapes or the sag differ a little from the body's;"
LEFT = 0.5  # of what that error has beyond free modes', rms: more, and something else is there


@dataclass(frozen=True, eq=False)
class Findings:
    """What the modal layer adds to the report."""

    verdict: str
    effects: list
    ranking: list
    advice: list
    warnings: list
    before: Error | None = None  # of the declared body
    rows: tuple = ()  # (name, Error): further rows of the chain
    misfit: tuple[float, float] = (0.0, 0.0)  # of pitches and of shapes, declared body
    # effects in time that the found change of the body makes needless
    instead: tuple[str, ...] = ()
    mesh_pitch: dict | None = None  # computed mode -> Hz at 1 Pa with the effect
    # computed mode -> least and most Young's modulus over the best, as far as the effect is known
    moduli: dict | None = None
    doubtful: bool = False  # whether the body is another one, and what it is no more than a guess
    stiffer: float = 1.0  # dynamic over static stiffness of the first mode
    stiffest: float = 1.0  # the same at most, where that is in doubt
    minor: tuple = ()  # (name, share of the motion) of the camera's effects that are too small

    def mesh_frequency(self, own: float, j: int) -> float:
        """Hz at 1 Pa of computed mode j with the found effect of the body in it."""
        return own if not self.mesh_pitch else self.mesh_pitch.get(j, own)

    def modulus_span(self, j: int) -> tuple[float, float]:
        """The least and the most Young's modulus over the best one, by computed mode j's pitch."""
        return (1.0, 1.0) if not self.moduli else self.moduli.get(j, (1.0, 1.0))

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
    known = heard.body.case.declared
    seen = [one for one in camera_effects(heard, verdict) if one.effect["name"] not in known]
    if found.effects:  # a changed body's shapes are not those that a lag is read beside
        seen = [one for one in seen if one.effect["name"] != "rolling_shutter"]
    large = [one for one in seen if one.material]
    if not large:
        return replace(found, minor=tuple((o.effect["name"], o.share) for o in seen))
    in_time = len(verdict.effects) > verdict.laws
    shown = [] if found.before or in_time else [one for one in large if one.before]
    return replace(
        found,
        verdict="explained" if found.verdict == "adequate" else found.verdict,
        effects=[*found.effects, *(one.effect for one in large)],
        minor=tuple((o.effect["name"], o.share) for o in seen if o not in large),
        before=found.before or (shown[0].before if shown else None),
        rows=(*found.rows, *((o.effect["name"], errors(verdict.final)) for o in shown)),
    )


def _examine_body(heard: Heard, verdict: Verdict, stiff, sigma) -> Findings:
    """Compare the final fit's pitches and shapes with the body's, and name what would mend them."""
    soft, softest = softer(verdict.final)
    plain = Findings(verdict.verdict, [], [], [], [], stiffer=1 / soft, stiffest=1 / softest)
    condition = heard.condition[verdict.final.law.fitted[0]]
    if heard.turns[condition] is None or verdict.verdict == "refused":
        return replace(plain, advice=[verdict.why] if verdict.why else [])
    ground = ground_of(heard, verdict, stiff, sigma)
    if ground is None:
        return plain
    base, K = ground.base, len(ground.measured.frequency)
    pieces = K * PIECES + (K - 1) + (ground.pull is not None)
    plain = replace(plain, warnings=_sag_lines(ground, base))
    marched = any(e.marched for e in verdict.final.law.effects)
    # what acts in time may have bent the shapes beyond knowing which mode is which
    known_apart = not marched or _alike(base.modes, heard)
    # a second cause needs to be clearer, unless the first hardly moves anything
    slight = not acts(verdict.damped) and _is_slight(verdict)
    doubt = DOUBT**2 if acts(verdict.final) and not slight else DOUBT
    chance = _chance(base, ground.measured)
    bent = _bends(verdict.final)
    if chance > (doubt if bent else DOUBT):
        if verdict.verdict == "adequate" and (strange := strangers(verdict, ground)):
            warnings = [*plain.warnings, told(strange)]
            return replace(plain, verdict="unexplained", warnings=warnings)
        return plain  # shapes alone, bent by whatever acts in time, name nothing
    ranked = _weighed(suspects(ground, _no_suspects(heard.body)), heard, verdict)
    known = [s for s in ranked if s.effect.name in heard.body.case.declared and s.evidence > 0]
    if known:  # as the author says, the body is this one
        base = known[0].hypothesis
        as_said = _mesh_pitch(known[0], heard, stiff)
        moduli = _moduli(known[0], heard)
        lines = _sag_lines(ground, base)
        plain = replace(plain, mesh_pitch=as_said, moduli=moduli, warnings=lines)
        chance = _chance(base, ground.measured)
        if chance > (doubt if bent else DOUBT):
            return plain
        ranked = [replace(s, evidence=s.evidence - known[0].evidence) for s in ranked]
    ranked = [s for s in ranked if s.effect.name not in heard.body.case.declared]
    over = max(base.chi2 - pieces, 0.0)
    good = [
        s
        for s in ranked
        if s.evidence > EVIDENCE
        and base.chi2 - s.hypothesis.chi2 > ENOUGH * over
        and not _may_be_nothing(s)
    ]
    if not (known_apart or (good and good[0].hypothesis.chi2 < pieces)):
        return plain
    if chance > doubt and not (good and _mends_all(good[0], base, ground.measured)):
        return _unsure(plain, [(s.effect.name, _as_found(s, plain, heard, stiff)) for s in good])
    before = body_error(verdict, ground, base)
    with_it = body_error(verdict, ground, good[0].hypothesis) if good else None
    misfit = (float((base.pitch_pull**2).sum()), float(base.shape_chi2.sum()))
    free = errors(verdict.damped)
    mended = bool(good) and mends(with_it, before, free)
    if not mended and base.chi2 < CLEAR * pieces:
        line = f"{DIFFERS} no known effect mends that."
        return replace(plain, warnings=[*plain.warnings, line])
    if not good or misleads(with_it, before, free):
        return replace(plain, verdict="unexplained", before=before, misfit=misfit, doubtful=True)
    best, left = good[0], leaves(with_it, before, free)
    outweighed = _outweighs(before, free, verdict)
    clear = verdict.verdict != "unexplained" or outweighed
    astray = strays(verdict.final, ASTRAY if best.effect.nonlinear else FAR_OFF)
    clear = clear and mended and not astray
    fits = left <= LEFT and best.hypothesis.chi2 < CLEAR * pieces
    found = "explained" if clear and fits else "unexplained"
    return replace(
        plain,
        verdict=found,
        effects=[_told(best, ranked)],
        warnings=_sag_lines(ground, best.hypothesis),
        ranking=_ranking(ranked, verdict, ground),
        before=before,
        rows=((best.effect.name, with_it),),
        misfit=misfit,
        instead=("split_modes",) if mended else (),  # a changed body parts its own pairs
        mesh_pitch=_mesh_pitch(best, heard, stiff),
        moduli=_moduli(best, heard),
        doubtful=not fits,
    )


def _unsure(plain: Findings, able: list[tuple[str, dict]]) -> Findings:
    """The same, with Young's modulus as unsure as the body is: what may have changed it, beside a
    drag or a stiffness that drifts, is not clear enough to be named, and is told in a line.

    able: of each of these the name and, by computed mode, the least and the most modulus with it
    over that without.
    """
    if not able:
        return plain
    moduli = {}
    for j in able[0][1]:
        known = plain.modulus_span(j)
        least, most = np.transpose([known, *(np.multiply(span[j], known) for _, span in able)])
        moduli[j] = (min(least), max(most))
    names = " or ".join(name for name, _ in able)
    return replace(plain, moduli=moduli, warnings=[*plain.warnings, f"{DIFFERS} {names} may act."])


def _as_found(one: Suspect, plain: Findings, heard: Heard, stiff: np.ndarray) -> dict:
    """By computed mode, the least and the most modulus that its pitch tells with a change of the
    body, over what it tells without.
    """
    own, changed = heard.body.modes.frequency, _mesh_pitch(one, heard, stiff)
    moduli = _moduli(one, heard)
    return {
        j: tuple(np.multiply((plain.mesh_frequency(own[j], j) / changed[j]) ** 2, moduli[j]))
        for j in changed
    }


def _outweighs(before: Error, free: Error, verdict: Verdict) -> bool:
    """Whether what the body misses is so much more than what free modes do that these decide
    nothing: fitted, and held out where they are clearly off.
    """
    off = strays(verdict.damped, CLEARLY)
    ahead = not off or before.held_out > OUTWEIGHS * free.held_out
    return before.fit > OUTWEIGHS * free.fit and ahead


def _alike(modes, heard: Heard) -> bool:
    """Whether the first of these are the matched modes, or the other ones of their pairs."""
    known, frequency = list(heard.match.modes), heard.body.modes.frequency
    apart = np.log(frequency[list(modes)[: len(known)]] / frequency[known])
    return bool((np.abs(apart) < PAIR).all())


def _is_slight(verdict: Verdict) -> bool:
    """Whether what was found in time hardly shows, moves no pitch, and is no creep, which a sag
    would show more of.
    """
    final, damped = verdict.final, verdict.damped
    little = gained(damped, final) < SLIGHT and moved(final, damped) < SLIGHT
    return little and not creeps(verdict)


def _weighed(ranked: list[Suspect], heard: Heard, verdict: Verdict) -> list[Suspect]:
    """The suspects, best evidence first, with what takes of the object turned over say."""
    out = [
        replace(s, evidence=s.evidence + weighs(heard, verdict.final, s.hypothesis.modulus))
        if s.effect.name == "gravity_preload"
        else s
        for s in ranked
    ]
    return sorted(out, key=lambda s: -s.evidence)


def _chance(body: Hypothesis, measured: Measured) -> float:
    """That a body as this one shows its pitches so far off, or its sag alone beside them."""
    pull, K = body.pitch_pull, len(measured.frequency)
    whole = chi2_law.sf((pull**2).sum(), max(len(pull) - 1, 1))
    if len(pull) == K:
        return float(whole)
    alone = pull[K] ** 2 / (1 - measured.weight[K] / measured.weight.sum())
    return float(2 * min(whole, chi2_law.sf(alone, 1)))


def _bends(final: TimeFit) -> bool:
    """Whether what acts may change shapes and pitches, too: all but what acts on every mode in its
    own shape, as drag and a stiffness that drifts do.
    """
    acting = [e for e in final.law.effects if e.layer in ("time", "camera")]
    return any(e.acceleration is None for e in acting)


def _mends_all(one: Suspect, base: Hypothesis, measured: Measured) -> bool:
    """Whether it is twice as clear as it must be, and nothing is the matter with it: it leaves no
    more faint modes aside than the declared body does.
    """
    clear = one.evidence > 2 * EVIDENCE and one.hypothesis.strange <= base.strange
    return clear and _chance(one.hypothesis, measured) > FITS


def _no_suspects(body: Body) -> list[str]:
    """Names of changes of the body that are in it already."""
    out = ["gravity_preload"] if body.carried else []
    if body.case.takes[0].loads:  # how these sit would be taken for another mass
        out.append("added_mass")
    return out


def _sag_lines(ground: Ground, body: Hypothesis) -> list[str]:
    if body.sag is None:
        return []
    at = int(np.argmax(np.abs(ground.measured.sag)))
    name = ground.data.take.recording.markers[ground.data.marker[at]].name
    unit = "px" if ground.data.take.recording.camera else "m"
    return [
        f"Sag of {name}: {abs(ground.measured.sag[at]):.4g} {unit} measured, "
        f"{abs(body.sag[at]):.4g} {unit} predicted."
    ]


def _may_be_nothing(suspect: Suspect) -> bool:
    """Whether its interval holds the value that changes nothing: not even its sign is known."""
    if suspect.effect.nothing is None:
        return False
    name, value = suspect.effect.nothing
    values = [report[name] for _, report, _ in suspect.near]
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


def _ranking(ranked, verdict, ground) -> list[dict]:
    chances = _chances(ranked)
    return [
        {
            "name": s.effect.name,
            "held_out": body_error(verdict, ground, s.hypothesis).held_out,
            "probability": p,
        }
        for s, p in zip(ranked, chances, strict=True)
    ]


def _moduli(one: Suspect, heard: Heard) -> dict:
    """By computed mode, see `Findings.modulus_span`."""
    least, most = one.moduli
    return {j: (least[k], most[k]) for k, j in enumerate(heard.match.modes)}


def _mesh_pitch(best: Suspect, heard: Heard, stiff: np.ndarray) -> dict:
    """Hz at 1 Pa of every measured mode's computed partner with the effect in the body."""
    found, own = best.hypothesis, best.hypothesis.pitches
    return {
        j: float(own[k] * np.sqrt(1 + stiff[min(found.modes[k], len(stiff) - 1)]))
        for k, j in enumerate(heard.match.modes)
    }
