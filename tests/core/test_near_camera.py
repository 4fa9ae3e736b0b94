"""The camera that is put where the rest places show it."""

from types import SimpleNamespace

import numpy as np
import pytest

from core.channels import Channels
from core.data import Camera
from core.lens import Fitted, straightened
from core.near_camera import lens

MIDDLE, DISTANCE, PRINCIPAL = np.array([0.3, -0.1, 0.2]), 0.5, np.array([640.0, 360.0])
CORNER = np.array([1200.0, 80.0])


def afar(origin=PRINCIPAL, size=(1280, 720)):
    """An orthographic camera that looks aslant and sees the object's origin at a pixel."""
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    turn[2] = np.cross(turn[0], turn[1])
    return Camera("orthographic", turn, np.zeros(3), 2000.0, origin, size)


@pytest.mark.parametrize("origin", [PRINCIPAL, CORNER])
def test_the_plane_through_the_middle_is_seen_as_it_was_declared(origin):
    far = afar(origin)
    places = MIDDLE + np.random.default_rng(4).standard_normal((5, 2)) @ far.rows[:2] * 0.1
    assert lens(far, MIDDLE, DISTANCE).project(places) == pytest.approx(far.project(places))


@pytest.mark.parametrize("towards", [0.1, -0.2])
@pytest.mark.parametrize(("far", "picture"), [
    (afar(), PRINCIPAL),
    (afar(CORNER), PRINCIPAL),  # the lens looks at the picture's middle
    (afar(CORNER, (0, 0)), CORNER),  # of which no more is known
])  # fmt: skip
def test_what_comes_towards_the_lens_is_seen_larger(far, picture, towards):
    place = MIDDLE - towards * far.rows[2]
    seen = lens(far, MIDDLE, DISTANCE).project(place) - picture
    grown = (far.project(place) - picture) / (1 - towards / DISTANCE)
    assert seen == pytest.approx(grown)


def bent(sigma=0.05, more=None):
    """Channels of a lens before which a body swings across the view in one mode and almost towards
    it in another one; the body; the motions (T, 2); what is seen if pixels moved in proportion.

    more: (u, time) -> (T, 2) motions beside those, in the modes' own shapes.
    """
    rng, time = np.random.default_rng(5), np.arange(400) / 100
    near = lens(afar(), MIDDLE, 6 * DISTANCE)
    places = MIDDLE + 0.05 * rng.uniform(-1, 1, (6, 3))
    along, towards = near.rows[0], near.rows[2] + 0.002 * near.rows[1]
    grows = 1 + 4 * (places - MIDDLE) @ near.rows[1:2].T
    shapes = np.stack([grows * along, grows[::-1] * towards], axis=2)  # (6, 3, 2)
    u = np.array([[0.03], [0.2]]) * np.cos(2 * np.pi * np.array([[5.0], [3.1]]) * time)
    u = (u * np.exp(-0.5 * time)).T
    h = 1e-6 * np.eye(3)
    slopes = [near.project(places + one) - near.project(places - one) for one in h]
    directions = np.moveaxis(np.array(slopes) / 2e-6, 0, 2).reshape(12, 3)
    acted = u if more is None else u + more(u, time)
    moved = np.einsum("tk,nik->tni", acted, shapes)
    rest = near.project(places).ravel()
    straight = rest + np.einsum("ci,tci->tc", directions, np.repeat(moved, 2, axis=1))
    seen = near.project((places + moved).reshape(-1, 3)).reshape(len(time), -1)
    markers = [SimpleNamespace(position=place) for place in places]
    take = SimpleNamespace(recording=SimpleNamespace(camera=near, markers=markers))
    data = Channels(
        time=time,
        values=seen + sigma * rng.standard_normal(seen.shape),
        sigma=np.full(12, sigma),
        fit=np.ones(len(time), bool),
        marker=np.repeat(np.arange(6), 2),
        support=np.zeros(12, bool),
        directions=directions,
        row=np.zeros(12),
        rows=np.zeros(seen.shape),
        rest=rest,
        quiet=np.full(12, np.nan),
        take=take,
    )
    body = SimpleNamespace(modes=SimpleNamespace(shapes=shapes), markers=np.eye(18))
    return data, body, u, straight


def off(data, body, straight, known):
    """How far what is straightened is from what is straight, in the noise."""
    return (straightened(data, body, np.eye(2), known).values - straight).std() / data.sigma[0]


def test_what_hardly_shows_in_a_frame_is_straightened_by_what_shows_in_all():
    data, body, u, straight = bent()
    shown = np.einsum("ci,cik->kc", data.directions, body.modes.shapes[data.marker])
    left = data.values - data.values.mean(axis=0) - (u - u.mean(axis=0)) @ shown
    assert (data.values - straight).std() > 10 * data.sigma[0]
    assert off(data, body, straight, Fitted(u, shown, left)) < 1.1
    unit = np.array([3.0, -0.5])  # whatever a fit has them in
    scaled = Fitted(u * unit, shown / unit[:, None], left)
    assert off(data, body, straight, scaled) < 1.1
    assert off(data, body, straight, None) > 3


@pytest.mark.parametrize("more", [
    lambda u, time: np.c_[10 * u[:, 0] ** 2, 0 * time],
    lambda u, time: np.c_[-10 * u[:, 0] ** 2, 0 * time],
    lambda u, time: np.c_[0.002 * np.exp(-time / 1.5), 0 * time],
], ids=["an overtone", "one the other way", "a creep"])  # fmt: skip
def test_what_acts_on_the_body_is_not_taken_for_a_bend(more):
    data, body, u, straight = bent(more=more)
    shown = np.einsum("ci,cik->kc", data.directions, body.modes.shapes[data.marker])
    left = data.values - data.values.mean(axis=0) - (u - u.mean(axis=0)) @ shown
    known = Fitted(u, shown, left)
    assert off(data, body, straight, known) < 1.5
    assert (straight - straight.mean(axis=0)).std() > 100 * data.sigma[0]


def test_the_bend_says_how_far_a_mode_moves_whose_computed_shape_is_a_little_off():
    """Turned by a degree or two, what goes towards the lens is seen twice as large, or half."""
    data, body, u, straight = bent()
    shown = np.einsum("ci,cik->kc", data.directions, body.modes.shapes[data.marker])
    left = data.values - data.values.mean(axis=0) - (u - u.mean(axis=0)) @ shown
    # towards it each marker moves as computed, across the view as seen
    aside = np.cross(*lens(afar(), MIDDLE, DISTANCE).rows[[0, 2]])
    shapes = body.modes.shapes + 0.02 * aside[:, None] * np.array([0.0, 1.0])
    other = SimpleNamespace(modes=SimpleNamespace(shapes=shapes), markers=body.markers)
    assert off(data, other, straight, Fitted(u, shown, left)) < 1.3
