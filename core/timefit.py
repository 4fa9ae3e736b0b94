"""Fit the modes of the tracks, with effects simulated in them, by variable projection.

Law         y_c(t) = offset_c + sum_k S_kc u_k(t - delay_c) + columns with shapes of their own
Unknown     pitch and damping per mode, start of every take, the effects' parameters (searched);
            shapes S, offsets and columns' shapes are linear and drop out of the search
Source      Golub and Pereyra, Inverse Problems 19 (2003) R1 (variable projection)
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .ahead import ahead
from .channels import Channels
from .effects.base import Effect
from .law import Law, TimeFit, bounds, unpack
from .shutter import later
from .simulate import swing

WILD = 1e7  # noise units; a motion that runs away is a bad fit, not an error
PIN = 1e3  # weight that keeps S at the reference at one, so that u is in metres there


def _motion(law: Law, unpacked, data: Channels):
    """u, u' (B, T, K), the columns (B, T, q), the delays (B, C, T) or None."""
    omega, zeta, start, thetas = unpacked
    time = np.broadcast_to(data.time, (len(omega), len(data.time)))
    pairs = list(zip(law.effects, thetas, strict=True))
    for effect, theta in pairs:
        if effect.clock:
            time = np.maximum(effect.clock(theta, law.setting, time), 0)
    forces = [(e, th) for e, th in pairs if e.acceleration or e.force]
    u, v, traces = swing(omega, zeta, start, time, forces, law.setting)
    # modes above those that were measured answer a force at once, in a shape of their own
    columns = [(e, traces[:, :, [j]]) for j, (e, _) in enumerate(p for p in forces if p[0].force)]
    delay = None if data.late is None else data.late.T[None]
    for effect, theta in pairs:
        if effect.columns:
            columns.append((effect, effect.columns(theta, law.setting, time, u)))
        if effect.delay:
            delay = effect.delay(theta, law.setting, data.rows.T) + (0 if delay is None else delay)
    return u, v, columns, delay


def _basis(law: Law, unpacked, take: int):
    """Basis (B, 1 or C, T, nb) of the fitted take number `take`, who may not use it (C, nb), and u
    (B, T, K).
    """
    data = law.takes[law.fitted[take]]
    u, v, columns, delay = _motion(law, unpacked, data)
    omega, zeta = unpacked[:2]
    motion = u
    u, v = (u[:, None], v[:, None]) if delay is None else later(omega, zeta, (u, v), delay)
    B, D, T, K = u.shape
    widths = [c.shape[2] for _, c in columns]
    each = 1 + sum(widths)
    head = law.own * law.conditions
    nb = head + each * len(law.fitted)
    basis = np.zeros((B, D, T, nb))
    at = law.own * law.condition[law.fitted[take]]
    basis[:, :, :, at : at + K] = u
    if law.turning:
        speed = v / omega[:, None, None]
        basis[:, :, :, at + K : at + law.own] = speed[..., list(law.turning)]
    at = head + each * take
    basis[:, :, :, at] = 1
    barred = np.zeros((len(data.sigma), nb), bool)
    barred[data.support, :head] = True
    at += 1
    for (effect, values), width in zip(columns, widths, strict=True):
        basis[:, :, :, at : at + width] = values[:, None]
        if effect.channels:
            barred[~effect.channels(law.setting, data), at : at + width] = True
        at += width
    return basis, barred, motion


def _given(law: Law, take: int):
    """Values (T, C) of the fitted take without what effects subtract as known motion."""
    values = law.takes[law.fitted[take]].values
    known = [e.given(law.fitted[take])[: len(values)] for e in law.effects if e.given]
    return values - sum(known)


class _Solved(NamedTuple):
    """The linear part for a batch of parameters; bases, uses and motions: one a fitted take."""

    coefficients: np.ndarray  # (B, C, nb)
    bases: tuple  # (B, 1 or C, T, nb)
    uses: list  # (T, C) bool
    motions: tuple  # (B, T, K)
    barred: np.ndarray  # (C, nb) bool


def _solve(law: Law, P: np.ndarray) -> _Solved:
    """The linear part for parameters P (B, p). Takes share coefficients within a condition."""
    bases, barred, motions = zip(
        *(_basis(law, unpack(law, P, take), take) for take in range(len(law.fitted))), strict=True
    )
    data = [law.takes[index] for index in law.fitted]
    uses = [one.known & one.fit[:, None] for one in data]
    barred = sum(barred) > 0
    coefficients = np.zeros((len(P), *barred.shape))
    for condition in range(law.conditions):
        group = [n for n, i in enumerate(law.fitted) if law.condition[i] == condition]
        columns = _columns(law, condition, group, barred.shape[1])
        gram = right = 0
        for n in group:
            values = np.where(uses[n], _given(law, n), 0.0)
            basis = bases[n] if law.conditions == 1 else np.take(bases[n], columns, axis=3)
            own = _normal(basis, values, uses[n])
            weight = data[n].sigma ** -2.0 if len(group) > 1 else np.ones(1)
            gram = gram + own[0] * weight[:, None, None]
            right = right + own[1] * weight[:, None]
        if group:
            coefficients[:, :, columns] = _coefficients(gram, right, barred[:, columns])
    return _Solved(coefficients, bases, uses, motions, barred)


def _columns(law: Law, condition: int, group: list[int], count: int) -> np.ndarray:
    """Indices of the basis' columns that a condition's takes share, or have for themselves."""
    head = law.own * law.conditions
    each = (count - head) // len(law.fitted)
    own = [np.arange(head + each * n, head + each * (n + 1)) for n in group]
    return np.concatenate([np.arange(law.own * condition, law.own * (condition + 1)), *own])


def _normal(basis: np.ndarray, values: np.ndarray, use: np.ndarray):
    """Normal equations (B, 1 or C, n, n), (B, C, n); one for all channels where none lacks any.

    basis (B, 1 or C, T, n), values and use (T, C).
    """
    whole, some = use.all(axis=1), use.any(axis=1)
    if basis.shape[1] > 1:
        whole = np.zeros_like(whole)
    rows = slice(None) if whole.all() else whole  # no copy of what is large
    b = basis[:, 0, rows]
    gram = (np.swapaxes(b, 1, 2) @ b)[:, None]
    right = np.swapaxes(np.swapaxes(b, 1, 2) @ values[rows], 1, 2)
    patchy = some & ~whole  # rows with a missing sample, or channels with their own delay
    if patchy.any():
        b = basis[:, :, patchy] * use[patchy].T[None, :, :, None]
        gram = gram + np.swapaxes(b, 2, 3) @ b
        right = right + np.einsum("bcti,tc->bci", b, values[patchy])
    return gram, right


def _coefficients(gram: np.ndarray, right: np.ndarray, barred: np.ndarray) -> np.ndarray:
    """(B, C, n) from the normal equations, nought where `barred` (C, n)."""
    scale = np.sqrt(np.einsum("bcii->bci", gram))
    scale = np.where(scale > 0, scale, 1.0)
    gram = gram / (scale[:, :, :, None] * scale[:, :, None])
    right = right / scale
    out = np.empty_like(right)
    kinds, of = np.unique(barred, axis=0, return_inverse=True)
    for k, kind in enumerate(kinds):
        alike = of.ravel() == k
        own = gram if gram.shape[1] == 1 else gram[:, alike]
        own = own + np.diag(np.where(kind, 1e12, 1e-11))
        y = right[:, alike]
        if own.shape[1] == 1:
            out[:, alike] = np.swapaxes(np.linalg.solve(own[:, 0], np.swapaxes(y, 1, 2)), 1, 2)
        else:
            out[:, alike] = np.linalg.solve(own, y[..., None])[..., 0]
    return out / scale


def _residuals(law: Law, P: np.ndarray) -> np.ndarray:
    """(B, R) noise units, with the rows that keep the reference at one."""
    return _left(law, _solve(law, P))


def _left(law: Law, solved: _Solved) -> np.ndarray:
    coefficients, bases, uses = solved[:3]
    out = []
    for take, index in enumerate(law.fitted):
        data = law.takes[index]
        if bases[take].shape[1] == 1:
            predicted = bases[take][:, 0] @ np.swapaxes(coefficients, 1, 2)
        else:
            predicted = np.einsum("bcti,bci->btc", bases[take], coefficients)
        left = (_given(law, take) - predicted) / data.sigma
        every = uses[take].all()
        out.append(left.reshape(len(left), -1) if every else left[:, uses[take]])
    K = law.modes
    for c in range(law.conditions):
        own = coefficients[:, :, c * law.own : (c + 1) * law.own]
        hold = np.r_[PIN, np.full(K - 1, law.trust)]
        out.append(hold * (1 - np.einsum("kc,bck->bk", law.gauge(c), own[:, :, :K])))
        if law.turning:
            across = law.gauge(c)[list(law.turning)]
            out.append(PIN * np.einsum("kc,bck->bk", across, own[:, :, K:]))
    r = np.concatenate(out, axis=1)
    if not (r.min() > -WILD and r.max() < WILD):  # NaN too
        r = np.nan_to_num(np.clip(r, -WILD, WILD), nan=WILD)
    return r


def _cut(law: Law, horizon: float) -> Law:
    """The law with fitted takes no longer than that share of the fitted part: all else is marched
    in vain.
    """
    takes = list(law.takes)
    for index in law.fitted:
        data = takes[index]
        n = int((data.time <= horizon * data.time[data.fit][-1] + 1e-12).sum())
        takes[index] = replace(
            data,
            time=data.time[:n],
            values=data.values[:n],
            fit=data.fit[:n],
            rows=data.rows[:n],
        )
    return replace(law, takes=tuple(takes))


def _bounds(law: Law):
    K, A = law.modes, law.setting.amplitude
    a, b, _ = law.sizes()
    centre = np.log(law.setting.omega / (2 * np.pi))
    low = np.concatenate([np.tile(np.r_[centre - 0.7, np.zeros(K)], a // (2 * K))])
    high = np.concatenate([np.tile(np.r_[centre + 0.7, np.full(K, 0.9)], a // (2 * K))])
    inner = [bounds(e, K) for e in law.effects]
    effect_low = np.concatenate([i[0] for i in inner]) if inner else np.zeros(0)
    effect_high = np.concatenate([i[1] for i in inner]) if inner else np.zeros(0)
    wide = np.full(b, 50 * A)
    return np.r_[low, -wide, effect_low], np.r_[high, wide, effect_high]


def _steps(law: Law) -> np.ndarray:
    a, b, c = law.sizes()
    return np.r_[np.full(a, 1e-6), np.full(b, 1e-5 * law.setting.amplitude), np.full(c, 1e-5)]


def fit(law: Law, start: np.ndarray, horizons=(1.0,), evaluations: int = 10) -> TimeFit:
    """Least squares from `start` (p,), over growing shares of the fitted part."""
    return best_fit(law, start[None], horizons, evaluations)


def best_fit(law: Law, starts: np.ndarray, horizons=(1.0,), evaluations: int = 10) -> TimeFit:
    """The best that `fit` finds from any of `starts` (S, p), all searched at once."""
    low, high = _bounds(law)
    for horizon in horizons:
        short = _cut(law, horizon)
        starts = [np.clip(_gauged(short, p), low + 1e-12, high - 1e-12) for p in starts]
        walks = _descend(short, starts, (low, high), evaluations)
        starts = [p for p, _, _ in walks]
    p, jacobian, _ = min(walks, key=lambda walk: walk[2])
    return conclude(law, p, jacobian)


def _gauged(law: Law, p: np.ndarray) -> np.ndarray:
    """p with every start scaled so that its shape is one at the reference again.

    A new effect turns shapes; the scale follows at once here, and only slowly in the search.
    """
    coefficients = _solve(law, p[None]).coefficients[0]
    a, _, _ = law.sizes()
    p = p.copy()
    for take, index in enumerate(law.fitted):
        at = law.own * law.condition[index]
        own = coefficients[:, at : at + law.modes]
        scale = np.einsum("kc,ck->k", law.gauge(law.condition[index]), own)
        scale = np.where((np.abs(scale) > 0.01) & (np.abs(scale) < 100), scale, 1.0)
        p[a + 2 * law.modes * take :][: 2 * law.modes] *= np.tile(scale, 2)
    return p


def _look(law: Law, places: list[np.ndarray], high: np.ndarray) -> list:
    """Residuals and Jacobian at every place, in one batch: many march for little more than one."""
    steps = _steps(law)
    moves = [np.where(x + steps < high, steps, -steps) for x in places]
    batch = [x + np.vstack([0 * x, np.diag(m)]) for x, m in zip(places, moves, strict=True)]
    r = _residuals(law, np.vstack(batch)).reshape(len(places), len(steps) + 1, -1)
    return [(one[0], ((one[1:] - one[:1]) / m[:, None]).T) for one, m in zip(r, moves, strict=True)]


def _descend(law: Law, starts, bounds, evaluations: int) -> list:
    """(p, Jacobian, cost) where the search from every start ends; they go in step."""
    searches = [_search(p, bounds, evaluations) for p in starts]
    asked = {i: next(search) for i, search in enumerate(searches)}
    ended = [None] * len(starts)
    while asked:
        seen = _look(law, list(asked.values()), bounds[1])
        for i, look in zip(list(asked), seen, strict=True):
            try:
                asked[i] = searches[i].send(look)
            except StopIteration as end:
                ended[i] = end.value
                del asked[i]
    return ended


def _search(p, bounds, evaluations: int):
    """Levenberg-Marquardt within bounds (More, Lect. Notes Math. 630 (1978) 105): asks for the
    residuals and Jacobian at places, returns p, Jacobian, cost.

    The normal equations are of the few searched parameters only, so they are cheap, and scaled to
    unit diagonal they are well enough conditioned.
    """
    low, high = bounds
    r, jacobian = yield p
    cost, damping = r @ r, 1e-3
    for _ in range(evaluations):
        scale = np.linalg.norm(jacobian, axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        J = jacobian / scale
        slope = J.T @ r
        stuck = ((p <= low + 1e-12) & (slope > 0)) | ((p >= high - 1e-12) & (slope < 0))
        H = J.T @ J + damping * np.eye(len(p))
        H[stuck], H[:, stuck] = 0.0, 0.0
        H[stuck, stuck] = 1.0
        move = -np.linalg.solve(H, np.where(stuck, 0.0, slope)) / scale
        trial = np.clip(p + move, low + 1e-12, high - 1e-12)
        after, tangent = yield trial
        if after @ after < cost:
            gain, p, r, jacobian = cost - after @ after, trial, after, tangent
            cost, damping = r @ r, damping / 8
            if gain < 1e-5 * cost + 0.05:
                break
        else:
            damping *= 6
            if damping > 1e6:
                break
    return p, jacobian, cost


def screen(found: TimeFit, effect: Effect, thetas: list) -> np.ndarray:
    """Gain in chi2 that each start promises: a score test off the fitted law's tangents (n,).

    The residual's change by the effect at `theta`, without what the fitted parameters can take
    up, scaled as it likes (Rao, Linear Statistical Inference, 1973, 6e).
    """
    law, _ = extend(found, (effect,), [thetas[0]])
    P = np.vstack([np.r_[found.parameters, np.asarray(theta, float)] for theta in thetas])
    low, high = _bounds(law)
    change = _residuals(_cut(law, 1.0), np.clip(P, low, high)) - found.residuals
    scale = np.linalg.norm(found.jacobian, axis=0)
    q, _ = np.linalg.qr(found.jacobian / np.where(scale > 0, scale, 1.0))
    change = change - (change @ q) @ q.T
    power = (change**2).sum(axis=1)
    return (change @ found.residuals) ** 2 / np.where(power > 0, power, np.inf)


def conclude(law: Law, p: np.ndarray, jac: np.ndarray) -> TimeFit:
    """The fit at `p`, predictions of all takes, and the covariance from the Jacobian."""
    solved = _solve(law, p[None])
    coefficients = solved.coefficients[0]
    r = _left(law, solved)[0]
    predicted = [None] * len(law.takes)
    for take, index in enumerate(law.fitted):
        y = (solved.bases[take][0] @ coefficients[:, :, None])[..., 0].T
        predicted[index] = y + sum(e.given(index) for e in law.effects if e.given)
    scale = np.linalg.norm(jac, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    inverse = np.linalg.pinv((jac / scale).T @ (jac / scale), rcond=1e-12)
    for index, data in enumerate(law.takes):
        if data.take.held_out:
            predicted[index] = ahead(law, p, coefficients, index, _basis)
    return TimeFit(
        law=law,
        parameters=p,
        covariance=inverse / np.outer(scale, scale),
        coefficients=coefficients,
        predicted=tuple(predicted),
        chi2=float((r**2).sum()),
        samples=int(sum(use.sum() for use in solved.uses)),
        unknowns=len(p) + int((~solved.barred).sum()) - law.own,
        residuals=r,
        jacobian=jac,
        motions=tuple(motion[0] for motion in solved.motions),
    )


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


def without(found: TimeFit, i: int) -> TimeFit:
    """Fitted again without effect number `i`, from where the fit with it stands."""
    law, theta = found.law, found.theta
    kept = [k for k in range(len(theta)) if k != i]
    outer = found.parameters[: sum(law.sizes()[:2])]
    law = replace(law, effects=tuple(law.effects[k] for k in kept))
    return fit(law, np.concatenate([outer, *(theta[k][0] for k in kept)]), evaluations=20)


def instead(found: TimeFit, effect: Effect) -> float:
    """chi2 with another one in the last effect's place, and all parameters as they are."""
    law = replace(found.law, effects=(*found.law.effects[:-1], effect))
    return float((_residuals(law, found.parameters[None]) ** 2).sum())


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
    u, _, columns, _ = _motion(bodily, unpack(bodily, found.parameters[None], 0), data)
    return u[0], [(effect, values[0]) for effect, values in columns]
