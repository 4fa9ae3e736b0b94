from dataclasses import replace

import numpy as np
import pytest

from core.body import Body
from core.data import Material, TetMesh
from core.effects import split_modes
from core.elasticity import assemble, hold_points
from core.symmetry import is_even, unevenness
from tests.core.solids import block
from tests.core.test_simulate import setting

TURN, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
TURN *= np.linalg.det(TURN)


def held(size, pinned, element="p1"):
    mesh = block((6, 4, 4), size, jitter=0.1)
    where = np.flatnonzero(pinned(mesh.nodes))
    mesh = TetMesh(mesh.nodes @ TURN.T + 0.3, mesh.tets)
    if element == "p2":  # by place: there are more points than nodes
        model = assemble(mesh, Material(1000.0, 0.4), element)
        return hold_points(model, np.flatnonzero(pinned((model.points - 0.3) @ TURN)))
    return hold_points(assemble(mesh, Material(1000.0, 0.4), element), where)


def at_the_foot(x):
    return x[:, 0] < 1e-9


@pytest.mark.parametrize("element", ["p1", "p2"])
@pytest.mark.parametrize("size", [(3, 1, 1), (1, 1, 1), (1, 3, 3)])
def test_a_square_body_that_is_held_at_its_foot_is_even(size, element):
    assert unevenness(held(size, at_the_foot, element)) < 0.02  # the inner nodes are moved


def test_a_cube_that_is_held_on_two_opposite_faces_is_even():
    assert is_even(held((1, 1, 1), lambda x: at_the_foot(x) | (x[:, 0] > 1 - 1e-9)))


def test_unevenness_is_that_of_the_squared_widths_of_body_and_foot():
    assert unevenness(held((3, 1, 1.08), at_the_foot)) == pytest.approx(2 * (1.08**2 - 1), abs=0.02)
    assert not is_even(held((3, 1, 1.08), at_the_foot))


@pytest.mark.parametrize(("width", "pairs"), [(1, True), (1.01, True), (1.1, False)])
def test_a_pair_is_split_where_the_body_may_have_one(width, pairs):
    model = held((3, 1, width), at_the_foot)
    body = Body(None, model, model, None, None)
    assert body.pairs == pairs
    declared = replace(setting(), paired=True, symmetric=body.pairs)
    assert (split_modes.EFFECT.requires(declared, ()) == "") == pairs


@pytest.mark.parametrize(
    "pinned",
    [
        lambda x: at_the_foot(x) & (x[:, 1] < 1e-9),
        lambda x: x[:, 1] < 1e-9,
        lambda x: at_the_foot(x) & (abs(x[:, 1] - 0.5) < 0.3),
    ],
    ids=["one edge", "one side", "a strip across the foot"],
)
def test_a_square_bar_that_is_held_unevenly_is_not_even(pinned):
    assert not is_even(held((3, 1, 1), pinned))


def test_a_bar_that_hangs_from_one_point_of_its_axis_is_even():
    assert is_even(held((3, 1, 1), lambda x: (abs(x - [0, 0.5, 0.5]) < 1e-9).all(axis=1)))
