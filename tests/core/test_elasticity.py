from dataclasses import dataclass, replace

import numpy as np
import pytest

from core.boundary import boundary, face_points
from core.data import Load, Material
from core.elasticity import (
    add_loads,
    assemble,
    geometric_stiffness,
    gravity_force,
    hold,
    hold_points,
    loose_motions,
    point_operator,
    static,
    surface_quadrature,
    surface_springs,
)
from core.elements import ELEMENTS
from core.errors import DataError
from core.modes import solve_modes
from tests.core.solids import block, box_surface

RUBBER = Material(1100.0, 0.47)
SIZE = (0.1, 0.02, 0.03)
MESH = block((10, 2, 3), SIZE, jitter=0.2)
RNG = np.random.default_rng(3)


@dataclass(frozen=True)
class Slab:
    low: float
    high: float

    def contains(self, points):
        return (points[:, 0] >= self.low) & (points[:, 0] <= self.high)


def rigid(points, centre=(0.01, 0.2, -0.3)):
    """(P, 3, 6) three translations and three small turns."""
    shift = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    turn = np.cross(np.eye(3), (points - np.array(centre))[:, None, :]).transpose(0, 2, 1)
    return np.concatenate([shift, turn], axis=2)


@pytest.mark.parametrize("element", ELEMENTS)
def test_pins_on_a_coarse_surface_hold_the_whole_end_and_nothing_else(element):
    surface = box_surface(SIZE)
    model = hold(assemble(MESH, RUBBER, element), surface, surface.vertices[:, 0] == 0)
    on_end = np.isin(np.arange(len(model.points)), face_points(model)) & (model.points[:, 0] == 0)
    assert (model.pinned == on_end).all()
    assert loose_motions(model) == 0


def test_pins_hold_points_that_meshing_moved_by_a_hair():
    moved = MESH.nodes + RNG.uniform(0, 3e-4, MESH.nodes.shape)
    surface = box_surface(SIZE)
    model = assemble(replace(MESH, nodes=moved), RUBBER)
    model = hold(model, surface, surface.vertices[:, 0] == 0)
    assert model.pinned.sum() == (model.points[:, 0] < 1e-3).sum()


def test_a_region_between_the_vertices_of_large_triangles_holds_the_band_inside_it():
    surface = box_surface(SIZE)
    nobody = np.zeros(len(surface.vertices), bool)
    model = hold(assemble(MESH, RUBBER), surface, nobody, (Slab(0.044, 0.056),))
    band = np.abs(model.points[face_points(model), 0] - 0.05) <= 0.006
    assert (model.pinned[face_points(model)] == band).all()


def test_a_pin_of_two_vertices_holds_a_point_at_each_and_leaves_one_turn():
    surface = box_surface(SIZE)
    pins = np.zeros(len(surface.vertices), bool)
    pins[[0, 1]] = True
    model = hold(assemble(MESH, RUBBER), surface, pins)
    assert model.pinned.sum() == 2
    assert loose_motions(model) == 1
    assert loose_motions(replace(model, pinned=np.arange(len(model.points)) == 4)) == 3


def test_pins_that_hold_nothing_or_everything_are_refused():
    surface = box_surface(SIZE)
    model = assemble(MESH, RUBBER, "p1")
    with pytest.raises(DataError, match="no point"):
        hold(model, surface, np.zeros(8, bool), (Slab(1, 2),))
    with pytest.raises(DataError, match="whole surface"):
        hold(model, surface, np.ones(8, bool))


@pytest.mark.parametrize("element", ELEMENTS)
def test_every_place_in_on_and_off_the_body_follows_a_rigid_motion(element):
    model = assemble(MESH, RUBBER, element)
    places = RNG.uniform(-0.02, 0.12, (200, 3))
    operator = point_operator(model, places)
    motions = RNG.standard_normal(6)
    got = operator @ (rigid(model.points) @ motions).ravel()
    assert got.reshape(-1, 3) == pytest.approx(rigid(places) @ motions, abs=1e-10)


@pytest.mark.parametrize("element", ELEMENTS)
def test_places_inside_follow_any_linear_field(element):
    model = assemble(MESH, RUBBER, element)
    places = RNG.uniform(0, 1, (300, 3)) * SIZE
    A = RNG.standard_normal((3, 3))
    got = point_operator(model, places) @ (model.points @ A.T).ravel()
    assert got.reshape(-1, 3) == pytest.approx(places @ A.T, abs=1e-12)


def test_a_marker_on_a_post_moves_smoothly_as_its_foot_goes_along_the_beam():
    model = hold_points(assemble(MESH, RUBBER), np.flatnonzero(MESH.nodes[:, 0] == 0))
    bend = static(model, gravity_force(model, (0, 0, -9.81)), 1e5)
    x = np.linspace(0.03, 0.1, 141)
    post = point_operator(model, np.column_stack([x, 0.01 + 0 * x, 0.04 + 0 * x]))
    along = (post @ bend.ravel()).reshape(-1, 3)
    foot = point_operator(model, np.column_stack([x, 0.01 + 0 * x, 0.03 + 0 * x]))
    slope = np.gradient((foot @ bend.ravel()).reshape(-1, 3)[:, 2], x)
    lean = along[:, 0] - (foot @ bend.ravel()).reshape(-1, 3)[:, 0]
    assert lean[10:-30] == pytest.approx(-0.01 * slope[10:-30], rel=0.12)
    assert np.abs(np.diff(along[:, 0])).max() < 0.05 * np.ptp(along[:, 0])


def test_a_load_adds_its_mass_and_about_a_far_axis_its_inertia():
    model = assemble(MESH, RUBBER)
    place = np.array([0.11, 0.0, 0.05])
    added = add_loads(model, (Load(0.02, place),)).mass - model.mass
    motions = rigid(model.points).reshape(-1, 6)
    inertia = motions.T @ (added @ motions)
    reach = place - [0.01, 0.2, -0.3]
    assert np.diag(inertia)[:3] == pytest.approx(0.02)
    assert np.trace(inertia[3:, 3:]) == pytest.approx(2 * 0.02 * reach @ reach)


def test_a_column_under_its_weight_sinks_by_the_closed_form():
    column = block((12, 3, 3), (0.3, 0.02, 0.02))
    model = assemble(column, Material(1000.0, 0.0))
    model = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
    u = static(model, gravity_force(model, (-9.81, 0, 0)), 2e5)
    tip = u[np.isclose(model.points[:, 0], 0.3), 0]
    assert tip == pytest.approx(-1000 * 9.81 * 0.3**2 / (2 * 2e5), rel=1e-9)


@pytest.mark.parametrize("element", ELEMENTS)
def test_the_skin_has_the_areas_and_the_outward_normals_of_the_box(element):
    operator, normals, areas = surface_quadrature(assemble(MESH, RUBBER, element))
    a, b, c = SIZE
    assert areas.sum() == pytest.approx(2 * (a * b + b * c + c * a))
    place = (operator @ assemble(MESH, RUBBER, element).points.ravel()).reshape(-1, 3)
    divergence = areas @ np.einsum("qi,qi->q", place, normals)
    assert divergence == pytest.approx(3 * a * b * c)  # Gauss: ∮ x·n = 3 V


@pytest.mark.parametrize("element", ELEMENTS)
def test_springs_on_the_held_end_add_up_to_its_area(element):
    model = assemble(MESH, RUBBER, element)
    springs = surface_springs(model, model.points[:, 0] == 0)
    push = np.tile([0.0, 0.0, 1.0], len(model.points))
    assert push @ (springs @ push) == pytest.approx(SIZE[1] * SIZE[2])
    with pytest.raises(DataError, match="no whole triangle"):
        surface_springs(model, np.arange(len(model.points)) == 0)


@pytest.mark.parametrize("element", ELEMENTS)
def test_hanging_stiffens_and_standing_softens_by_the_same_small_part(element):
    beam = block((20, 2, 2), (0.4, 0.02, 0.02))
    model = assemble(beam, Material(1000.0, 0.3), element)
    model = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
    Y, shifts = 4e6, []
    base = solve_modes(model, 1).frequency[0]
    for g in (9.81, -9.81):
        stress = geometric_stiffness(model, static(model, gravity_force(model, (g, 0, 0)), Y))
        kg = replace(model, shear=model.shear + stress * (2 * 1.3))
        shifts.append(solve_modes(kg, 1).frequency[0] ** 2 / base**2 - 1)
    inertia, area, L = 0.02**4 / 12, 0.02**2, 0.4
    stiff = 1.8751**4 * Y * inertia / (1000 * area * L**4)
    # Rayleigh with a clamped beam's first shape: ω² = (1.8751/L)^4 EI/ρA + 1.5706 g/L
    law = 1.5706 * 9.81 / L / stiff
    bending = (base * np.sqrt(Y) * 2 * np.pi) ** 2 / stiff
    assert np.array(shifts) * bending == pytest.approx([law, -law], rel=0.03)


def test_boundary_of_a_box_has_as_many_triangles_as_its_cells_show():
    assert len(boundary(block((4, 3, 2), (1, 1, 1))).tet) == 2 * 2 * (4 * 3 + 3 * 2 + 2 * 4)
