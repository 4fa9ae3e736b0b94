"""The other direction of a degenerate pair: part of every symmetric body, not an effect.

Law         a second motion at the pitch of mode k, with its own damping ratio and shape; with
            other loads it lies elsewhere and moves otherwise, so those takes have one of their own
Tells       the motion turns in an ellipse without beating
Source      Rayleigh, The Theory of Sound, vol. 1, 221 a; a split beyond `SPREAD` is split_modes
"""

from dataclasses import dataclass

import numpy as np

from .base import SAME_SHAPE, Effect, as_declared, companion, of_takes, ring, shared, unlike_damping

MOST = 1.15  # ratio of the damping ratios of two modes of one pitch
LOSS, ACROSS = 1.5, 0.1  # the same, where no more of the one's motion goes along the other
OTHER = 3.0  # the same, where no more than noise is left
NOTHING = 1.1  # misfit per sample
AT_BOUND = 0.98  # of the most that it may part by
SPREAD = 0.002  # relative: what meshing splits by


@dataclass(frozen=True)
class Where:
    """Whose partner it is: that of measured mode `k` in takes that carry the same loads."""

    k: int
    frequency: float  # Hz of the mode there
    damping_ratio: float
    take: int = 0  # the first of those among the fitted ones
    pitch: int = 0  # theirs, as in the law
    condition: int = 0  # as in the law: whose shape of that mode
    takes: tuple = ()  # see `of_takes`


def _split(found, at: Where, gap: float) -> str:
    """The mode's own pitch is fitted along, so only afterwards is it known how far they part.

    One that would part further than it may, and leaves something, is another one's too.
    """
    split = found.theta[-1][0][0]
    if abs(split) > AT_BOUND * (gap + SPREAD) and found.chi2 > NOTHING * found.samples:
        return "its pitch is another one"
    own = np.exp(found.parameters[2 * found.law.modes * at.pitch + at.k])
    apart = abs(at.frequency * (1 + split) / own - 1)
    return "its pitch is another one" if apart > gap + 2 * SPREAD else ""


def _mimics(found, at: Where, gap: float) -> str:
    """A pair that lies apart by itself may look alike from one side, and then leaves nothing."""
    if gap > SPREAD and found.chi2 < NOTHING * found.samples and _looks_alike(found, at.k):
        return ""
    return companion(found, at.k, at.condition, at.take)


def _looks_alike(found, k: int) -> bool:
    """Whether the channels see the computed directions of mode k's pair, if known, move as one."""
    ways = found.law.ways
    seen = np.linalg.svd(ways[k], compute_uv=False) if ways else ()
    return len(seen) < 2 or bool(seen[1] ** 2 < (1 - SAME_SHAPE) * seen[0] ** 2)


def another_motion(found, k: int, condition: int = 0, take: int = 0, pitch: int = 0) -> str:
    """Why the last effect is not the other direction of mode k by its damping; or "". One material
    and one pitch make one loss; where two directions lie straight across each other, what is held
    or loaded unlike may damp them unlike, far so where nothing else is to be told. The others as in
    the law, see `companion`.
    """
    most = MOST
    if shared(found, k, condition, take) < ACROSS:
        most = OTHER if found.chi2 < NOTHING * found.samples else LOSS
    alike = unlike_damping(found, k, pitch) < np.log(most)
    return "" if alike else "its damping is another motion's"


def partner(at: Where, gap: float = 0.0) -> Effect:
    """The partner of a mode; theta = (split, damping ratio).

    `gap`: how far, relatively, the body itself parts the pair.
    """

    def columns(theta, setting, time, u):
        omega = 2 * np.pi * at.frequency * (1 + theta[:, 0])[:, None]
        return ring(omega, theta[:, 1][:, None], time)

    return Effect(
        name=f"partner of mode {at.k + 1}" + (f" with loads {at.pitch + 1}" if at.pitch else ""),
        layer="pair",
        parameters=(),
        twins=(),
        settle="",
        low=(-gap - SPREAD, 1e-4),
        high=(gap + SPREAD, 0.4),
        starts=lambda setting, residual: [
            (split, float(np.clip(share * at.damping_ratio, 1e-3, 0.3)))
            for split, share in ((0.002 + gap, 0.8), (-0.002 - gap, 1.25))
        ],
        columns=columns,
        of_release=True,
        phased=True,
        channels=of_takes(at.takes),
        veto=lambda found: (
            _mimics(found, at, gap)
            or another_motion(found, at.k, at.condition, at.take, at.pitch)
            or _split(found, at, gap)
        ),
    )


def is_of(effect: Effect, k: int) -> bool:
    """Whether the effect is a motion of mode k's pair."""
    return effect.layer == "pair" and effect.name.split(" with ")[0].endswith(f" mode {k + 1}")


def crossing(k: int, gap: float = 0.0) -> Effect:
    """The direction of a degenerate pair in which no force acts: it swings on freely.

    It has the pitch and damping that mode `k` would have without the force, so that it mimics
    nothing where both look alike from one side; theta = (split,), within what meshing makes.
    """

    def beside(theta, omega, zeta, time):
        return ring(omega[:, [k]] * (1 + theta[:, :1]), zeta[:, [k]], time)

    return Effect(
        name=f"motion across mode {k + 1}",
        layer="pair",
        parameters=(),
        twins=(),
        settle="",
        low=(-gap - SPREAD,),
        high=(gap + SPREAD,),
        # at one pitch it would be a turn of the mode, which tells nothing of where to go
        starts=lambda setting, residual: [(way * max(gap, SPREAD / 2),) for way in (1, -1)],
        columns=as_declared(beside),
        beside=beside,
        of_release=True,
        phased=True,
    )
