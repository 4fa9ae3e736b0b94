from dataclasses import replace

import numpy as np
import pytest

from core.data import Material
from core.eigen import lowest_eigenpairs
from core.elasticity import assemble, hold_points
from core.errors import DataError
from core.modes import solve_modes
from tests.core.solids import block


def clamped(counts, size, material, element="p2"):
    model = assemble(block(counts, size), material, element)
    return hold_points(model, np.flatnonzero(model.points[:, 0] == 0))


def test_a_clamped_bar_rings_at_a_quarter_wave_from_above_as_h_squared():
    length, excess = 0.5, []
    exact = np.sqrt(1 / 1000.0) / (4 * length)
    for n in (4, 8):
        bar = clamped((n, 1, 1), (length, 0.02, 0.02), Material(1000.0, 0.0), "p1")
        x = bar.free[bar.free % 3 == 0]  # only x is free
        square, _ = lowest_eigenpairs(bar.stiffness[x][:, x], bar.mass[x][:, x], 1)
        excess.append(np.sqrt(square[0]) / (2 * np.pi) / exact - 1)
    assert excess[1] > 0
    assert excess[0] / excess[1] == pytest.approx(4, rel=0.05)
    assert excess[1] == pytest.approx((np.pi / 16) ** 2 / 24, rel=0.05)


def test_a_slender_clamped_beam_follows_euler_and_bernoulli_for_three_modes():
    length, height = 1.0, 0.02
    beam = clamped((40, 1, 1), (length, 2 * height, height), Material(1000.0, 0.0))
    found = solve_modes(beam, 8)
    vertical = np.abs(found.shapes[:, 2]).max(axis=0) > 2 * np.abs(found.shapes[:, 1]).max(axis=0)
    roots = np.array([1.875104, 4.694091, 7.854757])
    exact = roots**2 / (2 * np.pi * length**2) * height / np.sqrt(12 * 1000.0)
    assert found.frequency[vertical][:3] == pytest.approx(exact, rel=0.01)


def timoshenko(length, height, density, nu):
    """First frequency (Hz) at Y = 1 Pa of a clamped square beam, by Timoshenko's equations.

    Shear coefficient of a rectangle 10 (1 + ν) / (12 + 11 ν) (Cowper 1966).
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    area, inertia = height**2, height**4 / 12
    shear = 10 * (1 + nu) / (12 + 11 * nu) * area / (2 * (1 + nu))

    def gap(omega):
        def rates(_, y):  # w, ψ, moment, force
            w, psi, moment, force = y
            return [
                psi + force / shear,
                moment / inertia,
                -force - density * inertia * omega**2 * psi,
                -density * area * omega**2 * w,
            ]

        ends = [
            solve_ivp(rates, (0, length), start, rtol=1e-9, atol=1e-14).y[2:, -1]
            for start in ([0, 0, 1.0, 0], [0, 0, 0, 1.0])
        ]
        return np.linalg.det(np.array(ends))

    bernoulli = 1.875104**2 / length**2 * np.sqrt(inertia / (density * area))
    return brentq(gap, 0.3 * bernoulli, 1.05 * bernoulli) / (2 * np.pi)


def test_a_stocky_clamped_beam_follows_timoshenko():
    # no lateral contraction: a clamp that hinders it is not in Timoshenko's equations
    beam = clamped((12, 4, 4), (0.3, 0.1, 0.1), Material(1000.0, 0.0))
    exact = timoshenko(0.3, 0.1, 1000.0, 0.0)
    assert solve_modes(beam, 1).frequency[0] == pytest.approx(exact, rel=0.003)
    bernoulli = 1.875104**2 / 0.3**2 * 0.1 / np.sqrt(12 * 1000.0) / (2 * np.pi)
    assert exact < 0.95 * bernoulli


def test_frequencies_are_proportional_to_the_root_of_youngs_modulus():
    beam = clamped((6, 2, 2), (0.3, 0.1, 0.1), Material(1000.0, 0.45))
    stiff = replace(beam, shear=7.0 * beam.shear, bulk=7.0 * beam.bulk)
    got = solve_modes(stiff, 6).frequency
    assert got == pytest.approx(np.sqrt(7) * solve_modes(beam, 6).frequency, rel=1e-11)


def test_modes_solve_the_eigenproblem_and_are_orthonormal_in_the_mass():
    beam = clamped((8, 2, 2), (0.3, 0.1, 0.1), Material(1000.0, 0.49))
    found = solve_modes(beam, 10)
    x = found.shapes.reshape(-1, 10)
    assert x.T @ (beam.mass @ x) == pytest.approx(np.eye(10), abs=1e-9)
    free = beam.free
    left = (beam.stiffness @ x)[free]
    right = (beam.mass @ x)[free] * (2 * np.pi * found.frequency) ** 2
    assert np.abs(left - right).max() < 1e-5 * np.abs(right).max()
    assert not x[np.repeat(beam.pinned, 3)].any()


def test_the_same_model_gives_the_same_bytes():
    beam = clamped((8, 2, 2), (0.3, 0.1, 0.1), Material(1000.0, 0.49))
    one, two = solve_modes(beam, 5), solve_modes(beam, 5)
    assert one.frequency.tobytes() == two.frequency.tobytes()
    assert one.shapes.tobytes() == two.shapes.tobytes()


def test_more_modes_than_free_dofs_are_refused():
    with pytest.raises(DataError, match="free dofs"):
        solve_modes(clamped((1, 1, 1), (1, 1, 1), Material(1.0)), 1000)
