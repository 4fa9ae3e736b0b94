"""Young's modulus where a recording does not tell what was found from a twin."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import twins


def _fit(pitch, *names):
    effects = [SimpleNamespace(name=name) for name in names]
    law = SimpleNamespace(effects=effects, modes=1)
    own = [np.zeros((1, 1)) for _ in names]
    return SimpleNamespace(frequency=np.array([pitch]), law=law, column_shapes=lambda: own)


def _verdict(final, *others):
    ranked = [SimpleNamespace(names=(o.law.effects[0].name,), found=o) for o in others]
    names = tuple(o.law.effects[0].name for o in others)
    return SimpleNamespace(final=final, twins=(names,), ranked=ranked)


@pytest.fixture
def ratio(monkeypatch):
    told = {"ratio": {"value": 2.0, "ci95": [1.5, 3.0]}}
    monkeypatch.setattr(twins, "parameters", lambda found, index: told)


def test_a_modulus_without_twins_is_what_its_pitch_says():
    assert twins.modulus_span(_verdict(_fit(5.0, "contact")), 0) == (1.0, 1.0)


def test_a_modulus_may_be_what_a_twin_makes_of_it():
    verdict = _verdict(_fit(5.0, "contact"), _fit(4.5, "large_amplitude"))
    assert twins.modulus_span(verdict, 0) == pytest.approx((0.81, 1.0))


def test_a_body_stiffer_one_way_is_as_stiff_as_either_side(ratio):
    """k (1 - b) and k (1 + b) with (1 + b) / (1 - b) = 3 at most."""
    uneven = _fit(5.0, "asymmetric_stiffness")
    assert twins.modulus_span(_verdict(uneven), 0) == pytest.approx((0.5, 1.5))
    verdict = _verdict(_fit(5.0, "contact"), uneven)
    assert twins.modulus_span(verdict, 0) == pytest.approx((0.5, 1.5))


def test_only_the_first_mode_swings_on_two_sides(ratio):
    assert twins.modulus_span(_verdict(_fit(5.0, "asymmetric_stiffness")), 1) == (1.0, 1.0)
