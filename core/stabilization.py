"""Which poles stay where they are, whatever order is asked of the pencil."""

from dataclasses import dataclass

import numpy as np

from .data import seal
from .noise_floor import noise_floor
from .pencil import evenly, shift_poles, signal_space

SAME_FREQUENCY = 0.005  # relative, from one order to the next
SAME_DAMPING = 0.1  # relative, with DAMPING_SLACK added
DAMPING_SLACK = 0.001


@dataclass(frozen=True, eq=False)
class Stabilization:
    """Oscillating poles at every order: the points of a stabilization diagram."""

    order: np.ndarray  # (k,)
    frequency: np.ndarray  # (k,) Hz, natural
    damping_ratio: np.ndarray  # (k,)
    stable: np.ndarray  # (k,) bool: the order before has it too

    def __post_init__(self):
        seal(self, "order", int, (None,))
        k = len(self.order)
        seal(self, "frequency", float, (k,))
        seal(self, "damping_ratio", float, (k,))
        seal(self, "stable", bool, (k,))


def stabilization(time: np.ndarray, signals: np.ndarray, most: int = 40) -> Stabilization:
    """Poles of the pencil at the orders 2, 4 .. `most`; time (T,) s, signals (T, C), NaN missing.

    Growing and overdamped poles are left out. Van der Auweraer & Peeters, J. IEST 47 (2004) 109.
    """
    time, signals = np.asarray(time, float), np.asarray(signals, float)
    floor = noise_floor(time, signals)
    dt, even = evenly(time, signals)
    space = signal_space(even / np.where(floor > 0, floor, 1.0))
    rows, before = [], np.zeros((0, 2))
    for order in range(2, min(most, space.shape[0] - 2, space.shape[1]) + 1, 2):
        p = shift_poles(space, order, dt)
        p = p[(p.imag > 1e-6 / dt) & (p.real < 0)]
        now = np.column_stack([np.abs(p) / (2 * np.pi), -p.real / np.abs(p)])
        near_f = np.abs(now[:, None, 0] / before[None, :, 0] - 1) < SAME_FREQUENCY
        slack = SAME_DAMPING * before[None, :, 1] + DAMPING_SLACK
        near_z = np.abs(now[:, None, 1] - before[None, :, 1]) < slack
        stable = (near_f & near_z).any(axis=1)
        rows += [(order, f, z, s) for (f, z), s in zip(now, stable, strict=True)]
        before = now
    columns = list(zip(*rows, strict=True)) or [(), (), (), ()]
    return Stabilization(*map(np.array, columns))
