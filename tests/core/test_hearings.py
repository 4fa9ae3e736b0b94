"""Modes that were not heard by themselves: which of them are the body's."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import joint
from core.data import RingDown
from core.hearings import weak_beside
from core.match import Match
from core.unheard import weak_modes


@pytest.mark.parametrize("strongest", [0, 1])
def test_a_mimic_is_weak_lies_beside_the_strongest_and_dies_otherwise(strongest):
    other = 1 - strongest
    match = Match((strongest, strongest, other, strongest, strongest), (1, 0, 2, 3, 4))
    frequency = np.array([6.28, 6.10, 6.4, 6.5, 15.1])
    damping_ratio = np.array([0.008, 0.035, 0.035, 0.01, 0.035])
    # the third was heard, the fourth dies alike, the last lies far away
    assert weak_beside(match, frequency, damping_ratio).tolist() == [False, True] + 3 * [False]


@pytest.mark.parametrize(("rate", "found", "aside"), [(60.0, 20.6, [22.3]), (500.0, 22.3, [20.6])])
def test_a_weak_pole_that_is_a_fold_is_no_weak_mode(rate, found, aside):
    """Seen so, the modes at 20.6 and 37.7 Hz move alike; at 60 frames/s the latter is at 22.3."""
    rng = np.random.default_rng(2)
    shapes = rng.standard_normal((3, 8))
    shapes[2] = shapes[1] + 0.2 * rng.standard_normal(8)
    data = SimpleNamespace(
        support=np.zeros(8, bool), frame=1 / rate, fit=np.ones(50, bool),
        time=np.arange(50) / rate, sigma=np.ones(8),
    )  # fmt: skip
    strong = SimpleNamespace(
        frequency=np.array([2.77]),
        damping_ratio=np.array([0.01]),
        law=SimpleNamespace(fitted=[0], takes=[data], turning=()),
    )
    pitch = np.array([2.77, 20.6, 37.7])
    body = SimpleNamespace(modes=SimpleNamespace(frequency=pitch), seen=lambda data: shapes)
    heard = np.array([shapes[2], 0.3 * shapes[1]], complex)
    rest = RingDown([22.3, 20.6], [0.03, 0.01], heard, np.zeros(8), np.ones(8), np.eye(4))
    ring, match, left = weak_modes(strong, rest, body, Match((2,), (0,)), 0.4)
    assert match == Match((2, 2), (0, 1))
    assert ring.frequency == pytest.approx([2.77, found]) and left == pytest.approx(aside)


@pytest.mark.parametrize(("left", "kept"), [(20.0, "as filmed"), (1.05, "straight")])
def test_takes_that_a_lens_bends_are_straightened_unless_that_leaves_far_more(
    monkeypatch, left, kept
):
    """What two modes of huge swings that cancel would bend is none of what is seen."""
    ground, straight = (
        SimpleNamespace(name=name, condition=[0], rings=[SimpleNamespace(frequency=[5.0])],
                        fitted=[0])
        for name in ("as filmed", "straight")
    )  # fmt: skip
    fits = {"as filmed": 1.0, "straight": left}
    match = Match((0,), (0,))
    for name, value in {
        "common": lambda matches, heard: matches,
        "left_out": lambda *_: [],
        "_same_poles": lambda *_: None,
        "settle": lambda on, chosen, matches: (fits[on.name], None, {0: match}),
        "_straightened": lambda on, settled: straight,
        "excess": lambda one: one,
        "_whole": lambda on, settled, loaded: (settled[0], None, match),
        "heard_by": lambda on, whole: (on.name, whole[0]),
    }.items():
        monkeypatch.setattr(joint, name, value)
    assert joint._hear(ground, {0: match}) == (kept, fits[kept])
