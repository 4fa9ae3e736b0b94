"""Frames dropped or doubled: the recording's time jumps while its count goes on.

Law         t <- t + sum_j n_j T [t >= t_j], n_j whole frames
Tells       a common step in the phases of all modes and markers at one instant
Looks like  tracker_drift when one marker moves much more than the others
Cannot      be predicted: the jumps of the held-out part are read off that part, as time stamps are
Source      Pati, Rezaiifar, Krishnaprasad, Asilomar 1993: the orthogonal pursuit of the jumps
"""

import numpy as np

from .base import Effect, Parameter

MOST = 6  # jumps that are looked for at a time; a recording with more is not worth mending
MUCH = 0.25  # of a take, that its jumps may add up to
SURE = 30.0  # least gain in chi2 of one more jump, over the misfit per sample
EDGE = 4  # samples at either end that cannot tell
STAIRS, ENDS = 3, 25  # jumps that look like stairs, and instants between which those may rise
WHOLE = 0.3  # frames by which what is left of a jump may differ from none


def lost(jumps: tuple[tuple[tuple[float, float], ...], ...], takes: tuple) -> Effect:
    """Known jumps (instant s, seconds gained) of each of the takes (Channels)."""

    def clock(theta, setting, time, take):
        own = next((own for data, own in zip(takes, jumps, strict=True) if data.take is take), ())
        return time + sum(gain * (time >= when) for when, gain in own)

    pairs = zip(takes, jumps, strict=True)
    count = sum(abs(gain) / data.frame for data, own in pairs for _, gain in own)
    return Effect(
        name="lost_frames",
        layer="camera",
        parameters=(Parameter("frames", "count", 0, 1e4, 0.0),),
        twins=(),
        settle="export the clip with its time stamps, or film a running clock",
        starts=lambda setting, residual: [()],
        clock=clock,
        free=2 * sum(map(len, jumps)),
        report=lambda theta, setting, shape: {"frames": round(count)},
    )


def gathered(jumps, more, frame: float) -> tuple[tuple[float, float], ...]:
    """Both lists of jumps as one, those between the same two frames added up."""
    total = {}
    for when, gain in (*jumps, *more):
        after = int(when / frame)  # instants are written rounded, so their sums differ
        first, so_far = total.get(after, (when, 0.0))
        total[after] = first, so_far + gain
    return tuple(sorted((when, gain) for when, gain in total.values() if abs(gain) > 1e-9))


def too_many(jumps, data, most: int = MOST) -> bool:
    """Whether a take (Channels) with more than so many jumps, or so large ones, is not worth
    mending.
    """
    total = sum(abs(gain) for _, gain in jumps)
    return len(jumps) > most or total > MUCH * (data.time[-1] - data.time[0])


def is_whole(frames: float) -> bool:
    """Whether a jump is of a whole number of frames, and not of none."""
    return bool(round(frames)) and abs(frames - round(frames)) < WHOLE


def next_jumps(seen: "Sight") -> list[tuple[float, float]]:
    """Instants (s) and lengths (frames, not yet whole) of the jumps that a residual shows."""
    chosen, gains, left = [], np.zeros(0), seen.residual
    least = SURE * max(float(np.mean(left**2)), 1.0)  # misfit beyond noise is coloured
    while len(chosen) < MOST:
        score = np.cumsum((left * seen.step).sum(axis=1)[::-1])[::-1] ** 2
        score = np.where(
            seen.power > 1e-6 * seen.power.max(), score / np.maximum(seen.power, 1e-300), 0
        )
        score[:EDGE] = score[-EDGE:] = 0
        at = int(np.argmax(score))
        if score[at] < least or at in chosen:
            break
        chosen.append(at)
        gains, left = seen.gains(chosen)
    return [(float(seen.time[at]), g) for at, g in zip(chosen, gains, strict=True)]


class Sight:
    """A residual (T, C) beside what a jump by one frame would do to it, in noise units.

    A jump by g adds g y'(t) to all later samples; what `basis` (T, b) can take up, a channel at a
    time, tells nothing and is taken off.
    """

    def __init__(self, data, predicted: np.ndarray, basis: np.ndarray):
        residual = data.values - predicted
        use = ~np.isnan(residual).any(axis=1)
        speed = np.gradient(predicted, data.time, axis=0)
        self.time, self.frame = data.time[use] - data.frame / 2, data.frame
        self.step = speed[use] / data.sigma * data.frame
        self.q, _ = np.linalg.qr(basis[use])
        self.residual = residual[use] / data.sigma
        self.residual = self.residual - self.q @ (self.q.T @ self.residual)
        late = np.cumsum((self.q[:, :, None] * self.step[:, None])[::-1], axis=0)[::-1]
        whole = np.cumsum((self.step**2).sum(axis=1)[::-1])[::-1]
        self.power = whole - (late**2).sum(axis=(1, 2))  # of a jump at every instant

    def gains(self, places: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Frames (j,) of jumps at these samples, and the residual (T, C) without them."""
        after = np.arange(len(self.time))[:, None] >= places
        steps = after[:, :, None] * self.step[:, None]  # (T, j, C)
        inner = np.einsum("tb,tjc->bjc", self.q, steps)
        steps = steps - np.einsum("tb,bjc->tjc", self.q, inner)
        columns = np.moveaxis(steps, 1, 2).reshape(-1, len(places))
        y = self.residual.ravel()
        gains, *_ = np.linalg.lstsq(columns, y, rcond=None)
        return gains, (y - columns @ gains).reshape(self.residual.shape)

    def is_ramp(self, jumps) -> bool:
        """Whether these jumps are the stairs that a clock makes which goes wrong from one instant
        to another, as a pitch does that is another one for that long: without them the residual
        bears that out so far that the numbers of all the jumps are not worth it.
        """
        if len(jumps) < STAIRS:
            return False
        whole = np.round([gain / self.frame for _, gain in jumps])
        stairs = (np.arange(len(self.time))[:, None] >= self._places(jumps)) @ whole
        y = self.residual + self._seen(stairs)
        ends = np.linspace(self.time[0], self.time[-1], ENDS)
        left = np.inf
        for n, begin in enumerate(ends):
            for end in ends[n + 1 :]:
                column = self._seen(np.clip((self.time - begin) / (end - begin), 0, 1))
                taken = (column * y).sum() ** 2 / max((column**2).sum(), 1e-300)
                left = min(left, float((y**2).sum() - taken))
        known = float((self.residual**2).sum())
        price = (2 * len(jumps) - 3) * np.log(y.size) * max(known / y.size, 1.0)
        return left < known + price

    def _seen(self, late: np.ndarray) -> np.ndarray:
        """(T, C) what a clock that is late (T,) frames does, but for what the basis takes up."""
        moved = self.step * late[:, None]
        return moved - self.q @ (self.q.T @ moved)

    def _places(self, jumps) -> list[int]:
        """Samples from which they are seen."""
        return [int(np.argmin(np.abs(self.time - when))) for when, _ in jumps]

    def left_of(self, jumps) -> np.ndarray:
        """Frames (j,) of each of these jumps that are left in the residual."""
        return self.gains(self._places(jumps))[0]
