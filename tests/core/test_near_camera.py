"""The camera that is put where the rest places show it."""

import numpy as np
import pytest

from core.data import Camera
from core.near_camera import lens

MIDDLE, DISTANCE, PRINCIPAL = np.array([0.3, -0.1, 0.2]), 0.5, np.array([640.0, 360.0])


def afar():
    """An orthographic camera that looks aslant."""
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    turn[2] = np.cross(turn[0], turn[1])
    return Camera("orthographic", turn, np.zeros(3), 2000.0, PRINCIPAL, (1280, 720))


def test_the_plane_through_the_middle_is_seen_as_it_was_declared():
    far = afar()
    places = MIDDLE + np.random.default_rng(4).standard_normal((5, 2)) @ far.rows[:2] * 0.1
    assert lens(far, MIDDLE, DISTANCE).project(places) == pytest.approx(far.project(places))


@pytest.mark.parametrize("towards", [0.1, -0.2])
def test_what_comes_towards_the_lens_is_seen_larger(towards):
    far = afar()
    place = MIDDLE - towards * far.rows[2]
    seen = lens(far, MIDDLE, DISTANCE).project(place) - PRINCIPAL
    grown = (far.project(place) - PRINCIPAL) / (1 - towards / DISTANCE)
    assert seen == pytest.approx(grown)
