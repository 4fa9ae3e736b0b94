"""When a second hearing is the better one."""

from types import SimpleNamespace

import pytest

from core import rehear


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
