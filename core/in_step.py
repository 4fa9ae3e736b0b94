"""Searches that go in step: what all of them ask for at a time is worked out in one go.

Each search runs in a thread of its own until it asks; when every one of them waits for an answer,
the questions are put together. Which ones those are depends on no timing, so neither do results.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

_here = threading.local()  # who this thread is: its crew, and its place among that


def in_step(jobs: list[Callable[[], object]]) -> list:
    """What each of the `jobs` returns, in their order. Raises what the first one raises that does.

    Jobs may call this themselves; theirs go in step with all the others.
    """
    crew = getattr(_here, "crew", None)
    if len(jobs) < 2:
        return [job() for job in jobs]
    return (crew or _Crew()).run(jobs, _here.place if crew else None)


def asked(question, answer: Callable[[list], list]):
    """What `answer` says to `question`, which it is asked together with all others of the step.

    answer(questions) -> an answer to each; the same function for all who go in step.
    """
    crew = getattr(_here, "crew", None)
    return crew.ask(question, answer) if crew else answer([question])[0]


class _Crew:
    """Threads that go in step."""

    def __init__(self):
        self.lock = threading.Lock()
        self.turn = threading.Lock()  # one at a time: threads that vie for the interpreter are slow
        self.busy = 0  # threads that neither ask nor wait for those that they began
        self.asking = []

    def run(self, jobs, parent: tuple | None) -> list:
        """What the jobs of `parent`, a place in this crew, return."""
        left = [len(jobs)]

        def work(n, job):
            _here.crew, _here.place = self, (*(parent or ()), n)
            try:
                with self.turn:
                    return job()
            finally:
                with self.lock:
                    left[0] -= 1
                    # the last one's turn is the parent's again
                    self.busy -= not (parent is not None and left[0] == 0)
                self._answer()

        with self.lock:
            self.busy += len(jobs) - (parent is not None)
        if parent is not None:
            self.turn.release()
        with ThreadPoolExecutor(len(jobs)) as threads:
            done = [threads.submit(work, *pair) for pair in enumerate(jobs)]
        if parent is not None:
            self.turn.acquire()
        return [one.result() for one in done]

    def ask(self, question, answer):
        one = _here.place, question, answer, Future()
        with self.lock:
            self.asking.append(one)
            self.busy -= 1
        self.turn.release()
        self._answer()
        try:
            return one[-1].result()
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
        try:
            results = answers[0](list(questions))
        except Exception as error:  # noqa: BLE001  (raised where they were asked)
            for one in told:
                one.set_exception(error)
        else:
            for one, result in zip(told, results, strict=True):
                one.set_result(result)
