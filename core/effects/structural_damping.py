"""One loss factor for all modes: hysteresis of the material.

Law         K (1 + i eta), so every mode has the damping ratio eta/2
Tells       the damping ratio is the same over modes and added masses
Looks like  viscous_damping while fewer than three modes are seen
Source      Ewins, Modal Testing (2000), 2.5 (hysteretic damping)
"""

from .base import Effect, Parameter

EFFECT = Effect(
    name="structural_damping",
    layer="damping",
    parameters=(Parameter("loss_factor", "1", 0.0, 2.0),),
    twins=("viscous_damping",),
    settle="excite three modes or more, or add a known mass and film again",
)
LAW = "common"


def report(found, sigma) -> dict:
    """loss_factor: value and standard deviation."""
    return {"loss_factor": (2 * found.damping_ratio[0], 2 * sigma[0])}
