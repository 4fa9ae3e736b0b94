"""A rolling shutter that is known: which instant every sample was really taken at.

Row r of H is exposed readout r/H after the first (Liang, Chang, Chen, IEEE Trans. Image Process.
17 (2008) 1323). A marker's own row is measured, and moves with it.
"""

import numpy as np

from .data import RingDown, poles


def rows_of(values: np.ndarray, rest: np.ndarray, height: float) -> np.ndarray:
    """(T, C) share of the picture's height at which each sample was seen, 0 top to 1 bottom.

    values (T, C): u, v of every marker in turn, px; rest (C,) px takes a missing sample's place.
    """
    v = np.where(np.isfinite(values), values, rest)[:, 1::2]
    return np.repeat(v, 2, axis=1) / max(height, 1)


def at_once(amplitude: np.ndarray, pole: np.ndarray, late: np.ndarray | None) -> np.ndarray:
    """(m, C) complex amplitudes as they would be without the shutter's mean delay late (T, C) s.

    pole (m,) 1/s. A sample taken d later shows a exp(p d).
    """
    return amplitude if late is None else amplitude * np.exp(-np.outer(pole, late.mean(axis=0)))


def rung(ring: RingDown, time: np.ndarray, late) -> np.ndarray:
    """(T, C) a ring-down as it shows at the instants `time` (T,) s, so `late` s, (T, C) or (C,)."""
    when = np.add.outer(time - ring.t0, np.zeros(len(ring.offset))) + late
    swings = zip(poles(ring.frequency, ring.damping_ratio), ring.amplitude, strict=True)
    return ring.offset + sum(((a * np.exp(p * when)).real for p, a in swings), 0 * when)


def height(camera) -> float:
    """px from a picture's first row to its last."""
    return camera.image_size[1] or 2 * camera.principal_point[1]


def overtone(amplitude: np.ndarray, pole: complex, readout: float) -> np.ndarray:
    """(C,) complex amplitudes, px, at twice the pitch of a swing with amplitudes (C,), u and v of
    every marker in turn, and `pole`, 1/s, that is read out with `readout`, s a row.

    A marker is seen later by what it has moved down the picture, in which time it moves on: to
    first order a(t) + a'(t) readout v(t).
    """
    return pole * readout * amplitude * np.repeat(amplitude[1::2], 2) / 2


def later(omega: np.ndarray, zeta: np.ndarray, motion: tuple, delay: np.ndarray) -> tuple:
    """Displacement and velocity (B, C, T, K) `delay` s after motion = (u, v), each (B, T, K).

    omega (B, K) rad/s, zeta (B, K); delay (B, C, T) or (B, C, 1), less than a period or so: exact
    where the mode swings freely meanwhile, u'' + 2 z w u' + w^2 u = 0.
    """
    (u, v), d = (x[:, None] for x in motion), delay[..., None]
    w, z = omega[:, None, None], zeta[:, None, None]
    free = w * np.sqrt(np.maximum(1 - z**2, 1e-6))
    shrink, cos, sin = np.exp(-z * w * d), np.cos(free * d), np.sin(free * d) / free
    return (
        shrink * (u * (cos + z * w * sin) + v * sin),
        shrink * (v * (cos - z * w * sin) - w**2 * u * sin),
    )
