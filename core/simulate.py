"""Motion of the measured modes with the found effects: exact for what is linear, stepped else."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .effects.base import FINE, Carried, Setting, is_one
from .in_step import asked
from .march import stepped

COARSE = 16  # steps per period of the first mode, while it is only sought which force is there
UNFELT = ("steps", "pitches", "pose", "carried")  # what forces are not told, or a take at a time
ROOM = 30e6  # numbers of a march's path: 240 MB
NEAR = 8192  # numbers of each array that are worked on at a time: they stay near at hand
HIGHEST = 3  # steps per period of the highest mode: at two, the kicks would be in step with it


def free_swing(omega, zeta, start, time, speeds: bool = True):
    """u, u' (B, T, K) of u'' + 2 z w u' + w^2 u = 0 from start (B, 2, K), at times (B, T); None
    for u' without `speeds`.
    """
    begin = start[:, None, 0], start[:, None, 1]
    return _glide(omega, zeta, begin, time[:, :, None], speeds)


@dataclass(frozen=True, eq=False)
class _Asked:
    """What is asked of `swing`, as it has it."""

    omega: np.ndarray  # (B, K) rad/s natural
    zeta: np.ndarray  # (B, K)
    start: np.ndarray  # (B, 2, K) m, m/s
    time: np.ndarray  # (B, T) s
    forces: list  # [(effect, theta (B, p)), ...]
    setting: Setting
    speeds: bool
    beside: Carried | None

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
        return self.steps, self.omega.shape[1], id(self.beside), *one


def swing(  # noqa: PLR0913  (what a motion is, and what is asked of it)
    omega, zeta, start, time, forces: list, setting: Setting, speeds: bool = True, beside=None
):
    """u, u' (B, T, K) and the forces' traces (B, T, F) with `forces` [(effect, theta (B, p)), ...];
    None for u' without `speeds`.

    Marched in steps (`march.py`), of which one cut short leads to the instants `time` (B, T). With
    no force it is `free_swing`. High modes may need more steps than `setting` says; they get FINE
    at most. Searches that go in step march as one: a step costs hardly more for many motions than
    for one. `beside`: what the forces feel besides, which is no part of u.
    """
    if not forces:
        return *free_swing(omega, zeta, start, time, speeds), np.zeros((*time.shape, 0))
    return asked(_Asked(omega, zeta, start, time, forces, setting, speeds, beside), _marched)


def _marched(all_of: list[_Asked]) -> list:
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


def _in_one(group: list[_Asked]):
    """u, u' and traces of each, of one march of all."""
    setting = group[0].setting
    omega, zeta, start = (
        np.concatenate([getattr(one, name) for one in group]) for name in ("omega", "zeta", "start")
    )
    step = 2 * np.pi / (group[0].steps * setting.omega[0])
    count = int(np.ceil(max(one.time.max() for one in group) / step)) + 1
    ends = np.cumsum([0, *(len(one.omega) for one in group)])
    rows = [slice(a, b) for a, b in pairwise(ends)]
    forces = [(where, one.forces) for where, one in zip(rows, group, strict=True)]
    beside = group[0].beside and group[0].beside.at(step, count)
    path, traces = stepped(_flow(omega, zeta, step), start, forces, setting, step, count, beside)
    for one, where, own in zip(group, rows, traces, strict=True):
        yield _seen(one, path[..., where], step, own)


def _seen(one: _Asked, path, step: float, traces):
    """What `swing` returns, of a march's path (N, 3, K, B) and traces (N, B)."""
    at = one.time[:1] if len(one.time) > 1 and is_one(one.time) else one.time
    batch = np.arange(len(one.time))[: len(at), None]
    place = np.minimum((at / step).astype(int), len(path) - 1)
    nearest = np.minimum(np.rint(at / step).astype(int), len(path) - 1)
    if len(at) < len(one.time):  # the same instants for all
        u, v = _on(one, path, place[0], at[0] - place[0] * step)
        traces = [trace[nearest[0]].T for trace in traces]
        return u, v, np.stack(traces, axis=2) if traces else np.zeros((*one.time.shape, 0))
    u, v, kick = (path[place, j, :, batch] for j in range(3))
    traces = [trace[nearest, batch] for trace in traces]
    rest = (at - place * step)[:, :, None]
    u, v = _glide(one.omega, one.zeta, (u, v + rest / 2 * kick), rest)
    none = np.zeros((*one.time.shape, 0))
    return u, v + rest / 2 * kick, np.stack(traces, axis=2) if traces else none


def _on(one: _Asked, path, place, rest):
    """u, u' (B, T, K), views, from a path (N, 3, K, B) at steps `place` (T,) so much earlier,
    `rest` (T,) s; None for u' where that is not asked.
    """
    waves = _Waves((one.omega * np.sqrt(np.clip(1 - one.zeta**2, 1e-12, None))).T,
                   (one.zeta * one.omega).T)  # fmt: skip
    out = np.empty((2 if one.speeds else 1, len(place), *one.omega.T.shape))
    part = max(NEAR // one.omega.size, 1)
    for some in (slice(a, a + part) for a in range(0, len(place), part)):
        u, v, kick = np.moveaxis(path[place[some]], 1, 0)
        kick *= (rest[some] / 2)[:, None, None]
        v += kick
        for of_u, of_v, there in zip(*waves.flow(rest[some], one.speeds), out, strict=True):
            np.multiply(of_u, u, out=there[some])
            of_v *= v
            there[some] += of_v
        if one.speeds:
            out[1, some] += kick
    u, *v = np.moveaxis(out, 3, 1)
    return u, v[0] if v else None


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
        own[n], other[n] = ends[n], ends[1 - n]
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
    if len(rest) > 1 and is_one(rest):
        return tuple(np.swapaxes(part, 0, 1) for part in _Waves(w, d).at(rest[0, :, 0]))
    envelope, phase = np.exp(-d[:, None] * rest), w[:, None] * rest
    return envelope * np.cos(phase), envelope * np.sin(phase)


class _Waves:
    """exp(-d t) cos(w t) and exp(-d t) sin(w t) for w, d (*).

    Neighbours in a batch mostly differ in other things than these; each pair is worked out once.
    """

    def __init__(self, w, d):
        pairs, of = np.unique(np.ravel(w + 1j * d), return_inverse=True)
        self.each, self.of = 1j * pairs.real - pairs.imag, of.reshape(w.shape)

    def at(self, rest):
        """Both (T, *) at `rest` (T,)."""
        wave = np.exp(np.multiply.outer(rest, self.each))
        return wave.real[:, self.of], wave.imag[:, self.of]

    def flow(self, rest, speeds: bool = True):
        """What u and u' (T, *) give to u `rest` (T,) later, and with `speeds` to u': two lists."""
        wave = np.exp(np.multiply.outer(rest, self.each))
        cos, sin, w, d = wave.real, wave.imag, self.each.imag, -self.each.real
        sin = sin / w
        of_u, of_v = [cos + d * sin], [sin]
        if speeds:
            of_u.append(-(w**2 + d**2) * sin)
            of_v.append(cos - d * sin)
        return [p[:, self.of] for p in of_u], [p[:, self.of] for p in of_v]
