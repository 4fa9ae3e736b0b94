"""Keys follow a motion between frames; a pluck displaces exactly the vertex that was pulled."""

import numpy as np
import pytest

from core import bake
from core.data import Motion
from core.errors import DataError

F, Z = np.array([5.0, 13.0, np.nan]), np.array([0.03, 0.02, np.nan])


@pytest.fixture
def motion():
    rng = np.random.default_rng(1)
    time = np.linspace(0, 1.5, 1000)
    w = 2 * np.pi * F[:2] * time[:, None]
    weights = np.exp(-Z[:2] * w) * np.cos(w)
    weights = np.concatenate([weights, 0 * time[:, None]], axis=1) * [0.3, 0.1, 1]
    return Motion(("mode 1", "mode 2", "still"), rng.standard_normal((7, 3, 3)), time, weights)


def test_the_sampled_motion_converges_with_the_fourth_power_of_the_step():
    errors = []
    for n in (40, 80):
        time = np.linspace(0, 1, n + 1)
        motion = Motion(("a",), np.ones((1, 3, 1)), time, np.sin(6 * np.pi * time)[:, None])
        between = np.linspace(0.2, 0.8, 777)
        error = bake.sample(motion, between)[:, 0] - np.sin(6 * np.pi * between)
        errors.append(np.abs(error).max())
    assert 12 < errors[0] / errors[1] < 20


@pytest.mark.parametrize("fps", [2, 12, 24, 480])
def test_the_curve_between_keys_is_the_motion_at_every_rate(motion, fps):
    keys = bake.keys(motion, fps, first=10)
    time = np.linspace(0, 1.4, 500)
    h = (keys.frame[1] - keys.frame[0]) / fps
    i = np.clip((time / h).astype(int), 0, len(keys.frame) - 2)
    s = ((time / h) - i)[:, None]
    p0, p1 = keys.value[i], keys.value[i + 1]
    m0, m1 = keys.slope[i] * fps * h, keys.slope[i + 1] * fps * h
    curve = (
        (2 * s**3 - 3 * s**2 + 1) * p0
        + (s**3 - 2 * s**2 + s) * m0
        + (3 * s**2 - 2 * s**3) * p1
        + (s**3 - s**2) * m1
    )
    assert np.abs(curve - bake.sample(motion, time)).max() < 1e-4 * 0.3
    assert set(np.arange(10, 11 + int(1.5 * fps))) <= set(keys.frame)  # each whole frame has one
    if fps == 480:
        assert (np.diff(keys.frame) == 1).all()  # and no more than it needs


def test_only_shapes_that_move_are_baked_the_strongest_first_at_peak_one(motion):
    found = bake.strongest(motion, amplitude=2.0)
    assert sorted(found.names) == ["mode 1", "mode 2"]
    assert np.allclose(np.abs(found.weights).max(axis=0), 1)
    whole = np.einsum("vdk,tk->tvd", found.shapes, found.weights)
    assert np.allclose(whole, 2 * np.einsum("vdk,tk->tvd", motion.shapes, motion.weights))
    assert len(bake.strongest(motion, 1).names) == 1


def test_a_pluck_pulls_the_vertex_as_asked_and_lets_it_go_from_rest(motion):
    pull = np.array([0.0, 0.01, 0.0])
    found = bake.plucked(motion, F, Z, (4, pull))
    place = np.einsum("dk,tk->td", found.shapes[4], found.weights)
    assert np.isclose(place[0] @ pull, 1e-4, rtol=1e-9)
    soon = bake.sample(found, np.array([0, 1e-5]))
    speed = (soon[1] - soon[0])[:2] / 1e-5 / (2 * np.pi * F[:2] * soon[0, :2])
    assert (np.abs(speed) < 0.2 * Z[:2]).all()  # an undamped start would leave it at z
    assert (found.weights[:, 2] == 0).all()
    # a force, so each mode is bent by its flexibility: q ~ phi / w^2
    bend = found.weights[0, :2] / motion.shapes[4, 1, :2] * F[:2] ** 2
    assert np.isclose(bend[0], bend[1], rtol=1e-9)


def test_a_plucked_mode_crosses_zero_at_its_damped_period(motion):
    found = bake.plucked(motion, F, Z, (0, np.array([1e-3, 0, 0])))
    fine = np.linspace(0, 1, 200_001)
    wave = bake.sample(found, fine)[:, 0]
    crossings = fine[:-1][np.diff(np.sign(wave)) != 0]
    assert np.allclose(np.diff(crossings), 0.5 / (5.0 * np.sqrt(1 - 0.03**2)), atol=2e-5)


def test_a_cache_on_disk_is_the_header_and_the_places(motion, tmp_path):
    rest = np.arange(21.0).reshape(7, 3)
    bake.write_pc2(tmp_path / "a.pc2", rest, motion, (30, 24.0))
    raw = (tmp_path / "a.pc2").read_bytes()
    assert raw[:12] == b"POINTCACHE2\0"
    assert len(raw) == 32 + 30 * 7 * 3 * 4
    places = np.frombuffer(raw, "<f4", offset=32).reshape(30, 7, 3)
    truth = rest + np.einsum(
        "vdk,tk->tvd", motion.shapes, bake.sample(motion, np.arange(30) / 24.0)
    )
    assert np.allclose(places, truth, atol=2e-6)


def test_a_motion_survives_the_file_and_a_broken_file_is_refused(motion, tmp_path):
    bake.save_motion(tmp_path / "m.npz", motion, frequency=F)
    found, more = bake.load_motion(tmp_path / "m.npz")
    assert found.names == motion.names
    assert (found.weights == motion.weights).all()
    assert np.array_equal(more["frequency"], F, equal_nan=True)
    (tmp_path / "m.npz").write_bytes(b"nothing")
    with pytest.raises(DataError, match="not readable"):
        bake.load_motion(tmp_path / "m.npz")


@pytest.mark.parametrize(("pull", "why"), [((99, [0, 0, 1]), "vertex 99"), ((0, [0, 0, 0]), "0 m")])
def test_an_impossible_pluck_is_refused(motion, pull, why):
    with pytest.raises(DataError, match=why):
        bake.plucked(motion, F, Z, pull)


def test_a_motion_that_stands_still_is_refused(motion):
    still = Motion(motion.names, motion.shapes, motion.time, 0 * motion.weights)
    with pytest.raises(DataError, match="no shape moves"):
        bake.strongest(still)
