"""The best single effect, and a second one beside it."""

from .law import TimeFit
from .residual import EVIDENCE, NOISY, excess, misfit
from .sufficiency import counts_second, fails, gained, one_of
from .time_layer import MATERIAL, Candidate, seconds
from .verdict import Verdict, twins_of

RIVALS = 3  # single effects, the best ones, beside which a second one is sought


def add_second(chain, strong: list[Candidate], ranked, over: float) -> tuple[Verdict, dict]:
    """The single effect, and a second one where what is left is material and one effect's; and what
    was sought beside single effects, by their fits.

    Where others come near the best single effect, each is tried with a second one: which of them
    is there may show only beside the right companion.
    """
    best, more, known = strong[0], [], {}
    more_left = excess(best.found) > MATERIAL and best.found.chi2 > NOISY * best.found.samples
    if more_left or fails(best.found):
        left = _left(best.found)  # no pair can gain more than this over the best
        firsts = [c for c in strong[:RIVALS] if c.evidence >= best.evidence - left]
        found = [c.found for c in firsts]
        known = dict(zip(found, seconds(firsts, found), strict=True))
        tries = [
            (first, [c for c in known[first.found] if c.evidence > EVIDENCE and not c.outdone])
            for first in firsts
        ]
        able = [t for t in tries if t[1] and counts_second(t[0], t[1][0], over)]
        best, more = max(able, key=lambda t: t[0].evidence + t[1][0].evidence, default=tries[0])
    if more and counts_second(best, more[0], over):
        one = one_of(chain[0][1], more[0].found, over, best.evidence)
        best, more = (best, more) if one is None else (one, [])
    chain += ((best.names[0], best.found),)
    effects, twins, minor = (best,), (twins_of(best, strong),), ()
    for c in more[:1]:
        if counts_second(best, c, over):
            chain += ((c.names[-1], c.found),)
            effects += (c,)
            twins += (twins_of(c, more),)
        elif gained(best.found, c.found) < MATERIAL:
            minor = ((c.names[-1], gained(best.found, c.found)),)
    return Verdict("explained", chain, effects, twins, ranked, minor), known


def _left(found: TimeFit) -> float:
    """Misfit beyond noise, where it was fitted and held out."""
    ahead, count = misfit(found.law.takes, found.predicted, True)
    return max(found.chi2 - found.samples, 0.0) + max(ahead - count, 0.0)
