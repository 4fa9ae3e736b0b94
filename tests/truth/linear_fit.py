"""What the declared linear model leaves behind: used only to choose how strong an effect to plant.

Variable projection: poles are searched, amplitudes and offsets are linear.
"""

import numpy as np
from scipy.optimize import least_squares


def leftover(time, values, frequency, ratio, shapes=None) -> np.ndarray:
    """Residual (T, C) after the best sum of damped modes.

    values (T, C); starting frequency (m,) Hz and damping ratio (m,). With `shapes` (C, m) the
    frequencies keep their proportions and every mode its shape, as in a model with one free modulus.
    """
    count = len(frequency)

    def poles(p):
        f = frequency * np.exp(p[:count] if shapes is None else p[0])
        z = np.clip(ratio * np.exp(p[-count:]), 1e-5, 0.9)
        return 2 * np.pi * f * (-z + 1j * np.sqrt(1 - z**2))

    def residual(p):
        wave = np.exp(np.outer(time, poles(p)))
        if shapes is None:
            basis = np.hstack([np.ones((len(time), 1)), wave.real, wave.imag])
            return values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
        return locked(values, wave, shapes)

    size = count + (count if shapes is None else 1)
    scale = np.sqrt(np.mean((values - values.mean(0)) ** 2)) + 1e-300
    fit = least_squares(
        lambda p: (residual(p) / scale).ravel(), np.zeros(size), bounds=(-1.2, 1.2), max_nfev=25
    )
    return residual(fit.x)


def locked(values, wave, shapes) -> np.ndarray:
    """Residual with fixed shapes: the offsets drop out by taking means."""
    centred = values - values.mean(0)
    wave = wave - wave.mean(0)
    parts = [wave.real, wave.imag]
    basis = np.stack([p[:, None, k] * shapes[None, :, k] for p in parts for k in range(p.shape[1])], -1)
    flat = basis.reshape(-1, basis.shape[-1])
    size = np.linalg.norm(flat, axis=0) + 1e-300
    return centred - ((flat / size) @ np.linalg.lstsq(flat / size, centred.ravel(), rcond=None)[0]).reshape(
        centred.shape
    )
