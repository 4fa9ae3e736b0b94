"""What known loads do to the pitches of a body that bears more than its case says."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from core import other_loads, turned
from core.compare import Measured, compare
from core.doubt import chance_of
from core.other_loads import ALIKE, PLACED, SAME, WHOLE, Shift, shifts_of, told_by
from core.turned import FLOOR

STIFF = np.array([100.0, 900.0, 2500.0])  # N/m of three masses, each on a spring of its own
HEAVY = np.array([1.0, 0.8, 0.5])  # kg
ON_TOP = np.array([0.3, 0.0, 0.1])  # kg


def shift(lump=0.0, times=1.0):
    """Of the first and the last mass, as their springs with a lump on the first would show it."""
    bare = HEAVY + np.array([lump, 0, 0])
    measured = -0.5 * np.log1p(times * ON_TOP / bare)[[0, 2]]
    return Shift(1, measured, np.full(2, 1e-4), np.diag(times * ON_TOP))


def told(shifts, lump):
    """What a body with that lump is told by them, and what without."""
    heavy = HEAVY + np.array([lump, 0, 0])
    pitch = np.sqrt(STIFF / heavy)[[0, 2]] / (2 * np.pi)
    seen = np.eye(3, 4) + 0.01
    measured = Measured(pitch, np.full(2, 0.003), seen[[0, 2]], np.full((2, 4), 0.02))
    found = compare(measured, STIFF / heavy, seen)
    assert found.modes == (0, 2)
    matrices = np.diag(STIFF), np.diag(heavy)
    return told_by(shifts, found, matrices, [one.added for one in shifts]), found, measured


@pytest.mark.parametrize("lump", [0.0, 0.4])
def test_the_body_that_bears_what_is_there_shows_the_shift(lump):
    right, before, _ = told((shift(lump),), lump)
    assert right.shifts.pull == pytest.approx(np.zeros((1, 2)), abs=1e-9)
    assert right.chi2 == pytest.approx(before.chi2)
    assert right.modulus == before.modulus


def test_the_declared_body_is_off_by_what_it_does_not_know_of():
    """Generalized least squares, with what all shifts are off by at once in the covariance."""
    wrong, before, pitch = told((shift(0.4), shift(0.4, 2.0)), 0.0)
    off, way, own = [], [], []
    for times in (1.0, 2.0):
        foretold = shift(0.0, times).measured
        off += list(foretold - shift(0.4, times).measured)
        way += list(WHOLE * foretold)
        own += [1e-8 + (PLACED * np.abs(foretold).max()) ** 2] * 2
    covariance = np.diag(own) + np.outer(way, way)
    cost = np.array(off) @ np.linalg.solve(covariance, off)
    assert wrong.chi2 - before.chi2 == pytest.approx(cost)
    assert wrong.pitch_chi2 - before.pitch_chi2 == pytest.approx(cost)
    left = wrong.shifts.pull * wrong.shifts.error + wrong.shifts.common * wrong.shifts.way
    assert left.ravel() == pytest.approx(off)
    assert chance_of(before, pitch) > 0.5 > 1e-3 > chance_of(wrong, pitch)


@pytest.mark.parametrize("takes", [1, 6])
def test_a_body_as_much_heavier_as_its_density_may_be_off_is_in_no_doubt(takes):
    """However many loads show it: what is wrong there is wrong in all of them."""
    heavier = 1.1
    shifts = tuple(
        replace(one, measured=-0.5 * np.log1p(times * ON_TOP / HEAVY / heavier)[[0, 2]])
        for times in np.linspace(0.5, 2, takes)
        for one in [shift(0.0, times)]
    )
    wrong, _, pitch = told(shifts, 0.0)
    assert chance_of(wrong, pitch) > 0.1


def test_what_is_not_known_of_a_shift_costs_nothing_and_what_no_body_does_costs_much():
    none = replace(shift(0.4), measured=np.full(2, np.nan))
    same, before, pitch = told((none,), 0.0)
    assert same.chi2 == before.chi2
    assert chance_of(same, pitch) == chance_of(before, pitch)
    fails = told_by((shift(),), before, (np.diag([-1e-9, 900.0, 2500.0]), np.diag(HEAVY)),
                    [np.diag(ON_TOP)])  # fmt: skip
    assert 1e3 < fails.chi2 < np.inf


@pytest.mark.parametrize("way", [-0.5 * np.log(1.2), 0.0])
def test_either_of_two_that_a_load_makes_of_a_pair_may_be_what_is_seen(way):
    """Two at one pitch, the load on their sum: one of what they become drops, the other stays."""
    matrices = np.diag([100.0, 100.001, 900.0]), np.eye(3)
    added = 0.1 * np.array([[1.0, 1, 0], [1, 1, 0], [0, 0, 0]])
    seen = np.eye(3, 4) + 0.01
    pitch = Measured(np.array([1.5]), np.full(1, 0.003), seen[:1], np.full((1, 4), 0.02))
    found = compare(pitch, matrices[0].diagonal(), seen)
    one = Shift(1, np.array([way]), np.full(1, 1e-4), added)
    assert chance_of(told_by((one,), found, matrices, [added]), pitch) > 0.05


GRAVITY = np.array([0, 0, -9.81])


def heard_with(mass, *, carried=None, pitch=(1, 1, 0, 0), turned=0.0, over=None, laden=1):
    """Four takes, the last two with a load on the first of three masses, of which two modes are
    heard; `laden`: the condition in which it is on.
    """
    c, s = np.cos(turned), np.sin(turned)
    plain, other = np.eye(3), np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    heavy = [np.diag([1.0, 1, 1]), np.diag([1.0 + mass, 1, 1])]
    bodies = [
        SimpleNamespace(
            model=SimpleNamespace(mass=csr_matrix(m), points=np.array([[0, 0, 0], [0.5, 0, 0]])),
            modes=SimpleNamespace(frequency=np.array([1.0, 1.5, 4.0]), shapes=own[:, None]),
            carried=carried,
        )
        for m, own in zip(heavy, (plain, other), strict=True)
    ]
    gravity = [GRAVITY, GRAVITY, over if over is not None else GRAVITY, GRAVITY]
    takes = [
        SimpleNamespace(
            take=SimpleNamespace(loads=(["load"] if n == laden else []), gravity=g), frame=0.01
        )
        for n, g in zip((0, 0, 1, 1), gravity, strict=True)
    ]
    law = SimpleNamespace(fitted=[0, 1, 2, 3], pitch=pitch, modes=2)
    pitches = np.array([[5.0, 20.0], [5.0, 20.0], [4.0, 19.0], [4.0, 19.0]])
    deviations = [0.02, 0.03, 1, 1, 0.01, 0.015, 1, 1]  # of the set of pitches that is told first
    parameters = np.zeros(8)
    for at, own in zip(pitch, pitches, strict=True):
        parameters[4 * at : 4 * at + 2] = np.log(own)
    final = SimpleNamespace(
        law=law,
        parameters=parameters,
        covariance=np.diag(np.square(deviations)),
        pitches=lambda n: pitches[n],
    )
    heard = SimpleNamespace(
        body=bodies[0],
        bodies=bodies,
        condition=(0, 0, 1, 1),
        takes=takes,
        match=SimpleNamespace(modes=(0, 2)),
    )
    return heard, SimpleNamespace(final=final), SimpleNamespace(modes=(0, 2))


@pytest.fixture
def plainly(monkeypatch):
    monkeypatch.setattr(turned, "inflation", lambda final: 4.0)
    monkeypatch.setattr(other_loads, "true_frequency", lambda heard, final: final.pitches(0))
    foot = np.array([0.06, 9.0, 0.04])
    monkeypatch.setattr(other_loads, "on_narrow_feet", lambda body, take: foot * len(take.loads))


@pytest.mark.parametrize("laden", [0, 1])
def test_takes_with_another_load_show_a_shift_once(plainly, laden):
    (one,) = shifts_of(*heard_with(0.3, laden=laden), bias=0.04)
    assert one.take == 2
    assert one.measured == pytest.approx([np.log(0.8), np.nan], nan_ok=True)
    borne = 0.3 * 9.80665 / 0.5 / (2 * np.pi * 5.0) ** 2  # as a pendulum of the body's length
    first = np.linalg.norm([2 * 0.01, 2 * 0.02, FLOOR, 0.04, 0.03, borne])
    second = np.linalg.norm([2 * 0.015, 2 * 0.03, FLOOR, 0.04, 0.02])
    assert one.error.shape == (2,) and one.error == pytest.approx([first, second])
    assert one.within(np.eye(3)) == pytest.approx(np.diag([0.3, 0, 0]))


@pytest.mark.parametrize(
    ("mass", "how"),
    [
        (0.3, {"carried": 1e5}),
        (0.3, {"pitch": (0, 0, 0, 0)}),
        (0.0, {}),  # another condition, by gravity
        (0.3, {"over": -GRAVITY, "pitch": (1, 1, 0, 1)}),
    ],
)
def test_takes_that_differ_by_their_weight_or_by_nothing_show_none(plainly, mass, how):
    assert shifts_of(*heard_with(mass, **how)) == ()
    leaning = GRAVITY + np.array([0.5 * ALIKE * 9.81, 0, 0])
    assert len(shifts_of(*heard_with(0.3, over=leaning))) == 1


def test_a_mode_that_the_load_makes_another_one_or_that_folds_tells_nothing(plainly, monkeypatch):
    far = np.arccos(np.sqrt(SAME)) + 0.1
    heard, verdict, found = heard_with(0.3)
    cases = {
        "as it is": (heard, verdict, found),
        "turned": heard_with(0.3, turned=far),
        "another": (heard, verdict, SimpleNamespace(modes=(1, 2))),
    }
    known = {k: bool(np.isfinite(shifts_of(*one)[0].measured[0])) for k, one in cases.items()}
    assert known == {"as it is": True, "turned": False, "another": False}
    heard.bodies[1].modes.frequency = np.array([1.0, 1.5, 4.0])[[1, 0, 2]]  # changed places
    heard.bodies[1].modes.shapes = np.eye(3)[[1, 0, 2]][:, None]
    assert np.isnan(shifts_of(heard, verdict, found)[0].measured).all()
    monkeypatch.setattr(other_loads, "true_frequency", lambda heard, final: np.array([95.0, 20.0]))
    (one,) = shifts_of(*heard_with(0.3))  # a fold does not move as the pitch does
    assert np.isnan(one.measured).all()
