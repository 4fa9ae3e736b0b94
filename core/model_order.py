"""How many modes are in a ring-down: what the data force upon us, and no more.

A further mode is believed when the likelihood ratio is beyond what the best of all the places in
the spectrum where noise could have been mistaken for one would reach by chance (Wilks' chi square,
Bonferroni over the places), with residuals that are not white counted at their own spectrum.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from .pencil import evenly, shift_poles, signal_space, thinned
from .varpro import Fit, Poles, fit

CHANCE = 1e-3  # of one false mode in a recording of white noise
MATERIAL = 5e-3  # rms of the least mode worth a name, over that of the motion, in any channel
CLEARED = 0.99  # share of what was left, above which even a trifle is a mode
MISFIT = 1.6  # residual over noise, above which the recording is not a sum of modes alone
SAME_SHAPE = 0.9  # modal assurance criterion
SAME_SHAPE_BLURRED = 0.35  # the same, for two modes closer than their widths
SAME_PITCH = 0.25  # relative difference
SLOWEST = 0.7  # creep in nepers over the record; slower ones are polynomials
CYCLES = 0.75  # of the slowest oscillation within the record; slower ones are trends
OVERDAMPED = 0.97  # damping ratio beyond which nothing swings
FADED = 1.5  # decay in nepers per sample beyond which a mode is a glitch of the first frame
DEGREE = 3  # of the steepest trend


@dataclass(frozen=True, eq=False)
class Record:
    """A ring-down made ready: seconds from its first sample, every channel, missing as NaN."""

    t: np.ndarray  # (T,) s, first 0
    y: np.ndarray  # (T, C)
    dt: float  # s, typical
    even: np.ndarray  # (T', C) on an even grid without gaps, in units of the noise
    floor: np.ndarray  # (C,) noise
    noise: np.ndarray | None  # (C,) as given

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


def prepare(time: np.ndarray, signals: np.ndarray, floor: np.ndarray, noise=None) -> Record:
    """A record whose noise is about `floor` (C,)."""
    dt, even = evenly(time, signals)
    scale = np.where(floor > 0, floor, 1.0)
    return Record(time - time[0], signals, dt, even / scale, floor, noise)


def polynomial(t: np.ndarray, degree: int) -> np.ndarray:
    """(T, degree + 1) Chebyshev polynomials over the record; the first is the constant."""
    return np.polynomial.chebyshev.chebvander(2 * t / t[-1] - 1, degree)


def model_of(record: Record, poles: Poles, degree: int, iterate: bool = True) -> Model:
    """The most likely model near `poles`."""
    x = polynomial(record.t, degree)
    found = fit(record.t, record.y, x, poles, noise=record.noise, iterate=iterate)
    return Model(found, degree)


def select(record: Record, most: int) -> Model:
    """The model with as many modes, up to `most`, and as much trend as the data ask for."""
    best = _pruned(record, _start(record, most))
    for _ in range(most + DEGREE + 2):
        grown = _grown(record, best, most)
        if grown is None:
            break
        grown = _pruned(record, grown)
        if _score(record, grown) >= _score(record, best):
            break
        best = grown
    return best


def believable(poles: Poles, record: Record) -> np.ndarray:
    """(m,) bool: swings at least about once, and is not gone within a frame."""
    natural = np.hypot(poles.decay, poles.omega)
    return (
        (poles.omega * record.t[-1] > 2 * np.pi * CYCLES)
        & (poles.decay < OVERDAMPED * natural)
        & (poles.decay * record.dt < FADED)
    )


# --- where to start -------------------------------------------------------------------------


def candidates(record: Record, signals: np.ndarray, most: int) -> list[np.ndarray]:
    """Sets of complex poles, one for each order of the pencil, at one or two rates."""
    found = []
    for factor in sorted({1, max(1, len(signals) // 300)}):
        part = thinned(signals, factor)
        space = signal_space(part)
        for order in range(1, min(2 * most + 6, space.shape[0] - 2, space.shape[1]) + 1):
            found.append(shift_poles(space, order, factor * record.dt))
    return found


def _poles_of(complex_poles: np.ndarray, record: Record) -> tuple[Poles, int]:
    """Oscillating and real poles out of a pencil's set; those that hardly move make a degree."""
    swinging = complex_poles[complex_poles.imag > 1e-6 / record.dt]
    swinging = swinging[swinging.imag < (np.pi - 1e-3) / record.dt]
    poles = Poles(np.maximum(-swinging.real, 0), swinging.imag, np.zeros(0))
    fine = believable(poles, record)
    real = complex_poles[np.abs(complex_poles.imag) <= 1e-6 / record.dt].real
    creep = -real[(real < -SLOWEST / record.t[-1]) & (real > -FADED / record.dt)]
    still = np.abs(complex_poles) * record.t[-1] < 2 * np.pi * CYCLES
    degree = min(DEGREE, max(0, int(still.sum()) - len(creep)))
    return Poles(poles.decay[fine], poles.omega[fine], creep), degree


def _penalty(record: Record, poles: Poles, degree: int) -> float:
    """Twice the log likelihood that the poles must earn: Schwarz's, plus the search for places."""
    channels = len(record.size)
    logs = float(np.log(record.size).sum())
    search = 2 * np.log(len(record.t) / CHANCE)
    mode = min(2 * logs, _threshold(record, 2 * channels + 2)) + search
    creep = min(logs, _threshold(record, channels + 1))
    return len(poles.omega) * mode + (len(poles.creep) + degree) * creep


def _threshold(record: Record, freedoms: int) -> float:
    """Likelihood ratio (twice its logarithm) that noise alone does not reach anywhere."""
    return float(chdtri(freedoms, CHANCE / (2 * len(record.t))))


def _start(record: Record, most: int) -> Model:
    """The pencil's set that pays best for its poles, refined; the constant alone if none does."""
    none = Poles(np.zeros(0), np.zeros(0), np.zeros(0))
    tried = [(2 * model_of(record, none, 0).fit.cost, 0, none, 0)]
    room = int(record.size.min()) - 4 - DEGREE
    for n, found in enumerate(candidates(record, record.even, most)):
        poles, degree = _poles_of(found, record)
        if len(poles.omega) > most or 4 * len(poles.omega) + 2 * len(poles.creep) > room:
            continue
        model = model_of(record, poles, degree, iterate=False)
        score = 2 * model.fit.cost + _penalty(record, poles, degree)
        tried.append((score, n + 1, poles, degree))
    tried.sort(key=lambda row: row[:2])
    fits = [model_of(record, *row[2:]) for row in tried[:2]]
    return min(fits, key=lambda model: _score(record, model))


def _score(record: Record, model: Model) -> float:
    """Less is better."""
    return 2 * model.fit.cost + _penalty(record, model.fit.poles, model.degree)


# --- growing and pruning --------------------------------------------------------------------


def _without(poles: Poles, k: int) -> Poles:
    """Poles less the k-th, counted over modes and then creeps."""
    m = len(poles.omega)
    keep = np.arange(m) != k
    return Poles(
        poles.decay[keep], poles.omega[keep], poles.creep[np.arange(len(poles.creep)) != k - m]
    )


def _needed(record: Record, small: Model, large: Model, k: int | None) -> bool:
    """True where what `large` has more is beyond chance, beyond a trifle, and no makeshift.

    `k`: the pole in question, counted over modes and then creeps; None for a steeper trend.
    """
    channels = len(record.size)
    swings = k is not None and k < large.modes
    free = 1 - (large.fit.columns + 2) / record.size.mean()  # Bartlett's correction
    ratio = 2 * (small.fit.cost - large.fit.cost) * free
    steeper = max(large.degree - small.degree, 0) if k is None else 0
    least = _threshold(
        record, (2 * channels + 2) if swings else (channels * steeper or channels + 1)
    )
    colour = inflation(large.fit, record.dt, large.fit.poles.omega[[k]])[0] if swings else 1.0
    against = np.sum(record.size * (small.fit.noise**2 / large.fit.noise**2 - 1)) * free
    if ratio < least or max(against, ratio) < least * colour:
        return False
    if swings and _makeshift(record, large, k):
        return False
    motion = np.nansum((record.y - np.nanmean(record.y, axis=0)) ** 2)
    before = np.nansum(small.fit.residual**2)
    less = before - np.nansum(large.fit.residual**2)
    return bool(less > MATERIAL**2 * motion or less > CLEARED * before)


def _makeshift(record: Record, model: Model, k: int) -> bool:
    """True where mode k bends a stronger one that no sum of damped sinusoids describes.

    It has the other's shape and nearly its pitch, and yet the residual stays above the noise:
    friction, contact and large amplitudes look like that, a pair of true modes does not.
    """
    left = np.sqrt(np.nanmean(model.fit.residual**2, axis=0))
    if np.median(left / np.where(record.floor > 0, record.floor, np.inf)) < MISFIT:
        return False
    shape = model.fit.amplitude / model.fit.noise
    power = np.sum(np.abs(shape) ** 2, axis=1)
    likeness = np.abs(shape.conj() @ shape[k]) ** 2 / np.maximum(power * power[k], 1e-300)
    omega, decay = model.fit.poles.omega, model.fit.poles.decay
    near = np.abs(omega / omega[k] - 1) < SAME_PITCH
    blurred = np.abs(omega - omega[k]) < decay + decay[k]  # such a pair's shapes are uncertain too
    same = (near & (likeness > SAME_SHAPE)) | (blurred & (likeness > SAME_SHAPE_BLURRED))
    stronger = (power > power[k]) | ((power == power[k]) & (np.arange(model.modes) < k))
    return bool((same & stronger).any())


def _pruned(record: Record, model: Model) -> Model:
    """Without makeshifts, and without the weakest poles whose loss is no more than chance."""
    model = _reasonable(record, model)
    while True:
        poles = model.fit.poles
        total = len(poles.decay) + len(poles.creep)
        rest = [model_of(record, _without(poles, k), model.degree, False) for k in range(total)]
        order = sorted(range(total), key=lambda k: rest[k].fit.cost)
        doubtful = [k for k in order if k < model.modes and _makeshift(record, model, k)]
        for k in doubtful[:1] or order[:2]:
            smaller = model_of(record, _without(poles, k), model.degree)
            if not _needed(record, smaller, model, k):
                break
        else:
            if not model.degree:
                return model
            smaller = model_of(record, poles, model.degree - 1)
            if _needed(record, smaller, model, None):
                return model
        model = _reasonable(record, smaller)


def _reasonable(record: Record, model: Model) -> Model:
    """Refitted without oscillations that have wandered off to where nothing swings."""
    for _ in range(8):
        poles = model.fit.poles
        fine = believable(poles, record) & (poles.omega * record.dt < np.pi)
        slow = (poles.creep * record.t[-1] > SLOWEST) & (poles.creep * record.dt < FADED)
        if fine.all() and slow.all():
            return model
        poles = Poles(poles.decay[fine], poles.omega[fine], poles.creep[slow])
        model = model_of(record, poles, model.degree)
    return model


def _grown(record: Record, model: Model, most: int) -> Model | None:
    """The model with the mode or trend that it misses most, None if it misses nothing."""
    p = model.fit.poles
    steps = [(model_of(record, p, d), None) for d in range(model.degree + 1, DEGREE + 1)]
    if not len(p.creep):
        tries = [Poles(p.decay, p.omega, np.array([c / record.t[-1]])) for c in (1.0, 4.0)]
        steps += [(model_of(record, poles, 0), model.modes) for poles in tries]
    if model.modes < most:
        steps += [(larger, model.modes) for larger in _one_more(record, model)]
    for larger, k in sorted(steps, key=lambda step: _score(record, step[0])):
        whole = _reasonable(record, larger)
        if whole is larger and _needed(record, model, larger, k):
            return larger
    return None


def _one_more(record: Record, model: Model) -> list[Model]:
    """Models with one more oscillation: from the residual's own poles, or by splitting one."""
    poles = model.fit.poles
    if 4 * (model.modes + 1) + 2 > record.size.min() - 4:
        return []
    _, left = evenly(record.t, model.fit.residual / np.where(record.floor > 0, record.floor, 1))
    space = signal_space(left)
    tried = [_poles_of(shift_poles(space, n, record.dt), record)[0] for n in (2, 4, 6)]
    places = {(s, w) for p in tried for s, w in zip(p.decay, p.omega, strict=True)}
    for s, w in zip(poles.decay, poles.omega, strict=True):
        apart = max(s, 2 * np.pi / record.t[-1]) / 2
        places |= {(s, w + apart), (s, max(w - apart, w / 2))}
    starts = [
        Poles(np.append(poles.decay, s), np.append(poles.omega, w), poles.creep)
        for s, w in sorted(places)
    ]
    quick = [(model_of(record, p, model.degree, False).fit.cost, n) for n, p in enumerate(starts)]
    chosen = [starts[n] for _, n in sorted(quick)[:2]]
    return [model_of(record, p, model.degree) for p in chosen]


# --- residuals that are not white -----------------------------------------------------------


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
        parts = [_density(part, w * dt) for part in (combined.real, combined.imag)]
        factors.append(max(1.0, sum(parts) / (1.0 if len(weight) == 1 else free)))
    return np.array(factors)


def _density(series: np.ndarray, angle: float) -> float:
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
