"""Motion of the measured modes with the found effects: exact for what is linear, stepped else."""

import numpy as np

from .effects.base import Setting, State

RUNAWAY = 30.0  # first amplitudes; a motion that has run away stays finite
STEPS_PER_PERIOD = 32  # of the first mode; only added forces see the step, and as its square


def free_swing(omega, zeta, start, time):
    """u, u' (B, T, K) of u'' + 2 z w u' + w^2 u = 0 from start (B, 2, K), at times (B, T)."""
    return _glide(omega, zeta, (start[:, None, 0], start[:, None, 1]), time[:, :, None])


def swing(omega, zeta, start, time, forces: list, setting: Setting):
    """u, u' (B, T, K) and the forces' traces (B, T, F) with `forces` [(effect, theta (B, p)), ...].

    Strang splitting: half a kick, the exact linear flow, half a kick, the two halves between
    steps taken as one with the speed extrapolated to their middle; a step cut short by the same
    rule leads to the instants `time` (B, T). With no force it is `free_swing`.
    """
    if not forces:
        return *free_swing(omega, zeta, start, time), np.zeros((*time.shape, 0))
    step = 2 * np.pi / (STEPS_PER_PERIOD * setting.omega[0])
    count = int(np.ceil(time.max() / step)) + 1
    flow = _flow(omega, zeta, step)
    u, v = start[:, 0].copy(), start[:, 1].copy()
    push = _Push(forces, setting, u)
    half, limit = step / 2, RUNAWAY * setting.amplitude
    rush = limit * setting.omega.max()
    path = np.empty((count + 1, 3, *u.shape))
    kick = push.kick(u, v, 0.0, 0.0)
    path[0] = u, v, kick
    for i in range(count):
        v = v + half * kick
        u, v = flow[0] * u + flow[1] * v, flow[2] * u + flow[3] * v
        _bound(u, limit)
        _bound(v, rush)
        kick = push.kick(u, v + half * kick, (i + 1) * step, step)
        _bound(kick, rush / step)
        v = v + half * kick
        path[i + 1] = u, v, kick
    place = np.minimum((time / step).astype(int), count)
    batch = np.arange(len(time))[:, None]
    rest = (time - place * step)[:, :, None]
    u, v, kick = (path[place, j, batch] for j in range(3))
    u, v = _glide(omega, zeta, (u, v + rest / 2 * kick), rest)
    traces = push.traces()[np.minimum(np.rint(time / step).astype(int), count), batch]
    return u, v + rest / 2 * kick, traces


def _bound(x: np.ndarray, size: float):
    """x within ±size, in place; np.clip takes twice as long on arrays as small as these."""
    np.maximum(x, -size, out=x)
    np.minimum(x, size, out=x)


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

    def kick(self, u, v, t, h):
        total, trace = 0.0, []
        for part in self.parts:
            effect, theta, couple, drive, memory = part
            state = State(u, v, t, h, (u * couple).sum(1), (v * couple).sum(1), memory)
            if effect.force:
                f = effect.force(theta, self.setting, state)
                trace.append(f)
                total = total + f[:, None] * drive
            else:
                total = total + effect.acceleration(theta, self.setting, state)
            part[4] = state.memory
        self.past.append(trace)
        return total

    def traces(self):
        """(N, B, F) forces at the steps."""
        first = self.parts[0][2]
        if not self.past[0]:
            return np.zeros((len(self.past), len(first), 0))
        return np.swapaxes(np.array(self.past), 1, 2)


def _flow(omega, zeta, step):
    """The four (B, K) entries of the linear map over one step."""
    B, K = omega.shape
    out = []
    for unit in ((1.0, 0.0), (0.0, 1.0)):
        start = np.empty((B, 2, K))
        start[:, 0], start[:, 1] = unit
        u, v = free_swing(omega, zeta, start, np.full((B, 1), step))
        out.append((u[:, 0], v[:, 0]))
    return out[0][0], out[1][0], out[0][1], out[1][1]


def _glide(omega, zeta, start, rest):
    """u, u' (B, T, K) after the linear flow over `rest` (B, T, 1) from start (u, v) (B, T, K)."""
    w = (omega * np.sqrt(np.clip(1 - zeta**2, 1e-12, None)))[:, None]
    d, o = (zeta * omega)[:, None], omega[:, None]
    u0, v0 = start
    envelope, cos, sin = np.exp(-d * rest), np.cos(w * rest), np.sin(w * rest)
    u = envelope * (u0 * cos + (v0 + d * u0) / w * sin)
    return u, envelope * (v0 * cos - (o**2 * u0 + d * v0) / w * sin)
