"""A mode of the body that lies at twice another one's pitch and is seen to move as that does."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import overtones
from core.effects.further_mode import pitch_of
from core.further import _poles, with_overtones_of
from core.law import replace
from core.overtones import with_overtones
from core.pipeline import calibrate_case
from core.verdict import Verdict
from tests.core.test_further import FIRST, ringing
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import SHAPE, channels, declared, moved
from tests.truth import make

MATCH = SimpleNamespace(modes=(0,))


def heard(*ratios):
    """What was heard of a body with modes at so many times its first pitch, all seen alike; the
    second swings a tenth as far as the first and lies at twice its pitch.
    """
    found = declared(channels(moved() + 0.1 * AMPLITUDE * np.outer(ringing(2.0), SHAPE)))
    modes = SimpleNamespace(frequency=FIRST * np.array(ratios))
    body = SimpleNamespace(modes=modes, seen=lambda data: np.tile(SHAPE, (len(ratios), 1)))
    return SimpleNamespace(free=found, declared=found, match=MATCH, body=body)


def told(found, verdict="unexplained"):
    return Verdict(verdict, ((None, found),), (), (), (), ())


def test_such_a_mode_is_left_for_the_effects_at_first_and_the_bodys_if_it_has_one_there():
    one = heard(1.0, 1.98)
    assert _poles(one.declared, 0, MATCH, one.body) == []
    wider = with_overtones_of(one.declared, MATCH, one.body)
    (effect,) = wider.law.effects
    assert pitch_of(effect, wider.theta[0][0]) == pytest.approx(2 * FIRST, rel=2e-3)
    assert wider.chi2 < 1.1 * wider.samples < one.declared.chi2
    other = heard(1.0, 2.4)
    assert with_overtones_of(other.declared, MATCH, other.body) is other.declared


@pytest.mark.parametrize(
    ("said", "off", "better"),
    [
        ("adequate", 0.0, True),
        ("explained", 0.0, True),
        ("unexplained", 0.0, False),
        ("adequate", AMPLITUDE, False),  # what comes is foretold worse
    ],
)
def test_it_counts_where_all_is_told_with_it_and_no_less_foretold(monkeypatch, said, off, better):
    monkeypatch.setattr(overtones, "replace", lambda one, **new: SimpleNamespace(**vars(one) | new))
    one, asked = heard(1.0, 1.98), []

    def diagnose(wider):
        asked.append(wider)
        (said_of,) = wider.declared.predicted
        ahead = ~wider.declared.law.takes[0].fit[:, None]
        fit = replace(wider.declared, predicted=(said_of + off * ahead,))
        return told(fit, said)

    before = told(one.declared)
    got = with_overtones(one, before, diagnose)
    assert (got[1] is not before) is better and (got[0] is not one) is better
    (wider,) = asked
    assert wider.free is wider.declared and len(wider.declared.law.effects) == 1


def test_nothing_is_asked_where_all_is_told_or_no_mode_was_matched():
    def diagnose(wider):
        raise AssertionError

    quiet = declared(channels(moved()))
    before = told(quiet, "explained")
    one = heard(1.0, 1.98)
    assert with_overtones(one, before, diagnose) == (one, before)
    one.match = SimpleNamespace(modes=(0, None))
    assert with_overtones(one, told(one.declared), diagnose)[0] is one
    other = heard(1.0, 2.4)  # the body has none there
    assert with_overtones(other, told(other.declared), diagnose)[0] is other


@pytest.mark.slow
def test_a_strip_that_swings_across_at_twice_its_pitch_has_no_shaking_support(tmp_path):
    """It is twice as wide as thick, and a camera between the two ways sees both in one shape."""
    truth = make("compliant_pin", 161806, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["compliant_pin"]
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.03)
