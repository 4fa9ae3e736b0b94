"""Folded pitches: what a frame rate shows of a body that swings faster than half of it."""

import numpy as np

from .video import Video

FOLDED = 0.2  # of the frame rate: a mode seen above it may be a fold of a higher one
NEAR_HALF = 0.4  # of it, above which that is worth a warning
FOLDS = 3  # multiples of the frame rate about which such modes are sought
SLUGGISH = 0.25  # damping ratio of a slow mode that may be the fold of a fast one's light damping
AGREES = 0.01  # relative, of two rates


def aliases(
    frequency: float, damping_ratio: float, capture_fps: float, *, doubted: bool = False
) -> list[float]:
    """Hz, natural frequencies that `capture_fps` would show at `frequency`, lowest first.

    What is sampled is the damped frequency f_d = f sqrt(1 - z^2); k F - f_d and k F + f_d look
    the same at F frames/s. Empty where there are five frames or more in a period, unless it is
    damped more than a body that rings, or the rate is `doubted`: a body that swings at that pace
    and is seen so evenly is rarely one that swings ten times faster.
    """
    damped = frequency * np.sqrt(1 - damping_ratio**2)
    if damped < FOLDED * capture_fps and damping_ratio < SLUGGISH and not doubted:
        return []
    decay = frequency * damping_ratio  # the envelope is not folded
    folds = [k * capture_fps + sign * damped for k in range(1, FOLDS + 1) for sign in (-1, 1)]
    return [float(np.hypot(fold, decay)) for fold in folds]


def doubted_rate(clip: Video, capture_fps: float) -> bool:
    """Whether the file says that more frames were taken in a second than were declared.

    A file that plays slower than it was filmed is slow motion, and says nothing.
    """
    told = [rate for rate in (clip.rate, clip.tagged_rate) if rate is not None]
    return any(rate > (1 + AGREES) * capture_fps for rate in told)


def fold_warnings(found, folds, capture_fps: float) -> tuple[str, ...]:
    """What to say of the modes (a RingDown) that have `folds` Hz, but for those of a quiet kind."""
    said = []
    for f, z, fold in zip(found.frequency, found.damping_ratio, folds, strict=True):
        if f > NEAR_HALF * capture_fps:
            why = f"is near half of the {capture_fps:g} frames/s"
        elif fold and f < FOLDED * capture_fps:
            why = f"has a damping ratio of {z:.2g}, or the file's own rate speaks against it"
        else:
            continue
        said.append(
            f"the mode seen at {f:.4g} Hz {why}: it may as well be {fold[0]:.4g}, {fold[1]:.4g} or "
            f"{fold[2]:.4g} Hz. Film at a higher rate, or at a slightly different one, to tell."
        )
    return tuple(said)
