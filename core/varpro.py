"""Least squares for sums of damped sinusoids, with every linear unknown projected out.

y_c(t) = sum_k Re(a_kc exp(p_k t)) + sum_j b_jc exp(-r_j t) + X(t) x_c,  p_k = -s_k + i w_k.

Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; the Jacobian is Kaufman's (BIT 15, 1975), whose
square is exactly the Fisher information of the poles once amplitudes are known only from the data.
"""

from dataclasses import dataclass

import numpy as np

from .errors import RecordingError

ITERATIONS = 80
GONE = 1e-100  # norm of a column that is nought: what swings by it would be beyond all numbers
ROUNDED = 1e-30  # of the largest second derivative: what is less is nought, rounded
STEP, GAIN = 1e-3, 1e-6  # standard deviations, log likelihood: a last step that is no more
APART = 1e-4  # sine between a column and those before it, below which squares cost digits


@dataclass(frozen=True, eq=False)
class Poles:
    """What is not linear: s (m,) and w (m,) of oscillating poles, r (j,) of real ones; 1/s."""

    decay: np.ndarray  # (m,) s >= 0
    omega: np.ndarray  # (m,) w > 0
    creep: np.ndarray  # (j,) r >= 0

    @property
    def vector(self) -> np.ndarray:
        """(2m + j,)"""
        return np.concatenate([self.decay, self.omega, self.creep])

    def moved(self, vector: np.ndarray) -> "Poles":
        """The same numbers of poles at the places in `vector` (2m + j,)."""
        m = len(self.omega)
        return Poles(vector[:m], vector[m : 2 * m], vector[2 * m :])


@dataclass(frozen=True, eq=False)
class Fit:
    """Poles with everything that follows from them linearly."""

    poles: Poles
    amplitude: np.ndarray  # (m, C) complex a at t = 0
    creep: np.ndarray  # (j, C) b
    linear: np.ndarray  # (q, C) x, one row for each column of X
    residual: np.ndarray  # (T, C), NaN where nothing was measured
    noise: np.ndarray  # (C,) that the channels were weighted by
    information: np.ndarray  # (2m + j, 2m + j) Fisher information of the poles at that noise
    cost: float  # minus the log likelihood, up to a constant

    @property
    def columns(self) -> int:
        """Linear unknowns of one channel."""
        return 2 * len(self.amplitude) + len(self.creep) + len(self.linear)


@dataclass(frozen=True, eq=False)
class _Samples:
    """What is fitted. Channels that were measured at the same instants share one projection: they
    are a block; a shorter block repeats its first channel, and any instant, unused.
    """

    t: np.ndarray  # (T,)
    y: np.ndarray  # (T, C), nought where nothing was measured
    x: np.ndarray  # (T, q)
    seen: np.ndarray | None  # (T, C) bool; None where nothing is missing
    channels: np.ndarray  # (b, w)
    own: np.ndarray  # (b, w) bool
    missing: np.ndarray  # (b, r) instants
    gone: np.ndarray  # (b, r) bool
    ways: tuple  # of each pole number (p,), the two columns of t * basis that it moves along


def fit(
    t: np.ndarray,
    y: np.ndarray,
    x: np.ndarray,
    start: Poles,
    *,
    noise=None,
    iterations: int = ITERATIONS,
) -> Fit:
    """Most likely poles from `start`; t (T,) s >= 0, y (T, C) with NaN where missing, x (T, q).

    With `noise` (C,) the channels are weighted by it; without, each channel's noise is estimated
    along with the rest (concentrated likelihood). `iterations=0` solves the linear part only.
    Raises RecordingError when a channel has fewer samples than unknowns.
    """
    samples = _samples(t, y, x, start)
    count = np.isfinite(y).sum(axis=0)
    scale = np.nanmax(y, axis=0) - np.nanmin(y, axis=0)
    floor = (1e-14 * scale + 1e-14 * (scale.max() if scale.max() > 0 else 1.0)) ** 2

    def evaluate(vector):
        return _evaluate(samples, start.moved(vector), count, (noise, floor))

    vector = start.vector
    m = len(start.omega)
    low, high = np.zeros(len(vector)), np.full(len(vector), np.inf)
    low[m : 2 * m] = 1e-2 / max(t[-1], 1e-300)
    fold = np.pi / np.diff(t).min(initial=np.inf)  # beyond it a pitch may have a double
    high[m : 2 * m][start.omega < fold] = fold
    vector = np.maximum(vector, low)
    state = evaluate(vector)
    if len(vector):
        vector, state = _levenberg_marquardt(evaluate, (vector, state), (low, high), iterations)
    return _fit_of(state, start.moved(vector), samples)


def basis(t: np.ndarray, poles: Poles) -> np.ndarray:
    """(T, 2m + j): exp(-s t) cos(w t) of all modes, then exp(-s t) sin(w t), then exp(-r t)."""
    m, t = len(poles.omega), t[:, None]
    out = np.empty((len(t), 2 * m + len(poles.creep)))
    envelope, phase = np.exp(-poles.decay * t), poles.omega * t
    np.multiply(envelope, np.cos(phase), out=out[:, :m])
    np.multiply(envelope, np.sin(phase), out=out[:, m : 2 * m])
    np.exp(-poles.creep * t, out=out[:, 2 * m :])
    return out


def _samples(t, y, x, start: Poles) -> _Samples:
    seen, unknowns = np.isfinite(y), len(start.vector) + len(start.omega)
    alike: dict[bytes, list[int]] = {}
    for channel, pattern in enumerate(seen.T):
        alike.setdefault(pattern.tobytes(), []).append(channel)
    for channel, *_ in alike.values():
        count = int(seen[:, channel].sum())
        if count <= unknowns + x.shape[1]:
            raise RecordingError(
                f"Ring-down: channel {channel} has {count} samples for "
                f"{unknowns + x.shape[1]} unknowns. Leave the channel out or record longer."
            )
    channels, own = _filled(list(alike.values()))
    missing, gone = _filled([np.flatnonzero(~seen[:, block[0]]) for block in alike.values()])
    whole = bool(seen.all())
    y = y if whole else np.where(seen, y, 0.0)
    seen, ways = None if whole else seen, _ways(len(start.omega), len(start.creep))
    return _Samples(t, y, x, seen, channels, own, missing, gone, ways)


def _filled(lists: list) -> tuple[np.ndarray, np.ndarray]:
    """(b, longest) the lists, the shorter ones filled up with their first item, and bool which."""
    width = max(map(len, lists))
    out, own = np.zeros((len(lists), width), int), np.zeros((len(lists), width), bool)
    for row, mine, items in zip(out, own, lists, strict=True):
        row[:] = items[0] if len(items) else 0
        row[: len(items)] = items
        mine[: len(items)] = True
    return out, own


def _project(samples: _Samples, poles: Poles):
    """Linear unknowns (n, C), residual (T, C), t * basis (T, k), and of each block the normal
    matrix of the part of that which the linear unknowns cannot imitate (b, k, k).
    """
    moving = basis(samples.t, poles)
    k, q = moving.shape[1], samples.x.shape[1]
    n, channels = k + q, samples.channels
    columns = np.empty((len(moving), n + k))
    columns[:, :k], columns[:, k:n] = moving, samples.x
    phi, tangent = columns[:, :n], columns[:, n:]
    scale = np.sqrt(np.einsum("tn,tn->n", phi, phi))
    scale[scale < GONE] = 1.0
    phi /= scale
    np.multiply(samples.t[:, None], moving, out=tangent)
    normal = (columns.T @ columns)[None]
    if samples.missing.size:
        lost = columns[samples.missing] * samples.gone[:, :, None]
        normal = normal - np.swapaxes(lost, 1, 2) @ lost
    known, cross, alone = normal[:, :n, :n], normal[:, :n, n:], normal[:, n:, n:]
    right = np.moveaxis((phi.T @ samples.y)[:, channels], 1, 0)
    answer = np.empty((len(channels), n, right.shape[2] + cross.shape[2]))
    plain = _are_plain(known)
    both = np.concatenate([right, cross], axis=2)
    answer[plain] = np.linalg.solve(known[plain], both[plain])
    apart = alone - np.swapaxes(cross, 1, 2) @ answer[:, :, right.shape[2] :]
    solved = np.empty((n, samples.y.shape[1]))
    solved[:, channels] = np.moveaxis(answer[:, :, : right.shape[2]], 0, 1)
    for b in np.flatnonzero(~plain):
        rows = np.ones(len(phi), bool)
        rows[samples.missing[b][samples.gone[b]]] = False
        some = phi[rows], samples.y[rows][:, channels[b]], tangent[rows]
        solved[:, channels[b]], apart[b] = _least(*some)
    residual = samples.y - phi @ solved
    if samples.seen is not None:
        residual *= samples.seen
    return solved / scale[:, None], residual, tangent, apart


def _are_plain(grams: np.ndarray) -> np.ndarray:
    """(b,) bool: whether normal equations (b, n, n) of columns as long as one or a little less lose
    no digit that matters.
    """
    try:
        return np.linalg.cholesky(grams).diagonal(axis1=1, axis2=2).min(axis=1) > APART
    except np.linalg.LinAlgError:
        if len(grams) == 1:
            return np.zeros(1, bool)
        return np.concatenate([_are_plain(gram[None]) for gram in grams])


def _least(phi: np.ndarray, y: np.ndarray, tangent: np.ndarray):
    """The least linear unknowns that do equally well, two poles being in one place, and the normal
    matrix of the tangents' part that these cannot imitate.
    """
    q, triangle = np.linalg.qr(phi)
    u, s, vt = np.linalg.svd(triangle)
    keep = s > 1e-13 * s[0]
    q = q @ u[:, keep]
    left = tangent - q @ (q.T @ tangent)
    return (vt[keep].T / s[keep]) @ (q.T @ y), left.T @ left


def _ways(m: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    k, r = np.arange(m), 2 * m + np.arange(j)
    return np.concatenate([k, k, r]), np.concatenate([m + k, m + k, r])


def _slopes(solved: np.ndarray, m: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    """The derivative by each pole number: u (p, C) times the first column that it moves along, and
    v (p, C) times the second.
    """
    u, v = np.zeros((2, 2 * m + j, solved.shape[1]))
    np.negative(solved[:m], out=u[:m])
    u[m : 2 * m] = solved[m : 2 * m]
    np.negative(solved[2 * m : 2 * m + j], out=u[2 * m :])
    np.negative(solved[m : 2 * m], out=v[:m])
    np.negative(solved[:m], out=v[m : 2 * m])
    return u, v


def _evaluate(samples: _Samples, poles: Poles, count, known) -> dict:
    noise, floor = known
    m, j = len(poles.omega), len(poles.creep)
    solved, residual, tangent, apart = _project(samples, poles)
    squares = np.einsum("tc,tc->c", residual, residual)
    if noise is None:
        variance = squares / count + floor
        cost = 0.5 * float(np.sum(count * np.log(variance)))
    else:
        variance = np.asarray(noise, float) ** 2
        cost = 0.5 * float(np.sum(squares / variance))
    u, v = _slopes(solved, m, j)
    first, second = samples.ways
    slope = (tangent.T @ residual) / variance
    gradient = -np.einsum("pc,pc->p", u, slope[first]) - np.einsum("pc,pc->p", v, slope[second])
    weight = (samples.own / variance[samples.channels])[:, None]
    us, vs = (np.moveaxis(w[:, samples.channels], 1, 0) for w in (u, v))
    uw, vw, ut, vt = us * weight, vs * weight, np.swapaxes(us, 1, 2), np.swapaxes(vs, 1, 2)
    crossed = (apart[:, first[:, None], second] * (uw @ vt)).sum(axis=0)
    information = (apart[:, first[:, None], first] * (uw @ ut)).sum(axis=0) + crossed + crossed.T
    information += (apart[:, second[:, None], second] * (vw @ vt)).sum(axis=0)
    return {
        "cost": cost,
        "gradient": gradient,
        "information": information,
        "variance": variance,
        "solved": solved,
        "residual": residual,
    }


def _levenberg_marquardt(evaluate, start, bounds, iterations: int):
    """Marquardt's scaling; a low bound that the gradient pushes against is held, and a step to a
    high one is too long.
    """
    (vector, state), (low, high) = start, bounds
    damping = 1e-3
    for _ in range(iterations):
        free = (vector > low) | (state["gradient"] < 0)
        if not free.any():
            break
        hessian = state["information"][np.ix_(free, free)]
        own = hessian.diagonal()
        scale = np.sqrt(np.maximum(own, max(ROUNDED * own.max(), 1e-300)))
        scaled = hessian / (scale[:, None] * scale)
        scaled.flat[:: len(scale) + 1] += damping
        step = np.zeros(len(vector))
        rhs = -state["gradient"][free] / scale
        step[free] = np.linalg.solve(scaled, rhs) / scale
        trial = np.maximum(vector + step, low)
        tried = evaluate(trial) if (trial < high).all() else state | {"cost": np.inf}
        gain = state["cost"] - tried["cost"]
        if gain >= 0:
            small = np.max(np.abs(trial - vector)[free] * scale) < STEP
            vector, state = trial, tried
            damping = max(damping / 10, 1e-12)
            if small and gain < GAIN:
                break
        else:
            damping *= 6
            if damping > 1e8:
                break
    return vector, state


def _fit_of(state: dict, poles: Poles, samples: _Samples) -> Fit:
    m, j = len(poles.omega), len(poles.creep)
    solved, residual = state["solved"], state["residual"]
    if samples.seen is not None:
        residual = np.where(samples.seen, residual, np.nan)
    return Fit(
        poles,
        solved[:m] - 1j * solved[m : 2 * m],
        solved[2 * m : 2 * m + j],
        solved[2 * m + j :],
        residual,
        np.sqrt(state["variance"]),
        state["information"],
        state["cost"],
    )
