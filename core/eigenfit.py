"""A coarse mesh whose first modes take given eigenvalues; its other modes, and all shapes, stay.

K' = K + M Φ diag(λ* - λ) Φᵀ M, Φᵀ M Φ = I: a change of rank m, never multiplied out. With the
mesh-converged eigenvalues for λ* a dynamic simulation of the coarse mesh rings as the fine one
would; with the measured ones it rings as the object did. The two answer different questions and
are kept apart by `source`.

Source      Chen, Levin, Kaufman, Ascher, Pai, EigenFit for consistent elastodynamic simulation
            across mesh resolution, SCA 2019
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .data import ElasticModel, Modes, seal
from .errors import DataError
from .factorization import factorize


@dataclass(frozen=True, eq=False)
class EigenFit:
    """A body and the low-rank change of its stiffness, all at the modulus of the given modes."""

    model: ElasticModel
    factors: np.ndarray  # (3P, m) kg^1/2, M Φ
    change: np.ndarray  # (m,) 1/s2, λ* - λ
    source: str  # "converged" | "measured"

    def __post_init__(self):
        seal(self, "factors", float, (3 * len(self.model.points), None))
        seal(self, "change", float, (self.factors.shape[1],))
        if self.source not in ("converged", "measured"):
            raise DataError(
                f'EigenFit.source: "{self.source}"; "converged" or "measured" is needed.'
            )

    def stiffness_times(self, u: np.ndarray) -> np.ndarray:
        """K' u (3P,) or (3P, k)."""
        low = self.factors.T @ u
        return self.model.stiffness @ u + self.factors @ (self.change * low.T).T


def fit_eigenvalues(
    model: ElasticModel, modes: Modes, values: np.ndarray, source: str = "converged"
) -> EigenFit:
    """The change that gives the first len(values) of the model's `modes` the eigenvalues `values`.

    `values` (m,) 1/s2 at the modulus of `modes`. Raises DataError when there are more values than
    modes, or one is not positive (the body would have no rest).
    """
    values = np.asarray(values, float)
    m = len(values)
    if not 0 < m <= len(modes.frequency) or not (values > 0).all():
        raise DataError(
            f"fit_eigenvalues: {m} values for {len(modes.frequency)} modes; at least one and no "
            "more than there are modes, all above 0, are needed. Solve for more modes."
        )
    shapes = modes.shapes[:, :, :m].reshape(-1, m)
    change = values - (2 * np.pi * modes.frequency[:m]) ** 2
    return EigenFit(model, model.mass @ shapes, change, source)


def fitted_solver(
    fit: EigenFit, mass_factor: float, stiffness_factor: float
) -> Callable[[np.ndarray], np.ndarray]:
    """x (3P,) of (a M + b K') x = r on the free dofs, zero on the held ones, by Woodbury.

    One sparse factorization of a M + b K serves every step of an implicit time integration.
    Raises DataError when the fitted system has no solution (b λ* = -a M for one mode).
    """
    free = fit.model.free
    A = mass_factor * fit.model.mass + stiffness_factor * fit.model.stiffness
    factor = factorize(A[free][:, free], np.repeat(fit.model.points, 3, axis=0)[free])
    U = fit.factors[free]
    AU = factor.solve(U)
    small = np.eye(len(fit.change)) + (stiffness_factor * fit.change)[:, None] * (U.T @ AU)
    if np.linalg.cond(small) > 1e13:
        raise DataError("fitted_solver: the fitted system is singular. Change the time step.")

    def solve(r: np.ndarray) -> np.ndarray:
        y = factor.solve(r[free])
        x = np.zeros(len(r))
        x[free] = y - AU @ np.linalg.solve(small, stiffness_factor * fit.change * (U.T @ y))
        return x

    return solve
