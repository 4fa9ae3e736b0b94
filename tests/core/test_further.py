"""A further mode that was heard off its pitch, beside one mode that is known."""

import numpy as np
import pytest

from core.all_told import _mimics, cleared
from core.effects import large_amplitude, lost_frames
from core.effects.further_mode import further_mode, pitch_of
from core.further import _staying
from core.law import replace
from core.linear_part import fitted_instants
from core.match import mac
from core.refit import LESS, lighter
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import (
    NOISE,
    SHAPE,
    TIME,
    Backbone,
    W,
    channels,
    declared,
    moved,
    raced,
)

FIRST = W / (2 * np.pi)  # Hz
OTHER = np.array([0.3, -0.5, 0.8, 0.6])  # how the markers show the further mode


def ringing(times, zeta=0.03):
    """(T,) a swing `times` as high as the known mode."""
    w = times * W
    return np.exp(-zeta * w * TIME) * np.cos(w * np.sqrt(1 - zeta**2) * TIME + 0.7)


def sounding(times, zeta=0.03):
    """The known mode with a further one `times` as high, found without the latter."""
    wave = ringing(times, zeta)
    return declared(channels(moved() + 0.3 * AMPLITUDE * np.outer(wave, OTHER)))


@pytest.mark.parametrize("heard", [2.5, 2.64, 2.36])
def test_a_mode_is_found_where_it_is_though_it_was_heard_beside(heard):
    found, count = _staying(sounding(2.5), [further_mode(heard * FIRST, 0.03)], 0)
    assert count == 1
    pitch = pitch_of(found.law.effects[0], found.theta[0][0])
    assert pitch == pytest.approx(2.5 * FIRST, rel=2e-3)
    assert found.chi2 < 1.1 * found.samples


def test_faint_modes_beside_an_effect_are_heard_in_what_the_take_would_show_without_it():
    values = moved(Backbone(0.05, 0.0))
    for times, shape in ((2.2, OTHER), (2.6, OTHER[::-1])):
        values = values + 0.03 * AMPLITUDE * np.outer(ringing(times), shape)
    without = declared(channels(values))
    found = raced(without, large_amplitude.EFFECT)
    told = cleared(found, 0)
    assert np.sort(told.ring.frequency) / FIRST == pytest.approx([1, 2.2, 2.6], rel=0.01)
    assert told.ring.frequency[list(told.at)] == pytest.approx(found.frequency, rel=1e-3)
    left = told.values - cleared(without, 0).values
    assert np.abs(left).max() > 5 * NOISE  # the backbone, that is taken away


def test_what_turns_out_an_overtone_is_no_mode():
    bare = sounding(2.0)
    found, count = _staying(bare, [further_mode(2.15 * FIRST, 0.03)], 0)
    assert count == 0
    assert found is bare


def test_the_damping_of_a_mode_that_is_heard_anew_keeps_its_bound():
    found, count = _staying(sounding(2.38, 0.075), [further_mode(2.6 * FIRST, 0.02)], 0)
    assert count == 0


def test_time_that_stands_still_is_left_out_of_what_is_heard():
    found = declared(channels(moved()))
    (data,) = found.law.takes
    jumps = (((data.time[20] - 1e-6, -2 * data.frame),),)  # frames doubled
    law = replace(found.law, effects=(lost_frames.lost(jumps, found.law.takes),))
    time, use = fitted_instants(law, [np.zeros((1, 0))], data)
    assert (np.diff(time) > 0).all() and data.fit.sum() - use.sum() == 2
    assert not use[20:22].any()


def test_a_take_of_its_own_condition_has_its_own_shapes():
    one, other = channels(moved()), channels(moved(shape=SHAPE[::-1]))
    found = declared(one, other, condition=(0, 1))
    for take, shape in enumerate((SHAPE, SHAPE[::-1])):
        own = found.shapes_of(take)[0]
        assert mac(own, shape) > 0.999
    assert np.array_equal(found.shapes_of(0), found.shapes)


def test_damping_that_may_be_something_elses_is_less():
    found = declared(channels(moved(zeta=0.06)))
    less = lighter(found)
    assert less.damping_ratio[0] == pytest.approx(found.damping_ratio[0] / LESS)
    assert less.frequency == found.frequency and less.chi2 > found.chi2


def test_a_motion_in_the_span_of_a_loud_pair_is_none_of_its_own():
    """A softening bends a pair as one: what it makes is like neither partner, and both."""
    rng = np.random.default_rng(4)
    known = rng.standard_normal((3, 12))
    pair = known[0] - known[1]
    for shape, f, partner, alike in [
        (pair, 5.6, 5.2, True),
        (pair, 9.0, 5.2, False),  # the partner is too far from it
        (pair, 5.6, 6.0, False),  # no pair: each bends by itself
        (known[0], 9.0, 5.2, True),
        (known[2], 5.6, 5.2, False),
        (pair + 2 * rng.standard_normal(12), 5.6, 5.2, False),
    ]:
        assert _mimics(shape, f, known, np.array([5.0, partner, 11.0])) is alike
