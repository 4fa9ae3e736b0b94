"""The body in its own modes and static responses, and its motion in fine steps.

    M q'' + C q' + K q = f(q, q', t),   u = V q

The linear part is advanced by the exact matrix exponential, the forces by Lawson's fourth-order
Runge-Kutta scheme (SIAM J. Numer. Anal. 4, 1967). At least 200 steps a period, more
where a force at a node is stiff (`film.quickest`).
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from . import bodies

SAME = 1e-9  # of a static response's energy, squared sine: below it is another one's


@dataclass(frozen=True, eq=False)
class System:
    """Reduced matrices. `extra` rows of the state are linear internal variables."""

    basis: np.ndarray  # (3N, r) m per unit q
    M: np.ndarray  # (r, r)
    C: np.ndarray  # (r, r)
    K: np.ndarray  # (r, r)
    frequency: np.ndarray  # (r,) Hz of the basis, natural
    damping_ratio: np.ndarray  # (r,) as drawn for the modes
    branch: tuple[float, float] | None = None  # stiffness ratio and time (s) of a relaxing branch

    @property
    def size(self) -> int:
        return len(self.M)

    def at(self, node: int) -> np.ndarray:
        """(3, r) motion of a node."""
        return self.basis[3 * node : 3 * node + 3]

    def matrix(self) -> np.ndarray:
        """A of z' = A z + (0, M^-1 f, 0), z = (q, q') or, with a branch, (q, q', s)."""
        r = self.size
        inverse = np.linalg.inv(self.M)
        zero, one = np.zeros((r, r)), np.eye(r)
        if self.branch is None:
            return np.block([[zero, one], [-inverse @ self.K, -inverse @ self.C]])
        ratio, time = self.branch
        stiff = inverse @ self.K
        return np.block(
            [
                [zero, one, zero],
                [-(1 + ratio) * stiff, -inverse @ self.C, ratio * stiff],
                [one / time, zero, -one / time],
            ]
        )


def reduce(body, count: int, forces=None, ground=None) -> System:
    """`count` modes and the static responses to the nodal forces (3N, k), undamped."""
    _, V = bodies.modes(body, count, ground)
    K = body.stiffness if ground is None else body.stiffness + ground
    if forces is not None and forces.size:
        u = bodies.respond(body, forces, ground)
        u = u - V @ (V.T @ (body.mass @ u))
        keep = np.sqrt(np.einsum("ij,ij->j", u, body.mass @ u))
        u = (u / np.where(keep > 0, keep, 1))[:, keep > 0]
        size, turn = linalg.eigh(u.T @ (body.mass @ u))  # two forces may ask for the same response
        own = size > SAME
        V = np.hstack([V, u @ turn[:, own] / np.sqrt(size[own])])
    value, vector = linalg.eigh(V.T @ (K @ V), V.T @ (body.mass @ V))
    V = V @ vector
    one = np.eye(len(value))
    frequency = np.sqrt(np.clip(value, 0, None)) / (2 * np.pi)
    return System(V, one, 0 * one, np.diag(value), frequency, np.zeros(len(value)))


def damped(system: System, ratio: np.ndarray) -> System:
    """Viscous modal damping: C = diag(2 z w) in the modes of the system as it stands."""
    value, vector = linalg.eigh(system.K, system.M)
    omega = np.sqrt(np.clip(value, 0, None))
    side = system.M @ vector
    C = side @ np.diag(2 * ratio * omega) @ side.T
    return System(system.basis, system.M, C, system.K, omega / (2 * np.pi), ratio, system.branch)


@dataclass(frozen=True, eq=False)
class Track:
    """Fine samples of a run."""

    time: np.ndarray  # (S,) s
    q: np.ndarray  # (S, r)
    v: np.ndarray  # (S, r)


def run(system: System, state: np.ndarray, step: float, count: int, forces=()) -> Track:
    """`count` steps of `step` s from `state` (q, q'[, s]) at t = 0 under `forces`.

    A force has `force(q, v, t) -> (r,)` and, where it has a memory, `commit(q, v, t)`.
    """
    A = system.matrix()
    r = system.size
    whole, half = linalg.expm(A * step), linalg.expm(A * step / 2)
    out = np.empty((count + 1, len(state)))
    out[0] = z = state.astype(float)
    if not forces:
        for n in range(count):
            out[n + 1] = z = whole @ z
        return Track(step * np.arange(count + 1), out[:, :r], out[:, r : 2 * r])
    push = np.zeros((len(state), r))
    push[r : 2 * r] = np.linalg.inv(system.M)
    memory = [one for one in forces if hasattr(one, "commit")]

    def slope(z, t):
        f = forces[0].force(z[:r], z[r : 2 * r], t)
        for one in forces[1:]:
            f = f + one.force(z[:r], z[r : 2 * r], t)
        return push @ f

    for n in range(count):
        t = n * step
        k1 = slope(z, t)
        y = half @ z
        h1 = half @ k1
        k2 = slope(y + step / 2 * h1, t + step / 2)
        k3 = slope(y + step / 2 * k2, t + step / 2)
        y = half @ y
        k4 = slope(y + step * (half @ k3), t + step)
        z = y + step / 6 * (half @ (h1 + 2 * (k2 + k3)) + k4)
        out[n + 1] = z
        for one in memory:
            one.commit(z[:r], z[r : 2 * r], t + step)
    return Track(step * np.arange(count + 1), out[:, :r], out[:, r : 2 * r])
