"""A drag on all modes that the body may swing in, where few of them are heard beside it, and what
shows beside that.

Drag makes a mode die away as no exponential does, and modes that lie close together damp one
another: what is heard are poles that no mode has, and a search from there goes astray. How far the
body's pitches lie apart, and how the air takes hold of every mode, are known of the body; so
nothing that was heard counts here but the strongest one's pitch.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from .by_two import SHOWN
from .carried import carrying
from .effects import air_drag
from .effects.base import FINE
from .effects.further_mode import is_further
from .joint import Heard
from .law import Law, TimeFit
from .refit import without
from .residual import EVIDENCE, NOISY, QUIET, bic, errors
from .settle import MUCH, STRAY
from .stirred import LIGHT, LOOKS, SHARES, SILENT, of_heard, widened
from .sufficiency import CLEARLY, CLEARLY_BOTH, at_a_bound, bends_the_body, owes
from .time_layer import judge, seconds, vetoed
from .timefit import conclude, walked
from .verdict import Verdict, Whole, twins_of
from .widen import begun

DRAG = air_drag.EFFECT
STRENGTHS = (0.05, 0.2, 0.5, 1.2)  # from which a drag is sought
NEAR = 0.15  # of the strongest mode's pitch, within which another one may swing with it unheard
BESIDE = (0.5, -0.5)  # of its swing, from which that one's is sought, too
FEWEST = 8  # modes: a strong drag damps those that were let go by what it makes the others do
MOST = 3  # of the searches that are looked at


def with_drag(heard: Heard, verdict: Verdict, *, beside: bool = False) -> Verdict | None:
    """The verdict that a drag on the body's lowest modes explains all, or, where nothing was found
    that does, such a drag and what shows `beside` it; None where these do not, or tell no more than
    what was found.
    """
    found = verdict.damped
    if not _may_be_one(verdict, found) or any(e.marched for e in found.law.effects):
        return None
    wider = widened(heard, found, FEWEST, FINE)
    if wider is None:
        return None
    more, law = wider
    computed = heard.body.modes.frequency[list(more.match.modes)]
    apart = np.log(computed / computed[0])
    begins = [np.array([s]) for s in STRENGTHS]
    drags, able = [], []
    for some in _fitted(replace(law, effects=(*law.effects, DRAG)), found, apart, begins):
        drags.append(min(some, key=bic))
        able = [one for one in some if _explains(one, found, apart)]
        if able:
            break
    one = min(able, key=bic, default=None)
    if one is None:
        seeks = beside and verdict.verdict == "unexplained"
        return _with_another(verdict, wider, drags, apart) if seeks else None
    if not _tells_more(one, verdict):
        return None
    plain = chain.from_iterable(_fitted(law, found, apart, [np.zeros(0)]))
    if bic(one) > min(map(bic, plain)) - EVIDENCE:  # all that it needs is the modes
        return None
    return _in_place(verdict, more, [one])


def _with_another(
    verdict: Verdict, wider: tuple[Heard, Law], drags: list[TimeFit], apart: np.ndarray
) -> Verdict | None:
    """The verdict that one of the `drags`, of which the best alone tells more than all that was
    found, and what shows beside it explain all: the best one may have bent itself to what the other
    effect does. `wider`: what they are fits of, but for the drag.
    """
    declared, (more, law) = verdict.damped, wider
    first = min(drags, key=bic)
    if not bic(first) < bic(verdict.complete):
        return None
    firsts = [judge((DRAG.name,), one, declared) for one in drags]
    seen = seconds(firsts, [declared] * len(firsts), declared)
    able = (c.found for some in seen for c in some if not c.outdone)
    able = (c for c in able if _explains(c, declared, apart, CLEARLY_BOTH))
    both = min((c for c in able if _tells_more(c, verdict)), key=bic, default=None)
    if both is None or bic(both) > bic(first) - EVIDENCE:
        return None
    other, theta = both.law.effects[-1], both.theta[-1][0]
    undragged = replace(law, effects=(*law.effects, other))
    rivals = [without(both, both.law.effects.index(DRAG))]
    rivals += chain.from_iterable(_fitted(undragged, declared, apart, [theta]))
    if bic(both) > min(map(bic, rivals)) - EVIDENCE:  # all that the other one needs is the modes
        return None
    return _in_place(verdict, more, [first, both])


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


def _fitted(
    law: Law, found: TimeFit, apart: np.ndarray, begins: list[np.ndarray]
) -> Iterator[list[TimeFit]]:
    """The best fits of a law whose modes lie, in logarithms, `apart` (N,) from the first one: those
    that were held there at first, then those that were free at once. `begins`: from where the
    numbers of what `found` has not.
    """
    K, N = found.law.modes, law.modes
    outer = begun(
        found, apart[K:], lambda _: LIGHT, lambda starts: (SILENT * np.hypot(*starts).max(), 0.0)
    )
    (a, b, _), pairs = law.sizes(), zip(found.law.effects, found.theta, strict=True)
    inner = np.concatenate([np.zeros(0), *(t[0] for e, t in pairs if not is_further(e))])
    at, swing = outer[:a].reshape(-1, 2, N), outer[a : a + b].reshape(-1, 2, N)
    at[:, 0] = at[:, 0, :1] + apart
    at[:, 1] = LIGHT
    swings = [swing]
    for k in np.flatnonzero(np.abs(apart) < NEAR)[1:]:
        for part in BESIDE:
            swings.append(swing.copy())
            swings[-1][:, :, k] = part * swing[:, :, 0]
    starts = [np.r_[at.ravel(), one.ravel(), inner, b] for one in swings for b in begins]
    held = replace(law, tied=tuple((k, float(gap)) for k, gap in enumerate(apart) if k))
    for first in held, law:
        walks = walked(first, np.array(starts), SHARES, LOOKS, most=MOST)
        if first is held:
            walks = walked(law, np.array([p for p, _, _ in walks]), SHARES[-1:], LOOKS, most=MOST)
        yield [carrying(conclude(law, p, jacobian)) for p, jacobian, _ in walks]


def _explains(one: TimeFit, declared: TimeFit, apart: np.ndarray, clearly: float = CLEARLY) -> bool:
    """Whether a fit leaves nothing but noise, in modes that lie as far apart as the body's, but for
    those that are too damped to ring. clearly: see `owes`.
    """
    if one.chi2 > NOISY * one.samples or owes(one, declared, clearly):
        return False
    if vetoed(one) or bends_the_body(one) or at_a_bound(one, declared):
        return False
    off = np.log(one.frequency) - apart
    off = np.abs(off - off[one.loudest])
    return not (off[one.damping_ratio < MUCH] > STRAY).any()


def _tells_more(one: TimeFit, verdict: Verdict) -> bool:
    """Whether a drag leaves less than what was found, for its numbers, and foretells as much."""
    best = verdict.complete
    margin = EVIDENCE if verdict.verdict == "explained" else 0.0
    return errors(one).held_out <= errors(best).held_out and bic(one) < bic(best) - margin


def _in_place(verdict: Verdict, more: Heard, fits: list[TimeFit]) -> Verdict:
    """The verdict with a drag, and what the last one of the `fits` has beside it, in place of what
    it names, told by what each fit says of the heard modes.
    """
    known, declared, best = verdict.laws, verdict.damped, fits[-1]
    told = [(one.law.effects[-1].name, of_heard(one, declared)) for one in fits]
    final, names = told[-1][1], tuple(name for name, _ in told)
    found = tuple(replace(judge((name,), best, declared), found=final) for name in names)
    others = [c for c in verdict.ranked[known:] if c.names != names[:1]]
    # others were fitted with the heard modes only, and so is what they are ranked with, if it was
    heard = next((c for c in verdict.ranked[known:] if c.names == names[:1]), None)
    alone = heard or replace(judge(names[:1], fits[0], declared), found=told[0][1])
    twins = [twins_of(found[0], others)] if len(found) == 1 else [(), ()]
    return replace(
        verdict,
        verdict="explained",
        chain=(*verdict.chain[: known + 1], *told),
        effects=(*verdict.effects[:known], *found),
        twins=(*verdict.twins[:known], *twins),
        ranked=(*verdict.ranked[:known], *sorted([alone, *others], key=lambda c: -c.evidence)),
        minor=(),
        bare=heard.found if heard and len(found) == 1 else None,
        whole=Whole(more, best),
    )
