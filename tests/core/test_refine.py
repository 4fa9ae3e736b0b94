import numpy as np
import pytest

from core.boundary import boundary
from core.refine import refine
from tests.core.solids import block

MESH = block((3, 2, 2), (0.3, 0.2, 0.1), jitter=0.3)


def test_refinement_makes_eight_of_each_and_keeps_volume_skin_and_nodes():
    fine = refine(MESH)
    assert len(fine.tets) == 8 * len(MESH.tets)
    assert fine.volume == pytest.approx(MESH.volume, rel=1e-12)
    assert boundary(fine).areas.sum() == pytest.approx(boundary(MESH).areas.sum(), rel=1e-12)
    assert (fine.nodes[: len(MESH.nodes)] == MESH.nodes).all()


def test_children_of_a_tetrahedron_have_equal_volumes():
    a, b, c, d = refine(MESH).nodes[refine(MESH).tets].transpose(1, 0, 2)
    volume = np.einsum("ti,ti->t", np.cross(b - a, c - a), d - a) / 6
    a, b, c, d = MESH.nodes[MESH.tets].transpose(1, 0, 2)
    parents = np.einsum("ti,ti->t", np.cross(b - a, c - a), d - a) / 48
    assert np.sort(volume) == pytest.approx(np.sort(np.repeat(parents, 8)))


def test_every_inner_triangle_belongs_to_two_tetrahedra():
    fine = refine(refine(block((1, 1, 1), (1, 1, 1))))
    assert len(boundary(fine).tet) == 12 * 16
