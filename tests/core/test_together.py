"""Two effects of which neither shows alone, integrated here by another rule."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import exchange, time_layer, together
from core.effects import asymmetric_stiffness, dry_friction, relaxation, steady_drive
from core.exchange import exchanged
from core.time_layer import Candidate, judge, stands_in
from core.timefit import extend, fit, sharp
from core.together import _with_jumps, pairs
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import SHAPE, TIME, Rub, channels, declared, moved, raced

SLOW = 0.8  # s


def creeping_and_rubbed(share=0.4):
    """The rub stops the swing early, and the slow return is most of what is left then."""
    creep = share * AMPLITUDE * np.exp(-TIME / SLOW)
    return declared(channels(moved(Rub(0.08, 0.02)) + np.outer(creep, SHAPE)))


def test_two_effects_are_found_where_neither_is_alone():
    found = creeping_and_rubbed()
    for effect in (dry_friction.EFFECT, relaxation.EFFECT):
        alone = raced(found, effect)
        assert alone.chi2 > 3 * alone.samples
    best = pairs(found, [], {})[0]
    assert set(best.names) == {"dry_friction", "relaxation"}
    fine = sharp(best.found)
    assert fine.chi2 < 1.2 * fine.samples
    theta = dict(zip(best.names, fine.theta, strict=True))
    assert abs(np.exp(theta["relaxation"][0][0]) / SLOW - 1) < 0.1
    assert abs(theta["dry_friction"][0][0] / 0.08 - 1) < 0.1


def test_where_nothing_acts_no_two_effects_are_begun():
    assert pairs(declared(channels(moved())), [], {}) == []


def test_what_was_sought_beside_an_effect_is_not_sought_again(monkeypatch):
    found = creeping_and_rubbed()
    creep = judge(("relaxation",), raced(found, relaxation.EFFECT), found)
    names = ("relaxation", "dry_friction")
    rub = judge(names, raced(creep.found, dry_friction.EFFECT), creep.found)
    asked = []
    monkeypatch.setattr(together, "seconds", lambda firsts, *_: asked.append(firsts) or [])
    monkeypatch.setattr(together, "_of_the_library", lambda start: [])
    (both,) = together.pairs(found, [creep], {creep.found: [rub]})
    assert asked == [[]] and both.found is rub.found
    assert both.evidence > rub.evidence  # over the fit without either


def both_of(found, *effects):
    """The candidate of two effects, one raced beside the other."""
    first, second = effects
    return judge((first.name, second.name), raced(raced(found, first), second), found)


def test_a_twin_takes_the_place_of_what_a_search_began_with():
    found = creeping_and_rubbed(0.15)
    wrong = both_of(found, asymmetric_stiffness.EFFECT, dry_friction.EFFECT)
    best = exchanged([wrong], found)[0]
    assert set(best.names) == {"dry_friction", "relaxation"}
    fine = sharp(best.found)
    assert fine.chi2 < 1.2 * fine.samples


@pytest.mark.parametrize(("better", "rounds"), [(True, 2), (False, 1)])
def test_what_took_the_place_of_the_best_is_given_up_for_a_twin_of_its_own(
    monkeypatch, better, rounds
):
    found = creeping_and_rubbed(0.15)
    wrong = both_of(found, asymmetric_stiffness.EFFECT, dry_friction.EFFECT)
    right = both_of(found, relaxation.EFFECT, dry_friction.EFFECT)
    asked = []

    def instead(best, at, effect):
        asked.append(best)
        return right.found if better and effect.name == "relaxation" else None

    monkeypatch.setattr(exchange, "_instead", instead)
    best = exchanged([wrong], found)[0]
    assert best.found is (right if better else wrong).found
    assert len({id(one) for one in asked}) == rounds


def test_a_line_at_the_pitch_stands_in_for_a_rub_that_tells_as_much():
    found = creeping_and_rubbed()
    rub = both_of(found, relaxation.EFFECT, dry_friction.EFFECT)
    law, start = extend(
        raced(found, relaxation.EFFECT), (steady_drive.EFFECT,), [(np.log(found.frequency[0]),)]
    )
    line = judge(("relaxation", "steady_drive"), fit(law, start), found)
    assert steady_drive.is_resonant(line.found)
    assert stands_in(line, [line, rub]) and not stands_in(line, [line])
    assert not stands_in(rub, [line, rub])


def test_lost_frames_are_read_beside_every_effect_that_is_no_clock_itself():
    whole = np.outer(np.exp(-TIME / SLOW), SHAPE) * 0.4 * AMPLITUDE + moved()
    values = np.vstack([whole[:200], whole[202:]])
    start = declared(channels(values, time=TIME[: len(values)]))
    single = judge(("relaxation",), raced(start, relaxation.EFFECT), start)
    ((beside, (both,)),) = _with_jumps(start, [single])
    assert beside is single and both.names == ("relaxation", "lost_frames")
    assert both.found.chi2 < 1.2 * both.found.samples < single.found.chi2
    again = judge(("relaxation", "lost_frames"), both.found, start)
    assert _with_jumps(start, [again]) == []


@pytest.mark.parametrize(
    ("over", "share", "stands"), [(1.2, 0.995, True), (1.2, 0.9, False), (1.5, 0.995, False)]
)
def test_a_line_at_the_pitch_stands_in_for_a_rub_that_leaves_hardly_more_than_noise(
    monkeypatch, over, share, stands
):
    """However many samples make of a tenth of the noise a clear gain."""
    fits = {
        name: SimpleNamespace(chi2=per * 1e5, samples=1e5, unknowns=10)
        for name, per in (("steady_drive", 1.1), ("dry_friction", over))
    }
    monkeypatch.setattr(time_layer.steady_drive, "is_resonant", lambda found: True)
    line = Candidate(("relaxation", "steady_drive"), fits["steady_drive"], 1e6, 0.99, 0.99)
    rub = Candidate(("relaxation", "dry_friction"), fits["dry_friction"], share * 1e6, 0.98, 0.98)
    assert stands_in(line, [line, rub]) == stands
