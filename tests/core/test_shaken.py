"""What the support does as well is no mode of the object."""

import numpy as np
import pytest

from core.data import Camera, Marker, Recording, Take
from core.listen import listen

FPS, NOISE = 100.0, 0.003
TIME = np.arange(500) / FPS
UP = np.array([[1.0, 0.2, 0.1], [0.7, 0.1, 0.0], [0.5, -0.2, 0.1]])  # three markers of the object
ASIDE = np.array([[0.1, 0.8, 0.0], [0.0, -0.5, 0.1], [0.2, 0.6, 0.0]])


def swing(frequency, ratio, time=TIME):
    omega = 2 * np.pi * frequency
    return np.exp(-ratio * omega * time) * np.cos(omega * np.sqrt(1 - ratio**2) * time)


def heard(object_, foot, on="support", lost=()):
    """The ring-down of (T, 3, 3) markers on an object and (T, f, 3) beside it, with noise."""
    rng = np.random.default_rng(1)
    values = np.concatenate([object_, foot], axis=1)
    values = values + NOISE * rng.standard_normal(values.shape)
    for marker in lost:
        values[rng.uniform(size=len(TIME)) < 0.9, 3 + marker] = np.nan
    markers = [Marker(f"m{n}", position=(0.1 * n, 0, 0.1)) for n in range(3)]
    markers += [Marker(f"f{n}", position=(0.1 * n, 0, 0.0), on=on) for n in range(foot.shape[1])]
    take = Take(Recording(TIME, values, tuple(markers), capture_fps=FPS), name="tracks.csv")
    return listen(take, lambda time, signals: (0.0, time[-1]))[1]


def sway():
    """(T, 1, 3) of a hand that holds the camera: slow and far, and never the same."""
    ways = np.sin(np.outer(TIME, [5.0, 6.0, 7.0]) + np.arange(3))
    return (2 * np.exp(-0.15 * TIME)[:, None] * ways)[:, None]


@pytest.mark.parametrize(("on", "lost"), [("support", ()), ("support", (0,)), ("object", ())])
def test_a_camera_in_the_hand_is_told_by_what_stands_beside_the_object(on, lost):
    """A marker that is hardly ever seen does not keep another one from telling."""
    foot = np.zeros((len(TIME), 2, 3)) + sway()
    ring = heard(swing(3.0, 0.05)[:, None, None] * UP + sway(), foot, on, lost)
    lively = [f for f, z in zip(ring.frequency, ring.damping_ratio, strict=True) if z < 0.5]
    if on == "support":
        assert lively == [pytest.approx(3.0, rel=0.01)]
        (told,) = ring.warnings
        assert told.startswith("tracks.csv") and 'on = "object"' in told
    else:
        assert min(lively) < 2.0 and any(abs(f / 3 - 1) < 0.01 for f in lively)
        assert not ring.warnings


def test_a_support_that_stands_still_takes_nothing_away():
    moved = swing(3.0, 0.05)[:, None, None] * UP
    ring = heard(moved, np.zeros((len(TIME), 1, 3)))
    assert ring.frequency == pytest.approx(heard(moved, moved[:, :0]).frequency, rel=1e-4)
    assert not ring.warnings


@pytest.mark.parametrize(("share", "kept"), [(0.5, True), (1.0, False)])
def test_a_mode_that_a_soft_support_goes_along_with_is_one(share, kept):
    """Half as far as the object it may go; what goes as far as that is no mode of it."""
    first, second = swing(3.0, 0.03), swing(17.0, 0.02)
    moved = first[:, None, None] * np.ones((3, 3)) + second[:, None, None] * ASIDE
    ring = heard(moved, share * first[:, None, None] * np.ones((1, 3)))
    assert any(abs(f / 3 - 1) < 0.02 for f in ring.frequency) == kept
    assert any(abs(f / 17 - 1) < 0.02 for f in ring.frequency)


@pytest.mark.parametrize("beside", ["a hum", "what dies at once"])
def test_the_only_mode_stays_whatever_the_support_does(beside):
    """What hums on, or is dead within a swing, is none that could be told instead."""
    others = {"a hum": np.cos(2 * np.pi * 13 * TIME), "what dies at once": swing(1.5, 0.7)}
    first = swing(3.0, 0.03)[:, None, None]
    moved = first * np.ones((3, 3)) + others[beside][:, None, None] * ASIDE
    ring = heard(moved, 0.9 * first * np.ones((1, 3)))
    assert any(abs(f / 3 - 1) < 0.02 for f in ring.frequency)


@pytest.mark.parametrize("readout", [0.0, 0.02])
@pytest.mark.parametrize("aside", [True, False])
def test_a_shake_is_seen_row_by_row_and_the_more_the_nearer(readout, aside):
    """The marker on the support is lower in the picture, and further from the lens."""
    size = (640, 480)
    camera = Camera(
        "pinhole", np.eye(3), np.zeros(3), 500.0, np.array([320.0, 240.0]), size, readout
    )
    places = np.array([[0.0, -0.1, 0.6], [0.1, -0.05, 0.6], [-0.1, 0.0, 0.62], [0.0, 0.3, 1.2]])
    late = readout * camera.project(places)[:, 1] / size[1]
    columns = []
    for n, place in enumerate(places):
        time = TIME + late[n]
        shake = 0.004 * swing(11.0, 0.004, time)
        moved = np.outer(0.006 * (n < 3) * swing(3.0, 0.03, time), [1.0, 0.3, 0.0])
        way = np.array([0.7, 0.7, 0.0])
        px = camera.project(place + moved + aside * np.outer(shake, way))
        columns.append(px + (not aside) * np.outer(shake, 700 * way[:2]))
    values = np.array(columns).swapaxes(0, 1)
    values = values + 0.05 * np.random.default_rng(0).standard_normal(values.shape)
    markers = tuple(
        Marker(f"m{n}", tuple(place), on="object" if n < 3 else "support")
        for n, place in enumerate(places)
    )
    take = Take(Recording(TIME, values, markers, camera, capture_fps=FPS), name="t")
    _, ring = listen(take, lambda time, signals: (0.0, time[-1]))
    assert any(abs(f / 3 - 1) < 0.02 for f in ring.frequency)
    assert not any(abs(f / 11 - 1) < 0.02 for f in ring.frequency)
