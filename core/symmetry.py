"""Whether a body has pairs of modes by its symmetry, not two modes that happen to lie close."""

import numpy as np

from .data import ElasticModel
from .elasticity import surface_quadrature

EVEN = 0.06  # relative, of second moments: pitches that lie apart by half of it are a pair's
CENTRED = 0.1  # of the radius of gyration, that the pins may be off the axis
POINT = 0.05  # of the body's width: pins that are narrower have no direction


def unevenness(model: ElasticModel) -> float:
    """How much wider, relatively in second moments, a body is one way than the other across a line
    through its pins, and these with it; infinite where there is no such line.

    Nought for every body that a turn by less than half a circle brings to itself: its bending
    modes come in pairs of one pitch (Perrin and Charnley, J. Sound Vib. 31, 1973), and a bar's
    pitch goes with the root of the moment. Second moments are exact for any element: they are
    those of the mass matrix on linear fields.
    """
    mass = model.mass[::3, ::3]
    share = np.asarray(mass.sum(axis=0)).ravel()
    away = model.points - share @ model.points / share.sum()
    moments = away.T @ (mass @ away) / share.sum()
    pins, weight = _held(model, away)
    centre = weight @ pins / weight.sum()
    spread = (pins - centre).T @ ((pins - centre) * weight[:, None]) / weight.sum()
    far = CENTRED * np.sqrt(np.trace(moments))
    size, axes = np.linalg.eigh(moments)
    if np.ptp(size) <= EVEN * size[0]:  # as wide all ways, so that its pins tell the axis
        axes = np.linalg.eigh(spread)[1]
        if np.linalg.norm(centre) > far:
            axes = centre[:, None] / np.linalg.norm(centre)
    best = np.inf
    for line in axes.T:
        least, most = _across(moments, line)
        thin, wide = _across(spread, line)
        patch = wide > POINT**2 * most
        if np.linalg.norm(centre - (centre @ line) * line) <= far:
            own = most / least - 1
            best = min(best, own + (wide / max(thin, 1e-300) - 1 if patch else 0.0))
    return float(best)


def _held(model: ElasticModel, away: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) where the body is held, of its points' places `away`, and (n,) how much of it there.

    A patch counts by its area, however it is meshed; else points do.
    """
    operator, _, areas = surface_quadrature(model)
    loose = np.asarray(abs(operator[:, model.free]).sum(axis=1)).reshape(-1, 3).sum(axis=1)
    if (loose == 0).any():
        places = (operator @ away.ravel()).reshape(-1, 3)
        return places[loose == 0], areas[loose == 0]
    return away[model.pinned], np.ones(model.pinned.sum())


def _across(moments: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(2,) second moments across the unit `line`, the lesser first, of `moments` (3, 3)."""
    _, _, rows = np.linalg.svd(line[None])
    return np.linalg.eigvalsh(rows[1:] @ moments @ rows[1:].T)


def is_even(model: ElasticModel) -> bool:
    """Whether a pair of its modes is one by the body's symmetry, or nearly."""
    return unevenness(model) < EVEN
