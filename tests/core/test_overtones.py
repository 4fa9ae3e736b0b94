"""A mode of the body that lies at twice another one's pitch and is seen to move as that does."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import overtones
from core.effects import contact
from core.effects.further_mode import pitch_of
from core.further import _poles, with_overtones_of
from core.law import replace
from core.overtones import with_overtones
from core.pipeline import calibrate_case
from core.time_layer import Candidate
from core.timefit import fit
from core.verdict import Verdict
from tests.core.test_further import FIRST, ringing
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import SHAPE, Backbone, channels, declared, moved
from tests.truth import make

MATCH = SimpleNamespace(modes=(0,))
SHAKES = replace(contact.ABOVE, name="base_motion", free=12)


def heard(*ratios, swing=None):
    """What was heard of a body with modes at so many times its first pitch, all seen alike; the
    second swings a tenth as far as the first and lies at twice its pitch.
    """
    swing = moved() if swing is None else swing
    found = declared(channels(swing + 0.1 * AMPLITUDE * np.outer(ringing(2.0), SHAPE)))
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


def asking(monkeypatch, answer):
    """A diagnosis that gives the answer, and the takes that it was asked of."""
    monkeypatch.setattr(overtones, "replace", lambda one, **new: changed(one, new))
    asked = []
    return asked, lambda wider: asked.append(wider) or answer(wider.declared)


def changed(one, new):
    if isinstance(one, SimpleNamespace):
        return SimpleNamespace(**vars(one) | new)
    return replace(one, **new)


def worse(found, chi2=1.0, ahead=0.0):
    """The fit with so many times its chi2, and so much (m) off in what was held out."""
    (said,), held = found.predicted, ~found.law.takes[0].fit[:, None]
    return replace(found, chi2=chi2 * found.chi2, predicted=(said + ahead * held,))


@pytest.mark.parametrize(
    ("before", "said", "off", "better"),
    [
        ("unexplained", "adequate", {}, True),
        ("unexplained", "explained", {}, True),
        ("unexplained", "unexplained", {}, False),
        ("unexplained", "adequate", {"ahead": AMPLITUDE}, False),  # what comes is foretold worse
        ("unexplained", "explained", {"chi2": 1.5}, True),
        ("unexplained", "explained", {"chi2": 9.0}, False),  # less likely than without
        ("explained", "adequate", {}, True),
        ("explained", "explained", {"chi2": 1.5}, False),  # it left more than noise, too
    ],
)
def test_it_counts_where_all_is_told_with_it_and_no_less_foretold(
    monkeypatch, before, said, off, better
):
    one = heard(1.0, 1.98)
    asked, diagnose = asking(monkeypatch, lambda found: told(worse(found, **off), said))
    then = told(one.declared, before)
    got = with_overtones(one, then, diagnose)
    assert (got[1] is not then) is better and (got[0] is not one) is better
    (wider,) = asked
    assert wider.free is wider.declared and len(wider.declared.law.effects) == 1


@pytest.mark.parametrize(
    ("before", "after", "better"),
    [
        ((SHAKES,), (), True),  # it is read off the record
        ((contact.ABOVE,), (), False),  # a stop rings at an overtone, too
        ((contact.ABOVE,), (contact.ABOVE,), True),
        ((contact.ABOVE, SHAKES), (contact.ABOVE,), True),
        ((contact.ABOVE, SHAKES), (), False),
    ],
)
def test_what_explains_gives_way_to_a_mode_only_if_it_is_read_off_the_record(
    monkeypatch, before, after, better
):
    def naming(found, effects):
        all_of = replace(found, law=replace(found.law, effects=effects))
        named = tuple(Candidate((e.name,), all_of, 1.0, 1, 1) for e in effects)
        return replace(told(all_of, "explained"), effects=named)

    one = heard(1.0, 1.98)
    then = naming(one.declared, before)
    _, diagnose = asking(monkeypatch, lambda found: naming(found, after))
    assert (with_overtones(one, then, diagnose)[1] is not then) is better


def test_it_is_the_same_mode_in_both_fits_where_the_declared_damping_is_another_law(monkeypatch):
    one = heard(1.0, 1.98)
    law = replace(one.free.law, damping="common")
    one.declared = fit(law, one.free.parameters, evaluations=20)
    asked, diagnose = asking(monkeypatch, lambda found: told(found, "adequate"))
    with_overtones(one, told(one.declared), diagnose)
    (wider,) = asked
    assert wider.declared.law.damping == "common" != wider.free.law.damping
    assert len(wider.free.law.effects) == 1
    assert wider.declared.law.effects == wider.free.law.effects


def test_nothing_is_asked_where_all_is_told_or_no_mode_was_matched():
    def diagnose(wider):
        raise AssertionError

    quiet = declared(channels(moved()))
    before = told(quiet, "explained")
    one = heard(1.0, 1.98)
    assert with_overtones(one, before, diagnose) == (one, before)
    assert with_overtones(one, told(one.declared, "refused"), diagnose)[0] is one
    one.match = SimpleNamespace(modes=(0, None))
    assert with_overtones(one, told(one.declared), diagnose)[0] is one
    other = heard(1.0, 2.4)  # the body has none there
    assert with_overtones(other, told(other.declared), diagnose)[0] is other
    bent = heard(1.0, 1.98, swing=moved(Backbone(0.3, 0.0)))  # nor is it most of what was off
    assert with_overtones(bent, told(bent.declared), diagnose)[0] is bent


@pytest.mark.slow
def test_a_strip_that_swings_across_at_twice_its_pitch_has_no_shaking_support(tmp_path):
    """It is twice as wide as thick, and a camera between the two ways sees both in one shape."""
    truth = make("compliant_pin", 161806, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["compliant_pin"]
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.03)
