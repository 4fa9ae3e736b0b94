"""How every point takes part in a mode, with what noise leaves open of it.

Amplitudes are linear in the samples, so their covariance is that of least squares; poles that are
not known exactly add theirs (the Schur complement of Fisher's matrix: Kay, Fundamentals of
Statistical Signal Processing, vol. 1, 1993, ch. 3).
"""

import numpy as np

from .data import RingDown, poles
from .significance import density

FAINT = 2.0  # standard deviations: an amplitude below it has no phase to speak of


def deflection_covariance(time: np.ndarray, signals: np.ndarray, found: RingDown) -> np.ndarray:
    """(m, C, 2, 2) covariance of the real and imaginary part of `found.amplitude`.

    time (T,) s and signals (T, C), NaN where missing, are what the amplitudes were fitted to, with
    a constant beside them. Noise that is not white counts at its density at each mode. Infinite
    for a channel without enough samples.
    """
    m, C = found.amplitude.shape
    pole = poles(found.frequency, found.damping_ratio)
    wave = np.exp(np.outer(time - found.t0, pole))
    basis = np.hstack([wave.real, -wave.imag, np.ones((len(time), 1))])
    slope = _slopes(found, pole)
    left = signals - found.predict(time)
    step = float(np.median(np.diff(time)))
    out = np.full((m, C, 2, 2), np.inf)
    inverses: dict[bytes, np.ndarray] = {}
    for c in range(C):
        seen = np.isfinite(signals[:, c])
        if seen.sum() <= basis.shape[1] + 2:
            continue
        key = seen.tobytes()
        if key not in inverses:
            inverses[key] = np.linalg.pinv(basis[seen])
        solve = inverses[key]
        moved = (time[seen, None] - found.t0) * wave[seen] * found.amplitude[:, c]
        bent = np.hstack([(moved * slope[0]).real, (moved * slope[1]).real])  # (n, 2m) dy/d(f, z)
        gain = solve @ bent  # the amplitudes take up what moved poles leave
        free = seen.sum() - basis.shape[1]
        scale = seen.sum() / free
        for k in range(m):
            level = scale * density(left[seen, c], 2 * np.pi * found.frequency[k] * step)
            rows = [k, m + k]
            white = solve[rows] @ solve[rows].T * max(level, scale * np.mean(left[seen, c] ** 2))
            out[k, c] = white + gain[rows] @ found.covariance @ gain[rows].T
    return out


def polar(value: complex, covariance: np.ndarray) -> tuple[tuple, tuple]:
    """(amplitude, low, high) and (phase, low, high) rad with 95 % intervals of a complex number.

    covariance (2, 2) of its real and imaginary part. A phase that noise hides may be any.
    """
    size = abs(value)
    along = np.array([value.real, value.imag]) / size if size > 0 else np.array([1.0, 0.0])
    across = np.array([-along[1], along[0]])
    radial, turned = (float(np.sqrt(max(w @ covariance @ w, 0.0))) for w in (along, across))
    amplitude = (size, max(size - 1.96 * radial, 0.0), size + 1.96 * radial)
    phase = float(np.angle(value))
    if not size > FAINT * turned or 1.96 * turned > np.pi * size:
        return amplitude, (phase, -np.pi, np.pi)
    reach = 1.96 * turned / size
    return amplitude, (phase, phase - reach, phase + reach)


def _slopes(found: RingDown, pole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """d(pole)/d(f) and d(pole)/d(z) (m,)."""
    z = found.damping_ratio
    return pole / found.frequency, 2 * np.pi * found.frequency * (-1 - 1j * z / np.sqrt(1 - z**2))
