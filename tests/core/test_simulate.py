"""One mode that swings under each force: closed forms of oscillator theory."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from core.effects import air_drag, contact, dry_friction, large_amplitude, stiffness_drift
from core.effects.base import Setting
from core.simulate import free_swing, swing

OMEGA = np.array([2 * np.pi * 5.0])
AMPLITUDE = 0.01


def setting(zeta: float = 0.0) -> Setting:
    one = np.array([[1.0, 0.0, 0.0]])
    return Setting(
        omega=OMEGA,
        zeta=np.array([zeta]),
        couple=np.ones(1),
        places=np.zeros((1, 0)),
        levers=np.ones(1),
        planes=np.zeros((0, 2, 0)),
        skin=one,
        facing=one[:, :1],
        wind=one.T,
        amplitude=AMPLITUDE,
        masses=np.ones(1),
        modal_mass=0.02,
        drag_area=1e-3,
        duration=4.0,
        reference=np.ones((1, 1)),
    )


def run(effect, theta, amplitude=AMPLITUDE, seconds=4.0, zeta=0.0):
    time = np.linspace(0, seconds, 4001)
    start = np.array([[[amplitude], [0.0]]])
    forces = [(effect, np.array([theta], float))]
    u, _, _ = swing(OMEGA[None], np.array([[zeta]]), start, time[None], forces, setting())
    return time, u[0, :, 0]


def crossings(time, u):
    """Instants of upward crossings of zero."""
    i = np.flatnonzero((u[:-1] < 0) & (u[1:] >= 0))
    return time[i] - u[i] * (time[i + 1] - time[i]) / (u[i + 1] - u[i])


def peaks(u):
    inner = u[1:-1]
    return inner[(inner > u[:-2]) & (inner >= u[2:])]


def test_a_free_mode_swings_as_the_damped_oscillator():
    time, z = np.linspace(0, 2, 300), 0.07
    start = np.array([[[0.3], [1.2]]])
    u, v = free_swing(OMEGA[None], np.array([[z]]), start, time[None])
    w = OMEGA[0] * np.sqrt(1 - z**2)
    d = z * OMEGA[0]
    exact = np.exp(-d * time) * (0.3 * np.cos(w * time) + (1.2 + d * 0.3) / w * np.sin(w * time))
    assert np.abs(u[0, :, 0] - exact).max() < 1e-12
    assert abs(v[0, 0, 0] - 1.2) < 1e-12


@pytest.mark.parametrize("shift", [0.02, -0.02])
def test_pitch_follows_the_square_of_the_amplitude(shift):
    """Duffing's backbone curve df/f = shift (A/A0)^2, up to its next order."""
    for amplitude in (AMPLITUDE, AMPLITUDE / 2):
        at = crossings(*run(large_amplitude.EFFECT, (shift, 0.0), amplitude))
        pitch = (len(at) - 1) / (at[-1] - at[0])
        expected = shift * (amplitude / AMPLITUDE) ** 2
        assert abs(pitch / 5.0 - 1 - expected) < 2.5 * expected**2 + 1e-4


@pytest.mark.parametrize("shift", [0.05, -0.05])
def test_a_body_that_hardens_all_over_swings_by_its_strain_energy(shift):
    """Two modes that hang together by what both strain, by another integrator."""
    omega, ratio = OMEGA[0] * np.array([1.0, 1.7]), np.array([1.0, 0.6])  # m_1 / m_k
    start = np.array([[0.8 * AMPLITUDE, 0.5 * AMPLITUDE], [0.0, 0.1 * OMEGA[0] * AMPLITUDE]])

    def pull(_, state):
        u, v = state[:2], state[2:]
        energy = (omega**2 * u**2 / ratio).sum() / omega[0] ** 2
        return np.r_[v, -(omega**2) * u * (1 + (8 / 3) * shift * energy / AMPLITUDE**2)]

    time = np.linspace(0, 3, 3001)
    exact = solve_ivp(pull, (0, 3), start.ravel(), t_eval=time, rtol=1e-9, atol=1e-12).y[:2].T
    two = replace(setting(), omega=omega, zeta=np.zeros(2), couple=np.ones(2), masses=ratio)
    forces = [(large_amplitude.OVERALL, np.array([[shift, 0.0]]))]
    u, _, _ = swing(omega[None], np.zeros((1, 2)), start[None], time[None], forces, two)
    assert np.abs(u[0] - exact).max() < 0.02 * AMPLITUDE
    plain, _ = free_swing(omega[None], np.zeros((1, 2)), start[None], time[None])
    assert np.abs(plain[0] - exact).max() > 0.5 * AMPLITUDE


def test_dry_friction_takes_the_same_from_every_cycle():
    """4 F/k a cycle (Rayleigh), for a rub that slips at once."""
    share = 0.01
    tops = peaks(run(dry_friction.EFFECT, (share, np.log(3e-4)), seconds=3.0)[1])[:12]
    fall = -np.diff(tops)
    assert np.abs(fall - 4 * share * AMPLITUDE).max() < 0.1 * 4 * share * AMPLITUDE


def test_friction_stops_the_motion_dead():
    u = run(dry_friction.EFFECT, (0.05, np.log(1e-3)), seconds=4.0)[1]
    assert np.ptp(u[-500:]) < 0.02 * AMPLITUDE < np.ptp(u[:500])


def rubbed(effect, theta, start, seconds=1.5):
    """(T,) s and (T, 2) m of two modes of one pitch that move a place straight across each other,
    from start (2, 2).
    """
    two = replace(
        setting(), omega=OMEGA.repeat(2), zeta=np.zeros(2), couple=np.ones(2), masses=np.ones(2)
    )
    time = np.linspace(0, seconds, 1501)
    begun = AMPLITUDE * np.array(start, float)[None] * np.array([1.0, OMEGA[0]])[:, None]
    forces = [(effect, np.array([theta], float))]
    given = (two.omega[None], np.zeros((1, 2)), begun, time[None], forces)
    return time, swing(*given, replace(two, steps=256))[0][0]


def test_a_round_swing_that_rubs_in_a_plane_falls_as_a_spiral_does():
    """F w r is lost of w^2 r^2: the radius falls by F/2w a second."""
    share = 0.03
    theta = (share, np.log(1e-3), 0.0, 1.0)
    time, u = rubbed(dry_friction.IN_PLANE, theta, [[1.0, 0.0], [0.0, 1.0]])
    radius = np.linalg.norm(u, axis=1) / AMPLITUDE
    assert radius == pytest.approx(1 - share * OMEGA[0] / 2 * time, abs=0.01)


def test_a_straight_swing_rubs_in_a_plane_as_along_its_own_line():
    share, travel = 0.03, 0.02
    plane = (share, np.log(travel), 0.0, 1.0)
    line = (0.6 * share, np.log(travel / 0.6), 0.8 / 0.6)
    start = [[0.6, 0.8], [0.0, 0.0]]
    _, one = rubbed(dry_friction.IN_PLANE, plane, start)
    _, other = rubbed(dry_friction.EFFECT, line, start)
    assert one == pytest.approx(other, abs=1e-6 * AMPLITUDE)


def test_under_drag_the_inverse_amplitude_grows_in_proportion_to_time():
    """1/A = 1/A0 + 4 c w t / 3 pi for a force c |v| v per mass."""
    strength = 0.2
    time, u = run(air_drag.EFFECT, (strength,))
    tops = peaks(u)
    at = np.arange(1, len(tops) + 1) / 5.0
    slope = np.polyfit(at[5:], 1 / tops[5:], 1)[0]
    exact = 4 * (strength / AMPLITUDE) * OMEGA[0] / (3 * np.pi)
    assert abs(slope / exact - 1) < 0.03


def test_a_drifting_stiffness_is_followed_by_the_pitch():
    at = crossings(*run(stiffness_drift.EFFECT, (0.2, 0.0)))
    pitch = 1 / np.diff(at)
    middle = (at[1:] + at[:-1]) / 2
    assert np.abs(pitch - 5.0 * np.sqrt(1 + 0.2 * middle / 4.0)).max() < 0.02


def test_a_drift_may_level_off():
    at = crossings(*run(stiffness_drift.EFFECT, (0.2, 1.5)))
    pitch, s = 1 / np.diff(at), (at[1:] + at[:-1]) / 2 / 4.0
    assert np.abs(pitch - 5.0 * np.sqrt(1 + 0.2 * (1 - np.exp(-1.5 * s)) / 1.5)).max() < 0.02


@pytest.mark.parametrize("bend", [-0.5, 0.0, 1.5])
def test_a_bent_backbone_has_the_period_of_its_potential(bend):
    """T = 4 int_0^A dx / sqrt(2 (V(A) - V(x))), x = A sin a taking the root's end away."""

    def stored(x):
        y = x / AMPLITUDE
        odd = y**4 / 4 if bend == 0 else y**2 / (2 * bend) - np.log1p(bend * y**2) / (2 * bend**2)
        return OMEGA[0] ** 2 * AMPLITUDE**2 * (y**2 / 2 + 8 / 3 * 0.05 * odd)

    angle = (np.arange(20000) + 0.5) * np.pi / 40000
    x = AMPLITUDE * np.sin(angle)
    period = 4 * np.sum(
        AMPLITUDE * np.cos(angle) / np.sqrt(2 * (stored(AMPLITUDE) - stored(x)))
    ) * np.pi / 40000  # fmt: skip
    at = crossings(*run(large_amplitude.EFFECT, (0.05, bend)))
    assert abs((at[-1] - at[0]) / (len(at) - 1) / period - 1) < 1e-3


def test_a_stop_out_of_reach_changes_nothing():
    time, u = run(contact.ABOVE, (0.98, np.log(50.0)), amplitude=0.9 * AMPLITUDE)
    assert np.abs(u - 0.9 * AMPLITUDE * np.cos(OMEGA[0] * time)).max() < 1e-12


def test_a_stop_raises_the_pitch_and_is_on_its_side():
    """Released against the stop, the energy in it swings the mode further the other way."""
    above = run(contact.ABOVE, (0.5, np.log(3.0)))[1]
    assert above.max() < 1.01 * AMPLITUDE
    further = np.sqrt(1 + 3.0 * 0.5**2) * AMPLITUDE
    assert abs(-above.min() / further - 1) < 0.01
    at = crossings(*run(contact.ABOVE, (0.5, np.log(3.0))))
    assert (len(at) - 1) / (at[-1] - at[0]) > 5.05


def test_a_motion_that_runs_away_stays_finite():
    assert np.isfinite(run(large_amplitude.EFFECT, (-0.3, 4.0), amplitude=5 * AMPLITUDE)[1]).all()
