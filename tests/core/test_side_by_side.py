"""Independent work in two processes gives what it gives in one."""

import os
import time

import numpy as np
import pytest

from core import side_by_side as where
from core.side_by_side import meanwhile, side_by_side


@pytest.fixture(params=[True, False], ids=["forked", "in turn"])
def forked(request, monkeypatch):
    if request.param and not hasattr(os, "fork"):
        pytest.skip("no fork here")
    monkeypatch.setattr(where, "_may_fork", lambda: request.param)
    return request.param


def test_results_come_in_the_order_of_the_jobs(forked):
    jobs = [lambda n=n: (time.sleep(0.05), n, os.getpid(), np.full(3, n)) for n in range(6)]
    out = side_by_side(jobs)
    assert [n for _, n, _, _ in out] == list(range(6))
    assert len({pid for _, _, pid, _ in out}) == (2 if forked else 1)
    assert (out[3][3] == 3).all()


def test_what_does_not_pickle_is_packed_and_unpacked(forked):
    jobs = [lambda n=n: lambda: n for n in range(4)]
    out = side_by_side(jobs, pack=lambda one: one(), unpack=lambda n, packed: lambda: packed)
    assert [one() for one in out] == [0, 1, 2, 3]


def test_an_error_in_the_child_is_told_here(forked):
    def bad():
        raise ValueError("a stone in the shoe")

    with pytest.raises(ValueError, match="a stone in the shoe"):
        side_by_side([lambda: time.sleep(0.1), bad])


def test_an_error_here_leaves_no_child_behind(forked):
    def bad():
        raise ValueError("here")

    with pytest.raises(ValueError, match="here"):
        side_by_side([bad, bad, bad])
    if forked:
        with pytest.raises(ChildProcessError):
            os.waitpid(-1, os.WNOHANG)


def test_a_child_has_no_child(monkeypatch):
    monkeypatch.setenv(where.CHILD, "1")
    assert not where._may_fork()


def test_what_goes_on_meanwhile_is_there_when_it_is_asked_for(forked):
    with meanwhile(lambda: (os.getpid(), np.arange(3))) as result:
        pid, values = result()
    assert (pid != os.getpid()) == forked
    assert (values == np.arange(3)).all()


def test_what_nobody_waits_for_any_longer_ends(forked):
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt), meanwhile(lambda: time.sleep(60)):
        raise KeyboardInterrupt
    assert time.monotonic() - begun < 30


def test_what_fails_meanwhile_fails_when_it_is_asked_for(forked):
    def bad():
        raise ValueError("late")

    with pytest.raises(ValueError, match="late"), meanwhile(bad) as result:
        result()
