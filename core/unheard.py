"""Modes of the body that the harmonic inversion did not hear, as poles to be tried."""

import numpy as np

from .baseline import real_shapes
from .body import Body
from .data import RingDown, poles
from .effects.aliasing import is_folded, unfolded
from .harmonic_inversion import invert
from .law import TimeFit
from .match import PAIR, Match, likeness
from .pursuit import HEARD, is_driven
from .residual import QUIET

LIVELY = 0.25  # damping ratio up to which a weak pole may be a mode
PARTED = 0.003  # relative, from which two computed modes are no pair by the body's symmetry
LONGER = 1.1  # times as fast, at most, that what lives as long as another pole dies
NEIGHBOUR = 1.5  # times the strongest mode's pitch, within which another one may go unheard


def rest_of(found: TimeFit) -> RingDown | None:
    """The ring-down of what the fit leaves of the first fitted take; None where that is noise."""
    if found.chi2 < QUIET * found.samples:
        return None
    data = found.law.takes[found.law.fitted[0]]
    left, on = found.missed(0)[data.fit], ~data.support
    return invert(data.time[data.fit], left[:, on], noise=data.sigma[on], max_modes=6)


def weak_modes(
    found: TimeFit, rest: RingDown, body: Body, match: Match, alike: float
) -> tuple[RingDown, Match, np.ndarray] | None:
    """The poles with those that only the residual shows, where they are modes of the body, and the
    pitches (q,) Hz of the other ones that ring.

    A weak mode hides behind strong ones until those are taken off; it counts when its pitch and
    its shape in the `rest` are those of a computed mode that was not matched yet; `alike`: how
    nearly. What may as well be the fold of one above half the frame rate does not. Their amplitudes
    are yet to be fitted.
    """
    law = found.law
    data = law.takes[law.fitted[0]]
    on, rate = ~data.support, 1 / data.frame
    scale = found.frequency[0] / body.modes.frequency[match.modes[0]]
    seen, frequency = body.seen(data), body.modes.frequency * scale
    new_f, new_z, modes = list(found.frequency), list(found.damping_ratio), list(match.modes)
    own, pole = (poles(one.frequency, one.damping_ratio) for one in (found, rest))
    driven = is_driven(pole, np.ptp(data.time[data.fit]), own)
    turning = found.frequency[list(law.turning)]  # there the pair's other direction is in the fit
    known = (np.abs(np.log(rest.frequency[:, None] / turning)) < 2 * PAIR).any(axis=1)
    able = np.flatnonzero(~driven & ~known & (rest.damping_ratio < LIVELY))
    for k in able:
        amplitude = rest.amplitude[k]
        shape = np.zeros(len(on))
        shape[on] = real_shapes(amplitude[None])[0][0]
        f, z = rest.frequency[k], rest.damping_ratio[k]
        alikes = [likeness(shape, seen, frequency, j) for j in range(len(frequency))]
        fits = [
            (alikes[j] - 2 * abs(np.log(f / frequency[j])), j)
            for j in range(len(frequency))
            if all(m != j and abs(frequency[m] / frequency[j] - 1) > PAIR for m in modes)
        ]
        quality, j = max(fits, default=(0.0, None))
        folds = (
            alikes[j] - 2 * abs(np.log(unfolded(f, frequency[j], rate) / frequency[j]))
            for j in range(len(frequency))
            if is_folded(f, frequency[j], rate)
        )
        if quality > alike and quality > max(folds, default=-np.inf):
            new_f, new_z, modes = [*new_f, f], [*new_z, z], [*modes, j]
    if len(modes) == len(match.modes):
        return None
    wider = Match(match.poles + match.poles[:1] * (len(modes) - len(match.modes)), tuple(modes))
    return bare(new_f, new_z, data.sigma), wider, np.setdiff1d(rest.frequency[able], new_f)


def neighbours(found: TimeFit, heard: RingDown, match: Match, body: Body):
    """The poles with that of a computed mode beside the strongest one, the match of both, and what
    ties them, as `Law.tied`, one after another. The other direction of a pair, which only meshing
    may have parted, is none.

    Two modes that lie close together sound as one while something bends their pitches. A pole that
    was `heard` there, lives about as long and was not matched may be the strongest mode itself, and
    the one that was matched to it the other mode.
    """
    frequency = body.modes.frequency
    ratio = frequency / frequency[match.modes[0]]
    apart = np.abs(np.log(frequency[:, None] / frequency[list(match.modes)])).min(axis=1)
    apart = np.where(apart < PAIR, np.minimum(apart, body.parts), apart)
    data = found.law.takes[found.law.fitted[0]]
    f, z, first = found.frequency, found.damping_ratio, match.poles[0]
    own = heard.frequency[first], heard.damping_ratio[first]
    longer = _longer_lived(heard, match, data)
    for j in np.flatnonzero((np.abs(np.log(ratio)) < np.log(NEIGHBOUR)) & (apart > PARTED)):
        modes = (*match.modes, int(j))
        ring = bare(np.r_[f, f[0] * ratio[j]], np.r_[z, z[0]], data.sigma)
        yield ring, Match((*match.poles, first), modes), ((len(f), float(np.log(ratio[j]))),)
        for k in longer:
            other = np.r_[heard.frequency[k], f[1:], own[0]]
            ring = bare(other, np.r_[heard.damping_ratio[k], z[1:], own[1]], data.sigma)
            yield ring, Match((int(k), *match.poles[1:], first), modes), ()


def _longer_lived(heard: RingDown, match: Match, data) -> np.ndarray:
    """Which poles beside the strongest one were not matched and die, but about as late as that or
    later, and are not faint.
    """
    first, pole = match.poles[0], poles(heard.frequency, heard.damping_ratio)
    able = np.abs(np.log(heard.frequency / heard.frequency[first])) < np.log(NEIGHBOUR)
    able &= pole.real > LONGER * pole.real[first]
    able[list(match.poles)] = False
    able &= ~is_driven(pole, np.ptp(data.time[data.fit]), pole[[first]])
    size = np.linalg.norm(heard.amplitude / heard.noise, axis=1)
    return np.flatnonzero(able & (size > HEARD * size[first]))


def bare(frequency, damping_ratio, sigma: np.ndarray) -> RingDown:
    """Poles (m,) whose amplitudes are yet to be fitted."""
    m, C = len(frequency), len(sigma)
    z = np.clip(damping_ratio, 1e-4, 0.85)
    return RingDown(frequency, z, np.zeros((m, C)), np.zeros(C), sigma, np.eye(2 * m))
