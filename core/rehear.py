"""A second hearing: a mode more or fewer, once it is known what acts in time or that nothing is."""

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np

from .carried import carrying
from .effects.base import Effect
from .hearings import nearby, without_mimics
from .joint import SHOWN, Heard
from .law import TimeFit, replace
from .residual import EVIDENCE, NOISY, bic, errors, excess
from .settle import cancels, moves_its_way
from .time_layer import singles
from .timefit import as_it_stands, best_fit, misfits
from .verdict import Verdict
from .widen import begun, placed

STIRRED = (0.0, 0.1, -0.1, 0.3, -0.3)  # of the first mode's start, from which its own is sought
RUNNERS = 2  # of those
MOSTLY = 0.5  # of what was left, rms: where one more mode leaves less, it may move as it likes


def second_hearing(
    heard: Heard, verdict: Verdict, diagnose: Callable[..., Verdict]
) -> tuple[Heard, Verdict]:
    """The takes and the verdict, both anew where that is better with one more low mode; or, where
    all is unexplained, without those that may be none.

    Two modes of a body that lie close together sound as one while something bends their pitches.
    What bends them may be known by now, and what one of them is like follows from the other; or
    it could not be found without the other, or foretells nothing. `diagnose(heard, start)`: the
    latter a fit from where effects are sought, the declared one by default.
    """
    heard, verdict = _with_one_more(heard, verdict, diagnose)
    fewer = without_mimics(heard) if verdict.verdict == "unexplained" else None
    if fewer is None or not _one_foretells_more(fewer.declared, verdict):
        return heard, verdict
    again = diagnose(fewer)
    if not _is_better(again, verdict):
        return heard, verdict
    return _with_one_more(fewer, again, diagnose)


def _one_foretells_more(declared: TimeFit, verdict: Verdict) -> bool:
    """Whether the declared fit, or one effect beside it, foretells more than all that was found."""
    off = errors(_best(verdict) or verdict.final).held_out
    if errors(declared).held_out < off:
        return True
    found, _ = singles(declared, declared)
    return any(errors(one.found).held_out < off for one in found)


def _best(verdict: Verdict) -> TimeFit | None:
    """What was found, or the effect that tells most, if any was tried."""
    if verdict.effects:
        return verdict.final
    return verdict.ranked[0].found if verdict.ranked else None


def _with_one_more(heard: Heard, verdict: Verdict, diagnose) -> tuple[Heard, Verdict]:
    best = _best(verdict)
    quiet = best is not None and best.chi2 < NOISY * best.samples
    if best is None or (quiet and verdict.verdict != "unexplained"):
        return heard, verdict
    for near in nearby(heard):
        wider = _with_the_mode(near, best, heard)
        own = near.declared.law
        left = excess(best)
        moves = partial(moves_its_way, wider, near.body, near.match.modes[-1])
        if cancels(near.declared) and cancels(wider):
            continue
        if excess(wider) < MOSTLY * left or (excess(wider) < SHOWN * left and moves()):
            there = replace(own, setting=wider.law.setting)
            again = diagnose(near, as_it_stands(there, wider.parameters[: sum(own.sizes())]))
        elif excess(near.declared) < SHOWN * excess(heard.declared):
            again = diagnose(near)
        else:
            continue
        if _is_better(again, verdict) and not cancels(again.final):
            return near, again
    return heard, verdict


def _is_better(again: Verdict, before: Verdict) -> bool:
    """Whether more is explained or less is left, held out too, and no less is named."""
    if before.verdict == "explained" != again.verdict or (before.effects and not again.effects):
        return False
    if _is_plainer(again, before):
        return True
    more = before.verdict == "unexplained" and again.verdict in ("explained", "adequate")
    less = excess(again.final) < SHOWN * excess(before.final)
    return (more or less) and not errors(again.final).held_out > errors(before.final).held_out


def _is_plainer(again: Verdict, before: Verdict) -> bool:
    """Whether a mode of the body, beside the same laws, explains more than what was read off the
    record: what is so told of what comes is no foresight.
    """
    named = set(again.names) == set(before.by_law) < set(before.names)
    explains = again.verdict in ("explained", "adequate")
    return named and explains and bic(again.final) < bic(before.final) - EVIDENCE


def _with_the_mode(near: Heard, found: TimeFit, heard: Heard) -> TimeFit:
    """`found` with the further mode of `near`, from where it stands."""
    old, law, K = found.law, near.declared.law, found.law.modes
    known = {e.name for e in [*heard.declared.law.effects, *law.effects]}
    pairs = list(zip(old.effects, found.theta, strict=True))
    before = {e: _wider(e, t[0], K, near.declared) for e, t in pairs}
    declared = zip(law.effects, near.declared.theta, strict=True)
    own = [before.get(e, [t[0]]) for e, t in declared]
    new = [e for e, _ in pairs if e.name not in known]
    inner = [*own, *(before[e] for e in new)]
    computed, modes = near.body.modes.frequency, near.match.modes
    ratio = np.log(computed[modes[-1]] / computed[modes[0]])
    outers = [
        begun(found, np.array([ratio]), lambda own: own[0], lambda own, part=part: part * own[:, 0])
        for part in STIRRED
    ]
    starts = [np.concatenate([outer, *some]) for outer in outers for some in product(*inner)]
    # what an effect's numbers are relative to
    omega = np.r_[old.setting.omega, law.setting.omega[K:]]
    setting = replace(law.setting, omega=omega, amplitude=old.setting.amplitude)
    law = replace(
        law,
        effects=(*law.effects, *new),
        tied=((K, ratio),),
        setting=setting,
    )
    starts = np.array(starts)
    left = misfits(law, starts, near.declared.samples)
    # without a force, starts of the new mode that differ in size and sign alone are one
    likely = np.unique(np.log(left).round(6), return_index=True)[1][:RUNNERS]
    return carrying(best_fit(law, starts[likely], evaluations=20))


def _wider(effect: Effect, theta: np.ndarray, modes: int, near: TimeFit) -> list[np.ndarray]:
    """The effect's numbers, with what its place may share in the further mode: as the nearest place
    that is known, or nothing.
    """
    places = near.law.setting.places
    if not effect.force:
        return [theta]
    nothing = np.r_[places[0, : modes - 1], np.zeros(places.shape[1] - modes + 1)]
    return [
        one for some in (places, nothing[None]) for one in placed(effect, theta, modes, some, 1)
    ]
