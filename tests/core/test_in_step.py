"""Jobs that go in step ask together, and get what each would have got alone."""

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import core
from core import simulate
from core.effects import air_drag, contact, dry_friction, large_amplitude, stiffness_drift
from core.effects.base import Setting
from core.in_step import asked, in_step
from core.simulate import swing

INTERRUPTED = """
from core.in_step import asked, in_step
import signal, time

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it

def slow(questions):
    time.sleep(0.02)
    return questions

def job(n):
    while True:
        in_step([lambda: asked(n, slow), lambda: asked(-n, slow)]) if n else asked(n, slow)

print("begun", flush=True)
try:
    in_step([lambda: job(0), lambda: job(1), lambda: job(2)])
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


def doubled(seen):
    def answer(questions):
        seen.append(tuple(questions))
        return [2 * question for question in questions]

    return answer


def test_what_is_asked_at_a_time_is_answered_at_once():
    seen = []
    answer = doubled(seen)

    def job(n):
        return [asked(10 * n + turn, answer) for turn in range(n + 1)]

    out = in_step([lambda n=n: job(n) for n in range(3)])
    assert out == [[0], [20, 22], [40, 42, 44]]
    assert seen == [(0, 10, 20), (11, 21), (22,)]  # whoever has ended is not waited for


def test_jobs_within_jobs_go_in_step_with_all():
    seen = []
    answer = doubled(seen)

    def outer(n):
        first = in_step([lambda m=m: asked(10 * n + m, answer) for m in range(2)])
        return [*first, asked(100 + n, answer)]

    assert in_step([lambda n=n: outer(n) for n in range(2)]) == [[0, 2, 200], [20, 22, 202]]
    assert seen == [(0, 1, 10, 11), (100, 101)]


def test_one_who_fails_stops_nobody_and_is_heard_of():
    seen, ended = [], []
    answer = doubled(seen)

    def fails():
        asked(1, answer)
        raise ValueError("this one")

    def goes_on():
        ended.append(asked(2, answer) + asked(3, answer))

    with pytest.raises(ValueError, match="this one"):
        in_step([fails, goes_on])
    assert ended == [10]


def refuse(questions):
    raise ValueError("no")


@pytest.mark.parametrize("answer", [refuse, lambda questions: questions[:1]])
def test_an_answer_that_fails_is_told_to_all_who_asked(answer):
    def job():
        try:
            asked(1, answer)
        except ValueError:
            return "told"

    assert in_step([job, job]) == ["told", "told"]


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
def test_an_interrupt_ends_all_at_once():
    child = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED],
        cwd=Path(core.__file__).parents[1],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert child.stdout.readline() == "begun\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=20)
    assert out == "stopped\n" and child.returncode == 0


def test_whoever_is_interrupted_leaves_nobody_behind():
    begun = threading.active_count()

    def slow(questions):
        time.sleep(0.01)
        return questions

    def breaks():
        asked(1, slow)
        raise KeyboardInterrupt

    out = []

    def outer():
        try:
            in_step([breaks, breaks])
        except KeyboardInterrupt:
            out.append("told")

    in_step([outer, outer])
    assert out == ["told", "told"] and threading.active_count() == begun


def test_alone_one_asks_for_oneself():
    seen = []
    assert asked(4, doubled(seen)) == 8 and seen == [(4,)]


OMEGA = np.array([30.0, 47.0, 95.0])
AMPLITUDE = 0.01


def setting() -> Setting:
    """Three modes with masses, places and a skin of their own."""
    rng = np.random.default_rng(3)
    skin, masses = rng.normal(size=(3, 12)), np.array([1.0, 0.4, 2.5])
    return Setting(
        omega=OMEGA,
        zeta=np.full(3, 0.02),
        couple=np.ones(3),
        places=np.zeros((1, 2)),
        levers=np.ones(1),
        planes=np.zeros((0, 2, 2)),
        skin=skin,
        facing=rng.normal(size=(3, 4)),
        wind=skin.T / 12 * masses,
        amplitude=AMPLITUDE,
        masses=masses,
        modal_mass=0.02,
        drag_area=1e-3,
        duration=4.0,
        reference=np.ones((3, 1)),
    )


MARCHES = {
    "contact": [(contact.ABOVE, (0.4, np.log(2.0), 0.3, -0.5))],
    "friction": [(dry_friction.EFFECT, (0.02, np.log(0.02), 0.7, 0.1))],
    "backbone": [(large_amplitude.EFFECT, (0.05, 0.3, -0.2, 0.4))],
    "drift and friction": [
        (stiffness_drift.EFFECT, (0.1, 0.5)),
        (dry_friction.EFFECT, (0.01, np.log(0.03), 0.2, 0.9)),
    ],
    "friction and drag": [
        (dry_friction.EFFECT, (0.03, np.log(0.01), -0.3, 0.2)),
        (air_drag.EFFECT, (0.2,)),
    ],
    "in a plane and along a line": [
        (dry_friction.IN_PLANE, (0.03, np.log(0.02), 0.3, -0.4, 0.5, 0.2)),
        (large_amplitude.EFFECT, (0.05, 0.3, -0.2, 0.4)),
    ],
}


def marches(place: Setting) -> list:
    """Of other forces, lengths, pitches and sizes of batch."""
    rng = np.random.default_rng(5)

    def march(forces, batch, seconds):
        time = np.broadcast_to(np.linspace(0, seconds, 300), (batch, 300))
        omega = OMEGA * np.linspace(0.98, 1.02, batch)[:, None]
        start = AMPLITUDE * rng.normal(size=(batch, 2, 3)) * [[1.0], [30.0]]
        spread = [(e, np.array(theta) * np.linspace(0.9, 1, batch)[:, None]) for e, theta in forces]
        return lambda: swing(omega, np.full((batch, 3), 0.02), start, time, spread, place)

    return [march(f, 1 + n, 1.0 + 0.4 * n) for n, f in enumerate(MARCHES.values())]


@pytest.mark.parametrize("room", [simulate.ROOM, 1.0])
def test_a_march_of_many_is_that_of_each(room, monkeypatch):
    """To the last digits of a product; `room` for all at once, or for one at a time."""
    monkeypatch.setattr(simulate, "ROOM", room)
    jobs = marches(setting())
    for alone, beside in zip([job() for job in jobs], in_step(jobs), strict=True):
        for one, other in zip(alone, beside, strict=True):
            assert one == pytest.approx(other, rel=1e-9, abs=1e-12)


def test_what_marches_together_needs_no_more_than_there_is_room_for(monkeypatch):
    monkeypatch.setattr(simulate, "ROOM", 100.0)
    groups = simulate._within([60.0, 10.0, 40.0, 10.0, 300.0, 50.0])
    assert sorted(i for group in groups for i in group) == list(range(6))
    assert groups[0] == [4]
    sizes = [60.0, 10.0, 40.0, 10.0, 300.0, 50.0]
    assert all(len(g) == 1 or len(g) * max(sizes[i] for i in g) <= 100 for g in groups)
