"""Ring-down in, modes out: natural frequencies, damping ratios and amplitudes, with intervals.

All channels share the poles. The matrix pencil says where they may be, maximum likelihood by
variable projection where they are, and a likelihood ratio test how many of them there are.
"""

import numpy as np

from . import varpro
from .data import RingDown, poles
from .errors import RecordingError
from .model_order import prepare, select
from .noise_floor import noise_floor
from .significance import MATERIAL, inflation

__all__ = ["fit_poles", "invert", "noise_floor"]

MOST_MODES = 16
FEWEST_FRAMES = 12


def invert(
    time: np.ndarray,
    signals: np.ndarray,
    *,
    max_modes: int | None = None,
    t0=None,
    noise=None,
    faintest: float = MATERIAL,
) -> RingDown:
    """Modes of a ring-down, as many as the data force upon us; strongest first.

    time (T,) s ascending, even or not; signals (T, C), NaN where a sample is missing. Samples
    before `t0` (s, default the first) are left out, and amplitudes refer to the first one used.
    `noise` (C,) rms weights the channels where it is known. `faintest`: share of all motion, rms,
    from which a mode that is beyond chance is worth a name. A constant is always in the model, a
    slow trend or a creep where the data ask for one; neither is a mode. Raises RecordingError on
    too little data.
    """
    time, signals = _checked(time, signals, t0)
    given = None if noise is None else _checked_noise(noise, signals)
    floor = noise_floor(time, signals) if given is None else given
    room = (int(np.isfinite(signals).sum(axis=0).min()) - 6) // 4
    most = max(0, min(MOST_MODES if max_modes is None else max_modes, room))
    record = prepare(time, signals, floor, given, faintest)
    found = select(record, most)
    return _ringdown(found.fit, time, given, found.degree)


def fit_poles(  # noqa: PLR0913  (keywords for what most callers leave out)
    time: np.ndarray,
    signals: np.ndarray,
    frequency: np.ndarray,
    damping_ratio: np.ndarray,
    *,
    extra_basis: np.ndarray | None = None,
    noise: np.ndarray | None = None,
    fit: bool = True,
) -> RingDown:
    """Most likely ring-down with as many modes as are given, from those values; strongest first.

    time (T,) s, signals (T, C) with NaN where missing, frequency (m,) Hz natural, damping_ratio
    (m,) in [0, 1). `extra_basis` (T, q): columns beside the constant, fitted freely in every
    channel. `noise` (C,) rms: the channels' weights, else estimated along with the poles.
    `fit=False`: amplitudes only. Amplitudes refer to the first instant.
    """
    time, signals = _checked(time, signals, None)
    given = None if noise is None else _checked_noise(noise, signals)
    p = poles(np.atleast_1d(frequency), np.clip(np.atleast_1d(damping_ratio), 0, 1 - 1e-9))
    x = np.ones((len(time), 1))
    if extra_basis is not None:
        x = np.hstack([x, np.asarray(extra_basis, float).reshape(len(time), -1)])
    start = varpro.Poles(-p.real, p.imag, np.zeros(0))
    steps = varpro.ITERATIONS if fit else 0
    found = varpro.fit(time - time[0], signals, x, start, noise=given, iterations=steps)
    return _ringdown(found, time, given)


def _checked(time, signals, t0) -> tuple[np.ndarray, np.ndarray]:
    time, signals = np.asarray(time, float), np.asarray(signals, float)
    if signals.ndim == 1:
        signals = signals[:, None]
    if time.ndim != 1 or signals.ndim != 2 or len(time) != len(signals):
        raise RecordingError(
            f"Ring-down: time {time.shape} and signals {signals.shape} do not belong together; "
            "(T,) and (T, C) are needed."
        )
    if t0 is not None:
        time, signals = time[time >= t0], signals[time >= t0]
    if len(time) < FEWEST_FRAMES:
        raise RecordingError(
            f"Ring-down: {len(time)} frames; {FEWEST_FRAMES} are needed. Record longer."
        )
    if not (np.isfinite(time).all() and (np.diff(time) > 0).all()):
        raise RecordingError("Ring-down: time goes back or stands still. Sort the frames.")
    few = np.isfinite(signals).sum(axis=0) < FEWEST_FRAMES
    if few.any() or not signals.shape[1]:
        raise RecordingError(
            f"Ring-down: {few.sum()} of {few.size} channels have fewer than {FEWEST_FRAMES} "
            "samples. Leave them out."
        )
    return time, signals


def _checked_noise(noise, signals) -> np.ndarray:
    noise = np.broadcast_to(np.asarray(noise, float), signals.shape[1:]).copy()
    if not (np.isfinite(noise).all() and (noise > 0).all()):
        raise RecordingError("Ring-down: a channel's noise is not above 0. Leave it to be found.")
    return noise


def _ringdown(found: varpro.Fit, time: np.ndarray, given, degree: int = 0) -> RingDown:
    decay, omega = found.poles.decay, found.poles.omega
    natural = np.hypot(decay, omega)
    order = np.argsort(-np.linalg.norm(found.amplitude, axis=1), kind="stable")
    count = np.isfinite(found.residual).sum(axis=0)
    free = np.maximum(count - found.columns - len(found.poles.vector) / len(count), 1)
    rms = np.sqrt(np.nansum(found.residual**2, axis=0) / free)
    covariance = _covariance(found, rms, float(np.median(np.diff(time))), given is not None)
    m = len(omega)
    both = np.concatenate([order, m + order])
    return RingDown(
        frequency=natural[order] / (2 * np.pi),
        damping_ratio=decay[order] / natural[order],
        amplitude=found.amplitude[order],
        offset=found.linear[0],
        noise=rms,
        covariance=covariance[np.ix_(both, both)],
        t0=float(time[0]),
        degree=degree,
        creep=found.poles.creep,
    )


def _covariance(found: varpro.Fit, rms, dt: float, weighted: bool) -> np.ndarray:
    """(2m, 2m) of natural frequency (Hz) and damping ratio, residuals' colour included."""
    decay, omega = found.poles.decay, found.poles.omega
    m = len(omega)
    if not m:
        return np.zeros((0, 0))
    scale = np.sqrt(np.maximum(np.diag(found.information), 1e-300))
    inverse = np.linalg.pinv(found.information / np.outer(scale, scale), hermitian=True)
    by_pole = (inverse / np.outer(scale, scale))[: 2 * m, : 2 * m]
    w = np.hypot(decay, omega)
    k = np.arange(m)
    change = np.zeros((2 * m, 2 * m))
    change[k, k], change[k, m + k] = decay / w / (2 * np.pi), omega / w / (2 * np.pi)
    change[m + k, k], change[m + k, m + k] = omega**2 / w**3, -decay * omega / w**3
    wider = np.sqrt(np.tile(inflation(found, dt, omega), 2))
    freedoms = 1.0 if weighted else float(np.mean((rms / found.noise) ** 2))
    return freedoms * np.outer(wider, wider) * (change @ by_pole @ change.T)
