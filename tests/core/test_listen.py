"""From a take to its free motion: frames that still saw the object held are left out."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import recorded
from core.data import Marker, Recording, Take
from core.errors import RecordingError
from core.listen import listen

FPS, FREQUENCY, DAMPING_RATIO, NOISE = 81.0, 3.0, 0.05, 0.003
SWINGS = np.array([[1.0, 0.2, 0.1], [0.7, 0.1, 0.0], [0.5, -0.2, 0.1]])


def held_then_free(held: int, seed: int) -> Take:
    """Markers that leave their places only after `held` frames."""
    time = np.arange(240) / FPS
    since = np.maximum(time - held / FPS, 0)
    omega = 2 * np.pi * FREQUENCY
    swing = np.exp(-DAMPING_RATIO * omega * since) * (
        np.cos(omega * since) + DAMPING_RATIO * np.sin(omega * since)
    )
    values = swing[:, None, None] * SWINGS
    values = values + NOISE * np.random.default_rng(seed).standard_normal(values.shape)
    markers = tuple(Marker(f"m{n}", position=(0.1 * n, 0, 0.1)) for n in range(3))
    return Take(Recording(time, values, markers, capture_fps=FPS))


@pytest.mark.parametrize("held", [0, 1, 2, 3])
def test_frames_that_saw_the_object_held_are_left_out_and_no_others(held):
    """At the top of a slow swing a frame more is hardly seen; what free motion may be stays."""
    for seed in range(4):
        take = held_then_free(held, seed)
        free, ring = listen(take, lambda time, signals: (0.0, time[-1]))
        late = len(take.recording.time) - len(free.time)
        assert held - 1 <= late <= held
        assert ring.damping_ratio[0] == pytest.approx(DAMPING_RATIO, rel=0.03)


def test_frames_before_a_blow_are_left_out_though_a_pole_that_dies_at_once_tells_them():
    """Three frames at rest, a hundred and seventy a swing: they lie on a line, not on a swing."""
    time = np.arange(2400) / FPS
    since = np.maximum(time - 3 / FPS, 0)
    omega = 2 * np.pi * FPS / 170
    for seed in range(4):
        swing = np.exp(-0.017 * omega * since) * np.sin(omega * since)
        values = swing[:, None, None] * SWINGS
        values = values + 2 * NOISE * np.random.default_rng(seed).standard_normal(values.shape)
        markers = tuple(Marker(f"m{n}", position=(0.1 * n, 0, 0.1)) for n in range(3))
        take = Take(Recording(time, values, markers, capture_fps=FPS))
        free, ring = listen(take, lambda time, signals: (0.0, time[-1]))
        assert 2 <= len(time) - len(free.time) <= 3
        assert len(ring.frequency) == 1


def test_a_marker_that_nobody_tracked_is_not_believed_beyond_the_others():
    """Written as it rests, or rounded to where it stays: its last digit must outweigh no motion."""
    take = held_then_free(0, 5)
    values = take.recording.values.copy()
    values[:, 2] = [0.2, 0.0, 0.1]
    markers = (*take.recording.markers[:2], Marker("foot", (0.2, 0, 0.1), on="support"))
    take = replace(take, recording=replace(take.recording, values=values, markers=markers))
    free, _ = listen(take, lambda time, signals: (0.0, time[-1]))
    usual = np.median(free.sigma[~free.support])
    assert usual == pytest.approx(NOISE, rel=0.2)
    assert (free.sigma[free.support] > 1e-4 * usual).all()


def test_of_takes_that_are_refused_the_first_one_is_told(monkeypatch):
    """Whichever of them is heard first."""
    monkeypatch.setattr(recorded, "side_by_side", lambda jobs: [job() for job in jobs[::-1]][::-1])
    rng, still = np.random.default_rng(1), held_then_free(0, 0)
    takes = [
        replace(
            still,
            name=name,
            recording=replace(still.recording, values=NOISE * rng.standard_normal((240, 3, 3))),
        )
        for name in ("one", "two")
    ]
    body = SimpleNamespace(case=SimpleNamespace(takes=takes))
    with pytest.raises(RecordingError, match="recording one"):
        recorded.recorded(body, lambda time, signals: (0.0, time[-1]))


@dataclass(frozen=True)
class Filmed:
    """A case, or a body, that stands in for one with takes."""

    takes: tuple = ()
    case: object = None


@pytest.mark.parametrize("held_out", [False, True])
def test_a_later_take_that_cannot_be_heard_is_left_out_and_told(held_out):
    """A body let go too softly stands still at once where it is rubbed; the others tell enough."""
    rng, moves = np.random.default_rng(1), held_then_free(0, 0)
    noise = NOISE * rng.standard_normal((240, 3, 3))
    still = replace(
        moves, name="two", recording=replace(moves.recording, values=noise), held_out=held_out
    )
    takes = (replace(moves, name="one"), still, replace(moves, name="three"))
    kept, pairs = recorded._usable(
        Filmed(case=Filmed(takes=takes)), lambda time, signals: (0.0, time[-1])
    )
    assert [take.name for take in kept.case.takes] == ["one", "three"]
    assert [data.take for data, _ in pairs] == list(kept.case.takes)
    (line,) = kept.case.takes[0].recording.warnings
    assert line.startswith("recording two: no oscillation") and "without it" in line
    assert ("last third" in line) is held_out


def test_a_case_whose_first_take_cannot_be_heard_is_refused():
    rng, moves = np.random.default_rng(1), held_then_free(0, 0)
    noise = NOISE * rng.standard_normal((240, 3, 3))
    still = replace(moves, name="one", recording=replace(moves.recording, values=noise))
    with pytest.raises(RecordingError, match="recording one"):
        recorded._usable(
            Filmed(case=Filmed(takes=(still, moves))), lambda time, signals: (0.0, time[-1])
        )


def test_held_frames_are_left_out_beside_what_acts_later():
    """A marker that jumps leaves far more than the held frames do; they stand out all the same."""
    for seed in range(4):
        take = held_then_free(3, seed)
        values = take.recording.values.copy()
        values[90:, 1] += 0.2
        jumped = replace(take, recording=replace(take.recording, values=values))
        free, _ = listen(jumped, lambda time, signals: (0.0, time[-1]))
        assert 2 <= len(take.recording.time) - len(free.time) <= 3


def test_a_marker_seen_just_often_enough_is_heard():
    """A frame less, and no inversion would be possible."""
    for seed in range(3):
        take = held_then_free(1, seed)
        values = take.recording.values.copy()
        values[4:152, 0] = np.nan  # of the 160 frames that are fitted 12 are left
        free, ring = listen(
            replace(take, recording=replace(take.recording, values=values)),
            lambda time, signals: (0.0, time[-1]),
        )
        assert len(free.time) == len(take.recording.time)
        assert ring.frequency[0] == pytest.approx(FREQUENCY, rel=0.01)
