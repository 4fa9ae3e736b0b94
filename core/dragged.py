"""A drag on all modes that the body may swing in, where few of them are heard beside it, and what
shows beside that.
"""

import numpy as np

from .by_two import SHOWN
from .effects import air_drag
from .joint import Heard
from .law import TimeFit
from .lowest import (
    Lowest,
    explains,
    fitted,
    in_place,
    least_of,
    lowest_of,
    tells_more,
    with_effects,
)
from .refit import without
from .residual import EVIDENCE, QUIET, bic
from .sufficiency import CLEARLY_BOTH
from .time_layer import judge, seconds
from .timefit import misfits
from .verdict import Verdict

DRAG = air_drag.EFFECT
STRENGTHS = (0.05, 0.2, 0.5, 1.2)  # from which a drag is sought


def with_drag(heard: Heard, verdict: Verdict, *, beside: bool = False) -> Verdict | None:
    """The verdict that a drag on the body's lowest modes explains all, or, where nothing was found
    that does, such a drag and what shows `beside` it; None where these do not, or tell no more than
    what was found.
    """
    found = verdict.damped
    lowest = lowest_of(heard, found) if _may_be_one(verdict, found) else None
    if lowest is None:
        return None
    drags, able = [], []
    for some in fitted(with_effects(lowest, DRAG), found, [np.array([s]) for s in STRENGTHS]):
        drags.append(min(some, key=bic))
        able = [one for one in some if explains(one, found, lowest.apart)]
        if able:
            break
    one = min(able, key=bic, default=None)
    if one is None:
        seeks = beside and verdict.verdict == "unexplained"
        return _with_another(verdict, lowest, drags) if seeks else None
    if not tells_more(one, verdict):
        return None
    if bic(one) > least_of(lowest, found, [np.zeros(0)]) - EVIDENCE:  # all it needs is the modes
        return None
    return in_place(verdict, lowest.heard, [(DRAG.name, one)])


def _with_another(verdict: Verdict, lowest: Lowest, drags: list[TimeFit]) -> Verdict | None:
    """The verdict that one of the `drags`, of which the best alone tells more than all that was
    found, and what shows beside it explain all: the best one may have bent itself to what the other
    effect does. One without which nothing would change is none.
    """
    drags = [one for one in drags if _acts(one)]
    declared, first = verdict.damped, min(drags, key=bic, default=None)
    if first is None or not bic(first) < bic(verdict.complete):
        return None
    firsts = [judge((DRAG.name,), one, declared) for one in drags]
    seen = seconds(firsts, [declared] * len(firsts), declared)
    able = (c.found for some in seen for c in some if not c.outdone)
    able = (one for one in able if explains(one, declared, lowest.apart, CLEARLY_BOTH))
    both = min((one for one in able if tells_more(one, verdict)), key=bic, default=None)
    if both is None or bic(both) > bic(first) - EVIDENCE:
        return None
    other, theta = both.law.effects[-1], both.theta[-1][0]
    rival = bic(without(both, both.law.effects.index(DRAG)))
    undragged = least_of(with_effects(lowest, other), declared, [theta])
    if bic(both) > min(rival, undragged) - EVIDENCE:  # all that the other one needs is the modes
        return None
    return in_place(verdict, lowest.heard, [(DRAG.name, first), (other.name, both)])


def _acts(one: TimeFit) -> bool:
    """Whether anything would change if a fit's drag, its last number, were nought."""
    still = np.r_[one.parameters[:-1], 0.0]
    return bool(misfits(one.law, still[None])[0] > one.chi2 + EVIDENCE)


def _may_be_one(verdict: Verdict, declared: TimeFit) -> bool:
    """Whether a drag may act that was not found, or not alone, and the recording can show it: where
    something acts that is not all told, or where all is, by two effects of which it is one, or by
    what leaves a little while a drag takes its share, too.
    """
    law, final, names = declared.law, verdict.final, verdict.names[verdict.laws :]
    if DRAG.requires(law.setting, law.takes):
        return False
    if verdict.verdict == "unexplained":
        return True
    if not names or (names == (DRAG.name,) and verdict.whole):
        return False
    if len(names) > 1 and DRAG.name in names:
        return True
    shows = any(c.names == (DRAG.name,) and c.share > SHOWN for c in verdict.ranked)
    return shows and final.chi2 > QUIET * final.samples
