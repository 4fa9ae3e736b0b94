"""From a declared fit to a verdict: what is missing, how sure that is, and what to film next.

adequate      what is left is noise, or less than half a per cent of the motion
explained     one or two effects take nearly all of it, on held-out data too
unexplained   something is there, and nothing known takes enough of it, or what is no effect of
              the library takes clearly more
refused       the recording cannot decide
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .baseline import real_shapes
from .damping import find_damping
from .data import poles
from .foils import is_broken, weakens
from .harmonic_inversion import invert
from .law import TimeFit
from .match import mac
from .residual import NOISY, QUIET, excess, misfit, motion_rms, noise_share, nrmse
from .time_layer import (
    EVIDENCE,
    MATERIAL,
    NEARLY,
    Candidate,
    judge,
    pairs,
    refuted,
    singles,
)
from .timefit import sharp, without

ENOUGH = 0.80  # share of the excess that one effect must take to be the explanation
ENOUGH_HELD = 0.70  # the same on held-out samples
ALL = 0.95  # as ENOUGH, where it is read off the record and has to take nearly everything
ENOUGH_BOTH = 0.88  # for two effects, which have more freedom
WEAK = 0.05  # of the motion, rms: more than that is no forgotten weak mode
SECOND_SIZE = 0.25  # of the declared fit's excess, rms, that a second effect must take
SECOND = 0.6  # share of what the first leaves that a second must take
COMPANION = 0.7  # MAC from which a line has a known mode's shape
APART = 0.03  # of its pitch that a further mode keeps from those known and their overtones
RIVALS = 3  # single effects of which a second one is sought
LOUD = 1.5  # noise units, rms: less motion than that decides nothing
SWINGS = 1.5  # of the first mode that a fit must see
FAR_OFF = 2.0  # times its noise, from which a held-out error is that of something not modelled
FRAMES = 2.5  # a swing; below, a pitch may be a folded one


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the time layer found. `chain[0]` is the declared fit; the last is the final one."""

    verdict: str
    chain: tuple[tuple[str | None, TimeFit], ...]
    effects: tuple[Candidate, ...]  # one a found effect, in the order of the chain
    twins: tuple[tuple[str, ...], ...]  # of each found effect
    ranked: tuple[Candidate, ...]
    minor: tuple[tuple[str, float], ...]
    why: str = ""  # a refusal's reason, and what to film instead

    @property
    def final(self) -> TimeFit:
        return self.chain[-1][1]


def diagnose(
    declared: TimeFit,
    free: TimeFit,
    *,
    widen: Callable = lambda found, effects: found,
    start: TimeFit | None = None,
) -> Verdict:
    """Name what the declared fit lacks: a law of damping first, then an effect, or two.

    `widen` (TimeFit, number of effects -> TimeFit) adds the body's modes that a fit with that
    many effects, its last ones, lays bare. `start`: the declared law at other pitches and damping
    ratios, from where effects are sought.
    """
    why = _undecidable(free)
    if why:
        return Verdict("refused", ((None, declared),), (), (), (), (), why)
    lacking = find_damping(declared, free)
    if lacking is None:
        return _sharpened(_diagnose(declared, widen, start or declared))
    damping, twins = lacking
    then = _sharpened(_diagnose(damping.found, widen, damping.found))
    first = ((None, declared), (damping.names[0], damping.found))
    return replace(
        then,
        verdict="explained" if then.verdict == "adequate" else then.verdict,
        chain=first + then.chain[1:],
        effects=(damping, *then.effects),
        twins=(twins, *then.twins),
        ranked=(damping, *then.ranked),
    )


def _sharpened(verdict: Verdict) -> Verdict:
    """The same, with what was found in coarse steps fitted and judged in fine ones."""
    declared = verdict.chain[0][1]
    fine = {found: sharp(found) for _, found in verdict.chain}
    return replace(
        verdict,
        chain=tuple((name, fine[found]) for name, found in verdict.chain),
        effects=tuple(judge(c.names, fine[c.found], declared) for c in verdict.effects),
        ranked=tuple(
            judge(c.names, fine[c.found], declared) if c.found in fine else c
            for c in verdict.ranked
        ),
    )


def _undecidable(found: TimeFit) -> str:
    """Why this recording cannot tell one effect from another; empty where it can."""
    data = found.law.takes[found.law.fitted[0]]
    size = motion_rms(found.law.takes)
    if size < LOUD:
        return (
            f"Too noisy to decide: the motion is {size:.2g} times the noise, {LOUD:g} is needed. "
            "Release it from further out, or bring the camera closer."
        )
    swings = found.frequency[0] * found.law.setting.duration
    if swings < SWINGS:
        return (
            f"Too short to decide: {swings:.2g} swings are fitted, {SWINGS:g} are needed. "
            "Film on until it stands still."
        )
    frames = 1 / (found.frequency[0] * data.frame)
    if frames < FRAMES:
        return (
            f"Too coarse to decide: {frames:.2g} frames a swing, {FRAMES:g} are needed. The true "
            "pitch may be another one that folds to this. Film at twice the frame rate."
        )
    return ""


def _diagnose(declared: TimeFit, widen: Callable, start: TimeFit) -> Verdict:
    chain = ((None, declared),)
    over = excess(declared)
    if over < MATERIAL and declared.chi2 < QUIET * declared.samples and not _fails(declared):
        return Verdict("adequate", chain, (), (), (), ())
    able = singles(start, against=declared)
    ranked = tuple(c for c in able if not c.outdone)
    strong = [c for c in ranked if c.evidence > EVIDENCE]
    if (over < MATERIAL and not any(_shows(c, declared) for c in strong)) or (
        not strong and declared.chi2 < NOISY * declared.samples and not _strays(declared)
    ):
        minor = tuple((c.names[0], gained(declared, c.found)) for c in strong)
        return Verdict("adequate", chain, (), (), ranked, minor)
    strong = [c for c in strong if gained(declared, c.found) >= MATERIAL or _shows(c, declared)]
    if over < WEAK and not _fails(declared) and more_modes(declared, strong):
        return Verdict("adequate", chain, (), (), ranked, ())
    strong = _widened(strong, declared, widen)
    if strong and sufficient(strong[0], ENOUGH):
        if is_broken(declared, strong[0]):
            return Verdict("unexplained", chain, (), (), ranked, ())
        if weakens(declared, strong[0]):
            return _partly(chain, strong[0], strong, ranked)
        return _add_second(chain, strong, ranked, over)
    doubtful = [c for c in able if c.outdone]
    beam = sorted([*strong, *doubtful], key=lambda c: -c.evidence)
    found = _polished(pairs(declared, beam), declared, widen)
    both = [c for c in found if sufficient(c, ENOUGH_BOTH)]
    nearly = [c for c in found if sufficient(c, ENOUGH_BOTH, nearly=True)]
    if both and is_broken(declared, both[0]):
        return Verdict("unexplained", chain, (), (), ranked, ())
    one = _one_of(declared, both[0].found, over, strong) if both else None
    if one:
        return Verdict(
            "explained",
            (*chain, (one.names[0], one.found)),
            (one,),
            (twins_of(one, strong),),
            ranked,
            (),
        )
    if both:
        return _two(chain, both, ranked)
    if nearly and _is_more(nearly[0], strong, over):
        return replace(_two(chain, nearly, ranked), verdict="unexplained")
    partial = [c for c in strong[:1] if c.share > 0.3 and not c.held_share < 0.3]
    if partial:
        return _partly(chain, partial[0], strong, ranked)
    return Verdict("unexplained", chain, (), (), ranked, ())


def _partly(chain, best: Candidate, strong: list[Candidate], ranked) -> Verdict:
    """Not explained, but `best` takes its part."""
    chain += ((best.names[0], best.found),)
    return Verdict("unexplained", chain, (best,), (twins_of(best, strong),), ranked, ())


def _polished(found: list[Candidate], declared: TimeFit, widen: Callable) -> list[Candidate]:
    """The candidates, the best ones with the modes that they lay bare."""
    best = [
        max(c, judge(c.names, widen(c.found, 2), declared), key=lambda one: one.evidence)
        if c.found.chi2 > NOISY * c.found.samples
        else c
        for c in found[:RIVALS]
    ]
    return sorted([*best, *found[RIVALS:]], key=lambda c: -c.evidence)


def _widened(strong: list[Candidate], declared: TimeFit, widen: Callable) -> list[Candidate]:
    """The candidates, those near the best with the modes that they lay bare."""
    near = [c for c in strong[:RIVALS] if c.evidence >= NEARLY * strong[0].evidence]
    out = strong[len(near) :]
    for c in near:
        if c.found.chi2 > NOISY * c.found.samples and not c.found.law.effects[-1].given:
            c = max(c, judge(c.names, widen(c.found, 1), declared), key=lambda one: one.evidence)
        out.append(c)
    return sorted(out, key=lambda c: -c.evidence)


def more_modes(declared: TimeFit, strong: list[Candidate]) -> bool:
    """Whether further weak modes, each with a shape of its own, are all that is left, and tell it
    better than the `strong` effects do.

    A body has more modes than a model matches; their pitches and shapes are the modal layer's
    business. A line with the first mode's shape is none of them: it mimics what acts in time.
    """
    data = declared.law.takes[declared.law.fitted[0]]
    on = ~data.support
    left = (data.values - declared.predicted[declared.law.fitted[0]])[data.fit][:, on]
    time = data.time[data.fit]
    ring = invert(time, left, noise=data.sigma[on], max_modes=5)
    shapes, _ = real_shapes(ring.amplitude)
    first, other = declared.frequency[0] * np.arange(1, 4), declared.frequency[1:]
    own = [
        k
        for k, (s, f) in enumerate(zip(shapes, ring.frequency, strict=True))
        if ring.damping_ratio[k] < 0.2
        and mac(s, declared.shapes[0, on]) < COMPANION
        and np.abs(np.log(f / first)).min() > APART
        and not any(
            abs(np.log(f / g)) < APART and mac(s, there[on]) > COMPANION
            for g, there in zip(other, declared.shapes[1:], strict=True)
        )
    ]
    if not own:
        return False
    phase = np.exp(np.outer(time, poles(ring.frequency[own], ring.damping_ratio[own])))
    q, _ = np.linalg.qr(np.hstack([phase.real, phase.imag, np.ones((len(time), 1))]))
    y, known = np.nan_to_num(left) / data.sigma[on], np.isfinite(left)
    rest, whole = (float((z[known] ** 2).sum()) for z in (y - q @ (q.T @ y), y))
    if strong:
        other = data.values - strong[0].found.predicted[declared.law.fitted[0]]
        if rest > np.nansum((other[data.fit][:, on] / data.sigma[on]) ** 2):
            return False
    return rest < NOISY * known.sum() or whole - rest > ENOUGH * (whole - known.sum())


def _shows(candidate: Candidate, declared: TimeFit) -> bool:
    """Small beside the first swings, but what the dying motion cannot be predicted without."""
    return _fails(declared) and candidate.confirmed


def _fails(declared: TimeFit) -> bool:
    """Whether what was held out is predicted worse than its noise allows."""
    left, count = misfit(declared.law.takes, declared.predicted, True)
    return left > NOISY * count


def _strays(found: TimeFit) -> bool:
    """Whether what was held out is mispredicted by much more than noise."""
    takes = found.law.takes
    return errors(found)[0] > FAR_OFF * noise_share(takes, True) > 0


def gained(before: TimeFit, after: TimeFit) -> float:
    """RMS that a fit takes away, as a share of the motion's RMS."""
    return float(np.sqrt(max(excess(before) ** 2 - excess(after) ** 2, 0)))


def sufficient(candidate: Candidate, enough: float, *, nearly: bool = False) -> bool:
    """Takes nearly all of the excess, where it was fitted and where it was held out.

    `nearly`: what was held out may still be predicted worse than noise, by far.
    """
    _, count = misfit(candidate.found.law.takes, candidate.found.predicted, False)
    takes = candidate.found.chi2 < NOISY * count
    found = candidate.found.law.effects[-len(candidate.names) :]
    takes |= candidate.share >= (ALL if all(e.free for e in found) else enough)
    ahead = ALL if _strays(candidate.found) and not nearly else ENOUGH_HELD
    return takes and not candidate.held_share < ahead


def _is_more(both: Candidate, strong: list[Candidate], over: float) -> bool:
    """Whether two effects do clearly more than the best single one."""
    if not strong:
        return True
    return _counts_second(strong[0], judge(both.names, both.found, strong[0].found), over)


def twins_of(candidate: Candidate, others) -> tuple[str, ...]:
    """Names of single effects whose evidence comes near the candidate's."""
    name = candidate.names[-1]
    return tuple(
        c.names[-1]
        for c in others
        if c.names[-1] != name
        and c.evidence >= NEARLY * candidate.evidence
        and not c.held_share < NEARLY * min(candidate.held_share, 1.0)
    )


def _add_second(chain, strong: list[Candidate], ranked, over: float) -> Verdict:
    """The single effect, and a second one where what is left is material and one effect's.

    Where others come near the best single effect, each is tried with a second one: which of them
    is there may show only beside the right companion.
    """
    best, more = strong[0], []
    if excess(best.found) > MATERIAL and best.found.chi2 > NOISY * best.found.samples:
        left = best.found.chi2 - best.found.samples  # no pair can gain more than this over the best
        tries = []
        for first in [c for c in strong[:RIVALS] if c.evidence >= best.evidence - left]:
            more = singles(first.found, first.names, most=4)
            found = [c for c in more if c.evidence > EVIDENCE and not c.outdone]
            tries.append((first, found))
        able = [t for t in tries if t[1] and _counts_second(t[0], t[1][0], over)]
        best, more = max(able, key=lambda t: t[0].evidence + t[1][0].evidence, default=tries[0])
    if more and _counts_second(best, more[0], over):
        one = _one_of(chain[0][1], more[0].found, over, [best])
        best, more = (best, more) if one is None else (one, [])
    chain += ((best.names[0], best.found),)
    effects, twins, minor = (best,), (twins_of(best, strong),), ()
    for c in more[:1]:
        if _counts_second(best, c, over):
            chain += ((c.names[-1], c.found),)
            effects += (c,)
            twins += (twins_of(c, more),)
        elif gained(best.found, c.found) < MATERIAL:
            minor = ((c.names[-1], gained(best.found, c.found)),)
    return Verdict("explained", chain, effects, twins, ranked, minor)


def _one_of(
    declared: TimeFit, both: TimeFit, over: float, strong: list[Candidate]
) -> Candidate | None:
    """The one of two effects that does without the other and better than the best single one.

    The search for it may have missed it; the second one then only led the way there.
    """
    effects = both.law.effects
    for dropped, kept in ((-2, -1), (-1, -2)):
        alone = without(both, len(effects) + dropped)
        one = judge((effects[kept].name,), alone, declared)
        if one.evidence <= max((c.evidence for c in strong[:1]), default=0.0) or not sufficient(one, ENOUGH):
            continue
        pair = judge((effects[kept].name, effects[dropped].name), both, alone)
        if not (refuted(alone) or _counts_second(one, pair, over)):
            return one
    return None


def _counts_second(first: Candidate, second: Candidate, over: float) -> bool:
    """Whether a second effect is material, and takes most of what the first leaves."""
    enough = gained(first.found, second.found) >= max(MATERIAL, SECOND_SIZE * over)
    return enough and second.share >= SECOND and not second.held_share < 0.5


def _two(chain, both: list[Candidate], ranked) -> Verdict:
    """Two effects found together, the one that does more alone first."""
    best = both[0]
    alone = {c.names[0]: c for c in ranked}
    names = sorted(best.names, key=lambda n: -alone[n].evidence if n in alone else 0)
    declared = chain[0][1]
    middle = alone[names[0]].found if names[0] in alone else best.found
    chain += ((names[0], middle), (names[1], best.found))
    twins = tuple(
        tuple(
            {
                n
                for c in both
                if other in c.names and c.evidence >= 0.9 * best.evidence
                for n in c.names
                if n not in names
            }
        )
        for name, other in ((names[0], names[1]), (names[1], names[0]))
    )
    effects = tuple(judge((n,), best.found, declared) for n in names)
    return Verdict("explained", chain, effects, twins, ranked, ())


def probabilities(ranked, declared: TimeFit) -> list[float]:
    """Of each candidate, tempered: a misfit's independent pieces are its cycles, not its samples.

    The likelihood of a fit whose own error is unknown falls as its misfit to the power -n/2, with
    n the cycles of the first mode in the fitted part.
    """
    if not ranked:
        return []
    cycles = declared.law.setting.omega[0] / (2 * np.pi) * declared.law.setting.duration
    misfits = np.array([c.found.chi2 for c in ranked])
    weight = (misfits / misfits.min()) ** (-max(cycles, 4) / 2)
    return list(weight / weight.sum())


def errors(found: TimeFit) -> tuple[float, float]:
    """Held-out and fitted NRMSE."""
    takes = found.law.takes
    return nrmse(takes, found.predicted, True), nrmse(takes, found.predicted, False)
