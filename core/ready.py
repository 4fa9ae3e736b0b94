"""Candidates made ready to be compared: fitted to their end, with what they lay bare."""

from collections.abc import Callable
from functools import partial

import numpy as np

from .branches import with_branch
from .carried import carrying
from .effects.further_mode import ran_off
from .further import with_modes_of
from .law import TimeFit
from .read_off import read_anew
from .refit import turned
from .residual import EVIDENCE, NOISY, QUIET
from .rub import in_plane
from .side_by_side import in_step_by_parts
from .time_layer import NEARLY, Candidate, judge, vetoed
from .timefit import fit

LAID_BARE = 2  # best candidates that are looked at for what they lay bare, one by each process
VIES = 0.95  # of the best one's evidence, from which a candidate vies for its place
WORTH = 0.7  # share of the excess that two effects take, from which what they lay bare is sought
TO_THE_END = 40  # looks that those get which vie


def to_their_end(found: list[Candidate], declared: TimeFit) -> list[Candidate]:
    """The candidates, best first, those that vie for the first place fitted to their end.

    What follows the amplitude and what follows time are told apart by what a search in few looks
    leaves. One that is none at its end stays as good as it was.
    """
    vie = vying(found)
    if len(vie) < 2:
        return found

    def to_the_end(c):
        if not any(e.marched for e in c.found.law.effects):
            return c
        longer = carrying(fit(c.found.law, c.found.parameters, evaluations=TO_THE_END))
        none = vetoed(longer) or (len(c.names) > 1 and vetoed(turned(longer)))
        if none or (ran_off(longer) and not ran_off(c.found)):
            return c
        return judge(c.names, longer, declared)

    longer = in_step_by_parts([partial(to_the_end, c) for c in vie])
    others = [c for c in found if c not in vie]
    return sorted([*longer, *others], key=lambda c: -c.evidence)


def vying(found: list[Candidate]) -> list[Candidate]:
    """Those of the candidates, best first, that vie for the first place."""
    least = VIES * next((c.evidence for c in found if not c.outdone), np.inf)
    return [c for c in found if c.evidence >= max(least, EVIDENCE) and not c.outdone]


def polished(found: list[Candidate], declared: TimeFit, widen: Callable) -> list[Candidate]:
    """The candidates of two effects, the two best ones with all that they lay bare.

    Modes that die soon are missed in the first part only.
    """
    able = [max(c.share, c.held_share) > WORTH and n < LAID_BARE for n, c in enumerate(found)]
    return _laid_bare(found, able, declared, widen)


def widened(strong: list[Candidate], declared: TimeFit, widen: Callable) -> list[Candidate]:
    """The candidates, the best and the next with all that they lay bare, if it is near."""
    able = [
        c.evidence >= NEARLY * strong[0].evidence and n < LAID_BARE for n, c in enumerate(strong)
    ]
    return _laid_bare(strong, able, declared, widen)


def _laid_bare(found: list[Candidate], able: list[bool], declared: TimeFit, widen: Callable):
    """The candidates, best first, those that are `able` with a second time of a relaxation, a rub
    in a plane, a shared motion read off anew and further modes, those too that another one laid
    bare, where that is better.
    """

    def laid_bare(c):
        two = in_plane(with_branch(c.found, len(c.names)), len(c.names))
        two = read_anew(two, len(c.names))
        others = [judge(c.names, found, declared) for found in (two, widen(two, len(c.names)))]
        return max(c, *others, key=lambda one: one.evidence)

    may = [c for c, is_able in zip(found, able, strict=True) if is_able]
    loud = any(c.found.chi2 >= NOISY * c.found.samples for c in may)
    # with a loud one all that leave a little are asked for more: else the worse one leaves less
    some = [c for c in may if loud and c.found.chi2 >= QUIET * c.found.samples]
    others = [c for c in found if c not in some]
    out = in_step_by_parts([partial(laid_bare, c) for c in some])

    def with_all(c):
        found = c.found
        for other in out:
            found = with_modes_of(found, other.found, len(c.names)) if other is not c else found
        return max(c, judge(c.names, found, declared), key=lambda one: one.evidence)

    # they are the same body's: which effects tell more shows with all that any of them laid bare
    out = in_step_by_parts([partial(with_all, c) for c in out])
    return sorted([*out, *others], key=lambda c: -c.evidence)
