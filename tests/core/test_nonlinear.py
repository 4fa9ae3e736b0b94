from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from core.data import Material
from core.elasticity import assemble, geometric_stiffness, gravity_force, hold_points, static
from core.errors import DataError
from core.modes import solve_modes
from core.nonlinear import (
    _line_search,
    at_equilibrium,
    elastic_energy,
    equilibrium,
    forces_and_tangent,
    strain_points,
)
from tests.core.solids import block

JELLY = Material(1000.0, 0.45)
SOFT = ("p1", "p1_smoothed", "p2")


def body(element, counts=(6, 2, 2), size=(0.12, 0.03, 0.03), material=JELLY):
    model = assemble(block(counts, size, jitter=0.1), material, element)
    return hold_points(model, np.flatnonzero(model.points[:, 0] == 0))


@pytest.mark.parametrize("element", SOFT)
def test_force_is_the_slope_of_energy_and_the_tangent_that_of_the_force(element):
    model = body(element, (2, 1, 1))
    parts, moduli = strain_points(model), (1.0, 3.0)
    rng = np.random.default_rng(0)
    u, d = (0.003 * rng.standard_normal(model.points.size) for _ in range(2))
    h = 1e-4
    force, K = forces_and_tangent(parts, moduli, u)
    up, down = u + h * d, u - h * d
    slope = (elastic_energy(parts, moduli, up) - elastic_energy(parts, moduli, down)) / (2 * h)
    assert slope == pytest.approx(force @ d, rel=1e-6)
    bend = forces_and_tangent(parts, moduli, up)[0] - forces_and_tangent(parts, moduli, down)[0]
    assert bend / (2 * h) == pytest.approx(K @ d, rel=1e-5, abs=1e-8 * np.abs(K @ d).max())


@pytest.mark.parametrize("element", SOFT)
def test_about_rest_the_tangent_is_the_linear_stiffness(element):
    model = body(element)
    nu = model.material.poisson_ratio
    moduli = 1 / (2 * (1 + nu)), 1 / (3 * (1 - 2 * nu))
    force, K = forces_and_tangent(strain_points(model), moduli, np.zeros(model.points.size))
    assert np.abs(force).max() < 1e-15
    assert abs(K - model.stiffness).max() < 1e-12 * abs(K).max()


def test_a_turned_body_has_no_energy_and_no_force():
    model = body("p2")
    angle = 1.2
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    u = (model.points @ turn.T - model.points).ravel()
    parts = strain_points(model)
    assert abs(elastic_energy(parts, (1.0, 5.0), u)) < 1e-15
    assert np.abs(forces_and_tangent(parts, (1.0, 5.0), u)[0]).max() < 1e-13


@pytest.mark.parametrize("element", SOFT)
def test_a_small_load_gives_the_linear_displacement(element):
    model = body(element)
    force = 1e-4 * gravity_force(model, (0, 0, -9.81))
    rest = equilibrium(model, force, 2e4)
    linear = static(model, force, 2e4)
    assert np.abs(rest.displacement - linear).max() < 1e-3 * np.abs(linear).max()


def test_a_stretched_column_follows_the_uniaxial_law():
    model = assemble(block((6, 2, 2), (0.3, 0.1, 0.1)), Material(1.0, 0.4), "p2")
    ends = np.isclose(model.points[:, 0], 0.3)
    x, y, z = model.points.T
    roller = hold_points(model, np.flatnonzero((x == 0) & (y == 0) & (z == 0)))
    Y, stretch = 100.0, 1.3
    mu, kappa = Y / 2.8, Y / 0.6

    def stress(b, along):  # first Piola stress for stretches (along, b, b)
        J = along * b * b
        size = along**2 + 2 * b**2
        iso = mu * J ** (-2 / 3)
        return (
            iso * (along - size / (3 * along)) + kappa * (J - 1) * J / along,
            iso * (b - size / (3 * b)) + kappa * (J - 1) * J / b,
        )

    side = brentq(lambda b: stress(b, stretch)[1], 0.5, 1.2)
    u = (model.points * (np.array([stretch, side, side]) - 1)).ravel()
    nu = 0.4
    moduli = Y / (2 * (1 + nu)), Y / (3 * (1 - 2 * nu))
    force, _ = forces_and_tangent(strain_points(roller), moduli, u)
    pull = force.reshape(-1, 3)[ends, 0].sum()
    assert pull == pytest.approx(stress(side, stretch)[0] * 0.01, rel=1e-9)
    inner = ~ends & (x != 0)
    assert np.abs(force.reshape(-1, 3)[inner]).max() < 1e-10


def test_under_a_heavy_load_the_rest_is_stable_and_sags_less_than_linearly():
    model = body("p1_smoothed", (10, 2, 2), (0.2, 0.03, 0.03))
    force = gravity_force(model, (0, 0, -9.81))
    rest, linear = equilibrium(model, force, 1.2e5), static(model, force, 1.2e5)
    tip = np.abs(rest.displacement[:, 2]).max()
    assert np.abs(linear[:, 2]).max() > 0.1  # half of its length: far beyond small
    assert 0.2 * np.abs(linear[:, 2]).max() < tip < 0.9 * np.abs(linear[:, 2]).max()
    free = model.free
    assert np.linalg.eigvalsh(rest.stiffness[free][:, free].toarray())[0] > 0


def test_a_hanging_column_stiffens_as_its_initial_stress_says():
    model, Y = body("p2", (8, 1, 1), (0.2, 0.02, 0.02)), 2e6
    force = gravity_force(model, (9.81, 0, 0))
    about = at_equilibrium(model, equilibrium(model, force, Y), Y)
    stress = geometric_stiffness(model, static(model, force, Y))
    linear = at_equilibrium(model, equilibrium(model, 0 * force, Y), Y)
    share = 2 * (1 + model.material.poisson_ratio)
    f = solve_modes(linear, 1).frequency[0]
    shift = solve_modes(about, 1).frequency[0] / f - 1
    expected = replace(linear, shear=linear.shear + share * stress)
    law = solve_modes(expected, 1).frequency[0] / f - 1
    assert shift > 0
    assert shift == pytest.approx(law, rel=0.15)


def test_a_free_body_and_a_discontinuous_element_are_refused():
    model = assemble(block((1, 1, 1), (1, 1, 1)), JELLY, "p1")
    with pytest.raises(DataError, match="free to move"):
        equilibrium(model, np.zeros(24), 1.0)
    with pytest.raises(DataError, match="no nonlinear form"):
        equilibrium(body("dg"), np.zeros(len(body("dg").points) * 3), 1.0)


def test_a_step_that_the_energy_is_too_unsure_to_judge_is_taken_whole():
    """Near the rest it falls by less than its last digits, which differ between processors."""
    u, move, rounding = np.array([1e-9]), np.array([-1e-9]), 1e-15

    def total(v):
        return 0.5 * float(v @ v) + rounding * float(v[0] != u[0])

    with pytest.raises(DataError, match="no step lowers"):
        _line_search(total, u, move, 1e-18, 0.0)
    assert _line_search(total, u, move, 1e-18, 4 * rounding) == 1.0
