import numpy as np
import pytest
from scipy.linalg import eigh

from core.data import Material
from core.eigenfit import fit_eigenvalues, fitted_solver
from core.elasticity import assemble, hold_points
from core.errors import DataError
from core.modes import solve_modes
from core.stiffening import converged_eigenvalues
from tests.core.solids import block


def build(mesh, element):
    model = assemble(mesh, Material(1000.0, 0.47), element)
    return hold_points(model, np.flatnonzero(model.points[:, 0] == 0))


MESH = block((5, 2, 2), (0.5, 0.1, 0.12), jitter=0.2)
MODEL = build(MESH, "p1")
MODES = solve_modes(MODEL, 14)
OWN = (2 * np.pi * MODES.frequency) ** 2


@pytest.fixture(scope="module")
def wanted():
    """Ten eigenvalues of the same body, mesh-converged."""
    return converged_eigenvalues(build, MESH, 10).values[:10]


def test_the_first_ten_are_exact_and_the_others_untouched(wanted):
    fit = fit_eigenvalues(MODEL, MODES, wanted)
    K = fit.stiffness_times(np.eye(3 * len(MODEL.points)))
    free = MODEL.free
    got = eigh(K[np.ix_(free, free)], MODEL.mass[free][:, free].toarray(), eigvals_only=True)
    others = np.sort(np.concatenate([wanted, OWN[10:]]))
    assert wanted[0] < 0.6 * OWN[0]
    assert got[:12] == pytest.approx(others[:12], rel=1e-8)


def test_a_time_integration_of_the_coarse_mesh_rings_at_the_ten_given_frequencies(wanted):
    fit = fit_eigenvalues(MODEL, MODES, wanted)
    h = 2 * np.pi / np.sqrt(wanted[9]) / 8
    solve = fitted_solver(fit, 1.0, h**2 / 4)
    start = np.linspace(1, 2, 10)
    u = MODES.shapes[:, :, :10].reshape(-1, 10) @ start
    v, seen = np.zeros_like(u), []
    for _ in range(200):  # trapezoidal rule; its phase per step is 2 atan(ω h / 2) exactly
        r = MODEL.mass @ v - h * fit.stiffness_times(u + h / 4 * v)
        w = solve(r)
        u, v = u + h / 2 * (v + w), w
        seen.append(fit.factors.T @ u / start)
    phase = 2 * np.arctan(np.sqrt(wanted) * h / 2)
    exact = np.cos(np.outer(np.arange(1, 201), phase))
    assert np.array(seen) == pytest.approx(exact, abs=1e-6)


def test_measured_values_move_only_as_many_modes_as_were_measured():
    fit = fit_eigenvalues(MODEL, MODES, OWN[:2] * 0.8, "measured")
    third = MODES.shapes[:, :, 2].ravel()
    assert fit.source == "measured"
    assert fit.stiffness_times(third) == pytest.approx(MODEL.stiffness @ third, abs=1e-9)
    first = MODES.shapes[:, :, 0].ravel()
    assert first @ fit.stiffness_times(first) == pytest.approx(0.8 * OWN[0], rel=1e-9)


def test_values_that_cannot_be_are_refused():
    with pytest.raises(DataError, match="Solve for more modes"):
        fit_eigenvalues(MODEL, MODES, np.ones(15))
    with pytest.raises(DataError, match="all above 0"):
        fit_eigenvalues(MODEL, MODES, np.array([1.0, -1.0]))
    with pytest.raises(DataError, match="source"):
        fit_eigenvalues(MODEL, MODES, OWN[:2], "guessed")
