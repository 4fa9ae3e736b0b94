"""From a ring-down to the law that the time layer fits: which modes, at which reference."""

from dataclasses import replace

import numpy as np

from .channels import Channels
from .data import RingDown
from .effects.base import Setting
from .timefit import Law


def real_shapes(amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Real shapes (K, C) and complex starts (K,) with amplitude ~ start x shape (K, C).

    The phase that makes each row most nearly real: half that of the sum of squares.
    """
    turn = np.exp(-0.5j * np.angle((amplitude**2).sum(axis=1)))
    shape = (amplitude * turn[:, None]).real
    return shape, np.conj(turn)


def px_per_metre(data: Channels) -> float:
    """Channel units per metre of motion across the view; 1 for 3-D tracks."""
    if data.take.recording.camera is None:
        return 1.0
    return float(np.sqrt((data.directions**2).sum() / len(data.directions)))


def reference_weights(shape: np.ndarray, data: Channels) -> np.ndarray:
    """(C,) weights w: w . shape is the motion, m, of the marker that moves most."""
    size = np.array(
        [np.linalg.norm(shape[data.marker == m]) for m in range(data.marker.max() + 1)]
    )
    size[np.unique(data.marker[data.support])] = 0
    best = data.marker == int(np.argmax(size))
    return np.where(best, shape, 0) / (np.linalg.norm(shape[best]) * px_per_metre(data))


def build_law(
    rings: list[RingDown], takes: tuple[Channels, ...], condition: tuple[int, ...], damping: str
) -> tuple[Law, np.ndarray]:
    """The declared law and its starting parameters from the ring-downs of the fitted takes.

    All ring-downs hold the same K modes in the same order; their t0 is the release.
    """
    first = rings[0]
    shapes, _ = real_shapes(first.amplitude)
    shapes[:, takes[0].support] = 0
    weights = np.array([reference_weights(s, takes[0]) for s in shapes])
    fitted = [i for i, t in enumerate(takes) if not t.take.held_out]
    starts, conditions = [], max(condition[i] for i in fitted) + 1
    block = [None] * conditions
    for ring, index in zip(rings, fitted, strict=True):
        z = np.clip(ring.damping_ratio, 1e-4, 0.85)
        if block[condition[index]] is None:
            block[condition[index]] = np.r_[np.log(ring.frequency), z]
        at = (ring.amplitude @ weights.T).diagonal()  # complex, m at each mode's reference
        pole = -z + 1j * np.sqrt(1 - z**2)
        starts.append(np.concatenate([at.real, (at * pole).real]))
    sizes = [np.hypot(s[: len(weights)], s[len(weights) :]) for s in starts]
    unit = shapes / np.einsum("kc,kc->k", weights, shapes)[:, None]
    couple = unit @ weights[0]
    setting = Setting(
        omega=2 * np.pi * first.frequency,
        zeta=np.clip(first.damping_ratio, 1e-4, 0.85),
        couple=couple,
        drive=couple.copy(),
        amplitude=float(max(s[0] for s in sizes)),
        modal_mass=np.nan,
        drag_area=np.nan,
        duration=float(max(takes[i].time[takes[i].fit][-1] for i in fitted)),
    )
    law = Law(takes, condition, weights, setting, damping)
    return law, np.concatenate([*block, *starts])


def with_masses(law: Law, modal_mass: np.ndarray, drag_area: float) -> Law:
    """The law with masses (K,) kg known from the matched model, NaN where a mode has no match."""
    known = np.where(np.isfinite(modal_mass), modal_mass, modal_mass[0])
    setting = replace(
        law.setting,
        drive=law.setting.couple * (known[0] / known if np.isfinite(known[0]) else 1.0),
        modal_mass=float(modal_mass[0]),
        drag_area=drag_area,
    )
    return replace(law, setting=setting)
