"""A relaxation with two times, integrated here by another rule."""

import numpy as np
import pytest

from core.branches import with_branch
from core.effects import relaxation
from core.residual import errors, noise_share
from core.tell import parameters
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import NOISE, SHAPE, TIME, W, channels, declared, moved, raced

TIMES, RATIOS = (0.12, 1.1), (0.06, 0.12)  # s, of the static stiffness
QUIET = 0.2 * NOISE


class Creep:
    """Branches (Maxwell's elements) beside a spring, let go from a pose held long."""

    def __init__(self, times=TIMES, ratios=RATIOS):
        self.parts = [[AMPLITUDE, time, ratio] for time, ratio in zip(times, ratios, strict=True)]

    def pull(self, x, v, t, h):
        out = 0.0
        for part in self.parts:
            held, time, ratio = part
            out -= W**2 * ratio * (x - held)
            part[0] += h * (x - held) / time
        return out


def creeping(*branches, beside=0.0, seed=0):
    """The fit with one time of a motion that so many branches draw."""
    loud = np.random.default_rng(seed).standard_normal((len(TIME), len(SHAPE)))
    values = moved(Creep(*branches), seed=seed) - (NOISE - QUIET) * loud + beside
    return raced(declared(channels(values, QUIET)), relaxation.EFFECT)


def test_two_times_are_found_and_predict_what_was_held_out():
    single = creeping()
    assert single.chi2 > 1.3 * single.samples
    both = with_branch(single, 1)
    assert both.chi2 < 1.1 * both.samples
    noise = noise_share(both.law.takes, True)
    assert errors(single)[0] > 1.5 * noise and errors(both)[0] < 1.1 * noise
    told = parameters(both, 0)
    for name, truth in (("ratio", sum(RATIOS)), ("time", TIMES[1])):
        low, high = told[name]["ci95"]
        assert low <= truth <= high
        assert abs(told[name]["value"] / truth - 1) < 0.1
    assert with_branch(both, 1) is both


def test_one_time_stays_one():
    for seed in range(5):
        single = creeping(TIMES[1:], RATIOS[1:], seed=seed)
        assert with_branch(single, 1) is single


def test_what_moves_otherwise_is_no_second_time():
    """A slow wander of one marker has not the shape of the pose that was let go from."""
    wander = np.zeros((len(TIME), len(SHAPE)))
    wander[:, 3] = 0.06 * AMPLITUDE * np.exp(-TIME / TIMES[0])
    single = creeping(TIMES[1:], RATIOS[1:], beside=wander)
    assert single.chi2 > 1.3 * single.samples
    assert with_branch(single, 1) is single


@pytest.mark.parametrize(("times", "why"), [((0.5, 60.0), "slower"), ((0.01, 0.5), "damping")])
def test_each_of_two_times_must_be_one_that_a_record_shows(times, why):
    single = declared(channels(moved()))
    found = raced(single, relaxation.EFFECT)
    theta = [np.log(np.array([times]))]
    assert why in relaxation.BRANCHED.veto(Found(found, theta))


class Found:
    """A fit with other numbers of its last effect."""

    def __init__(self, found, theta):
        self.law, self.theta = found.law, theta
