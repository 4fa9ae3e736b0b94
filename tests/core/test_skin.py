"""Few points of the skin drag as the whole skin does, whichever way the body moves."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core.effects import air_drag
from core.skin import few
from tests.core.test_simulate import setting

SIDES = (0.02, 0.05, 0.2)  # m, of a bar that stands on the ground


def skin(n=24):
    """Midpoints (q, 3), outward normals (q, 3) and areas (q,) of patches of all sides."""
    places, normals, areas = [], [], []
    for axis, way in ((a, w) for a in range(3) for w in (-1, 1)):
        other = [a for a in range(3) if a != axis]
        grid = np.stack(np.meshgrid(*[(np.arange(n) + 0.5) / n] * 2), axis=-1).reshape(-1, 2)
        place = np.zeros((len(grid), 3))
        for column, a in enumerate(other):
            place[:, a] = SIDES[a] * (grid[:, column] - (0.5 if a < 2 else 0.0))
        place[:, axis] = SIDES[axis] * (way / 2 if axis < 2 else (way + 1) / 2)
        places.append(place)
        normals.append(np.tile(way * np.eye(3)[axis], (len(grid), 1)))
        areas.append(np.full(len(grid), SIDES[other[0]] * SIDES[other[1]] / n**2))
    return np.vstack(places), np.vstack(normals), np.concatenate(areas)


def swaying(place):
    """(q, 3, K) bends either way, and a twist."""
    x, y, z = (place / SIDES[2]).T
    none = 0 * z
    return np.stack(
        [
            np.stack([z**2, none, -2 * z * x], axis=1),
            np.stack([none, z**2, -2 * z * y], axis=1),
            np.stack([-y * z, x * z, none], axis=1) * 8,
        ],
        axis=2,
    )


def drag(moved, facing, areas, speed):
    into = np.maximum(facing @ speed, 0)
    return np.einsum("q,qi,qik->k", into * areas, moved @ speed, moved)


def test_few_points_drag_as_all_of_them_do():
    place, normal, areas = skin()
    moved = swaying(place)
    facing = np.einsum("qi,qik->qk", normal, moved)
    pick, share = few(moved, facing, areas)
    assert len(pick) <= 100 and (share > 0).all()
    assert share.sum() < 1.5 * areas.sum()  # what does not move needs none
    size = np.array([drag(moved, facing, areas, one)[k] for k, one in enumerate(np.eye(3))])
    off, whole = [], []
    for _ in range(200):
        speed = np.random.default_rng(len(off) + 5).standard_normal(3) * size ** (-1 / 3)
        whole.append(drag(moved, facing, areas, speed) * size ** (-1 / 3))
        off.append(drag(moved[pick], facing[pick], share, speed) * size ** (-1 / 3) - whole[-1])
    assert np.linalg.norm(off) < 0.02 * np.linalg.norm(whole)


@pytest.mark.parametrize("masses", [(1.0, 1.0, 1.0), (1.0, 0.4, 2.5)])
def test_only_the_side_in_front_is_dragged(masses):
    """So a twist that goes with a bend is dragged by what one side alone feels: a body whose two
    sides were dragged half each would feel none of it. A light mode is dragged more than a heavy
    one: masses (K,) are one over those of the modes.
    """
    masses = np.array(masses)
    place, normal, areas = skin()
    moved = swaying(place)
    facing = np.einsum("qi,qik->qk", normal, moved)
    pick, share = few(moved, facing, areas)
    skin_of = np.moveaxis(moved[pick], 2, 0)  # (K, s, 3)
    one = replace(
        setting(),
        couple=np.ones(3),
        omega=np.ones(3),
        skin=np.swapaxes(skin_of, 1, 2).reshape(3, -1),
        facing=facing[pick].T,
        wind=(np.swapaxes(skin_of, 1, 2) * share).reshape(3, -1).T * masses,
        masses=masses,
    )
    push = air_drag.acceleration(np.array([[one.amplitude]]), one)
    for speed in np.array([[1.0, 0.3, 0.5], [-1.0, 0.2, 0.4], [0.2, -1.0, 0.3]]):
        told = push(SimpleNamespace(v=speed[:, None]))[:, 0]
        expected = -2 * drag(moved, facing, areas, speed) * masses
        assert np.abs(told - expected).max() < 0.03 * np.abs(expected).max()
