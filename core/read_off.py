"""Effects made from what a fit leaves: wandering markers, lost frames, a shaken support."""

from dataclasses import replace
from functools import partial

import numpy as np

from .baseline import px_per_metre
from .carried import carrying
from .channels import reaches
from .effects import base_motion, tracker_drift
from .effects.base import Effect
from .in_step import in_step
from .jumps import jumps
from .law import TimeFit
from .refit import put
from .timefit import fit

BELOW = 0.8  # of the strongest mode's pitch, up to which a body's answer to its support is told
ROUNDS = 3  # in which a shared motion is read off anew
CLEARLY = 0.02  # of the misfit, that a shared motion must take which is read off anew
REFITTED = 5  # looks of a fit with it: what it took for a pitch must turn back


def read_off(start: TimeFit) -> list[Effect]:
    """Effects that are made from what a fit leaves."""
    law, out = start.law, []
    data = law.takes[law.fitted[0]]
    if len(np.unique(data.marker[~data.support])) >= 3:
        left = tuple(
            np.zeros_like(t.values) if t.take.held_out else t.values - p
            for t, p in zip(law.takes, start.predicted, strict=True)
        )
        swings = law.setting.duration * law.setting.omega[0] / (2 * np.pi)
        out += tracker_drift.propose(law.takes, left, law.fitted[0], swings)
    out += jumps(start)
    return out + (shared_motions(start) if _common_is_possible(start, data) else [])


def shared_motions(start: TimeFit) -> list[Effect]:
    """What all markers share of what a fit leaves, as the camera or the support may move."""
    law = start.law
    data, residual = law.takes[law.fitted[0]], start.missed(0)
    shared = _likeliest(start)
    frames = sum(int(law.takes[index].fit.sum()) for index in law.fitted)
    free = frames * data.take.recording.values.shape[2]
    own = data.support if data.support.any() else slice(None)
    rms = base_motion.size(data, residual) / px_per_metre(data, own)
    paths = base_motion.support_paths(law.takes)
    answering = [base_motion.shaken(shared, rms, free, one) for one in paths]
    return [base_motion.shaken(shared, rms, free), *_answered(start, free), *answering]


def _likeliest(start: TimeFit) -> tuple[np.ndarray, ...]:
    """What the markers of every take share, (T, C): of a camera that turns, or of one or a support
    that goes aside, whichever leaves less.
    """
    takes = start.law.takes
    left = [t.values - p for t, p in zip(takes, start.predicted, strict=True)]

    def shared(data, rest, aside: bool):
        if not _is_read(data):
            return np.zeros_like(data.values)
        return base_motion.common_motion(data, rest, reaches(data)[aside])

    def misses(motions) -> float:
        rests = zip(takes, left, motions, strict=True)
        return sum(np.nansum(((rest - own) / t.sigma)[t.fit] ** 2) for t, rest, own in rests)

    pairs = list(zip(takes, left, strict=True))
    ways = [tuple(shared(*pair, aside) for pair in pairs) for aside in (False, True)]
    return min(ways, key=misses)


def read_anew(found: TimeFit, effects: int) -> TimeFit:
    """The fit with a shared motion among its last so many effects read off anew beside the others,
    as long as clearly less is left: read before, it holds a share of what they do.
    """
    for _ in range(ROUNDS if effects > 1 else 0):
        own = found.law.effects
        last = range(len(own) - effects, len(own))
        at = next((i for i in last if own[i].name == base_motion.NAME), None)
        if at is None:
            break
        bare = tuple(p - own[at].given(n) for n, p in enumerate(found.predicted))
        anew = [
            effect
            for effect in shared_motions(replace(found, predicted=bare))
            if bool(effect.columns) == bool(own[at].columns)
        ]
        fits = in_step([partial(_in_place, found, at, effect) for effect in anew])
        best = min(fits, key=lambda one: one.chi2)
        if best.chi2 > (1 - CLEARLY) * found.chi2:
            break
        found = best
    return found


def _in_place(found: TimeFit, at: int, effect: Effect) -> TimeFit:
    """Fitted again with another effect in the place of one that is read off, too."""
    law, (start,) = put(found, at, effect, [()])
    return carrying(fit(law, start, evaluations=REFITTED))


def _answered(start: TimeFit, free: int) -> list[Effect]:
    """A support that moves, of which no marker tells, as the computed body answers to it."""
    law = start.law
    seen_at, channels = law.setting.support, law.takes[law.fitted[0]].values.shape[1]
    if seen_at is None or any(t.support.any() or t.values.shape[1] != channels for t in law.takes):
        return []
    low = BELOW * law.setting.omega[0] / (2 * np.pi)
    shared, sizes = [], []
    for data, predicted in zip(law.takes, start.predicted, strict=True):
        if not _is_read(data):
            shared.append(np.zeros_like(data.values))
            continue
        moved, size = base_motion.answered_motion(data, data.values - predicted, seen_at, low)
        shared.append(moved)
        sizes.append(size)
    return [base_motion.shaken(tuple(shared), sizes[0], free)]


def _is_read(data) -> bool:
    """Whether a shared motion is taken off a take: off one that is held out where markers on the
    support show it, for what is but missing from a prediction is shared too.
    """
    return not data.take.held_out or bool(data.support.any())


def _common_is_possible(start: TimeFit, data) -> bool:
    """A marker on the support shows it; else the markers must not sit together."""
    if data.support.any():
        return True
    markers = np.unique(data.marker)
    size = [np.linalg.norm(start.shapes[0][data.marker == m]) for m in markers]
    return len(markers) >= 3 and min(size) < 0.35 * max(size)
