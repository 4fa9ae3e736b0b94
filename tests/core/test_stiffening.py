import numpy as np
import pytest

from core.data import Load, Material
from core.elasticity import Seat, add_loads, assemble, hold_points
from core.elements import ELEMENTS
from core.modes import solve_modes
from core.refine import refine
from core.stiffening import converged_eigenvalues, moved, nested_interpolation, stiffening
from tests.core.solids import block

SIZE = (0.6, 0.1, 0.15)
MESH = block((5, 2, 2), SIZE, jitter=0.2)


def builder(nu):
    def build(mesh, element):
        model = assemble(mesh, Material(1000.0, nu), element)
        return hold_points(model, np.flatnonzero(model.points[:, 0] < 1e-12))

    return build


def squares(model, count):
    return (2 * np.pi * solve_modes(model, count).frequency) ** 2


@pytest.fixture(scope="module")
def truth():
    """Lowest four eigenvalues on a mesh 64 times finer, by Poisson's ratio."""
    fine = refine(refine(MESH))
    return {nu: squares(builder(nu)(fine, "p2"), 4) for nu in (0.3, 0.47)}


@pytest.mark.parametrize("nu", [0.3, 0.47])
def test_the_converged_eigenvalues_hold_the_finely_refined_ones_in_their_error(nu, truth):
    found = converged_eigenvalues(builder(nu), MESH, 4)
    assert (np.abs(found.values[:4] - truth[nu]) < 2.5 * found.sigma[:4]).all()
    assert (found.sigma[:4] < 0.04 * truth[nu]).all()


def test_a_rim_of_pins_through_triangles_is_met_by_the_finer_element():
    def build(mesh, element):
        model = assemble(mesh, Material(1000.0, 0.3), element)
        return hold_points(model, np.flatnonzero(model.points[:, 0] < 0.15 + 1e-9))

    along = squares(build(block((24, 3, 4), SIZE), "p2"), 2)  # its cells end where the pins do
    for counts in ((7, 2, 2), (11, 2, 3)):
        across = block(counts, SIZE, jitter=0.25)
        coarse = squares(build(across, "p2"), 2) / along - 1
        limit = converged_eigenvalues(build, across, 2).values[:2] / along - 1
        assert np.abs(coarse).min() > 0.04
        assert np.abs(limit).max() < 0.02


@pytest.mark.parametrize("element", ELEMENTS)
def test_stiffening_is_the_excess_over_a_much_finer_mesh(element, truth):
    build = builder(0.47)
    model = build(MESH, element)
    modes = solve_modes(model, 2)
    ratio, sigma = stiffening(model, modes, converged_eigenvalues(build, MESH, 2))
    limit = squares(model, 2) / (1 + ratio)  # sorted: locked bending may come after torsion
    error = limit * sigma / (1 + ratio)
    assert (np.abs(np.sort(limit) - truth[0.47][:2]) < 3 * error).all()


def test_material_stiffness_stays_within_2_percent_while_the_apparent_one_moves_by_more_than_10():
    measured = 0.05  # any frequency, Hz: both moduli scale with its square
    apparent, material = [], []
    for n in (1, 2, 3):
        mesh = block((4 * n, n, n + 1), SIZE, jitter=0.15)
        build = builder(0.45)
        model = build(mesh, "p1_smoothed" if n == 1 else "p1")
        modes = solve_modes(model, 1)
        ratio, _ = stiffening(model, modes, converged_eigenvalues(build, mesh, 1))
        apparent.append((measured / modes.frequency[0]) ** 2)
        material.append(apparent[-1] * (1 + ratio[0]))
    assert np.ptp(material) < 0.02 * np.mean(material)
    assert np.ptp(apparent) > 0.1 * np.mean(apparent)


def test_the_two_level_correction_finds_what_the_direct_solution_finds(monkeypatch):
    mesh = block((6, 2, 2), SIZE, jitter=0.2)
    direct = converged_eigenvalues(builder(0.45), mesh, 4)
    monkeypatch.setattr("core.stiffening.DIRECT", 0)
    steps = converged_eigenvalues(builder(0.45), mesh, 4)
    gap = np.abs(steps.values[:4] - direct.values[:4])
    assert (gap > 0).any()
    assert (gap < 0.5 * direct.sigma[:4]).all()


def test_a_free_body_converges_too(monkeypatch):
    def build(mesh, element):
        return assemble(mesh, Material(1000.0, 0.3), element)

    mesh = block((3, 1, 1), SIZE)
    monkeypatch.setattr("core.stiffening.DIRECT", 0)
    found = converged_eigenvalues(build, mesh, 8)
    truth = squares(build(refine(refine(mesh)), "p2"), 8)
    assert (np.abs(found.values[:6]) < 1e-4 * truth[6]).all()
    assert (np.abs(found.values[6:8] - truth[6:]) < 3 * found.sigma[6:8]).all()


def test_quadratic_fields_pass_unchanged_to_the_cubic_points():
    mesh = block((3, 2, 2), SIZE, jitter=0.2)
    coarse, fine = (builder(0.3)(mesh, e) for e in ("p2", "p3"))

    def field(x):
        return np.column_stack([x[:, 0] * x[:, 1], x[:, 2] ** 2 - x[:, 0], x[:, 1] * x[:, 2]])

    got = nested_interpolation(coarse, fine) @ field(coarse.points).ravel()
    assert got.reshape(-1, 3) == pytest.approx(field(fine.points), abs=1e-12)


def test_a_lumped_mass_has_pitches_that_converge_on_any_mesh():
    """On a point they would not: there the body gives way without limit (Johnson, ch. 3)."""
    load = (Load(3.0, np.array([0.6, 0.1, 0.15])),)

    def build(mesh, element):
        return add_loads(builder(0.45)(mesh, element), load)

    coarse, fine = (converged_eigenvalues(build, mesh, 3) for mesh in (MESH, refine(MESH)))
    assert fine.values[:3] == pytest.approx(coarse.values[:3], rel=0.04)
    assert (fine.sigma[:3] < 0.02 * fine.values[:3]).all()


def test_half_the_width_of_a_lump_moves_no_pitch_without_one_and_some_with_it():
    plain = builder(0.45)(MESH, "p2")
    loaded, narrow = (
        add_loads(plain, (Load(3.0, np.array([0.6, 0.1, 0.15])),), Seat(width, True))
        for width in (1.0, 0.5)
    )
    assert moved(plain, solve_modes(plain, 4), plain) == pytest.approx(0, abs=1e-6)
    change = moved(loaded, solve_modes(loaded, 4), narrow)
    assert 1e-4 < change.max() < 0.5
