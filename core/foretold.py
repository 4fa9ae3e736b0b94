"""How far what a fit foretells may be off by what the part that it has seen cannot tell.

Two pitches that lie too close for the fitted part to tell them apart beat differently later on: a
held-out misfit that is no more than that shows nothing that the model lacks.
Source      Seber and Wild, Nonlinear Regression (1989), 5.1: the spread of a prediction
"""

import numpy as np

from .law import TimeFit
from .linear_part import Solved, solve
from .residual import NOISY, parts
from .timefit import within

STEP = 0.1  # of a standard deviation of each parameter, by which it is moved


def doubt(found: TimeFit) -> float:
    """Misfit, in noise squared, that the held-out samples may have beside their own noise, because
    the numbers that foretell them were fitted to others that are noisy; as much as that noise at
    most, for more is no small change.

    None where whole takes are held out, whose start is fitted to them; where forces act, for what
    they do later may turn on anything; and where the fitted part is not told to its noise.
    """
    law = found.law
    whole = any(data.take.held_out for data in law.takes)
    marched = any(effect.marched for effect in law.effects)
    if whole or marched or found.chi2 > NOISY * found.samples:
        return 0.0
    spread = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    able = spread > 0
    moved = found.parameters + np.vstack([0 * found.parameters, STEP * np.diag(spread)[able]])
    solved = solve(law, within(law, moved))
    alike = found.covariance[np.ix_(able, able)] / np.outer(spread[able], spread[able])
    held, total = parts(law.takes, True), 0.0
    for take, index in enumerate(law.fitted):
        out = _foretold(solved, take)[:, held[index]]
        sigma = np.broadcast_to(law.takes[index].sigma, held[index].shape)[held[index]]
        change = (out[1:] - out[0]) / (STEP * sigma)
        total += float(np.einsum("in,ij,jn->", change, alike, change, optimize=True))
        total += _of_shapes(solved, take, held[index])
    return min(total, sum(int(own.sum()) for own in held)) if np.isfinite(total) else 0.0


def _foretold(solved: Solved, take: int) -> np.ndarray:
    """(B, T, C) of a fitted take."""
    return np.swapaxes((solved.bases[take] @ solved.coefficients[..., None])[..., 0], 1, 2)


def _of_shapes(solved: Solved, take: int, held: np.ndarray) -> float:
    """What shapes and offsets that are uncertain add, in noise squared: the samples' leverage."""
    basis, use, total = solved.bases[take][0], solved.uses[take], 0.0
    for channel in np.flatnonzero(held.any(axis=0)):
        own = basis[min(channel, len(basis) - 1)]
        own = own[:, ~solved.barred[channel]]
        seen = own[use[:, channel]]
        size = np.linalg.norm(seen, axis=0)
        own, seen = own[:, size > 0] / size[size > 0], seen[:, size > 0] / size[size > 0]
        inverse = np.linalg.pinv(seen.T @ seen, rcond=1e-10, hermitian=True)
        later = own[held[:, channel]]
        total += float(np.einsum("ti,ij,tj->", later, inverse, later))
    return total
