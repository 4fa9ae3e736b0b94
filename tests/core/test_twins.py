"""Young's modulus where a recording does not tell what was found from a twin."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import twins


def _fit(pitches, *names):
    effects = [SimpleNamespace(name=name) for name in names]
    law = SimpleNamespace(effects=effects, setting=SimpleNamespace(pair=0))
    own = [np.zeros((1, 1)) for _ in names]
    return SimpleNamespace(frequency=np.array(pitches), law=law, column_shapes=lambda: own)


def _span(final, *others, k=0, effects=1):
    ranked = [SimpleNamespace(names=(o.law.effects[0].name,), found=o) for o in others]
    names = tuple(o.law.effects[0].name for o in others)
    found = (None,) * effects
    verdict = SimpleNamespace(final=final, twins=(names,), ranked=ranked, effects=found)
    return twins.twins_span(verdict, k, lambda one: one.frequency)


@pytest.fixture
def ratio(monkeypatch):
    told = {"ratio": {"value": 2.0, "ci95": [1.5, 3.0]}}
    monkeypatch.setattr(twins, "parameters", lambda found, index: told)


def test_a_modulus_without_twins_is_what_its_pitch_says():
    assert _span(_fit([5.0, 9.0], "contact")) == (1.0, 1.0)


def test_a_modulus_may_be_what_a_twin_makes_of_it():
    final, twin = _fit([5.0, 9.0], "contact"), _fit([4.5, 9.9], "large_amplitude")
    assert _span(final, twin) == pytest.approx((0.81, 1.0))
    assert _span(final, twin, k=1) == pytest.approx((1.0, 1.21))


def test_a_twin_that_was_fitted_alone_says_nothing_beside_another_effect():
    final, twin = _fit([5.0], "contact", "dry_friction"), _fit([4.5], "large_amplitude")
    assert _span(final, twin, effects=2) == (1.0, 1.0)


def test_a_body_stiffer_one_way_is_as_stiff_as_either_side(ratio):
    """k (1 - b) and k (1 + b) with (1 + b) / (1 - b) = 3 at most."""
    uneven = _fit([5.0], "asymmetric_stiffness")
    assert _span(uneven) == pytest.approx((0.5, 1.5))
    assert _span(_fit([5.0], "contact"), uneven) == pytest.approx((0.5, 1.5))


def test_a_spring_that_bends_the_first_mode_bends_a_higher_one_by_less(ratio):
    """An octave up a spring moves a mode's squared pitch by a quarter of what it does below."""
    uneven = _fit([5.0, 10.0], "asymmetric_stiffness")
    sides = 3.0**0.25
    assert _span(uneven, k=1) == pytest.approx((2 / (1 + sides), 2 * sides / (1 + sides)))


def test_a_mode_that_left_its_place_in_a_twin_says_nothing_of_the_modulus():
    final, twin = _fit([5.0, 9.0], "contact"), _fit([4.5, 17.0], "dry_friction")
    assert _span(final, twin, k=1) == (1.0, 1.0)


def test_a_twin_that_creeps_makes_the_body_softer_at_rest(monkeypatch):
    """Static over dynamic stiffness: 0.8 by the twin, 0.5 at least."""
    final, twin = _fit([5.0], "asymmetric_stiffness"), _fit([5.0], "relaxation")
    monkeypatch.setattr(twins, "parameters", lambda found, index: {"ratio": {"ci95": [1.0, 1.0]}})
    soft = {id(twin): (0.8, 0.5)}
    monkeypatch.setattr(twins, "softer", lambda one: soft.get(id(one), (1.0, 1.0)))
    assert _span(final, twin) == pytest.approx((0.5, 1.0))
