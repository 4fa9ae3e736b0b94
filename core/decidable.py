"""Whether a recording can tell one effect from another at all."""

from .law import TimeFit
from .residual import motion_rms

LOUD = 1.5  # noise units, rms: less motion than that decides nothing
SWINGS = 1.5  # of the first mode that a fit must see
FRAMES = 2.5  # a swing; below, a pitch may be a folded one


def undecidable(found: TimeFit) -> str:
    """Why this recording cannot tell one effect from another; empty where it can."""
    data = found.law.takes[found.law.fitted[0]]
    size = motion_rms(found.law.takes)
    if size < LOUD:
        return (
            f"Too noisy to decide: the motion is {size:.2g} times the noise, {LOUD:g} is needed. "
            "Release it from further out, or bring the camera closer."
        )
    swings = found.frequency[0] * found.law.setting.duration
    if swings < SWINGS:
        return (
            f"Too short to decide: {swings:.2g} swings are fitted, {SWINGS:g} are needed. "
            "Film on until it stands still."
        )
    frames = 1 / (found.frequency[0] * data.frame)
    if frames < FRAMES:
        return (
            f"Too coarse to decide: {frames:.2g} frames a swing, {FRAMES:g} are needed. The true "
            "pitch may be another one that folds to this. Film at twice the frame rate."
        )
    return ""
