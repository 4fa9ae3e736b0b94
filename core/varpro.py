"""Least squares for sums of damped sinusoids, with every linear unknown projected out.

y_c(t) = sum_k Re(a_kc exp(p_k t)) + sum_j b_jc exp(-r_j t) + X(t) x_c,  p_k = -s_k + i w_k.

Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; the Jacobian is Kaufman's (BIT 15, 1975), whose
square is exactly the Fisher information of the poles once amplitudes are known only from the data.
"""

from dataclasses import dataclass

import numpy as np

from .errors import RecordingError

ITERATIONS = 80


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
class _Block:
    """Channels that were measured at the same instants, so that they share one projection."""

    channels: np.ndarray
    rows: np.ndarray
    t: np.ndarray  # (T',)
    y: np.ndarray  # (T', C')
    x: np.ndarray  # (T', q)


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
    blocks = _blocks(t, y, x, len(start.vector) + len(start.omega))
    count = np.isfinite(y).sum(axis=0)
    scale = np.nanmax(y, axis=0) - np.nanmin(y, axis=0)
    floor = (1e-14 * scale + 1e-14 * (scale.max() if scale.max() > 0 else 1.0)) ** 2

    def evaluate(vector):
        return _evaluate(blocks, start.moved(vector), count, (noise, floor))

    vector = start.vector
    m = len(start.omega)
    low = np.zeros(len(vector))
    low[m : 2 * m] = 1e-2 / max(t[-1], 1e-300)
    vector = np.maximum(vector, low)
    state = evaluate(vector)
    if len(vector):
        vector, state = _levenberg_marquardt(evaluate, (vector, state), low, iterations)
    return _fit_of(state, start.moved(vector), y.shape, blocks)


def basis(t: np.ndarray, poles: Poles) -> np.ndarray:
    """(T, 2m + j): exp(-s t) cos(w t) of all modes, then exp(-s t) sin(w t), then exp(-r t)."""
    envelope = np.exp(-np.outer(t, poles.decay))
    phase = np.outer(t, poles.omega)
    return np.hstack(
        [envelope * np.cos(phase), envelope * np.sin(phase), np.exp(-np.outer(t, poles.creep))]
    )


def _blocks(t, y, x, unknowns: int) -> list[_Block]:
    seen = np.isfinite(y)
    alike: dict[bytes, list[int]] = {}
    for channel, pattern in enumerate(seen.T):
        alike.setdefault(pattern.tobytes(), []).append(channel)
    blocks = []
    for channels in map(np.array, alike.values()):
        rows = np.flatnonzero(seen[:, channels[0]])
        if len(rows) <= unknowns + x.shape[1]:
            raise RecordingError(
                f"Ring-down: channel {channels[0]} has {len(rows)} samples for "
                f"{unknowns + x.shape[1]} unknowns. Leave the channel out or record longer."
            )
        whole = len(rows) == len(t)
        part = (t, y[:, channels], x) if whole else (t[rows], y[np.ix_(rows, channels)], x[rows])
        blocks.append(_Block(channels, rows, *part))
    return blocks


def _project(block: _Block, poles: Poles):
    """Linear unknowns, residual, and the part of t * basis that they cannot imitate."""
    moving = basis(block.t, poles)
    phi = np.hstack([moving, block.x])
    scale = np.linalg.norm(phi, axis=0)
    scale[scale == 0] = 1.0
    q, triangle = np.linalg.qr(phi / scale)
    u, s, vt = np.linalg.svd(triangle)
    keep = s > 1e-13 * s[0]  # two poles in one place: the smallest of their equal solutions
    q = q @ u[:, keep]
    z = q.T @ block.y
    coefficients = (vt[keep].T / s[keep]) @ z / scale[:, None]
    tangent = block.t[:, None] * moving
    tangent -= q @ (q.T @ tangent)
    return coefficients, block.y - q @ z, tangent


def _tangent_weights(coefficients: np.ndarray, m: int, j: int) -> np.ndarray:
    """(2m + j, 2m + j, C): the derivative by each pole number, in terms of t * basis."""
    size = 2 * m + j
    weights = np.zeros((size, size, coefficients.shape[1]))
    k, r = np.arange(m), 2 * m + np.arange(j)
    a, b = coefficients[:m], coefficients[m : 2 * m]
    weights[k, k], weights[k, m + k] = -a, -b
    weights[m + k, k], weights[m + k, m + k] = b, -a
    weights[r, r] = -coefficients[2 * m : size]
    return weights


def _evaluate(blocks, poles: Poles, count, known) -> dict:
    noise, floor = known
    m, j = len(poles.omega), len(poles.creep)
    parts = [_project(block, poles) for block in blocks]
    squares = np.empty(len(count))
    for block, (_, residual, _) in zip(blocks, parts, strict=True):
        squares[block.channels] = np.einsum("tc,tc->c", residual, residual)
    if noise is None:
        variance = squares / count + floor
        cost = 0.5 * float(np.sum(count * np.log(variance)))
    else:
        variance = np.asarray(noise, float) ** 2
        cost = 0.5 * float(np.sum(squares / variance))
    gradient, information = np.zeros(2 * m + j), np.zeros((2 * m + j, 2 * m + j))
    for block, (coefficients, residual, tangent) in zip(blocks, parts, strict=True):
        weights = _tangent_weights(coefficients, m, j)
        per = 1 / variance[block.channels]
        gradient -= np.einsum("pkc,kc->p", weights, (tangent.T @ residual) * per)
        seen = np.tensordot(tangent.T @ tangent, weights * per, axes=(1, 1))  # (k, p, c)
        information += np.tensordot(weights, seen, axes=([1, 2], [0, 2]))
    return {
        "cost": cost,
        "gradient": gradient,
        "information": information,
        "variance": variance,
        "parts": parts,
    }


def _levenberg_marquardt(evaluate, start, low, iterations: int):
    """Marquardt's scaling; a bound that the gradient pushes against is held."""
    vector, state = start
    damping = 1e-3
    for _ in range(iterations):
        free = (vector > low) | (state["gradient"] < 0)
        if not free.any():
            break
        hessian = state["information"][np.ix_(free, free)]
        scale = np.sqrt(np.maximum(np.diag(hessian), 1e-300))
        scaled = hessian / np.outer(scale, scale)
        step = np.zeros(len(vector))
        rhs = -state["gradient"][free] / scale
        step[free] = np.linalg.solve(scaled + damping * np.eye(len(scale)), rhs) / scale
        trial = np.maximum(vector + step, low)
        tried = evaluate(trial)
        gain = state["cost"] - tried["cost"]
        if gain >= 0:
            small = np.max(np.abs(trial - vector)[free] * scale) < 1e-5
            vector, state = trial, tried
            damping = max(damping / 10, 1e-12)
            if small and gain < 1e-9:
                break
        else:
            damping *= 6
            if damping > 1e8:
                break
    return vector, state


def _fit_of(state: dict, poles: Poles, shape, blocks) -> Fit:
    m, j = len(poles.omega), len(poles.creep)
    columns = 2 * m + j + blocks[0].x.shape[1]
    coefficients, residual = np.zeros((columns, shape[1])), np.full(shape, np.nan)
    for block, (solved, left, _) in zip(blocks, state["parts"], strict=True):
        coefficients[:, block.channels] = solved
        residual[np.ix_(block.rows, block.channels)] = left
    return Fit(
        poles,
        coefficients[:m] - 1j * coefficients[m : 2 * m],
        coefficients[2 * m : 2 * m + j],
        coefficients[2 * m + j :],
        residual,
        np.sqrt(state["variance"]),
        state["information"],
        state["cost"],
    )
