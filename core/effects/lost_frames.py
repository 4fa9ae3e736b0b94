"""Frames dropped or doubled: the recording's time jumps while its count goes on.

Law         t <- t + sum_j n_j T [t >= t_j], n_j whole frames
Tells       a common step in the phases of all modes and markers at one instant
Looks like  tracker_drift when one marker moves much more than the others
Source      the format's own time stamps, where a container keeps them
"""

import numpy as np

from .base import Effect, Parameter

MOST = 4  # jumps that are looked for; a recording with more is not worth mending


def lost(jumps: tuple[tuple[float, float], ...], frame: float) -> Effect:
    """Known jumps (instant s, seconds gained)."""

    def clock(theta, setting, time):
        return time + sum(gain * (time >= when) for when, gain in jumps)

    return Effect(
        name="lost_frames",
        layer="camera",
        parameters=(Parameter("frames", "count", 0, 1e4),),
        twins=(),
        settle="export the clip with its time stamps, or film a running clock",
        starts=lambda setting, residual: [()],
        clock=clock,
        report=lambda theta, setting, shape: {
            "frames": round(sum(abs(gain) for _, gain in jumps) / frame)
        },
    )


def next_jump(data, residual: np.ndarray, speed: np.ndarray) -> tuple[float, float] | None:
    """The instant and the whole number of frames (in s) whose jump takes most of the residual.

    `residual`, `speed` (T, C): a jump by g adds g y'(t) to all later samples.
    """
    use = data.fit & ~np.isnan(residual).any(axis=1)
    r, s = residual[use] / data.sigma, speed[use] / data.sigma
    late_rs = np.cumsum((r * s).sum(axis=1)[::-1])[::-1]
    late_ss = np.cumsum((s * s).sum(axis=1)[::-1])[::-1] + 1e-300
    gain = late_rs**2 / late_ss
    gain[:3] = gain[-3:] = 0
    at = int(np.argmax(gain))
    frames = np.round(late_rs[at] / late_ss[at] / data.frame)
    if frames == 0:
        frames = np.sign(late_rs[at])
    return float(data.time[use][at]) - data.frame / 2, float(frames * data.frame)
