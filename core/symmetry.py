"""Whether a body has pairs of modes by its symmetry, not two modes that happen to lie close."""

import numpy as np

from .data import ElasticModel
from .elasticity import surface_quadrature

EVEN = 0.05  # relative, of two second moments: two pitches as far apart still are a pair's
CENTRED = 0.1  # of the radius of gyration, that the pins may be off the axis
ROUND = 0.2  # relative, of the second moments of the pins, which are cut as the mesh is


def unevenness(model: ElasticModel) -> float:
    """How much wider, relatively in second moments, a held body is one way than the other across
    a line through its pins; infinite where it has no such line, or its pins are uneven there.

    Nought for every body that a turn by less than half a circle brings to itself: its bending
    modes come in pairs of one pitch (Perrin and Charnley, J. Sound Vib. 29, 1973), and a bar's
    pitch goes with the root of the moment. Second moments are exact for any element: they are
    those of the mass matrix on linear fields.
    """
    mass = model.mass[::3, ::3]
    share = np.asarray(mass.sum(axis=0)).ravel()
    away = model.points - share @ model.points / share.sum()
    moment, axes = np.linalg.eigh(away.T @ (mass @ away) / share.sum())
    pins, weight = _held(model, away)
    centre = weight @ pins / weight.sum()
    spread = (pins - centre).T @ ((pins - centre) * weight[:, None]) / weight.sum()
    best = np.inf
    for one, two, axis in ((0, 1, 2), (1, 2, 0)):
        off = centre - (centre @ axes[:, axis]) * axes[:, axis]
        ball = np.ptp(moment) <= EVEN * moment[0]  # any line is an axis
        line = centre if ball and centre @ centre > 0 else axes[:, axis]
        if not ball and off @ off > CENTRED**2 * moment.sum():
            continue
        least, most = _across(spread, line)
        if most <= (1 + ROUND) * least or most <= ROUND**2 * moment[two]:
            best = min(best, moment[two] / moment[one] - 1)
    return float(best)


def _held(model: ElasticModel, away: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) where the body is held, of its points' places `away`, and (n,) how much of it there.

    A patch counts by its area, however it is meshed; else points do; the middle where none is held.
    """
    operator, _, areas = surface_quadrature(model)
    loose = np.asarray(abs(operator[:, model.free]).sum(axis=1)).reshape(-1, 3).sum(axis=1)
    if (loose == 0).any():
        places = (operator @ away.ravel()).reshape(-1, 3)
        return places[loose == 0], areas[loose == 0]
    points = away[model.pinned] if model.pinned.any() else np.zeros((1, 3))
    return points, np.ones(len(points))


def _across(spread: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(2,) second moments across `line`, the lesser first, of those along the axes (3, 3)."""
    _, _, rows = np.linalg.svd(line[None])
    return np.linalg.eigvalsh(rows[1:] @ spread @ rows[1:].T)


def is_even(model: ElasticModel) -> bool:
    """Whether a pair of its modes is one by the body's symmetry, or nearly."""
    return unevenness(model) < EVEN
