"""Which poles of a clip are modes of a free swing, and which are something else that was seen."""

import numpy as np

from .data import RingDown
from .pursuit import DEAD

WEAK = 0.3  # of the strongest mode: what is weaker must show that it is a mode
DECAYS = 3.0  # standard deviations by which its damping ratio must lie above zero
OVERTONES = (2, 3, 4, 5)
NEAR = 0.002  # relative, of an overtone's pitch


def sift(found: RingDown, capture_fps: float) -> tuple[np.ndarray, tuple[str, ...]]:
    """(k,) indices of the modes, strongest first, and one warning that names the others.

    The strongest always counts. A weak one that does not decay is a tone from outside, one at a
    whole multiple of a stronger pitch (folded at `capture_fps`) is its overtone, and one that is
    over within a swing is the blow that started it all.
    """
    strength = np.linalg.norm(found.amplitude, axis=1)
    kept, others = [], []
    for k, (f, z) in enumerate(zip(found.frequency, found.damping_ratio, strict=True)):
        weak = strength[k] < WEAK * strength.max()
        stronger = [j for j in kept if strength[k] < WEAK * strength[j]]
        if k == int(np.argmax(strength)):
            kept.append(k)
        elif z > DEAD:
            others.append(f"{f:.4g} Hz is over at once")
        elif any(_is_overtone(found, k, j, capture_fps) for j in stronger):
            others.append(f"{f:.4g} Hz is an overtone of a stronger pitch")
        elif weak and z < DECAYS * found.damping_sigma[k]:
            others.append(f"{f:.4g} Hz is not seen to decay")
        else:
            kept.append(k)
    said = f"weak motion that is no mode of a free swing: {', '.join(others)}." if others else ""
    return np.array(kept, int), (said,) if said else ()


def _is_overtone(found: RingDown, k: int, j: int, capture_fps: float) -> bool:
    seen, f = found.frequency[k], found.frequency[j]
    slack = max(NEAR * seen, 3 * found.frequency_sigma[k])
    for n in OVERTONES:
        folded = abs((n * f + capture_fps / 2) % capture_fps - capture_fps / 2)
        if abs(seen - folded) < slack:
            return True
    return False
