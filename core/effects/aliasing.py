"""A mode above half the frame rate, folded down to a pitch that the camera can show.

Law         f_seen = |f - n r|, r the frame rate and n whole; the decay rate stays as it is
Tells       a pitch that is no mode's, while its unfolded one and its shape are a computed mode's
Looks like  a mode that the model lacks; another frame rate moves the seen pitch, not the true one
Source      Shannon, Proc. IRE 37 (1949) 10
"""

import numpy as np

from .base import Effect, Parameter

NEAR = 0.03  # relative, to a computed pitch: as well as shapes and ratios of pitches are known


def unfolded(seen: float, near: float, rate: float) -> float:
    """Hz, the pitch nearest to `near` that is seen as `seen` at `rate` frames/s."""
    n = np.round(np.array([near - seen, near + seen]) / rate)
    able = np.abs(n * rate + np.array([seen, -seen]))
    return float(able[np.argmin(np.abs(able - near))])


def is_folded(seen: float, computed: float, rate: float) -> bool:
    """Whether a computed pitch above half the rate explains `seen` by its fold, and only so."""
    if computed <= rate / 2:
        return False
    true = unfolded(seen, computed, rate)
    return abs(true / computed - 1) < min(NEAR, abs(seen / computed - 1) / 2)


EFFECT = Effect(
    name="aliasing",
    layer="camera",
    parameters=(Parameter("frequency", "Hz", 0.0, 1e6),),
    twins=(),
    settle="film at another frame rate, twice as fast if the camera can",
)
