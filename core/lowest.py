"""Fits of the body's lowest modes, heard or not, that begin where the body itself has them.

What takes energy from all modes, a drag or a rub, makes them die away as no exponential does, and
modes that lie close together damp one another: what is heard are poles that no mode has, and a
search from there goes astray. How far the body's pitches lie apart, and how a force takes hold of
every mode, are known of the body; so nothing that was heard counts here but the strongest one's
pitch.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from .carried import carrying
from .effects.base import FINE
from .effects.further_mode import is_further
from .joint import Heard
from .law import Law, TimeFit
from .residual import EVIDENCE, NOISY, bic, errors
from .settle import MUCH, STRAY
from .stirred import LIGHT, LOOKS, SHARES, SILENT, of_heard, widened
from .sufficiency import CLEARLY, at_a_bound, bends_the_body, owes
from .time_layer import judge, vetoed
from .timefit import conclude, walked
from .verdict import Verdict, Whole, twins_of
from .widen import begun

NEAR = 0.15  # of the strongest mode's pitch, within which another one may swing with it unheard
BESIDE = (0.5, -0.5)  # of its swing, from which that one's is sought, too
FEWEST = 8  # modes: what takes much damps those that were let go by what it makes the others do
MOST = 3  # of the searches that are looked at


@dataclass(frozen=True, eq=False)
class Lowest:
    """What was heard with the body's lowest modes, and the law of a fit with these."""

    heard: Heard
    law: Law
    apart: np.ndarray  # (N,) log of each mode's computed pitch over the first one's


def lowest_of(heard: Heard, found: TimeFit) -> Lowest | None:
    """The lowest modes for what may act beside a fit; None where all of them were heard, or a march
    follows what it has already.
    """
    if any(e.marched for e in found.law.effects):
        return None
    wider = widened(heard, found, FEWEST, FINE)
    if wider is None:
        return None
    more, law = wider
    computed = heard.body.modes.frequency[list(more.match.modes)]
    return Lowest(more, law, np.log(computed / computed[0]))


def with_effects(lowest: Lowest, *effects) -> Lowest:
    """The same with so many more effects, last."""
    law = replace(lowest.law, effects=(*lowest.law.effects, *effects))
    return replace(lowest, law=law)


def starts_of(lowest: Lowest, found: TimeFit, begins: list[np.ndarray]) -> np.ndarray:
    """(S, p) from where the law is searched: the modes as the body has them, lightly damped, what
    `found` has as it is there, and the `begins` of what it has not.
    """
    K, N, apart = found.law.modes, lowest.law.modes, lowest.apart
    outer = begun(
        found, apart[K:], lambda _: LIGHT, lambda starts: (SILENT * np.hypot(*starts).max(), 0.0)
    )
    (a, b, _), pairs = lowest.law.sizes(), zip(found.law.effects, found.theta, strict=True)
    inner = np.concatenate([np.zeros(0), *(t[0] for e, t in pairs if not is_further(e))])
    at, swing = outer[:a].reshape(-1, 2, N), outer[a : a + b].reshape(-1, 2, N)
    at[:, 0] = at[:, 0, :1] + apart
    at[:, 1] = LIGHT
    swings = [swing]
    for k in np.flatnonzero(np.abs(apart) < NEAR)[1:]:
        for part in BESIDE:
            swings.append(swing.copy())
            swings[-1][:, :, k] = part * swing[:, :, 0]
    return np.array([np.r_[at.ravel(), one.ravel(), inner, b] for one in swings for b in begins])


def fitted(lowest: Lowest, found: TimeFit, begins: list[np.ndarray]) -> Iterator[list[TimeFit]]:
    """The best fits of the law: those that were held at the body's pitches at first, then those
    that were free at once.
    """
    law, starts = lowest.law, starts_of(lowest, found, begins)
    held = replace(law, tied=tuple((k, float(gap)) for k, gap in enumerate(lowest.apart) if k))
    for first in held, law:
        walks = walked(first, starts, SHARES, LOOKS, most=MOST)
        if first is held:
            walks = walked(law, np.array([p for p, _, _ in walks]), SHARES[-1:], LOOKS, most=MOST)
        yield [carrying(conclude(law, p, jacobian)) for p, jacobian, _ in walks]


def least_of(lowest: Lowest, found: TimeFit, begins: list[np.ndarray]) -> float:
    """The least that the law leaves, for its numbers."""
    return min(bic(one) for some in fitted(lowest, found, begins) for one in some)


def explains(one: TimeFit, declared: TimeFit, apart: np.ndarray, clearly: float = CLEARLY) -> bool:
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


def tells_more(one: TimeFit, verdict: Verdict) -> bool:
    """Whether a fit leaves less than what was found, for its numbers, and foretells as much."""
    best = verdict.complete
    margin = EVIDENCE if verdict.verdict == "explained" else 0.0
    return errors(one).held_out <= errors(best).held_out and bic(one) < bic(best) - margin


def in_place(
    verdict: Verdict,
    more: Heard,
    fits: list[tuple[str, TimeFit]],
    *,
    said: str = "explained",
    twins: tuple = (),
    alone: dict[str, TimeFit] | None = None,
) -> Verdict:
    """The verdict with the names of the `fits` of all modes, each with one more than the one before
    it, in place of what it has, told by what each says of the heard modes. said: what it is then;
    twins: of each, if there are two; alone: fits of all modes with one effect each, ranked as such.
    """
    known, declared, (_, best) = verdict.laws, verdict.damped, fits[-1]
    told = [(name, of_heard(one, declared)) for name, one in fits]
    final, names = told[-1][1], tuple(name for name, _ in told)
    found = tuple(replace(judge((name,), best, declared), found=final) for name in names)

    def as_heard(name, one):
        return replace(judge((name,), one, declared), found=of_heard(one, declared))

    # others were fitted with the heard modes only, and so is what they are ranked with, if it was
    heard = {c.names[0]: c for c in verdict.ranked[known:]}
    like = {name: as_heard(name, one) for name, one in (alone or {}).items()}
    ranked = {names[0]: as_heard(*fits[0])} | heard | like
    others = [c for name, c in ranked.items() if name != names[0]]
    twins = twins or ([twins_of(found[0], others)] if len(found) == 1 else [(), ()])
    unlike = names[0] in heard and names[0] not in like
    return replace(
        verdict,
        verdict=said,
        chain=(*verdict.chain[: known + 1], *told),
        effects=(*verdict.effects[:known], *found),
        twins=(*verdict.twins[:known], *twins),
        ranked=(*verdict.ranked[:known], *sorted(ranked.values(), key=lambda c: -c.evidence)),
        minor=(),
        bare=heard[names[0]].found if unlike and len(found) == 1 else None,
        whole=Whole(more, best),
    )
