"""Which computed mode is which measured one: by frequency and by shape at the markers (MAC)."""

from dataclasses import dataclass

import numpy as np

from .baseline import real_shapes
from .data import RingDown

PAIR = 0.015  # relative distance below which two computed modes count as a degenerate pair
HARMONIC = 0.04  # relative distance below which a pole is an overtone of a nonlinear mode


@dataclass(frozen=True)
class Match:
    """Measured poles that are modes of the body, and the computed mode of each."""

    poles: tuple[int, ...]  # into the ring-down, strongest first
    modes: tuple[int | None, ...]  # into the computed modes; None = no computed mode fits


def mac(a: np.ndarray, b: np.ndarray) -> float:
    """Modal assurance criterion |a.b|^2 / (a.a b.b), 0 to 1 (Allemang, Sound Vib. 37, 2003)."""
    power = (a @ a) * (b @ b)
    return float((a @ b) ** 2 / power) if power > 0 else 0.0


def likeness(shape: np.ndarray, modes: np.ndarray, frequency: np.ndarray, j: int) -> float:
    """MAC of `shape` (C,) with mode j of `modes` (m, C), or with the pair that j belongs to."""
    pair = modes[np.abs(frequency / frequency[j] - 1) < PAIR]
    q, _ = np.linalg.qr(pair.T)
    return float(((q.T @ shape) ** 2).sum() / (shape @ shape))


def match_modes(ring: RingDown, frequency: np.ndarray, shapes: np.ndarray) -> Match:
    """Match `ring` to computed modes at any one modulus: frequency (m,), shapes (m, C).

    The modulus is unknown, so every computed mode is tried as the strongest measured one; the
    assignment with the best likeness in shape and in ratio of frequencies, weighted by strength,
    wins. Overtones and same-shape companions of a stronger pole are no modes of the body.
    """
    measured, _ = real_shapes(ring.amplitude)
    strength = np.linalg.norm(measured, axis=1)
    best, answer = -np.inf, Match((0,), (None,))
    for first in range(min(len(frequency), 8)):
        alike = likeness(measured[0], shapes, frequency, first)
        if alike < 0.5:
            continue
        scale = ring.frequency[0] / frequency[first]
        poles, modes, score = [0], [first], strength[0] * (alike - 0.03 * first)
        for k in range(1, len(strength)):
            j, quality = _partner(k, ring, measured, poles, modes, frequency * scale, shapes)
            if j is not None:
                poles.append(k)
                modes.append(j)
                score += strength[k] * quality
        if score > best:
            best, answer = score, Match(tuple(poles), tuple(modes))
    return answer


def _partner(k, ring, measured, poles, modes, frequency, shapes):
    """The free computed mode of pole k and how good it is, or None."""
    f, shape = ring.frequency[k], measured[k]
    strongest = np.linalg.norm(measured[0])
    if np.linalg.norm(shape) < 2e-3 * strongest or ring.damping_ratio[k] > 0.5:
        return None, 0.0
    for p in poles:
        same = mac(shape, measured[p])
        ratio = f / ring.frequency[p]
        overtone = any(abs(ratio / n - 1) < HARMONIC for n in (2, 3, 4, 5))
        if same > 0.9 and (overtone or abs(ratio - 1) < 0.4):
            return None, 0.0
    best, found = 0.35, None
    for j in range(len(frequency)):
        near = [m for m in modes if abs(frequency[m] / frequency[j] - 1) < PAIR]
        if j in modes or near:
            continue
        quality = likeness(shape, shapes, frequency, j) - abs(np.log(f / frequency[j]))
        if quality > best:
            best, found = quality, j
    return found, best


def select(ring: RingDown, poles: tuple[int, ...]) -> RingDown:
    """The ring-down with these poles only."""
    k = list(poles)
    both = k + [len(ring.frequency) + i for i in k]
    return RingDown(
        ring.frequency[k],
        ring.damping_ratio[k],
        ring.amplitude[k],
        ring.offset,
        ring.noise,
        ring.covariance[np.ix_(both, both)],
        ring.t0,
        ring.warnings,
    )
