import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse.linalg import spsolve

from core.boundary import face_points
from core.data import Material, TetMesh
from core.eigen import lowest_eigenpairs
from core.elasticity import assemble, hold_points
from core.elements import ELEMENTS, dg
from core.elements.p2_mixed import nodal_dilatation
from core.elements.simplex import gradients, quadrature
from core.errors import DataError
from core.modes import solve_modes
from tests.core.solids import block

FOAM = Material(60.0, 0.3)
MESH = block((4, 3, 3), (0.4, 0.2, 0.3), jitter=0.3)
every_element = pytest.mark.parametrize("element", ELEMENTS)


def linear_field(points):
    return points @ np.array([[0.1, 0.3, -0.2], [0.0, 0.2, 0.5], [0.4, -0.1, 0.05]])


@every_element
def test_a_linear_field_on_the_skin_is_the_solution_inside(element):
    model = assemble(MESH, FOAM, element)
    exact = linear_field(model.points).ravel()
    skin = np.isin(np.arange(len(model.points)), face_points(model))
    inner, outer = np.flatnonzero(np.repeat(~skin, 3)), np.flatnonzero(np.repeat(skin, 3))
    K = model.stiffness
    got = spsolve(K[inner][:, inner].tocsc(), -K[inner][:, outer] @ exact[outer])
    assert inner.size
    assert got == pytest.approx(exact[inner], abs=1e-11)


@every_element
def test_the_energy_of_a_linear_field_is_its_strain_energy(element):
    model = assemble(MESH, FOAM, element)
    u = linear_field(model.points).ravel()
    strain = (lambda A: (A + A.T) / 2)(linear_field(np.eye(3)))
    deviator = strain - np.trace(strain) / 3 * np.eye(3)
    assert u @ (model.shear @ u) == pytest.approx(2 * np.sum(deviator**2) * MESH.volume)
    assert u @ (model.bulk @ u) == pytest.approx(np.trace(strain) ** 2 * MESH.volume)


@every_element
def test_rigid_motions_carry_no_energy(element):
    model = assemble(MESH, FOAM, element)
    turn = np.cross(model.points - [1.0, 2.0, 3.0], [0.3, -1.0, 0.5])
    force = model.stiffness @ turn.ravel()
    assert np.abs(force).max() < 1e-13 * np.abs(model.stiffness).max() * 10


@every_element
def test_the_mass_matrix_sums_to_the_mass(element):
    model = assemble(MESH, FOAM, element)
    assert model.mass.sum() == pytest.approx(3 * 60.0 * 0.4 * 0.2 * 0.3)


@every_element
def test_the_mass_matrix_knows_the_moment_of_inertia(element):
    model = assemble(MESH, FOAM, element)
    spin = np.cross([0, 0, 1.0], model.points - [0.2, 0.1, 0.15]).ravel()
    exact = 60.0 * 0.4 * 0.2 * 0.3 * (0.4**2 + 0.2**2) / 12
    assert spin @ (model.mass @ spin) == pytest.approx(exact)


@every_element
def test_a_free_body_has_six_zero_modes_and_no_more(element):
    f = solve_modes(assemble(MESH, FOAM, element), 8).frequency
    assert (f[:6] < 1e-5 * f[6]).all()
    assert f[6] > 0


@every_element
def test_stiffness_matrices_are_exactly_symmetric(element):
    model = assemble(MESH, FOAM, element)
    for matrix in (model.shear, model.bulk, model.mass):
        assert abs(matrix - matrix.T).max() <= 1e-15 * abs(matrix).max()


@every_element
def test_a_uniform_scale_of_stiffness_scales_eigenvalues(element):
    model = assemble(MESH, FOAM, element)
    twice = assemble(MESH, FOAM, element, stiffness_scale=np.full(len(MESH.tets), 2.0))
    assert abs(twice.stiffness - 2 * model.stiffness).max() < 1e-12


@every_element
def test_stiffness_of_a_soft_half_lies_between_soft_and_stiff(element):
    half = np.where(MESH.nodes[MESH.tets].mean(1)[:, 0] > 0.2, 0.25, 1.0)
    u = np.random.default_rng(0).standard_normal(3 * len(assemble(MESH, FOAM, element).points))
    energy = [
        u @ (assemble(MESH, FOAM, element, stiffness_scale=s).stiffness @ u)
        for s in (0.25 + 0 * half, half, 1 + 0 * half)
    ]
    assert energy[0] < energy[1] < energy[2]


@every_element
def test_numbering_of_the_nodes_does_not_change_frequencies(element):
    shuffled = np.random.default_rng(2).permutation(len(MESH.nodes))
    place = np.argsort(shuffled)
    other = TetMesh(MESH.nodes[shuffled], place[MESH.tets][:, [1, 2, 0, 3]])
    got, want = (solve_modes(assemble(m, FOAM, element), 10).frequency for m in (other, MESH))
    assert got[6:] == pytest.approx(want[6:], rel=1e-9)


@every_element
def test_the_bar_comes_nearer_to_its_limit_with_every_refinement(element):
    found = []
    for n in (1, 2, 3):
        model = assemble(block((5 * n, n, n), (0.5, 0.1, 0.1)), FOAM, element)
        model = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
        found.append(solve_modes(model, 1).frequency[0])
    fine = assemble(block((16, 4, 4), (0.5, 0.1, 0.1)), FOAM, "p2")
    fine = hold_points(fine, np.flatnonzero(fine.points[:, 0] == 0))
    errors = np.abs(np.array(found) / solve_modes(fine, 1).frequency[0] - 1)
    assert errors[2] < errors[0]
    assert errors[2] < {"p1": 0.25, "p2": 0.006}.get(element, 0.12)


def excess(element, nu):
    """Error of the first frequency of a bar two elements thick."""
    models = (
        assemble(block(n, (1.0, 0.1, 0.1)), Material(1000.0, nu), e)
        for n, e in (((20, 2, 2), element), ((40, 4, 4), "p2"))
    )
    held = (hold_points(m, np.flatnonzero(m.points[:, 0] == 0)) for m in models)
    coarse, fine = (solve_modes(m, 1).frequency[0] for m in held)
    return coarse / fine - 1


def test_smoothing_unlocks_linear_tetrahedra_up_to_a_poisson_ratio_of_0499():
    assert excess("p1", 0.49) > 1
    assert abs(excess("p1_smoothed", 0.49)) < 0.06
    assert abs(excess("p1_smoothed", 0.499)) < 0.08


def test_a_pressure_of_its_own_frees_few_quadratic_tetrahedra_of_locking_at_04999():
    def off(element):
        models = (
            assemble(block(n, (0.5, 0.2, 0.1), jitter=0.2), Material(1000.0, 0.4999), e)
            for n, e in (((5, 2, 1), element), ((10, 4, 2), "p3"))
        )
        held = (hold_points(m, np.flatnonzero(m.points[:, 0] == 0)) for m in models)
        coarse, fine = (solve_modes(m, 5).frequency for m in held)
        return np.abs(coarse / fine - 1).max()

    assert off("p2_mixed") < off("p2") / 3
    assert off("p2_mixed") < 0.06


def test_a_mixed_dilatation_is_the_mean_that_linear_functions_see():
    dilatation, size = nodal_dilatation(MESH)
    points = assemble(MESH, FOAM, "p2_mixed").points
    u = np.column_stack([points[:, 0] ** 2, points[:, 1], points[:, 2] * 0]).ravel()  # div 2x + 1
    theta = dilatation @ u
    assert size.sum() == pytest.approx(MESH.volume)
    assert size @ theta == pytest.approx((2 * 0.2 + 1) * MESH.volume)  # x = 0.2 on average
    x = MESH.nodes[:, 0]
    exact = (2 * 0.4**3 / 3 + 0.4**2 / 2) * 0.2 * 0.3  # of x div u, that linear functions give
    assert (size * theta) @ x == pytest.approx(exact)


def test_quadrature_is_exact_for_monomials_up_to_its_degree():
    from math import factorial

    for d in (1, 2, 3):
        bary, weight = quadrature(d, 4)
        for powers in np.ndindex(*(3,) * (d + 1)):
            if sum(powers) <= 4:
                exact = np.prod([factorial(p) for p in powers]) * factorial(d)
                exact /= factorial(sum(powers) + d)
                assert weight @ np.prod(bary ** np.array(powers), axis=1) == pytest.approx(exact)


def test_gradients_of_barycentric_coordinates_are_those_of_linear_functions():
    volume, g = gradients(MESH.nodes, MESH.tets)
    slope = np.array([0.3, -2.0, 1.0])
    got = np.einsum("tk,tki->ti", (MESH.nodes @ slope)[MESH.tets], g)
    assert got == pytest.approx(np.broadcast_to(slope, got.shape))
    assert volume.sum() == pytest.approx(0.4 * 0.2 * 0.3)


def test_an_unknown_element_and_a_negative_scale_are_refused():
    with pytest.raises(DataError, match='"p4"'):
        assemble(MESH, FOAM, "p4")
    with pytest.raises(DataError, match="above 0"):
        assemble(MESH, FOAM, "p1", stiffness_scale=np.full(len(MESH.tets), -1.0))


@pytest.mark.parametrize("kind", ["lumped", "averaged"])
@every_element
def test_every_kind_of_mass_is_positive_and_sums_to_the_mass(element, kind):
    mass = assemble(MESH, FOAM, element, mass=kind).mass
    assert mass.sum() == pytest.approx(3 * 60.0 * 0.4 * 0.2 * 0.3)
    assert mass.diagonal().min() > 0


def test_averaged_mass_is_far_nearer_to_the_quarter_wave_than_consistent_or_lumped():
    excess = {}
    for kind in ("consistent", "lumped", "averaged"):
        model = assemble(block((8, 1, 1), (0.5, 0.1, 0.1)), Material(1.0, 0.0), "p1", mass=kind)
        model = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
        x = model.free[model.free % 3 == 0]  # only x is free
        square, _ = lowest_eigenpairs(model.stiffness[x][:, x], model.mass[x][:, x], 1)
        excess[kind] = np.sqrt(square[0]) / np.pi - 1  # exact: ω = (π/2) c / L
    assert excess["lumped"] < 0 < excess["consistent"]
    assert abs(excess["averaged"]) < 0.25 * excess["consistent"]


def test_a_larger_penalty_rings_higher_and_ends_at_the_continuous_element():
    mesh, found = block((4, 1, 1), (0.4, 0.1, 0.1)), []
    for penalty in (6.0, 7.0, 20.0, 1e5):
        m = dg.build(mesh, np.ones(len(mesh.tets)), penalty)
        K = (m.shear / 2.6 + m.bulk / 1.2).toarray()
        values = eigh(K, m.mass.toarray(), eigvals_only=True)
        assert values[0] > -1e-6 * values[-1]
        found.append(values[6])
    limit = (2 * np.pi * solve_modes(assemble(mesh, Material(1.0, 0.3), "p1"), 7).frequency[6]) ** 2
    assert found == sorted(found)
    assert found[-1] == pytest.approx(limit, rel=1e-3)


def test_an_unknown_mass_is_refused():
    with pytest.raises(DataError, match='mass "heavy"'):
        assemble(MESH, FOAM, "p1", mass="heavy")
