"""Two effects of which neither shows alone, integrated here by another rule."""

import numpy as np

from core.effects import dry_friction, relaxation
from core.timefit import sharp
from core.together import pairs
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import SHAPE, TIME, Rub, channels, declared, moved, raced

SLOW = 0.8  # s


def creeping_and_rubbed():
    """The rub stops the swing early, and the slow return is most of what is left then."""
    creep = 0.4 * AMPLITUDE * np.exp(-TIME / SLOW)
    return declared(channels(moved(Rub(0.08, 0.02)) + np.outer(creep, SHAPE)))


def test_two_effects_are_found_where_neither_is_alone():
    found = creeping_and_rubbed()
    for effect in (dry_friction.EFFECT, relaxation.EFFECT):
        alone = raced(found, effect)
        assert alone.chi2 > 3 * alone.samples
    best = pairs(found, [])[0]
    assert set(best.names) == {"dry_friction", "relaxation"}
    fine = sharp(best.found)
    assert fine.chi2 < 1.2 * fine.samples
    theta = dict(zip(best.names, fine.theta, strict=True))
    assert abs(np.exp(theta["relaxation"][0][0]) / SLOW - 1) < 0.1
    assert abs(theta["dry_friction"][0][0] / 0.08 - 1) < 0.1


def test_where_nothing_acts_no_two_effects_are_begun():
    assert pairs(declared(channels(moved())), []) == []
