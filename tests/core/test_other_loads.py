"""What known loads do to the pitches of a body that bears more than its case says."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from core import other_loads
from core.compare import Measured, compare
from core.doubt import chance_of
from core.other_loads import FLOOR, SAME, UNSURE, Shift, shifts_of, told_by

STIFF = np.array([100.0, 700.0, 2500.0])  # N/m of three masses, each on a spring of its own
HEAVY = np.array([1.0, 0.8, 0.5])  # kg
ON_TOP = 0.3  # kg, on the first one


def shift(lump=0.0, on_top=ON_TOP):
    """As springs with a lump on the first mass would show it."""
    measured = -0.5 * np.log1p(on_top / (HEAVY[0] + lump))
    return Shift(1, np.array([measured]), np.full(1, 1e-4), np.diag([on_top, 0, 0]))


def told(shift, lump):
    """What a body with that lump is told by it."""
    heavy = HEAVY + np.array([lump, 0, 0])
    values = STIFF / heavy
    pitch = Measured(np.array([1.5]), np.full(1, 0.003), np.ones((1, 2)), np.full((1, 2), 0.02))
    seen = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 0.2]])
    found = compare(pitch, values, seen)
    matrices = np.diag(STIFF), np.diag(heavy)
    return told_by((shift,), found, matrices, [shift.added]), found, pitch


@pytest.mark.parametrize("lump", [0.0, 0.4])
def test_the_body_that_bears_what_is_there_shows_the_shift(lump):
    right, before, _ = told(shift(lump), lump)
    assert right.shift_left == pytest.approx(0, abs=1e-12)
    assert right.chi2 == pytest.approx(before.chi2)
    assert right.modulus == before.modulus


def test_the_declared_body_is_off_by_what_it_does_not_know_of():
    wrong, before, pitch = told(shift(0.4), 0.0)
    off = -0.5 * np.log(1.3) + 0.5 * np.log1p(0.3 / 1.4)
    assert wrong.shift_left[0, 0] == pytest.approx(off)
    pull = off / np.hypot(1e-4, UNSURE * 0.5 * np.log(1.3))
    assert wrong.shift_pull[0, 0] == pytest.approx(pull)
    assert wrong.chi2 == pytest.approx(before.chi2 + pull**2)
    assert chance_of(before, pitch) > 0.5 > 1e-3 > chance_of(wrong, pitch)


def test_what_is_not_known_of_a_shift_costs_nothing():
    none = replace(shift(0.4), measured=np.array([np.nan]))
    same, before, pitch = told(none, 0.0)
    assert same.chi2 == before.chi2
    assert chance_of(same, pitch) == chance_of(before, pitch)


def test_modes_that_a_load_turns_into_one_another_are_told_together():
    """Two at one pitch, the load on their sum: one of what they become drops, the other stays."""
    matrices = np.diag([100.0, 100.001, 900.0]), np.eye(3)
    added = 0.1 * np.array([[1.0, 1, 0], [1, 1, 0], [0, 0, 0]])
    values, x = np.linalg.eigh(matrices[0])
    foretold = other_loads._foretold(matrices, added, values[:1], x[:, :1])
    assert -0.5 * np.log(1.2) < foretold[0] < 0
    assert foretold[0] == pytest.approx(-0.25 * np.log(1.2), rel=0.1)


def heard_with(mass, *, carried=None, pitch=(0, 0, 1), turned=0.0):
    """Three takes, the last one with a load on the first of three unit masses."""
    c, s = np.cos(turned), np.sin(turned)
    shapes = np.eye(3)[:, None]
    other = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])[:, None]
    bodies = [
        SimpleNamespace(
            model=SimpleNamespace(mass=csr_matrix(np.diag(m))),
            modes=SimpleNamespace(frequency=np.array([1.0, 1.5, 4.0]), shapes=own),
            carried=carried,
        )
        for m, own in (([1, 1, 1], shapes), ([1 + mass, 1, 1], other))
    ]
    takes = [SimpleNamespace(take=SimpleNamespace(loads=())) for _ in range(3)]
    law = SimpleNamespace(fitted=[0, 1, 2], pitch=pitch, modes=1, setting=None)
    final = SimpleNamespace(
        law=law,
        covariance=np.diag([0.01**2, 1, 0.02**2, 1]),
        pitches=lambda n: np.array([5.0, 5.0, 4.0])[[n]],
    )
    heard = SimpleNamespace(
        body=bodies[0],
        bodies=bodies,
        condition=(0, 0, 1),
        takes=takes,
        match=SimpleNamespace(modes=(0,)),
    )
    return heard, SimpleNamespace(final=final)


@pytest.fixture
def plainly(monkeypatch):
    monkeypatch.setattr(other_loads, "inflation", lambda final: 1.0)
    monkeypatch.setattr(other_loads, "true_frequency", lambda heard, final: final.pitches(0))
    monkeypatch.setattr(other_loads, "on_narrow_feet", lambda body, loads: np.full(3, 0.06))


def test_a_take_with_another_load_shows_a_shift(plainly):
    (one,) = shifts_of(*heard_with(0.3), bias=0.04)
    assert one.take == 2
    assert one.measured == pytest.approx(np.log(0.8))
    assert one.error == pytest.approx(np.linalg.norm([0.01, 0.02, FLOOR, 0.04, 0.03]))
    assert one.within(np.eye(3)) == pytest.approx(np.diag([0.3, 0, 0]))


@pytest.mark.parametrize("how", [{"carried": 1e5}, {"pitch": (0, 0, 0)}])
def test_a_weight_that_is_carried_or_pitches_in_common_tell_nothing(plainly, how):
    assert shifts_of(*heard_with(0.3, **how)) == ()


def test_a_mode_that_the_load_makes_another_one_tells_nothing(plainly, monkeypatch):
    far = np.arccos(np.sqrt(SAME)) + 0.1
    (one,) = shifts_of(*heard_with(0.3, turned=far))
    assert np.isnan(one.measured).all()
    monkeypatch.setattr(other_loads, "true_frequency", lambda heard, final: np.array([25.0]))
    (one,) = shifts_of(*heard_with(0.3))  # a fold does not move as the pitch does
    assert np.isnan(one.measured).all()
