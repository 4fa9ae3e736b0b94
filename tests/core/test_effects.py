"""What holds for every effect of the library."""

import importlib
import pkgutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from core import effects
from core.case_schema import EFFECT_NAMES
from core.channels import reaches
from core.conditions import common
from core.data import Camera, RingDown
from core.effects import (
    BY_NAME,
    TIME_EFFECTS,
    asymmetric_stiffness,
    base_motion,
    further_mode,
    graded_stiffness,
    lost_frames,
    partner,
    relaxation,
    steady_drive,
    tracker_drift,
)
from core.linear_part import TIE, _ties
from core.match import Match, match_modes
from core.read_off import _likeliest
from core.simulate import swing
from core.unheard import neighbours
from tests.core.test_simulate import AMPLITUDE, OMEGA, setting

FILES = sorted({m.name for m in pkgutil.iter_modules(effects.__path__)} - {"base", "partner"})
OWN = {
    "further_mode",
    "sudden_change",
    "weakening_friction",
}  # what an effect is weighed beside or against
NEUTRAL = {
    "large_amplitude": (0.0, 0.0),
    "asymmetric_stiffness": (0.0, 1.5),
    "contact": (0.98, np.log(0.01)),
    "dry_friction": (0.0, np.log(0.01)),
    "air_drag": (0.0,),
    "stiffness_drift": (0.0, 1.0),
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_tells_law_signs_twins_and_source(name):
    text = importlib.import_module(f"core.effects.{name}").__doc__
    for line in ("Law  ", "Tells  ", "Looks like  ", "Source  "):
        assert f"\n{line}" in text, line


@pytest.mark.parametrize("name", [name for name in FILES if name not in OWN])
def test_a_file_bears_a_name_of_the_contract(name):
    assert name in EFFECT_NAMES


@pytest.mark.parametrize("effect", BY_NAME.values(), ids=lambda e: e.name)
def test_twins_are_effects_of_the_contract_and_something_settles_them(effect):
    assert set(effect.twins) <= set(EFFECT_NAMES)
    assert len(effect.settle) > 20


@pytest.mark.parametrize("effect", [e for e in TIME_EFFECTS if e.name in NEUTRAL])
def test_no_strength_is_no_effect(effect):
    time = np.linspace(0, 2, 500)
    start = np.array([[[0.9 * AMPLITUDE], [0.0]]])
    theta = np.array([NEUTRAL[effect.name]], float)
    args = (OMEGA[None], np.array([[0.02]]), start, time[None])
    with_it = swing(*args, [(effect, theta)], setting())[0]
    without = swing(*args, [], setting())[0]
    assert np.abs(with_it - without).max() < 1e-12


@pytest.mark.parametrize("ratio", [0.1, 0.4, 1.0, 2.5, 10.0])
def test_an_exponential_gradient_is_told_by_few_powers(ratio):
    s = np.linspace(0, 1, 101)
    told = np.polynomial.polynomial.polyval(s, graded_stiffness.powers(ratio))
    assert np.abs(told / ratio**s - 1).max() < 3e-3


def test_a_gradient_that_hardly_is_one_has_all_powers_too():
    """The last ones may cancel to nought."""
    ratios = 1 + np.linspace(-0.01, 0.01, 2001)
    assert {len(graded_stiffness.powers(one)) for one in ratios} == {graded_stiffness.DEGREE + 1}


@pytest.mark.parametrize("noise", [0.03, 0.3, 1.0])
def test_a_shaken_path_is_cleared_of_noise_and_its_gaps_are_bridged(noise):
    rng = np.random.default_rng(5)
    time = np.arange(600) / 120
    waves = [(0.4, 0.3), (1.1, 1.0), (2.3, 0.5), (5.2, 0.2)]  # Hz, size
    path = sum(a * np.sin(2 * np.pi * f * time + a) for f, a in waves)
    seen = path + noise * rng.standard_normal(600)
    seen[200:204] = np.nan
    left = base_motion.clear(seen, noise**2) - path
    assert np.sqrt(np.mean(left**2)) < 0.7 * noise
    assert np.abs(base_motion.clear(path, 0.0) - path).max() < 1e-9


def supported(ways, noise=0.05, name="take"):
    """A take in which two markers on the support go `ways` (n, 3), and one elsewhere otherwise."""
    rng = np.random.default_rng(4)
    recording = SimpleNamespace(start=0.0, stop=None)
    values = np.hstack([ways, ways, ways[::-1, ::-1]])
    return SimpleNamespace(
        take=SimpleNamespace(name=name, recording=recording),
        time=np.arange(len(ways)) / 120,
        marker=np.repeat([0, 1, 2], 3),
        support=np.repeat([True, True, False], 3),
        values=values + noise * rng.standard_normal(values.shape),
        sigma=np.full(9, noise),
    )


def test_a_support_is_heard_along_every_way_that_it_goes():
    time = np.arange(600) / 120
    one, other = np.sin(2 * np.pi * 1.1 * time), np.sin(2 * np.pi * 2.3 * time + 1)
    along, across = np.outer(one, [1.0, 0.5, 0.0]), np.outer(other, [0.0, 0.3, 0.4])
    (line,) = base_motion.support_paths([supported(along)])
    ((_, ways),) = line.values()
    assert ways.shape == (1, 600)
    _, plane = base_motion.support_paths([supported(along + across)])
    ((_, ways),) = plane.values()
    assert ways.shape == (2, 600)
    for path in (one - one.mean(), other - other.mean()):
        left = path - np.linalg.lstsq(ways.T, path, rcond=None)[0] @ ways
        assert np.sqrt(np.mean(left**2)) < 0.05
    # in another take only does it go the other way
    _, plane = base_motion.support_paths([supported(along), supported(across, name="other")])
    assert [ways.shape for _, ways in plane.values()] == [(2, 600), (2, 600)]
    assert base_motion.support_paths([supported(along[:10])]) == []


@pytest.mark.parametrize(
    ("size", "noise", "count"),
    [(0.15, 0.001, 2), (0.08, 0.001, 1), (0.3, 0.1, 2), (0.3, 0.8, 1)],
    ids=["it shows", "beside the largest a trifle", "above the noise", "within the noise"],
)
def test_a_way_counts_beside_the_largest_and_above_the_noise(size, noise, count):
    time = np.arange(600) / 120
    one, other = np.sin(2 * np.pi * 1.0 * time), np.sin(2 * np.pi * 2.0 * time)
    moved = np.outer(one, [1.0, 0.0, 0.0]) + size * np.outer(other, [0.0, 1.0, 0.0])
    assert len(base_motion.support_paths([supported(moved, noise)])) == count


def test_a_body_on_a_support_answers_each_way_in_each_of_its_modes_as_they_are():
    """What a fit moves of one mode's pitch moves that mode's answers only."""
    time = np.arange(600) / 120
    ways = np.array([np.sin(2 * np.pi * 1.1 * time), np.sin(2 * np.pi * 2.3 * time)])
    path = {("take", 0.0, None): (time, ways)}
    effect = base_motion.shaken((np.zeros((600, 9)),), 0.1, 0, path)
    there = effect.beside_in(supported(ways[[0, 1, 0]].T).take)
    omega, zeta = np.array([[6.0, 15.0], [6.3, 15.0]]), np.full((2, 2), 0.03)
    moved = there(None, omega, zeta, np.tile(time, (2, 1)))
    assert moved.shape == (2, 600, 4)
    apart = np.abs(moved[1] - moved[0]).max(axis=0)
    expected = [base_motion.answer(w, 0.03, time, s) for w in omega[0] for s in ways]
    assert np.allclose(moved[0].T, expected)
    assert (apart[:2] > 0.01).all() and (apart[2:] == 0).all()


def test_what_was_held_briefly_may_creep_more_than_it_showed():
    theta, pose = np.array([np.log(2.0)]), np.array([1.0, 2.0])
    plain = replace(setting(), pose=pose)
    shown = relaxation.report(theta, plain, 0.3 * pose[:, None])
    (most,) = relaxation.alike(theta, plain, 0.3 * pose[:, None])
    assert shown == {"ratio": pytest.approx(0.3), "time": pytest.approx(2.0 / 1.3)}
    held = 0.5  # of its time: so much of the branch has let go by then
    assert most["ratio"] * (1 - np.exp(-held)) == pytest.approx(shown["ratio"])
    assert most["time"] * (1 + most["ratio"]) == pytest.approx(2.0)


def test_what_a_blow_leaves_behind_tells_the_branch_that_was_not_held():
    """Struck from rest, a body creeps but as far as the blow, in its moment, drives it."""
    w, z, r, time, v = 2 * np.pi * 4.0, 0.02, 0.25, 0.8, 0.3

    def pull(_, state):
        u, speed, s = state
        return [speed, -2 * z * w * speed - w**2 * (u + r * (u - s)), (u - s) / time]

    t = np.linspace(0, 4, 2001)
    moved = solve_ivp(pull, (0, 4), [0, v, 0], t_eval=t, rtol=1e-10, atol=1e-13).y[0]
    poles = np.linalg.eigvals([[0, 1, 0], [-(w**2) * (1 + r), -2 * z * w, r * w**2],
                               [1 / time, 0, -1 / time]])  # fmt: skip
    waves = np.exp(np.outer(t, poles))
    at = int(np.argmin(np.abs(poles.imag)))
    slow = np.linalg.lstsq(waves, moved, rcond=None)[0][at].real
    theta = np.array([np.log(-1 / poles[at].real)])
    omega = np.abs(poles[at - 1])
    struck = replace(setting(), pose=np.array([v / omega]), blow=np.array([v / omega**2]))
    told = relaxation.report(theta, struck, np.array([[slow]]))
    assert told["ratio"] == pytest.approx(r, rel=0.03)
    assert told["time"] == pytest.approx(time, rel=0.03)
    held = relaxation.report(theta, replace(struck, blow=None), np.array([[slow]]))
    assert held["ratio"] < r / 5
    assert relaxation.alike(theta, struck, np.array([[slow]])) == []


@pytest.mark.parametrize(
    ("frames", "whole"), [(1.1, True), (-1.9, True), (0.5, False), (0.1, False), (2.4, False)]
)
def test_a_jump_is_of_whole_frames(frames, whole):
    assert lost_frames.is_whole(frames) == whole


def test_a_recording_with_many_jumps_or_a_long_one_is_not_worth_mending():
    data = SimpleNamespace(time=np.linspace(0, 8.0, 481))
    short = [(0.5 * n, 1 / 60) for n in range(6)]
    assert not lost_frames.too_many(short, data)
    assert lost_frames.too_many([*short, (7.0, -1 / 60)], data)
    assert lost_frames.too_many([(1.0, 1.5), (2.0, -1.5)], data)


def test_jumps_that_cancel_are_none():
    frame = 0.016667  # of 60 a second, as it is written
    jumps = [(2.5 * frame, frame), (181.5 / 60, frame)]
    assert lost_frames.gathered(jumps, [(181.5 * frame, -frame)], frame) == (jumps[0],)


@pytest.mark.parametrize(("times", "is_one"), [(1.5, True), (3.0, False)])
def test_a_return_slower_than_the_record_is_one_until_it_is_no_more_than_an_offset(times, is_one):
    plain = setting()
    theta = [np.log(times * plain.duration)]
    assert (relaxation.unseen(np.array(theta), plain) == "") is is_one


def test_a_marker_wanders_in_parts_no_shorter_than_a_swing():
    plain, time = setting(), np.linspace(0, 4.0, 200)[None]
    brief = replace(plain, duration=7 / 5)  # of 5 Hz
    few = tracker_drift.wander((0,), ["m"]).columns(np.zeros((1, 0)), plain, time, None)
    fine = tracker_drift.wander((0,), ["m"], fine=True)
    assert few.shape[2] == 5
    assert fine.columns(np.zeros((1, 0)), plain, time, None).shape[2] == 20
    assert fine.columns(np.zeros((1, 0)), brief, time, None).shape[2] == 7


def test_a_further_mode_is_one_while_it_keeps_clear_of_its_bounds():
    mode = further_mode.further_mode(8.0, 0.02)
    assert further_mode.is_a_mode(mode, np.array([0.01, 0.03]))
    assert not further_mode.is_a_mode(mode, np.array([0.05, 0.03]))  # pitch as far as it may
    assert not further_mode.is_a_mode(mode, np.array([0.01, 0.06]))  # thrice the damping
    found = SimpleNamespace(
        law=SimpleNamespace(effects=(relaxation.EFFECT, mode)),
        theta=[np.array([[0.0]]), np.array([[0.0, 0.06]])],
    )
    assert further_mode.ran_off(found)


def test_a_mode_whose_pitch_reaches_its_bound_is_heard_there_anew():
    loaded = object()
    mode = further_mode.further_mode(8.0, 0.02, (loaded,))
    anew = further_mode.heard_anew(mode, np.array([-0.05, 0.03]))
    pitch = further_mode.pitch_of(anew, np.zeros(2))
    assert pitch == pytest.approx(8.0 * np.exp(-0.05))
    assert anew.starts(None, None) == [(0.0, 0.03)]
    assert not anew.channels(setting(), SimpleNamespace(sigma=np.ones(3), take=object())).any()
    assert further_mode.heard_anew(mode, np.array([0.01, 0.03])) is mode


def test_a_mode_of_one_load_is_seen_in_takes_with_that_load_only():
    loaded, bare = object(), object()
    mode = further_mode.further_mode(8.0, 0.02, (loaded,))
    seen = [
        mode.channels(setting(), SimpleNamespace(sigma=np.ones(3), take=take)).tolist()
        for take in (loaded, bare)
    ]
    assert seen == [[True] * 3, [False] * 3]
    assert further_mode.further_mode(8.0, 0.02).channels is None


def test_the_size_of_a_shaking_is_that_without_noise():
    rng, time = np.random.default_rng(7), np.arange(2000) / 120
    path = np.sin(2 * np.pi * 1.3 * time)
    noise = 1.5 * rng.standard_normal((2000, 3))
    for support in ([False] * 3, [True, False, False]):
        data = SimpleNamespace(
            marker=np.arange(3), support=np.array(support), sigma=np.full(3, 1.5)
        )
        size = base_motion.size(data, path[:, None] + noise)
        assert abs(size / np.sqrt(0.5) - 1) < 0.1


def test_the_size_of_a_shaking_counts_all_axes_and_no_marker_that_is_lost():
    path = np.sin(2 * np.pi * 1.3 * np.arange(2000) / 120)
    residual = np.repeat(path[:, None], 4, axis=1)
    data = SimpleNamespace(
        marker=np.repeat([0, 1], 2), support=np.zeros(4, bool), sigma=np.full(4, 1e-6)
    )
    assert base_motion.size(data, residual) == pytest.approx(1.0, rel=0.01)
    residual[:, [1, 3]] = np.nan
    assert base_motion.size(data, residual) == pytest.approx(np.sqrt(0.5), rel=0.01)


def strayed(markers: list[int], swings=12.0):
    """What is proposed where these of nine markers leave much more than noise."""
    residual = np.random.default_rng(3).standard_normal((100, 9))
    residual[:, markers] += np.linspace(0, 30, 100)[:, None]
    names = [SimpleNamespace(name=f"m{n}") for n in range(9)]
    take = SimpleNamespace(recording=SimpleNamespace(markers=names), held_out=False)
    data = SimpleNamespace(
        marker=np.arange(9), sigma=np.ones(9), time=np.arange(100) / 50, take=take,
        fit=np.ones(100, bool),
    )  # fmt: skip
    return data, tracker_drift.propose((data,), (residual,), 0, swings)


def test_a_short_record_shows_coarse_wandering_only():
    (_, few), (_, many) = strayed([0], 4.0), strayed([0], 12.0)
    assert len(many) == len(few) + 2  # one more of each of the two worst markers


@pytest.mark.parametrize(
    ("markers", "together"),
    [([2], []), ([2, 6], [2, 6]), ([0, 1, 2, 3], [])],  # what most show is the object's own
)
def test_a_few_markers_that_stray_together_are_proposed_together(markers, together):
    data, proposed = strayed(markers)
    told = [effect.report(None, None, None)["markers"] for effect in proposed]
    several = [names for names in told if len(names) > 1]
    assert bool(several) is bool(together)
    assert all(names == [f"m{n}" for n in together] for names in several)
    for effect, names in zip(proposed, told, strict=True):
        if effect.channels:
            assert [f"m{n}" for n in np.flatnonzero(effect.channels(None, data))] == names


@pytest.mark.parametrize(("split", "is_one"), [(0.0025, True), (0.00299, False)])
def test_a_partner_that_parts_as_far_as_it_may_and_leaves_something_is_none(split, is_one):
    effect, omega = partner.partner(partner.Where(0, 5.0, 0.02), 0.001), 2 * np.pi * np.array([5.0])
    law = {"setting": replace(setting(), omega=omega), "modes": 1, "own": 1, "damping": "free"}
    found = SimpleNamespace(
        law=SimpleNamespace(**law),
        theta=[np.array([[split, 0.02]])],
        parameters=np.array([np.log(5.0), 0.02, split, 0.02]),
        covariance=np.zeros((4, 4)),
        frequency=np.array([5.0]),
        damping_ratio=np.array([0.02]),
        coefficients=np.array([[1.0], [0.0]]),
        column_shapes=lambda take=0: [np.array([[0.0, 0.0], [1.0, 1.0]])],
        chi2=300.0,
        samples=100,
    )
    assert (effect.veto(found) == "") is is_one


@pytest.mark.parametrize(("pitch", "is_one"), [(5.0, False), (5.6, True)])
def test_a_line_is_at_resonance_by_the_pitch_that_is_fitted_beside_it(pitch, is_one):
    """Where the drive beats with it, the pitch that was heard at first is the drive's."""
    found = SimpleNamespace(
        law=SimpleNamespace(
            setting=replace(setting(), omega=2 * np.pi * np.array([5.0])),
            own=1,
            fitted=(0,),
            takes=(SimpleNamespace(time=np.linspace(0, 5, 100)),),
        ),
        theta=[np.array([[np.log(4.95)]])],
        frequency=np.array([pitch]),
        coefficients=np.array([[1.0], [0.5]]),
        column_shapes=lambda take=0: [np.array([[1.0, 0.2], [0.5, 0.1]])],
        chi2=300.0,
        samples=100,
    )
    assert (steady_drive.EFFECT.veto(found) == "") is is_one


@pytest.mark.parametrize(("span", "is_one"), [(2.2, True), (1.8, False)])
def test_a_line_has_two_cycles_in_what_was_fitted_and_held_out_together(span, is_one):
    """Whatever was fitted of it: a line that is told has foretold the rest."""
    take = SimpleNamespace(time=np.linspace(0, span, 100))
    found = SimpleNamespace(
        law=SimpleNamespace(
            setting=replace(setting(), duration=2 / 3 * span), own=1, fitted=(0,), takes=(take,)
        ),
        theta=[np.array([[np.log(1.0)]])],
        frequency=np.array([5.0]),
    )
    assert (steady_drive.EFFECT.veto(found) == "") is is_one


def heard_by_one_take(frequency, damping_ratio, amplitude=1.0):
    """Poles (m,) as heard, and the fit of those at 5 Hz and above 10 Hz."""
    z, m = np.array(damping_ratio), len(frequency)
    size = np.broadcast_to(amplitude, m)[:, None] * np.ones((m, 3))
    ring = RingDown(np.array(frequency), z, size, np.zeros(3), np.ones(3), np.eye(2 * m))
    data = SimpleNamespace(sigma=np.ones(3), time=np.arange(300) / 60, fit=np.ones(300, bool))
    matched = [0, *np.flatnonzero(ring.frequency > 10)]
    found = SimpleNamespace(
        frequency=ring.frequency[matched],
        damping_ratio=z[matched],
        law=SimpleNamespace(takes=[data], fitted=[0]),
    )
    return found, ring, Match(tuple(map(int, matched)), tuple(2 * n for n in range(len(matched))))


def of_pitches(*computed, parts=np.inf):
    """A body with modes at these Hz, which `parts` a pair by so much at most."""
    return SimpleNamespace(modes=SimpleNamespace(frequency=np.array(computed)), parts=parts)


@pytest.mark.parametrize(
    ("parts", "tried"), [(np.inf, [2, 3]), (0.007, [2, 3]), (0.001, [3])],
    ids=["a load may part a pair", "an uneven body", "a pair that meshing parts"],
)  # fmt: skip
def test_modes_that_lie_near_each_other_without_symmetry_are_tried_as_two(parts, tried):
    body = of_pitches(1.0, 1.001, 1.01, 1.4, 3.0, parts=parts)
    ways = neighbours(*heard_by_one_take([5.0], [0.02]), body)
    assert [both.modes for _, both, _ in ways] == [(0, j) for j in tried]


def test_of_two_poles_heard_where_one_mode_was_matched_the_longer_lived_may_be_that_mode():
    case = heard_by_one_take([5.0, 12.0, 5.1], [0.25, 0.02, 0.04])
    tied, free = neighbours(*case, of_pitches(1.0, 1.1, 2.5))
    assert [both.modes for _, both, _ in (tied, free)] == [(0, 2, 1)] * 2
    assert tied[0].frequency == pytest.approx([5.0, 12.0, 5.5]) and tied[2][0][0] == 2
    assert free[0].frequency == pytest.approx([5.1, 12.0, 5.0]) and free[2] == ()
    assert free[0].damping_ratio == pytest.approx([0.04, 0.02, 0.25])
    assert [both.poles for _, both, _ in (tied, free)] == [(0, 1, 0), (2, 1, 0)]
    alike = heard_by_one_take([5.0, 12.0, 5.1], [0.02, 0.02, 0.021])  # the halves of one pair
    assert len(list(neighbours(*alike, of_pitches(1.0, 1.1, 2.5)))) == 2


@pytest.mark.parametrize(
    ("pitch", "z", "size"),
    [(5.1, 0.3, 1.0), (7.4, 0.2, 1.0), (5.1, 1e-5, 1.0), (5.1, 0.04, 0.05), (8.0, 0.04, 1.0)],
    ids=["it dies sooner", "it is less damped, but higher", "it does not die", "it is faint",
         "it is far"],
)  # fmt: skip
def test_no_other_pole_is_taken_for_the_strongest_mode(pitch, z, size):
    case = heard_by_one_take([5.0, pitch], [0.25, z], [1.0, size])
    assert len(list(neighbours(*case, of_pitches(1.0, 1.1, 2.5)))) == 1


@pytest.mark.parametrize(
    ("first", "z", "like", "modes"),
    [
        (0.02, 0.08, 1.0, (0, 1)),
        (0.02, 0.34, 1.0, (0,)),
        (0.02, 0.005, 1.0, (0,)),
        (0.005, 0.192, 1.0, (0, 1)),
        (0.02, 0.08, 0.6, (0,)),
    ],
    ids=["as the first one", "a mean that wanders", "a line", "as its pitch", "of another shape"],
)
def test_a_mode_is_known_by_its_fold_if_it_moves_and_dies_as_such_a_one_does(first, z, like, modes):
    """At 60 frames/s a mode of 48 Hz is seen at 12 Hz; it dies in the same time."""
    shapes = np.array([[1.0, 0.5, 0.2, 0.0], [0.3, -1.0, 0.8, 0.0]])
    ring = RingDown(
        np.array([5.0, 12.0]),
        np.array([first, z]),
        shapes.astype(complex),
        np.zeros(4),
        np.ones(4),
        np.eye(4),
    )
    seen = shapes.copy()
    seen[1] *= np.sqrt(like)
    seen[1, 3] = np.sqrt(1 - like) * np.linalg.norm(shapes[1])
    chase = ([0, 1], shapes, np.array([0.9, 0.4]))
    found = match_modes(ring, chase, np.array([1.0, 48 / 5]), seen, 60.0)
    assert found.modes == modes


@pytest.mark.parametrize(
    ("low", "z", "like", "loud", "poles"),
    [
        (1.07, 0.02, 0.95, 0.4, (1,)),
        (1.07, 0.3, 0.95, 0.4, (0,)),
        (0.01, 0.02, 0.95, 0.4, (0,)),
        (1.07, 0.02, 0.4, 0.4, (0,)),
        (1.9, 0.02, 0.95, 0.4, (0,)),
        (1.07, 0.02, 0.95, 0.1, (0,)),
        (1.07, 0.02, -0.95, 0.4, (0,)),
    ],
    ids=[
        "a mode", "a mean that creeps", "a mean that wanders", "unlike any mode",
        "where the lowest may be", "faint", "as the strongest",
    ],
)  # fmt: skip
def test_no_strong_pole_lies_below_the_lowest_mode(low, z, like, loud, poles):
    """A mass moves the strongest pole, which is another mode, nearly as mode 0 moves."""
    seen = np.eye(3, 6)
    shapes = np.zeros((2, 6))
    shapes[0, [0, 4]] = np.sqrt([0.65, 0.35])
    shapes[1, [0, 5 if like > 0 else 4]] = np.sqrt([abs(like), 1 - abs(like)])
    ring = RingDown(
        np.array([2.0, low]), np.array([0.02, z]), shapes.astype(complex),
        np.zeros(6), np.ones(6), np.eye(4),
    )  # fmt: skip
    chase = ([0, 1], shapes, np.array([0.9, loud]))
    found = match_modes(ring, chase, np.array([1.0, 1.5, 2.2]), seen)
    assert found.poles == poles and found.modes == (0,)


@pytest.mark.parametrize(("moves", "poles"), [(0, (1,)), (2, (0,))])
def test_what_is_heard_below_the_lowest_mode_is_none_that_lies_above_it(moves, poles):
    """A support that shakes as a whole moves as a high mode does."""
    seen = np.eye(3, 6)
    shapes = np.zeros((2, 6))
    shapes[0, [0, 4]] = np.sqrt([0.65, 0.35])
    shapes[1, [moves, 5]] = np.sqrt([0.95, 0.05])
    ring = RingDown(
        np.array([2.0, 1.07]), np.array([0.02, 0.02]), shapes.astype(complex),
        np.zeros(6), np.ones(6), np.eye(4),
    )  # fmt: skip
    chase = ([0, 1], shapes, np.array([0.9, 0.4]))
    found = match_modes(ring, chase, np.array([1.0, 1.5, 9.0]), seen)
    assert found.poles == poles and found.modes == (0,)


def test_a_fold_below_the_lowest_mode_stays_where_it_was_matched():
    """At 60 frames/s a mode of 52 Hz is seen at 8 Hz, below the first one at 10 Hz."""
    seen = np.eye(2, 6)
    ring = RingDown(
        np.array([10.0, 8.0]), np.array([0.02, 0.13]), seen.astype(complex),
        np.zeros(6), np.ones(6), np.eye(4),
    )  # fmt: skip
    chase = ([0, 1], seen, np.array([0.9, 0.4]))
    found = match_modes(ring, chase, np.array([1.0, 5.2]), seen, 60.0)
    assert found.poles == (0, 1) and found.modes == (0, 1)


@pytest.mark.parametrize(("split", "modes"), [(0.04, (0,)), (0.3, (2, 3))])
def test_the_halves_of_a_split_pair_are_that_pair_and_not_higher_modes_as_far_apart(split, modes):
    """Seen from above a post's two pairs move alike; pitches too far apart are no split pair's."""
    seen = np.vstack([np.eye(2, 6), np.eye(2, 6)])
    shapes = np.eye(2, 6)
    ring = RingDown(
        np.array([5.0, 5.0 * (1 + split)]), np.full(2, 0.01), shapes.astype(complex),
        np.zeros(6), np.ones(6), np.eye(4),
    )  # fmt: skip
    chase = ([0, 1], shapes, np.array([0.8, 0.6]))
    frequency = np.array([1.0, 1.0, 6.0, 6.0 * (1 + split)])
    assert match_modes(ring, chase, frequency, seen).modes == modes


def test_two_modes_that_lie_near_may_have_turned_into_one_another():
    """Between both, the strongest pole is the one that it is more like; elsewhere it is none."""
    rng = np.random.default_rng(3)
    seen = np.linalg.qr(rng.standard_normal((12, 12)))[0][:5]
    computed = np.array([1.0, 1.05, 2.5, 3.6, 4.0])

    def matched(shape):
        ring = RingDown(
            np.array([5.0]),
            np.array([0.02]),
            shape[None].astype(complex),
            np.zeros(12),
            np.ones(12),
            np.eye(2),
        )
        return match_modes(ring, ([0], shape[None], np.ones(1)), computed, seen).modes

    assert matched(0.68 * seen[0] + 0.73 * seen[1]) == (1,)
    assert matched(0.68 * seen[1] + 0.73 * seen[2]) == (2,)  # by itself: these lie far apart
    assert matched(seen[2] + 1.01 * seen[3] + 0.3 * rng.standard_normal(12)) == (None,)
    assert matched(rng.standard_normal(12)) == (None,)


@pytest.mark.parametrize(
    ("heard", "like", "loud", "modes"),
    [
        (2.3, 0.95, 0.5, (1, 0)),
        (1.4, 0.95, 0.5, (None,)),
        (2.3, 0.5, 0.5, (None,)),
        (2.3, 0.95, 0.05, (None,)),
    ],
    ids=["by its pitch", "at no mode's pitch", "the other is none for sure", "the other is faint"],
)
def test_a_strongest_pole_bent_beyond_knowing_is_a_mode_beside_another_one(
    heard, like, loud, modes
):
    """A heavy mass bends mode 1 until it is like none; mode 0 is still itself, or hardly."""
    seen = np.eye(3, 9)
    shapes = np.zeros((2, 9))
    shapes[0, [0, 1, 2, 5]] = np.sqrt([0.1, 0.42, 0.1, 0.38])
    shapes[1, [0, 6]] = np.sqrt([like, 1 - like])
    ring = RingDown(
        np.array([heard, 1.0]), np.full(2, 0.02), shapes.astype(complex),
        np.zeros(9), np.ones(9), np.eye(4),
    )  # fmt: skip
    chase = ([0, 1], shapes, np.array([0.9, 0.9 * loud]))
    found = match_modes(ring, chase, np.array([1.0, 2.3, 4.9]), seen)
    assert found.modes == modes and found.poles[0] == 0


@pytest.mark.parametrize(
    ("computed", "heard", "modes"),
    [(1.0145, 1.0154, (0, 1)), (1.0145, 1.04, (0,)), (1.003, 1.0035, (0,))],
    ids=["parted by a load as computed", "split further", "one pitch but for the mesh"],
)
def test_a_pair_that_is_parted_as_computed_is_two_modes(computed, heard, modes):
    shapes = np.array([[1.0, 0.1, 0.5], [-0.1, 1.0, 0.6]])
    amplitude = shapes.astype(complex)
    pitch, z = 4.687 * np.array([1.0, heard]), np.full(2, 0.03)
    ring = RingDown(pitch, z, amplitude, np.zeros(3), np.ones(3), np.eye(4))
    chase = ([0, 1], shapes, np.array([0.9, 0.4]))
    found = match_modes(ring, chase, np.array([1.0, computed]), shapes)
    assert found.modes == modes


@pytest.mark.parametrize(
    ("pairs", "turn", "heard", "modes"),
    [
        (False, 0.0, 1.019, (0, 1)), (True, 0.0, 1.019, (0,)), (False, 0.3, 1.019, (0, 1)),
        (False, 0.0, 1.06, (0,)), (False, 0.0, 0.985, (0, 1)),
    ],
    ids=["by no symmetry", "a symmetric body's", "a little turned", "far off", "in other order"],
)  # fmt: skip
def test_near_modes_by_chance_are_known_by_their_ways(pairs, turn, heard, modes):
    """A coarse mesh has them 0.3 % apart."""
    shapes = np.array([[1.0, 0.1, 0.5], [-0.1, 1.0, 0.6]])
    c, s = np.cos(turn), np.sin(turn)
    moves = np.array([[c, s], [-s, c]]) @ shapes
    pitch, z = 4.687 * np.array([1.0, heard]), np.full(2, 0.03)
    ring = RingDown(pitch, z, moves.astype(complex), np.zeros(3), np.ones(3), np.eye(4))
    chase = ([0, 1], moves, np.array([0.9, 0.4]))
    found = match_modes(ring, chase, np.array([1.0, 1.003]), shapes, pairs=pairs)
    assert found.modes == modes


def test_what_swings_the_second_of_two_near_ways_is_the_second_mode():
    shapes = np.array([[1.0, 0.1, 0.5], [-0.1, 1.0, 0.6]])
    args = np.full(1, 5.0), np.full(1, 0.03), shapes[1:].astype(complex), np.zeros(3), np.ones(3)
    chase = ([0], shapes[1:], np.ones(1))
    found = match_modes(
        RingDown(*args, np.eye(2)), chase, np.array([1.0, 1.01]), shapes, pairs=False
    )
    assert found.modes == (1,)


@pytest.mark.parametrize(
    ("computed", "heard", "modes"),
    [(2.1, 2.3, (0, 1)), (2.1, 2.5, (0, 1, 2)), (2.25, 2.3, (0, 1, 2))],
    ids=["the sum of two, far off", "no sum, far off", "the sum of two, as computed"],
)
def test_a_sum_of_two_pitches_is_a_mode_only_where_one_was_computed(computed, heard, modes):
    """Modes at 1 and 1.3 Hz, and what is heard of a third."""
    shapes = np.array([[1.0, 0.5, 0.2], [0.3, -1.0, 0.8], [0.5, -0.4, -1.0]])
    pitch, z = np.array([1.0, 1.3, heard]), np.full(3, 0.02)
    ring = RingDown(pitch, z, shapes.astype(complex), np.zeros(3), np.ones(3), np.eye(6))
    chase = ([0, 1, 2], shapes, np.array([0.9, 0.4, 0.2]))
    assert match_modes(ring, chase, np.array([1.0, 1.3, computed]), shapes).modes == modes


@pytest.mark.parametrize(
    ("computed", "heard", "modes"),
    [(2.3, 2.004, (0,)), (2.3, 2.1, (0, 1)), (2.04, 2.004, (0, 1)), (2.7, 2.995, (0,))],
    ids=["an overtone, far off", "none, far off", "an overtone, as computed", "the next one"],
)
def test_an_overtone_that_moves_as_a_mode_is_one_only_where_one_was_computed(
    computed, heard, modes
):
    """A stop at one place stirs other modes at twice the pitch. Modes at 1 Hz and `computed`."""
    shapes = np.array([[1.0, 0.5, 0.2], [0.3, -1.0, 0.8]])
    pitch, z = np.array([1.0, heard]), np.full(2, 0.02)
    ring = RingDown(pitch, z, shapes.astype(complex), np.zeros(3), np.ones(3), np.eye(4))
    chase = ([0, 1], shapes, np.array([0.9, 0.4]))
    assert match_modes(ring, chase, np.array([1.0, computed]), shapes).modes == modes


def test_takes_with_other_loads_are_led_by_a_mode_that_all_show():
    """What is loudest with one load and with another may be the other of a pair, or another mode"""
    heard = {0: np.array([5.0, 9.0, 14.0]), 1: np.array([4.6, 8.5, 13.0])}
    near = {0: Match((0, 1, 2), (0, 1, 3)), 1: Match((0, 1, 2), (1, 0, 3))}
    assert [m.modes for m in common(near, heard).values()] == [(0, 3), (1, 3)]
    far = {0: Match((0, 1, 2), (0, 2, 3)), 1: Match((1, 2, 0), (2, 3, 0))}
    led = common(far, heard)
    assert led[0] == Match((1, 0, 2), (2, 0, 3))
    assert led[1] == Match((1, 0, 2), (2, 0, 3))
    alone = {0: Match((0, 1), (0, 3)), 1: Match((2, 1), (2, 3))}
    assert [m.modes for m in common(alone, heard).values()] == [(3,), (3,)]


def test_the_two_modes_of_a_near_pair_keep_half_their_distance():
    law = SimpleNamespace(modes=2, sizes=lambda: (4, 0, 0), tied=((1, 0.02),))
    pitch = np.array([0.005, 0.02, 0.06])  # of the second over the first, in logarithms
    P = np.c_[0 * pitch, pitch, np.full((3, 2), 0.02)]
    off = _ties(law, P)[:, 0]
    assert off[0] == pytest.approx(TIE * 0.005) and off[1] == 0 and off[2] > 0


def before_a_lens():
    """Two markers on the support and one near the lens, as channels; instants; what they see of
    what goes aside, and of a camera that turns.
    """
    rows, places = np.eye(3), np.array([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.02, 0.01, -0.2]])
    camera = Camera("pinhole", rows, np.array([0, 0, -0.5]), 1000.0, np.zeros(2))
    data = SimpleNamespace(
        take=SimpleNamespace(recording=SimpleNamespace(camera=camera)),
        marker=np.repeat(np.arange(3), 2),
        directions=camera.jacobian(places).reshape(-1, 3),
        sigma=np.full(6, 0.01),
        support=np.array([True, True, False]).repeat(2),
    )
    time = np.arange(400) / 100
    path = 1e-3 * np.array([np.sin(3 * time), np.cos(2 * time), 0 * time]).T
    aside = np.array([(camera.project(places + s) - camera.project(places)).ravel() for s in path])
    return data, time, {"aside": aside, "turning": np.tile(aside[:, :2], 3)}


def test_what_goes_aside_before_a_lens_is_seen_the_more_the_nearer_it_is():
    data, _, moved = before_a_lens()
    aside, turning = moved["aside"], moved["turning"]
    alike, nearer = reaches(data)
    assert nearer[4:] / nearer[:2] == pytest.approx(0.5 / 0.3, rel=1e-3)
    for moved, reach, other in ((aside, nearer, alike), (turning, alike, nearer)):
        off, wrong = (
            np.abs(base_motion.common_motion(data, moved, one) - moved)[:, 4:].max() / moved.max()
            for one in (reach, other)
        )
        assert off < 0.02 < 0.2 < wrong


def test_of_what_markers_share_that_is_read_off_which_leaves_less_and_nothing_where_none_tells():
    """A held-out take without a marker on the support has gaps, and no shared motion."""
    data, time, moved = before_a_lens()
    unread = SimpleNamespace(
        **vars(data) | {"support": np.zeros(6, bool), "take": SimpleNamespace(held_out=True)}
    )
    unread.take.recording = data.take.recording
    data.take.held_out, data.fit, unread.fit = False, time < 3, time < 1
    unread.values = np.where(time[:, None] < 2, moved["aside"], np.nan)
    for seen in moved.values():
        data.values = seen
        law = SimpleNamespace(takes=(data, unread))
        shared, none = _likeliest(SimpleNamespace(law=law, predicted=(0 * seen, 0 * seen)))
        assert np.abs(shared - seen).max() < 0.02 * seen.max()
        assert (none == 0).all()


def test_a_support_that_no_marker_shows_is_told_by_how_the_body_answers_to_it():
    """Two modes on a support that swings slowly both ways, in closed form."""
    rng = np.random.default_rng(3)
    fps, T, sigma = 100.0, 600, 2e-6
    time = np.arange(T) / fps
    shapes = rng.standard_normal((2, 18))  # six markers, three axes
    push = np.array([[1.2, 0.1, -0.3], [0.1, 0.7, 0.2]])
    along = np.tile(np.eye(3), (6, 1))

    def seen_at(frequency):
        r = frequency / np.array([4.0, 9.0])
        return along + (shapes.T * (r**2 / (1 - r**2 + 0.04j * r))) @ push

    moved, support = np.zeros((T, 18)), np.zeros((T, 3))
    for frequency in rng.uniform(0.3, 2.4, 8):
        way = 1e-4 * rng.standard_normal(3) * np.exp(2j * np.pi * rng.uniform())
        wave = np.exp(2j * np.pi * frequency * time)[:, None]
        moved += (wave * (seen_at(frequency) @ way)).real
        support += (wave * way).real
    data = SimpleNamespace(
        time=time,
        marker=np.repeat(np.arange(6), 3),
        sigma=np.full(18, sigma),
        support=np.zeros(18, bool),
    )
    noisy = moved + sigma * rng.standard_normal(moved.shape)
    noisy[rng.uniform(size=T) < 0.03, 4] = np.nan
    shared, rms = base_motion.answered_motion(data, noisy, seen_at, 3.2)
    inner = slice(30, -30)
    stiff = base_motion.common_motion(data, noisy)
    left, rigid = (np.sqrt(np.mean((one - moved)[inner] ** 2)) for one in (shared, stiff))
    assert left < 0.1 * rigid
    assert rms == pytest.approx(np.sqrt(np.var(support, axis=0).sum()), rel=0.05)


@pytest.mark.parametrize(
    ("place", "bent", "powers"),
    [((0.5, -0.3), 0, (1.0, 1.6, 2.0)), ((3.0, 0.2), 1, (1.0,)), ((0.2, -9.0), 2, (1.0,))],
)
def test_a_stiffness_is_as_uneven_as_that_of_the_mode_which_it_bends_most(place, bent, powers):
    """By the force itself: each mode pushed by the first amplitude to either side."""
    three = replace(
        setting(),
        omega=OMEGA[0] * np.array([1.0, 1.02, 4.0]),
        couple=np.ones(3),
        masses=np.array([1.0, 0.7, 1.8]),
    )
    couple = np.r_[1.0, place]
    for power in powers:
        theta = np.array([0.04, power, *place])
        push = asymmetric_stiffness.force(theta[None], three)
        sides = []
        for k, omega in enumerate(three.omega):
            far = np.array([-AMPLITUDE, AMPLITUDE])
            felt = [float(push(SimpleNamespace(x=couple[k] * u))[0]) for u in far]
            sides.append(omega**2 - couple[k] * three.masses[k] * np.array(felt) / far)
        ratios = [max(side) / min(side) for side in sides]
        assert int(np.argmax(ratios)) == bent
        told = asymmetric_stiffness.report(theta, three, None)["ratio"]
        assert told - 1 == pytest.approx(ratios[bent] - 1, rel=1e-6)
