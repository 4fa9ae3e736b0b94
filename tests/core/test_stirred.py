"""Modes that nobody heard and that a found force rings."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core.effects import air_drag, dry_friction
from core.law import numbers
from core.pipeline import calibrate_case
from core.stirred import _begins, _of_heard, with_stirred
from core.timefit import extend, fit
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import Rub, W, channels, declared, moved
from tests.truth import make

RUB = (0.03, np.log(0.02))


@pytest.fixture(scope="module")
def heard_only():
    start = declared(channels(moved(Rub(0.03, 0.02))))
    return fit(*extend(start, (dry_friction.EFFECT,), [RUB]), evaluations=20)


@pytest.fixture(scope="module")
def wider(heard_only):
    """A fit of two modes, the second of which was not heard."""
    old = heard_only.law
    setting = replace(
        old.setting,
        omega=W * np.array([1.0, 1.7]),
        zeta=np.full(2, 0.02),
        couple=np.ones(2),
        places=np.array([[0.0], [3.0]]),
        levers=np.ones(2),
        masses=np.ones(2),
    )
    across = np.array([0.2, -0.5, 0.4, 1.0])
    law = replace(old, reference=np.vstack([old.reference, across / 2]), setting=setting)
    law = replace(law, gauges=(law.reference,))
    outer = np.r_[np.log(setting.omega / 2 / np.pi), 0.02, 0.03, AMPLITUDE, 1e-5, 0.0, 0.0]
    return fit(law, np.r_[outer, RUB, 0.5], evaluations=3)


def test_what_is_said_of_the_heard_modes_foretells_what_all_of_them_do(heard_only, wider):
    told = _of_heard(wider, heard_only)
    assert len(told.parameters) == sum(told.law.sizes())
    assert told.coefficients.shape == heard_only.coefficients.shape
    assert told.frequency == pytest.approx(wider.frequency[:1])
    assert told.damping_ratio == pytest.approx(wider.damping_ratio[:1])
    assert (told.theta[0][0] == wider.theta[0][0, :2]).all()
    assert (told.shapes == wider.shapes[:1]).all()
    assert (told.rest() == wider.rest()).all()
    assert (told.column_shapes()[0] == wider.column_shapes()[0]).all()
    assert told.covariance[1, 1] == wider.covariance[2, 2]  # of the first one's damping ratio
    assert told.covariance[-1, -1] == wider.covariance[-2, -2]  # of the rub's travel
    assert told.predicted is wider.predicted and told.chi2 == wider.chi2


@pytest.mark.parametrize("effect", [dry_friction.EFFECT, dry_friction.IN_PLANE, air_drag.EFFECT])
def test_every_begin_has_the_numbers_of_the_wider_law(effect):
    rng = np.random.default_rng(1)
    heard, modes = 2, 4
    law = SimpleNamespace(setting=SimpleNamespace(places=rng.standard_normal((30, modes - 1))))
    theta = rng.standard_normal(numbers(effect, heard))
    begins = list(_begins(effect, theta, heard, law))
    assert {len(one) for one in begins} == {numbers(effect, modes)}
    own = len(effect.low)
    assert (begins[0][:own] == theta[:own]).all()
    if effect.force:  # first as the place does that shares most nearly as much in the heard modes
        nearest = np.argmin(np.abs(law.setting.places[:, 0] - theta[own]))
        assert (begins[0][own : own + 3] == [theta[own], *law.setting.places[nearest, 1:]]).all()
    if effect.axes > 1:
        assert (begins[0][own + 3 :] == [theta[own + 1], 0, 0]).all()


def test_none_is_looked_for_without_a_found_force_or_beside_noise(heard_only):
    def verdict(names, chi2):
        final = replace(heard_only, chi2=chi2 * heard_only.samples)
        return SimpleNamespace(final=final, names=names, laws=0)

    assert with_stirred(None, verdict(("dry_friction",), 1.2)) is None
    assert with_stirred(None, verdict((), 5.0)) is None
    with pytest.raises(AttributeError):  # else they are
        with_stirred(None, verdict(("dry_friction",), 5.0))


@pytest.mark.slow
def test_a_rub_explains_what_the_modes_do_that_it_rings(tmp_path):
    truth = make("dry_friction", 881002, tmp_path)  # of a strip, of which one mode is heard
    result = calibrate_case(tmp_path / "case.toml")
    report = result.report
    (effect,) = report["diagnosis"]["effects"]
    assert report["diagnosis"]["verdict"] == "explained" and effect["name"] == "dry_friction"
    assert report["error"]["after"] < 1.3 * report["error"]["floor"]
    low, high = effect["parameters"]["force"]["ci95"]
    assert low < truth["parameters"]["dry_friction"]["force"] < high
    assert len(report["modes"]) == 1  # of the others no more is known than that they swing
    assert sum(name.startswith("mode") for name in result.motion.names) > 1
