"""A rolling shutter: taken out exactly where it is known, found where it is not."""

import importlib

import numpy as np
import pytest

from core.pipeline import calibrate_case
from core.shutter import later, overtone
from tests.truth import film
from tests.truth.plant_camera import again

make = importlib.import_module("tests.truth.make")
SHARE = 0.95  # of a frame, from the first row to the last


def filmed(folder, kind, *, seed=2, snr=60):
    """The report of one planted swing: filmed at once, rolling and said so, rolling and not, or not
    and with the picture upside down.
    """
    rng = np.random.default_rng([seed, 7])
    stage, planted, _ = make.stand("rolling_shutter", seed, rng, {"takes": 1})
    shot = film.shoot(stage, planted, [SHARE])
    readout = SHARE / stage.fps
    assert shot.camera.readout == pytest.approx(readout)
    sigma = make.strength.spread(shot, stage) * 10 ** (-snr / 20)
    noise = sigma * np.random.default_rng(seed).standard_normal(shot.values.shape)
    values = shot.values
    if kind in ("at once", "turned"):
        own = {"at once": 0.0, "turned": -readout}[kind]
        values = film.look(again(shot, camera=make.replace(shot.camera, readout=own)))
    folder.mkdir(exist_ok=True)
    make.store(folder, kind, stage, shot, [values + noise], np.random.default_rng(0))
    case = folder / "case.toml"
    if kind == "said":
        text = case.read_text()
        assert "[camera]\n" in text
        case.write_text(text.replace("[camera]\n", f"[camera]\nreadout = {readout!r}\n"))
    kept = folder.parent / "kept.npz"
    return calibrate_case(case, elements=600, tets=kept).report, readout


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    base = tmp_path_factory.mktemp("rolling")
    return {kind: filmed(base / kind, kind) for kind in ("at once", "said", "unsaid", "turned")}


def test_a_known_rolling_shutter_leaves_no_trace_at_all(reports):
    plain, rolled = reports["at once"][0], reports["said"][0]
    assert plain["diagnosis"]["verdict"] == rolled["diagnosis"]["verdict"] == "adequate"
    for name in ("before", "after", "floor"):  # a thousandth of the motion's size, both
        assert rolled["error"][name] == pytest.approx(plain["error"][name], rel=0.02)
    values = [r["youngs_modulus"]["material"]["value"] for r in (plain, rolled)]
    assert values[0] == pytest.approx(values[1], rel=1e-5)
    assert len(plain["modes"]) == len(rolled["modes"]) > 2
    for one, other in zip(plain["modes"], rolled["modes"], strict=True):
        for key in ("natural_frequency_hz", "damping_ratio"):
            half = np.ptp(one[key]["ci95"]) / 2
            assert abs(one[key]["value"] - other[key]["value"]) < 2 * half  # other rows, same noise
        assert one["mac"] == pytest.approx(other["mac"], abs=1e-3)


def test_an_unknown_one_is_found_with_its_readout_and_then_leaves_no_trace(reports):
    plain, (found, readout) = reports["at once"][0], reports["unsaid"]
    assert found["error"]["before"] > 5 * plain["error"]["before"]
    (effect,) = found["diagnosis"]["effects"]
    assert effect["name"] == "rolling_shutter"
    assert effect["parameters"]["readout"]["value"] == pytest.approx(readout, rel=2e-3)
    assert found["error"]["after"] == pytest.approx(plain["error"]["after"], rel=0.02)
    assert found["youngs_modulus"]["material"]["value"] == pytest.approx(
        plain["youngs_modulus"]["material"]["value"], rel=1e-5
    )


def test_the_rows_of_a_picture_that_was_turned_are_read_from_below(reports):
    plain, (found, readout) = reports["at once"][0], reports["turned"]
    (effect,) = found["diagnosis"]["effects"]
    assert effect["name"] == "rolling_shutter"
    assert effect["parameters"]["readout"]["value"] == pytest.approx(-readout, rel=5e-3)
    assert found["error"]["after"] == pytest.approx(plain["error"]["after"], rel=0.02)


def test_a_free_swing_seen_later_is_that_swing():
    w, z = np.array([[20.0, 55.0]]), np.array([[0.1, 0.02]])
    t, d = np.linspace(0, 1, 60), np.array([[[0.03], [0.11]]])
    pole = w[0] * (-z[0] + 1j * np.sqrt(1 - z[0] ** 2))

    def swing(when):
        wave = (0.3 - 0.7j) * np.exp(pole * when[..., None])
        return wave.real, (pole * wave).real

    u, v = swing(t)
    seen = later(w, z, (u[None], v[None]), d)
    for channel, delay in enumerate(d[0, :, 0]):
        for one, truth in zip(seen, swing(t + delay), strict=True):
            assert np.abs(one[0, channel] - truth).max() < 1e-12


def test_rows_that_are_late_sound_at_twice_a_pitch_as_foretold():
    """Each sample is seen when its own row is read, and the row moves with the marker."""
    rng, zeta, height, readout = np.random.default_rng(3), 0.03, 720.0, 0.006
    # px: u and v of four markers, none in step with another
    shape = rng.uniform(10, 60, 8) * np.exp(2j * np.pi * rng.random(8))
    rest, time = rng.uniform(100, 600, 4), np.arange(400) / 100
    pole = 2 * np.pi * 4 * (-zeta + 1j * np.sqrt(1 - zeta**2))

    def place(when):
        return (shape * np.exp(pole * when)).real

    when = np.repeat(time[:, None], 8, axis=1)
    for _ in range(30):
        row = (rest + place(when)[:, 1::2]) / height
        when = time[:, None] + readout * np.repeat(row, 2, axis=1)
    columns = np.exp(np.outer(time, [pole, 2 * pole]))
    still = np.c_[np.ones(len(time)), np.exp(2 * pole.real * time)]  # a product's mean dies away
    basis = np.hstack([columns.real, -columns.imag, still])
    found = np.linalg.lstsq(basis, place(when), rcond=None)[0]
    first, double = found[:2] + 1j * found[2:4]
    # a marker's mean row turns both its amplitudes
    late = np.exp(pole * readout * np.repeat(rest, 2) / height)
    foretold = overtone(first / late, pole, readout / height) * late**2
    assert np.linalg.norm(double - foretold) < 0.02 * np.linalg.norm(double)
    backwards = np.linalg.norm(double - foretold.conj()) / np.linalg.norm(double)
    assert backwards > 0.5
