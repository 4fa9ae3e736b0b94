"""Independent work in two processes gives what it gives in one."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from core import side_by_side as where
from core.effects import TIME_EFFECTS
from core.effects.further_mode import further_mode
from core.handover import Known
from core.in_step import asked
from core.side_by_side import in_step_by_parts, meanwhile, side_by_side
from core.time_layer import singles
from tests.core.test_timefit import Rub, channels, declared, moved

LARGE = 200_000  # more than a pipe holds


FORKED = os.environ.get("RINGDOWN_FORKED") == "1"  # set in a process that may be forked, below
alone = pytest.mark.skipif(not FORKED, reason="is run in a process of its own")


@pytest.fixture
def forked(monkeypatch):
    monkeypatch.setattr(where, "_may_fork", lambda: FORKED)
    yield FORKED
    assert not where._children


@pytest.fixture
def two_cores(monkeypatch):
    """Whatever is here: two cores, one thread, and no Blender."""
    monkeypatch.delenv(where.ALONE, raising=False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 1})
    monkeypatch.setattr(os, "listdir", lambda path: ["one"])
    monkeypatch.setattr(sys, "modules", {k: v for k, v in sys.modules.items() if k != "bpy"})


@pytest.mark.skipif(FORKED or sys.platform != "linux", reason="no fork here, or it is this one")
def test_all_of_this_holds_with_a_child_too():
    settings = dict.fromkeys(("RINGDOWN_FORKED", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", __file__],
        cwd=Path(where.__file__).parents[1],
        env=os.environ | settings,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert " passed" in done.stdout


def test_results_come_in_the_order_of_the_jobs(forked):
    jobs = [lambda n=n: (time.sleep(0.05), n, os.getpid(), np.full(LARGE, n)) for n in range(6)]
    out = side_by_side(jobs)
    assert [n for _, n, _, _ in out] == list(range(6))
    assert len({pid for _, _, pid, _ in out}) == (2 if forked else 1)
    assert all((values == n).all() for _, n, _, values in out)


@pytest.mark.parametrize("shared", [True, False])
def test_parts_go_in_step_and_come_in_order(forked, shared, monkeypatch):
    monkeypatch.setattr(where, "may_share", lambda: shared)
    sizes = []

    def answer(questions):
        sizes.append(len(questions))
        time.sleep(0.05)  # or one process takes both halves
        return [question + 100 for question in questions]

    jobs = [lambda n=n: asked(n, answer) for n in range(5)]
    out = in_step_by_parts([lambda job=job: (job(), os.getpid()) for job in jobs])
    assert [value for value, _ in out] == [100, 101, 102, 103, 104]
    theirs = [n for n, (_, pid) in enumerate(out) if pid != os.getpid()]
    assert theirs in ([1, 3], [0, 2, 4]) if forked and shared else not theirs
    here = [3, 2] if shared else [5]
    assert sizes == ([2 if theirs == [0, 2, 4] else 3] if forked and shared else here)


def test_a_function_comes_with_what_it_encloses(forked):
    """No pickle holds one that was made in a function."""
    own = np.zeros(3)

    def job(n):
        time.sleep(0.05)  # or one process does all
        more = [n]

        def told(factor=10, *, also=0):
            return factor * more[0] + also + own

        return os.getpid(), told, own

    out = side_by_side([partial(job, n) for n in range(4)])
    assert len({pid for pid, *_ in out}) == (2 if forked else 1)
    for n, (_, told, same) in enumerate(out):
        assert told(also=1) == pytest.approx(10 * n + 1)
        assert told(factor=2) == pytest.approx(2 * n)
        assert same is own


@alone
@pytest.mark.parametrize("slow", [0, 1])
def test_what_goes_in_step_depends_on_no_timing(two_cores, slow):
    """Work that is shared shares none of itself, whichever process is done first."""

    def job(n):
        time.sleep(0.3 * (n == slow))
        return in_step_by_parts([lambda: asked(0, lambda some: [len(some)] * len(some))] * 4)

    assert where._may_fork()
    assert in_step_by_parts([partial(job, n) for n in range(2)]) == [[4] * 4] * 2


def test_what_was_there_before_is_the_same_object_after(forked):
    found = declared(channels(moved()))

    def job(effect):
        time.sleep(0.05)
        return os.getpid(), replace(found, law=replace(found.law, effects=(effect,)))

    effects = [*TIME_EFFECTS[:3], further_mode(7.0, 0.02)]
    out = side_by_side([partial(job, effect) for effect in effects])
    assert len({pid for pid, _ in out}) == (2 if forked else 1)
    for effect, (_, one) in zip(effects, out, strict=True):
        assert one.law.effects[0] is effect and one.law.takes[0] is found.law.takes[0]
        assert one.law.setting is found.law.setting and one.jacobian is found.jacobian


def test_what_was_there_is_known_wherever_it_is():
    own, key, inner = np.zeros(3), declared(channels(moved())), np.ones(2)

    def job(*, by_name=own):
        return by_name

    known = Known([job, {key: 0}, [SimpleNamespace], partial(max, inner)])
    assert all(id(one) in known.objects for one in (own, key, inner, job))
    assert known.unpacked(known.packed({key: [own, inner]}))[key][0] is own


def test_what_a_diagnosis_shares_can_be_handed_over():
    """Where it could not, the other process would do it once more, and nobody would notice."""
    found = declared(channels(moved(Rub(0.05, 0.02))))
    known = Known([found])
    ranked = singles(found)[0]
    again = known.unpacked(known.packed(ranked))
    for one, other in zip(ranked, again, strict=True):
        assert one.names == other.names and one.found.law.takes[0] is other.found.law.takes[0]
        assert one.found.parameters == pytest.approx(other.found.parameters, rel=0)
        effect, same = one.found.law.effects[-1], other.found.law.effects[-1]
        assert effect is same if effect in TIME_EFFECTS else effect.name == same.name


def test_an_effect_that_a_child_made_does_what_it_did_there(forked):
    take = channels(moved())  # any noun stands for one
    pitches = 3.0, 4.0, 5.0

    def job(pitch):
        time.sleep(0.05)
        return further_mode(pitch, 0.02, (take,))

    theta, at = np.array([[0.01, 0.03]]), np.linspace(0, 1, 9)[None]
    for pitch, effect in zip(
        pitches, side_by_side([partial(job, f) for f in pitches]), strict=True
    ):
        here = further_mode(pitch, 0.02)
        same = effect.columns(theta, None, at, None), here.columns(theta, None, at, None)
        assert same[0] == pytest.approx(same[1])
        assert effect.channels(None, SimpleNamespace(sigma=[1.0], take=take)).all()


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


def test_what_a_killed_child_had_taken_is_done_here(forked):
    here = os.getpid()

    def deadly():
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return "done"

    assert side_by_side([lambda: time.sleep(0.1), deadly, deadly])[1:] == ["done", "done"]


@pytest.mark.parametrize("value", [None, 0, np.arange(3), np.arange(LARGE)])
def test_what_goes_on_meanwhile_is_there_as_often_as_it_is_asked_for(forked, value):
    with meanwhile(lambda: (os.getpid(), value)) as result:
        pid, first = result()
        assert result()[0] == pid or not forked
    assert (pid != os.getpid()) == forked
    np.testing.assert_equal(first, value)


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


def test_a_child_has_no_child(monkeypatch):
    monkeypatch.setenv(where.ALONE, "1")
    assert not where._may_fork()


def test_where_no_process_is_to_be_had_one_does_it_all(monkeypatch):
    def none():
        raise BlockingIOError("too many")

    monkeypatch.setattr(where, "_may_fork", lambda: True)
    monkeypatch.setattr(os, "fork", none, raising=False)
    assert side_by_side([lambda: 1, lambda: 2]) == [1, 2]
    with meanwhile(lambda: 3) as result:
        assert result() == 3


@alone
def test_there_are_no_more_processes_than_cores(two_cores):
    with meanwhile(lambda: time.sleep(60)):
        assert not where._may_fork()
    assert where._may_fork()


@pytest.mark.skipif(sys.platform != "linux", reason="no fork here")
def test_a_child_ends_with_the_one_who_started_it():
    script = f"""
import os, sys, time
sys.path.insert(0, {str(Path(where.__file__).parents[1])!r})
from core import side_by_side as where
where._may_fork = lambda: True
with where.meanwhile(lambda: b"x" * {LARGE}):
    print(*where._children, flush=True)
    time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as parent:
        child = int(parent.stdout.readline())
        time.sleep(0.3)
        parent.kill()
    for _ in range(100):
        stat = Path(f"/proc/{child}/stat")
        if not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] in "ZX":
            return
        time.sleep(0.1)
    pytest.fail("the child goes on")


def test_two_processes_find_what_one_finds(monkeypatch):
    found = declared(channels(moved(Rub(0.05, 0.02))))
    results = []
    for fork in (FORKED, False):
        monkeypatch.setattr(where, "_may_fork", lambda fork=fork: fork)
        results.append(singles(found)[0])
    for one, other in zip(*results, strict=True):
        assert (one.names, one.outdone) == (other.names, other.outdone)
        assert one.found.parameters == pytest.approx(other.found.parameters, rel=1e-9, abs=1e-12)
        assert one.evidence == pytest.approx(other.evidence, rel=1e-9)


def test_jobs_of_alike_strides_share_a_part_where_that_costs_less():
    """What marches as one costs its steps once; jobs without a march are dealt out."""

    def parts(strides):
        return sorted(map(sorted, where._parts(strides)))

    assert parts([16, 64, 16, 64]) == [[0, 2], [1, 3]]
    assert parts([64, 64, 16, 16, 16]) == [[0, 1], [2, 3, 4]]
    assert parts([0] * 6) == [[n] for n in range(6)]
    assert parts([32] * 5) == [[0, 2, 4], [1, 3]]
    assert parts([1, 1]) == [[0], [1]]
    assert parts([0, 32, 0, 32, 0]) == [[0], [1, 3], [2], [4]]


def test_many_jobs_go_in_parts_that_either_process_may_take():
    """The dearest first: what comes last is what one waits for."""
    parts = where._parts([16.0] * 9 + [64.0] * 4)
    assert sorted(n for part in parts for n in part) == list(range(13))
    assert parts[0] == [9, 10, 11, 12] and len(parts) == 4
    assert where._parts([16, 64, 16, 64]) == [[1, 3], [0, 2]]
