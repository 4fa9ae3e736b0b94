"""The founding report's numbers, held to closed forms and to published values."""

import json

import numpy as np
import pytest

from core.data import Material, TetMesh
from core.elasticity import assemble
from core.elements.linear import laplacian, scalar_mass, shear_and_bulk, stiffness
from core.elements.mass import averaged
from core.elements.simplex import each_axis
from core.errors import CaseError
from core.plane_mesh import polygon_mesh, refined, signed_distance
from core.study import study
from core.study_line import (
    averaged_closed,
    conjecture,
    differences,
    differences_closed,
    elements,
    elements_closed,
    exact,
    phase,
    study_line,
)
from core.study_plane import (
    POLYGON,
    TRIANGLE,
    holding_force,
    plane_strain_modes,
    study_polygon,
    study_triangle,
    widest_corner,
)
from core.study_solid import bar, errors, pitches


@pytest.fixture(scope="module")
def line():
    return study_line()


@pytest.fixture(scope="module")
def polygon():
    return study_polygon()[0]


@pytest.fixture(scope="module")
def triangle():
    return study_triangle()[0]


# --- the product's elements in every dimension ------------------------------------------------


def test_in_three_dimensions_they_are_the_products_own():
    nodes = np.random.default_rng(2).uniform(size=(4, 3)) + np.vstack([np.zeros(3), np.eye(3)])
    model = assemble(TetMesh(nodes, [[0, 1, 2, 3]]), Material(1.0, 0.4), "p1")
    cells = np.array([[0, 1, 2, 3]])
    shear, bulk = shear_and_bulk(nodes, cells)
    mass = each_axis(scalar_mass(nodes, cells))
    for ours, theirs in ((shear, model.shear), (bulk, model.bulk), (mass, model.mass)):
        assert np.abs((ours - theirs).toarray()).max() < 1e-14 * abs(theirs).max()


def test_plane_strain_carries_a_uniform_strain_with_the_exact_energy():
    nodes, cells = polygon_mesh(POLYGON, 0.2)
    strain = np.array([[0.1, 0.03], [-0.05, 0.2]])
    u = (nodes @ strain.T).ravel()
    e, nu = (strain + strain.T) / 2, 0.4
    lame = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    density = lame[0] * np.trace(e) ** 2 + 2 * lame[1] * (e**2).sum()
    area = scalar_mass(nodes, cells).sum()
    assert u @ stiffness(nodes, cells, nu) @ u == pytest.approx(density * area, rel=1e-12)


def test_the_polygons_mesh_fills_it_and_keeps_its_corners():
    nodes, cells = polygon_mesh(POLYGON, 0.1)
    x, y = POLYGON.T
    area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    assert scalar_mass(nodes, cells).sum() == pytest.approx(area, rel=1e-3)
    assert np.linalg.norm(nodes[:, None] - POLYGON, axis=-1).min(axis=0).max() < 1e-12
    assert signed_distance(nodes, POLYGON).max() < 1e-3


def test_refining_halves_edges_and_keeps_the_area():
    nodes, cells = polygon_mesh(POLYGON, 0.2)
    fine, quarters = refined(nodes, cells)
    assert len(quarters) == 4 * len(cells)
    assert scalar_mass(fine, quarters).sum() == pytest.approx(scalar_mass(nodes, cells).sum())


# --- the line ---------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [2, 4, 8, 16, 32])
@pytest.mark.parametrize(("length", "c"), [(1.0, 1.0), (2.0, 3.0)])
def test_the_line_follows_its_closed_forms_at_any_length(n, length, c):
    half = (lambda *line: elements(*line, averaged), averaged_closed)
    for found, closed in ((differences, differences_closed), (elements, elements_closed), half):
        assert np.abs(found(length, c, n) / closed(length, c, n) - 1).max() < 1e-12


@pytest.mark.parametrize("n", [2, 8, 16])
def test_differences_err_below_and_elements_above(n):
    true = exact(1, 1, n)
    assert (differences(1, 1, n) < true).all()
    assert (elements(1, 1, n) > true).all()


def test_averaged_mass_errs_by_a_share_of_x4_over_240():
    short = 1 - (averaged_closed(1, 1, 16) / exact(1, 1, 16))[:3]
    assert short == pytest.approx(phase(16)[:3] ** 4 / 240, rel=0.02)


def test_the_conjecture_differs_from_the_elements_by_a_share_of_x6_over_3024():
    difference = (conjecture(1, 1, 16) / elements_closed(1, 1, 16) - 1)[:3]
    assert difference == pytest.approx(phase(16)[:3] ** 6 / 3024, rel=0.06)


def test_the_conjecture_fails_for_high_modes(line):
    rows = line["eigenvalues"]
    assert rows["2"]["elements"] == pytest.approx([12.0], rel=1e-12)
    assert rows["2"]["conjecture"] == pytest.approx([12.073], abs=5e-4)
    top = [rows["16"][key][-1] for key in ("elements", "conjecture", "exact")]
    assert top == pytest.approx([2985, 4369, 2221], abs=0.5)


def test_the_line_reports_its_own_closed_form_error(line):
    assert all(row["closed_form_error"] < 1e-12 for row in line["eigenvalues"].values())


def test_dac_mends_the_first_mode_and_leaves_the_next_high(line):
    rows = list(line["dac_on_the_first"].values())
    assert [r["factor"] for r in rows] == pytest.approx([0.950, 0.987, 0.997], abs=5e-4)
    left = np.array([r["frequency_percent"] for r in rows])
    assert np.abs(left[:, 0]).max() < 1e-10
    assert left[:, 1] == pytest.approx([7.5, 1.9, 0.5], abs=0.05)
    assert left[:, 2] == pytest.approx([16.5, 5.2, 1.3], abs=0.06)


def test_averaged_mass_leaves_a_hundredth_of_the_error(line):
    row = line["averaged_mass"]
    assert row["averaged_percent"] == pytest.approx([-0.005, -0.08, -0.4], rel=0.06)
    assert row["consistent_percent"] == pytest.approx([0.6, 2.6, 5.8], rel=0.08)


def test_the_reports_formulas_err_by_l2_and_its_mass_by_a_quarter(line):
    assert line["report"]["mass_matrix_6_limit_over_pi2"] == pytest.approx(0.75, rel=1e-4)
    assert line["report"]["formula_4_at_length_2_over_true"] == pytest.approx(4, rel=1e-3)


# --- the polygon ------------------------------------------------------------------------------


def test_the_polygons_table_is_met_within_two_per_cent(polygon):
    table = {row["h"]: (row["scalar"], row["elastic"]) for row in polygon["table"]}
    published = {
        0.2: (2.4085, 0.8685),
        0.15: (2.3534, 0.7863),
        0.1: (2.3039, 0.6936),
        0.05: (2.2690, 0.5761),
    }
    assert table.keys() == published.keys()
    for h, values in published.items():
        assert table[h] == pytest.approx(values, rel=0.02)


def test_its_widest_corner_sets_how_fast_it_converges(polygon):
    assert np.degrees(widest_corner(POLYGON)) == pytest.approx(290.6, abs=0.05)
    assert polygon["power_of_h"] == pytest.approx(1.24, abs=0.005)
    assert polygon["power_measured"] == pytest.approx(polygon["power_of_h"], abs=0.1)
    assert polygon["scalar_limit"] == pytest.approx(2.246, rel=1e-3)


def test_nested_meshes_only_get_softer(polygon):
    assert (np.diff(polygon["nested_scalar"]) < 0).all()
    assert min(polygon["nested_scalar"]) > polygon["scalar_limit"]


def test_a_free_plate_has_three_rigid_motions():
    values, _ = plane_strain_modes(*polygon_mesh(POLYGON, 0.2), 4)
    assert np.abs(values[:3]).max() < 1e-9 * values[3]


def test_the_scalar_problem_of_a_square_is_pi_squared():
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1.0)])
    nodes, cells = polygon_mesh(square, 0.1)
    K, M = laplacian(nodes, cells), scalar_mass(nodes, cells)
    u = np.cos(np.pi * nodes[:, 0])
    assert (u @ K @ u) / (u @ M @ u) == pytest.approx(np.pi**2, rel=0.02)


# --- the triangle -----------------------------------------------------------------------------


def test_one_triangle_needs_the_force_of_uniform_strain():
    force, _ = holding_force(TRIANGLE, np.array([(0, 1, 2)]), 0.3)
    mu, lam = 1 / 2.6, 0.3 / (1.3 * 0.4)
    slope = 1 / np.sqrt(0.75)  # the top's shape function per height
    expected = np.sqrt(0.75) / 2 * slope**2 * np.array([mu * 0.2, (lam + 2 * mu) * 0.1])
    assert force == pytest.approx(expected, rel=1e-12)


def test_the_holding_force_falls_as_published(triangle):
    published = {"0.3": (0.0895, 0.0438, 0.0256, 0.0178, 0.0137)}
    published["0.48"] = (0.509, 0.150, 0.0576, 0.0311)
    for nu, forces in published.items():
        assert triangle[nu]["force"][: len(forces)] == pytest.approx(forces, rel=0.02)
        assert (np.diff(triangle[nu]["force"]) < 0).all()


def test_a_point_has_no_stiffness_its_compliance_grows_by_the_same_with_each_halving(triangle):
    for row in triangle.values():
        growth = row["growth_of_compliance"][-2:]
        assert growth[1] == pytest.approx(growth[0], rel=0.02)
        assert min(growth) > 10


# --- the bar ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("element", "nu", "n", "first", "after"),
    [
        ("p1", 0.3, 2, 30, 22),
        ("p1", 0.49, 2, 155, 56),
        ("p1", 0.49, 4, 59, 41),
        ("p1_smoothed", 0.3, 2, -3.6, 14),
        ("p1_smoothed", 0.49, 2, 4.2, 5.9),
        ("p2", 0.49, 1, 5.5, 4.4),
    ],
)
def test_locking_on_the_bar(element, nu, n, first, after):
    found = errors(pitches(n, element, nu)[0], pitches(2, "p3", nu)[0])
    assert found["first_percent"] == pytest.approx(first, rel=0.03)
    assert found["worst_after_dac_percent"] == pytest.approx(after, rel=0.03)


def test_penalty_turns_discontinuous_elements_into_p1():
    p1 = pitches(1, "p1", 0.3)[0][0]
    soft, hard, welded = (pitches(1, "dg", 0.3, p)[0][0] for p in (7.0, 70.0, 7e4))
    assert soft < hard < welded < p1 * (1 + 1e-6)
    assert welded == pytest.approx(p1, rel=1e-3)


def test_the_bar_is_whole():
    mesh = bar(2)
    assert mesh.volume == pytest.approx(10, rel=1e-12)
    assert len(mesh.tets) == 6 * 20 * 2 * 2


# --- the command's work -----------------------------------------------------------------------


def test_the_study_writes_numbers_and_four_pictures(tmp_path):
    seen = []
    found = study(tmp_path / "out", lambda share, text: seen.append(share))
    assert json.loads((tmp_path / "out" / "study.json").read_text()) == found
    names = {"line.png", "polygon.png", "triangle.png", "locking.png", "study.json"}
    assert {p.name for p in (tmp_path / "out").iterdir()} == names
    assert all((tmp_path / "out" / n).stat().st_size > 5000 for n in names)
    assert seen == sorted(seen)
    assert seen[-1] == 1


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(CaseError, match="--out"):
        study(tmp_path / "out")
