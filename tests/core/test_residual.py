"""Errors of a prediction: of all takes, of each, and what a change of the body leaves of them."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from core.body_error import PULLED, body_error, leaves, mends, misleads
from core.channels import Channels
from core.compare import NO_SHIFTS, ShiftsLeft
from core.doubt import bends
from core.effects import air_drag, contact, stiffness_drift
from core.examine import _outweighs
from core.residual import Error, error_of

FRAMES, RATE = 300, 100


def waving(name: str, size: float, held_out: bool = False) -> Channels:
    """A take of two markers that swing by `size`; the last third is held out of one that is not."""
    time, last = np.arange(FRAMES) / RATE, 0.5 if held_out else 2.0
    wave = size * np.sin(np.outer(time, [20.0, 33.0]))
    wave[10:20, 1] = np.nan
    return Channels(
        time=time,
        values=wave + np.array([3.0, -1.0]),
        sigma=np.full(2, 1e-3),
        fit=time < last,
        marker=np.arange(2),
        support=np.zeros(2, bool),
        directions=np.zeros((2, 3)),
        row=np.zeros(2),
        rows=np.zeros((FRAMES, 2)),
        rest=np.zeros(2),
        quiet=np.full(2, np.nan),
        take=SimpleNamespace(name=name, held_out=held_out),
    )


def missed(data: Channels, fitted: float, held: float) -> np.ndarray:
    """A prediction that misses those shares of the swings about their mean."""
    known = np.nan_to_num(data.values, nan=0.0)
    out = known.copy()
    for rows, share in ((data.fit, fitted), (~data.fit, held)):
        out[rows] += share * (known[rows] - np.nanmean(data.values[rows], axis=0))
    return out


def test_each_takes_error_is_over_its_own_motion():
    """The total is that of energies: the loud take counts for nearly all. No folder is told."""
    loud, faint = waving("loud", 1.0), waving(str(Path("faint").absolute()), 0.1)
    predicted = missed(loud, 0.1, 0.2), missed(faint, 0.5, 0.6)
    error = error_of((loud, faint), predicted)
    assert [name for name, *_ in error.each] == ["loud", "faint"]
    assert np.array([one[1:] for one in error.each]) == pytest.approx(
        np.array([[0.2, 0.1], [0.6, 0.5]])
    )
    assert error.held_out == pytest.approx(np.sqrt((0.2**2 + 0.06**2) / 1.01), rel=0.01)
    assert error.fit == pytest.approx(np.sqrt((0.1**2 + 0.05**2) / 1.01), rel=0.01)


def test_with_a_whole_take_held_out_no_other_one_is():
    first, second = waving("first", 1.0), waving("second", 0.1, held_out=True)
    error = error_of((first, second), (missed(first, 0.1, 9.0), missed(second, 9.0, 0.3)))
    assert error.each == (
        ("first", None, pytest.approx(0.1)),
        ("second", pytest.approx(0.3), None),
    )
    assert error.held_out == pytest.approx(0.3) and error.fit == pytest.approx(0.1)


def test_what_a_change_of_the_body_leaves_is_counted_beyond_free_modes():
    before, free = Error(1.0, 0.8), Error(0.1, 0.05)
    assert leaves(before, before, free) == pytest.approx(1.0)
    assert leaves(Error(0.1, 0.05), before, free) == 0.0
    assert leaves(Error(0.1, 0.4), before, free) == pytest.approx(0.5, rel=0.01)
    assert leaves(Error(0.1, 0.05), Error(0.1, 0.05), free) == 0.0  # nothing shows


def test_a_change_of_the_body_mends_what_shows_held_out_or_fitted():
    before, free = Error(1.0, 0.06), Error(0.1, 0.05)  # what was fitted shows nothing
    assert mends(Error(0.7, 0.06), before, free)
    assert not mends(Error(0.9, 0.01), before, free)
    assert mends(Error(9.0, 9.0), Error(0.1, 0.05), free)


def test_a_change_of_the_body_that_foretells_worse_is_not_named():
    free = Error(0.1, 0.05)
    assert misleads(Error(1.3, 0.4), Error(1.0, 0.9), free)
    assert not misleads(Error(0.8, 0.4), Error(1.0, 0.9), free)
    assert not misleads(Error(0.13, 0.06), Error(0.12, 0.9), free)  # what was fitted shows it


def body_of(data: Channels, pulls, shares=()) -> tuple:
    """A body whose two pitches are off by so many standard deviations of a hundredth each, and the
    first by `shares` of a hundredth that both are off by in some way at once.
    """
    pitch, shapes = np.array([20.0, 33.0]) / (2 * np.pi), np.array([[1.0, 0.0], [0.0, 1.0]])
    law = SimpleNamespace(modes=2, takes=(data,), fitted=[0])
    declared = SimpleNamespace(
        law=law, frequency=pitch, shapes=shapes, predicted=(np.nan_to_num(data.values),)
    )
    shares, pulls = np.asarray(shares, float), np.asarray(pulls, float)
    ways = np.tile([0.01, 0.0, 0.0], (len(shares), 1))  # the last one is the sag's
    measured = SimpleNamespace(
        frequency=pitch, shapes=shapes, error=np.full(2, 0.01), together=ways
    )
    ground = SimpleNamespace(
        data=data, measured=measured, damping_ratio=np.full(2, 1e-6), shifts=()
    )
    off = 0.01 * pulls + [0.01 * shares.sum(), 0.0]
    found = SimpleNamespace(
        pitch_pull=pulls,
        together=shares,
        frequency=pitch * np.exp(-off),
        shapes=shapes,
        read=pitch.copy(),
        folded=(),
        shifts=NO_SHIFTS,
    )
    return declared, ground, found


def test_a_pitch_that_is_read_as_folded_shows_the_other_way_and_by_as_many_hertz():
    """One that is as far above what folds as another one is below the pitch as seen."""
    data = waving("one", 1.0)
    fit, there, plain = body_of(data, (8.0, 0.0))
    seen, twice = plain.read[0], 2 * plain.read[0]
    down = seen * (1 - np.exp(-0.01 * (8.0 - PULLED)))  # what is forgiven is forgiven of either
    up = PULLED + 100 * np.log(1 + down / twice)
    _, _, folded = body_of(data, (-up, 0.0))
    folded.read[0], folded.folded = twice, (0,)
    assert body_error(fit, there, folded).held_out == pytest.approx(
        body_error(fit, there, plain).held_out, rel=1e-6
    )


def test_a_computed_pitch_is_forgiven_what_it_may_be_off_by_and_no_more():
    """Beyond that it counts by so much as it is further off: no step where doubt ends."""
    data = waving("one", 1.0)
    within, little, much = (
        body_error(*body_of(data, (pull, 0.0))) for pull in (2.9, 3.05, 8.0)
    )  # fmt: skip
    assert within.held_out == pytest.approx(0.0, abs=1e-3)
    assert within.held_out < little.held_out < 0.05 < 0.3 < much.held_out
    for at_once in ((2.9,), (2.9, -2.9)):
        assert body_error(*body_of(data, (0.0, 0.0), at_once)).held_out == within.held_out
    assert body_error(*body_of(data, (0.0, 0.0), (8.0,))).held_out == pytest.approx(much.held_out)


def test_in_another_fits_terms_its_pitches_count_and_die_away_as_what_was_declared():
    """What rubs leaves little damping beside it, with which a pitch that is off would show long."""
    data = waving("one", 1.0)
    declared, ground, found = body_of(data, (8.0, 0.0))
    rubbed = SimpleNamespace(**vars(declared) | {"damping_ratio": np.full(2, 0.3)})
    plain = body_error(declared, ground, found)
    assert body_error(declared, ground, found, fit=rubbed) == plain
    rubbed.predicted = tuple(0.5 * one for one in declared.predicted)
    assert body_error(declared, ground, found, fit=rubbed).fit > 1.2 * plain.fit


@pytest.mark.parametrize("how", ["by itself", "as all are"])
def test_what_a_body_makes_of_another_load_counts_in_the_takes_that_have_it(how):
    """Beyond what a shift of the pitches is forgiven, and in these takes only, fitted or not."""
    first, *laden = (waving(name, 1.0) for name in ("first", "laden", "again"))
    own, ground, found = body_of(first, (0.0, 0.0))
    own.law = SimpleNamespace(modes=2, takes=(first, *laden), fitted=[0, 1], pitch=(0, 1, 1))
    own.predicted = own.predicted * 3
    own.pitches = lambda n: own.frequency
    own.damping_ratios = lambda n: np.full(2, 1e-6)
    own.shapes_of = lambda n: own.shapes
    ground.shifts = (SimpleNamespace(take=1),)

    def each(pull):
        one = np.array([[1.0, 0.0]])
        alone, common = (pull, 0.0) if how == "by itself" else (0.0, pull)
        found.shifts = ShiftsLeft(alone * one, 0.01 * np.ones((1, 2)), common, 0.01 * one)
        return [fit for _, _, fit in body_error(own, ground, found).each]

    assert each(2.9) == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)
    plain, one, other = each(8.0)
    assert plain == pytest.approx(0.0, abs=1e-3)
    as_much = body_error(*body_of(first, (8.0, 0.0))).fit
    assert one == pytest.approx(other) == pytest.approx(as_much, rel=0.1)


@pytest.mark.parametrize(("held", "told"), [(0.0, True), (0.3, False)])
def test_a_body_decides_alone_only_where_nothing_else_is_off_ahead(held, told):
    """What was fitted says that the body is wrong, and hardly what else is."""
    data = waving("one", 1.0)
    found = SimpleNamespace(
        law=SimpleNamespace(takes=(data,)), predicted=(missed(data, 0.01, held),)
    )  # fmt: skip
    free = error_of((data,), found.predicted)
    verdict = SimpleNamespace(damped=found)
    assert _outweighs(Error(0.5, 0.4), free, verdict) is told
    assert not _outweighs(Error(0.5, 0.04), free, verdict)


@pytest.mark.parametrize(
    ("acting", "bent"),
    [((air_drag,), False), ((stiffness_drift,), False), ((air_drag, contact), True)],
)
def test_what_acts_on_every_mode_in_its_own_shape_bends_none(acting, bent):
    """Then shapes and pitches that are off are the body's, whatever acts in time."""
    effects = [one.ABOVE if one is contact else one.EFFECT for one in acting]
    assert bends(SimpleNamespace(law=SimpleNamespace(effects=effects))) is bent
