"""A marker or a few wander slowly or jump: the tracker lost its grip, not the object its physics.

Law         y_m += a polynomial in time, or a step, in those markers only
Tells       they leave the motion that all others share
Looks like  split_modes when there are few markers; relaxation when one marker dominates
Cannot      be predicted where it wanders at random: then the marker is set aside whole
Source      Baker and Matthews, Int. J. Comput. Vis. 56 (2004) 221: template drift
"""

import numpy as np

from .base import Effect, Parameter

PARTS, FINE_PARTS = 5, 20  # of the record, over each of which a marker wanders evenly
ALONE = 10.0  # times the usual marker's misfit, from which one may be set aside
MOST = 0.3  # of the markers, that go astray
ASTRAY = 3.0  # the same, from which it may be one of a few that go astray


def _bends(time, span, count):
    """Smooth hats (..., T, count) over [0, span], the last of which goes on as a constant."""
    place = np.clip(time / span, 0, 1) * count
    return np.stack([np.clip(place - k, 0, 1) for k in range(count)], axis=-1)


def _of_markers(names: list[str], twins: tuple[str, ...], **hooks) -> Effect:
    """The effect in the markers of these names."""
    return Effect(
        name="tracker_drift",
        layer="camera",
        parameters=(Parameter("markers", "names", 0, 0),),
        twins=twins,
        settle="track again with a larger pattern, or put a better mark there",
        starts=lambda setting, residual: [()],
        report=lambda theta, setting, shape: {"markers": names},
        **hooks,
    )


def wander(markers: tuple[int, ...], names: list[str], *, fine: bool = False) -> Effect:
    """Slow wandering of each of these markers, by slopes over equal parts of the record.

    A few, or `fine` ones that are still no shorter than a swing.
    """

    def parts(setting):
        swings = int(setting.duration * setting.omega[0] / (2 * np.pi))
        return min(max(swings, PARTS), FINE_PARTS) if fine else PARTS

    return _of_markers(
        names,
        ("split_modes",),
        columns=lambda theta, setting, time, u: _bends(time, setting.duration, parts(setting)),
        channels=lambda setting, take: np.isin(take.marker, markers),
    )


def jump(markers: tuple[int, ...], instants: list[float], names: list[str]) -> Effect:
    """A step of these markers at each of the instants (s)."""
    return _of_markers(
        names,
        ("split_modes", "lost_frames"),
        columns=lambda theta, setting, time, u: (time[:, :, None] >= instants).astype(float),
        channels=lambda setting, take: np.isin(take.marker, markers),
    )


def stray(markers: tuple[int, ...], names: list[str], takes: tuple, residuals: tuple) -> Effect:
    """Markers set aside: all that they leave, in each take (T, C), is the tracker's."""
    own = [
        np.where(np.isin(data.marker, markers), np.nan_to_num(left), 0.0)
        for data, left in zip(takes, residuals, strict=True)
    ]
    return _of_markers(
        names,
        ("split_modes",),
        given=lambda take: own[take],
        free=int(
            sum(
                d.fit.sum() * np.isin(d.marker, markers).sum() for d in takes if not d.take.held_out
            )
        ),
    )


def propose(takes: tuple, residuals: tuple, first: int, swings: float) -> list[Effect]:
    """Effects worth a fit: markers whose residual (T, C) stands out in the take `first`, which
    lasts that many swings; the two worst alone, and all that may be astray if most are not.
    """
    data, residual = takes[first], residuals[first]
    size = np.array(
        [
            np.nanmean((residual[:, data.marker == m] / data.sigma[data.marker == m]) ** 2)
            for m in range(data.marker.max() + 1)
        ]
    )
    usual, worst = np.median(size), np.argsort(-size)
    astray = worst[: int((size > ASTRAY * usual).sum())]
    groups = [tuple(worst[:1]), tuple(worst[1:2])]
    if 1 < len(astray) <= MOST * len(size):
        groups.append(tuple(astray))
    found = []
    for group in groups:
        names = sorted(data.take.recording.markers[m].name for m in group)
        found.append(wander(group, names))
        if swings > PARTS:
            found.append(wander(group, names, fine=True))
        steps = [_best_step(residual[:, data.marker == m]) for m in group]
        found.append(jump(group, [float(data.time[at]) for at in steps], names))
        if size[list(group)].min() > ALONE * usual:
            found.append(stray(group, names, takes, residuals))
    return found


def _best_step(values: np.ndarray) -> int:
    """Index of the split of (T, d) into two means that leaves least."""
    y = np.nan_to_num(values - np.nanmean(values, axis=0))
    total, T = np.cumsum(y, axis=0), len(y)
    n = np.arange(1, T)[:, None]
    gain = (total[:-1] ** 2 / n + (total[-1] - total[:-1]) ** 2 / (T - n)).sum(axis=1)
    return int(np.argmax(gain[2:-2])) + 3 if T > 8 else T // 2
