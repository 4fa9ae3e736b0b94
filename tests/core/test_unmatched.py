"""What further modes tell of a body."""

from types import SimpleNamespace

import numpy as np
import pytest

from core import ground, stranger
from core.unmatched import ALOUD, LOUD, FurtherMode, of_the_body, unfolded_mode


def heard(rate=1000.0):
    """A body with three modes apart, the first of which was matched, at 2 Hz."""
    modes = SimpleNamespace(frequency=np.array([1.0, 2.5, 4.0]))
    return SimpleNamespace(
        body=SimpleNamespace(modes=modes), match=SimpleNamespace(modes=(0,)), rate=rate
    )


def told(further, seen, one, **how):
    """Those of the modes that tell of the body that was heard."""
    law = SimpleNamespace(fitted=[0], takes=(SimpleNamespace(frame=1 / one.rate),))
    final = SimpleNamespace(frequency=np.array([2.0]), damping_ratio=np.array([0.01]), law=law)
    return of_the_body(further, seen, one, final, **how)


@pytest.mark.parametrize(("pitch", "tells"), [(5.2, True), (7.7, False)])
def test_what_moves_as_no_mode_may_be_a_changed_bodys(pitch, tells):
    """But for what lies near the highest computed one, at 8 Hz."""
    one = FurtherMode(pitch, 0.02, np.array([0.4, 0.4, 0.4, 1.0]), 1e-3, 0.001, 4)
    assert told([one], np.eye(3, 4), heard()) == []
    assert told([one], np.eye(3, 4), heard(), however=True) == ([one] if tells else [])


@pytest.mark.parametrize(
    ("pull", "free", "strange", "alone"),
    [
        ([0.5, -0.5, 4.0], 0.5, 1, True),
        ([0.5, -0.5, 4.0, 4.0], 0.5, 2, True),
        ([0.5, -0.5, 0.3], 0.5, 0, False),
        ([1.8, -1.8, 4.0], 0.5, 1, False),
        ([0.0, 4.0, 4.0], 0.0, 2, False),
    ],
    ids=["one", "two", "none", "loud ones, too", "one loud mode is never off"],
)
def test_faint_modes_alone_are_off_where_two_loud_ones_are_the_bodys(pull, free, strange, alone):
    base = SimpleNamespace(
        strange=strange, pitch_pull=np.array(pull), free=np.full(len(pull), free)
    )
    measured = SimpleNamespace(frequency=np.arange(len(pull)), faint=max(strange, 1))
    assert ground._only_faint_are_off(SimpleNamespace(base=base, measured=measured)) == alone


@pytest.mark.parametrize(
    ("shape", "loud", "tells"),
    [
        ([0.1, 1.0, 0.2], 0.001, True),
        ([1.0, 0.1, 0.1], 0.001, False),  # as the matched one moves
        ([0.4, 0.4, 0.4, 1.0], 0.001, False),
        ([0.4, 0.4, 0.4, 1.0], 1.1 * LOUD, True),
    ],
)
def test_a_faint_mode_tells_of_the_body_where_it_moves_as_one_of_its_own(shape, loud, tells):
    shape = np.r_[shape, np.zeros(4 - len(shape))]
    one = FurtherMode(7.0, 0.02, shape, 1e-3, loud, 4)
    assert told([one], np.eye(3, 4), heard()) == ([one] if tells else [])


@pytest.mark.parametrize(("pitch", "least"), [(7.0, LOUD), (8.2, ALOUD), (4.9, ALOUD)])
def test_what_has_the_pitch_of_a_mode_and_moves_otherwise_counts_sooner(pitch, least):
    """The body's other modes lie at 5 and 8 Hz."""
    shape = np.array([0.4, 0.4, 0.4, 1.0])
    for loud, tells in ((0.9 * least, False), (1.1 * least, True)):
        one = FurtherMode(pitch, 0.02, shape, 1e-3, loud, 4)
        assert told([one], np.eye(3, 4), heard()) == ([one] if tells else [])


@pytest.mark.parametrize(
    ("seen_at", "rate", "tells"),
    [(7.0, 1000.0, True), (7.7, 1000.0, False), (3.2, 1000.0, True), (3.2, 11.5, False)],
    ids=["below the highest", "above what was computed", "far lower", "rather its fold"],
)
def test_a_faint_mode_tells_of_the_body_where_it_was_computed(seen_at, rate, tells):
    """The mode that it moves as lies at 8 Hz, which at 11.5 frames/s is seen at 3.5 Hz."""
    one = FurtherMode(seen_at, 0.02, np.array([0.1, 0.1, 1.0, 0.0]), 1e-3, 0.001, 4)
    assert told([one], np.eye(3, 4), heard(rate)) == ([one] if tells else [])


def unlike(channels, seed):
    """A faint motion that is none of the body's."""
    shape = np.random.default_rng(seed).standard_normal(channels)
    return FurtherMode(7.0, 0.02, shape, 1e-3, 0.001, 4)


@pytest.mark.parametrize("channels", [3, 6, 12, 24])
def test_what_is_none_of_its_modes_seldom_tells_of_the_body(channels):
    """With few channels any motion is like some mode's."""
    many = 0
    for seed in range(200):
        seen = np.random.default_rng(1000 + seed).standard_normal((3, channels))
        many += len(told([unlike(channels, seed)], seen, heard()))
    assert many <= 0.08 * 200


def test_a_mode_that_no_channel_sees_is_like_nothing():
    for seed in range(20):
        seen = np.eye(3, 12)
        seen[1:] *= 1e-9 * np.random.default_rng(seed).standard_normal((2, 1))
        shape = np.r_[0.0, 1.0, np.zeros(10)]
        assert not told([FurtherMode(7.0, 0.02, shape, 1e-3, 0.001, 4)], seen, heard())


@pytest.mark.parametrize(
    ("shape", "seen_at", "z", "true"),
    [
        ([0.1, 0.2, 1.0], 12.0, 0.08, 48.0),
        ([0.1, 1.0, 0.4], 12.0, 0.08, 12.0),  # more like a mode that is lower than computed
        ([0.7, 0.7, 0.7], 12.0, 0.08, 12.0),
        ([0.1, 0.2, 1.0], 12.0, 0.002, 12.0),  # it does not die as a mode
        ([0.1, 0.2, 1.0], 14.5, 0.08, 14.5),  # the fold of none
    ],
    ids=["a fold", "moved", "unlike", "a line", "elsewhere"],
)
def test_a_further_mode_is_unfolded_where_it_is_like_the_folded_one_alone(shape, seen_at, z, true):
    """At 60 frames/s a mode of 48 Hz is seen at 12 Hz, and dies in the same time."""
    modes = SimpleNamespace(frequency=np.array([1.0, 2.6, 9.6]))
    body = SimpleNamespace(body=SimpleNamespace(modes=modes), match=SimpleNamespace(modes=(0,)))
    final = SimpleNamespace(
        law=SimpleNamespace(takes=[SimpleNamespace(frame=1 / 60)], fitted=[0]),
        frequency=np.array([5.0]),
        damping_ratio=np.array([0.02]),
    )
    one = FurtherMode(seen_at, z, np.array(shape), 1e-3, 0.1, 4)
    found = unfolded_mode(one, np.eye(3), body, final)
    assert found.frequency == pytest.approx(true, rel=5e-3)
    assert found.frequency * found.damping_ratio == pytest.approx(seen_at * z)


@pytest.mark.parametrize(
    ("seen_at", "damping_ratio", "first", "strange"),
    [
        (5.8, 0.04, 0.02, True),
        (5.8, 0.2, 0.02, False),
        (5.8, 0.04, 0.0, False),
        (5.8, 0.04, 0.002, False),
        (8.2, 0.04, 0.02, False),
        (4.5, 0.2, 0.02, True),
    ],
    ids=["dies too slowly for a fold", "a fold", "none dies", "all do", "its own", "neither"],
)
def test_a_stranger_is_no_fold_of_what_would_have_to_die_otherwise(
    monkeypatch, seen_at, damping_ratio, first, strange
):
    """A mode at 234.2 Hz, known to 0.5 Hz, is seen at 5.8 with 240 frames/s."""
    body = SimpleNamespace(modes=SimpleNamespace(frequency=np.array([3.6, 8.4, 234.2])))
    ground = SimpleNamespace(
        body=body,
        data=SimpleNamespace(frame=1 / 240),
        base=SimpleNamespace(modulus=1.0),
        measured=SimpleNamespace(frequency=np.array([3.6])),
        shrink=np.ones(3),
        doubt=np.full(3, 0.002),
    )
    law = SimpleNamespace(effects=())
    final = SimpleNamespace(frequency=np.array([3.6]), damping_ratio=np.array([first]), law=law)
    one = FurtherMode(seen_at, damping_ratio, np.ones(3), 1e-3, 0.2, 4)
    monkeypatch.setattr(stranger, "further_modes", lambda verdict, *but: [one])
    found = stranger.strangers(SimpleNamespace(final=final), ground)
    assert found == ([seen_at] if strange else [])


@pytest.mark.parametrize(
    ("names", "loud", "strange"),
    [((), 0.02, True), (("base_motion",), 0.02, False), (("base_motion",), 0.2, True)],
    ids=["nothing acts", "what shakes all shakes it", "louder than that"],
)
def test_a_stranger_is_told_beside_what_shakes_all_where_it_is_loud(
    monkeypatch, names, loud, strange
):
    """At 2.55 Hz, between a body's modes at 2.3 and 2.9: whatever the markers share took of it."""
    ground = SimpleNamespace(
        body=SimpleNamespace(modes=SimpleNamespace(frequency=np.array([2.3, 2.9]))),
        data=SimpleNamespace(frame=1 / 100),
        base=SimpleNamespace(modulus=1.0),
        measured=SimpleNamespace(frequency=np.array([2.3])),
        shrink=np.ones(2),
        doubt=np.full(2, 0.002),
    )
    law = SimpleNamespace(effects=[SimpleNamespace(name=name) for name in names])
    final = SimpleNamespace(frequency=np.array([2.3]), damping_ratio=np.array([0.014]), law=law)
    one = FurtherMode(2.55, 0.007, np.ones(3), 1e-3, loud, 4)
    monkeypatch.setattr(
        stranger, "further_modes", lambda verdict, *but: [one] if "base_motion" in but else []
    )
    found = stranger.strangers(SimpleNamespace(final=final), ground)
    assert found == ([2.55] if strange else [])


def test_beside_a_folded_mode_a_fold_is_no_stranger(monkeypatch):
    """228 and 200 Hz, both with a damping ratio of 0.005, at 240 frames/s."""
    body = SimpleNamespace(modes=SimpleNamespace(frequency=np.array([228.0, 200.0, 300.0])))
    kept = {"data": SimpleNamespace(frame=1 / 240), "base": SimpleNamespace(modulus=1.0)}
    kept |= {"shrink": np.ones(3), "doubt": np.full(3, 0.002)}
    ground = SimpleNamespace(
        body=body, measured=SimpleNamespace(frequency=np.array([228.0])), **kept
    )
    z, law = np.array([0.005 * 228 / 12]), SimpleNamespace(effects=())
    seen = SimpleNamespace(frequency=np.array([12.0]), damping_ratio=z, law=law)
    one = FurtherMode(40.0, 0.005 * 200 / 40, np.ones(3), 1e-3, 0.2, 4)
    monkeypatch.setattr(stranger, "further_modes", lambda verdict, *but: [one])
    assert stranger.strangers(SimpleNamespace(final=seen), ground) == []
