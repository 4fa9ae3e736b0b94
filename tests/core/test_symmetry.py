import numpy as np
import pytest

from core.data import Material, TetMesh
from core.elasticity import assemble, hold_points
from core.symmetry import is_even
from tests.core.solids import block


def held(size, pinned, element="p1", turn=None):
    mesh = block((6, 4, 4), size, jitter=0.1)
    where = np.flatnonzero(pinned(mesh.nodes))
    if turn is not None:
        mesh = TetMesh(mesh.nodes @ turn.T + 0.3, mesh.tets)
    return hold_points(assemble(mesh, Material(1000.0, 0.4), element), where)


@pytest.mark.parametrize("element", ["p1", "p2"])
@pytest.mark.parametrize(
    ("size", "even"), [((3, 1, 1), True), ((1, 1, 1), True), ((1, 3, 3), True), ((3, 1, 1.1), False)]
)
def test_a_body_is_even_where_its_section_is_as_wide_both_ways(size, even, element):
    turn, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    assert is_even(held(size, lambda x: x[:, 0] == 0, element, turn)) is even


def test_a_square_bar_that_is_held_on_one_edge_is_not_even():
    assert not is_even(held((3, 1, 1), lambda x: (x[:, 0] == 0) & (x[:, 1] == 0)))
    assert not is_even(held((3, 1, 1), lambda x: x[:, 1] == 0))
