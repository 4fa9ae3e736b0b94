"""Markers that were lost, or found, so that too few frames show them of what is fitted."""

import numpy as np

from .channels import FITTED
from .data import Case, Take, replace
from .errors import RecordingError
from .listen import ENOUGH, release

FEWEST, SEEN = 24, 0.25  # frames that must show a marker there, or this share of them, but ENOUGH
MOST = 0.5  # of the markers on the object, that a later take may lack without being refused


def without_lost(case: Case, find_release) -> Case:
    """The case without the markers that too few frames show of what is fitted in one of its takes,
    which warnings name; as it is where none on the object would be left.

    Where a marker rests is told by what is fitted alone. A later take that lacks most of them is
    left to what refuses it.
    """
    on = np.array([marker.on == "object" for marker in case.takes[0].recording.markers])
    few = np.array([_too_few(take, find_release) for take in case.takes])
    few[1:][few[1:, on].mean(axis=1) > MOST] = False
    lost = few.any(axis=0)
    if not lost.any() or (lost | ~on).all():
        return case
    takes = [
        _only(take, ~lost, _lines(take, own)) for take, own in zip(case.takes, few, strict=True)
    ]
    return replace(case, takes=tuple(takes))


def _too_few(take: Take, find_release) -> np.ndarray:
    """(n,) which markers of a take too few frames show of what is fitted."""
    recording = take.recording
    none = np.zeros(len(recording.markers), bool)
    if take.held_out:
        return none
    try:
        begin, end = release(take, find_release)
    except RecordingError:  # which says more when the take is heard
        return none
    after = recording.time - begin
    rows = (after >= 0) & (after <= FITTED * (end - begin))
    least = max(ENOUGH, min(FEWEST, SEEN * rows.sum()))
    return np.isfinite(recording.values[rows]).all(axis=2).sum(axis=0) < least


def _lines(take: Take, few: np.ndarray) -> list[str]:
    return [
        f"{take.name}: the marker {take.recording.markers[n].name} is seen in too few of the "
        "frames that are fitted, and was left out of all takes. Track it there to use it."
        for n in np.flatnonzero(few)
    ]


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
