"""What the camera does: folds, a near lens, a pinhole's bend, a wrong clock; planted elsewhere."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import t

from core.baseline import real_shapes
from core.data import poles
from core.effects.aliasing import is_folded, unfolded
from core.effects.rolling_shutter import Ellipse, lag
from core.harmonic_inversion import invert
from core.match import mac, true_pitches
from core.pipeline import calibrate_case
from core.pursuit import is_driven, pursue
from core.settle import amplitudes
from tests.truth import make


@pytest.mark.parametrize("true", [30.27, 61.2, 104.9])
def test_a_fold_is_undone_from_nearby(true):
    seen = abs(true - 50 * round(true / 50))
    assert unfolded(seen, 1.02 * true, 50) == pytest.approx(true)


def test_a_pitch_that_fits_its_own_mode_or_none_is_not_unfolded():
    assert not is_folded(19.7, 20.0, 50)  # below half the rate
    assert not is_folded(40.0, 34.0, 60)  # its fold is 15 % off
    assert is_folded(19.73, 30.27, 50)


def test_only_the_folded_one_of_several_pitches_is_unfolded():
    computed = np.array([4.93, 11.01, 30.27])
    found = true_pitches(np.array([4.93, 11.04, 19.73]), (0, 1, 2), computed, 50)
    assert found == pytest.approx([4.93, 11.04, 30.27], rel=1e-3)


def test_a_tone_that_stays_while_all_else_dies_is_driven():
    dying, tone = poles(np.array([5.0]), np.array([0.03])), poles(np.array([7.0]), np.array([1e-5]))
    assert is_driven(tone, 3.0, np.r_[dying, tone]).all()
    assert not is_driven(dying, 3.0, np.r_[dying, tone]).any()
    assert not is_driven(tone, 3.0, tone).any()  # a fork that rings on and on


def test_a_fork_that_rings_on_beside_something_faint_that_dies_stays_a_mode():
    time = np.arange(360) / 120.0
    pole = poles(np.array([5.0, 11.0]), np.array([2e-4, 0.03]))
    amplitude = np.array([[10.0, 8.0], [0.2, -0.2]], complex)
    noise = 0.01 * np.random.default_rng(0).standard_normal((360, 2))
    values = (np.exp(np.outer(time, pole)) @ amplitude).real + noise
    order, _, _ = pursue(invert(time, values), time, values, np.full(2, 0.01))
    assert order[0] == 0


@pytest.mark.parametrize("wanders", ["creep", "bend"])
def test_a_mode_that_dies_soon_is_not_seen_to_move_as_the_mean_wanders(wanders):
    """Across the first one, and along neither of them the mean of every channel wanders."""
    time = np.arange(240) / 100.0
    pole = poles(np.array([4.4, 24.0]), np.array([0.03, 0.05]))
    first = np.array([1.0, 1.0, 1.0, -1.0, 0.0, 0.0])
    brief = np.array([0.0, 0.0, 0.0, 0.0, 0.3, -0.3])
    way = {"creep": np.exp(-time / 0.2), "bend": (time / 2.4 - 0.5) ** 2}[wanders]
    noise = 0.005 * np.random.default_rng(1).standard_normal((240, 6))
    values = (np.exp(np.outer(time, pole)) @ np.array([10 * first, brief], complex)).real
    values += np.outer(way, [1.0, 1.0, -1.0, 1.0, 2.0, 2.0]) + noise
    found = invert(time, values)
    order, shapes, _ = pursue(found, time, values, np.full(6, 0.005))
    assert len(order) == 2 and mac(shapes[1], brief) > 0.99
    data = SimpleNamespace(time=time, values=values, fit=np.ones(240, bool), late=None)
    ground = SimpleNamespace(takes=(data,), rings=(found,))
    bare = replace(found, degree=0, creep=())  # whatever the poles were chosen from
    shape = real_shapes(amplitudes(ground, 0, bare).amplitude)[0][order[1]]
    assert mac(shape, brief) > 0.99


def ellipse(rng, readout=0.0, wrong=0.0, noise=1.0):
    """A pair that swings in an ellipse at 5 Hz, seen by ten markers on as many rows."""
    directions, row = 100 * rng.standard_normal((2, 20)), np.repeat(rng.uniform(0, 1, 10), 2)
    pole = complex(poles(5.0, 0.02))
    true = directions + wrong * 100 * rng.standard_normal((2, 20))
    amplitude = (rng.standard_normal(2) + 1j * rng.standard_normal(2)) @ true
    amplitude = amplitude * np.exp(pole * readout * row)
    amplitude = amplitude + noise * (rng.standard_normal(20) + 1j * rng.standard_normal(20))
    return Ellipse(amplitude, directions, row, pole)


@pytest.mark.parametrize("readout", [0.016, -0.008])
def test_rows_that_lag_show_in_a_pairs_ellipse_and_the_interval_holds_the_readout(readout):
    rng, inside = np.random.default_rng(5), 0
    for _ in range(60):
        told = lag([ellipse(rng, readout)])
        assert told.certain
        inside += abs(told.readout - readout) < t.ppf(0.975, told.free) * told.sigma
    assert inside >= 51


@pytest.mark.parametrize("wrong", [0.0, 0.02, 0.2])
def test_shapes_that_are_not_the_bodys_are_no_rolling_shutter(wrong):
    rng = np.random.default_rng(6)
    assert not any(lag([ellipse(rng, wrong=wrong)]).certain for _ in range(60))


def test_two_channels_tell_nothing_of_a_pairs_rows():
    one = ellipse(np.random.default_rng(7), 0.016)
    few = Ellipse(one.amplitude[:2], one.directions[:, :2], one.row[:2], one.pole)
    assert lag([few]) is None


def planted(kind, seed, folder, **given):
    truth = make(kind, seed, folder, **given)
    result = calibrate_case(folder / "case.toml")
    return truth, result, result.report["diagnosis"]


def test_a_frame_lost_after_the_fitted_part_is_read_off_what_was_held_out(tmp_path):
    _, result, diagnosis = planted("lost_frames", 617, tmp_path)
    assert result.heard.declared.chi2 < 1.1 * result.heard.declared.samples  # all is well there
    assert [e["name"] for e in diagnosis["effects"]] == ["lost_frames"]
    assert result.report["error"]["after"] < 0.1 * result.report["error"]["before"]


@pytest.mark.slow
def test_a_folded_mode_is_named_with_its_true_pitch_and_baked_at_it(tmp_path):
    truth, result, diagnosis = planted("aliasing", 84, tmp_path)
    assert [e["name"] for e in diagnosis["effects"]] == ["aliasing"]
    told = diagnosis["effects"][0]["parameters"]["frequency"]["value"]
    assert told == pytest.approx(truth["parameters"]["aliasing"]["frequency"][0], rel=5e-4)
    first, last = result.report["error"]["chain"]
    assert last["fit"] < 0.7 * first["fit"]
    weight = result.motion.weights[:, 2]
    turns = np.flatnonzero(np.diff(np.sign(weight[: len(weight) // 4])))
    half = np.median(np.diff(result.motion.time[turns]))
    assert 0.5 / half == pytest.approx(told, rel=0.03)


@pytest.mark.slow
def test_a_fold_under_the_noise_is_told_as_minor(tmp_path):
    """The model is no worse for it, as far as this recording can say."""
    _, _, diagnosis = planted("aliasing", 84, tmp_path, snr=20)
    assert diagnosis["verdict"] == "adequate"
    assert [e["name"] for e in diagnosis["minor"]] == ["aliasing"]


@pytest.mark.slow
def test_a_near_lens_is_read_off_the_rest_places(tmp_path):
    truth, _, diagnosis = planted("perspective", 84, tmp_path)
    assert [e["name"] for e in diagnosis["effects"]] == ["perspective"]
    told = diagnosis["effects"][0]["parameters"]["distance"]
    assert told["value"] == pytest.approx(truth["parameters"]["perspective"]["distance"], rel=0.05)


@pytest.mark.slow
def test_a_declared_pinhole_bends_nothing_into_an_effect(tmp_path):
    truth, _, diagnosis = planted("poisson_ratio", 83, tmp_path)
    assert [e["name"] for e in diagnosis["effects"]] == ["poisson_ratio"]
    low, high = diagnosis["effects"][0]["parameters"]["value"]["ci95"]
    assert low < truth["parameters"]["poisson_ratio"]["value"] < high


@pytest.mark.slow
def test_a_wrong_clock_shows_where_the_sag_does_not_fit_the_pitch(tmp_path):
    truth, result, diagnosis = planted("clock", 84, tmp_path)
    assert diagnosis["effects"][0]["name"] == "clock"
    low, high = diagnosis["effects"][0]["parameters"]["factor"]["ci95"]
    assert low < truth["parameters"]["clock"]["factor"] < high
    modulus = result.report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.05)
