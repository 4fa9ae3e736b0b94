import numpy as np
import pytest

from core.nearest import closest_on_triangles, locate, nearest_face
from tests.core.solids import block

RNG = np.random.default_rng(5)


def test_the_nearest_face_is_never_farther_than_any_point_of_the_surface():
    vertices = RNG.standard_normal((60, 3)) * [1, 0.1, 5]
    faces = RNG.integers(0, 60, (90, 3))
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    places = RNG.standard_normal((300, 3)) * 3
    face, bary, distance = nearest_face(places, vertices, faces)
    foot = np.einsum("nk,nki->ni", bary, vertices[faces[face]])
    assert np.linalg.norm(foot - places, axis=1) == pytest.approx(distance)
    assert ((bary >= -1e-12) & (bary <= 1 + 1e-12)).all()
    samples = np.einsum("sk,fki->fsi", RNG.dirichlet(np.ones(3), 200), vertices[faces])
    gaps = np.linalg.norm(places[:, None] - samples.reshape(1, -1, 3), axis=2).min(axis=1)
    assert (distance <= gaps + 1e-12).all()
    assert np.median(gaps - distance) < 0.2


def test_the_foot_on_a_triangle_without_area_is_on_its_longest_edge():
    line = np.array([[[0.0, 0, 0], [1, 0, 0], [0.5, 0, 0]]])
    weights = closest_on_triangles(np.array([[0.3, 1.0, 0.0]]), line)
    assert weights @ line[0] == pytest.approx(np.array([[0.3, 0, 0]]))


def test_places_are_found_in_a_tetrahedron_that_contains_them_and_outside_in_none():
    mesh = block((5, 4, 3), (1, 1, 1), jitter=0.3)
    places = RNG.uniform(-0.5, 1.5, (2000, 3))
    tet, bary = locate(places, mesh.nodes, mesh.tets)
    inside = ((places >= 0) & (places <= 1)).all(axis=1)
    assert ((tet >= 0) == inside).all()
    back = np.einsum("nk,nki->ni", bary[inside], mesh.nodes[mesh.tets[tet[inside]]])
    assert back == pytest.approx(places[inside])
    assert bary[inside].min() > -1e-8
