"""Where the fit of a take begins: once what rings above all computed modes of the body has died.

A blow on a compact body, or a pull at a point of it, rings so many modes that they cannot all be
fitted. High ones die first, so the first frames are left out instead.
"""

import numpy as np

from .all_told import SAME, damps_alike
from .baseline import real_shapes
from .channels import Channels
from .data import RingDown, poles
from .match import mac

FEW = 3  # of them, from which they are waited for; fewer are fitted as further modes
FADED = 3.0  # noise, of all channels together, that such a mode has died to
SPENT = 0.9  # nepers that the strongest mode may die by meanwhile
SHARE = 0.5  # of the fitted part that may be left out


def outlived(data: Channels, ring: RingDown, known: RingDown, top: float) -> float:
    """s after the release at which what a take rings above `top` Hz has died away, or the strongest
    mode has died too far; 0 where little rings there. `known`: its modes that were matched.

    What acts in time makes overtones and companions, which move as the strongest mode does; what
    is counted moves otherwise, and is damped as the body's modes are.
    """
    on = ~data.support
    shapes, first = (real_shapes(one.amplitude[:, on])[0] for one in (ring, known))
    above = [
        k
        for k, (f, z) in enumerate(zip(ring.frequency, ring.damping_ratio, strict=True))
        if f > top
        and damps_alike(f, z, known.frequency, known.damping_ratio)
        and mac(shapes[k], first[0]) < SAME
    ]
    if len(above) < FEW:
        return 0.0
    decay = -poles(ring.frequency, ring.damping_ratio).real[above]
    loud = np.linalg.norm(ring.amplitude[above][:, on] / data.sigma[on], axis=1)
    silent = (np.log(np.maximum(loud / FADED, 1.0)) / decay).max()
    dying = -poles(known.frequency[:1], known.damping_ratio[:1]).real[0]
    return float(min(silent, SPENT / dying, SHARE * data.time[data.fit][-1]))
