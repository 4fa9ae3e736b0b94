"""Motion of the measured modes with the found effects: exact for what is linear, stepped else."""

import numpy as np

from .effects.base import FINE, Setting, State

RUNAWAY = 30.0  # first amplitudes; a motion that has run away stays finite
OFTEN = 8  # steps between two looks at it; between them it goes on
COARSE = 16  # steps per period of the first mode, while it is only sought which force is there
HIGHEST = 3  # steps per period of the highest mode: at two, the kicks would be in step with it


def free_swing(omega, zeta, start, time):
    """u, u' (B, T, K) of u'' + 2 z w u' + w^2 u = 0 from start (B, 2, K), at times (B, T)."""
    return _glide(omega, zeta, (start[:, None, 0], start[:, None, 1]), time[:, :, None])


def swing(omega, zeta, start, time, forces: list, setting: Setting):
    """u, u' (B, T, K) and the forces' traces (B, T, F) with `forces` [(effect, theta (B, p)), ...].

    Strang splitting: half a kick, the exact linear flow, half a kick, the two halves between
    steps taken as one with the speed extrapolated to their middle; a step cut short by the same
    rule leads to the instants `time` (B, T). With no force it is `free_swing`. High modes may
    need more steps than `setting` says; they get FINE at most.
    """
    if not forces:
        return *free_swing(omega, zeta, start, time), np.zeros((*time.shape, 0))
    steps = max(setting.steps, min(HIGHEST * setting.omega.max() / setting.omega[0], FINE))
    step = 2 * np.pi / (steps * setting.omega[0])
    count = int(np.ceil(time.max() / step)) + 1
    by_place, by_speed = _flow(omega, zeta, step)
    push = _Push(forces, setting, start[:, 0])
    limit = RUNAWAY * setting.amplitude * np.array([1.0, setting.omega.max()])[:, None, None]
    most = limit[1, 0, 0] / step
    path = np.empty((count + 1, 3, *omega.shape))  # u, u', kick; few calls a step, for speed
    path[0, :2] = np.swapaxes(start, 0, 1)
    path[0, 2] = push.kick(path[0, :2], 0.0, 0.0)
    half = step / 2 * path[0, 2]
    for i in range(count):
        u, v, _ = path[i]
        state = path[i + 1, :2]
        np.multiply(by_place, u, out=state)
        state += by_speed * (v + half)
        if i % OFTEN == 0:
            np.maximum(state, -limit, out=state)
            np.minimum(state, limit, out=state)
        ahead = state.copy()
        ahead[1] += half
        kick = path[i + 1, 2]
        np.maximum(push.kick(ahead, (i + 1) * step, step), -most, out=kick)
        np.minimum(kick, most, out=kick)
        half = step / 2 * kick
        state[1] += half
    place = np.minimum((time / step).astype(int), count)
    batch = np.arange(len(time))[:, None]
    rest = (time - place * step)[:, :, None]
    u, v, kick = (path[place, j, batch] for j in range(3))
    u, v = _glide(omega, zeta, (u, v + rest / 2 * kick), rest)
    traces = push.traces()[np.minimum(np.rint(time / step).astype(int), count), batch]
    return u, v + rest / 2 * kick, traces


class _Push:
    """All added forces along one march, with what each remembers."""

    def __init__(self, forces, setting: Setting, u):
        self.setting, self.past, self.parts = setting, [], []
        K = u.shape[1]
        for effect, theta in forces:
            memory = effect.begin(theta, setting, u) if effect.begin else None
            couple = np.ones_like(u)
            if effect.force and K > 1:
                couple[:, 1:] = theta[:, len(effect.low) :]
            drive = couple * setting.masses
            self.parts.append([effect, theta, couple, drive, memory])

    def kick(self, state, t, h):
        """(B, K) acceleration by all forces in `state` (2, B, K)."""
        total, trace = 0.0, []
        u, v = state
        for part in self.parts:
            effect, theta, couple, drive, memory = part
            if effect.force:
                x, dx = np.add.reduce(state * couple, axis=2)
                seen = State(u, v, t, h, x, dx, memory)
                f = effect.force(theta, self.setting, seen)
                trace.append(f)
                total = total + f[:, None] * drive
            else:
                seen = State(u, v, t, h, u[:, 0], v[:, 0], memory)
                total = total + effect.acceleration(theta, self.setting, seen)
            part[4] = seen.memory
        self.past.append(trace)
        return total

    def traces(self):
        """(N, B, F) forces at the steps."""
        first = self.parts[0][2]
        if not self.past[0]:
            return np.zeros((len(self.past), len(first), 0))
        return np.swapaxes(np.array(self.past), 1, 2)


def _flow(omega, zeta, step):
    """The linear map over one step: what u and what u' give to both, each (2, B, K)."""
    B, K = omega.shape
    out = []
    for unit in ((1.0, 0.0), (0.0, 1.0)):
        start = np.empty((B, 2, K))
        start[:, 0], start[:, 1] = unit
        u, v = free_swing(omega, zeta, start, np.full((B, 1), step))
        out.append(np.array([u[:, 0], v[:, 0]]))
    return out


def _glide(omega, zeta, start, rest):
    """u, u' (B, T, K) after the linear flow over `rest` (B, T, 1) from start (u, v) (B, T, K)."""
    w, d, o = omega * np.sqrt(np.clip(1 - zeta**2, 1e-12, None)), zeta * omega, omega[:, None]
    cos, sin = _waves(w, d, rest)
    w, d = w[:, None], d[:, None]
    u0, v0 = start
    u = cos * u0 + sin * ((v0 + d * u0) / w)
    return u, cos * v0 - sin * ((o**2 * u0 + d * v0) / w)


def _waves(w, d, rest):
    """exp(-d t) cos(w t) and exp(-d t) sin(w t) (B, T, K) for w, d (B, K) at `rest` (B, T, 1).

    Neighbours in a batch mostly differ in other things than these; each pair is worked out once.
    """
    if len(rest) > 1 and not np.ptp(rest, axis=0).any():
        pairs, of = np.unique(np.ravel(w + 1j * d), return_inverse=True)
        wave = np.exp(np.multiply.outer(rest[0, :, 0], 1j * pairs.real - pairs.imag))
        of = of.reshape(w.shape)
        return tuple(np.swapaxes(part[:, of], 0, 1) for part in (wave.real, wave.imag))
    envelope, phase = np.exp(-d[:, None] * rest), w[:, None] * rest
    return envelope * np.cos(phase), envelope * np.sin(phase)
