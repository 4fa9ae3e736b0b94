"""What a recording can prove: whether a mode is there, and how far its estimate may be off.

A further mode is believed when the likelihood ratio is beyond what the best of all the places in
the spectrum where noise could have been mistaken for one would reach by chance (Wilks' chi square,
Bonferroni over the places), with residuals that are not white counted at their own spectrum.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from .varpro import Fit, Poles

CHANCE = 1e-3  # of one false mode in a recording of white noise
MATERIAL = 5e-3  # rms of the least mode worth a name, over that of all motion
CLEARED = 0.99  # share of what was left, above which even a trifle is a mode
MOST = 0.5  # share of what was left, above which a mode is one however badly it fits
ALL = 0.95  # share of what was left, above which one near another pitch is a mode of its own
MISFIT = 1.6  # residual over noise, above which the recording is not a sum of modes alone
MANY = 6  # channels, in which two modes of one body cannot look the same
SAME_SHAPE = 0.9  # modal assurance criterion
SAME_SHAPE_BLURRED = 0.35  # the same, for two modes closer than their widths
SAME_PITCH = 0.25  # relative difference
STEADY = 0.1  # nepers over the record, at most, of what something drives
DYING = 1.0  # nepers that what is let go falls by, at least, beside it
CYCLES = 0.75  # of the slowest oscillation within the record; slower ones are trends
OVERDAMPED = 0.97  # damping ratio beyond which nothing swings
FADED = 1.5  # decay in nepers per sample beyond which a mode is a glitch of the first frame


@dataclass(frozen=True, eq=False)
class Record:
    """A ring-down made ready: seconds from its first sample, every channel, missing as NaN."""

    t: np.ndarray  # (T,) s, first 0
    y: np.ndarray  # (T, C)
    dt: float  # s, typical
    even: np.ndarray  # (T', C) on an even grid without gaps, in units of the noise
    floor: np.ndarray  # (C,) noise
    noise: np.ndarray | None  # (C,) as given
    faintest: float = MATERIAL  # share of the motion, rms, that a mode must have

    @property
    def size(self) -> np.ndarray:
        """(C,) samples."""
        return np.isfinite(self.y).sum(axis=0)


@dataclass(frozen=True, eq=False)
class Model:
    """Poles and trend fitted to a record."""

    fit: Fit
    degree: int  # of the polynomial, 0 = the constant alone

    @property
    def modes(self) -> int:
        """Oscillating poles."""
        return len(self.fit.poles.omega)


def believable(poles: Poles, record: Record) -> np.ndarray:
    """(m,) bool: swings at least about once, and is not gone within a frame."""
    natural = np.hypot(poles.decay, poles.omega)
    return (
        (poles.omega * record.t[-1] > 2 * np.pi * CYCLES)
        & (poles.decay < OVERDAMPED * natural)
        & (poles.decay * record.dt < FADED)
    )


def threshold(record: Record, freedoms: int) -> float:
    """Likelihood ratio (twice its logarithm) that noise alone does not reach anywhere."""
    return float(chdtri(freedoms, CHANCE / (2 * len(record.t))))


def needed(record: Record, small: Model, large: Model, k: int | None) -> bool:
    """True where what `large` has more is beyond chance, beyond a trifle, and no makeshift.

    `k`: the pole in question, counted over modes and then creeps; None for a steeper trend.
    """
    channels = len(record.size)
    swings = k is not None and k < large.modes
    free = 1 - (large.fit.columns + 2) / record.size.mean()  # Bartlett's correction
    ratio = 2 * (small.fit.cost - large.fit.cost) * free
    steeper = max(large.degree - small.degree, 0) if k is None else 0
    least = threshold(
        record, (2 * channels + 2) if swings else (channels * steeper or channels + 1)
    )
    colour = inflation(large.fit, record.dt, large.fit.poles.omega[[k]])[0] if swings else 1.0
    before = np.nansum(small.fit.residual**2)
    less = before - np.nansum(large.fit.residual**2)
    loud = swings and ratio >= least and less > MOST * before
    if loud and not makeshift(record, large, k, small):
        return True
    against = np.sum(record.size * (small.fit.noise**2 / large.fit.noise**2 - 1)) * free
    if ratio < least or max(against, ratio) < least * colour:
        return False
    if swings and makeshift(record, large, k, small):
        return False
    motion = np.nansum((record.y - np.nanmean(record.y, axis=0)) ** 2)
    return bool(less > record.faintest**2 * motion or less > CLEARED * before)


def makeshift(record: Record, model: Model, k: int, small: Model | None = None) -> bool:
    """True where mode k bends a stronger one that no sum of damped sinusoids describes.

    It has the other's shape and nearly its pitch. Friction, contact and large amplitudes look like
    that; a pair of true modes does only where few channels see it, and then it leaves no residual.
    `small`: the model without it; a mode of another shape that takes nearly all that this leaves
    is none, nor is a steady drive that does, or the mode beside one.
    """
    left = np.sqrt(np.nanmean(model.fit.residual**2, axis=0))
    misfit = np.median(left / np.where(record.floor > 0, record.floor, np.inf)) > MISFIT
    if not misfit and len(left) < MANY:
        return False
    shape = model.fit.amplitude / model.fit.noise
    power = np.sum(np.abs(shape) ** 2, axis=1)
    likeness = np.abs(shape.conj() @ shape[k]) ** 2 / np.maximum(power * power[k], 1e-300)
    omega, decay = model.fit.poles.omega, model.fit.poles.decay
    same = (np.abs(omega / omega[k] - 1) < SAME_PITCH) & (likeness > SAME_SHAPE)
    takes_all = small is not None and _takes_all(small, model)
    if takes_all and not misfit:
        # a drive beside a mode moves the body as that does, and goes on where that dies
        steady, dies = decay * record.t[-1] < STEADY, decay * record.t[-1] > DYING
        same &= ~((steady & dies[k]) | (dies & steady[k]))
    if misfit and not takes_all:
        # the shapes of two modes closer than their widths are uncertain too
        blurred = np.abs(omega - omega[k]) < decay + decay[k]
        same |= blurred & (likeness > SAME_SHAPE_BLURRED)
    stronger = (power > power[k]) | ((power == power[k]) & (np.arange(model.modes) < k))
    return bool((same & stronger).any())


def _takes_all(small: Model, large: Model) -> bool:
    before, after = (np.nansum((m.fit.residual / large.fit.noise) ** 2) for m in (small, large))
    return bool(after < (1 - ALL) * before)


def inflation(found: Fit, dt: float, omega) -> np.ndarray:
    """(k,) >= 1: variance of estimates at `omega` (k,) 1/s over what white noise would give.

    The residual, weighed as a mode's channels are, has the spectrum of a low-order autoregression
    (order by BIC); what counts is its density at the mode's own frequency.
    """
    residual = np.where(np.isfinite(found.residual), found.residual, 0.0) / found.noise
    present = np.isfinite(found.residual).mean(axis=0)
    free = max(1 - (found.columns + 2) / len(residual), 0.1)
    factors = []
    for w in omega:
        if len(found.poles.omega):
            k = int(np.argmin(np.abs(found.poles.omega - w)))
            weight = np.conj(found.amplitude[k]) / found.noise
        else:
            weight = 1 / found.noise.astype(complex)
        size = np.sum(np.abs(weight) ** 2 * present)
        if not (np.isfinite(size) and size > 0):
            factors.append(1.0)
            continue
        combined = residual @ (weight / np.sqrt(size))
        parts = [density(part, w * dt) for part in (combined.real, combined.imag)]
        factors.append(max(1.0, sum(parts) / (1.0 if len(weight) == 1 else free)))
    return np.array(factors)


def density(series: np.ndarray, angle: float) -> float:
    """Density of an autoregression at `angle` rad per sample; of white noise: its variance."""
    count = len(series)
    variance = float(np.mean(series**2))
    if variance < 1e-30:
        return 0.0
    correlation = np.array([series[: count - k] @ series[k:] for k in range(9)]) / count
    best, density = count * np.log(variance), variance
    a, error = np.array([1.0]), variance
    for order in range(1, min(9, count // 10)):
        reflect = -(a @ correlation[order:0:-1]) / error
        a = np.append(a, 0.0) + reflect * np.append(0.0, a[::-1])
        error *= max(1 - reflect**2, 1e-6)
        score = count * np.log(error) + order * np.log(count)
        if score < best:
            best = score
            response = a @ np.exp(-1j * angle * np.arange(order + 1))
            density = error / abs(response) ** 2
    return density
