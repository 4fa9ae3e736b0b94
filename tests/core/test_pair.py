"""A force on one direction of a degenerate pair, integrated here by another rule."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import race as race_of
from core.data import RingDown
from core.effects import contact, large_amplitude, split_modes, steady_drive
from core.effects.base import companion
from core.joint import laid_bare
from core.match import Match
from core.pair import across, opened, with_partner
from core.parameters import parameters
from core.partners import heard_split
from core.timefit import extend, fit
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import NOISE, SHAPE, TIME, Stop, W, channels, declared, moved, raced

OTHER = np.array([0.8, 0.7, -0.1, 0.4])  # how the markers show the other direction
ASIDE = np.array([0.1, -0.5, 1.0, 0.7])


def aslant(force, other=OTHER):
    """(T, 4) a pair that is let go aslant to what acts on it."""
    free = np.exp(-0.02 * W * TIME) * np.cos(W * np.sqrt(1 - 0.02**2) * TIME + 1.2)
    return moved(force) + AMPLITUDE * np.outer(free, other)


def paired(found):
    """The same, of a body whose first mode has a partner that was not matched."""
    setting = replace(found.law.setting, paired=True, pair_gap=0.0)
    return replace(found, law=replace(found.law, setting=setting))


def test_what_a_pair_does_across_a_stop_is_told_from_the_stop():
    found = declared(channels(aslant(Stop(0.5, 0.8))))
    alone, both = raced(found, contact.ABOVE), raced(paired(found), contact.ABOVE)
    assert alone.chi2 > 1.5 * alone.samples
    assert both.chi2 < 1.15 * both.samples
    gap = both.law.effects[-1].report(both.theta[-1][0], both.law.setting, None)["gap"]
    assert gap == pytest.approx(0.5 * AMPLITUDE, rel=0.05)


class Hardening:
    """A stiffness that grows with the square of the displacement, by `share` at the amplitude."""

    def __init__(self, share):
        self.share = share

    def pull(self, x, v, t, h):
        return -self.share * W**2 * x**3 / AMPLITUDE**2


@pytest.mark.parametrize(("alike", "other"), [(-0.3, 0.1), (0.3, 0.3)])
def test_what_a_pair_does_across_is_sought_however_much_the_reference_shows_of_it(alike, other):
    """Fitted alone, the force has taken up some of what swings across where both look alike."""
    values = aslant(Hardening(0.15), alike * SHAPE + other * OTHER)
    both = raced(paired(declared(channels(values))), large_amplitude.EFFECT)
    assert both.chi2 < 1.15 * both.samples


def test_nothing_is_taken_across_where_the_force_tells_all():
    found = paired(declared(channels(moved(Stop(0.5, 0.8)))))
    both = raced(found, contact.ABOVE)
    assert [e.name for e in both.law.effects] == ["contact"]
    assert across(both) is both


def test_nothing_is_taken_across_where_no_force_acts():
    """The other direction swings a little aside in pitch, which the mode alone cannot follow."""
    aside = np.exp(-0.02 * W * TIME) * np.cos(1.002 * W * TIME + 1.2)
    values = moved() + AMPLITUDE * np.outer(aside, ASIDE)
    found = paired(declared(channels(values)))
    both = raced(found, contact.ABOVE)
    alone = raced(declared(channels(values)), contact.ABOVE)
    assert alone.chi2 > 2 * alone.samples
    assert [e.name for e in both.law.effects] == ["contact"]


def beating(apart, seed):
    """A split pair let go aslant, `apart` over its mean, 13 swings long: a twelfth of a beat."""
    fall = np.exp(-0.02 * W * TIME)
    one, other = (fall * np.cos(W * (1 + way * apart / 2) * TIME) for way in (-1, 1))
    values = AMPLITUDE * (np.outer(one, SHAPE) + np.outer(other, ASIDE))
    return values + NOISE * np.random.default_rng(seed).standard_normal(values.shape)


def split(values):
    """The search for a split, and what is told of it."""
    found = raced(paired(declared(channels(values))), split_modes.EFFECT)
    return found, parameters(found, 0)["split"]


def test_a_pair_that_hardly_begins_to_beat_is_opened_however_a_search_has_left_it(monkeypatch):
    """Where two swings of one pitch all but cancel, a search creeps."""
    values = beating(0.007, 0)
    found, told = split(values)
    assert found.chi2 < 1.1 * found.samples
    assert told["value"] == pytest.approx(0.007, rel=0.1)
    monkeypatch.setattr(race_of, "opened", lambda found: found)
    left, crept = split(values)
    assert left.chi2 > found.chi2 and crept["value"] < 0.8 * told["value"]
    assert opened(left).chi2 == pytest.approx(found.chi2, rel=1e-4)
    bare = declared(channels(values))
    assert opened(bare) is bare


def test_the_interval_of_a_split_holds_it():
    """Both pitches are fitted, and neither is known without the other."""
    told = [split(beating(0.01, seed))[1]["ci95"] for seed in range(20)]
    assert sum(low < 0.01 < high for low, high in told) >= 18
    assert np.median([high - low for low, high in told]) < 0.005


class Laden:
    """A take that is no other one."""

    held_out = False

    def __init__(self, take):
        self.recording = take.recording


@pytest.mark.parametrize(("shape", "is_another"), [(0.4 * ASIDE, True), (SHAPE, False)])
def test_a_pair_that_a_load_parts_has_a_partner_in_that_take_alone(shape, is_another):
    """With the load both are lower, and 1.5 % apart."""

    def rings(pitch, phase):
        omega = pitch * W
        fall = np.exp(-0.02 * omega * TIME)
        return AMPLITUDE * fall * np.cos(omega * np.sqrt(1 - 0.02**2) * TIME + phase)

    noise = np.random.default_rng(3).standard_normal((2, len(TIME), len(SHAPE)))
    values = np.outer(rings(0.9, 0.0), SHAPE) + np.outer(rings(0.9 * 1.015, 1.2), shape)
    bare = channels(np.outer(rings(1.0, 0.0), SHAPE) + NOISE * noise[0])
    laden = channels(values + NOISE * noise[1])
    found = declared(bare, replace(laden, take=Laden(laden.take)), condition=(0, 1))
    assert with_partner(found, 0, 0.02) is found
    wider = with_partner(found, 0, 0.02, take=1)
    assert wider.chi2 < 1.1 * wider.samples
    assert (companion(wider, 0, condition=1, take=1) == "") is is_another
    ((split, damping_ratio),) = wider.theta[-1]
    if is_another:
        parted = np.exp(found.parameters[2] - wider.parameters[2]) * (1 + split)
        assert abs(parted - 1) == pytest.approx(0.015, abs=0.002)
        assert damping_ratio == pytest.approx(0.02, rel=0.1)


def test_the_other_direction_is_sought_with_a_drive_that_one_rings_beside():
    """A line at 7.3 Hz, while the pair rings out in both of its directions, 0.4 % apart."""
    fall = np.exp(-0.02 * W * TIME)
    line = np.outer(np.sin(2 * np.pi * 7.3 * TIME), 0.2 * AMPLITUDE * (SHAPE + ASIDE))
    values = moved() + np.outer(AMPLITUDE * fall * np.cos(1.004 * W * TIME + 1.2), ASIDE) + line
    bare = declared(channels(values))
    found = fit(*extend(bare, (steady_drive.EFFECT,), [(np.log(7.3),)]), evaluations=40)
    computed = np.array([5.0, 5.01, 31.0])
    body = SimpleNamespace(modes=SimpleNamespace(frequency=computed), parts=np.inf)
    heard = SimpleNamespace(match=Match((0,), (0,)), body=body)
    wider = laid_bare(heard, found, 1)
    assert found.chi2 > 2 * found.samples
    assert wider.chi2 < 1.1 * wider.samples
    assert wider.law.effects[-1] is steady_drive.EFFECT


@pytest.mark.parametrize(
    ("apart", "turned", "split"),
    [(0.04, np.pi / 2, True), (0.04, 0.3, False), (0.004, np.pi / 2, False), (0.2, 1.5, False)],
    ids=["split", "one direction twice", "as near as a mesh parts them", "another mode"],
)
def test_a_pair_that_was_heard_as_two_has_no_partner_at_one_pitch(apart, turned, split):
    """Two directions of a pair, as 8 channels see them; one a little faint of a third mode."""
    seen = np.linalg.qr(np.random.default_rng(5).standard_normal((8, 3)))[0].T
    ways = np.array([[1.0, 0.0, 0.1], [np.cos(turned), np.sin(turned), -0.1]])
    pitches = 10.0 * np.array([1.0, np.exp(apart)])
    ring = RingDown(
        pitches, np.full(2, 0.03), (ways @ seen).astype(complex), np.zeros(8), np.ones(8), np.eye(4)
    )
    on = np.ones(8, bool)
    assert heard_split(ring, on, 0, seen, np.array([10.0, 10.0, 25.0]), 0.001) == split
