"""Independent work on two cores: a forked child takes every piece that is not yet taken.

Only where forking is safe: on Linux, in a process of one thread that is not Blender. Elsewhere
one piece follows the other, with the same result.
"""

import os
import pickle
import signal
import sys
from collections.abc import Callable
from contextlib import contextmanager

CHILD = "RINGDOWN_SIDE"  # set where no core is left for a child
MOST = 255  # pieces; more take turns


def side_by_side(jobs: list[Callable[[], object]], *, pack=None, unpack=None) -> list:
    """What each of the `jobs` returns, in their order; the longest ones had better come first.

    pack(result) makes what goes from one process to the other, which must pickle;
    unpack(number of the job, packed) makes the result of it again.
    """
    if not 1 < len(jobs) <= MOST or not _may_fork():
        return [job() for job in jobs]
    tickets, reader, child = _open(jobs, pack)
    try:
        done = {n: jobs[n]() for n in _taken(tickets)}
        told = _received(reader) or {}
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(reader)
        os.close(tickets)
        os.waitpid(child, 0)
    for n, packed in told.items():
        done[n] = unpack(n, packed) if unpack else packed
    # what the child came to grief over comes to grief here, where it can be told
    return [done[n] if n in done else job() for n, job in enumerate(jobs)]


@contextmanager
def meanwhile(job: Callable[[], object]):
    """A function that returns what `job` returns, which is at work until then; it must pickle."""
    if not _may_fork():
        yield job
        return
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        _send(writer, job)
    os.close(writer)
    try:
        yield lambda: _received(reader) or job()
    finally:
        os.kill(child, signal.SIGKILL)  # it has nothing left to do, or nobody to do it for
        os.close(reader)
        os.waitpid(child, 0)


def _received(reader: int):
    with os.fdopen(reader, "rb", closefd=False) as pipe:
        sent = pipe.read()
    return pickle.loads(sent) if sent else None


def _send(writer: int, job: Callable[[], object]) -> None:
    """The child's whole life: do the job, tell, and never return."""
    os.environ[CHILD] = "1"
    try:
        sent = pickle.dumps(job())
        with os.fdopen(writer, "wb") as pipe:
            pipe.write(sent)
    finally:
        os._exit(0)


def _may_fork() -> bool:
    if sys.platform != "linux" or "bpy" in sys.modules or os.environ.get(CHILD):
        return False
    return len(os.sched_getaffinity(0)) > 1 and len(os.listdir("/proc/self/task")) == 1


def _open(jobs: list, pack) -> tuple[int, int, int]:
    """Where the numbers of untaken jobs and the child's results are read, and the child."""
    tickets, issue = os.pipe()
    os.write(issue, bytes(range(len(jobs))))
    os.close(issue)
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        _send(writer, lambda: _share(jobs, pack, tickets))
    os.close(writer)
    return tickets, reader, child


def _taken(tickets: int):
    """Numbers of jobs that nobody has taken yet."""
    while ticket := os.read(tickets, 1):
        yield ticket[0]


def _share(jobs: list, pack, tickets: int) -> dict:
    results = {n: jobs[n]() for n in _taken(tickets)}
    return {n: pack(one) if pack else one for n, one in results.items()}
