"""Searches that go in step: what all of them ask for at a time is worked out in one go.

Each search runs in a thread of its own until it asks; when every one of them waits for an answer,
the questions are put together. Which ones those are depends on no timing. One thread runs at a
time: those that vie for the interpreter are slow.
"""

import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, wait

AWAKE = 0.2  # s after which whoever waits looks up

_here = threading.local()  # who this thread is: its crew, and its place among that


def in_step(jobs: list[Callable[[], object]]) -> list:
    """What each of the `jobs` returns, in their order. Raises what the first one raises that does.

    Jobs may call this themselves; theirs go in step with all the others.
    """
    if len(jobs) < 2:
        return [job() for job in jobs]
    crew = getattr(_here, "crew", None)
    return crew.run(jobs, _here.place) if crew else _Crew().run(jobs)


def asked(question, answer: Callable[[list], list]):
    """What `answer` says to `question`, which it is asked together with all others of the step.

    answer(questions) -> an answer to each; the same function for all who go in step.
    """
    crew = getattr(_here, "crew", None)
    return crew.ask(question, answer) if crew else answer([question])[0]


class _Crew:
    """Threads that go in step; daemons, so that nobody waits for them when the process ends."""

    def __init__(self):
        self.lock = threading.Lock()  # of the three that follow
        self.busy = 0  # threads that neither ask nor wait for those that they began
        self.asking = []
        self.stopped = False
        self.turn = threading.Lock()  # whose it is runs

    def run(self, jobs, parent: tuple | None = None) -> list:
        """What the jobs of `parent`, a place in this crew, return; it waits meanwhile.

        Where the waiting is interrupted all that goes in step ends at its next question.
        """
        done, left = [Future() for _ in jobs], [len(jobs)]

        def work(n, job):
            _here.crew, _here.place = self, (*(parent or ()), n)
            with self.turn:
                result, error = _outcome(job)
            with self.lock:
                left[0] -= 1
                # the last one's turn is the parent's again
                self.busy -= not (parent is not None and left[0] == 0)
            done[n].set_exception(error) if error else done[n].set_result(result)
            self._answer()

        def begun():
            for pair in enumerate(jobs):
                threading.Thread(target=work, args=pair, daemon=True).start()
            while wait(done, timeout=AWAKE).not_done:
                pass  # an interrupt that another thread was told of is heard here

        with self.lock:
            self.busy += len(jobs) - (parent is not None)
        try:
            begun() if parent is None else self._meanwhile(begun)
        except BaseException:
            self._stop()
            raise
        return [one.result() for one in done]

    def ask(self, question, answer):
        """What `answer` says to the question."""
        told = Future()
        with self.lock:
            if self.stopped:
                raise CancelledError
            self.asking.append((_here.place, question, answer, told))
            self.busy -= 1
        return self._meanwhile(lambda: self._answer() or told.result())

    def _meanwhile(self, waits):
        """What `waits` returns; others run in the meantime."""
        self.turn.release()
        try:
            return waits()
        finally:
            self.turn.acquire()

    def _answer(self) -> None:
        """All that is asked, if everybody waits for it."""
        with self.lock:
            if self.busy or not self.asking:
                return
            some, self.asking = sorted(self.asking, key=lambda one: one[0]), []
            self.busy = len(some)
        _, questions, answers, told = zip(*some, strict=True)
        results, error = _outcome(lambda: list(zip(told, answers[0](list(questions)), strict=True)))
        for one in told if error else ():
            one.set_exception(error)
        for one, result in results or ():
            one.set_result(result)

    def _stop(self) -> None:
        with self.lock:
            self.stopped = True
            waiting, self.asking = self.asking, []
        for *_, told in waiting:
            told.cancel()


def _outcome(job: Callable[[], object]):
    """What the job returns, and what it raises."""
    try:
        return job(), None
    except BaseException as error:  # noqa: BLE001  (raised again where it is waited for)
        return None, error
