"""Forces beside a motion that goes on, against one equation of motion for all of it."""

from dataclasses import replace

import numpy as np
import pytest

from core.carried import carrying
from core.effects import dry_friction, large_amplitude, relaxation, steady_drive
from core.effects.base import Carried
from core.refit import without
from core.timefit import extend, fit, misfits, sharp
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import SHAPE, TIME, Backbone, Rub, W, channels, declared, moved

RATE = 8.3  # Hz of the line; the mode swings at 5


class Driven:
    """A line's force of `size` times the mode's own at first, and another one on all that moves."""

    def __init__(self, size, other):
        self.size, self.other = size * W**2 * AMPLITUDE, other

    def pull(self, x, v, t, h):
        return self.size * np.sin(2 * np.pi * RATE * t) + self.other.pull(x, v, t, h)


FORCES = [
    (Backbone(0.05, 0.0), 0.05, large_amplitude.EFFECT, (0.02, 0.0)),
    (Rub(0.05, 0.02), 0.05, dry_friction.EFFECT, (0.03, np.log(0.02))),
]


def beside_a_line(size, force, effect, start):
    """The fit with the effect beside the line as it is heard, and the same carrying that."""
    found = declared(channels(moved(Driven(size, force))))
    law, p = extend(found, (steady_drive.EFFECT,), [(np.log(RATE),)])
    line = fit(law, p, evaluations=40)
    return [
        sharp(fit(*extend(one, (effect,), [start]), evaluations=40))
        for one in (line, carrying(line))
    ]


@pytest.mark.parametrize(("force", "strength", "effect", "start"), FORCES)
def test_a_force_feels_what_goes_on_beside_the_ring_down(force, strength, effect, start):
    deaf, found = beside_a_line(1.0, force, effect, start)
    found = sharp(carrying(found))
    assert found.chi2 < 1.1 * found.samples < 0.98 * deaf.chi2
    assert found.theta[-1][0][0] == pytest.approx(strength, rel=0.1)
    assert found.damping_ratio[0] == pytest.approx(0.02, abs=0.002)
    assert found.frequency[0] == pytest.approx(5.0, rel=3e-3)


def test_where_the_force_was_there_first_it_comes_to_feel_the_line_as_well():
    """Its pitch has taken up what the line does, so that all of the record is out of phase."""
    found = declared(channels(moved(Driven(1.0, Backbone(0.05, 0.0)))))
    law, p = extend(found, (large_amplitude.EFFECT,), [(0.02, 0.0)])
    stiff = fit(law, p, evaluations=20)
    deaf = fit(*extend(stiff, (steady_drive.EFFECT,), [(np.log(RATE),)]), evaluations=40)
    assert deaf.chi2 > 3 * deaf.samples
    found = carrying(carrying(carrying(deaf)))
    assert found.chi2 < 1.1 * found.samples
    assert found.frequency[0] == pytest.approx(5.0, rel=5e-3)


def test_a_creep_carries_the_body_to_where_it_still_is():
    creep = 0.3 * AMPLITUDE * np.exp(-TIME / 0.8)
    found = declared(channels(moved() + np.outer(creep, SHAPE)))
    law, p = extend(found, (relaxation.EFFECT,), [(np.log(0.8),)])
    u, v = carrying(fit(law, p, evaluations=20)).law.setting.carried[0].at(0.01, 100)
    at = 0.01 * np.arange(101)
    assert u[:, 0] == pytest.approx(0.3 * AMPLITUDE * np.exp(-at / 0.8), abs=0.01 * AMPLITUDE)
    assert v[:, 0] == pytest.approx(-u[:, 0] / 0.8, rel=0.05)


def test_a_carried_motion_has_its_speed_however_few_the_steps():
    rate = 2 * np.pi * 6 * 5.0  # six times the pitch that the steps are made for
    step = 1 / (16 * 5.0)
    u, v = Carried([lambda time: np.sin(rate * time)[:, None]]).at(step, 20)
    assert v[:, 0] == pytest.approx(rate * np.cos(rate * step * np.arange(21)), abs=0.02 * rate)


def test_what_is_carried_goes_with_the_effect_that_makes_it():
    found = declared(channels(moved(Driven(1.0, Rub(0.05, 0.02)))))
    assert carrying(found) is found
    law, p = extend(found, (steady_drive.EFFECT,), [(np.log(RATE),)])
    line = carrying(fit(law, p, evaluations=40))
    both = fit(*extend(line, (dry_friction.EFFECT,), [(0.03, np.log(0.02))]))

    def heard(found, law=None):
        return misfits(law or found.law, found.parameters[None])[0]

    def deaf(law):
        return replace(law, setting=replace(law.setting, carried=()))

    assert heard(both) != pytest.approx(heard(both, deaf(both.law)), rel=1e-3)
    lone = without(both, 0)
    assert heard(lone) == heard(lone, deaf(lone.law))


def test_what_is_carried_is_worked_out_once_for_the_same_steps():
    asked = []

    def path(time):
        asked.append(len(time))
        return np.sin(time)[:, None]

    one = Carried([path])
    u, v = one.at(0.01, 100)
    assert one.at(0.01, 100)[0] is u
    assert asked == [101] * 3
    assert v[50, 0] == pytest.approx(np.cos(0.5), rel=1e-4)
