"""Harmonic inversion against closed forms, planted truths and the Cramer-Rao bound."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from core import varpro
from core.data import poles
from core.errors import RecordingError
from core.harmonic_inversion import fit_poles, invert


def ring(t, frequency, damping_ratio, amplitude):
    """(T, C) sum of damped modes; amplitude (m, C) complex at t = 0."""
    return (np.exp(np.outer(t, poles(frequency, damping_ratio))) @ np.asarray(amplitude)).real


def with_noise(y, decibel, seed):
    """`y` and white noise `decibel` below its rms."""
    level = np.sqrt(np.mean(y**2)) * 10 ** (-decibel / 20)
    return y + level * np.random.default_rng(seed).standard_normal(y.shape), level


def cramer_rao(t, frequency, damping_ratio, amplitude, level):
    """(2m,) bound on frequencies (Hz) and damping ratios, differencing model and offset."""
    amplitude = np.asarray(amplitude)
    m = len(frequency)

    def model(v):
        a = (v[2 * m : 3 * m] + 1j * v[3 * m : 4 * m])[:, None]
        return ring(t, v[:m], v[m : 2 * m], a)[:, 0] + v[4 * m]

    v = np.concatenate(
        [frequency, damping_ratio, amplitude[:, 0].real, amplitude[:, 0].imag, [0.0]]
    )
    steps = 1e-6 * np.eye(len(v))
    J = np.stack([(model(v + s) - model(v - s)) / 2e-6 for s in steps], axis=1)
    return np.sqrt(np.diag(np.linalg.inv(J.T @ J / level**2)))[: 2 * m]


PAIR = (np.array([3.1, 3.4]), np.array([0.02, 0.025]), np.array([[1.0], [1j]]))
FOUR_SECONDS = np.arange(120) / 30


def test_two_sines_with_slow_decays_come_back_to_six_digits():
    t = np.arange(10_000.0)
    y = np.exp(-1e-2 * t) * np.cos(2 * np.pi * 0.1 * t)
    y += 2 * np.exp(-1e-3 * t) * np.cos(2 * np.pi * 0.08 * t)
    found = invert(t, y)
    p = poles(found.frequency, found.damping_ratio)
    np.testing.assert_allclose(p.imag / (2 * np.pi), [0.08, 0.1], rtol=1e-6)
    np.testing.assert_allclose(-p.real, [1e-3, 1e-2], rtol=1e-6)
    np.testing.assert_allclose(np.abs(found.amplitude[:, 0]), [2, 1], rtol=1e-6)


def test_fifteen_strongly_damped_modes_in_128_samples_are_all_found():
    omega = [32.85, 36.51, 38.29, 48.82, 105.63, 146.96, 183.24, 191.10, 217.34, 241.39]
    omega = np.array([*omega, 253.59, 283.60, 298.20, 299.85, 304.95])  # rad/s
    decay = [4.61, 9.44, 12.95, 0.09, 9.24, 14.88, 10.19, 7.46, 11.21, 2.18]
    decay = np.array([*decay, 11.03, 9.64, 4.42, 12.25, 9.20])  # 1/s
    t = np.linspace(0, 1, 128)
    y = (np.exp(-np.outer(t, decay)) * np.cos(np.outer(t, omega))).sum(axis=1)
    found = invert(t, y)
    p = poles(found.frequency, found.damping_ratio)
    order = np.argsort(p.imag)
    np.testing.assert_allclose(p.imag[order], omega, atol=1e-8)
    np.testing.assert_allclose(-p.real[order], decay, atol=1e-8)


@pytest.mark.parametrize(
    ("decibel", "lost"), [(10, 2), (20, 0), pytest.param(30, 0, marks=pytest.mark.slow)]
)
def test_a_close_pair_is_told_apart_as_well_as_the_noise_allows(decibel, lost):
    f, z, a = PAIR
    clean = ring(FOUR_SECONDS, f, z, a)
    errors = []
    for seed in range(40):
        y, level = with_noise(clean, decibel, seed)
        found = invert(FOUR_SECONDS, y)
        if len(found.frequency) == 2:
            errors.append(np.sort(found.frequency) - f)
    assert len(errors) >= 40 - lost
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (rms < 1.3 * cramer_rao(FOUR_SECONDS, f, z, a, level)[:2]).all()


def test_a_mode_with_a_damping_ratio_of_forty_per_cent_is_found():
    y, _ = with_noise(ring(FOUR_SECONDS, [2.0], [0.4], [[1.0]]), 30, 1)
    found = invert(FOUR_SECONDS, y + 5)
    assert len(found.frequency) == 1
    assert abs(found.damping_ratio[0] - 0.4) < 4 * found.damping_sigma[0] < 0.2
    assert abs(found.frequency[0] - 2.0) < 4 * found.frequency_sigma[0] < 0.4


TRENDS = {
    "offset": lambda t: 30 + 0 * t,
    "drift": lambda t: 3 + 0.1 * t,
    "bend": lambda t: 3 + 0.05 * t**2,
    "creep": lambda t: 3 + 0.5 * np.exp(-t / 1.5),
}


@pytest.mark.parametrize("trend", TRENDS)
def test_a_slow_trend_neither_becomes_a_mode_nor_bends_one(trend):
    clean = ring(FOUR_SECONDS, [1.0], [0.05], [[1.0]])
    y, _ = with_noise(clean, 35, 3)
    found = invert(FOUR_SECONDS, y + TRENDS[trend](FOUR_SECONDS)[:, None])
    assert len(found.frequency) == 1
    assert abs(found.frequency[0] - 1.0) < 4 * found.frequency_sigma[0] < 0.02
    assert abs(found.damping_ratio[0] - 0.05) < 4 * found.damping_sigma[0] < 0.02


def test_one_period_on_an_offset_has_the_right_pitch():
    t = np.arange(60) / 30
    y, _ = with_noise(ring(t, [0.5], [0.03], [[1.0]]), 40, 4)
    found = invert(t, y + 10)
    assert abs(found.frequency[0] / 0.5 - 1) < 0.01


def test_a_close_pair_of_two_shapes_stays_two_modes_beside_what_is_no_mode():
    t = np.arange(106) / 100
    angles = np.linspace(0.1, 1.4, 8)
    shapes = np.array([13 * np.cos(angles), 1.7 * np.sin(angles)])  # MAC 0.4
    y = ring(t, np.array([5.39, 5.02]), np.array([0.054, 0.06]), shapes)
    y += 0.02 * np.cos(angles) * np.sign(np.sin(40 * t**2))[:, None]  # neither swing nor noise
    y += 0.008 * np.random.default_rng(3).standard_normal(y.shape)
    found = invert(t, y, noise=np.full(8, 0.008))
    low, high = sorted(found.frequency)[:2]
    assert (low, high) == (pytest.approx(5.02, rel=0.01), pytest.approx(5.39, rel=0.003))


@pytest.mark.parametrize("loud", [0.5, 3.0], ids=["the mode", "the drive"])
def test_a_drive_beside_a_mode_moves_as_that_does_and_both_are_heard(loud):
    """It goes on as it is while the mode dies; `loud`: the drive's swing over the mode's."""
    t = np.arange(232) / 200
    shape = np.random.default_rng(2).standard_normal(10)
    y = ring(t, np.array([25.4, 24.1]), np.array([0.027, 0.0]), np.outer([1.0, loud], shape))
    y += 0.02 * np.random.default_rng(3).standard_normal(y.shape)
    found = invert(t, y, noise=np.full(10, 0.02))
    assert sorted(found.frequency) == pytest.approx([24.1, 25.4], rel=1e-3)
    assert found.damping_ratio.max() == pytest.approx(0.027, rel=0.05)


def test_pure_noise_has_no_modes():
    rings = 0
    for seed in range(100):
        noise = np.random.default_rng(seed).standard_normal((120, 1 + seed % 3))
        rings += len(invert(FOUR_SECONDS, noise).frequency) > 0
    assert rings <= 2


def test_a_record_at_rest_has_no_modes():
    for y in (np.zeros((120, 2)), np.ones((120, 3)), np.outer(FOUR_SECONDS, [1.0, -2.0])):
        assert not len(invert(FOUR_SECONDS, y).frequency)


@pytest.mark.parametrize("decibel", [20, 60])
def test_motion_that_is_not_linear_is_one_mode_with_a_wide_interval(decibel):
    steps, x, v, track = 40, 1.0, 0.0, []
    h = 1 / 30 / steps
    for _ in FOUR_SECONDS:  # pitch falls from 2.25 to 2 Hz as the amplitude does
        track.append(x)
        for _ in range(steps):
            v -= h * ((4 * np.pi) ** 2 * (x + 0.4 * x**3) + 0.04 * 4 * np.pi * v)
            x += h * v
    shape = np.random.default_rng(0).standard_normal(8)
    y, _ = with_noise(np.outer(track, shape), decibel, 0)
    found = invert(FOUR_SECONDS, y)
    assert len(found.frequency) == 1
    assert 2.0 < found.frequency[0] < 2.25
    assert found.frequency_sigma[0] > 2e-3


def test_a_pair_of_equal_pitch_and_different_shape_stays_a_pair():
    shapes = np.random.default_rng(1).standard_normal((2, 8))
    y, _ = with_noise(ring(FOUR_SECONDS, [3.0, 3.06], [0.02, 0.02], shapes), 30, 1)
    found = invert(FOUR_SECONDS, y)
    order = np.argsort(found.frequency)
    assert len(order) == 2
    pull = (found.frequency[order] - [3.0, 3.06]) / found.frequency_sigma[order]
    assert (np.abs(pull) < 4).all()


def coverage(seeds):
    """(4,) share of 95 % intervals that hold the truth: two frequencies, two damping ratios."""
    f, z = np.array([2.0, 4.5]), np.array([0.03, 0.02])
    clean = ring(FOUR_SECONDS, f, z, [[1.0, 0.4], [0.5j, -0.8]])
    inside = []
    for seed in range(seeds):
        y, _ = with_noise(clean, 25, seed)
        found = invert(FOUR_SECONDS, y, max_modes=3)
        assert len(found.frequency) == 2
        order = np.argsort(found.frequency)
        pull_f = (found.frequency[order] - f) / found.frequency_sigma[order]
        pull_z = (found.damping_ratio[order] - z) / found.damping_sigma[order]
        inside.append(np.abs(np.concatenate([pull_f, pull_z])) < 1.96)
    return np.mean(inside, axis=0)


def test_intervals_hold_the_truth_95_times_in_100():
    share = coverage(120).mean()  # 480 intervals: standard deviation 1 %
    assert 0.95 - 0.03 < share < 0.95 + 0.03


def test_the_interval_said_is_the_cramer_rao_bound():
    f, z, a = PAIR
    clean, said = ring(FOUR_SECONDS, f, z, a), []
    for seed in range(12):
        y, level = with_noise(clean, 30, seed)
        found = fit_poles(FOUR_SECONDS, y, f, z)
        order = np.argsort(found.frequency)
        said.append(np.concatenate([found.frequency_sigma[order], found.damping_sigma[order]]))
    bound = cramer_rao(FOUR_SECONDS, f, z, a, level)
    np.testing.assert_allclose(np.mean(said, axis=0), bound, rtol=0.08)


@pytest.mark.slow
def test_intervals_hold_the_truth_93_to_97_times_in_100_over_a_thousand_seeds():
    share = coverage(1000)
    assert ((share > 0.93) & (share < 0.97)).all()


def test_sigma_falls_as_the_root_of_the_number_of_channels():
    sigma = {}
    for channels in (1, 4, 16):
        found = []
        for seed in range(10):
            clean = ring(FOUR_SECONDS, [3.0], [0.03], np.ones((1, channels)))
            y, _ = with_noise(clean, 20, seed)
            found.append(invert(FOUR_SECONDS, y, max_modes=2))
        sigma[channels] = np.mean([r.frequency_sigma[0] for r in found])
        pulls = [(r.frequency[0] - 3.0) / r.frequency_sigma[0] for r in found]
        assert np.sqrt(np.mean(np.square(pulls))) < 2
    assert abs(sigma[1] / sigma[4] / 2 - 1) < 0.1
    assert abs(sigma[1] / sigma[16] / 4 - 1) < 0.1


def test_a_noisy_channel_does_not_spoil_a_clean_one():
    rng = np.random.default_rng(0)
    noise = np.array([0.01, 1.0])
    y = ring(FOUR_SECONDS, [3.0], [0.03], [[1.0, 1.0]]) + noise * rng.standard_normal((120, 2))
    both = invert(FOUR_SECONDS, y)
    alone = invert(FOUR_SECONDS, y[:, :1])
    assert both.frequency_sigma[0] < 1.05 * alone.frequency_sigma[0]


def test_missing_samples_are_left_out_not_made_up():
    f, z = np.array([2.0, 5.3]), np.array([0.04, 0.02])
    rng = np.random.default_rng(7)
    y, _ = with_noise(ring(FOUR_SECONDS, f, z, rng.standard_normal((2, 6))), 35, 7)
    y[rng.random(120) < 0.3, 0:2] = np.nan
    y[30:50, 2:4] = np.nan
    y[70:75] = np.nan
    found = invert(FOUR_SECONDS, y)
    order = np.argsort(found.frequency)
    assert (np.abs(found.frequency[order] - f) < 4 * found.frequency_sigma[order]).all()
    assert (np.abs(found.damping_ratio[order] - z) < 4 * found.damping_sigma[order]).all()


def test_uneven_frames_are_taken_at_their_own_instants():
    f, z = np.array([2.0, 5.3]), np.array([0.04, 0.02])
    rng = np.random.default_rng(8)
    t = FOUR_SECONDS + rng.uniform(-0.4, 0.4, 120) / 30
    y, _ = with_noise(ring(t - t[0], f, z, rng.standard_normal((2, 4))), 40, 8)
    found = invert(t, y)
    order = np.argsort(found.frequency)
    assert (np.abs(found.frequency[order] - f) < 4 * found.frequency_sigma[order]).all()
    assert (found.frequency_sigma < 3e-3).all()


def test_colour_in_the_noise_widens_the_interval():
    rng = np.random.default_rng(9)
    white = rng.standard_normal((400, 1))
    t = np.arange(400) / 100
    red = np.zeros_like(white)
    for i in range(1, 400):
        red[i] = 0.9 * red[i - 1] + white[i]
    clean = ring(t, [1.5], [0.03], [[1.0]])
    wide, narrow = (invert(t, clean + 0.05 * n / n.std(), max_modes=1) for n in (red, white))
    assert wide.frequency_sigma[0] > 1.8 * narrow.frequency_sigma[0]


def test_prediction_gives_the_motion_back():
    clean = ring(FOUR_SECONDS, PAIR[0], PAIR[1], [[1.0, 0.3j], [0.2, 1.0]]) + np.array([3.0, -2])
    found = invert(FOUR_SECONDS + 7, clean)
    np.testing.assert_allclose(found.predict(FOUR_SECONDS + 7), clean, atol=1e-9)


def test_strongest_mode_comes_first():
    clean = ring(FOUR_SECONDS, [2.0, 5.0], [0.03, 0.02], [[0.2, 0.1], [1.0, 1.0]])
    found = invert(FOUR_SECONDS, with_noise(clean, 40, 0)[0])
    assert found.frequency[0] == pytest.approx(5.0, abs=0.01)


def test_frames_before_the_release_are_left_out():
    t = np.arange(180) / 30
    y = np.where(t[:, None] < 2, 1.0, ring(t - 2, [2.0], [0.05], [[1.0]]))
    found = invert(t, with_noise(y, 40, 0)[0], t0=2.0)
    assert found.t0 == 2.0
    assert abs(found.frequency[0] - 2.0) < 4 * found.frequency_sigma[0]


def test_fitting_given_poles_agrees_with_finding_them():
    clean = ring(FOUR_SECONDS, PAIR[0], PAIR[1], PAIR[2])
    y, _ = with_noise(clean, 30, 2)
    found = invert(FOUR_SECONDS, y)
    start = fit_poles(FOUR_SECONDS, y, [3.0, 3.5], [0.03, 0.03])
    np.testing.assert_allclose(start.frequency, found.frequency, rtol=1e-6)
    np.testing.assert_allclose(start.covariance, found.covariance, rtol=1e-3, atol=1e-12)


def test_extra_columns_take_out_a_disturbance_exactly():
    ramp = np.exp(-FOUR_SECONDS / 0.7)[:, None]
    y = ring(FOUR_SECONDS, [2.0], [0.05], [[1.0, 0.5]]) + ramp * [2.0, -3.0] + 1
    found = fit_poles(FOUR_SECONDS, y, [2.1], [0.03], extra_basis=ramp)
    assert found.frequency[0] == pytest.approx(2.0, abs=1e-9)
    assert found.damping_ratio[0] == pytest.approx(0.05, abs=1e-9)


def test_an_undamped_line_stays_within_its_bound():
    y, _ = with_noise(ring(FOUR_SECONDS, [2.0], [0.0], [[1.0]]), 30, 5)
    found = fit_poles(FOUR_SECONDS, y, [2.02], [0.01])
    assert 0 <= found.damping_ratio[0] < 4 * found.damping_sigma[0]


def test_given_poles_can_be_kept():
    y, _ = with_noise(ring(FOUR_SECONDS, [2.0], [0.05], [[1.0]]), 30, 6)
    found = fit_poles(FOUR_SECONDS, y, [2.3], [0.05], fit=False)
    assert found.frequency[0] == pytest.approx(2.3, rel=1e-12)


@pytest.mark.parametrize(
    ("time", "signals", "said"),
    [
        (np.arange(5.0), np.zeros((5, 1)), "5 frames"),
        (np.arange(50.0)[::-1], np.zeros((50, 1)), "goes back"),
        (np.arange(50.0), np.full((50, 2), np.nan), "2 of 2 channels"),
        (np.arange(50.0), np.zeros((40, 2)), "do not belong together"),
    ],
)
def test_too_little_data_is_refused(time, signals, said):
    with pytest.raises(RecordingError, match=said):
        invert(time, signals)


@pytest.mark.parametrize("seed", [62, 98, 106, 315])
def test_no_step_of_a_fit_lands_beyond_half_the_frame_rate(seed):
    """Every pitch has a double there that fits as well; a pitch that drifts makes long steps."""
    rng = np.random.default_rng(seed)
    t = np.arange(200) / 100.0
    pitch, drift = rng.uniform(3, 5), rng.uniform(-0.1, 0.1)
    wave = np.exp(-0.3 * t) * np.cos(2 * np.pi * pitch * (t + drift * t**2 / 2))
    values = wave[:, None] * rng.normal(size=(1, 3)) + 1e-3 * rng.normal(size=(200, 3))
    begin = 2 * np.pi * pitch * np.array([rng.uniform(0.8, 1.2), rng.uniform(0.9, 1.5)])
    start = varpro.Poles(np.array([0.3, 0.5]), begin, np.zeros(0))
    found = varpro.fit(t, values, np.ones((200, 1)), start)
    assert found.poles.omega.max() < 1.001 * np.pi * 100


def test_what_swings_loudly_is_a_mode_though_its_pitch_jumps():
    """No sum of damped sinusoids is like it, yet half of it and more is one."""
    rng = np.random.default_rng(4)
    time = np.arange(400) / 60
    phase = 2 * np.pi * np.cumsum(np.where(time < 3.8, 3.03, 2.87)) / 60
    shape = rng.standard_normal(12)
    y = np.outer(10 * np.exp(-0.1 * time) * np.cos(phase), shape) + rng.standard_normal((400, 12))
    found = invert(time, y, noise=np.ones(12))
    assert len(found.frequency) >= 1
    assert 2.8 < found.frequency[0] < 3.1


def test_normal_equations_and_orthogonal_ones_give_the_same_poles(monkeypatch):
    """Where every marker lacks other samples, and where none lacks any."""
    generator = np.random.default_rng(5)
    t = np.arange(200) / 100.0
    truth = varpro.Poles(np.array([0.8, 1.1]), np.array([31.0, 52.0]), np.zeros(0))
    whole = varpro.basis(t, truth) @ generator.normal(size=(4, 5))
    whole += 1e-3 * generator.standard_normal(whole.shape)
    patchy = whole.copy()
    for channel in range(4):
        patchy[generator.integers(len(t), size=7), channel] = np.nan
    near = varpro.Poles(1.1 * truth.decay, 1.01 * truth.omega, truth.creep)
    for y in (whole, patchy):
        found = []
        for least in (varpro.APART, np.inf):
            monkeypatch.setattr(varpro, "APART", least)
            found.append(varpro.fit(t, y, np.ones((len(t), 1)), near, noise=np.full(5, 1e-3)))
        one, other = found
        assert one.poles.vector == pytest.approx(other.poles.vector, rel=1e-8)
        assert one.amplitude == pytest.approx(other.amplitude, rel=1e-6)
        assert one.information == pytest.approx(other.information, rel=1e-6, abs=1e-6)
        assert one.residual == pytest.approx(other.residual, abs=1e-9, nan_ok=True)
        monkeypatch.undo()


@pytest.mark.parametrize("decay", [2e4, 3.6e4, 8e4])
def test_a_pole_that_dies_within_a_frame_is_no_overflow(decay):
    t = np.arange(60) / 100
    y = np.outer(np.exp(-2 * t) * np.cos(40 * t), [1.0, 0.5])
    y += 0.01 * np.random.default_rng(0).standard_normal(y.shape)
    start = varpro.Poles(np.array([2.0, decay]), np.array([40.0, 900.0]), np.zeros(0))
    with np.errstate(over="raise", invalid="raise"):
        found = varpro.fit(t, y, np.ones((60, 1)), start, noise=np.full(2, 0.01))
    assert found.poles.omega[0] == pytest.approx(40, rel=0.02)
    assert np.isfinite(found.amplitude).all()


def test_what_a_stop_cuts_short_swings_nevertheless():
    """Two modes before a hard stop: no sum of a few dying swings, and not one of them is needed."""
    f, z, gap, hard = (
        np.array([5.789457, 15.723984]),
        np.array([0.0074717, 0.0275387]),
        2.4692e-3,
        2.29322e5,
    )
    w, tip = 2 * np.pi * f, np.array([1.0, 0.537869])

    def pushed(_, state):
        q, v = state[:2], state[2:]
        return np.r_[v, -(w**2) * q - 2 * z * w * v + tip * hard * max(-gap - q @ tip, 0)]

    t = np.arange(1818) / 400
    go = solve_ivp(
        pushed, (0, t[-1]), [5e-3, 0, 0, 0], t_eval=t, rtol=1e-8, atol=1e-10, max_step=2e-4
    )
    shapes = np.array([np.linspace(0.1, 1, 8), np.linspace(-1, 1, 8)])
    y = go.y[:2].T @ shapes + 1e-6 * np.random.default_rng(57).standard_normal((len(t), 8))
    found = invert(t, y, noise=np.full(8, 1e-6))
    assert len(found.frequency) >= 1
    assert abs(found.frequency[0] / f[0] - 1) < 0.1


@pytest.mark.parametrize("seed", [3, 11])
def test_a_walk_that_no_few_swings_tell_has_none(seed):
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.standard_normal((600, 4)), axis=0)
    y = walk + 0.1 * rng.standard_normal(walk.shape)
    assert not len(invert(np.arange(600) / 60, y, noise=np.full(4, 0.1)).frequency)
