"""Modes that the body does not have: something in it, or on it, swings by itself."""

import numpy as np

from .ground import Ground
from .unmatched import FOLDS, REACH, further_modes
from .verdict import Verdict

AUDIBLE = 0.01  # of the strongest mode's motion, rms, from which a further mode is asked after
STRANGE = 0.05  # relative, from every pitch that the body has: no error of a mesh is that large


def strangers(verdict: Verdict, ground: Ground) -> list[float]:
    """Pitches (Hz) of what swings in the takes and is no mode of the body as declared."""
    own = ground.body.modes.frequency * np.sqrt(ground.shrink * ground.base.modulus)
    rate = 1 / ground.data.frame
    folded = np.abs(np.add.outer(np.arange(-FOLDS, FOLDS + 1) * rate, own))
    doubt = ground.doubt * own  # Hz: a fold moves as far as the mode does
    heard = [one.frequency for one in further_modes(verdict) if one.loud > AUDIBLE]
    return [
        f
        for f in heard
        # twice what a pitch may be off by, as half an eigenvalue
        if f < REACH * own.max() and (np.abs(folded - f) - doubt).min() > STRANGE * f
    ]


def told(pitches: list[float]) -> str:
    """The line about them."""
    named = ", ".join(f"{f:.4g}" for f in pitches)
    return (
        f"Something swings at {named} Hz, and the body as declared has no such mode: a loose part, "
        "something inside, or what it stands on. Film that too, or hold it still and film again."
    )
