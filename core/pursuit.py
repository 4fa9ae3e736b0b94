"""Which of the heard poles take the motion, one after the other, and which of them are driven."""

import numpy as np

from .baseline import real_shapes
from .data import RingDown, poles
from .gaps import bridged
from .shutter import at_once, rung
from .significance import DYING, STEADY

MOST = 8  # poles that are looked at as modes of the body
DEAD = 0.5  # damping ratio above which a pole is no mode of the body that rings
HEARD = 0.1  # of the loudest pole at the release: what dies more faintly than that tells nothing


def pursue(ring: RingDown, time: np.ndarray, values: np.ndarray, sigma: np.ndarray, *, late=None):
    """Poles in the order in which they take most of the motion beside means that wander, and each
    one's shape (C,) then.

    Strongly damped companions of a nonlinear mode cancel one another, so their amplitudes at the
    release say nothing; what one takes away from (T, C) `values` beside those before it does
    (orthogonal matching pursuit: Pati, Rezaiifar, Krishnaprasad, Asilomar 1993). `late` (T, C) s:
    how much after the instants `time` the samples were taken, where that is known.
    """
    told = rung(ring, time, 0.0 if late is None else late.mean(axis=0))
    values, known = bridged(values, told, slow=ring.slow(time))
    y = ((values - np.nanmean(values, axis=0)) / sigma)[known]
    pole = poles(ring.frequency, ring.damping_ratio)
    phase = np.exp(np.outer(time[known] - ring.t0, pole))
    slow = ring.slow(time[known])
    alive = ring.damping_ratio <= DEAD
    size = np.linalg.norm(ring.amplitude / sigma, axis=1)
    heard = alive & (size > HEARD * size.max())
    driven = is_driven(pole, np.ptp(time[known]), pole[heard])
    order, shapes, gains = [], [], []
    left = power = float(((y - slow @ np.linalg.lstsq(slow, y, rcond=None)[0]) ** 2).sum())
    while len(order) < min(len(ring.frequency), MOST):
        tries = []
        for k in range(len(ring.frequency)):
            if k in order or driven[k] or not alive[k]:
                continue
            waves = phase[:, [*order, k]]
            basis = np.hstack([waves.real, -waves.imag, slow])
            coefficients, *_ = np.linalg.lstsq(basis, y, rcond=None)
            tries.append((float(((y - basis @ coefficients) ** 2).sum()), k, coefficients))
        if not tries:
            break
        rest, k, coefficients = min(tries, key=lambda t: t[0])
        if left - rest < 2e-6 * power:
            break
        order.append(k)
        amplitude = coefficients[len(order) - 1] + 1j * coefficients[2 * len(order) - 1]
        amplitude = at_once((amplitude * sigma)[None], pole[[k]], late)
        shapes.append(real_shapes(amplitude)[0][0])
        gains.append(np.sqrt((left - rest) / power))
        left = rest
    return order, np.array(shapes), np.array(gains)


def is_driven(pole: np.ndarray, span: float, others: np.ndarray) -> np.ndarray:
    """Whether each `pole` (k,) stays as it is over `span` s while some of the `others` dies."""
    dies = (-others.real * span).max(initial=0.0) > DYING
    return (-pole.real * span < STEADY) & dies
