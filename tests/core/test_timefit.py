"""The fit of the time layer on motions of one mode, integrated here by another rule."""

import math
from dataclasses import make_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import diagnosis, exchange, foils, sufficiency, time_layer
from core.alone import add_second
from core.baseline import _places, behind, build_law
from core.carried import carrying
from core.channels import Channels
from core.compare import Measured, compare, rematched
from core.data import RingDown
from core.diagnosis import _does_more, _if_all_told, _loud, _pair
from core.effects import (
    TIME_EFFECTS,
    air_drag,
    asymmetric_stiffness,
    base_motion,
    contact,
    dry_friction,
    large_amplitude,
    lost_frames,
    partner,
    relaxation,
    split_modes,
    stiffness_drift,
    sudden_change,
    weakening_friction,
)
from core.effects.base import FINE
from core.effects.further_mode import further_mode
from core.exchange import _is_off, _put_in_hope, _sought_again, exchanged_alone
from core.foils import weakens, weakens_rather
from core.jumps import jumps
from core.law import bounds
from core.linear_part import solve, without_columns
from core.match import Match
from core.outset import begin, outsets
from core.parameters import as_fitted, parameters
from core.race import Begun, Try, begun, begun_all, ended, race, worth
from core.read_off import _in_place, read_anew, read_off, shared_motions
from core.ready import to_their_end
from core.refit import turned
from core.residual import AHEAD, NOISY, strays
from core.screen import screen
from core.settle import _opened, _otherwise_pitched, astray
from core.simulate import COARSE, swing
from core.sufficiency import (
    ENOUGH,
    adds,
    at_a_bound,
    bends_the_body,
    counts_second,
    fails,
    gained,
    is_drowned,
    owes,
    sufficient,
)
from core.tell import told_bounds, told_sizes
from core.time_layer import MATERIAL, Candidate, judge, vetoed
from core.timefit import DONE, _gauged, as_it_stands, best_fit, extend, fit, misfits, resized, sharp
from core.verdict import Verdict
from tests.core.test_simulate import AMPLITUDE, OMEGA, setting

RATE, SECONDS, NOISE = 120, 4.0, 0.01 * AMPLITUDE
TIME = np.arange(int(RATE * SECONDS)) / RATE
SHAPE = np.array([1.0, 0.6, -0.3, 0.1])
W = float(OMEGA[0])


def channels(values, sigma=NOISE, time=TIME):
    """What the fit is told of a recording (T, C); the last third is held out."""
    T, C = values.shape
    markers = [SimpleNamespace(name=f"m{n + 1}", on="object") for n in range(C)]
    recording = SimpleNamespace(
        camera=None, markers=markers, values=values[:, :, None], start=None, stop=None
    )
    take = SimpleNamespace(name="first", held_out=False, recording=recording)
    return Channels(
        time=time[:T],
        values=values,
        sigma=np.full(C, sigma),
        fit=time[:T] <= time[T - 1] * 2 / 3,
        marker=np.arange(C),
        support=np.zeros(C, bool),
        directions=np.tile([1.0, 0, 0], (C, 1)),
        row=np.zeros(C),
        rows=np.zeros((T, C)),
        rest=np.zeros(C),
        quiet=np.full(C, np.nan),
        take=take,
    )


class Stop:
    """A spring of `k` times the mode's own beyond `gap` amplitudes, on one side."""

    def __init__(self, gap, k):
        self.gap, self.k = gap * AMPLITUDE, k

    def pull(self, x, v, t, h):
        return -self.k * W**2 * max(0.0, x - self.gap)


class Backbone:
    """An odd spring that shifts the pitch by `shift` at first, and levels off by `bend`."""

    def __init__(self, shift, bend):
        self.shift, self.bend = shift, bend

    def pull(self, x, v, t, h):
        square = (x / AMPLITUDE) ** 2
        return -(8 / 3) * W**2 * self.shift * x * square / (1 + self.bend * square)


class Softening:
    """The stiffness falls by `share` within a quarter period at the instant `when`."""

    def __init__(self, share, when):
        self.share, self.when = share, when

    def pull(self, x, v, t, h):
        return self.share * W**2 * x * min(max((t - self.when) * 20 + 0.5, 0.0), 1.0)


class Rub:
    """Coulomb's force of `size` times the mode's own at first, through a bristle; may weaken."""

    def __init__(self, size, travel, weaker=0.0, pace=1.0):
        self.size, self.travel = size * W**2 * AMPLITUDE, travel * AMPLITUDE
        self.weaker, self.pace, self.z = weaker, pace * W * AMPLITUDE, 0.0

    def pull(self, x, v, t, h):
        self.z = min(max(self.z + v * h / self.travel, -1.0), 1.0)
        return -self.size * self.z * (1 - self.weaker * (1 - math.exp(-((v / self.pace) ** 2))))


def moved(force=None, shape=SHAPE, zeta=0.02, seed=0):
    """(T, C) a mode of 5 Hz with a force, by symplectic Euler's rule in 400 steps a frame."""
    h, x, v, u = 1 / (400 * RATE), AMPLITUDE, 0.0, []
    for i in range(400 * len(TIME)):
        if i % 400 == 0:
            u.append(x)
        own = force.pull(x, v, i * h, h) if force else 0.0
        v += h * (own - 2 * zeta * W * v - W**2 * x)
        x += h * v
    return np.outer(u, shape) + NOISE * np.random.default_rng(seed).standard_normal((len(u), 4))


def declared(*data, condition=(0,)):
    """The linear fit of one mode to the recordings."""
    amplitude = (AMPLITUDE * SHAPE)[None].astype(complex)
    ring = RingDown(
        np.array([5.0]), np.array([0.03]), amplitude, np.zeros(4), np.full(4, NOISE), np.eye(2)
    )
    fitted = [one for one in data if not one.take.held_out]
    law, p = build_law([ring] * len(fitted), data, condition)
    return fit(replace(law, setting=replace(law.setting, paired=False)), p, evaluations=40)


def tried(found, effect):
    begins = effect.starts(found.law.setting, None)
    return Try(found, screen(found, effect, begins), effect, begins)


def raced(found, effect):
    return race(tried(found, effect))


def test_the_linear_part_is_that_of_least_squares_a_channel():
    values = moved()
    values[20:30, 1] = np.nan
    found = declared(channels(values))
    solved = solve(found.law, found.parameters[None])
    for c in range(4):
        use = solved.uses[0][:, c]
        basis = solved.bases[0][0, 0]
        exact, *_ = np.linalg.lstsq(basis[use], values[use, c], rcond=None)
        assert solved.coefficients[0, c] == pytest.approx(exact, rel=1e-6, abs=1e-12)


def test_a_clock_is_sought_to_its_end_though_it_gains_nothing_where_it_was_fitted():
    found = declared(channels(moved(Backbone(0.05, 0.0))))
    (take,) = found.law.takes
    late = lost_frames.lost((((take.time[-20], take.frame),),), found.law.takes)
    tries = [tried(found, large_amplitude.EFFECT), Try(found, np.zeros(1), late, [()])]
    assert [one.effect for one in going_on(tries)] == [large_amplitude.EFFECT, late]


def test_starts_are_scaled_alike_one_by_one_and_together():
    found = declared(channels(moved()))
    P = found.parameters * np.array([[1.0], [0.7]])
    both = _gauged(found.law, P)
    assert both == pytest.approx(np.vstack([_gauged(found.law, p[None]) for p in P]))
    a = found.law.sizes()[0]
    assert both[0, a:] == pytest.approx(found.parameters[a:], rel=1e-3)
    assert abs(both[1, a] / P[1, a] - 1) > 0.1


@pytest.mark.parametrize("condition", [(0, 0), (0, 1)])
def test_takes_share_shapes_within_a_condition_only(condition):
    other = np.array([1.0, 0.2, 0.3, -0.4])
    found = declared(channels(moved()), channels(moved(shape=other)), condition=condition)
    shapes = solve(found.law, found.parameters[None]).coefficients[0, :, : found.law.conditions].T
    if condition == (0, 1):
        assert shapes == pytest.approx(np.array([SHAPE, other]), abs=0.01)
    else:  # one shape for both, between them
        assert shapes == pytest.approx((SHAPE + other)[None] / 2, abs=0.03)


def test_the_best_of_two_starts_is_found_whichever_comes_first():
    found = declared(channels(moved(Stop(0.5, 0.8))))
    tries = [extend(found, (contact.ABOVE,), [start]) for start in ((0.45, -0.5), (0.9, -4.0))]
    law, starts = tries[0][0], np.array([p for _, p in tries])
    both = best_fit(law, starts)
    alone = [fit(law, p).chi2 for p in starts]
    assert min(alone) < 0.5 * max(alone)
    # sums of other batches differ in their last digits, and so does the last look that a search
    # takes: it ends where one gains less than this
    least = pytest.approx(min(alone), abs=DONE * min(alone) + 0.05)
    assert both.chi2 == least
    assert best_fit(law, starts[::-1]).chi2 == least


class Uneven:
    """A spring stiffer by `more` on one side, by as much softer on the other."""

    def __init__(self, more):
        self.more = more

    def pull(self, x, v, t, h):
        return -(W**2) * self.more * abs(x)


@pytest.mark.parametrize(
    ("effect", "force", "asked"),
    [
        (large_amplitude.EFFECT, Backbone(0.01, 0.0), 0.01),
        (large_amplitude.EFFECT, Backbone(-0.01, 0.0), -0.01),
        (asymmetric_stiffness.EFFECT, Uneven(0.03), 0.03),
        (asymmetric_stiffness.EFFECT, Uneven(-0.03), -0.03),
    ],
)
def test_a_search_begins_the_way_that_what_is_left_asks_for(effect, force, asked):
    found = declared(channels(moved(force)))
    starts = effect.starts(found.law.setting, None)[:1]
    law = one_more(found, effect)
    there = outsets(found, law, [begin(found, effect, starts)])[0]
    assert 0.1 < there[-2] / asked < 1.5  # the rest turns with it, so the way there is bent
    after, nominal = misfits(law, np.array([there, [*found.parameters, *starts[0]]]))
    assert after < found.chi2 - 50
    assert after < nominal


def test_a_search_for_a_rub_begins_with_less_damping_than_was_heard():
    found = declared(channels(moved(Rub(0.03, 0.01))))
    starts = [(0.03, np.log(0.01))]
    law = one_more(found, dry_friction.EFFECT)
    there = outsets(found, law, [begin(found, dry_friction.EFFECT, starts)])[0]
    assert abs(there[1] - 0.02) < 0.5 * abs(found.damping_ratio[0] - 0.02)
    after, nominal = misfits(law, np.array([there, [*found.parameters, *starts[0]]]))
    assert after < 0.5 * nominal


def one_more(found, effect):
    return replace(found.law, effects=(*found.law.effects, effect))


@pytest.mark.parametrize(("shift", "bend"), [(-0.3, 1.0), (0.1, 0.0)])
def test_a_backbone_is_found_whichever_way_it_bends(shift, bend):
    found = raced(declared(channels(moved(Backbone(shift, bend)))), large_amplitude.EFFECT)
    fine = sharp(found)
    assert fine.chi2 < 1.1 * fine.samples
    assert fine.theta[0][0] == pytest.approx([shift, bend], rel=0.1, abs=0.05)


def test_of_two_that_vie_the_better_one_is_told_by_fits_to_their_end():
    before = declared(channels(moved(Backbone(-0.2, 1.5))))
    drift = judge(("stiffness_drift",), raced(before, stiffness_drift.EFFECT), before)
    whole = raced(before, large_amplitude.EFFECT)
    aside = whole.parameters - 0.6 * np.eye(len(whole.parameters))[-1]  # its bend
    short = judge(("large_amplitude",), fit(whole.law, aside, evaluations=1), before)
    assert 0.95 * drift.evidence < short.evidence < drift.evidence
    best, other = to_their_end([drift, short], before)
    assert (best.names, other.names) == (short.names, drift.names)
    assert best.found.theta[0][0] == pytest.approx([-0.2, 1.5], rel=0.1)
    assert to_their_end([short], before) == [short]  # nothing vies with it


def going_on(tries, bare=None):
    """Those of the searches that are worth their end."""
    return [one for one, _ in worth(begun_all(tries), bare)[0]]


@pytest.mark.parametrize("end", [None, 1e3, 5e3])
def test_what_led_by_half_and_came_to_nothing_is_made_anew_and_not_once_more(monkeypatch, end):
    """Two lead by a hair, one of which an end bears out; a third one behind them is left alone.

    end: where the other one ends, nowhere or no better than the fit that it was to mend.
    """
    kind = make_dataclass("Tried", ["name", "start", "effect", "promise", ("anew", bool, False)],
                          frozen=True, eq=False)  # fmt: skip
    start = make_dataclass("Fit", ["chi2"], eq=False)(1e3)
    effect = SimpleNamespace(marched=True, name="rub")
    promise = np.ones(1)
    tries = [kind(name, start, effect, promise) for name in ("sound", "nothing", "behind")]
    halves = [Begun(np.zeros((1, 1)), half) for half in (200.0, 210.0, 900.0)]
    going = list(zip(tries, halves, strict=True))
    ends = {"sound": 430.0, "worse": 2e3, "anew": 400.0}
    if end:
        ends["nothing"] = end

    def ended(going):
        found = [SimpleNamespace(chi2=ends[o.name]) if o.name in ends else None for o, _ in going]
        return [(one, end, False) for (one, _), end in zip(going, found, strict=True)]

    monkeypatch.setattr(time_layer, "_anew", lambda one: [
        replace(one, name=name, anew=True) for name in ("worse", "anew", "nothing too")
    ])  # fmt: skip
    monkeypatch.setattr(time_layer, "begun_all", lambda tries: [(one, None) for one in tries])
    monkeypatch.setattr(time_layer, "worth", lambda pairs: (pairs, []))
    monkeypatch.setattr(time_layer, "_ended", ended)
    monkeypatch.setattr(time_layer, "judge", lambda names, found, start: Candidate(
        names, found, -found.chi2, 1.0, 1.0
    ))  # fmt: skip
    done = time_layer._ended_at_last(going)
    assert [found and found.chi2 for _, found, _ in done] == [430.0, 400.0, None]
    best = {}
    time_layer._gather(best, done, start)
    assert best["rub"].found.chi2 == 400.0 and best["rub"].anew
    monkeypatch.setattr(time_layer, "stands_in", lambda *_: False)
    ((same,),) = time_layer._again([([best["rub"]], tries, start)])  # without a look at anything
    assert same.found is best["rub"].found


@pytest.mark.parametrize(
    ("halves", "promises", "lead"),
    [
        ((210.0, 200.0, 220.0), (1.0, 2.0, 3.0), [1, 0]),
        ((210.0, 90.0, 220.0), (1.0, 2.0, 3.0), [1]),  # the others are far behind
        ((np.nan, 90.0, np.nan), (1.0, 2.0, 3.0), [1]),
        ((np.nan, np.nan, np.nan), (1.0, 2.0, 3.0), [2]),
    ],
    ids=["abreast", "behind", "one has got so far", "none has"],
)
def test_a_second_search_leads_where_it_is_abreast_of_the_first(halves, promises, lead):
    start, effect = object(), SimpleNamespace(marched=True)
    going = [
        (SimpleNamespace(start=start, effect=effect, promise=np.array([p])), Begun(None, half))
        for half, p in zip(halves, promises, strict=True)
    ]
    assert time_layer._leaders(going) == lead


def test_a_search_that_falls_behind_is_not_ended():
    found = declared(channels(moved(Rub(0.05, 0.02))))
    effects = dry_friction.EFFECT, air_drag.EFFECT, stiffness_drift.EFFECT, relaxation.EFFECT
    going = going_on([tried(found, effect) for effect in effects])
    assert [one.effect.name for one in going] == ["dry_friction"]


def test_a_second_effect_that_tells_little_by_half_of_the_record_is_not_ended_where_two_must_tell():
    found = declared(channels(moved(Rub(0.05, 0.02))))
    beside = race(tried(found, stiffness_drift.EFFECT))
    drag, rub = tried(beside, air_drag.EFFECT), tried(beside, dry_friction.EFFECT)
    assert going_on([drag]) == [drag]  # none from there does better
    assert going_on([drag], found) == []
    assert going_on([drag, rub], found) == [rub]


@pytest.mark.parametrize(("late", "goes_on"), [(0.0, False), (0.3, True)])
def test_what_shows_late_is_not_judged_by_half_of_the_record(late, goes_on):
    class Twice:
        """The stiffness falls a little early, and by `late` after half of the fitted part."""

        def pull(self, x, v, t, h):
            return sum(Softening(*one).pull(x, v, t, h) for one in ((0.03, 0.5), (late, 1.6)))

    found = declared(channels(moved(Twice())))
    drag = tried(found, air_drag.EFFECT)
    assert going_on([drag], found) == [drag] * goes_on


def test_what_grows_with_time_is_sought_to_its_end_where_it_promises_most():
    class Late:
        """A rub, and a stiffness that falls more and more."""

        def __init__(self):
            self.rub = Rub(0.03, 0.02)

        def pull(self, x, v, t, h):
            return self.rub.pull(x, v, t, h) + 0.2 * W**2 * x * (t / SECONDS) ** 3

    found = declared(channels(moved(Late())))
    drift = tried(found, stiffness_drift.EFFECT)
    plain = replace(drift, effect=replace(drift.effect, grows=False))
    less = replace(tried(found, air_drag.EFFECT), promise=2 * drift.promise)
    assert going_on([plain], found) == []
    assert going_on([drift], found) == [drift]
    assert drift not in going_on([drift, less], found)


def test_where_noise_is_most_of_what_is_left_half_of_the_record_tells_nothing():
    found = declared(channels(moved(Rub(0.002, 0.02)), sigma=0.9 * NOISE))
    assert found.chi2 > 1.2 * found.samples
    rub = tried(race(tried(found, stiffness_drift.EFFECT)), dry_friction.EFFECT)
    assert going_on([rub], found) == [rub]


def test_a_hard_stop_is_searched_in_fine_steps_and_found():
    found = raced(declared(channels(moved(Stop(0.5, 6.0)))), contact.ABOVE)
    assert found.law.setting.steps == FINE
    found = sharp(found)
    assert found.chi2 < 1.2 * found.samples
    assert found.theta[-1][0][0] == pytest.approx(0.5, abs=0.03)


def test_what_finer_steps_do_not_bear_out_is_sought_again_in_those():
    """A law that in steps of a 24th of a period turns round stands for a motion that escapes."""

    def flighty(theta, setting):
        push = large_amplitude.force(theta, setting)
        return lambda state: push(state) * (1 if state.h * W > 2 * np.pi / 24 else -1)

    one = tried(
        declared(channels(moved(Backbone(-0.04, 0.0)))),
        replace(large_amplitude.EFFECT, force=flighty),
    )
    assert ended(one, begun(one), anew=False) is None
    found = race(one)
    assert found.law.setting.steps > FINE
    assert found.chi2 < 1.2 * found.samples
    assert -found.theta[0][0][0] == pytest.approx(-0.04, rel=0.1)
    assert sharp(found).law.setting.steps == found.law.setting.steps


def test_what_was_searched_in_coarse_steps_is_told_in_fine_ones():
    found = declared(channels(moved(Softening(0.1, 0.8))))
    coarse = raced(found, sudden_change.FOIL)
    assert coarse.law.setting.steps == COARSE
    fine = sharp(coarse)
    assert fine.law.setting.steps == FINE
    assert fine.chi2 < 1.2 * fine.samples
    assert sharp(found) is found  # nothing is marched in it


def test_high_modes_see_as_many_steps_as_they_need():
    omega = OMEGA[0] * np.array([1.0, 7.0])
    two = replace(
        setting(), omega=omega, zeta=np.full(2, 0.01), masses=np.ones(2), couple=np.ones(2)
    )
    start = np.array([[[AMPLITUDE, 0.1 * AMPLITUDE], [0.0, 0.0]]])
    theta = np.array([[0.5, np.log(0.3), 1.0]])

    def at(steps):
        given = (omega[None], np.full((1, 2), 0.01), start, TIME[None, :120])
        return swing(*given, [(contact.ABOVE, theta)], replace(two, steps=steps))[0]

    assert np.abs(at(COARSE) - at(64 * FINE)).max() < 0.03 * AMPLITUDE


@pytest.mark.parametrize(
    ("force", "wrong", "right"),
    [(Stop(0.6, 1.0), large_amplitude.EFFECT, "contact"),
     (Backbone(0.04, 0.3), contact.ABOVE, "large_amplitude")],
    ids=["a stop", "a backbone"],
)  # fmt: skip
def test_what_bends_the_pitch_otherwise_is_tried_in_the_place_of_its_twin(
    force, wrong, right, monkeypatch
):
    found = declared(channels(moved(force)))
    only = judge((wrong.name,), raced(found, wrong), found)
    twin = next(e for e in TIME_EFFECTS if e.name == right)
    assert _put_in_hope(only.found, twin, 0.0) is None
    best, *_ = exchanged_alone([only], found)
    assert best.names == (right,)
    assert best.found.chi2 < 1.1 * best.found.samples < only.found.chi2
    assert exchanged_alone([best], found) == [best]  # it leaves nothing
    # what leaves nothing where it was fitted, but predicts worse than noise allows
    quiet = replace(only.found, chi2=1.05 * only.found.samples)
    assert fails(quiet)
    rather, *_ = exchanged_alone([judge((wrong.name,), quiet, found)], found)
    assert rather.names == (right,)
    foretold = judge((wrong.name,), replace(quiet, predicted=best.found.predicted), found)
    assert exchanged_alone([foretold], found) == [foretold]
    worse = replace(best.found, predicted=tuple(3 * y for y in only.found.predicted))
    monkeypatch.setattr(exchange, "_put_in_hope", lambda *_: worse)
    monkeypatch.setattr(exchange, "_put", lambda one, *_: one)  # nor is it sought again
    (still,) = exchanged_alone([judge((wrong.name,), quiet, found)], found)
    assert still.names == (wrong.name,)


@pytest.fixture(scope="module")
def stiffening():
    """A linear fit of what stiffens with amplitude, what tells it, and that as it bent itself."""
    found = declared(channels(moved(Backbone(0.04, 0.0))))
    told = raced(found, large_amplitude.EFFECT)
    bent = as_it_stands(told.law, np.r_[told.parameters[:-2], 0.038, 0.035])
    return found, told, bent


def again_of(one, found):
    """What is made of the fit, sought again; None where it is left as it was."""
    before = judge(("large_amplitude",), one, found)
    (after,) = _sought_again([before], found)
    return None if after is before else after.found


def test_a_law_that_bent_itself_is_sought_again(stiffening):
    found, told, bent = stiffening
    again = again_of(bent, found)
    assert again.chi2 < 1.1 * again.samples < 0.8 * bent.chi2
    assert again.theta[0][0] == pytest.approx([0.04, 0.0], abs=0.05)


def test_what_foretells_badly_is_sought_again_and_what_leaves_noise_is_not(stiffening, monkeypatch):
    found, told, bent = stiffening
    half = replace(told, predicted=(0.9 * told.predicted[0] + 0.1 * found.predicted[0],))
    assert told.chi2 < 1.1 * told.samples and fails(half, 1.1)
    asked = []
    monkeypatch.setattr(exchange, "_put", lambda one, effect, _: asked.append(effect) or one)
    assert again_of(half, found) is None and asked == [large_amplitude.EFFECT]
    monkeypatch.setattr(exchange, "_put", None)  # not to be asked
    assert again_of(told, found) is None
    unmarched = replace(bent, law=replace(bent.law, effects=(split_modes.EFFECT,)))
    assert not _is_off(unmarched)
    far = as_it_stands(told.law, np.r_[told.parameters[:-2], 0.03, 0.035])
    assert judge(("large_amplitude",), far, found).share < ENOUGH
    assert again_of(far, found) is None


@pytest.mark.parametrize("doubt", ["refuted", "ran_off", "bends_the_body", "tells less"])
def test_what_is_sought_again_in_vain_leaves_all_as_it_was(stiffening, monkeypatch, doubt):
    found, told, bent = stiffening
    far = as_it_stands(told.law, np.r_[told.parameters[:-2], 0.03, 0.035])
    monkeypatch.setattr(exchange, "_put", lambda *_: far if doubt == "tells less" else told)
    assert (again_of(bent, found) is None) is (doubt == "tells less")
    if doubt != "tells less":
        monkeypatch.setattr(exchange, doubt, lambda one: one is told)
        assert again_of(bent, found) is None


@pytest.mark.parametrize("condition", [(0, 0), (0, 1)])
def test_an_effect_is_left_without_its_columns_in_all_takes(condition):
    found = declared(channels(moved()), channels(moved(seed=1)), condition=condition)
    effects = (further_mode(11.0, 0.02), relaxation.EFFECT, contact.ABOVE, dry_friction.EFFECT)
    thetas = [e.starts(found.law.setting, None)[0] for e in effects]
    law, p = extend(found, effects, thetas)
    whole = solve(law, p[None])
    less = without_columns(law, whole, effects[3])
    widths = [[], []]
    for solved, out in zip((whole, less), widths, strict=True):
        some = replace(found, law=law, parameters=p, coefficients=solved.coefficients[0])
        for take in range(2):
            out += [np.abs(shape).sum() for shape in some.column_shapes(take)]
    gone = np.array(widths[1]) < 1e-6 * np.array(widths[0])
    assert gone.tolist() == 2 * [False, False, False, True] and np.all(widths[0])
    assert less.coefficients[..., : law.own * law.conditions].all()
    assert (less.barred & ~whole.barred).sum() == 2 * 4


@pytest.mark.parametrize("answers", [0.0, 5.0], ids=["no answer", "an answer"])
def test_what_unheard_modes_answer_a_force_counts_as_much_as_it_tells(answers):
    found = raced(declared(channels(moved(Backbone(0.04, 0.0)))), large_amplitude.EFFECT)
    trace = solve(found.law, found.parameters[None]).bases[0][0, 0, :, -1]
    (take,) = found.law.takes
    way = answers * NOISE * np.array([0.5, -1.0, 1.0, 1.0])
    values = take.values.copy()
    values[take.fit] += np.outer(trace[take.fit] / trace[take.fit].std(), way)
    law = replace(found.law, takes=(replace(take, values=values),))
    found = fit(law, found.parameters)
    basis, left = solve(law, found.parameters[None]).bases[0][0, 0][take.fit], 0.0
    for y in values[take.fit].T:
        shape, *_ = np.linalg.lstsq(basis[:, :-1], y, rcond=None)
        left += (((y - basis[:, :-1] @ shape) / NOISE) ** 2).sum()
    bare, price = len(found.parameters) + 4 + 4 - 1, np.log(found.samples)
    assert found.unknowns < bare + 4 if not answers else found.unknowns == bare + 4
    least = min(left + bare * price, found.chi2 + (bare + 4) * price)
    assert found.chi2 + found.unknowns * price == pytest.approx(least, abs=1.0)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_plain_friction_is_not_held_for_one_that_weakens(seed):
    found = declared(channels(moved(Rub(0.03, 0.02), seed=seed)))
    best = judge(("dry_friction",), raced(found, dry_friction.EFFECT), found)
    assert best.share > 0.8
    assert not weakens(found, best)


def test_friction_that_weakens_with_speed_is_told_from_plain_friction():
    found = declared(channels(moved(Rub(0.12, 0.02, weaker=0.8, pace=0.2))))
    best = judge(("dry_friction",), raced(found, dry_friction.EFFECT), found)
    assert weakens(found, best)


@pytest.mark.parametrize(
    ("plain", "weak", "told"),
    [
        ((0.4, 0.4), (0.1, 0.1), True),
        ((0.4, 0.4), (0.35, 0.35), False),
        ((-0.012, 0.23), (-0.014, 0.21), False),  # of noise no share is left
        ((-0.012, 0.23), (-0.014, 0.08), True),
        ((0.05, 0.4), (0.01, 0.35), False),
        ((0.05, 0.4), (0.3, 0.1), False),
        ((0.4, 0.4), (0.5, 0.1), False),  # what was held out alone
    ],
    ids=["less", "little less", "noise", "and ahead", "hardly any", "more", "ahead alone"],
)
def test_a_rub_weakens_where_that_leaves_less_beyond_noise(plain, weak, told, monkeypatch):
    """Of what was fitted; or of all, and no more of what was fitted."""
    law = SimpleNamespace(effects=[dry_friction.EFFECT])
    one, other = (
        SimpleNamespace(law=law, theta=[[0.0]], chi2=1.0, evidence=evidence, left=left)
        for evidence, left in ((0.0, plain), (1e3, weak))
    )
    monkeypatch.setattr(foils, "sharp", lambda found: found)
    monkeypatch.setattr(foils, "_weakened", lambda found: other)
    monkeypatch.setattr(foils, "swapped", lambda *_: (law, [None]))
    monkeypatch.setattr(foils, "fit", lambda *_, **__: one)
    monkeypatch.setattr(foils.weakening_friction, "without", lambda theta: theta)
    monkeypatch.setattr(foils, "judge", lambda names, found, declared: found)
    monkeypatch.setattr(
        foils, "_over", lambda found, parts=(False, True): found.left[len(parts) - 1]
    )
    assert weakens(None, SimpleNamespace(names=("dry_friction",), found=one)) is told


class Both:
    """Two forces at a time."""

    def __init__(self, *parts):
        self.parts = parts

    def pull(self, x, v, t, h):
        return sum(part.pull(x, v, t, h) for part in self.parts)


@pytest.mark.parametrize(
    ("force", "told"),
    [(Rub(0.12, 0.02, weaker=0.8, pace=0.2), True), (Both(Rub(0.05, 0.02), Stop(0.5, 6.0)), False)],
    ids=["a weakening rub", "a rub and a stop"],
)
def test_two_effects_do_not_stand_in_for_a_rub_that_weakens(force, told):
    found = declared(channels(moved(force)))
    rub = judge(("dry_friction",), raced(found, dry_friction.EFFECT), found)
    both = raced(rub.found, contact.ABOVE)
    assert weakens_rather(found, both, rub) is told


@pytest.mark.parametrize(
    ("left", "far_off", "told"),
    [(1.03, False, False), (1.4, False, True), (1.03, True, True)],
    ids=["noise", "more", "off ahead"],
)
def test_two_effects_that_alone_leave_noise_are_no_rub_that_weakens(
    left, far_off, told, monkeypatch
):
    """Though that tells nearly as much: of so loud a motion what is left is little all the same."""
    plain, both, weak = (
        SimpleNamespace(chi2=1e4 * chi, samples=1e4, evidence=evidence)
        for chi, evidence in ((3.7, 3.2e5), (left, 5.55e5), (1.44, 5.5e5))
    )
    monkeypatch.setattr(foils, "sharp", lambda found: found)
    monkeypatch.setattr(foils, "_weakened", lambda found: weak)
    monkeypatch.setattr(foils, "judge", lambda names, found, declared: found)
    monkeypatch.setattr(foils, "strays", lambda found, much: far_off)
    rub = SimpleNamespace(names=("dry_friction",), found=plain)
    assert weakens_rather(None, both, rub) is told


def test_in_a_plane_a_rub_weakens_with_speed_whichever_way_it_goes():
    theta = np.array([[0.1, np.log(0.02), 0.75, np.log(0.1)]])
    for way in (np.array([[0.6], [0.8]]), np.array([[0.0], [-1.0]])):
        push = weakening_friction.IN_PLANE.force(theta, setting())
        quick = push(SimpleNamespace(dx=1e3 * way, h=1.0))
        assert quick == pytest.approx(-0.25 * 0.1 * OMEGA[0] ** 2 * AMPLITUDE * way)


def test_a_weakening_rub_is_plain_at_rest_and_weak_at_speed():
    theta = np.array([[0.1, np.log(0.02), 0.75, np.log(0.1)]])
    fast, rest = SimpleNamespace(dx=np.full(1, 1e3), h=1.0), SimpleNamespace(dx=np.zeros(1), h=1.0)
    weakening, plain = (
        friction.force(theta, setting()) for friction in (weakening_friction.FOIL, dry_friction)
    )
    quick, slow = (weakening(state)[0] for state in (fast, rest))
    assert slow == pytest.approx([plain(state)[0] for state in (fast, rest)][1])
    assert quick == pytest.approx(slow / 4)


def split(
    by, z=0.02, *, sigma=(0.0, 0.0), left=1.0, across=True, tilted=False, flat=False, line=0.0
):
    """A fit with one mode, damped by 0.02, and a partner `by` from it, as vetoes see it.

    sigma: standard deviations of the split and of the partner's damping ratio. left: of the noise,
    beside which a swing at `line` times the mode's pitch is left, if any.
    """
    rest = 0.1 * np.sqrt(left) * np.random.default_rng(0).standard_normal((len(TIME), 2))
    rest[:, 0] += bool(line) * np.exp(-0.5 * TIME) * np.cos(line * OMEGA[0] * TIME)
    seen = SimpleNamespace(
        sigma=np.full(2, 0.1), time=TIME, fit=np.ones(len(TIME), bool), support=np.zeros(2, bool)
    )
    second = [[0.5 * tilted], [1.0]] if across else [[1.0], [0.5]]
    return SimpleNamespace(
        theta=[np.array([[by, z]])],
        law=SimpleNamespace(
            setting=replace(setting(), towards=np.ones(1) if flat else None),
            modes=1,
            own=1,
            damping="free",
            fitted=(0,),
            takes=(seen,),
        ),
        missed=lambda take: rest,
        pitches=lambda take: OMEGA / (2 * np.pi),
        frequency=OMEGA / (2 * np.pi),
        damping_ratio=np.array([0.02]),
        parameters=np.r_[np.log(OMEGA / (2 * np.pi)), 0.02, by, z],
        covariance=np.diag([0.0, 0.0, *np.square(sigma)]),
        chi2=100.0 * (left + 10 * bool(line)),
        samples=100,
        coefficients=np.array([[1.0], [0.0 if across else 0.5]]),
        column_shapes=lambda take=0: [np.hstack([second, np.zeros((2, 1))])],
    )


@pytest.mark.parametrize(("spread", "named"), [(0.004, True), (0.006, False)])
def test_a_split_within_three_sigma_of_what_meshes_split_by_is_none(spread, named):
    assert bool(split_modes.veto(split(0.02, sigma=(spread, 0.0)))) is not named


@pytest.mark.parametrize(
    ("flat", "left", "line", "named"),
    [
        (True, 1.05, 0, True),
        (True, 1.5, 0, False),
        (False, 1.05, 0, False),
        (True, 1.0, 3.3, True),
        (True, 1.0, 1.1, False),
        (True, 1.5, 3.3, False),
    ],
)
def test_a_split_of_the_same_shape_is_one_where_a_camera_may_see_both_ways_alike(
    flat, left, line, named
):
    """It leaves nothing, or what rings at a pitch that is none of such a pair's."""
    one = split(0.08, left=left, across=False, flat=flat, line=line)
    assert bool(split_modes.veto(one)) is not named


@pytest.mark.parametrize(("other", "kept"), [([0.9, 0.5], True), ([-0.5, 1.0], False)])
def test_a_partner_of_the_same_shape_is_one_where_the_channels_see_both_ways_alike(other, kept):
    """Else a mode beside itself tells any swing that falls otherwise than it should."""
    one = split(0.003, across=False)
    one.law.ways = (np.array([[1.0, 0.5], other]).T,)
    assert bool(partner.partner(partner.Where(0, 5.0, 0.02), 0.004).veto(one)) is not kept


@pytest.mark.parametrize(
    ("z", "spread", "tilted", "left", "named"),
    [
        (0.021, 0.0, True, 1.2, True),
        (0.028, 0.0, True, 1.2, False),
        (0.028, 0.0, True, 1.05, False),
        (0.028, 0.003, True, 1.2, True),
        (0.028, 0.0, False, 1.2, True),
        (0.032, 0.0, False, 1.2, False),
        (0.032, 0.0, False, 1.05, True),
        (0.062, 0.0, False, 1.05, False),
    ],
)
def test_a_pair_is_damped_alike_and_unlike_straight_across_most_where_noise_is_left(
    z, spread, tilted, left, named
):
    one = split(0.05, z, sigma=(0.0, spread), left=left, tilted=tilted)
    assert bool(split_modes.veto(one)) is not named


@pytest.mark.parametrize(("turning", "named"), [(0.4, True), (0.6, False)])
def test_a_partner_that_turns_by_itself_is_no_mode_of_a_body_at_rest(turning, named):
    """As much of it a quarter of a period off as makes an ellipse of that ratio of its axes."""
    one = split(0.05)
    shapes = np.array([[0.0, turning], [1.0, 0.0]])
    one.column_shapes = lambda take=0: [shapes @ np.array([[0.6, 0.8], [-0.8, 0.6]])]
    assert bool(split_modes.veto(one)) is not named


def test_a_split_is_that_of_the_mode_that_has_a_partner():
    two = replace(setting(), omega=W * np.array([1.0, 2.2]), zeta=np.full(2, 0.02), pair=1)
    theta = np.array([0.03, 0.02])
    own = W * 2.2 / (2 * np.pi)
    told = split_modes.report(theta, replace(two, pitches=np.array([7.0, 0.99 * own])), None)
    assert told["split"] == pytest.approx((1.03 - 0.99) / 1.01)
    wave = split_modes.columns(theta[None], two, TIME[None], None)[0, :, 0]
    swings = (np.diff(np.sign(wave)) != 0).sum() / 2 / (TIME[-1] - TIME[0])
    assert swings == pytest.approx(1.03 * own, rel=0.02)


def two_modes(ratio):
    """The fit of two modes to a recording of two, heard at the first one's pitch."""
    other = np.array([0.2, -0.5, 0.6, 0.4])
    values = moved(zeta=0.02)
    fall = np.exp(-0.02 * ratio * W * TIME)
    values += AMPLITUDE * np.outer(fall * np.cos(ratio * W * TIME), other)
    ring = RingDown(
        np.array([5.0, 5.0 * 1.1]),
        np.array([0.03, 0.03]),
        AMPLITUDE * np.array([SHAPE, other], complex),
        np.zeros(4),
        np.full(4, NOISE),
        np.eye(4),
    )
    law, p = build_law([ring], (channels(values),), (0,))
    return law, p


def test_a_tied_mode_stays_where_the_first_one_puts_it_and_is_free_within_that():
    law, p = two_modes(1.12)
    tied = replace(law, tied=((1, math.log(1.1)),))
    free, held = fit(law, p, evaluations=40), fit(tied, p, evaluations=40)
    assert free.frequency[1] / free.frequency[0] == pytest.approx(1.12, rel=2e-3)
    assert held.frequency == pytest.approx(free.frequency, rel=1e-5)
    law, p = two_modes(1.25)
    held = fit(replace(law, tied=((1, math.log(1.1)),)), p, evaluations=40)
    assert held.frequency[1] / held.frequency[0] < 1.1 * math.exp(0.031)
    assert held.chi2 > 5 * fit(law, p, evaluations=40).chi2


@pytest.mark.parametrize("times", [-0.002, -150.0])
def test_a_mode_that_began_at_another_size_or_sign_ends_at_the_body_s(times):
    law, p = two_modes(1.12)
    good, a = fit(law, p, evaluations=40), law.sizes()[0]
    p[[a + 1, a + 3]] *= times
    found = fit(law, p, evaluations=40)
    assert found.sizes_off.max() > 0.5  # the search does not come back by itself
    again = resized(found)
    assert max(good.sizes_off.max(), again.sizes_off.max()) < 0.01
    assert again.chi2 == pytest.approx(good.chi2, rel=1e-3)


def touched(mass):
    """(T, C) of two modes that go against one stop, the second of so many times the mass that its
    shape says, by symplectic Euler's rule; and their shapes.
    """
    other = np.array([0.2, -0.5, 0.6, 0.4])
    h, w, z = 1 / (200 * RATE), W * np.array([1.0, 2.7]), 0.02
    couple, weights = np.array([1.0, other[0] / SHAPE[0]]), np.array([1.0, 1 / mass])
    x, v, u = AMPLITUDE * np.array([1.0, 0.6]), np.zeros(2), []
    for i in range(200 * len(TIME)):
        if i % 200 == 0:
            u.append(x.copy())
        push = -2.0 * W**2 * max(0.0, couple @ x - 0.5 * AMPLITUDE)
        v += h * (push * couple * weights - 2 * z * w * v - w**2 * x)
        x += h * v
    values = np.array(u) @ [SHAPE, other]
    return values + NOISE * np.random.default_rng(0).standard_normal(values.shape), other


def without_the_stop(mass):
    """The linear fit of two modes to what goes against a stop."""
    values, other = touched(mass)
    ring = RingDown(
        np.array([5.0, 13.5]),
        np.array([0.03, 0.03]),
        AMPLITUDE * np.array([SHAPE, 0.6 * other], complex),
        np.zeros(4),
        np.full(4, NOISE),
        np.eye(4),
    )
    law, p = build_law([ring], (channels(values),), (0,))
    masses = np.array([1.0, 0.6**2])  # the first one over each, where its marker moves most
    return fit(
        replace(law, setting=replace(law.setting, paired=False, masses=masses)), p, evaluations=40
    )


def with_the_stop(found):
    """The same with the stop, begun at what it is."""
    stop = (0.5, np.log(2.0), found.law.setting.couple[1])
    law, p = extend(found, (contact.ABOVE,), [stop])
    return fit(law, p, evaluations=40)


@pytest.mark.parametrize(("mass", "bends"), [(1.0, False), (4.0, True)])
def test_what_fits_only_in_another_body_is_no_explanation(mass, bends):
    bare = without_the_stop(mass)
    found = with_the_stop(bare)
    one = judge(("contact",), found, bare)
    assert found.chi2 < found.samples
    assert sufficient(one, ENOUGH) is not bends
    assert counts_second(judge(("none",), bare, bare), one, 0.0) is not bends
    assert bool(told_sizes(found)) is bends
    chain = (None, bare), ("contact", found)
    told = _if_all_told(Verdict("explained", chain, (one,), ((),), (), ()))
    assert told.verdict == ("unexplained" if bends else "explained")
    assert bends_the_body(found) is bends


@pytest.mark.parametrize(
    ("effect", "theta", "beyond"),
    [
        (large_amplitude.EFFECT, (0.9, 4.0), False),
        (large_amplitude.EFFECT, (1.499, 0.0), True),
        (large_amplitude.EFFECT, (-0.999, 0.0), True),
        (stiffness_drift.EFFECT, (-0.5999, 0.0), True),
        (contact.ABOVE, (contact.ABOVE.high[0], 0.0), False),  # where it sits, no strength
    ],
)
def test_what_must_be_as_strong_as_nothing_is_is_no_explanation(effect, theta, beyond):
    found = SimpleNamespace(law=SimpleNamespace(effects=[effect]), theta=[np.array([theta])])
    bare = SimpleNamespace(law=SimpleNamespace(effects=[]))
    assert at_a_bound(found, bare) == ([effect.name] if beyond else [])
    assert not at_a_bound(found, found)  # declared, it is no finding
    assert bool(told_bounds(found, bare)) is beyond
    chain = ((None, bare), (effect.name, found))
    with pytest.MonkeyPatch.context() as patch:
        for name in ("owes", "bends_the_body"):
            patch.setattr(diagnosis, name, lambda *_: False)
        told = diagnosis._if_all_told(Verdict("explained", chain, (None,), ((),), (), ()))
    assert told.verdict == ("unexplained" if beyond else "explained")


@pytest.mark.parametrize(("damping_ratio", "is_none"), [(0.3, False), (0.6, True)])
def test_what_stands_in_for_the_swing_itself_is_no_effect(damping_ratio, is_none):
    found = raced(declared(channels(moved(Rub(0.05, 0.02)))), air_drag.EFFECT)
    p = found.parameters.copy()
    p[1] = damping_ratio
    assert vetoed(replace(found, parameters=p)) is is_none


def test_the_order_of_two_effects_does_not_change_the_fit():
    found = declared(channels(moved(Rub(0.05, 0.02))))
    both, p = extend(found, (dry_friction.EFFECT, air_drag.EFFECT), [(0.04, np.log(0.05)), (0.02,)])
    one = fit(both, p, evaluations=30)
    other = turned(one)
    assert [e.name for e in other.law.effects] == ["air_drag", "dry_friction"]
    assert other.chi2 == pytest.approx(one.chi2, rel=0.02)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 2.5])
def test_a_shaken_mode_answers_as_a_seismometer_does(ratio):
    omega, zeta = W, 0.08
    time = np.linspace(0, 12, 3001)
    seen = base_motion.answer(omega, zeta, time, np.sin(ratio * omega * time))
    late = time > 8  # its own ringing has died
    gain = ratio**2 / np.hypot(1 - ratio**2, 2 * zeta * ratio)  # Den Hartog, 2.8
    assert np.abs(seen[late]).max() == pytest.approx(gain, rel=0.02)


def test_the_objects_middle_lies_behind_markers_on_its_front():
    camera = SimpleNamespace(rows=np.eye(3))
    markers = [SimpleNamespace(position=np.array([x, 0.0, 0.0])) for x in (-0.1, 0.1)]
    data = SimpleNamespace(
        take=SimpleNamespace(recording=SimpleNamespace(camera=camera, markers=markers))
    )
    box = np.array([[-0.2, -0.1, 0.0], [0.2, 0.1, 0.2]])
    assert behind(box, data) == pytest.approx(0.1)


def test_computed_modes_that_change_places_are_matched_by_what_fits():
    shapes = np.array([[1.0, 0.5, 0.2], [0.1, 1.0, -0.9], [0.2, 1.0, -0.5]])
    computed = np.array([5.0, 30.0, 31.0])
    measured = Measured(
        np.array([5.0, 31.0]), np.full(2, 0.005), shapes[[0, 1]], np.full((2, 3), 0.2)
    )
    values = (2 * np.pi * computed) ** 2
    first = compare(measured, values, shapes)
    assert first.modes == (0, 1)  # by the shape, though its pitch is the other's
    found = rematched(measured, values, shapes, None, first)
    assert found.modes == (0, 2) and found.chi2 < first.chi2


@pytest.mark.parametrize(("octaves", "is_none"), [(0.5, False), (-1.02, True), (1.02, True)])
def test_what_moves_the_first_mode_as_far_as_it_may_go_is_no_effect(octaves, is_none):
    found = declared(channels(moved(Rub(0.02, 0.01))))
    found = fit(*extend(found, (dry_friction.EFFECT,), [(0.02, np.log(0.01))]), evaluations=20)
    p = found.parameters.copy()
    p[0] = np.log(found.law.setting.omega[0] / (2 * np.pi)) + octaves * np.log(2)
    assert vetoed(replace(found, parameters=p)) == is_none


def test_two_measured_modes_may_change_places():
    """A first pitch that is a quarter too high sends the others each to the one above it."""
    shapes = np.array([[1.0, 0.5, 0.2, 0.1], [0.1, 1.0, -0.9, 0.3], [0.3, 0.9, -0.8, -0.3]])
    computed = np.array([5.0, 30.0, 39.0])
    measured = Measured(
        computed[[0, 2, 1]] * [1.3, 1, 1], np.array([0.3, 0.01, 0.01]), shapes[[0, 2, 1]],
        np.full((3, 4), 0.3),
    )  # fmt: skip
    values = (2 * np.pi * computed) ** 2
    first = compare(measured, values, shapes)
    assert first.modes == (0, 1, 2)
    found = rematched(measured, values, shapes, None, first)
    assert found.modes == (0, 2, 1) and found.chi2 < first.chi2 / 10


def test_a_rubs_force_is_as_unsure_as_its_place_and_no_more():
    found = declared(channels(moved(Rub(0.02, 0.01))))
    levers = np.array([1.0, 0.5, 0.25, 0.2])
    known = replace(found.law.setting, levers=levers, places=np.zeros((4, 0)), modal_mass=0.02)
    found = raced(replace(found, law=replace(found.law, setting=known)), dry_friction.EFFECT)
    told = parameters(found, 0)["force"]
    low, high = told["ci95"]
    at_tip = 0.02 * 0.02 * W**2 * AMPLITUDE
    assert told["value"] == pytest.approx(at_tip, rel=0.1)
    assert low < at_tip < at_tip / levers[-1] < high < 1.5 * at_tip / levers[-1]


def test_a_rub_aslant_to_the_first_mode_sits_where_a_mix_of_directions_moves():
    """A rod's two bending modes: at its tip a force may act along any mix of them."""
    reach = np.linspace(0, 1, 500) ** 2
    moved = np.zeros((500, 3, 2))
    moved[:, 1, 0], moved[:, 2, 1] = reach, reach
    places, levers = _places(moved, reach)
    rod = replace(setting(), places=places, levers=levers)
    angle = np.arctan(places[:, 0])
    assert np.abs(levers).max() == pytest.approx(1.0, abs=0.01)
    assert (levers <= np.cos(angle) + 1e-9).all()  # the force is spread over both directions
    for way in (0.5, 1.0, -2.0):
        able, _ = rod.able(np.array([way]), np.zeros(1))
        assert able.max() == pytest.approx(np.cos(np.arctan(way)), abs=0.1)
        assert 0.4 * able.max() < rod.lever(np.array([way])) < able.max()


def test_one_mode_leaves_a_rub_anywhere_on_the_body():
    reach = np.linspace(0, 1, 500) ** 2
    moved = np.zeros((500, 3, 1))
    moved[:, 1, 0] = reach
    places, levers = _places(moved, reach)
    assert places.shape == (len(levers), 0)
    assert (levers.min(), levers.max()) == pytest.approx((0.1, 1.0), abs=0.01)


def test_a_force_sits_where_some_place_of_the_body_may_be():
    places = np.array([[1.0, 2.0], [-4.0, 0.1], [0.5, -90.0]])
    low, high = bounds(dry_friction.EFFECT, 3, places)
    assert (high[-2:] == [6.0, 30.0]).all()
    assert (low[-2:] == -high[-2:]).all()
    assert (bounds(dry_friction.EFFECT, 3, places[:1])[1][-2:] == 30.0).all()


def test_few_places_are_told_once_each():
    moved = np.zeros((3, 3, 2))
    moved[:, 1, 0] = [0.2, 1.0, 0.5]
    moved[:, 1, 1] = [0.1, 0.52, 0.27]
    places, levers = _places(moved, moved[:, 1, 0])
    assert sorted(levers) == pytest.approx([0.2, 0.5, 1.0])
    assert len(places) == 3


@pytest.mark.parametrize(
    ("rest", "late", "owing"),
    [(0.0, 0.0, False), (0.2, 0.0, False), (0.4, 0.0, True), (0.0, 0.05, False), (0.0, 0.3, True)],
    ids=["noise", "a little fitted", "much fitted", "a trifle held out", "much held out"],
)
def test_an_explanation_owes_what_it_leaves_beyond_noise_and_a_trifle(rest, late, owing):
    found = declared(channels(moved(zeta=0.02)))
    assert owes(leaving(found, rest, late), leaving(found, 1.0, 1.0)) is owing


def test_what_is_read_off_the_record_leaves_no_trifle():
    found = declared(channels(moved(zeta=0.02)))
    jump = lost_frames.lost((((1.0, 1 / RATE),),), found.law.takes)
    bent, mode = large_amplitude.EFFECT, further_mode(8.0, 0.02)
    for effects, owing in [((jump, mode), True), ((bent, mode), False), ((jump, bent), False)]:
        told = leaving(found, 0.0, 0.05)
        told = replace(told, law=replace(told.law, effects=effects))
        assert owes(told, leaving(found, 1.0, 1.0)) is owing


def leaving(found, fitted, held):
    """The fit where so much of a wave that no mode has is left, fitted and held out."""
    data = found.law.takes[0]
    wave = 30 * data.sigma * np.sin(9.7 * W * data.time)[:, None]
    part = np.where(data.fit, fitted, held)[:, None] * wave
    left = ((data.values - found.predicted[0] - part) / data.sigma)[data.fit]
    return replace(found, predicted=(found.predicted[0] + part,), chi2=float((left**2).sum()))


@pytest.mark.parametrize(("damping_ratio", "said"), [(0.2, "explained"), (0.45, "unexplained")])
def test_what_leaves_the_swings_to_die_at_once_explains_nothing(damping_ratio, said):
    """It leaves noise only, but what stops the strongest mode is not told."""
    found = declared(channels(moved(zeta=0.02)))
    p = found.parameters.copy()
    p[1] = damping_ratio
    final = replace(found, parameters=p)
    assert final.damping_ratio[final.loudest] == damping_ratio
    chain = (None, leaving(found, 1.0, 1.0)), ("contact", final)
    told = _if_all_told(Verdict("explained", chain, (object(),), ((),), (), ()))
    assert told.verdict == said


@pytest.mark.parametrize(("loudest", "drowned"), [(0, False), (1, True), (2, False)])
def test_a_mode_that_is_not_the_strongest_may_die_at_once(loudest, drowned):
    found = SimpleNamespace(damping_ratio=np.array([0.02, 0.45, 0.1]), loudest=loudest)
    assert is_drowned(found) is drowned


def test_two_effects_may_leave_less_than_one():
    found = declared(channels(moved(zeta=0.02)))
    chain = (None, leaving(found, 0.2, 0.2)), ("one", leaving(found, 0.0, 0.041))
    told = [
        _if_all_told(Verdict("explained", chain, (object(),) * count, (), (), ())).verdict
        for count in (1, 2)
    ]
    assert told == ["explained", "unexplained"]


def test_what_mends_the_tail_counts_as_a_second_effect():
    """The first one fits to the noise and is off ahead: what is left is sought."""
    found = declared(channels(moved(seed=1)))
    assert found.chi2 < found.samples
    held = ~found.law.takes[0].fit
    off = replace(found, predicted=(found.predicted[0] + 2 * NOISE * held[:, None],))
    first = judge(("contact",), off, off)
    assert strays(off, AHEAD) and not strays(found, AHEAD)
    assert counts_second(first, judge(("stiffness_drift",), found, off), 0.1)
    assert not counts_second(judge(("contact",), found, found), first, 0.1)


@pytest.mark.parametrize(
    ("ahead", "left", "quiet", "counts"),
    [
        (1.35, 1.0, True, True),
        (1.35, 1.1, True, False),  # a quarter of it is left
        (1.35, 1.0, False, False),  # the first one does not tell what was fitted
        (1.1, 1.0, True, False),  # what is left ahead may be noise
    ],
)
def test_what_leaves_noise_ahead_counts_beside_what_leaves_a_little_more(
    ahead, left, quiet, counts
):
    """One effect may bend itself to nearly what two others do."""
    found = declared(channels(moved(seed=1)))
    data = found.law.takes[0]
    held, noise = ~data.fit[:, None], NOISE * np.random.default_rng(2).standard_normal((480, 4))

    def leaves(times, chi2=1.0):
        """So many times the noise ahead."""
        predicted = np.where(held, data.values - times * noise, found.predicted[0])
        return replace(found, predicted=(predicted,), chi2=chi2 * found.chi2)

    first = judge(("asymmetric_stiffness",), leaves(ahead, 1 if quiet else 1.5), leaves(3.0))
    second = judge(("relaxation",), leaves(left), first.found)
    assert not strays(first.found, AHEAD)
    assert counts_second(first, second, 0.1) is counts


@pytest.mark.parametrize(
    ("ahead", "left", "counts"),
    [
        (2.0, 0.0, True),
        (2.0, 0.8, False),  # most of it is left
        (1.0, 0.0, False),  # it hardly shows ahead
    ],
)
def test_what_tells_all_that_a_first_effect_leaves_counts_however_little(ahead, left, counts):
    """Over the noise where it was fitted, but a trifle of the motion."""
    noise = 0.05 * NOISE
    rest = (NOISE - noise) * np.random.default_rng(1).standard_normal((len(TIME), 4))
    found = declared(channels(moved(seed=1) - rest, sigma=noise))

    def leaves(much):
        data = found.law.takes[0]
        part = np.where(data.fit, 1.5, ahead)[:, None] * much * noise
        off = ((data.values - found.predicted[0] - part) / data.sigma)[data.fit]
        chi2 = float((off**2).sum())
        return replace(found, predicted=(found.predicted[0] + part,), chi2=chi2)

    first = judge(("dry_friction",), leaves(1.0), leaves(20.0))
    assert first.found.chi2 > 2 * first.found.samples
    second = judge(("stiffness_drift",), leaves(left), first.found)
    assert gained(first.found, second.found) < MATERIAL
    assert counts_second(first, second, 0.1) is counts


@pytest.mark.parametrize(("clock", "left", "is_part"), [
    (True, 0.0, True),
    (True, 1.0, False),  # most of it is left
    (False, 0.0, False),  # what acts must show where it was fitted
])  # fmt: skip
def test_frames_lost_after_the_fitted_part_are_a_part_of_what_was_off(clock, left, is_part):
    """The first effect leaves three times the noise there, too, which nothing tells."""
    found = declared(channels(moved(seed=1)))
    (data,) = found.law.takes
    effect = lost_frames.lost((((data.time[400], data.frame),),), found.law.takes)
    effect = effect if clock else stiffness_drift.EFFECT
    rough = 3 * NOISE * np.random.default_rng(2).standard_normal(data.values.shape)

    def leaves(ahead, law):
        part = np.where(data.fit[:, None], rough, ahead * NOISE)
        chi2 = 9.0 * found.samples
        return replace(found, law=law, predicted=(found.predicted[0] + part,), chi2=chi2)

    first = judge(("contact",), leaves(3.0, found.law), found)
    mended = leaves(3.0 * left, replace(found.law, effects=(effect,)))
    assert adds(first, judge(("contact", effect.name), mended, first.found)) is is_part
    quiet = judge(("contact",), leaves(1.0, found.law), found)  # nothing is off there
    assert not adds(quiet, judge(("contact", effect.name), mended, quiet.found))


@pytest.mark.parametrize(
    ("off", "left", "held", "counts"),
    [
        (1.7, 1.0, 0.95, True),
        (1.7, 1.4, 0.95, False),  # what mends a little must mend it all
        (2.8, 1.4, 0.95, True),
        (2.8, 1.4, 0.80, False),
    ],
)
def test_what_mends_nearly_all_that_is_far_off_ahead_counts(monkeypatch, off, left, held, counts):
    """Beside a first effect that leaves only noise where it was fitted."""
    ahead = {"first": off, "second": left}
    for name, value in {
        "bends_the_body": lambda found: False,
        "gained": lambda before, after: 0.001,
        "adds": lambda first, second: False,
        "strays": lambda found, much=2.0: ahead[found.name] > much,
        "fails": lambda found: ahead[found.name] > 1.1,
    }.items():
        monkeypatch.setattr(sufficiency, name, value)
    first, second = (
        SimpleNamespace(found=SimpleNamespace(name=name, chi2=1.0, samples=1.0), share=0.5)
        for name in ahead
    )
    second.held_share = held
    assert counts_second(first, second, 0.1) is counts


def as_if(found, effect, *theta):
    """The same, as if an effect told it."""
    law, p = extend(found, (effect,), [theta])
    return replace(found, law=law, parameters=p)


@pytest.mark.parametrize(
    ("left", "effect", "theta", "loud"),
    [
        (1.15, large_amplitude.EFFECT, (0.03, 4.0), True),
        (1.15, large_amplitude.EFFECT, (0.03, -0.6), True),
        (1.15, large_amplitude.EFFECT, (0.03, 2.0), False),
        (1.05, large_amplitude.EFFECT, (0.03, 4.0), False),
        (1.15, asymmetric_stiffness.EFFECT, (0.2, 2.0), True),
        (1.15, asymmetric_stiffness.EFFECT, (0.2, 1.0), False),
        (1.15, stiffness_drift.EFFECT, (0.1, 2.0), False),
        (1.15, air_drag.EFFECT, (0.01,), False),
    ],
    ids=["flat", "steep", "between", "to noise", "square", "plain", "in time", "no spring"],
)
def test_one_effect_is_doubted_where_its_law_is_bent_as_far_as_it_may_be_and_leaves_a_little(
    left, effect, theta, loud
):
    quiet = declared(channels(moved(seed=1)))
    far = replace(quiet, chi2=30.0 * quiet.samples)
    one = as_if(replace(quiet, chi2=left * quiet.samples), effect, *theta)
    found = judge((effect.name,), one, far)
    chain = ((None, far), (effect.name, one))
    assert _loud(Verdict("explained", chain, (found,), ((),), (), ()), {}) is loud


@pytest.mark.parametrize(
    ("left", "rest", "loud"),
    [(1.5, 1.15, True), (1.5, 1.4, False), (1.2, 1.0, False)],
    ids=["noisy, and mended", "noisy, not mended", "quiet"],
)
def test_one_effect_is_doubted_where_another_takes_most_of_what_it_leaves(
    monkeypatch, left, rest, loud
):
    """With more modes than effects are sought two by two beside."""
    monkeypatch.setattr(diagnosis, "two_by_two", lambda start: False)
    quiet = as_if(declared(channels(moved(seed=1))), large_amplitude.EFFECT, 0.03, 1.0)
    data = quiet.law.takes[0]

    def leaves(misfit):
        shift = np.sqrt(misfit - 1) * NOISE * data.fit[:, None]
        chi2 = quiet.chi2 + (misfit - 1) * quiet.samples
        return replace(quiet, chi2=chi2, predicted=(quiet.predicted[0] + shift,))

    far, one, more = map(leaves, (30.0, left, rest))
    found, second = judge(("contact",), one, far), judge(("contact", "relaxation"), more, one)
    alone = Verdict("explained", ((None, far), ("contact", one)), (found,), ((),), (), ())
    assert _loud(alone, {one: [second]}) is loud
    assert not _loud(alone, {one: [replace(second, outdone=True)]})
    assert not _loud(alone, {one: [replace(second, evidence=10.0)]})
    assert not _loud(alone, {})


@pytest.mark.parametrize(
    ("effect", "told", "taken"),
    [
        (contact.ABOVE, "explained", True),
        (contact.ABOVE, "unexplained", False),
        (contact.ABOVE, None, False),
        (relaxation.EFFECT, "explained", False),  # it pushes at no place
    ],
)
def test_one_force_with_the_modes_that_it_rings_goes_before_two_effects(
    monkeypatch, effect, told, taken
):
    monkeypatch.setattr(diagnosis, "_sharpened", lambda verdict: verdict)
    found = SimpleNamespace(law=SimpleNamespace(effects=(effect,)))
    one, two = (SimpleNamespace(effects=(SimpleNamespace(found=found),) * n) for n in (1, 2))
    rings = told and SimpleNamespace(verdict=told)
    asked = []
    monkeypatch.setattr(diagnosis, "replace", lambda _, **said: said)
    said = diagnosis._with_what_it_rings(one, lambda verdict: asked.append(verdict) or rings)
    assert (said is rings and said is not None) is taken
    # "explained" without them, it would stay so whatever these leave
    assert asked == [{"verdict": "unexplained"}] * bool(effect.force)
    assert diagnosis._with_what_it_rings(two, lambda verdict: rings) is None


@pytest.mark.parametrize(("ahead", "told"), [(3.0, True), (1.4, True), (0.9, False)])
def test_two_effects_tell_more_than_one_that_is_quiet_but_far_off_ahead(ahead, told):
    declared_fit = declared(channels(moved(seed=1)))
    far = leaving(declared_fit, 1.0, 1.0)
    held = ~declared_fit.law.takes[0].fit
    shift = declared_fit.predicted[0] + ahead * NOISE * held[:, None]
    off = replace(declared_fit, chi2=0.97 * declared_fit.samples, predicted=(shift,))
    one, two = (judge((name,), off, far) for name in ("contact", "relaxation"))
    alone = Verdict("explained", ((None, far), ("contact", off)), (one,), ((),), (), ())
    chain = ((None, far), ("contact", off), ("relaxation", declared_fit))
    both = Verdict("explained", chain, (one, two), ((), ()), (), ())
    assert np.isnan(_pair(both, alone).share)  # there was nothing to take
    assert _does_more(both, alone) is told


@pytest.mark.parametrize(
    ("fitted", "ahead", "told"),
    [(1.0, 1.0, True), (2.0, 1.0, False), (1.0, 2.0, False)],
    ids=["nearly all", "less where it was fitted", "less ahead"],
)
def test_two_effects_that_leave_more_than_noise_tell_more_if_they_take_nearly_all(
    fitted, ahead, told
):
    """Of what one effect leaves that is far off ahead."""
    declared_fit = declared(channels(moved(seed=1)))
    data = declared_fit.law.takes[0]

    def off(fit, held):
        shift = np.where(data.fit, fit, held)[:, None] * NOISE
        predicted = declared_fit.predicted[0] + shift
        chi2 = float((((data.values - predicted) / data.sigma)[data.fit] ** 2).sum())
        return replace(declared_fit, chi2=chi2, predicted=(predicted,))

    far, lone, pair = off(20.0, 20.0), off(3.0, 3.0), off(fitted, ahead)
    one, two = (judge((name,), lone, far) for name in ("contact", "relaxation"))
    alone = Verdict("explained", ((None, far), ("contact", lone)), (one,), ((),), (), ())
    chain = ((None, far), ("contact", lone), ("relaxation", pair))
    both = Verdict("explained", chain, (one, two), ((), ()), (), ())
    assert pair.chi2 > NOISY * pair.samples
    assert _does_more(both, alone) is told


def test_what_is_off_ahead_of_a_quiet_fit_is_sought():
    before = declared(channels(moved(Stop(0.5, 0.8))))
    found = raced(before, contact.ABOVE)
    held = ~found.law.takes[0].fit
    off = replace(
        found,
        chi2=0.97 * found.samples,
        predicted=(found.predicted[0] + 2 * NOISE * held[:, None],),
    )
    told, _ = add_second(((None, before),), [judge(("contact",), off, before)], (), 0.1)
    assert told.verdict == "explained"
    assert told.effects[0].names == ("contact",)


def ended_at(frequency, damping_ratio):
    """A fit whose modes ended there."""
    law = SimpleNamespace(setting=setting())
    found = SimpleNamespace(frequency=frequency, damping_ratio=damping_ratio, law=law)
    found.pitches = lambda take: found.frequency
    found.damping_ratios = lambda take: found.damping_ratio
    return found


def test_a_mode_that_stays_while_the_first_one_dies_has_strayed():
    heard = np.array([5.0, 9.0, 14.0])
    found = ended_at(heard, np.array([0.02, 1e-5, 0.02]))
    assert astray(found, heard, np.full(3, 0.02)).tolist() == [False, True, False]


def test_a_weak_mode_that_runs_into_a_loud_one_is_a_share_of_it():
    heard, z = np.array([5.0, 35.8, 35.1]), np.full(3, 0.03)
    found = ended_at(np.array([5.0, 35.82, 35.78]), z)
    assert astray(found, heard, z, loud=2).tolist() == [False, False, True]
    assert not astray(found, heard, z).any()  # both were heard: a split pair draws together
    assert not astray(found, found.frequency, z, loud=2).any()  # it was heard so near
    # of two weak ones that meet the later one goes; of a loud and a weak one the one that moved
    assert astray(found, heard, z, loud=1).tolist() == [False, False, True]
    found.frequency, heard = np.array([5.0, 38.02, 38.0]), np.array([5.0, 35.1, 38.0])
    assert astray(found, heard, z, loud=2).tolist() == [False, True, False]


def test_a_mode_that_takes_the_place_of_the_first_one_is_none():
    """Where that has left it; but not one that is where it was heard, or while the first is."""
    heard, z = np.array([5.0, 5.3, 14.0]), np.full(3, 0.02)
    gone = ended_at(np.array([6.1, 5.08, 14.0]), z)
    assert astray(gone, heard, z).tolist() == [False, True, False]
    gone.frequency = np.array([6.1, 5.25, 14.0])
    assert astray(gone, heard, z).tolist() == [False, False, False]
    gone.frequency = np.array([5.6, 5.08, 14.0])
    assert astray(gone, heard, z).tolist() == [False, False, False]


def test_modes_are_looked_at_in_the_first_fitted_take_of_each_set_of_pitches():
    law = SimpleNamespace(fitted=[0, 2, 3], pitch=(1, 0, 0, 1))
    assert sorted(_otherwise_pitched(law)) == [0, 1]


def test_a_mode_strays_in_the_take_where_it_does():
    heard, z = np.array([5.0, 9.0]), np.full(2, 0.02)
    found = ended_at(heard, z)
    found.pitches = lambda take: np.array([5.0, 9.0 - 2.5 * take])
    assert astray(found, heard, z).tolist() == [False, False]
    assert astray(found, heard, z, take=1).tolist() == [False, True]
    found.pitches = lambda take: heard
    found.damping_ratios = lambda take: np.array([0.02, 0.02 + 0.4 * take])
    assert astray(found, heard, z, take=1).tolist() == [False, True]


def test_a_weak_mode_that_runs_into_what_was_left_aside_was_none():
    heard, z = np.array([2.77, 20.59, 24.69]), np.full(3, 0.01)
    found = ended_at(np.array([2.77, 22.32, 24.69]), z)
    assert astray(found, heard, z, 1, [22.34]).tolist() == [False, True, False]
    assert not astray(found, heard, z, 1, [20.0]).any()  # it lies the other way
    assert not astray(found, heard, z, 1, [24.0]).any()  # nor did it run into this one
    assert not astray(found, heard, z, 3, [22.34]).any()  # each of them was heard by itself


def test_a_marker_on_the_support_shows_its_own_shaking_too():
    path = 0.3 * AMPLITUDE * np.sin(2 * np.pi * 1.3 * TIME)
    noise = NOISE * np.random.default_rng(3).standard_normal((len(TIME), 4))
    data = replace(channels(path[:, None] + noise), support=np.array([True, False, False, False]))
    shared = base_motion.common_motion(data, data.values)
    assert np.sqrt(np.mean((shared - path[:, None]) ** 2)) < 0.6 * NOISE


def held_out(values):
    """A take that is only predicted: of its start two swings are known."""
    data = channels(values)
    kind = make_dataclass("Held", ["recording", "held_out", "name"])
    take = kind(data.take.recording, True, "held out")
    return replace(data, take=take, fit=TIME <= 0.4)


def test_a_support_that_shakes_is_known_in_a_held_out_take_and_the_body_answers_there():
    """The last channel is on the support; two takes are shaken, each in its own way."""

    def shaken(seed, pitch):
        omega, size = 2 * np.pi * pitch, 0.3 * AMPLITUDE
        inertia = SimpleNamespace(
            pull=lambda x, v, t, h: size * omega**2 * math.sin(omega * t + seed)
        )
        support = size * np.sin(omega * TIME + seed)
        values = moved(inertia, seed=seed) + support[:, None]
        values[:, 3] = support + NOISE * np.random.default_rng(seed + 9).standard_normal(len(TIME))
        return values

    on = np.array([False, False, False, True])
    first = replace(channels(shaken(1, 3.1)), support=on, fit=np.ones(len(TIME), bool))
    other = replace(held_out(shaken(2, 2.3)), support=on)
    amplitude = (AMPLITUDE * SHAPE)[None].astype(complex)
    ring = RingDown(
        np.array([5.0]), np.array([0.02]), amplitude, np.zeros(4), np.full(4, NOISE), np.eye(2)
    )
    law, p = build_law([ring], (first, other), (0, 0))
    start = fit(law, p, evaluations=40)
    (answering,) = [e for e in read_off(start) if e.name == "base_motion" and e.columns]
    found = raced(start, answering)
    left = (other.values - found.predicted[1])[:, :3][~other.fit]
    before = (other.values - start.predicted[1])[:, :3][~other.fit]
    assert np.sqrt(np.mean(before**2)) > 20 * NOISE
    assert np.sqrt(np.mean(left**2)) < 2 * NOISE


def test_a_shared_motion_that_was_read_first_is_read_anew_beside_a_force():
    """As first read it holds a share of what a rub does."""
    shake = 3 * NOISE * np.sin(2 * np.pi * 1.7 * TIME)
    start = declared(channels(moved(Rub(0.05, 0.05)) + shake[:, None]))
    first = next(effect for effect in read_off(start) if effect.name == "base_motion")
    both = raced(raced(start, first), dry_friction.EFFECT)
    anew = read_anew(both, 2)
    assert [e.name for e in anew.law.effects] == ["base_motion", "dry_friction"]
    assert anew.chi2 - anew.samples < 0.3 * (both.chi2 - both.samples)
    alone = raced(start, first)
    assert read_anew(alone, 1) is alone


def test_a_rub_feels_a_support_that_is_read_off_anew():
    """The last channel is on the support, which shakes."""
    omega, size = 2 * np.pi * 3.1, 0.3 * AMPLITUDE
    rub = Rub(0.05, 0.05)

    def pull(x, v, t, h):
        return rub.pull(x, v, t, h) + size * omega**2 * math.sin(omega * t)

    support = size * np.sin(omega * TIME)
    values = moved(SimpleNamespace(pull=pull)) + support[:, None]
    values[:, 3] = support + NOISE * np.random.default_rng(9).standard_normal(len(TIME))
    shown = replace(channels(values), support=np.array([False, False, False, True]))
    start = declared(shown)
    (answering,) = [e for e in read_off(start) if e.name == "base_motion" and e.columns]
    both = carrying(raced(raced(start, answering), dry_friction.EFFECT))
    anew = read_anew(both, 2)
    assert both.law.setting.carried and anew.law.setting.carried
    assert not anew.chi2 > both.chi2
    (effect,) = [e for e in shared_motions(start) if e.columns]
    assert _in_place(both, 0, effect).law.setting.carried


@pytest.mark.parametrize(("off", "is_enough"), [(4.0, True), (6.0, False)])
def test_what_is_held_out_and_five_times_the_noise_away_is_not_explained(off, is_enough):
    before = declared(channels(moved(Stop(0.5, 0.8))))
    found = raced(before, contact.ABOVE)
    held = ~found.law.takes[0].fit
    astray = found.predicted[0] + off * NOISE * held[:, None]
    told = judge(("contact",), replace(found, predicted=(astray,)), before)
    nearly_all = replace(told, held_share=0.98)
    assert sufficient(nearly_all, ENOUGH) is is_enough
    assert sufficient(nearly_all, ENOUGH, nearly=True)


def test_a_frame_lost_late_is_the_explanation_however_many_markers_the_support_has():
    """What they stand still by is in the fit's misfit and in nothing that is to be explained."""
    values = np.delete(moved(shape=SHAPE * [1, 1, 0, 0]), len(TIME) * 5 // 6, axis=0)
    still = np.array([False, False, True, True])
    data = replace(channels(values, time=TIME[:-1]), support=still)
    start = declared(data)
    (lost,) = jumps(start)
    law, p = extend(start, (lost,), [()])
    told = judge(("lost_frames",), fit(law, p), start)
    assert np.isnan(told.share) and told.held_share > 0.9
    assert sufficient(told, ENOUGH)


def test_what_creeps_after_a_release_from_the_other_side_creeps_the_other_way():
    creep = 0.3 * AMPLITUDE * np.outer(np.exp(-TIME / 0.8), SHAPE)
    other = channels(-0.7 * (moved(seed=3) + creep))
    held = make_dataclass("Held", ["recording", "held_out"])(other.take.recording, True)
    whole = replace(other, take=held, fit=TIME <= 0.4)  # two swings tell its start
    first = replace(channels(moved() + creep), fit=np.ones(len(TIME), bool))
    amplitude = (AMPLITUDE * SHAPE)[None].astype(complex)
    ring = RingDown(
        np.array([5.0]), np.array([0.02]), amplitude, np.zeros(4), np.full(4, NOISE), np.eye(2)
    )
    law, p = build_law([ring], (first, whole), (0, 0))
    found = raced(fit(law, p, evaluations=40), relaxation.EFFECT)
    left = (whole.values - found.predicted[1])[~whole.fit]
    assert np.sqrt(np.mean(left**2)) < 1.2 * NOISE


def test_alone_every_effect_is_sought_that_promises_enough(monkeypatch):
    """A score test is linear: where a pitch has slipped many swings the right one may be last."""
    names = [f"effect {n}" for n in range(14)]
    tries = [
        SimpleNamespace(effect=SimpleNamespace(name=n, clock=False), promise=np.array([1e3]))
        for n in names
    ]
    monkeypatch.setattr(time_layer, "entries", lambda start, effects: tries)
    start = declared(channels(moved()))
    assert [one.effect.name for one in time_layer._chosen(start)] == names
    assert len(time_layer._chosen(start, time_layer.BESIDE)) == time_layer.BESIDE


@pytest.mark.parametrize("slides", [True, False])
def test_what_one_marker_does_alone_is_no_return_of_the_body(slides):
    """A body returns in the shape that it was held in, a marker by itself where it slides."""
    shape = np.eye(4)[2] if slides else SHAPE
    back = 0.1 * AMPLITUDE * np.outer(np.exp(-TIME / 1.5), shape)
    found = raced(declared(channels(moved() + back)), relaxation.EFFECT)
    assert found.chi2 < 1.2 * found.samples
    assert bool(vetoed(found)) == slides


def test_the_loudest_mode_is_the_one_that_lasts():
    law, p = two_modes(1.25)
    found = fit(law, p, evaluations=40)
    once = np.array([8.0, 1.0])[None] * np.array([[1.0, 1.0], *[[0.0, 1.0]] * 99])
    burst = replace(found, motions=(AMPLITUDE * once,))
    assert np.argmax(burst.swings) == 0 and burst.loudest == 1


@pytest.mark.parametrize(
    ("computed", "modes", "apart"),
    [
        ((5.0, 5.1), (0, 1), 0.0198),
        ((5.0, 5.1), (1, 0), -0.0198),
        ((5.0, 5.001), (0, 1), 0.0),  # one pitch
        ((5.0, 6.0), (0, 1), 0.0),  # further than a mode may stray
        ((5.0, 5.1), (0, None), 0.0),
    ],
)
def test_two_poles_at_one_pitch_are_opened_as_far_as_the_body_parts_them(computed, modes, apart):
    found = SimpleNamespace(
        frequency=np.array([5.0, 5.001]),
        damping_ratio=np.array([0.04, 0.045]),
        law=SimpleNamespace(fitted=(0,), takes=(SimpleNamespace(sigma=np.ones(3)),)),
    )
    rings = list(_opened(found, Match((0, 1), modes), np.array(computed)))
    assert len(rings) == (apart != 0)
    for ring in rings:
        assert np.log(ring.frequency[1] / ring.frequency[0]) == pytest.approx(apart, abs=1e-3)
        assert np.sqrt(ring.frequency.prod()) == pytest.approx(5.0005, rel=1e-6)


@pytest.mark.parametrize(
    ("phase", "stood", "struck"),
    [
        (np.pi / 2, np.nan, True),
        (np.pi / 2, 0.0, True),
        (np.pi / 2, 1.0, False),  # seen to be held off before
        (0.0, np.nan, False),
        (np.pi / 2 - 0.15, np.nan, False),  # it may begin in the midst of a swing
        (np.pi / 2 - 0.15, 0.0, True),
        (np.pi / 2 - 0.7, 0.0, True),  # pushed for a while
        (0.5, 0.0, False),  # pulled, and let go
    ],
)
def test_a_body_that_is_straight_and_fast_when_it_starts_was_struck(phase, stood, struck):
    fall = np.exp(-0.02 * W * TIME)
    wave = AMPLITUDE * fall * np.cos(np.sqrt(1 - 0.02**2) * W * TIME - phase)
    data = channels(np.outer(wave, SHAPE))
    found = declared(replace(data, quiet=stood * AMPLITUDE * SHAPE))
    blow = as_fitted(found).blow
    assert (blow is not None) is struck
    if struck and phase == np.pi / 2:
        assert blow == pytest.approx(AMPLITUDE / W * SHAPE, rel=0.03)
