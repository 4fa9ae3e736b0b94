"""The frames that a recording lost, read off what a fit leaves: jumps of whole frames."""

from functools import partial

import numpy as np

from .effects import lost_frames
from .effects.base import Effect
from .in_step import in_step
from .law import Law, TimeFit
from .refit import MOVED, swapped
from .timefit import extend, fit, standing

SEEN = 12  # frames in which every channel is there, more than which jumps need
ROUNDS = 3  # of looks for more jumps
NEAR = 4  # frames between two jumps that may be one
REFITTED = 5  # looks of a fit with them: what it took for a pitch must turn back


def jumps(start: TimeFit) -> list[Effect]:
    """The one effect whose jumps, all whole frames, the residuals show, if they show any.

    What else is missing makes jumps too, of any length. Where those that are seen, as whole frames,
    do not end so, only those are taken that look so from the first.
    """
    takes = tuple(start.law.takes[index] for index in start.law.fitted)
    if min(np.isfinite(start.missed(n)).all(axis=1).sum() for n in range(len(takes))) <= SEEN:
        return []
    none = ((),) * len(takes)

    def as_seen():
        known, found = _moved(*_sought(start, takes, lambda gain: True), takes)
        return none if _whole(found, known) != known else known

    def if_whole():
        known, found = _less_others(start, *_sought(start, takes, lost_frames.is_whole), takes)
        return _less_others(start, *_moved(known, found, takes), takes)[0]

    for known in in_step([as_seen, if_whole]):
        if any(known) and not any(map(lost_frames.too_many, known, takes)):
            known = _no_stairs(start, known, takes)
            return [lost_frames.lost(known, takes)] if any(known) else []
    return []


def _no_stairs(start: TimeFit, known: tuple, takes: tuple) -> tuple:
    """The jumps, without a take's where they stand for a pitch that was another for a while."""
    if max(map(len, known)) < lost_frames.STAIRS:
        return known
    found = _with_jumps(start, known, takes)
    return tuple(() if _sight(found, n).is_ramp(own) else own for n, own in enumerate(known))


def _sought(start: TimeFit, takes: tuple, is_one) -> tuple[tuple, TimeFit]:
    """The jumps that the residuals show one after another, of those whose frames are such as
    `is_one` wants, and the fit with them; none where there are twice as many as a recording may
    have, for two may yet turn out to be one.
    """
    none = ((),) * len(takes), start
    known, found = none
    for _ in range(ROUNDS):
        seen = [lost_frames.next_jumps(_sight(found, n)) for n in range(len(takes))]
        more = [
            [(when, round(gain) * data.frame) for when, gain in own if is_one(gain)]
            for own, data in zip(seen, takes, strict=True)
        ]
        if not any(gain for own in more for _, gain in own):
            break
        known = _gathered(known, more, takes)
        pairs = zip(known, takes, strict=True)
        if any(lost_frames.too_many(own, data, 2 * lost_frames.MOST) for own, data in pairs):
            return none
        found = _with_jumps(start, known, takes)
    return known, found


def _moved(known: tuple, found: TimeFit, takes: tuple) -> tuple[tuple, TimeFit]:
    """The jumps, and the fit with them, each where it fits best nearby; two near one another as
    one, where that fits better.
    """
    for _ in range(ROUNDS):
        moves = [
            (n, at, *move)
            for n, data in enumerate(takes)
            for at in range(len(known[n]))
            for move in _nearby(known[n], at, data.frame)
        ]
        some = [_after(known, [move], takes) for move in moves]
        left = in_step([partial(_left_with, found, lost_frames.lost(one, takes)) for one in some])
        before = _left(found)
        better = [moves[i] for i in np.argsort(left) if left[i] < before]
        if not better:
            break
        tries = dict.fromkeys(_after(known, one, takes) for one in (_apart(better), better[:1]))
        tries = list(tries)
        fits = in_step([partial(_instead, found, lost_frames.lost(one, takes)) for one in tries])
        least = min(range(len(tries)), key=lambda n: _left(fits[n]))
        if not _left(fits[least]) < before:
            break
        known, found = tries[least], fits[least]
    return known, found


def _nearby(own: tuple, at: int, frame: float) -> list[tuple]:
    """(how many of a take's jumps, from number `at` on, the one in their place): it moved, or made
    one with the next one where that is near.
    """
    when, gap = own[at]
    out = [(1, (when + shift, gap)) for shift in frame * np.array([-2, -1, 1, 2])]
    if at + 1 < len(own) and own[at + 1][0] - when < (NEAR + 0.5) * frame:
        out += [(2, (place, gap + own[at + 1][1])) for place, _ in own[at : at + 2]]
    return out


def _apart(moves: list) -> list:
    """Of the moves, best first, those of other jumps than the better ones."""
    out, gone = [], set()
    for n, at, many, jump in moves:
        own = {(n, at + i) for i in range(many)}
        if not own & gone:
            out.append((n, at, many, jump))
            gone |= own
    return out


def _after(known: tuple, moves: list, takes: tuple) -> tuple:
    """The jumps after moves of different ones: (take, number, how many, the one in their place)."""
    out = [list(own) for own in known]
    for n, at, many, jump in sorted(moves, key=lambda move: -move[1]):
        out[n][at : at + many] = [jump]
    return _gathered(out, ((),) * len(takes), takes)


def _left_with(found: TimeFit, effect: Effect) -> float:
    """What is left with other jumps in the last effect's place, all else as it stands."""
    law, (start,) = swapped(found, effect, [()])
    return _left_in_all(law, *standing(law, start))


def _instead(found: TimeFit, effect: Effect) -> TimeFit:
    """Fitted again with other jumps in the last effect's place."""
    law, (start,) = swapped(found, effect, [()])
    return fit(law, start, evaluations=MOVED)


def _left(found: TimeFit) -> float:
    return _left_in_all(found.law, found.chi2, found.predicted)


def _left_in_all(law: Law, chi2: float, predicted) -> float:
    """Misfit of the fitted takes, their last part too: a jump may lie there."""
    total = chi2
    for index in law.fitted:
        data = law.takes[index]
        left = ((data.values - predicted[index]) / data.sigma)[~data.fit][:, ~data.support]
        total += float(np.nansum(left**2))
    return total


def _less_others(start: TimeFit, known: tuple, found: TimeFit, takes: tuple):
    """The jumps, and the fit with them, without those that are not of whole frames."""
    while any(known) and (whole := _whole(found, known)) != known:
        known = whole
        found = _with_jumps(start, known, takes)
    return known, found


def _whole(found: TimeFit, known: tuple) -> tuple:
    """The jumps without those that the fit with them leaves other than whole."""
    out = []
    for n, own in enumerate(known):
        left = _sight(found, n).left_of(own) if own else ()
        pairs = zip(own, left, strict=True)
        out.append(tuple(jump for jump, rest in pairs if abs(rest) < lost_frames.WHOLE))
    return tuple(out)


def _gathered(jumps: tuple, more, takes: tuple) -> tuple:
    return tuple(
        lost_frames.gathered(own, other, data.frame)
        for own, other, data in zip(jumps, more, takes, strict=True)
    )


def _with_jumps(start: TimeFit, jumps: tuple, takes: tuple) -> TimeFit:
    law, p = extend(start, (lost_frames.lost(jumps, takes),), [()])
    return fit(law, p, evaluations=REFITTED)


def _sight(found: TimeFit, take: int) -> lost_frames.Sight:
    index = found.law.fitted[take]
    data = found.law.takes[index]
    u, s = found.motions[take], data.time[:, None] / data.time[-1]
    v = np.gradient(u, data.time, axis=0) / found.law.setting.omega
    basis = np.hstack([u, v, s * u, s * v, np.ones((len(u), 1))])
    return lost_frames.Sight(data, found.predicted[index], basis)
