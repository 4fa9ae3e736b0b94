"""A batch of motions in steps, each mode an exact linear swing that added forces kick.

Law         u'' + 2 zeta omega u' + omega^2 u = kick of every mode
Steps       half a kick, the exact flow, half a kick (Strang, SIAM J. Numer. Anal. 5 (1968) 506);
            the two halves between steps are one, with the speed extrapolated to their middle
"""

from collections.abc import Iterable

import numpy as np

from .effects.base import Effect, Setting, State

RUNAWAY = 30.0  # first amplitudes; a motion that has run away stays finite
OFTEN = 8  # steps between two looks at it; between them it goes on

Force = tuple[Effect, np.ndarray]  # the effect, its parameters (B, p)


def stepped(  # noqa: PLR0913  (what a motion is, and what acts on it)
    flow: tuple[np.ndarray, np.ndarray],
    start: np.ndarray,
    forces: Iterable[tuple[slice, list[Force]]],
    setting: Setting,
    step: float,
    count: int,
    beside: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[np.ndarray, list[list[np.ndarray]]]:
    """The path (N, 3, K, B) of motions, u (m), u' (m/s) and the kick (m/s2) at N = `count` + 1
    steps of `step` s; and of each of the `forces` the traces [(N, b), ...] of those that act at a
    place, one for each axis.

    flow: what u and u' (2, K, B) give to themselves, and to each other, over a step; start
    (B, 2, K); forces: those on some of the motions each; beside: u and u' (N, K) that these feel
    besides, and that are no part of the path.
    """
    own, other = flow
    now = _Now(np.moveaxis(start, 0, 2), beside)
    lines, theirs, pushes = _lines_of(now, forces, setting, count)
    shape = own[0].shape
    most = np.full(shape, RUNAWAY * setting.amplitude * setting.omega.max() / step)
    least, halved, half = -most, np.full(shape, step / 2), np.zeros(shape)
    limit = np.empty_like(own)
    limit[:] = RUNAWAY * setting.amplitude * np.array([1.0, setting.omega.max()])[:, None, None]
    # Few calls a step, of whole arrays of one shape: of numbers so few, one that broadcasts or
    # has a scalar, or reads every other number, takes twice the time of one that does not.
    ahead, kept, given = np.array(now.motion), np.empty_like(own), np.empty_like(own)
    (u0, v0), (u_of_u, v_of_v), (v_of_u, u_of_v) = ahead, kept, given
    path = np.empty((count + 1, 3, *shape))
    for i in range(count + 1):
        u, v, kick = path[i]
        if i:
            np.multiply(own, ahead, kept)
            np.multiply(other, ahead, given)
            np.add(u_of_u, u_of_v, u)
            np.add(v_of_v, v_of_u, v)
            if i % OFTEN == 0:
                np.clip(path[i, :2], -limit, limit, path[i, :2])
            now.goes_on(i, step, u, np.add(v, half, now.speed))
        _kick(now, lines, pushes, kick)
        np.maximum(kick, least, kick)
        np.minimum(kick, most, kick)
        np.multiply(kick, halved, half)
        if i:
            np.add(v, half, v)
        else:
            u[:], v[:] = u0, v0
        u0[:] = u
        np.add(v, half, v0)
    return path, [_traces(rows, some) for rows, some in theirs]


def _traces(rows: slice, lines: list["_Line"]) -> list[np.ndarray]:
    """[(N, b), ...] of the forces along these lines, one for each axis."""
    paths = [line.path[..., rows] for line in lines]
    return [p for q in paths for p in ([q] if q.ndim == 2 else np.moveaxis(q, 1, 0))]


def _kick(now: "_Now", lines: list["_Line"], pushes: list, out) -> None:
    """Put the acceleration (K, B) by all forces on the motions as they are now into `out`."""
    if lines:
        lines[0].push(out)
        for line in lines[1:]:
            line.push(now.spare)
            np.add(out, now.spare, out)
    else:
        out[:] = 0.0
    for state, push in pushes:
        out[:, state.at] += push(state)


class _Now:
    """The motions at one step: u (K, B) m, and u' (m/s) in the middle of the kick."""

    def __init__(self, motion, beside):
        self.motion = np.array(motion)
        self.u, self.v = self.motion
        self.spare, self.speed = np.empty_like(self.u), np.empty_like(self.u)
        self.i, self.t, self.h = 0, 0.0, 0.0
        self._beside = beside
        if beside is not None:
            self.u, self.v = (a + b[0][:, None] for a, b in zip(self.motion, beside, strict=True))

    def goes_on(self, i: int, step: float, u, v) -> None:
        if self._beside is not None:
            u, v = (a + b[i][:, None] for a, b in zip((u, v), self._beside, strict=True))
        self.i, self.t, self.h, self.u, self.v = i, i * step, step, u, v


class _Line:
    """One force, or none, at a place on each of the motions: along a line, or in a plane."""

    def __init__(self, now: _Now, axes: int, count: int):
        K, B = now.u.shape
        self.now, self.axes, self.parts = now, axes, []
        several = () if axes == 1 else (axes,)
        self.couple, self.path = np.zeros((*several, K, B)), np.zeros((count + 1, *several, B))
        self._work, self.drive = np.empty_like(self.couple), None
        self._x, self._dx, self._far, self._fast = None, None, -1, -1  # and the steps they are of
        self._alone, self.pushes = axes == 1 and K == 1, []  # of one mode every place moves alike

    def act(self, rows: np.ndarray, effect: Effect, theta) -> None:
        """Let a force act on the motions `rows`."""
        self.parts.append((rows, effect, theta))

    def begin(self, setting: Setting) -> None:
        """All is known that acts: those of one effect are pushed as one."""
        whose = {}
        for part in self.parts:
            whose.setdefault(part[1], []).append(part)
        for effect, some in whose.items():
            rows = np.concatenate([rows for rows, _, _ in some])
            theta = np.concatenate([theta for _, _, theta in some])
            place = theta[:, len(effect.low) :].T
            couple = np.zeros((self.axes, len(self.now.u), len(rows)))
            couple[0, 0] = 1.0
            couple[:, 1:] = place.reshape(self.axes, -1, len(rows))
            self.couple[..., rows] = couple if self.axes > 1 else couple[0]
            self.pushes.append((_Part(self.now, self, _at(rows)), effect.force(theta, setting)))
        self.drive = self.couple * setting.masses[:, None]

    @property
    def x(self):
        """(B,) or (axes, B) m, how far the places are; worked out where it is asked for."""
        if self._far != self.now.i:
            self._far = self.now.i
            self._x = self._there(self.now.u)
        return self._x

    @property
    def dx(self):
        """The same, m/s."""
        if self._fast != self.now.i:
            self._fast = self.now.i
            self._dx = self._there(self.now.v)
        return self._dx

    def _there(self, motion):
        if self._alone:
            return motion[0]
        np.multiply(motion, self.couple, self._work)
        return np.add.reduce(self._work, -2)

    def push(self, out) -> None:
        """Put the acceleration (K, B) by its forces into `out`."""
        f = self.path[self.now.i]
        for part, push in self.pushes:
            f[..., part.at] = push(part)
        if self.axes == 1:
            np.multiply(f, self.drive, out)
        else:
            np.multiply(f[:, None], self.drive, self._work)
            np.add.reduce(self._work, 0, None, out)


class _Part(State):
    """Some of the motions now, `at` these, with the line that a force acts along."""

    def __init__(self, now: _Now, line: _Line | None, at):
        self._now, self._line, self.at = now, line, at

    @property
    def t(self):
        return self._now.t

    @property
    def h(self):
        return self._now.h

    @property
    def u(self):
        return self._now.u[:, self.at]

    @property
    def v(self):
        return self._now.v[:, self.at]

    @property
    def x(self):
        return self._line.x[..., self.at]

    @property
    def dx(self):
        return self._line.dx[..., self.at]


def _at(rows: np.ndarray):
    """The same as a slice, where they follow one another."""
    follow = rows[-1] - rows[0] + 1 == len(rows)
    return slice(int(rows[0]), int(rows[-1]) + 1) if follow else rows


def _lines_of(now: _Now, forces, setting: Setting, count: int) -> tuple[list, list, list]:
    """Lines, in which all forces at places act; which motions have which of them; and
    [(_Part, push), ...] of all other forces.
    """
    lines, theirs, whole = [], [], {}
    for rows, some in forces:
        numbers, free, own = np.arange(rows.start, rows.stop), list(lines), []
        for effect, theta in some:
            if not effect.force:
                whole.setdefault(effect, []).append((numbers, theta))
                continue
            line = next((line for line in free if line.axes == effect.axes), None)
            if line is None:
                line = _Line(now, effect.axes, count)
                lines.append(line)
            else:
                free.remove(line)
            line.act(numbers, effect, theta)
            own.append(line)
        theirs.append((rows, own))
    for line in lines:
        line.begin(setting)
    pushes = []
    for effect, some in whole.items():
        rows = np.concatenate([rows for rows, _ in some])
        theta = np.concatenate([theta for _, theta in some])
        pushes.append((_Part(now, None, _at(rows)), effect.acceleration(theta, setting)))
    return lines, theirs, pushes
