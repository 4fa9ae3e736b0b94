"""Poles that the support shows nearly as much as the object: what shakes both, or the camera."""

import numpy as np

from .channels import Channels, axes_of, reaches
from .data import RingDown, poles, replace
from .match import select
from .pursuit import DEAD, is_driven
from .shutter import at_once

SHARED = 0.35  # of a swing, that is left where the support's own is taken off: less is no mode
MOVES = 3.0  # noise, rms, that a marker on the support moves by to tell anything
TWICE = 2  # samples of it per number that is fitted


def without_shared(ring: RingDown, data: Channels) -> RingDown:
    """The ring-down, of the moving channels, without what the support does nearly as much: a camera
    in the hand or a floor that shakes is no mode. The same where no marker tells, or where nothing
    else rings and dies.
    """
    own = _support_at(ring, data)
    if own is None:
        return ring
    on, pole = ~data.support, poles(ring.frequency, ring.damping_ratio)
    seen = at_once(ring.amplitude, pole, None if data.late is None else data.late[:, on])
    own, sigma = own[:, axes_of(data)[on]], data.sigma[on]
    shared = [own * (reach[on] / reach[data.support].mean()) for reach in reaches(data)]
    left = np.min([np.linalg.norm((seen - one) / sigma, axis=1) for one in shared], axis=0)
    body = left > SHARED * np.linalg.norm(seen / sigma, axis=1)
    alive = ring.damping_ratio <= DEAD
    driven = is_driven(pole, np.ptp(data.time[data.fit]), pole[alive])
    if not (body & alive & ~driven).any():
        return ring
    kept, gone = select(ring, np.flatnonzero(body)), ring.frequency[alive & ~body]
    if not len(gone):
        return kept
    told = (
        f"{data.take.name}: the markers on the support swing at "
        f"{', '.join(f'{f:.3g}' for f in gone)} Hz, too: taken for a camera or a support that "
        "shakes, and for no mode of the object. If they are on the object, "
        'write on = "object".'
    )
    return replace(kept, warnings=(*ring.warnings, told))


def _support_at(ring: RingDown, data: Channels) -> np.ndarray | None:
    """(m, axes) how much of every pole the markers on the support show in the mean, at once; None
    where they show nothing but noise, or too little.
    """
    pole, axes = poles(ring.frequency, ring.damping_ratio), axes_of(data)
    amplitude, moves = np.full((len(pole), len(axes)), np.nan, complex), False
    for c in np.flatnonzero(data.support):
        known = data.fit & np.isfinite(data.values[:, c])
        wave = np.exp(np.outer(data.time[known] - ring.t0, pole))
        basis = np.hstack([wave.real, -wave.imag, ring.slow(data.time[known])])
        if len(basis) < TWICE * basis.shape[1]:
            continue
        moves |= data.values[known, c].std() > MOVES * data.sigma[c]
        told = np.linalg.lstsq(basis, data.values[known, c], rcond=None)[0]
        amplitude[:, c] = told[: len(pole)] + 1j * told[len(pole) : 2 * len(pole)]
    amplitude = at_once(amplitude, pole, data.late)
    able = [np.isfinite(amplitude).all(axis=0) & (axes == a) for a in np.unique(axes)]
    if not moves or not len(pole) or not all(one.any() for one in able):
        return None
    return np.array([amplitude[:, one].mean(axis=1) for one in able]).T
