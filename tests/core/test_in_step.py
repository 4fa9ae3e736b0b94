"""Jobs that go in step ask together, and get what each would have got alone."""

import threading

import numpy as np
import pytest

from core.effects import air_drag, contact, dry_friction, large_amplitude, stiffness_drift
from core.in_step import asked, in_step
from core.simulate import swing
from tests.core.test_simulate import AMPLITUDE, OMEGA, setting


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
    assert threading.active_count() == 1


def test_an_answer_that_fails_is_told_to_all_who_asked():
    def answer(questions):
        raise ZeroDivisionError

    def job():
        try:
            asked(1, answer)
        except ZeroDivisionError:
            return "told"

    assert in_step([job, job]) == ["told", "told"]


def test_alone_one_asks_for_oneself():
    seen = []
    assert asked(4, doubled(seen)) == 8 and seen == [(4,)]


MARCHES = {
    "contact": [(contact.ABOVE, (0.4, np.log(2.0)))],
    "friction": [(dry_friction.EFFECT, (0.02, np.log(0.02)))],
    "backbone": [(large_amplitude.EFFECT, (0.05, 0.3))],
    "drift and friction": [
        (stiffness_drift.EFFECT, (0.1, 0.5)),
        (dry_friction.EFFECT, (0.01, np.log(0.03))),
    ],
    "friction and drag": [
        (dry_friction.EFFECT, (0.03, np.log(0.01))),
        (air_drag.EFFECT, (0.2,)),
    ],
}


def test_a_march_of_many_is_that_of_each():
    """Of other forces, lengths, pitches and sizes of batch; to the last digits of a product."""
    place, rng = setting(0.02), np.random.default_rng(5)

    def march(forces, batch, seconds):
        time = np.broadcast_to(np.linspace(0, seconds, 300), (batch, 300))
        omega = OMEGA * np.linspace(0.98, 1.02, batch)[:, None]
        start = AMPLITUDE * np.stack([np.ones((batch, 1)), rng.normal(size=(batch, 1))], axis=1)
        spread = [(e, np.array(theta) * np.linspace(0.9, 1, batch)[:, None]) for e, theta in forces]
        return lambda: swing(omega, np.full((batch, 1), 0.02), start, time, spread, place)

    jobs = [march(f, 1 + n, 1.0 + 0.4 * n) for n, f in enumerate(MARCHES.values())]
    for alone, beside in zip([job() for job in jobs], in_step(jobs), strict=True):
        for one, other in zip(alone, beside, strict=True):
            assert one == pytest.approx(other, rel=1e-9, abs=1e-12)
