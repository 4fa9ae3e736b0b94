"""What the body's own pitches and shapes leave of a recording, in the time layer's terms."""

import numpy as np

from .compare import Hypothesis
from .gaps import bridged
from .ground import Ground
from .law import TimeFit
from .match import mac
from .residual import Error, error_of

BENT = 0.95  # MAC below which a computed shape is not the measured one
SHOWN = 1.5  # times the error of free modes, from which the body's pitches and shapes show
MENDED = 0.8  # of the declared body's error, held out or fitted, that is left at most
PULLED = 3.0  # standard deviations that a computed pitch is forgiven: it may be off by so much


def body_error(
    declared: TimeFit, ground: Ground, found: Hypothesis, alike=(), fit: TimeFit | None = None
) -> Error:
    """Of a fit of the time layer, the declared one or another, with the body's pitches and shapes.

    alike: numbers of further takes, in which that body rings as in the first one. However it is
    fitted, the motion dies away as the `declared` fit has it.
    """
    fit = fit or declared
    law, data = fit.law, ground.data
    K, loud = law.modes, ground.measured
    own = np.r_[fit.frequency, loud.frequency[K:]]
    heard = np.vstack([fit.shapes, loud.shapes[K:]])
    pulls = found.pitch_pull[: len(found.frequency)]
    together = _beyond(found.together) @ loud.together[:, : len(pulls)]
    off = np.exp(-_beyond(pulls) * loud.error - together)
    folded = np.isin(np.arange(len(own)), found.folded)  # what is folded moves the other way
    f = np.where(folded, own + found.read * (1 - off), own * off)
    bent = np.array([mac(a, b) < BENT for a, b in zip(found.shapes, heard, strict=True)])
    shapes = np.where(bent[:, None], found.shapes, heard)
    index = law.fitted[0]
    z, told = ground.damping_ratio, fit.predicted[index]
    change = _bound(z, f, shapes, data, told) - _bound(z, own, heard, data, told)
    predicted = list(fit.predicted)
    predicted[index] = predicted[index] + change
    elsewhere = {i: (law.fitted.index(i), fit.frequency) for i in alike}
    for one, off in zip(ground.shifts, found.shifts.beyond(_beyond), strict=True):
        pitches = fit.pitches(one.take) * np.exp(off)
        own = law.pitch[law.fitted[one.take]]
        laden = [i for i, data in enumerate(law.takes) if law.pitch[i] == own and data.fit.any()]
        elsewhere |= dict.fromkeys(laden, (one.take, pitches))
    for i, (n, pitches) in elsewhere.items():
        data, z, shapes = law.takes[i], declared.damping_ratios(n), fit.shapes_of(n)
        told = fit.predicted[i]
        here, there = (_bound(z, f, shapes, data, told) for f in (pitches, fit.pitches(n)))
        predicted[i] = predicted[i] + here - there
    return error_of(law.takes, predicted)


def _beyond(pulls: np.ndarray) -> np.ndarray:
    """(n,) standard deviations, what of the pulls (n,) is not forgiven."""
    return np.sign(pulls) * np.maximum(np.abs(pulls) - PULLED, 0)


def _bound(z: np.ndarray, frequency, shapes, data, told) -> np.ndarray:
    """(T, C) best linear ring-down with these damping ratios, pitches and shapes, fitted where it
    may be; `told` (T, C): what stands in for markers that are hidden by turns.
    """
    w = 2 * np.pi * frequency
    phase = np.outer(data.time, w * np.sqrt(1 - z**2))
    fall = np.exp(-np.outer(data.time, z * w))
    waves = np.hstack([fall * np.cos(phase), fall * np.sin(phase)])  # (T, 2K)
    values, whole = bridged(data.values, told, data.fit)
    use = data.fit & whole
    mean = waves[use].mean(axis=0)
    both = np.vstack([shapes, shapes]) / data.sigma  # (2K, C)
    y = (values[use] - values[use].mean(axis=0)) / data.sigma
    centred = waves[use] - mean
    gram = (centred.T @ centred) * (both @ both.T)
    right = np.einsum("tk,tc,kc->k", centred, y, both)
    a = np.linalg.lstsq(gram, right, rcond=None)[0]
    return ((waves - mean) * a) @ (both * data.sigma) + values[use].mean(axis=0)


def mends(after: Error, before: Error, free: Error) -> bool:
    """Whether what the declared body misses more than free modes do is less with the effect.

    What does not show there is no test.
    """
    shown = _shown(after, before, free)
    return not shown or any(now < MENDED * was for now, was, _ in shown)


def leaves(after: Error, before: Error, free: Error) -> float:
    """Share that is left of the error, rms, that the declared body shows beyond free modes: held
    out or fitted, the larger one.
    """
    over = [
        max(now**2 - least**2, 0) / (was**2 - least**2)
        for now, was, least in _shown(after, before, free)
    ]
    return float(np.sqrt(max(over, default=0.0)))


def misleads(with_it: Error, before: Error, free: Error) -> bool:
    """Whether a change of the body foretells what was held out worse than the declared one, which
    itself misses it clearly.
    """
    return before.over(free, SHOWN)[0] and with_it.held_out > before.held_out


def _shown(after: Error, before: Error, free: Error) -> list[tuple[float, float, float]]:
    """(after, before, free) held out and fitted, where the body's error shows."""
    pairs = zip(before.over(free, SHOWN), ("held_out", "fit"), strict=True)
    return [tuple(getattr(e, part) for e in (after, before, free)) for over, part in pairs if over]
