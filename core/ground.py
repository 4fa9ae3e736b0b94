"""What was measured of the body, beside the body as it is declared."""

from dataclasses import dataclass

import numpy as np

from .baseline import px_per_metre
from .body import Body
from .camera_layer import true_frequency
from .channels import Channels
from .compare import PITCH_FLOOR, SHAPE_FLOOR, Hypothesis, Measured, compare, rematched
from .effects import split_modes
from .elasticity import gravity_force
from .folds import folds_of
from .joint import Heard
from .law import TimeFit, replace
from .match import PAIR
from .other_loads import Reduced, Shift, as_declared, reduced, shifts_of
from .parameters import inflation
from .sizes import size_slopes
from .turned import sag_between
from .twins import bent, creeps, handed_on, softer, twins
from .unmatched import acts, further_modes, is_loud, of_the_body, unfolded_mode
from .verdict import Verdict

CLOSE_FLOOR = 0.0007  # as PITCH_FLOOR, where what all pitches are off by at once is told apart
OWN = 0.25  # of the error of convergence, that is each pitch's own there
TOGETHER = 2.0  # of it, that all share: no rim or corner is as sharp as a mesh has it
SIZED = 0.002  # of each size along an axis: a tenth of a millimetre in five centimetres
NEAR = 2.0  # standard deviations, within which a pitch is the declared body's
UNSURE = 2.0  # of a pitch's standard deviation, by which it is off: a faint pole may be two modes
SPILL = 0.3  # of what is left in a channel may have gone into a mode's shape
BIASED = 0.5  # of what effects in time moved a pitch by, or the strongest one's, that it may be off
SETTLED = 0.03  # of the sag: error of geometry and a creep that nothing shows
PLACED = 0.001  # of the body's length, that a rest place may be off by
CREPT = 0.15  # the same where a creep may be at work
TILTED = 1.4  # of the sag over the length: how far a cantilever's end turns


@dataclass(frozen=True, eq=False)
class Ground:
    """What every suspect is fitted on."""

    body: Body
    data: Channels
    measured: Measured
    base: Hypothesis
    shrink: np.ndarray  # (m,) converged over computed eigenvalues
    doubt: np.ndarray  # (m,) relative error of an eigenvalue, and of how a load sits
    damping_ratio: np.ndarray  # (K,) of the measured modes, without what acts in time
    computed: np.ndarray  # (K,) relative error of a pitch that is the model's
    pull: np.ndarray | None = None  # (3P,) N, the body's own weight where the sag is known
    turned: bool = False  # that is told by takes of the body turned over
    shifts: tuple[Shift, ...] = ()  # of the pitches in takes with other loads
    with_loads: Reduced | None = None  # the declared body, as these ask for it

    @property
    def shifted(self) -> int:
        """How many pitches under other loads are known."""
        return int(sum(np.isfinite(one.measured).sum() for one in self.shifts))

    @property
    def unsure(self) -> np.ndarray:
        """(K,) relative error of a pitch that is the recording's."""
        return np.sqrt(np.maximum(self.measured.error**2 - self.computed**2, 0.0))


def ground_of(heard: Heard, verdict: Verdict, stiff, sigma) -> Ground | None:
    """What pitches and shapes are compared with; None where the declared body moves as nothing that
    was measured.

    Where, of all pitches, none but faint ones are off, each other mode counts however it moves: a
    body of which they all are has been changed, and a loose part makes one alone.
    """
    final, seen = verdict.final, heard.body.seen(_first_of(verdict.final))
    every = [unfolded_mode(one, seen, heard, final) for one in further_modes(verdict)]
    own = of_the_body(every, seen, heard, final)
    found = _ground(heard, verdict, stiff, sigma, own)
    if found is None or not _only_faint_are_off(found):
        return found
    more = of_the_body(every, seen, heard, final, however=True)
    return found if len(more) == len(own) else _ground(heard, verdict, stiff, sigma, more)


def _only_faint_are_off(found: Ground) -> bool:
    """Whether faint modes are strange to the declared body, and two loud ones or more are its."""
    loud = len(found.measured.frequency) - found.measured.faint
    if not found.base.strange or loud < 2:
        return False
    off = found.base.pitch_pull[:loud] ** 2 / np.maximum(found.base.free[:loud], 0.1)
    return bool(off.max() < NEAR**2)


def _ground(heard: Heard, verdict: Verdict, stiff, sigma, further: list) -> Ground | None:
    """That of the modes that were matched and these `further` ones."""
    final = verdict.final
    data = _first_of(final)
    body = heard.body
    loud = [one for one in further if is_loud(one, heard, final)]
    further = [*loud, *(one for one in further if one not in loud)]
    model_error = sigma[list(heard.match.modes)]
    model_error = np.r_[model_error, np.full(len(further), sigma.max())]
    at = [*range(final.law.modes), *(one.at for one in further)]
    spread = np.sqrt(np.maximum(np.diag(final.covariance)[at], 0) * inflation(final))
    true = true_frequency(heard, final)
    pitches = np.r_[true, [one.frequency for one in further]]
    bias = _biased(verdict, pitches)
    computed = np.hypot(PITCH_FLOOR, 0.5 * model_error)
    error = np.sqrt((UNSURE * spread) ** 2 + bias**2 + computed**2)
    middle, pair = split_modes.middle(final), final.law.setting.pair
    error[pair] = np.hypot(error[pair], split_modes.doubt(final))
    error[: len(true)] = np.hypot(error[: len(true)], _blurred(heard, final, true))
    pitches[pair] *= middle
    ratios = np.r_[verdict.damped.damping_ratio, [one.damping_ratio for one in further]]
    samples = max(int(data.fit.sum()), 1)
    shapes = np.vstack([final.shapes, *(one.shape for one in further)])
    size = np.abs(shapes).max(axis=1, keepdims=True)
    swing = np.array([*(u.std() for u in final.motions[0].T), *(one.swing for one in further)])
    left = final.missed(0)[data.fit]
    rest = SPILL * np.sqrt(np.nanmean(left**2, axis=0)) / np.maximum(swing[:, None], 1e-300)
    noise = data.sigma / np.maximum(swing[:, None], 1e-300) / np.sqrt(samples / 2)
    shape_error = np.sqrt(noise**2 + rest**2 + (SHAPE_FLOOR * size) ** 2)
    shape_error = np.where(data.support, 1e12, shape_error)
    sag, pull, settled, between = None, None, SETTLED, None
    case = body.case
    if case.shape == "unloaded" and case.takes[0].gravity is not None:
        between = sag_between(final)
        sag = final.rest() - data.rest if between is None else between
        sag = np.where(data.support, 0.0, sag)
        pull = gravity_force(body.model, data.take.gravity)
        length = np.ptp(body.model.points, axis=0).max()
        most = np.abs(sag).max() / px_per_metre(data)
        tilt = TILTED * most / length
        placed = PLACED if between is None else PLACED / 2  # it was put back by hand
        settled = np.hypot(SETTLED, placed * length / max(most, 1e-300))
        shape_error = np.hypot(shape_error, tilt * size)  # it swings about where it hangs
    measured = Measured(
        pitches,
        error,
        shapes,
        shape_error,
        sag,
        softer(final)[0],
        max(CREPT, settled) if creeps(verdict) else settled,
        len(further) - len(loud),
        folds=folds_of(pitches, ratios, 1 / data.frame, (0, final.loudest)),
    )
    shrink = 1 / (1 + stiff)
    base = _compared(body, data, measured, shrink)
    if base is None:
        return None
    if middle != 1:
        measured = parted(measured, base.modes, body.modes.frequency, (pair, middle - 1))
        base = _compared(body, data, measured, shrink) or base
    shifts = shifts_of(heard, verdict, base, np.broadcast_to(bias, pitches.shape)[: len(true)])
    with_loads = reduced(heard, shifts)
    return Ground(
        body,
        data,
        measured,
        as_declared(shifts, base, with_loads),
        shrink,
        doubt=sigma,
        damping_ratio=ratios,
        computed=computed,
        pull=pull,
        turned=between is not None,
        shifts=shifts,
        with_loads=with_loads,
    )


def _first_of(final: TimeFit) -> Channels:
    return final.law.takes[final.law.fitted[0]]


def _compared(body: Body, data: Channels, measured: Measured, shrink) -> Hypothesis | None:
    values, seen, unit = (2 * np.pi * body.modes.frequency) ** 2, body.seen(data), None
    if measured.sag is not None:
        pull = gravity_force(body.model, data.take.gravity)
        load = np.einsum("pim,pi->m", body.modes.shapes, pull.reshape(-1, 3))
        unit = converged_sag(body.sag(data), seen, load / values, shrink)
    found = compare(measured, values * shrink, seen, unit)
    return found and rematched(measured, values * shrink, seen, unit, found)


def converged_sag(sag: np.ndarray, shapes: np.ndarray, held: np.ndarray, shrink) -> np.ndarray:
    """(C,) a sag as it would be on a mesh that stiffens none of the modes.

    shapes (m, C); held (m,): how much of each mode is in the `sag` (C,); shrink (m,): its converged
    eigenvalue over its computed one.
    """
    return sag + (held * (1 / shrink - 1)) @ shapes


def looked_at_closely(ground: Ground) -> Ground | None:
    """The same where computed pitches are trusted further, but for what rims, corners and sizes may
    do to all of them at once; None as `ground_of` has it. Without loads.
    """
    modes = list(ground.base.modes)
    error = 0.5 * ground.doubt[modes]
    own = np.sqrt(ground.unsure**2 + (OWN * error) ** 2 + CLOSE_FLOOR**2)
    common = np.vstack([TOGETHER * error, SIZED * size_slopes(ground.body)[:, modes]])
    measured = replace(ground.measured, error=own, common=common)
    base = _compared(ground.body, ground.data, measured, ground.shrink)
    if base is None:
        return None
    base = as_declared(ground.shifts, base, ground.with_loads)
    return replace(ground, measured=measured, base=base)


def parted(measured: Measured, modes: tuple, own: np.ndarray, split: tuple) -> Measured:
    """The measurements where a pair of the body (computed pitches `own` (m,) Hz) is parted, whose
    middle was taken: what parts one pair parts the others, this way or that.

    split: the number of that pair's mode, and half of what it is parted by, relatively.
    """
    pair, half = split
    paired = (np.abs(own[:, None] / own[list(modes)] - 1) < PAIR).sum(axis=0) > 1
    paired[pair] = False
    error = np.where(paired, np.hypot(measured.error, half), measured.error)
    return replace(measured, error=error)


def _blurred(heard: Heard, final: TimeFit, true: np.ndarray) -> np.ndarray:
    """(K,) relative, how far computed modes that were not matched lie from each mode but the
    strongest, those within its half-width, or its width where its `true` pitch (K,) Hz is between
    the two: they may sound as one.
    """
    own, matched = heard.body.modes.frequency, list(heard.match.modes)
    strongest = final.loudest
    scaled = np.log(own / own[matched[strongest]] * true[strongest])
    at, others, pitch = scaled[matched][:, None], np.delete(scaled, matched), np.log(true)[:, None]
    gaps, half = np.abs(others - at), final.damping_ratio[:, None]
    between = (pitch - at) * (others - pitch) > 0
    far = np.where(gaps < np.where(between, 2 * half, half), gaps, 0.0).max(axis=1)
    far[strongest] = 0.0
    return far


def _biased(verdict: Verdict, frequency: np.ndarray) -> np.ndarray:
    """(K,) relative, how far off the pitches (K,) Hz may be by what acts in time.

    A body that is stiffer one way is by itself as stiff as one of the two.
    """
    final = verdict.final
    by = moved(final, verdict.damped) if acts(final) else np.zeros(final.law.modes)
    most = np.maximum(np.pad(by, (0, len(frequency) - len(by))), by[final.loudest])
    uneven = max(bent(final), *(bent(one) for one in twins(verdict)), 0.0)
    return np.maximum(BIASED * most, uneven * handed_on(frequency))


def moved(final: TimeFit, declared: TimeFit) -> np.ndarray:
    """(K,) relatively, how far the effects in time moved the pitches."""
    return np.abs(np.log(final.frequency / declared.frequency))
