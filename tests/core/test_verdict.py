"""Physics tests of what the report calls the probability of a found effect."""

from types import SimpleNamespace

import numpy as np
import pytest

from core.verdict import Verdict, probability

CYCLES = 10.0


def fit(chi2):
    """A fit that leaves so much, of a record of so many cycles."""
    setting = SimpleNamespace(omega=np.array([2 * np.pi * 5.0]), duration=CYCLES / 5.0)
    return SimpleNamespace(chi2=chi2, law=SimpleNamespace(setting=setting))


def candidate(name, chi2):
    return SimpleNamespace(names=(name,), found=fit(chi2))


def verdict(rows, ranked=()):
    chain = ((None, fit(1000.0)), *((name, fit(chi2)) for name, chi2 in rows))
    ranked = tuple(candidate(*one) for one in ranked)
    return Verdict("explained", chain, (), (), ranked, ())


def test_an_effect_is_weighed_against_all_that_was_fitted_without_it():
    found = verdict([("relaxation", 100.0)], [("relaxation", 100.0), ("contact", 110.0)])
    others = 1.1 ** (-CYCLES / 2) + 10.0 ** (-CYCLES / 2)
    assert probability(found, "relaxation") == pytest.approx(1 / (1 + others))


def test_a_second_effect_that_does_little_alone_is_as_sure_as_it_tells_beside_the_first():
    alone = [("relaxation", 300.0), ("air_drag", 900.0)]
    found = verdict([("relaxation", 300.0), ("air_drag", 100.0)], alone)
    without = 3.0 ** (-CYCLES / 2) + 10.0 ** (-CYCLES / 2) + 3.0 ** (-CYCLES / 2)
    assert probability(found, "air_drag") == pytest.approx(1 / (1 + without))
    assert probability(found, "relaxation") > 0.99


def test_a_law_of_damping_is_weighed_against_the_fit_before_it():
    """What was raced after it has it too."""
    found = verdict(
        [("viscous_damping", 400.0), ("relaxation", 100.0)], [("relaxation", 100.0), ("contact", 1)]
    )
    assert probability(found, "viscous_damping") == pytest.approx(1 / (1 + 0.4 ** (CYCLES / 2)))
    assert probability(found, "relaxation") < 0.01
    idle = verdict([("viscous_damping", 999.0), ("relaxation", 100.0)])
    assert probability(idle, "viscous_damping") == pytest.approx(0.5, abs=0.01)
