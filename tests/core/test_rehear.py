"""When a second hearing is the better one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import rehear
from core.effects import dry_friction
from core.timefit import extend, fit, misfits
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import Rub, W, channels, declared, moved


def verdict(name, left, held_out, effects=("rub",)):
    final = SimpleNamespace(left=left, held_out=held_out)
    return SimpleNamespace(verdict=name, effects=effects, final=final)


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
