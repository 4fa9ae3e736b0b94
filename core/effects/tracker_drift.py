"""A marker wanders slowly or jumps: the tracker lost its grip, not the object its physics.

Law         y_m += a polynomial in time, or a step, in one marker only
Tells       one marker leaves the motion that all others share
Looks like  split_modes when there are few markers; relaxation when one marker dominates
Cannot      be predicted where it wanders at random: then the marker is set aside whole
Source      Baker and Matthews, Int. J. Comput. Vis. 56 (2004) 221: template drift
"""

import numpy as np

from .base import Effect, Parameter

PARTS, FINE_PARTS = 5, 20  # of the record, over each of which a marker wanders evenly
ALONE = 10.0  # times the usual marker's misfit, from which one may be set aside


def _bends(time, span, count):
    """Smooth hats (..., T, count) over [0, span], the last of which goes on as a constant."""
    place = np.clip(time / span, 0, 1) * count
    return np.stack([np.clip(place - k, 0, 1) for k in range(count)], axis=-1)


def _of_marker(name: str, twins: tuple[str, ...], **hooks) -> Effect:
    """The effect in the marker called `name`."""
    return Effect(
        name="tracker_drift",
        layer="camera",
        parameters=(Parameter("markers", "names", 0, 0),),
        twins=twins,
        settle="track again with a larger pattern, or put a better mark there",
        starts=lambda setting, residual: [()],
        report=lambda theta, setting, shape: {"markers": [name]},
        **hooks,
    )


def wander(marker: int, name: str, *, fine: bool = False) -> Effect:
    """Slow wandering of one marker, by slopes over equal parts of the record.

    A few, or `fine` ones that are still no shorter than a swing.
    """

    def parts(setting):
        swings = int(setting.duration * setting.omega[0] / (2 * np.pi))
        return min(max(swings, PARTS), FINE_PARTS) if fine else PARTS

    return _of_marker(
        name,
        ("split_modes",),
        columns=lambda theta, setting, time, u: _bends(time, setting.duration, parts(setting)),
        channels=lambda setting, take: take.marker == marker,
    )


def jump(marker: int, when: float, name: str) -> Effect:
    """A step of one marker at the instant `when` (s)."""
    return _of_marker(
        name,
        ("split_modes", "lost_frames"),
        columns=lambda theta, setting, time, u: (time >= when)[:, :, None].astype(float),
        channels=lambda setting, take: take.marker == marker,
    )


def stray(marker: int, name: str, takes: tuple, residuals: tuple) -> Effect:
    """One marker set aside: all that it leaves, in each take (T, C), is the tracker's."""
    own = [
        np.where(data.marker == marker, np.nan_to_num(left), 0.0)
        for data, left in zip(takes, residuals, strict=True)
    ]
    return _of_marker(
        name,
        ("split_modes",),
        given=lambda take: own[take],
        free=int(sum(d.fit.sum() * (d.marker == marker).sum() for d in takes)),
    )


def propose(takes: tuple, residuals: tuple, first: int, swings: float) -> list[Effect]:
    """Effects worth a fit: markers whose residual (T, C) stands out in the take `first`, which
    lasts that many swings.
    """
    data, residual = takes[first], residuals[first]
    size = np.array(
        [
            np.nanmean((residual[:, data.marker == m] / data.sigma[data.marker == m]) ** 2)
            for m in range(data.marker.max() + 1)
        ]
    )
    worst = np.argsort(-size)[:2]
    found = []
    for m in worst:
        name = data.take.recording.markers[m].name
        found.append(wander(int(m), name))
        if swings > PARTS:
            found.append(wander(int(m), name, fine=True))
        at = _best_step(residual[:, data.marker == m])
        found.append(jump(int(m), float(data.time[at]), name))
        if size[m] > ALONE * np.median(size):
            found.append(stray(int(m), name, takes, residuals))
    return found


def _best_step(values: np.ndarray) -> int:
    """Index of the split of (T, d) into two means that leaves least."""
    y = np.nan_to_num(values - np.nanmean(values, axis=0))
    total, T = np.cumsum(y, axis=0), len(y)
    n = np.arange(1, T)[:, None]
    gain = (total[:-1] ** 2 / n + (total[-1] - total[:-1]) ** 2 / (T - n)).sum(axis=1)
    return int(np.argmax(gain[2:-2])) + 3 if T > 8 else T // 2
