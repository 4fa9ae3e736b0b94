"""A rub in a plane, against a swing of two modes by symplectic Euler's rule."""

from dataclasses import replace

import numpy as np
import pytest

from core.baseline import build_law
from core.damping import find_damping, is_needless
from core.data import RingDown
from core.diagnosis import diagnose
from core.effects import dry_friction
from core.race import Try, race
from core.rub import in_plane
from core.screen import screen
from core.time_layer import begins_of
from core.timefit import fit
from tests.core.test_timefit import AMPLITUDE, NOISE, RATE, TIME, channels

PITCH = np.array([5.0, 6.3])
SHAPES = np.array([[1.0, 0.7, 0.0, 0.0], [0.0, 0.0, 1.0, 0.6]])  # straight across each other
OMEGA, ZETA, PLACE = 2 * np.pi * PITCH, 0.01, np.array([[1.0, 0.0], [0.0, 1.1]])
SIZE, TRAVEL = 0.03, 0.02  # of the first mode's force at first, of its swing


def swung(plane: bool, zeta=ZETA, seed=0, size=SIZE):
    """(T, 4) m of two modes of one mass, rubbed in a plane or along a line between their ways."""
    h, x, v = 1 / (200 * RATE), AMPLITUDE * np.array([1.0, 0.6]), np.zeros(2)
    rows = PLACE if plane else np.array([[1.0, 0.8]])
    slip, out = np.zeros(len(rows)), []
    for i in range(200 * len(TIME)):
        if i % 200 == 0:
            out.append(x.copy())
        slip = slip + rows @ v * h / (TRAVEL * AMPLITUDE)
        slip /= max(np.linalg.norm(slip), 1.0)
        force = -size * OMEGA[0] ** 2 * AMPLITUDE * slip @ rows
        v = v + h * (force - 2 * zeta * OMEGA * v - OMEGA**2 * x)
        x = x + h * v
    noise = NOISE * np.random.default_rng(seed).standard_normal((len(out), 4))
    return np.array(out) @ SHAPES + noise


def swinging(values):
    """The best fit of two modes, each with a damping ratio of its own."""
    amplitude = (AMPLITUDE * np.array([1.0, 0.6])[:, None] * SHAPES).astype(complex)
    ring = RingDown(
        PITCH, np.full(2, 0.02), amplitude, np.zeros(4), np.full(4, NOISE), np.eye(4)
    )  # fmt: skip
    law, p = build_law([ring], (channels(values),), (0,))
    return fit(replace(law, setting=replace(law.setting, paired=False)), p, evaluations=40)


def equally_damped(free):
    """The best fit with one damping ratio for all modes."""
    return fit(replace(free.law, damping="common"), free.parameters, evaluations=40)


def rubbed(values):
    """The best fit of a rub along a line."""
    declared = swinging(values)
    effect = dry_friction.EFFECT
    begins = begins_of(effect, declared, None)
    return race(Try(declared, screen(declared, effect, begins), effect, begins))


def test_what_rubs_any_way_is_told_from_what_rubs_along_a_line():
    line = rubbed(swung(plane=True))
    found = in_plane(line, 1)
    assert line.chi2 > 2 * line.samples
    assert found.chi2 < 1.1 * found.samples
    (size, _, *places), (z, other) = found.theta[0][0], found.damping_ratio
    assert size == pytest.approx(SIZE, rel=0.1)
    assert np.abs(places) == pytest.approx(np.abs([0.0, 1.1]), abs=0.15)
    assert (z, other) == pytest.approx((ZETA, ZETA), rel=0.25)


def test_a_rub_along_a_line_stays_one():
    line = rubbed(swung(plane=False))
    assert line.chi2 < 1.2 * line.samples
    assert in_plane(line, 1) is line


def test_a_law_of_damping_that_a_rub_feigned_is_needless_once_the_rub_is_known():
    """Sideways it rubs the swing that is the smaller one the more."""
    for zeta, needless in ((ZETA, True), (np.array([0.01, 0.03]), False)):
        values = swung(plane=True, zeta=zeta)
        free = swinging(values)
        one = equally_damped(free)
        law, _ = find_damping(one, free)
        assert law.names == ("viscous_damping",)
        found = in_plane(rubbed(values), 1)
        assert is_needless(found, one) is needless


@pytest.mark.parametrize(("apart", "verdict"), [(0.02, "adequate"), (0.2, "explained")])
def test_a_law_of_damping_that_hardly_shows_is_told_and_not_added(apart, verdict):
    zeta = 0.02 * np.array([1 - apart, 1 + apart])
    free = swinging(swung(plane=False, zeta=zeta, size=0.0))
    told = diagnose(equally_damped(free), free)
    assert told.verdict == verdict
    minor = [name for name, share in told.minor if share < 0.005]
    assert (told.names, minor) in [((), ["viscous_damping"]), (("viscous_damping",), [])]
    assert bool(minor) == (verdict == "adequate")
