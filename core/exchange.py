"""An effect's twin in its place, alone or beside another effect, from where it stands.

What two effects look like apart is no guide to where they stand together: a search that began with
one of two twins alone may have no way to the other. From the best fit of two it is a short one. So
is that from what bends a pitch to what else bends it so. And an effect itself is sought once more
from where it stands, where it has bent to do nearly what it does otherwise.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from .carried import carrying
from .effects import TIME_EFFECTS
from .effects.base import PLACES, Effect
from .effects.further_mode import ran_off
from .law import Law, TimeFit
from .race import unlike
from .ready import TO_THE_END, vying
from .refit import swapped, turned
from .residual import NOISY, QUIET, errors
from .side_by_side import in_step_by_parts
from .sufficiency import ENOUGH, bends_the_body, fails, sufficient
from .time_layer import Candidate, able, begins_of, judge, refuted, stands_in
from .timefit import at_first, best_fit, misfits, walked

ROUNDS = 2  # of the best of two effects, each from what the one before has found
RUNNERS = 2  # starting places of a twin that are fitted
LOOKS, FIRST = 20, 8  # of a twin, and its first ones, or those on each share of the record
SHARES = (0.3, 0.6)  # of the record, on which a force begins that may bend a pitch otherwise
SEEN = 6  # strengths, the best on the first of them at its best place, with which it is sought
HOPE = 1.5  # of the best one's misfit, that it leaves then at most


def exchanged_alone(found: list[Candidate], declared: TimeFit) -> list[Candidate]:
    """The single effects, best first, with those that the best one's twins make in its place, where
    that leaves something and they nothing, or where it predicts what was held out worse than its
    noise allows, and they better.
    """
    found = _sought_again(found, declared)
    best = next((c for c in found if not c.outdone), None)
    if best is None:
        return found
    quiet, off = best.found.chi2 < QUIET * best.found.samples, errors(best.found).held_out
    if quiet and not fails(best.found):
        return found
    twins = [
        effect
        for effect in able(declared, TIME_EFFECTS)
        if effect.name in best.found.law.effects[-1].twins
    ]
    most = HOPE * best.found.chi2
    tries = in_step_by_parts([partial(_put_in_hope, best.found, effect, most) for effect in twins])
    kept = {c.names: c for c in found}
    for one in filter(None, tries):
        strayed = ran_off(one) and not ran_off(best.found)
        if one.chi2 > NOISY * one.samples or strayed or refuted(one):
            continue
        if quiet and not errors(one).held_out < off:
            continue
        candidate = judge((one.law.effects[-1].name,), one, declared)
        before = kept.get(candidate.names, candidate)
        kept[candidate.names] = max(before, candidate, key=lambda c: c.evidence)
    out = sorted(kept.values(), key=lambda c: -c.evidence)
    return [replace(c, outdone=c.outdone or stands_in(c, out)) for c in out]


def _sought_again(found: list[Candidate], declared: TimeFit) -> list[Candidate]:
    """The single effects, best first; those that vie for the first place, tell nearly all and leave
    more than noise, or predict worse than that, sought once more with the motion as it stands: a
    law of two numbers bends to do nearly what it does with two others.
    """
    vie = [c for c in vying(found) if sufficient(c, ENOUGH) and _is_off(c.found)]
    tries = in_step_by_parts(
        [partial(_put, c.found, c.found.law.effects[-1], TO_THE_END) for c in vie]
    )
    better = {}
    for before, one in zip(vie, tries, strict=True):
        strayed = ran_off(one) and not ran_off(before.found)
        bent = bends_the_body(one) and not bends_the_body(before.found)
        again = judge(before.names, one, declared)
        if again.evidence > before.evidence and not (strayed or bent or refuted(one)):
            better[before] = again
    return sorted((better.get(c, c) for c in found), key=lambda c: -c.evidence)


def _is_off(found: TimeFit) -> bool:
    """Whether what is marched leaves more than noise, or predicts worse."""
    marched = found.law.effects[-1].marched
    return marched and (found.chi2 > QUIET * found.samples or fails(found, QUIET))


def exchanged(found: list[Candidate], declared: TimeFit, rounds: int = ROUNDS) -> list[Candidate]:
    """The candidates of two effects, best first, with those that the best one's twins make; and,
    where another one is the best then, its own.
    """
    if not found or found[0].share < ENOUGH or not rounds:
        return found
    best = found[0]
    swaps = [
        (at, effect)
        for at in (-1, -2)
        for effect in able(declared, TIME_EFFECTS)
        if effect.name in _twins_of(best.found, at) and effect.name not in best.names
    ]
    tries = in_step_by_parts([partial(_instead, best.found, *swap) for swap in swaps])
    kept = {frozenset(c.names): c for c in found}
    for one in tries:
        if one is not None:
            names = tuple(e.name for e in one.law.effects[-2:])
            candidate, key = judge(names, one, declared), frozenset(names)
            kept[key] = max(kept.get(key, candidate), candidate, key=lambda c: c.evidence)
    out = sorted(kept.values(), key=lambda c: -c.evidence)
    out = [c for c in out if not stands_in(c, out)]
    same = not out or set(out[0].names) == set(best.names)
    return out if same else exchanged(out, declared, rounds - 1)


def _twins_of(found: TimeFit, at: int) -> set[str]:
    """Names of what may look like effect number `at`: of what bends a pitch beside a motion that it
    feels, all that does, for about a place aside what is the same both ways no longer is.
    """
    effects = found.law.effects
    aside = effects[at].bends and any(e.carries for e in effects)
    return {*effects[at].twins, *(e.name for e in TIME_EFFECTS if aside and e.bends)}


def _instead(found: TimeFit, at: int, effect: Effect) -> TimeFit | None:
    """The fit with `effect` in the place of number `at`, as the last one; None where it is none."""
    found = found if at == -1 else turned(found)
    best = _put(found, effect)
    strayed = ran_off(best) and not ran_off(found)
    return None if strayed or refuted(best) or refuted(turned(best)) else best


def _put(found: TimeFit, effect: Effect, looks: int = LOOKS) -> TimeFit:
    """The best fit with `effect` in the last one's place, begun where that stands and, if it is a
    force, on growing shares of the record as well, for on the whole its pitches may slip.
    """
    law, near, starts = _begun(found, effect)
    if effect is found.law.effects[-1]:
        near = np.vstack([near, found.parameters])
    if effect.marched:
        at = len(found.parameters) - len(found.theta[-1][0])
        begins = [tuple(p[at:]) for p in starts]
        first = unlike(effect, begins, -at_first(law, starts, SHARES[0]))[:SEEN]
        led = walked(law, starts[first], SHARES, FIRST, RUNNERS)
        near = np.vstack([near, *(p for p, _, _ in led)])
    return carrying(best_fit(law, near, evaluations=looks))


def _put_in_hope(found: TimeFit, effect: Effect, most: float) -> TimeFit | None:
    """The best fit with `effect` in the last one's place, begun where that stands; None where after
    the first looks it leaves more than `most`.
    """
    law, near, _ = _begun(found, effect)
    walks = walked(law, near, (1.0,), FIRST)
    if walks[0][2] > most:
        return None
    places = np.array([p for p, _, _ in walks])
    return carrying(best_fit(law, places, evaluations=LOOKS - FIRST))


def _begun(found: TimeFit, effect: Effect) -> tuple[Law, np.ndarray, np.ndarray]:
    """The law with `effect` in the last one's place, the few best starts, and all, at few places:
    each of them is marched.
    """
    ways = (1.0, -1.0) if effect.scales else (1.0,)
    begins = [(way * b[0], *b[1:]) if effect.scales else b
              for way in ways for b in begins_of(effect, found, None, PLACES)]  # fmt: skip
    law, starts = swapped(found, effect, begins)
    return law, starts[np.argsort(misfits(law, starts, found.samples))[:RUNNERS]], starts
