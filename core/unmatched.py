"""Modes of a take that no computed one was matched to: which of them tell of the body."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import beta

from .baseline import real_shapes
from .camera_layer import true_frequency
from .effects import split_modes
from .effects.aliasing import is_folded, unfolded
from .effects.further_mode import is_a_mode, of_take, pitch_of
from .joint import Heard
from .law import TimeFit, replace
from .match import CHANCE, PAIR, SURE, dies_alike, likeness
from .verdict import Verdict

HARMLESS = ("lost_frames", "tracker_drift")  # once told, they leave nothing of themselves
ADDED = ("relaxation", "steady_drive")  # linear: modes swing beside them as they would without
LOUD = 0.3  # of the strongest mode's motion, rms, from which one that was not matched counts
ALOUD = 0.1  # the same where it has a pitch of the body, and moves otherwise
THEIRS = 0.05  # relative, of a computed pitch, within which it has that
OWN = 0.4  # likeness to a computed mode from which a fainter one does too
REACH = 0.9  # of the highest computed pitch, up to which the body's modes are known
FOLDS = 3  # times the rate of the frames, by which a high mode may be seen folded down
UNSEEN = 0.05  # of the most that a mode moves: one that moves less, where it is seen, is not known


@dataclass(frozen=True, eq=False)
class FurtherMode:
    """A mode that no computed one was matched to."""

    frequency: float  # Hz
    damping_ratio: float
    shape: np.ndarray  # (C,)
    swing: float  # rms of what the shape is multiplied by
    loud: float  # motion over that of the strongest matched mode, rms
    at: int  # of its pitch among the fit's parameters


def further_modes(verdict: Verdict, *but: str) -> list[FurtherMode]:
    """The further modes of a take in which nothing acts in time but a pair that is parted, what was
    read off and is HARMLESS, or what adds to the swings and bends none; `but`: or these.
    """
    final = verdict.final
    law = final.law
    if acts(final, split_modes.EFFECT.name, *ADDED, *but):
        return []
    data = law.takes[law.fitted[0]]
    known = np.sqrt(((final.motions[0].std(axis=0)[:, None] * final.shapes) ** 2).sum(axis=1))
    shapes, first = final.column_shapes(), sum(law.sizes()[:2])
    out = []
    for i, effect, theta in of_take(final, 0):
        if is_a_mode(effect, theta):
            own = final.theta[i], law.setting, data.time[None], final.motions[0][None]
            swing = float(effect.columns(*own)[0].std(axis=0).mean())
            real = real_shapes((shapes[i] @ np.array([1, -1j]))[None])[0][0]
            loud = float(swing * np.linalg.norm(real) / known.max())
            at = first + sum(t.shape[1] for t in final.theta[:i])
            out.append(FurtherMode(pitch_of(effect, theta), float(theta[1]), real, swing, loud, at))
    return out


def unfolded_mode(one: FurtherMode, seen: np.ndarray, heard: Heard, final: TimeFit) -> FurtherMode:
    """The mode as it is, where what shows is the fold of the computed one that it is most like."""
    data, frequency = final.law.takes[final.law.fitted[0]], heard.body.modes.frequency
    own, rate = true_frequency(heard, final), 1 / data.frame
    computed = frequency * own[0] / frequency[heard.match.modes[0]]
    free = [j for j in range(len(computed)) if j not in heard.match.modes]
    best = max(free, key=lambda j: likeness(one.shape, seen, frequency, j), default=None)
    z = one.damping_ratio
    damped = one.frequency * np.sqrt(1 - z**2)
    if best is None or likeness(one.shape, seen, frequency, best) < SURE:
        return one
    if not is_folded(damped, computed[best], rate):
        return one
    true = float(np.hypot(unfolded(damped, computed[best], rate), z * one.frequency))
    if not dies_alike(one.frequency, z, true, (own[0], None, final.damping_ratio[0])):
        return one
    return replace(one, frequency=true, damping_ratio=z * one.frequency / true)


def is_loud(one: FurtherMode, heard: Heard, final: TimeFit) -> bool:
    """Whether it counts however it moves: what has the pitch of a mode that was not matched is no
    loose part, and does so sooner.
    """
    free = np.delete(_computed(heard, final), list(heard.match.modes))
    theirs = (np.abs(np.log(one.frequency / free)) < THEIRS).any()
    return bool(one.loud > (ALOUD if theirs else LOUD))


def _computed(heard: Heard, final: TimeFit) -> np.ndarray:
    """(m,) Hz of the body's modes, by the pitch of the strongest one."""
    own = heard.body.modes.frequency
    return own * true_frequency(heard, final)[0] / own[heard.match.modes[0]]


def of_the_body(
    further: list[FurtherMode], seen: np.ndarray, heard: Heard, final: TimeFit, *, however=False
) -> list[FurtherMode]:
    """Those that tell of the body: whatever is loud, for a body that is as declared shows no loud
    mode that it does not have, and what moves as one of its modes (m, C) that was not matched, or
    `however` it moves.

    Not what lies near the highest computed one, for it may be a mode that was not computed, nor
    what is rather the fold of the one that it moves as.
    """
    size = np.linalg.norm(seen, axis=1)
    free = [j for j in np.flatnonzero(size > UNSEEN * size.max()) if j not in heard.match.modes]
    own, computed = heard.body.modes.frequency, _computed(heard, final)
    rate = 1 / final.law.takes[final.law.fitted[0]].frame

    def tells(one):
        if is_loud(one, heard, final):
            return True
        return one.frequency < REACH * computed.max() and (however or is_as_one(one))

    def is_as_one(one):
        return any(
            _moves_as(one.shape, seen, own, j, len(free))
            and not _is_rather_folded(one.frequency, computed[j], rate)
            for j in free
        )

    return [one for one in further if tells(one)]


def _is_rather_folded(seen_at: float, computed: float, rate: float) -> bool:
    """Whether a pitch of which `seen_at` is the fold lies nearer to the `computed` one (Hz)."""
    folds = rate * np.arange(1, FOLDS + 1)
    aliases = np.r_[seen_at, np.abs(folds - seen_at), folds + seen_at]
    return bool(np.abs(np.log(aliases / computed)).argmin())


def _moves_as(shape: np.ndarray, seen: np.ndarray, frequency: np.ndarray, j: int, of: int) -> bool:
    """Whether a shape is that of mode j, as one that is none would not be by chance with any `of`
    so many: its likeness to k directions among C is then of the Beta distribution.
    """
    k = (np.abs(frequency / frequency[j] - 1) < PAIR).sum()
    alike, channels = likeness(shape, seen, frequency, j), (np.abs(seen) > 0).any(axis=0).sum()
    if alike <= OWN or channels <= k:
        return False
    return bool(of * beta.sf(alike, k / 2, (channels - k) / 2) < CHANCE)


def acts(final: TimeFit, *but: str) -> bool:
    """Whether an effect in time, declared or found, is in the fit that may bend a pitch or a shape
    even where it is told; `but`: names of others that are not counted.
    """
    but += HARMLESS
    return any(e.layer in ("time", "camera") and e.name not in but for e in final.law.effects)
