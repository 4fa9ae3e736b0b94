"""When a second hearing is the better one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import rehear
from core.effects import dry_friction
from core.settle import cancels
from core.timefit import extend, fit, misfits
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import Rub, W, channels, declared, moved


def verdict(name, left, held_out, effects=("rub",)):
    final = SimpleNamespace(left=left, held_out=held_out)
    said = {"names": effects, "by_law": effects}
    return SimpleNamespace(verdict=name, effects=effects, final=final, **said)


@pytest.mark.parametrize(
    ("again", "better"),
    [
        (("explained", 0.9, 0.8), True),
        (("adequate", 0.9, 0.8), True),
        (("explained", 0.9, 1.1), False),  # foretells less
        (("refused", 0.9, 0.8), False),
        (("unexplained", 0.9, 0.8), False),  # and leaves nearly as much
        (("unexplained", 0.5, 0.8), True),
        (("explained", 0.5, 0.8, ()), False),  # and names nothing
    ],
)
def test_what_is_explained_or_leaves_far_less_is_better(again, better, monkeypatch):
    monkeypatch.setattr(rehear, "excess", lambda final: final.left)
    monkeypatch.setattr(rehear, "errors", lambda final: final)
    before = verdict("unexplained", 1.0, 1.0)
    assert rehear._is_better(verdict(*again), before) == better


def test_what_was_explained_stays_so(monkeypatch):
    monkeypatch.setattr(rehear, "excess", lambda final: final.left)
    monkeypatch.setattr(rehear, "errors", lambda final: final)
    before = verdict("explained", 1.0, 1.0)
    assert not rehear._is_better(verdict("unexplained", 0.1, 0.1), before)
    assert rehear._is_better(verdict("explained", 0.1, 0.1), before)


@pytest.mark.parametrize(
    ("verdicts", "names", "bic", "better"),
    [
        (("explained", "explained"), ("rub",), 900.0, True),
        (("unexplained", "explained"), ("rub",), 900.0, True),
        (("unexplained", "unexplained"), ("rub",), 900.0, False),
        (("explained", "explained"), ("rub",), 990.0, False),  # hardly likelier
        (("explained", "explained"), ("drag",), 900.0, False),
        (("explained", "explained"), ("rub", "shake"), 900.0, False),
        (("explained", "explained"), (), 900.0, False),  # nothing is named
    ],
)
def test_a_mode_of_the_body_is_better_than_a_motion_that_is_read_off(
    verdicts, names, bic, better, monkeypatch
):
    """However little that leaves of what was held out, where it was read off, too."""
    monkeypatch.setattr(rehear, "excess", lambda final: final.left)
    monkeypatch.setattr(rehear, "errors", lambda final: final)
    monkeypatch.setattr(rehear, "bic", lambda final: final.bic)
    before = verdict(verdicts[0], 1.0, 0.1, ("rub", "shake"))
    before.names, before.by_law, before.final.bic = ("rub", "shake"), ("rub",), 1000.0
    again = verdict(verdicts[1], 0.9, 1.0, names)
    again.names, again.final.bic = names, bic
    assert rehear._is_better(again, before) == better


@pytest.mark.parametrize(
    ("starts", "pitch", "gone"),
    [((1.0, -1.0), 1.01, True), ((1.0, 0.5), 1.01, False), ((1.0, -1.0), 1.2, False)],
    ids=["against each other", "together", "far apart"],
)
def test_close_modes_that_swing_against_each_other_are_none(starts, pitch, gone):
    """Of one shape but for a tenth; in a second take they hardly swing at all."""
    time = np.linspace(0, 0.5, 100)
    shapes = np.array([[1.0, 0.5, -0.3], [1.0, 0.55, -0.27]])
    u = np.stack([a * np.cos(40 * k * time) for a, k in zip(starts, (1, pitch), strict=True)], 1)
    u = u * np.exp(-10 * time[:, None])
    data = SimpleNamespace(support=np.zeros(3, bool))
    found = SimpleNamespace(
        law=SimpleNamespace(takes=[data], fitted=[0], modes=2),
        frequency=np.array([6.0, 6.0 * pitch]),
        motions=(u, 0.01 * np.abs(u)),
        shapes_of=lambda take: shapes,
    )
    assert cancels(found) == gone


def nearby_is(monkeypatch, against):
    """A hearing with one more mode, of which the declared fit, the one with what was found, and
    the final one have it swing against another, or not.
    """
    declared, wider, final = against
    law = SimpleNamespace(setting=None, sizes=lambda: (0, 0, 0))
    near = SimpleNamespace(
        declared=SimpleNamespace(law=law, cancels=declared, left=0.1),
        body=None,
        match=SimpleNamespace(modes=(0, 1)),
    )
    sought = SimpleNamespace(law=law, cancels=wider, left=0.1, parameters=np.zeros(0))
    monkeypatch.setattr(rehear, "excess", lambda final: final.left)
    monkeypatch.setattr(rehear, "errors", lambda final: final)
    monkeypatch.setattr(rehear, "cancels", lambda found: found.cancels)
    monkeypatch.setattr(rehear, "nearby", lambda heard: [near])
    monkeypatch.setattr(rehear, "_with_the_mode", lambda *_: sought)
    monkeypatch.setattr(rehear, "replace", lambda law, setting: law)
    monkeypatch.setattr(rehear, "as_it_stands", lambda law, p: None)
    again = verdict("unexplained", 0.1, 0.1)
    again.final.cancels = final
    return near, again


@pytest.mark.parametrize(
    ("against", "asked", "taken"),
    [
        ((False, False, False), True, True),
        ((True, False, False), True, True),
        ((False, True, False), True, True),
        ((True, True, False), False, False),
        ((True, False, True), True, False),
    ],
)
def test_a_hearing_of_modes_that_cancel_is_not_taken(monkeypatch, against, asked, taken):
    near, again = nearby_is(monkeypatch, against)
    heard, before = SimpleNamespace(), verdict("unexplained", 1.0, 1.0)
    before.final.chi2, before.final.samples = 500.0, 100
    looked = []

    def diagnose(one, start):
        looked.append(one)
        return again

    out, _ = rehear._with_one_more(heard, before, diagnose)
    assert bool(looked) == asked and (out is near) == taken


def test_one_more_mode_is_sought_from_where_the_found_fit_stands(monkeypatch):
    """On the scale that the effect was found on, though the new hearing has another one: with the
    mode at rest and untouched by the rub the motion is the same.
    """
    start = declared(channels(moved(Rub(0.03, 0.02))))
    found = fit(*extend(start, (dry_friction.EFFECT,), [(0.03, np.log(0.02))]), evaluations=20)
    old = start.law
    setting = replace(
        old.setting,
        omega=W * np.array([1.1, 1.3]),
        zeta=np.full(2, 0.02),
        couple=np.ones(2),
        places=np.array([[0.0], [3.0]]),
        masses=np.ones(2),
        amplitude=0.6 * AMPLITUDE,
    )
    across = np.array([0.2, -0.5, 0.4, 1.0])
    law = replace(old, reference=np.vstack([old.reference, across / 2]), setting=setting)
    pitches = np.log(W / 2 / np.pi * np.array([1.1, 1.3]))
    outer = np.r_[pitches, 0.02, 0.02, AMPLITUDE, 0.0, 0.0, 0.0]
    near = SimpleNamespace(
        declared=SimpleNamespace(law=law, theta=[], parameters=outer, samples=start.samples),
        body=SimpleNamespace(modes=SimpleNamespace(frequency=np.array([5.0, 6.5]))),
        match=SimpleNamespace(modes=(0, 1)),
    )
    heard = SimpleNamespace(declared=SimpleNamespace(law=SimpleNamespace(effects=())))
    n = start.samples
    monkeypatch.setattr(rehear, "carrying", lambda found: found)
    monkeypatch.setattr(rehear, "best_fit", lambda law, starts, **_: misfits(law, starts, n))
    sought = rehear._with_the_mode(near, found, heard)
    left = (found.residuals[: found.samples] ** 2).sum()
    assert sought.min() < 1.02 * left < 0.2 * (start.residuals[: start.samples] ** 2).sum()
