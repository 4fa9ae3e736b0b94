"""Independent work on two cores: this process and a forked child take part after part.

Only where forking is safe and a core is free: on Linux, in a process of one thread that is not
Blender. Elsewhere one job follows the other, with the same result but for its last digits, for what
goes in step is worked out in other batches. Work that is shared shares none of itself: which
process is done first must not matter.
"""

import ctypes
import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from functools import partial

from .handover import Known
from .in_step import in_step

ALONE = "RINGDOWN_ALONE"  # an environment variable; set, it keeps all work in one process
MOST = 255  # jobs; more follow one another
PART = 4  # jobs that go in step where there are many
JOB, SHARE = 20.0, 0.25  # what a job costs beside its strides; what its own add to others' alike
GOING = 0.02  # s that an ended thread is waited for
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG

_children: set[int] = set()  # not waited for yet
_sharing: list[bool] = []  # while this process does its share of some work


def in_step_by_parts(jobs: list[Callable[[], object]], *, strides=None) -> list:
    """As `side_by_side`, of a few parts, the jobs of a part in step.

    strides: how many steps a job makes; those of alike jobs are made as one, so these stay
    together. By default all are alike. The parts are the same whether or not a core is free, and
    so are the last digits.
    """
    if len(jobs) < 2 or not may_share():
        return in_step(jobs)
    parts = _parts(strides or [1] * len(jobs))
    done = side_by_side([partial(in_step, [jobs[i] for i in part]) for part in parts])
    told = {
        i: one
        for part, some in zip(parts, done, strict=True)
        for i, one in zip(part, some, strict=True)
    }
    return [told[n] for n in range(len(jobs))]


def _parts(strides: list[float]) -> list[list[int]]:
    """Numbers of the jobs of each part, the dearest first: the process that is done sooner takes
    more of them. Of many jobs, whose motions fill a march anyway, parts are small; of few, those of
    alike strides stay together, but for the dearest ones if they are done sooner in two halves.
    """
    if len(strides) >= 3 * PART:
        order = sorted(range(len(strides)), key=lambda n: -strides[n])
        return [order[i : i + PART] for i in range(0, len(order), PART)]
    alike = {}
    for n, own in enumerate(strides):
        alike.setdefault(own or -1 - n, []).append(n)  # without a march each by itself
    parts = list(alike.values())
    dearest = max(parts, key=lambda part: _cost(part, strides))
    split = [part for part in parts if part is not dearest]
    split += [half for half in (dearest[0::2], dearest[1::2]) if half]
    parts = min(parts, split, key=lambda some: _last([_cost(part, strides) for part in some]))
    return sorted(parts, key=lambda part: -_cost(part, strides))


def _cost(part: list[int], strides: list[float]) -> float:
    """What a part costs, all of whose strides are alike."""
    return strides[part[0]] + sum(JOB + SHARE * strides[n] for n in part)


def _last(costs: list[float]) -> float:
    """When two processes are done that take the dearest first."""
    done = [0.0, 0.0]
    for cost in sorted(costs, reverse=True):
        done[done.index(min(done))] += cost
    return max(done)


def side_by_side(jobs: list[Callable[[], object]]) -> list:
    """What each of the `jobs` returns, in their order; see `handover` for what that may be.

    A job changes no array that was there before: what comes back of it would be the old one.
    """
    if not 1 < len(jobs) <= MOST or not _may_fork():
        return [job() for job in jobs]
    known = Known(jobs)
    tickets, issue = os.pipe()
    os.write(issue, bytes(range(len(jobs))))
    os.close(issue)
    try:
        child, reader = _fork(lambda: _share(jobs, tickets), known)
    except OSError:  # no process to be had
        os.close(tickets)
        return [job() for job in jobs]
    try:
        with _by_itself():
            done = _share(jobs, tickets)
    except BaseException:
        _drop(child, reader)
        raise
    finally:
        os.close(tickets)
    done |= _wait(child, reader, known)[1] or {}
    # what the child came to grief over comes to grief here, where it can be told
    return [done[n] if n in done else job() for n, job in enumerate(jobs)]


@contextmanager
def meanwhile(job: Callable[[], object]):
    """A function that returns what `job` returns, which is at work until then; see `handover`."""
    if not _may_fork():
        yield job
        return
    known = Known([job])
    try:
        child, reader = _fork(job, known)
    except OSError:
        yield job
        return
    answer = []

    def result():
        if not answer:
            whole, told = _wait(child, reader, known)
            answer.append(told if whole else job())
        return answer[0]

    try:
        yield result
    finally:
        if child in _children:
            _drop(child, reader)


@contextmanager
def _by_itself():
    """Meanwhile this process forks no further child, as its child does not."""
    _sharing.append(True)
    try:
        yield
    finally:
        _sharing.pop()


def may_share() -> bool:
    """Whether this process may have a child take some of its work, as soon as a core is free."""
    if sys.platform != "linux" or "bpy" in sys.modules or os.environ.get(ALONE) or _sharing:
        return False
    return len(os.sched_getaffinity(0)) > 1 and _is_one_thread()


def _may_fork() -> bool:
    return may_share() and len(os.sched_getaffinity(0)) > 1 + sum(map(_is_at_work, _children))


def _is_one_thread() -> bool:
    """Whether no other thread is left; one that has ended may take a moment to go."""
    end = time.monotonic() + GOING
    while True:
        try:
            if len(os.listdir("/proc/self/task")) == 1:
                return True
        except OSError:  # nobody tells
            return False
        if threading.active_count() > 1 or time.monotonic() > end:
            return False
        time.sleep(GOING / 100)


def _is_at_work(child: int) -> bool:
    return os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None


def _fork(work: Callable[[], object], known: Known) -> tuple[int, int]:
    """A child that sends what `work` returns, and where that is read. Raises OSError."""
    reader, writer = os.pipe()
    parent = os.getpid()
    try:
        child = os.fork()
    except OSError:
        os.close(reader)
        os.close(writer)
        raise
    if child:
        os.close(writer)
        _children.add(child)
        return child, reader
    status = 1
    gc.disable()  # to look through all would copy it, and the child is soon gone
    try:
        os.close(reader)
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, int(signal.SIGKILL), 0, 0, 0)
        if os.getppid() == parent:  # else it died before that was settled
            os.environ[ALONE] = "1"
            sent = known.packed(work())
            with os.fdopen(writer, "wb") as pipe:
                pipe.write(sent)
            status = 0
    finally:
        os._exit(status)


def _wait(child: int, reader: int, known: Known) -> tuple[bool, object]:
    """Whether the child's result came whole, and the result."""
    try:
        with os.fdopen(reader, "rb", closefd=False) as pipe:
            sent = pipe.read()
    except BaseException:
        _drop(child, reader)
        raise
    _, status = os.waitpid(child, 0)
    _children.discard(child)
    os.close(reader)
    return (True, known.unpacked(sent)) if status == 0 else (False, None)


def _drop(child: int, reader: int) -> None:
    os.kill(child, signal.SIGKILL)
    os.close(reader)
    os.waitpid(child, 0)
    _children.discard(child)


def _taken(tickets: int):
    """Numbers of jobs that nobody has taken yet."""
    while ticket := os.read(tickets, 1):
        yield ticket[0]


def _share(jobs: list, tickets: int) -> dict:
    return {n: jobs[n]() for n in _taken(tickets)}
