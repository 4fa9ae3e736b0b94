"""Takes that lack samples: of markers that are hidden by turns, and of such as were soon lost."""

import numpy as np

from .data import Case, Take, replace

WHOLE = 0.5  # share of the frames, from which those that show all markers are enough
FEWEST = 24  # frames in which a marker must be seen where a take is fitted, or
SEEN = 0.5  # this share of them, if that is less
FITTED = 2 / 3  # of a take, where none is held out


def bridged(values: np.ndarray, told: np.ndarray, use=slice(None), slow: np.ndarray | None = None):
    """Samples (T, C), NaN where missing, and which frames (T,) have all of them; where these are
    too few of those to `use`, what is missing as `told` (T, C), but for what wanders as the columns
    of `slow` (T, q) do, a constant by itself, and all frames.
    """
    seen = np.isfinite(values)
    whole = seen.all(axis=1)
    if whole[use].mean() >= WHOLE:
        return values, whole
    slow = np.ones((len(values), 1)) if slow is None else slow
    filled = values.copy()
    for c, known in enumerate(seen.T):
        rows = np.zeros(len(values), bool)
        rows[use] = known[use]
        off, *_ = np.linalg.lstsq(slow[rows], values[rows, c] - told[rows, c], rcond=None)
        filled[~known, c] = (told[:, c] + slow @ off)[~known]
    return filled, np.ones(len(values), bool)


def without_lost(case: Case) -> Case:
    """The case without the markers that hardly a frame shows of what is fitted in one of its takes,
    which warnings name; as it is where none would be left.

    Where a marker rests is told by what is fitted alone.
    """
    part = 1.0 if any(take.held_out for take in case.takes) else FITTED
    seen = [_seen(take, part) for take in case.takes]
    lost = np.any(
        [few for take, (few, _) in zip(case.takes, seen, strict=True) if not take.held_out], axis=0
    )
    on = np.array([marker.on == "object" for marker in case.takes[0].recording.markers])
    if not lost.any() or (lost | ~on).all():
        return case
    takes = [
        _only(take, ~lost, [] if take.held_out else told)
        for take, (_, told) in zip(case.takes, seen, strict=True)
    ]
    return replace(case, takes=tuple(takes))


def _seen(take: Take, part: float) -> tuple[np.ndarray, list[str]]:
    """(n,) which markers of a take too few frames show in that part of it, and a line on each."""
    recording = take.recording
    first = -np.inf if recording.start is None else recording.start
    last = np.inf if recording.stop is None else recording.stop
    rows = np.flatnonzero((recording.time >= first) & (recording.time <= last))
    rows = rows[: round(part * len(rows))]
    count = np.isfinite(recording.values[rows]).all(axis=2).sum(axis=0)
    few = count < min(FEWEST, SEEN * len(rows))
    lines = [
        f"{take.name}: the marker {recording.markers[n].name} is seen in {count[n]} of the "
        f"{len(rows)} frames that are fitted, and was left out. Track it on to use it."
        for n in np.flatnonzero(few)
    ]
    return few, lines


def _only(take: Take, kept: np.ndarray, lines: list[str]) -> Take:
    """The take with these markers (n,) only, and more warnings."""
    recording = take.recording
    markers = [marker for marker, on in zip(recording.markers, kept, strict=True) if on]
    sigma = None if recording.sigma is None else recording.sigma[:, kept]
    recording = replace(
        recording,
        values=recording.values[:, kept],
        markers=tuple(markers),
        sigma=sigma,
        warnings=(*recording.warnings, *lines),
    )
    return replace(take, recording=recording)
