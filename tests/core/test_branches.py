"""A relaxation with two times, integrated here by another rule."""

from dataclasses import replace

import numpy as np
import pytest

from core.branches import with_branch
from core.effects import relaxation
from core.parameters import parameters
from core.residual import errors, noise_share
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
    assert errors(single).held_out > 1.5 * noise and errors(both).held_out < 1.1 * noise
    assert with_branch(both, 1) is both


def test_the_stiffness_of_both_and_the_stiffer_ones_time_are_told_with_honest_intervals():
    covered, values = [], []
    for seed in range(8):
        told = parameters(with_branch(creeping(seed=seed), 1), 0)
        truths = {"ratio": sum(RATIOS), "time": TIMES[1]}
        covered += [
            told[name]["ci95"][0] <= truth <= told[name]["ci95"][1]
            for name, truth in truths.items()
        ]
        values.append([told[name]["value"] / truth for name, truth in truths.items()])
    assert np.mean(covered) > 0.85
    assert np.median(values, axis=0) == pytest.approx([1, 1], abs=0.05)


@pytest.mark.parametrize(
    ("ratios", "times"),
    [([0.2], [0.5]), ([0.06, 0.12], [0.12, 1.1]), ([0.1, 0.1], [1.0, 1.2]), ([2, 0.3], [0.1, 3])],
)
def test_what_returns_slowly_tells_the_branches(ratios, times):
    """Maxwell's elements beside a spring, let go: the dashpots' own equations, no transform."""
    r, T = np.array(ratios), np.array(times)
    pulled = np.tile(r / (1 + r.sum()), (len(r), 1))
    rates, ways = np.linalg.eig((pulled - np.eye(len(r))) / T[:, None])
    amounts = (r @ ways) * np.linalg.solve(ways, np.ones(len(r)))  # of 1 / (1 + sum r)
    stiff, found = relaxation.branches(np.log(-1 / rates), amounts)
    order = np.argsort(found)
    assert found[order] == pytest.approx(T, rel=1e-6)
    assert stiff[order] == pytest.approx(r, rel=1e-6)


def test_a_record_that_begins_later_tells_the_same_branch():
    """The pose is that of the release, of which less than half is left when the record begins."""
    whole = channels(moved(Creep(TIMES[1:], RATIOS[1:])), NOISE)
    late = whole.time >= 1.2
    later = replace(
        whole,
        **{name: getattr(whole, name)[late] for name in ("time", "values", "fit", "rows")},
    )
    for data in (whole, later):
        told = parameters(raced(declared(data), relaxation.EFFECT), 0)
        low, high = told["ratio"]["ci95"]
        assert low <= RATIOS[1] <= high
        assert told["ratio"]["value"] == pytest.approx(RATIOS[1], rel=0.15)


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


def test_a_second_time_that_no_record_shows_is_none():
    """One that lasts three records takes up what the first one leaves, at the bound."""
    for seed in range(3):
        single = creeping((0.3, 8.0), (0.1, 0.3), seed=seed)
        found = with_branch(single, 1)
        assert not relaxation.unseen(found.theta[0][0], found.law.setting)
        assert found is single or parameters(found, 0)["ratio"]["value"] < 0.5


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
