"""What a fit says of a take that it has never seen, but for how that take began."""

from dataclasses import replace

import numpy as np

from .law import Law, unpack, widths, with_columns
from .linear_part import regressors

STEPS, STILL = 12, 1e-6  # at most, and the share of the start that a last one moves it by


def ahead(law: Law, p: np.ndarray, coefficients: np.ndarray, index: int) -> np.ndarray:
    """(T, C) of a whole held-out take: all is known but its start, fitted where `fit` says.

    Its offsets are those of the first fitted take of its condition; motions that belong to a
    release scale with the start, and those that an effect reads off the take are known.
    """
    condition = law.condition[index]
    same = [i for i in law.fitted if law.condition[i] == condition]
    if not same:
        return np.full(law.takes[index].values.shape, np.nan)
    model = law.fitted.index(same[0])
    one = replace(law, takes=(law.takes[index],), condition=(0,), pitch=(0,))
    known = replace(law.takes[index], take=replace(law.takes[index].take, held_out=False))
    one = replace(one, takes=(known,))
    a, b, _ = law.sizes()
    K, at = law.modes, 2 * law.modes * law.pitch[index]
    lead = np.r_[p[at : at + 2 * K], np.zeros(2 * K), p[a + b :]]
    each = 1 + sum(widths(law))
    head = law.own * law.conditions + each * model
    own = coefficients[:, law.own * condition : law.own * (condition + 1)]
    known = np.hstack([own, coefficients[:, head : head + each]])
    data = one.takes[0]
    seen = sum(e.given(index) for e in law.effects if e.given)  # it cannot be foretold
    data = replace(data, values=data.values - seen)
    use = data.fit[:, None] & data.known & ~data.support

    wide = dict(zip(law.effects, widths(law), strict=True))
    bound = np.array([e.of_release for e in with_columns(law) for _ in range(wide[e])], bool)
    scales = np.r_[np.zeros(law.own + 1, bool), bound]

    def guess(starts, strength):
        P = np.tile(lead, (len(starts), 1))
        P[:, 2 * K : 4 * K] = starts
        basis = regressors(one, unpack(one, P, 0), 0)[0]
        scaled = known.copy()
        scaled[:, scales] *= strength
        return np.swapaxes((basis @ scaled[None, :, :, None])[..., 0], 1, 2)

    first = p[a + 2 * K * model : a + 2 * K * (model + 1)]
    return _started(guess, data, use, (first, law)) + seen


def _started(guess, data, use, given) -> np.ndarray:
    """(T, C) with the start (2K,) that fits the used samples best, by Gauss-Newton."""
    first, law = given
    size = np.hypot(*first.reshape(2, -1)).max()

    def strength(start):  # of a release from the other side it is negative
        return np.copysign(np.hypot(*start.reshape(2, -1)).max() / size, start @ first)

    x, step = np.zeros(len(first)), 1e-4 * law.setting.amplitude
    for _ in range(STEPS):
        y = guess(np.vstack([x, x + step * np.eye(len(x))]), strength(x))
        r = np.where(use, (data.values - y) / data.sigma, 0.0).reshape(len(y), -1)
        slope = (r[1:] - r[0]).T / step
        move = np.linalg.lstsq(slope, r[0], rcond=1e-8)[0]
        x = x - move
        if np.linalg.norm(move) < STILL * np.linalg.norm(x):
            break
    return guess(x[None], strength(x))[0]
