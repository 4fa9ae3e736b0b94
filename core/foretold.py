"""How far what a fit foretells may be off, by what it cannot know of the part that it has seen.

Two pitches that lie too close for the fitted part to tell them apart beat differently later on: a
held-out misfit that is no more than that shows nothing that the model lacks.
Source      Seber and Wild, Nonlinear Regression (1989), 5.1: the spread of a prediction
"""

import numpy as np

from .law import TimeFit
from .linear_part import Solved, solve
from .residual import parts

STEP = 0.1  # of a standard deviation of each parameter, by which it is moved


def doubt(found: TimeFit) -> float:
    """Misfit, in noise squared, that the held-out samples of the fitted takes have beside their
    noise, as that noise and the numbers fitted to the others are uncertain; none where whole takes
    are held out, or forces act.
    """
    law = found.law
    whole = any(data.take.held_out for data in law.takes)
    if whole or any(effect.marched for effect in law.effects):
        return 0.0
    inflation = max(found.chi2 / found.samples, 1.0)
    spread = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    able = spread > 0
    moves = STEP * np.diag(spread)[able]
    solved = solve(law, found.parameters + np.vstack([0 * found.parameters, moves]))
    alike = found.covariance[np.ix_(able, able)] / np.outer(spread[able], spread[able])
    held, total = parts(law.takes, True), 0.0
    for take, index in enumerate(law.fitted):
        out = _foretold(solved, take)[:, held[index]]
        sigma = np.broadcast_to(law.takes[index].sigma, held[index].shape)[held[index]]
        change = (out[1:] - out[0]) / (STEP * sigma)
        total += float(np.einsum("in,ij,jn->", change, alike, change, optimize=True))
        total += _of_shapes(solved, take, held[index])
    return inflation * total


def _foretold(solved: Solved, take: int) -> np.ndarray:
    """(B, T, C) of a fitted take."""
    bases = np.broadcast_to(
        solved.bases[take],
        (len(solved.coefficients), solved.coefficients.shape[1], *solved.bases[take].shape[2:]),
    )
    return np.einsum("bctn,bcn->btc", bases, solved.coefficients, optimize=True)


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
