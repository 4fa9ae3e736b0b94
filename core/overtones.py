"""Modes of the body that sound where an overtone of another one would, and move as that does.

A strip twice as wide as thick swings across at twice its first pitch, and a camera sees both in one
shape. What is not linear sounds the same, so that such a pole is left for the effects at first; it
is the body's where these leave more than noise, and it far less.
"""

from collections.abc import Callable

from .further import with_overtones_of
from .joint import SHOWN, Heard
from .law import TimeFit, replace
from .residual import EVIDENCE, NOISY, bic, errors, excess
from .sufficiency import fails
from .verdict import Verdict


def with_overtones(
    heard: Heard, verdict: Verdict, diagnose: Callable[[Heard], Verdict]
) -> tuple[Heard, Verdict]:
    """The takes and the verdict, both anew where such modes tell more than what was found does
    without them, held out too.
    """
    before = verdict.final
    if before.chi2 < NOISY * before.samples or None in heard.match.modes:
        return heard, verdict
    declared = _with_them(heard, heard.declared)
    if excess(declared) > SHOWN * excess(heard.declared):
        return heard, verdict
    same = heard.free is heard.declared
    free = declared if same else _with_them(heard, heard.free)
    wider = replace(heard, free=free, declared=declared)
    again = diagnose(wider)
    return (wider, again) if _is_better(again, verdict) else (heard, verdict)


def _with_them(heard: Heard, found: TimeFit) -> TimeFit:
    return with_overtones_of(found, heard.match, heard.body)


def _is_better(again: Verdict, before: Verdict) -> bool:
    """Whether all is told with such modes, and told better."""
    now, then = again.final, before.final
    likelier = bic(now) < bic(then) - EVIDENCE
    ahead = not fails(now) or errors(now).held_out <= errors(then).held_out
    return again.verdict in ("explained", "adequate") and likelier and ahead
