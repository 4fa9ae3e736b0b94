"""Effects made from what a fit leaves: wandering markers, lost frames, a shaken support."""

from functools import partial

import numpy as np

from .baseline import px_per_metre
from .effects import base_motion, lost_frames, tracker_drift
from .effects.base import Effect
from .in_step import in_step
from .law import TimeFit
from .refit import instead
from .timefit import extend, fit


def read_off(start: TimeFit) -> list[Effect]:
    """Effects that are made from what a fit leaves."""
    law, out = start.law, []
    data = law.takes[law.fitted[0]]
    residual = data.values - start.predicted[law.fitted[0]]
    if len(np.unique(data.marker[~data.support])) >= 3:
        left = tuple(
            t.values - p if p is not None else 0 * t.values
            for t, p in zip(law.takes, start.predicted, strict=True)
        )
        swings = law.setting.duration * law.setting.omega[0] / (2 * np.pi)
        out += tracker_drift.propose(law.takes, left, law.fitted[0], swings)
    if len(law.fitted) == 1 and np.isfinite(residual).all(axis=1).sum() > 12:
        out += _jumps(start, data)
    if _common_is_possible(start, data):
        shared = tuple(
            base_motion.common_motion(t, t.values - p) if p is not None else 0 * t.values
            for t, p in zip(law.takes, start.predicted, strict=True)
        )
        free = int(data.fit.sum()) * data.take.recording.values.shape[2]
        rms = base_motion.size(data, residual) / px_per_metre(data)
        out.append(base_motion.shaken(shared, rms, free))
        if data.support.any() and len(law.takes) == 1:
            out.append(base_motion.shaken(shared, rms, free, base_motion.support_path(data)))
    return out


def _jumps(start: TimeFit, data) -> list[Effect]:
    """The one effect whose jumps, all whole frames, the residual shows, if it shows any."""
    jumps, found = (), start
    for _ in range(3):
        seen = _sight(found, data)
        more = [(when, round(g) * data.frame) for when, g in lost_frames.next_jumps(seen)]
        if not any(gain for _, gain in more):
            break
        jumps = lost_frames.gathered(jumps, more, data.frame)
        found = _with_jumps(start, jumps, data)
    for at in range(len(jumps)):
        when, gap = jumps[at]
        moved = [
            (*jumps[:at], (when + shift * data.frame, gap), *jumps[at + 1 :])
            for shift in (-2, -1, 1, 2)
        ]
        effects = [lost_frames.lost(one, data.frame) for one in moved]
        better = in_step([partial(instead, found, effect) for effect in effects])
        left = [one.chi2 if one else np.inf for one in better]
        if min(left) < found.chi2:
            jumps, found = moved[int(np.argmin(left))], better[int(np.argmin(left))]
    jumps = lost_frames.gathered(jumps, (), data.frame)  # two that were moved together may be none
    if not jumps or not _sight(found, data).are_whole(jumps):
        return []
    return [lost_frames.lost(jumps, data.frame)]


def _with_jumps(start: TimeFit, jumps, data) -> TimeFit:
    law, p = extend(start, (lost_frames.lost(jumps, data.frame),), [()])
    return fit(law, p, evaluations=2)


def _sight(found: TimeFit, data) -> lost_frames.Sight:
    index = found.law.fitted[0]
    u, s = found.motions[0], data.time[:, None] / data.time[-1]
    v = np.gradient(u, data.time, axis=0) / found.law.setting.omega
    basis = np.hstack([u, v, s * u, s * v, np.ones((len(u), 1))])
    return lost_frames.Sight(data, found.predicted[index], basis)


def _common_is_possible(start: TimeFit, data) -> bool:
    """A marker on the support shows it; else the markers must not sit together."""
    if data.support.any():
        return True
    markers = np.unique(data.marker)
    size = [np.linalg.norm(start.shapes[0][data.marker == m]) for m in markers]
    return len(markers) >= 3 and min(size) < 0.35 * max(size)
