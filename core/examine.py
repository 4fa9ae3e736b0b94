"""The verdict on the whole: what the time layer found, and what pitches and shapes add to it."""

from dataclasses import replace

import numpy as np

from .body import Body
from .body_error import leaves, mends, misleads
from .camera_layer import camera_effects
from .doubt import (
    CLEAR,
    DOUBT,
    EVIDENCE,
    bends,
    chance_of,
    is_able,
    judged,
    least_chance,
    mends_all,
    moves_otherwise,
    pieces,
)
from .effects import MODAL_EFFECTS, added_mass, base_motion, gravity_preload
from .findings import Findings
from .ground import Ground, ground_of, looked_at_closely
from .joint import Heard
from .match import PAIR
from .modal_layer import Suspect, suspects
from .residual import FAR_OFF, Error, errors, strays
from .stranger import strangers, told
from .sufficiency import ASTRAY, CLEARLY
from .tell_change import body_lines, mesh_pitches, modulus_spans, ranking, sag_span, told_change
from .turned import all_turned, turned, weighs
from .twins import softer
from .unmatched import acts
from .verdict import Verdict

NEARLY = 0.01  # of a pitch, that what changed the body has moved it by, to be looked at closely
UNSURE = 2.0  # standard deviations, that one which was hardly heard may be off by there
OUTWEIGHS = 4.5  # body's misfit over that in time, above which the latter decides nothing
DIFFERS = "Pitches, shapes or the sag differ a little from the body's;"
MANY = 2  # effects in time, beside which a change of the body is a part of what stays unexplained
NEEDLESS = ("split_modes",)  # a changed body parts its own pairs
LEFT = 0.5  # of what that error has beyond free modes', rms: more, and something else is there


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
    stiffer, stiffest, least = (1 / soft for soft in softer(verdict.final))
    creep = {"stiffer": stiffer, "stiffest": stiffest, "least_stiff": least}
    plain = Findings(verdict.verdict, [], [], [], [], **creep)
    condition = heard.condition[verdict.final.law.fitted[0]]
    if heard.turns[condition] is None or verdict.verdict == "refused":
        return replace(plain, advice=[verdict.why] if verdict.why else [])
    ground = ground_of(heard, verdict, stiff, sigma)
    if ground is None:
        return plain
    plain = replace(
        plain,
        warnings=body_lines(ground, ground.base),
        moduli=dict.fromkeys(heard.match.modes, sag_span(ground, ground.base)),
    )
    found = _told(plain, ground, heard, verdict, stiff)
    # what shakes all takes what all markers share of a stranger, too
    shaken = found.verdict == "explained" and not found.effects and _is_shaken(verdict)
    return _unless_strange(found, verdict, ground) if shaken else found


def _is_shaken(verdict: Verdict) -> bool:
    """Whether a support or camera that moves is all that was found in time."""
    return verdict.names[verdict.laws :] == (base_motion.NAME,)


def _told(plain: Findings, ground: Ground, heard: Heard, verdict: Verdict, stiff) -> Findings:
    """What is told beside what is `plain` already."""
    declared = _is_as_declared(verdict, ground)
    if declared:
        weight = _turned_over(ground, heard, verdict)
        if weight:
            return _changed(plain, ground, verdict, (weight, weight), heard, stiff)
        strange = _unless_strange(plain, verdict, ground)
        if strange is not plain:
            return strange
    near = _may_be_near(verdict, ground)
    closer = _closely(plain, ground, heard, verdict, stiff) if near else None
    if closer:
        return closer
    return plain if declared else _otherwise(plain, ground, heard, verdict, stiff)


def _is_as_declared(verdict: Verdict, ground: Ground) -> bool:
    known = chance_of(ground.base, ground.measured) > DOUBT
    return known and not moves_otherwise(verdict, ground)


def _may_be_near(verdict: Verdict, ground: Ground) -> bool:
    """Whether all loud pitches, as far as they were heard, are nearly the declared body's, under
    other loads too, and no more is open: what acts in time, how a load sits, with what modulus the
    body bears its weight.
    """
    body, known = ground.body, ground.measured
    if acts(verdict.final) or body.case.takes[0].loads or body.carried:
        return False
    off = np.abs(np.log(ground.base.read / ground.base.frequency))
    near = off < np.maximum(NEARLY, UNSURE * ground.unsure)
    laden = np.abs(ground.base.shifts.pull) < UNSURE
    return bool(near[: len(near) - known.faint].all() and laden.all())


def _closely(plain, ground: Ground, heard: Heard, verdict: Verdict, stiff) -> Findings | None:
    """What is told where computed pitches are trusted further: what is not known of a change of the
    body, as how a lump sits, is little where the change is. None where that explains nothing.
    """
    close = looked_at_closely(ground)
    if close is None or chance_of(close.base, close.measured) > DOUBT:
        return None
    found = _otherwise(plain, close, heard, verdict, stiff)
    return found if found.verdict == "explained" and found.effects else None


def _otherwise(plain, ground: Ground, heard: Heard, verdict: Verdict, stiff) -> Findings:
    """What is told where pitches or shapes are not the declared body's."""
    ranked = _weighed(suspects(ground, _no_suspects(heard.body)), heard, verdict)
    # what acts in time may have bent the shapes beyond knowing which mode is which
    known_apart = not any(e.marched for e in verdict.final.law.effects)
    known_apart = known_apart or _alike(ground.base.modes, heard)
    plain, ground, ranked = _as_declared(plain, ground, ranked, heard, stiff)
    chance, otherwise = chance_of(ground.base, ground.measured), moves_otherwise(verdict, ground)
    if chance > DOUBT and not otherwise:
        return plain
    able = [s for s in ranked if is_able(s, ground)]
    fits = bool(able) and able[0].hypothesis.chi2 < pieces(ground)
    if not fits and chance > DOUBT:
        return _unless_strange(plain, verdict, ground)
    if not known_apart and (not fits or verdict.verdict == "unexplained"):
        return plain
    mended = able and mends_all(able[0], ground.base, ground.measured)
    mended = mended and not bends(verdict.final)  # which may have bent what it mends
    if chance > least_chance(verdict) and not otherwise and not mended:
        return _unsure(plain, [(s.effect.name, _as_found(s, plain, heard, stiff)) for s in able])
    return _changed(plain, ground, verdict, (able, ranked), heard, stiff)


def _unless_strange(plain: Findings, verdict: Verdict, ground: Ground) -> Findings:
    """What is told of a body that is as declared, or nearly, unless a mode swings that is none."""
    able = verdict.verdict == "adequate" or _is_shaken(verdict)
    strange = strangers(verdict, ground) if able else []
    if not strange:
        return plain
    return replace(plain, verdict="unexplained", warnings=[*plain.warnings, told(strange)])


def _as_declared(plain, ground: Ground, ranked: list[Suspect], heard: Heard, stiff):
    """The same beside the change of the body that the author declares, where it tells anything, and
    the other suspects.
    """
    declared = heard.body.case.declared
    others = [s for s in ranked if s.effect.name not in declared]
    known = [s for s in ranked if s.effect.name in declared and s.evidence > 0]
    if not known:
        return plain, ground, others
    said = known[0]
    plain = replace(
        plain,
        mesh_pitch=mesh_pitches(said, heard, stiff),
        moduli=modulus_spans(said, ground, heard),
        warnings=body_lines(ground, said.hypothesis),
    )
    others = [replace(s, evidence=s.evidence - said.evidence) for s in others]
    return plain, replace(ground, base=said.hypothesis), others


def _changed(plain, ground: Ground, verdict: Verdict, known, heard: Heard, stiff) -> Findings:
    """What is told of a body that is surely not the declared one; `known`: suspects that are able,
    and all of them.
    """
    base, (able, ranked) = ground.base, known
    best = able[0] if able else None
    weight = best is not None and best.effect.name == gravity_preload.EFFECT.name
    alike = all_turned(heard, verdict.final) if weight else ()
    seen, decides = judged(verdict, ground, best, alike)
    with_it, before, _ = seen
    misfit = (base.pitch_chi2, float(base.shape_chi2.sum()))
    mended = bool(best) and mends(*decides)
    if not mended and base.chi2 < CLEAR * pieces(ground):
        line = f"{DIFFERS} no known effect mends that."
        return _unless_strange(replace(plain, warnings=[*plain.warnings, line]), verdict, ground)
    if not best or misleads(*decides):
        return replace(plain, verdict="unexplained", before=before, misfit=misfit, doubtful=True)
    left = leaves(*decides)
    clear = verdict.verdict != "unexplained" or _outweighs(*seen[1:], verdict)
    clear = clear and _in_time(verdict, mended) < MANY  # so many together tell anything
    astray = strays(verdict.final, ASTRAY if best.effect.nonlinear else FAR_OFF)
    fits = left <= LEFT and best.hypothesis.chi2 < CLEAR * pieces(ground)
    effect = told_change(best, ranked)
    # nobody overlooks a mass larger than the body's: something on it swings by itself
    fits = fits and not added_mass.outweighs([effect], ground.body.bare.mass.sum() / 3)
    return replace(
        plain,
        verdict="explained" if clear and mended and not astray and fits else "unexplained",
        effects=[effect],
        warnings=body_lines(ground, best.hypothesis),
        ranking=ranking(ranked, verdict, ground),
        before=before,
        rows=((best.effect.name, with_it),),
        misfit=misfit,
        instead=NEEDLESS if mended else (),
        mesh_pitch=mesh_pitches(best, heard, stiff),
        moduli=modulus_spans(best, ground, heard),
        doubtful=not fits,
    )


def _in_time(verdict: Verdict, mended: bool) -> int:
    """Effects in time that stay beside a change of the body, which mends the pitches or not."""
    found = [one.names[-1] for one in verdict.effects[verdict.laws :]]
    return sum(not (mended and name in NEEDLESS) for name in found)


def _unsure(plain: Findings, able: list[tuple[str, dict]]) -> Findings:
    """The same, with Young's modulus as unsure as the body is: what may have changed it, beside
    what acts in time, is not clear enough to be named, and is told in a line.

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
    own, changed = heard.body.modes.frequency, mesh_pitches(one, heard, stiff)
    return {
        j: tuple(np.multiply((plain.mesh_frequency(own[j], j) / changed[j]) ** 2, span))
        for j, span in zip(changed, np.transpose(one.moduli), strict=False)
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


def _weighed(ranked: list[Suspect], heard: Heard, verdict: Verdict) -> list[Suspect]:
    """The suspects, best evidence first, with what takes of the object turned over say."""
    out = [
        replace(s, evidence=s.evidence + weighs(heard, verdict.final, s.hypothesis.modulus))
        if s.effect.name == "gravity_preload"
        else s
        for s in ranked
    ]
    return sorted(out, key=lambda s: -s.evidence)


def _turned_over(ground: Ground, heard: Heard, verdict: Verdict) -> list[Suspect]:
    """The body's own weight, where the takes of an object turned over show it by themselves,
    however well one take's pitches fit without.
    """
    weight = gravity_preload.EFFECT.name
    known = [*_no_suspects(heard.body), *heard.body.case.declared]
    if weight in known or not turned(heard, verdict.final):
        return []
    others = [effect.name for effect in MODAL_EFFECTS if effect.name != weight]
    return [s for s in _weighed(suspects(ground, others), heard, verdict) if s.evidence > EVIDENCE]


def _no_suspects(body: Body) -> list[str]:
    """Names of changes of the body that are in it already."""
    out = ["gravity_preload"] if body.carried else []
    if body.case.takes[0].loads:  # how these sit would be taken for another mass
        out.append("added_mass")
    return out
