"""Each mode loses energy at its own constant damping ratio.

Law         u'' + 2 z w u' + w^2 u = 0, z free for every mode
Tells       a straight logarithmic envelope
Looks like  structural_damping while fewer than three modes are seen
Source      Ewins, Modal Testing (2000), 2.4
"""

from .base import Effect, Parameter

EFFECT = Effect(
    name="viscous_damping",
    layer="damping",
    parameters=(Parameter("damping_ratio", "1", 0.0, 1.0),),
    twins=("structural_damping",),
    settle="add a known mass: a loss factor keeps the damping ratio, a dashpot does not",
)
LAW = "free"


def report(found, sigma) -> dict:
    """damping_ratio of every mode: value (K,) and standard deviation (K,)."""
    return {"damping_ratio": (found.damping_ratio, sigma)}
