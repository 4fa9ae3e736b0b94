"""Motion of the measured modes with the found effects: exact for what is linear, stepped else."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .effects.base import FINE, Setting, State
from .in_step import asked

RUNAWAY = 30.0  # first amplitudes; a motion that has run away stays finite
OFTEN = 8  # steps between two looks at it; between them it goes on
COARSE = 16  # steps per period of the first mode, while it is only sought which force is there
UNFELT = ("steps", "pitches", "pose")  # what a setting says to others than forces
ROOM = 30e6  # numbers of a march's path: 240 MB
HIGHEST = 3  # steps per period of the highest mode: at two, the kicks would be in step with it


def free_swing(omega, zeta, start, time, speeds: bool = True):
    """u, u' (B, T, K) of u'' + 2 z w u' + w^2 u = 0 from start (B, 2, K), at times (B, T); None
    for u' without `speeds`.
    """
    begin = start[:, None, 0], start[:, None, 1]
    return _glide(omega, zeta, begin, time[:, :, None], speeds)


@dataclass(frozen=True, eq=False)
class _March:
    """What is asked of `swing`, as it has it."""

    omega: np.ndarray  # (B, K) rad/s natural
    zeta: np.ndarray  # (B, K)
    start: np.ndarray  # (B, 2, K) m, m/s
    time: np.ndarray  # (B, T) s
    forces: list  # [(effect, theta (B, p)), ...]
    setting: Setting
    speeds: bool

    @property
    def steps(self) -> float:
        """Per period of the first mode; high modes may need more than the setting says."""
        omega = self.setting.omega
        return max(self.setting.steps, min(HIGHEST * omega.max() / omega[0], FINE))

    @property
    def size(self) -> float:
        """Numbers of its path."""
        span = self.time.max() * self.setting.omega[0] / (2 * np.pi)
        return 3 * span * self.steps * self.omega.size

    @property
    def kin(self) -> tuple:
        """The same for all that may march together."""
        said = {k: v for k, v in vars(self.setting).items() if k not in UNFELT}
        one = [v if v is None or np.isscalar(v) else id(v) for v in said.values()]
        return self.steps, self.omega.shape[1], *one


def swing(  # noqa: PLR0913  (what a motion is, and what is asked of it)
    omega, zeta, start, time, forces: list, setting: Setting, speeds: bool = True
):
    """u, u' (B, T, K) and the forces' traces (B, T, F) with `forces` [(effect, theta (B, p)), ...];
    None for u' without `speeds`.

    Strang splitting: half a kick, the exact linear flow, half a kick, the two halves between
    steps taken as one with the speed extrapolated to their middle; a step cut short by the same
    rule leads to the instants `time` (B, T). With no force it is `free_swing`. High modes may
    need more steps than `setting` says; they get FINE at most. Searches that go in step march as
    one: a step costs hardly more for many motions than for one.
    """
    if not forces:
        return *free_swing(omega, zeta, start, time, speeds), np.zeros((*time.shape, 0))
    return asked(_March(omega, zeta, start, time, forces, setting, speeds), _marched)


def _marched(all_of: list[_March]) -> list:
    """What `swing` returns of each."""
    out, kinds = [None] * len(all_of), {}
    for n, one in enumerate(all_of):
        kinds.setdefault(one.kin, []).append(n)
    for kind in kinds.values():
        for group in _within([all_of[n].size for n in kind]):
            some = [kind[i] for i in group]
            for n, motion in zip(some, _in_one([all_of[n] for n in some]), strict=True):
                out[n] = motion
    return out


def _within(sizes: list[float]) -> list[list[int]]:
    """Indices of those that may march together, by what one of them needs; one at least."""
    groups, most = [], ROOM
    for i in sorted(range(len(sizes)), key=lambda i: -sizes[i]):
        if groups and len(groups[-1]) < most:
            groups[-1].append(i)
        else:  # the longest first: all of a group march as far as that
            groups.append([i])
            most = ROOM // max(sizes[i], 1)
    return groups


def _in_one(group: list[_March]):
    """u, u' and traces of each, of one march of all."""
    setting = group[0].setting
    omega, zeta, start = (
        np.concatenate([getattr(one, name) for one in group]) for name in ("omega", "zeta", "start")
    )
    step = 2 * np.pi / (group[0].steps * setting.omega[0])
    count = int(np.ceil(max(one.time.max() for one in group) / step)) + 1
    own, other = _flow(omega, zeta, step)
    push = _Push(group, count)
    limit = np.empty_like(own)
    limit[:] = RUNAWAY * setting.amplitude * np.array([1.0, setting.omega.max()])[:, None, None]
    lower = -limit
    most = np.full_like(own[0], limit[1, 0, 0] / step)
    least, halved = -most, np.full_like(most, step / 2)
    # Few calls a step, of arrays of one shape: half of the time of one on numbers so few is its
    # scalars' and its broadcasting's.
    path = np.empty((count + 1, 3, *omega.T.shape))  # u, u', kick
    path[0, :2] = np.moveaxis(start, 0, 2)
    push.kick(path[0, :2], 0, 0.0, path[0, 2])
    half = halved * path[0, 2]
    ahead, across = np.array(path[0, :2]), np.empty_like(own)
    place, speed, swapped = ahead[0], ahead[1], ahead[::-1]
    speed += half
    for i in range(count):
        state, kick = path[i + 1, :2], path[i + 1, 2]
        u, v = state
        np.multiply(own, ahead, state)
        np.multiply(other, swapped, across)
        np.add(state, across, state)
        if i % OFTEN == 0:
            np.maximum(state, lower, state)
            np.minimum(state, limit, state)
        place[:] = u
        np.add(v, half, speed)
        push.kick(ahead, i + 1, step, kick)
        np.maximum(kick, least, kick)
        np.minimum(kick, most, kick)
        np.multiply(kick, halved, half)
        np.add(v, half, v)
        np.add(v, half, speed)
    for one, rows in zip(group, push.rows, strict=True):
        yield _seen(one, path[..., rows], step, push.traces(one, rows))


def _seen(one: _March, path, step: float, traces):
    """What `swing` returns, of a march's path (N, 3, K, B) and traces (F, N, B)."""
    at = one.time[:1] if len(one.time) > 1 and not np.ptp(one.time, axis=0).any() else one.time
    batch = np.arange(len(one.time))[: len(at), None]
    place = np.minimum((at / step).astype(int), len(path) - 1)
    nearest = np.minimum(np.rint(at / step).astype(int), len(path) - 1)
    if len(at) < len(one.time):  # the same instants for all
        u, v = _on(one, path[place[0]], at[0] - place[0] * step)
        traces = [trace[nearest[0]].T for trace in traces]
        return u, v, np.stack(traces, axis=2) if traces else np.zeros((*one.time.shape, 0))
    u, v, kick = (path[place, j, :, batch] for j in range(3))
    traces = [trace[nearest, batch] for trace in traces]
    rest = (at - place * step)[:, :, None]
    u, v = _glide(one.omega, one.zeta, (u, v + rest / 2 * kick), rest)
    none = np.zeros((*one.time.shape, 0))
    return u, v + rest / 2 * kick, np.stack(traces, axis=2) if traces else none


def _on(one: _March, states, rest):
    """u, u' (B, T, K), views, from states (T, 3, K, B) at steps so much earlier, `rest` (T,) s."""
    u, v, kick = states[:, 0], states[:, 1], states[:, 2]
    w = (one.omega * np.sqrt(np.clip(1 - one.zeta**2, 1e-12, None))).T
    d = (one.zeta * one.omega).T
    cos, sin = _wave(w, d, rest)
    half = kick
    half *= (rest / 2)[:, None, None]
    v += half
    across = d * u
    across += v
    across /= w
    across *= sin
    place = cos * u
    place += across
    if not one.speeds:
        return np.moveaxis(place, 2, 0), None
    across = one.omega.T**2 * u
    across += d * v
    across /= w
    across *= sin
    v *= cos
    v -= across
    v += half
    return np.moveaxis(place, 2, 0), np.moveaxis(v, 2, 0)


class _Push:
    """All added forces along one march."""

    def __init__(self, group: list[_March], count: int):
        ends = np.cumsum([0, *(len(one.omega) for one in group)])
        self.rows = [slice(a, b) for a, b in pairwise(ends)]
        self.parts, self.past = [], {}
        setting, whose = group[0].setting, {}
        for one, rows in zip(group, self.rows, strict=True):
            for effect, theta in one.forces:
                whose.setdefault(effect, []).append((rows, theta))
        for effect, some in whose.items():
            at = np.concatenate([np.arange(rows.start, rows.stop) for rows, _ in some])
            theta = np.concatenate([theta for _, theta in some])
            if at[-1] - at[0] + 1 == len(at):
                at = slice(at[0], at[-1] + 1)
            if not effect.force:
                self.parts.append((at, effect.acceleration(theta, setting), None))
                continue
            couple = np.zeros((effect.axes, len(setting.omega), len(theta)))
            couple[0, 0] = 1.0
            couple[:, 1:] = np.reshape(theta[:, len(effect.low) :].T, (effect.axes, -1, len(theta)))
            past = self.past[effect] = np.zeros((effect.axes, count + 1, ends[-1]))
            drive = couple * setting.masses[:, None]
            if effect.axes == 1:
                alone = len(couple[0]) == 1  # one mode moves every place alike
                couple, drive = None if alone else np.repeat(couple, 2, axis=0), drive[0]
            own = effect.axes, couple, drive, past
            self.parts.append((at, effect.force(theta, setting), own))

    def kick(self, state, i: int, h: float, out) -> None:
        """Put the acceleration (K, B) by all forces in `state` (2, K, B) at step `i` of `h` s into
        `out`.
        """
        out[:] = 0.0
        for at, push, own in self.parts:
            here = state[..., at]
            u, v = here
            if own is None:
                out[:, at] += push(State(u, v, i * h, h, u[0], v[0]))
                continue
            axes, couple, drive, past = own
            if axes > 1:
                x, dx = np.einsum("skb,wkb->swb", here, couple)
                f = past[:, i, at] = push(State(u, v, i * h, h, x, dx))
                out[:, at] += np.einsum("wb,wkb->kb", f, drive)
                continue
            x, dx = here[:, 0] if couple is None else np.add.reduce(here * couple, axis=1)
            f = past[0, i, at] = push(State(u, v, i * h, h, x, dx))
            out[:, at] += f * drive

    def traces(self, one: _March, rows: slice) -> list:
        """[(N, B), ...] forces of one of them at the steps."""
        paths = [self.past[effect] for effect, _ in one.forces if effect.force]
        return [path[:, rows] for both in paths for path in both]


def _flow(omega, zeta, step):
    """The linear map over one step: what u and u' give to themselves and to each other, (2, K, B)
    each.
    """
    B, K = omega.shape
    own, other = np.empty((2, 2, K, B))
    for n, unit in enumerate(((1.0, 0.0), (0.0, 1.0))):
        start = np.empty((B, 2, K))
        start[:, 0], start[:, 1] = unit
        ends = [end[:, 0].T for end in free_swing(omega, zeta, start, np.full((B, 1), step))]
        own[n], other[1 - n] = ends[n], ends[1 - n]
    return own, other


def _glide(omega, zeta, start, rest, speeds: bool = True):
    """u, u' (B, T, K) after the linear flow over `rest` (B, T, 1) from start (u, v) (B, T, K)."""
    w, d, o = omega * np.sqrt(np.clip(1 - zeta**2, 1e-12, None)), zeta * omega, omega[:, None]
    cos, sin = _waves(w, d, rest)
    w, d = w[:, None], d[:, None]
    u0, v0 = start
    u = cos * u0 + sin * ((v0 + d * u0) / w)
    return u, cos * v0 - sin * ((o**2 * u0 + d * v0) / w) if speeds else None


def _waves(w, d, rest):
    """exp(-d t) cos(w t) and exp(-d t) sin(w t) (B, T, K) for w, d (B, K) at `rest` (B, T, 1)."""
    if len(rest) > 1 and not np.ptp(rest, axis=0).any():
        return tuple(np.swapaxes(part, 0, 1) for part in _wave(w, d, rest[0, :, 0]))
    envelope, phase = np.exp(-d[:, None] * rest), w[:, None] * rest
    return envelope * np.cos(phase), envelope * np.sin(phase)


def _wave(w, d, rest):
    """The same (T, *) for w, d (*) at `rest` (T,).

    Neighbours in a batch mostly differ in other things than these; each pair is worked out once.
    """
    pairs, of = np.unique(np.ravel(w + 1j * d), return_inverse=True)
    wave = np.exp(np.multiply.outer(rest, 1j * pairs.real - pairs.imag))
    of = of.reshape(w.shape)
    return wave.real[:, of], wave.imag[:, of]
