"""Frames that a recording has lost, read off its jumps."""

from dataclasses import make_dataclass, replace

import numpy as np
import pytest

from core.jumps import _left, _moved, _nearby, _with_jumps, jumps
from core.parameters import parameters
from core.read_off import read_off
from core.timefit import extend, fit
from tests.core.test_timefit import (
    AMPLITUDE,
    NOISE,
    RATE,
    SHAPE,
    TIME,
    Softening,
    W,
    channels,
    declared,
    moved,
)


def test_frames_lost_in_one_of_two_takes_are_found_there():
    whole, gappy = moved(seed=0), np.delete(moved(seed=1), [100, 101], axis=0)
    found = declared(channels(whole), channels(gappy), condition=(0, 0))
    assert found.chi2 > 5 * found.samples
    (effect,) = [effect for effect in read_off(found) if effect.name == "lost_frames"]
    law, p = extend(found, (effect,), [()])
    with_it = fit(law, p)
    assert parameters(with_it, 0)["frames"]["value"] == 2
    assert with_it.chi2 < 1.1 * with_it.samples
    first, second = (effect.clock(None, None, TIME, data.take) - TIME for data in law.takes)
    assert not first.any()
    assert second[[99, 100]] == pytest.approx([0, 2 / RATE])


def test_of_jumps_those_that_are_of_whole_frames_are_lost_ones():
    """One frame is lost twice; between them the recording is half a frame late."""
    fine = 2 * np.arange(len(TIME))
    fine = fine + 2 * (np.arange(len(TIME)) >= 90) + 2 * (np.arange(len(TIME)) >= 210)
    fine = fine + 1 * (np.arange(len(TIME)) >= 150)
    w, z = np.sqrt(1 - 0.02**2) * W, 0.02
    when = fine / (2 * RATE)
    values = AMPLITUDE * np.outer(np.exp(-z * W * when) * np.cos(w * when), SHAPE)
    values = values + 0.1 * NOISE * np.random.default_rng(2).standard_normal(values.shape)
    found = declared(channels(values, sigma=0.1 * NOISE))
    (effect,) = jumps(found)
    (take,) = found.law.takes
    gained = effect.clock(np.zeros((1, 0)), None, take.time[None], take.take)[0] - take.time
    assert np.rint(np.diff(gained * RATE)).nonzero()[0].tolist() == [89, 209]
    assert gained[-1] * RATE == pytest.approx(2)


def test_as_many_jumps_as_a_recording_may_have_are_found():
    """Misplaced at first, they take more jumps to mend than there are."""
    places, frames = np.array([114, 142, 224, 300, 323, 391]), np.array([1, 2, 2, 3, 3, 2])
    lost = (np.arange(len(TIME))[:, None] >= places) @ frames
    kept = np.arange(len(TIME)) + lost
    values = moved()[kept[kept < len(TIME)]]
    (effect,) = jumps(declared(channels(values, time=TIME[: len(values)])))
    assert effect.report(None, None, None)["frames"] == frames.sum()


@pytest.mark.parametrize("place", [150, 400], ids=["fitted", "held out"])
def test_jumps_near_one_another_that_are_one_become_one(place):
    lost = 3 * (np.arange(len(TIME)) >= place)
    kept = np.arange(len(TIME)) + lost
    values = moved()[kept[kept < len(TIME)]]
    found = declared(channels(values, time=TIME[: len(values)]))
    takes, frame = found.law.takes, 1 / RATE
    when = takes[0].time[place] - frame / 2
    two = (((when, frame), (when + 3 * frame, 2 * frame)),)
    known, _ = _moved(two, _with_jumps(found, two, takes), takes)
    ((one,),) = known
    assert one == pytest.approx((when, 3 * frame))


def test_jumps_of_a_fitted_take_are_moved_by_what_it_shows_and_no_other_one_does():
    lost = 3 * (np.arange(len(TIME)) >= 400)  # after the fitted part
    kept = np.arange(len(TIME)) + lost
    values = moved()[kept[kept < len(TIME)]]
    one = channels(values, time=TIME[: len(values)])
    found = declared(one)
    kind = make_dataclass("Held", ["recording", "held_out", "name"])
    other = replace(
        channels(5 * moved()), take=kind(one.take.recording, True, "held out"), fit=TIME <= 0.4
    )  # of which nothing is foretold
    both = replace(found.law, takes=(*found.law.takes, other), condition=(0, 0))
    found = replace(found, law=both, predicted=(*found.predicted, np.zeros_like(other.values)))
    assert _left(found) == pytest.approx(
        (((values - found.predicted[0]) / NOISE) ** 2).sum(), rel=1e-6
    )


def test_jumps_far_apart_are_not_made_one():
    frame = 0.01
    near, far = ((1.0, frame), (1.04, frame)), ((1.0, frame), (1.05, frame))
    assert (2, (1.04, 2 * frame)) in _nearby(near, 0, frame)
    assert (2, (1.0, 2 * frame)) in _nearby(near, 0, frame)
    assert all(many == 1 for many, _ in _nearby(far, 0, frame))


def test_a_pitch_that_was_another_one_at_first_is_no_frame_lost_again_and_again():
    """It falls for good in the first take; the second one has only known it as it is then."""
    torn = [moved(Softening(0.05, when), seed=n) for n, when in enumerate((1.0, -9.0))]
    found = declared(*map(channels, torn), condition=(0, 0))
    assert found.chi2 > 5 * found.samples
    assert jumps(found) == []
    gone = np.delete(moved(zeta=0.01), [60, 61, 150, 230], axis=0)
    for gaps in (False, True):
        gone[::2, 0] = np.where(gaps, np.nan, gone[::2, 0])
        (effect,) = jumps(declared(channels(gone), channels(moved(zeta=0.01)), condition=(0, 0)))
        assert effect.free == 6  # three jumps


def test_where_no_frame_is_whole_no_jump_is_read():
    values = moved()
    values[::2, 0] = values[1::2, 1] = np.nan
    assert jumps(declared(channels(values))) == []
