"""Modes that the body does not have: something in it, or on it, swings by itself."""

import numpy as np

from .effects import base_motion
from .ground import Ground
from .match import dies_alike
from .unmatched import FOLDS, REACH, further_modes
from .verdict import Verdict

AUDIBLE = 0.01  # of the strongest mode's motion, rms, from which a further mode is asked after
SHAKEN = 0.05  # the same, where all is shaken: what shakes it may shake other things too
STRANGE = 0.05  # relative, from every pitch that the body has: no error of a mesh is that large


def strangers(verdict: Verdict, ground: Ground) -> list[float]:
    """Pitches (Hz) of what swings in the takes and is no mode of the body as declared."""
    own = ground.body.modes.frequency * np.sqrt(ground.shrink * ground.base.modulus)
    rate = 1 / ground.data.frame
    folded = np.abs(np.add.outer(np.arange(-FOLDS, FOLDS + 1) * rate, own))
    doubt = ground.doubt * own  # Hz: a fold moves as far as the mode does
    seen, true = verdict.final.frequency[0], ground.measured.frequency[0]
    first = true, None, verdict.final.damping_ratio[0] * seen / true  # as it is, not folded

    def is_strange(one):
        # twice what a pitch may be off by, as half an eigenvalue
        near = np.abs(folded - one.frequency) - doubt <= STRANGE * one.frequency
        return not any(
            fold == FOLDS  # its own pitch, not folded
            or not first[2]
            or dies_alike(one.frequency, one.damping_ratio, own[j], first)
            for fold, j in np.argwhere(near)
        )

    shaken = any(effect.name == base_motion.NAME for effect in verdict.final.law.effects)
    least = SHAKEN if shaken else AUDIBLE
    heard = [one for one in further_modes(verdict, base_motion.NAME) if one.loud > least]
    return [f for one in heard if (f := one.frequency) < REACH * own.max() and is_strange(one)]


def told(pitches: list[float]) -> str:
    """The line about them."""
    named = ", ".join(f"{f:.4g}" for f in pitches)
    return (
        f"Something swings at {named} Hz, and the body as declared has no such mode: a loose part, "
        "something inside, or what it stands on. Film that too, or hold it still and film again."
    )
