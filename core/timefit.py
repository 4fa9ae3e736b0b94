"""Fit the modes of the tracks, with effects simulated in them, by variable projection.

Law         y_c(t) = offset_c + sum_k S_kc u_k(t - delay_c) + columns with shapes of their own
Unknown     pitch and damping per mode, start of every take, the effects' parameters (searched);
            shapes S, offsets and columns' shapes are linear and drop out of the search
Source      Golub and Pereyra, Inverse Problems 19 (2003) R1 (variable projection)
"""

from dataclasses import replace
from functools import partial

import numpy as np

from .ahead import ahead
from .channels import cut
from .descent import descend
from .effects.base import FINE, Effect
from .law import Law, TimeFit, bounds, unpack
from .linear_part import Solved, left_over, march, residuals, solve, without_columns
from .side_by_side import may_share, side_by_side

DONE, NEAR = 1e-5, 1e-2  # share of the misfit that a last step gains, at the end and on the way
LAGS = 1.5  # of the best walk's misfit: one that is more off does not catch up
MANY = 4  # marched searches that are worth two processes
MUCH = 5e5  # samples, times numbers searched from all starts: a tenth of a second or more
FAINT = 0.01  # of its size, that a start may give a shape, and one over the most
GONE = 1e-6  # the same where no effect hangs on the size: below is what rounding leaves
FURTHEST = 0.7  # logarithm, that a pitch may end from where it was heard: an octave
SAME = 0.0005  # of what its parameters may be: nearer the best walk, one is where that is


def in_part(law: Law, horizon: float) -> Law:
    """The law with fitted takes no longer than that share of the fitted part: all else is marched
    in vain.
    """
    takes = list(law.takes)
    for index in law.fitted:
        data = takes[index]
        first, last = data.time[0], data.time[data.fit][-1]
        n = int((data.time <= first + horizon * (last - first) + 1e-12).sum())
        takes[index] = cut(data, n)
    return replace(law, takes=tuple(takes))


def _bounds(law: Law) -> tuple[np.ndarray, np.ndarray]:
    """(p,) and (p,) between which the parameters lie."""
    K, A = law.modes, law.setting.amplitude
    a, b, _ = law.sizes()
    centre = np.log(law.setting.omega / (2 * np.pi))
    low = np.concatenate([np.tile(np.r_[centre - FURTHEST, np.zeros(K)], a // (2 * K))])
    high = np.concatenate([np.tile(np.r_[centre + FURTHEST, np.full(K, 0.9)], a // (2 * K))])
    inner = [bounds(e, K, law.setting.places) for e in law.effects]
    effect_low = np.concatenate([i[0] for i in inner]) if inner else np.zeros(0)
    effect_high = np.concatenate([i[1] for i in inner]) if inner else np.zeros(0)
    wide = np.full(b, 50 * A)
    return np.r_[low, -wide, effect_low], np.r_[high, wide, effect_high]


def within(law: Law, P: np.ndarray) -> np.ndarray:
    """Parameters P (B, p), those beyond a bound put on it."""
    return np.clip(P, *_bounds(law))


def _steps(law: Law) -> np.ndarray:
    a, b, c = law.sizes()
    return np.r_[np.full(a, 1e-6), np.full(b, 1e-5 * law.setting.amplitude), np.full(c, 1e-5)]


def fit(law: Law, start: np.ndarray, horizons=(1.0,), evaluations: int = 10) -> TimeFit:
    """Least squares from `start` (p,), over growing shares of the fitted part."""
    return best_fit(law, start[None], horizons, evaluations)


def best_fit(
    law: Law,
    starts: np.ndarray,
    horizons=(1.0,),
    evaluations: int = 10,
    close: tuple[float, float] = (DONE, 0.0),
) -> TimeFit:
    """The best that `fit` finds from any of `starts` (S, p), all searched at once.

    `close`: gain of a last look at which the search ends, as a share of chi2 and in chi2.
    """
    p, jacobian, _ = walked(law, starts, horizons, evaluations, close=close)[0]
    return conclude(law, p, jacobian)


def walked(law: Law, starts, horizons, evaluations: int, most: int = 2, close=(DONE, 0.0)) -> list:
    """(p, Jacobian, cost) of the best searches from `starts`, `most` at most, best first."""
    low, high = _bounds(law)
    for horizon in horizons:
        short = in_part(law, horizon)
        starts = np.clip(_gauged(short, np.array(starts)), low + 1e-12, high - 1e-12)
        end = (evaluations, *close) if horizon == 1.0 else (evaluations, NEAR, 0.0)
        walks = _promising(_descended(short, starts, (low, high), end), high - low, most)
        starts = [p for p, _, _ in walks]
    return walks


def _promising(walks: list, reach: np.ndarray, most: int) -> list:
    """The best walk, and next ones that are neither far behind it nor where a better one is."""
    best, *others = sorted(walks, key=lambda walk: walk[2])
    out = [best]
    for walk in others:
        apart = all((np.abs(walk[0] - one[0]) > SAME * reach).any() for one in out)
        if walk[2] < LAGS * best[2] and apart and len(out) < most:
            out.append(walk)
    return out


def as_it_stands(law: Law, p: np.ndarray) -> TimeFit:
    """What a fit that ended at `p` says."""
    ((_, jacobian),) = _look(in_part(law, 1.0), [p], _bounds(law)[1])
    return conclude(law, p, jacobian)


def resized(found: TimeFit) -> TimeFit:
    """A fit without effects with every shape as large as in the body, however far it was from it.

    A search that began at a wrong size, or on the other side of nought, may have left for ever
    larger swings of ever smaller shapes: to a linear motion all of these are the same.
    """
    start = _gauged(found.law, found.parameters[None], GONE)[0]
    return min(found, fit(found.law, start), key=lambda one: one.chi2)


def _gauged(law: Law, P: np.ndarray, least: float = FAINT) -> np.ndarray:
    """P (B, p) with every start scaled so that its shape is one at the reference again.

    A new effect turns shapes; the scale follows at once here, and only slowly in the search. One
    that is nearly gone may be so because the start is wrong, and is left as it is.
    """
    coefficients = solve(law, P).coefficients
    a, _, _ = law.sizes()
    P, K = P.copy(), law.modes
    for take, index in enumerate(law.fitted):
        at = law.own * law.condition[index]
        own = coefficients[:, :, at : at + K]
        scale = np.einsum("kc,bck->bk", law.gauge(law.condition[index]), own)
        scale = np.where((np.abs(scale) > least) & (np.abs(scale) < 1 / least), scale, 1.0)
        P[:, a + 2 * K * take :][:, : 2 * K] *= np.tile(scale, 2)
    return P


def _look(law: Law, places: list[np.ndarray], high: np.ndarray) -> list:
    """Residuals and Jacobian at every place, in one batch: many march for little more than one."""
    steps = _steps(law)
    moves = [np.where(x + steps < high, steps, -steps) for x in places]
    batch = [x + np.vstack([0 * x, np.diag(m)]) for x, m in zip(places, moves, strict=True)]
    out = residuals(law, np.vstack(batch)).reshape(len(places), len(steps) + 1, -1)
    for (here, *moved), move in zip(out, moves, strict=True):
        for row, step in zip(moved, move, strict=True):  # one by one, while it is near at hand
            row -= here
            row /= step
    return [(one[0], one[1:].T) for one in out]


def _descended(law: Law, starts: np.ndarray, bounds, end: tuple[int, float, float]) -> list:
    """As `descend`, half of the searches by each of two processes, where there may be two and they
    are work enough: the steps of a march cost much the same for a few of them.
    """
    samples = sum(law.takes[i].values.size for i in law.fitted)
    few = len(starts) < MANY and any(e.marched for e in law.effects)
    search = partial(descend, partial(_look, law, high=bounds[1]), bounds=bounds, end=end)
    if few or samples * starts.size < MUCH or not may_share():
        return search(starts)
    halves = [half for half in np.array_split(starts, 2) if len(half)]
    done = side_by_side([partial(search, half) for half in halves])
    return [walk for half in done for walk in half]


def misfits(law: Law, P: np.ndarray, rows: int | None = None) -> np.ndarray:
    """(B,) chi2 at parameters P (B, p), over the first so many `rows` of the residuals: those of
    the samples come before those that hold the references.
    """
    return (residuals(in_part(law, 1.0), P)[:, :rows] ** 2).sum(axis=1)


def at_first(law: Law, starts: np.ndarray, horizon: float) -> np.ndarray:
    """(S,) chi2 where searches from `starts` (S, p) begin, on a share of the fitted part."""
    short = in_part(law, horizon)
    return (residuals(short, _gauged(short, starts)) ** 2).sum(axis=1)


def sharp(found: TimeFit) -> TimeFit:
    """The fit to its end and in fine steps; itself where no force is marched."""
    law = found.law
    if not any(e.marched for e in law.effects):
        return found
    law = replace(law, setting=replace(law.setting, steps=max(FINE, law.setting.steps)))
    return fit(law, found.parameters, evaluations=20)


def standing(law: Law, p: np.ndarray) -> tuple[float, list]:
    """chi2 at `p`, and what the law says there of the fitted takes, each (T, C), of others None."""
    _, r, predicted = _told(law, p)
    return float((r**2).sum()), predicted


def _told(law: Law, p: np.ndarray):
    """The linear part solved at `p`, the residuals (R,), and what is said of the fitted takes."""
    solved = solve(law, p[None])
    coefficients = solved.coefficients[0]
    predicted = [None] * len(law.takes)
    for take, index in enumerate(law.fitted):
        y = (solved.bases[take][0] @ coefficients[:, :, None])[..., 0].T
        predicted[index] = y + sum(e.given(index) for e in law.effects if e.given)
    return solved, left_over(law, p[None], solved)[0], predicted


def conclude(law: Law, p: np.ndarray, jac: np.ndarray) -> TimeFit:
    """The fit at `p`, predictions of all takes, and the covariance from the Jacobian."""
    solved, r, predicted = _told(law, p)
    for index, data in enumerate(law.takes):
        if data.take.held_out:
            predicted[index] = ahead(law, p, solved.coefficients[0], index)
    scale = np.linalg.norm(jac, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    inverse = np.linalg.pinv((jac / scale).T @ (jac / scale), rcond=1e-12)
    samples = int(sum(use.sum() for use in solved.uses))
    return TimeFit(
        law=law,
        parameters=p,
        covariance=inverse / np.outer(scale, scale),
        coefficients=solved.coefficients[0],
        predicted=tuple(predicted),
        chi2=float((r**2).sum()),
        samples=samples,
        unknowns=len(p) + _linear_unknowns(law, p, solved, r[:samples]) - law.own,
        residuals=r,
        jacobian=jac,
        motions=tuple(motion[0] for motion in solved.motions),
    )


def _linear_unknowns(law: Law, p: np.ndarray, solved: Solved, left: np.ndarray) -> float:
    """How many the linear part has; of the columns in which modes that were not heard answer a
    force, only as many as what they tell is worth, for where that is little there are none.

    left: residuals of the samples alone, for a shape of another size only asks for another start.
    """

    def count(one):
        return float((~one.barred).sum())

    price, best, least = np.log(max(len(left), 2)), solved, float(left @ left)
    misfit = least
    for effect in law.effects:
        if effect.force:
            less = without_columns(law, best, effect)
            more = float((left_over(law, p[None], less)[0, : len(left)] ** 2).sum())
            if more + price * count(less) < misfit + price * count(best):
                best, misfit = less, more
    return count(best) + (misfit - least) / price


def extend(
    found: TimeFit, effects: tuple[Effect, ...], thetas: list, at: int | None = None
) -> tuple[Law, np.ndarray]:
    """The same law with more effects, last or from place `at` on, and where to start from."""
    old = found.law.effects
    at = len(old) if at is None else at
    law = replace(found.law, effects=old[:at] + effects + old[at:])
    inner = [*found.theta[:at], *(np.asarray(t, float)[None] for t in thetas), *found.theta[at:]]
    outer = found.parameters[: sum(found.law.sizes()[:2])]
    return law, np.concatenate([outer, *(t[0] for t in inner)])


def trajectories(found: TimeFit, time: np.ndarray) -> tuple[np.ndarray, list]:
    """u (T, K) and the effects' columns [(effect, (T, q))] of the first fitted take at `time` (T,).

    The camera's own doings (jumps of its clock, later rows) are left out: a bake shows the body.
    """
    law = found.law
    index = law.fitted[0]
    bodily = replace(law, effects=tuple(replace(e, clock=None, delay=None) for e in law.effects))
    data = replace(
        law.takes[index],
        time=time,
        values=np.zeros((len(time), len(law.takes[index].sigma))),
        fit=np.ones(len(time), bool),
    )
    u, _, columns, _ = march(bodily, unpack(bodily, found.parameters[None], 0), data)
    return u[0], [(effect, values[0]) for effect, values in columns]
