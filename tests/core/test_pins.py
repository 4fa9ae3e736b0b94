"""Regions hold what is in them: against dense sampling of the surface, and at exact borders."""

import numpy as np
import pytest

from core.data import Surface
from core.errors import CaseError
from core.pins import Box, Sphere, held_vertices, spread, vertices_region

SQUARE = Surface(  # 1 m wide, two triangles, cut along the diagonal from 0 to 2
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
)


def test_a_box_meets_a_triangle_where_a_point_of_the_triangle_is_in_the_box():
    random = np.random.default_rng(3)
    verdicts = []
    for _ in range(1500):
        surface = Surface(random.uniform(-1, 1, size=(3, 3)), [[0, 1, 2]])
        low = random.normal(size=3) * 0.7
        box = Box(low, low + random.exponential(1.0, size=3))
        points = spread(surface)  # 60 a side: less than 0.07 m apart
        meets = box.meets(surface)
        verdicts.append(meets)
        if box.contains(points).any():
            assert meets
        if meets:
            assert Box(box.min, box.max, hair=0.07).contains(points).any()
    assert 0.1 < np.mean(verdicts) < 0.9


def test_a_box_meets_a_slanted_triangle_where_its_corner_pierces_the_plane():
    slanted = Surface(3 * np.eye(3), [[0, 1, 2]])  # x + y + z = 3
    assert not Box([0, 0, 0], [0.999, 0.999, 0.999]).meets(slanted)
    assert Box([0, 0, 0], [1.001, 1.001, 1.001]).meets(slanted)


def test_a_sphere_meets_a_triangle_where_its_centre_is_near_enough():
    above = [0.4, 0.2, 0.3]
    assert Sphere(above, 0.3001).meets(SQUARE)
    assert not Sphere(above, 0.2999).meets(SQUARE)
    beyond = [1.3, 0.5, 0.4]  # nearest to the edge x = 1, 0.5 away
    assert Sphere(beyond, 0.5001).meets(SQUARE)
    assert not Sphere(beyond, 0.4999).meets(SQUARE)


def test_borders_belong_to_the_region_and_a_hair_beyond_with_it():
    points = np.array([[0.2, 0, 0], [0.2 + 1e-9, 0, 0], [0.2 + 1e-6, 0, 0]])
    for region in (Box([0, -1, -1], [0.2, 1, 1]), Sphere([0, 0, 0], 0.2)):
        assert region.contains(points).tolist() == [True, False, False]
    for region in (Box([0, -1, -1], [0.2, 1, 1], 1e-8), Sphere([0, 0, 0], 0.2, 1e-8)):
        assert region.contains(points).tolist() == [True, True, False]


def test_named_vertices_hold_the_triangles_that_are_wholly_theirs():
    region = vertices_region(SQUARE, np.array([0, 1, 2]), "pin")
    inside, in_the_other, on_a_vertex, above = (
        [0.7, 0.3, 0],
        [0.3, 0.7, 0],
        [1, 1, 0],
        [0.7, 0.3, 1],
    )
    held = region.contains(np.array([inside, in_the_other, on_a_vertex, above]))
    assert held.tolist() == [True, False, True, False]
    two = vertices_region(SQUARE, np.array([0, 1]), "pin")  # an edge, no triangle
    assert two.contains(np.array([[0, 0, 0], [0.5, 0, 0]])).tolist() == [True, False]


def test_regions_add_up_and_each_must_hold_something():
    left, right = Box([-1, -1, -1], [0.1, 2, 1]), Box([0.9, -1, -1], [2, 2, 1])
    assert held_vertices(SQUARE, (left,)).tolist() == [True, False, False, True]
    assert held_vertices(SQUARE, (left, right)).all()
    with pytest.raises(CaseError, match=r"\[\[pin\]\] 2 holds nothing"):
        held_vertices(SQUARE, (left, Box([0, 0, 0.1], [1, 1, 1])))
    with pytest.raises(CaseError, match="whole surface"):
        held_vertices(SQUARE, (Box([-1, -1, -1], [0.5, 2, 1]), Box([0.5, -1, -1], [2, 2, 1])))


def test_a_spread_covers_each_triangle_by_its_area():
    points = spread(SQUARE).reshape(-1, 3)
    assert len(points) == 2 * 60 * 61 / 2
    np.testing.assert_allclose(points.mean(axis=0), [0.5, 0.5, 0], atol=1e-12)
    assert (points[:, :2] > 0).all()
    assert (points[:, :2] < 1).all()
