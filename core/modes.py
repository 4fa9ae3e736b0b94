"""Free vibration."""

import numpy as np

from .data import ElasticModel, Modes
from .eigen import lowest_eigenpairs
from .elasticity import loose_motions
from .errors import DataError


def solve_modes(model: ElasticModel, count: int) -> Modes:
    """Lowest `count` modes of K x = ω² M x over the free dofs, xᵀ M x = 1, f = ω/2π, at Y = 1 Pa.

    Multiply the frequencies by √Y. A free body's six rigid motions come out as near zeros.
    Raises DataError when more modes are asked than there are free dofs.
    """
    free = model.free
    if not 0 < count < free.size:
        raise DataError(f"solve_modes: {count} modes asked of a model with {free.size} free dofs.")
    K, M = model.stiffness[free][:, free], model.mass[free][:, free]
    places = np.repeat(model.points, 3, axis=0)[free]
    repeats = 8 if loose_motions(model) else 4
    omega2, x = lowest_eigenpairs(K, M, count, places, multiplicity=repeats)
    shapes = np.zeros((3 * len(model.points), count))
    shapes[free] = x
    frequency = np.sqrt(np.clip(omega2, 0, None)) / (2 * np.pi)
    return Modes(frequency, shapes.reshape(-1, 3, count))
