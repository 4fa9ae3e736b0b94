"""Modes of the body that sound where an overtone of another one would, and move as that does.

A strip twice as wide as thick swings across at twice its first pitch, and a camera sees both in one
shape. What is not linear sounds the same, so that such a pole is left for the effects at first; it
is the body's where these leave more than noise, and it takes most of what was off without them.
"""

from collections.abc import Callable

from .further import with_overtones_of
from .joint import SHOWN, Heard
from .law import replace
from .residual import EVIDENCE, NOISY, bic, errors, excess
from .sufficiency import fails
from .timefit import fit
from .verdict import Verdict


def with_overtones(
    heard: Heard, verdict: Verdict, diagnose: Callable[[Heard], Verdict]
) -> tuple[Heard, Verdict]:
    """The takes and the verdict, both anew where such modes tell more than what was found does
    without them, held out too.
    """
    before = verdict.final
    told = verdict.verdict == "refused" or before.chi2 < NOISY * before.samples
    if told or None in heard.match.modes:
        return heard, verdict
    # where each mode is damped as it was heard, for that a mode is one hangs on its damping
    free = with_overtones_of(heard.free, heard.match, heard.body)
    if excess(free) > SHOWN * excess(heard.free):
        return heard, verdict
    declared, damping = free, heard.declared.law.damping
    if heard.declared is not heard.free:
        declared = fit(replace(free.law, damping=damping), free.parameters, evaluations=40)
    wider = replace(heard, free=free, declared=declared)
    again = diagnose(wider)
    return (wider, again) if _is_better(again, verdict) else (heard, verdict)


def _is_better(again: Verdict, before: Verdict) -> bool:
    """Whether all is told with such modes, and told better; where it was told before, but for
    noise, and by the same effects but for what is read off the record: what bends a spring rings at
    an overtone, too.
    """
    now, then = again.final, before.final
    told = now.chi2 < NOISY * now.samples and set(before.by_law) <= set(again.names)
    if before.verdict == "explained" and not told:
        return False
    likelier = bic(now) < bic(then) - EVIDENCE
    ahead = not fails(now) or errors(now).held_out <= errors(then).held_out
    return again.verdict in ("explained", "adequate") and likelier and ahead
