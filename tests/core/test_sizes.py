"""What a size that is a little off does to the pitches: against a body solved at that size."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import doubt
from core.compare import Measured, compare
from core.data import Material
from core.elasticity import assemble, hold_points
from core.ground import Ground, looked_at_closely
from core.modes import solve_modes
from core.sizes import size_slopes
from tests.core.solids import block

SIZE = np.array([0.24, 0.03, 0.02])
STUFF = Material(1100.0, 0.45)


def bar(stretched=(1.0, 1.0, 1.0)):
    """A clamped bar, and its lowest six modes."""
    model = assemble(block((12, 2, 2), SIZE * stretched), STUFF)
    held = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
    modes = solve_modes(held, 6)
    return SimpleNamespace(bare=held, modes=modes, seen=lambda data: modes.shapes.reshape(-1, 6).T)


def test_a_pitch_moves_with_a_size_as_that_of_a_body_of_that_size():
    """An Euler bar's: as the thickness across which it bends, and as one over its length twice."""
    slopes, steps = size_slopes(bar()), 0.01 * np.eye(3)
    for own, step in zip(slopes, steps, strict=True):
        more, less = (bar(1 + way * step).modes.frequency for way in (1, -1))
        assert own == pytest.approx(np.log(more / less) / 0.02, abs=0.03)
    assert slopes[:, 0] == pytest.approx([-2.0, 0.0, 1.0], abs=0.1)
    assert slopes[:, 1] == pytest.approx([-2.0, 1.0, 0.0], abs=0.1)


@pytest.mark.parametrize(("off", "odd"), [(-0.005, False), (0.005, False), (0.03, True)])
def test_a_thickness_that_is_off_by_what_a_rule_misses_is_no_other_body(off, odd):
    body, real = bar(), bar((1.0, 1.0, 1 + off))
    shapes = body.seen(None)
    few, some = np.full(6, 0.003), np.full(shapes.shape, 0.02)
    measured = Measured(real.modes.frequency, few, shapes, some)
    values = (2 * np.pi * body.modes.frequency) ** 2
    base, none = compare(measured, values, shapes), np.zeros(6)
    far = Ground(body, None, measured, base, np.ones(6), none, none, few)
    close = looked_at_closely(far)
    assert (doubt.chance_of(close.base, close.measured) < doubt.DOUBT) is odd
