"""An effect's twin in its place, beside another effect, from where the two stand.

What two effects look like apart is no guide to where they stand together: a search that began with
one of two twins alone may have no way to the other. From the best fit of two it is a short one.
"""

from functools import partial

import numpy as np

from .effects import TIME_EFFECTS
from .effects.base import Effect
from .effects.further_mode import ran_off
from .law import TimeFit
from .refit import swapped, turned
from .side_by_side import in_step_by_parts
from .sufficiency import ENOUGH
from .time_layer import Candidate, able, begins_of, judge, refuted, stands_in
from .timefit import best_fit, misfits

RUNNERS = 2  # starting places of a twin that are fitted
LOOKS = 20


def exchanged(found: list[Candidate], declared: TimeFit) -> list[Candidate]:
    """The candidates of two effects, best first, with those that the best one's twins make."""
    if not found or found[0].share < ENOUGH:
        return found
    best = found[0]
    swaps = [
        (at, effect)
        for at in (-1, -2)
        for effect in able(declared, TIME_EFFECTS)
        if effect.name in best.found.law.effects[at].twins and effect.name not in best.names
    ]
    tries = in_step_by_parts([partial(_instead, best.found, *swap) for swap in swaps])
    kept = {frozenset(c.names): c for c in found}
    for one in tries:
        if one is not None:
            names = tuple(e.name for e in one.law.effects[-2:])
            candidate, key = judge(names, one, declared), frozenset(names)
            kept[key] = max(kept.get(key, candidate), candidate, key=lambda c: c.evidence)
    out = sorted(kept.values(), key=lambda c: -c.evidence)
    return [c for c in out if not stands_in(c, out)]


def _instead(found: TimeFit, at: int, effect: Effect) -> TimeFit | None:
    """The fit with `effect` in the place of number `at`, as the last one; None where it is none."""
    found = found if at == -1 else turned(found)
    ways = (1.0, -1.0) if effect.scales else (1.0,)
    begins = [(way * b[0], *b[1:]) if effect.scales else b
              for way in ways for b in begins_of(effect, found, None)]  # fmt: skip
    law, starts = swapped(found, effect, begins)
    first = np.argsort(misfits(law, starts, found.samples))[:RUNNERS]
    best = best_fit(law, starts[first], evaluations=LOOKS)
    strayed = ran_off(best) and not ran_off(found)
    return None if strayed or refuted(best) or refuted(turned(best)) else best
