"""Young's modulus from a measured pitch."""

import numpy as np
import pytest

from core.dac import apparent, material, scattered, youngs_modulus
from core.data import Material
from core.elasticity import assemble, hold_points
from core.modes import solve_modes
from tests.core.solids import block


@pytest.fixture(scope="module")
def beam():
    model = assemble(block((8, 2, 2), (0.1, 0.02, 0.03)), Material(1000.0, 0.4), "p2")
    return hold_points(model, np.flatnonzero(model.points[:, 0] < 1e-9))


def test_with_the_apparent_modulus_the_mesh_rings_as_measured(beam):
    own = solve_modes(beam, 3).frequency
    young = youngs_modulus(7.74, own[0])
    assert abs(own[0] * np.sqrt(young) / 7.74 - 1) < 1e-9


def test_the_interval_holds_the_frequencys():
    found = apparent(8.0, 0.04, 2e-3)
    assert found.low < found.value < found.high
    assert abs((found.high - found.value) / found.value - 2 * 1.96 * 0.04 / 8.0) < 2e-4


def test_the_meshs_own_stiffening_is_taken_out_with_its_error():
    found = apparent(8.0, 0.0, 2e-3)
    real = material(found, 0.18, 0.01)
    assert abs(real.value / found.value - 1.18) < 1e-12
    assert abs((real.high - real.low) / 2 / real.value - 1.96 * 0.01 / 1.18) < 1e-4


def test_other_modes_tell_how_sure_a_modulus_is_and_one_matched_wrongly_does_not():
    rng, inside, noise = np.random.default_rng(4), [], np.full(5, 0.002)
    for _ in range(500):
        moduli = np.exp(0.01 * rng.standard_normal(5))
        moduli[4] = rng.uniform(0.5, 2.0)
        inside.append(abs(np.log(moduli[0])) < 1.96 * scattered(moduli, noise, 0))
    assert 0.85 < np.mean(inside) < 0.99
    alone = scattered(np.array([1.0]), noise[:1], 0)
    assert alone == pytest.approx(0.005)  # nothing tells
    apart = np.array([1.0, 1.03, 1.03])
    assert scattered(np.ones(5), noise, 3) < alone < scattered(apart, noise[:3], 0)
    assert scattered(apart, np.array([0.0, 0.05, 0.05]), 0) < alone  # it is but their noise
