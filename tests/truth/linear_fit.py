"""What the declared linear model leaves behind: used only to choose how strong an effect to plant.

Variable projection: poles are searched, amplitudes and offsets are linear.
"""

import numpy as np
from scipy.optimize import least_squares


def leftover(time, values, frequency, ratio, shapes=None) -> float:
    """RMS that the best sum of damped modes leaves of `values` (T, C), offsets free.

    Starting frequency (m,) Hz and damping ratio (m,). With `shapes` (C, m) the frequencies keep
    their proportions and every mode its shape, as in a model with one free modulus.
    """
    count = len(frequency)
    centred = values - values.mean(0)
    scale = np.sqrt(np.mean(centred**2)) + 1e-300
    if shapes is not None:
        shapes = shapes / np.abs(shapes).max(0)
    few, shapes, lost = compress(centred / scale, shapes)

    def poles(p):
        f = frequency * np.exp(p[:count] if shapes is None else p[0])
        z = np.clip(ratio * np.exp(p[-count:]), 1e-5, 0.9)
        return 2 * np.pi * f * (-z + 1j * np.sqrt(1 - z**2))

    def residual(p):
        wave = np.exp(np.outer(time, poles(p)))
        wave = np.hstack([wave.real, wave.imag])
        wave = wave - wave.mean(0)
        return free(few, wave) if shapes is None else locked(few, wave, shapes)

    start = np.zeros(count + (count if shapes is None else 1))
    tie = np.full(len(start), 1 / 0.15)  # a mode may not wander off and turn into something else
    tie[-count:] = 1 / 0.5
    tie *= 0.03 * np.sqrt(values.size)
    fit = least_squares(
        lambda p: np.append(residual(p).ravel(), tie * p), start, method="lm", ftol=1e-4, xtol=1e-4,
        max_nfev=12 * (len(start) + 1),
    )  # fmt: skip
    return float(scale * np.sqrt((np.sum(residual(fit.x) ** 2) + lost) / values.size))


def compress(values, shapes) -> tuple:
    """Channels turned to a few that hold nearly all, the shapes with them, and the energy lost."""
    side = values if shapes is None else np.vstack([values, 1e3 * shapes.T])
    _, _, V = np.linalg.svd(side, full_matrices=False)
    V = V[:10].T
    few = values @ V
    lost = max(np.sum(values**2) - np.sum(few**2), 0.0)
    return few, None if shapes is None else V.T @ shapes, lost


def free(values, wave) -> np.ndarray:
    """Residual with every shape free."""
    Q, _ = np.linalg.qr(wave)
    return values - Q @ (Q.T @ values)


def locked(values, wave, shapes) -> np.ndarray:
    """Residual with fixed shapes, by the normal equations of the Kronecker basis."""
    both = np.hstack([shapes, shapes])
    gram = (wave.T @ wave) * (both.T @ both)
    size = np.sqrt(np.diag(gram)) + 1e-300
    right = np.sum(wave * (values @ both), axis=0)
    part = np.linalg.lstsq(gram / np.outer(size, size), right / size, rcond=1e-10)[0] / size
    return values - (wave * part) @ both.T
