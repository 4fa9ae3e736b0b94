"""What the camera does to a recording that the time layer cannot tell: folds, a near lens, and rows
exposed one after another where the motion is a degenerate pair's.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student_t

from .dac import SURE
from .data import poles
from .effects import perspective, rolling_shutter
from .effects.partner import is_of
from .effects.rolling_shutter import Ellipse
from .joint import Heard
from .law import TimeFit, unpack
from .match import PAIR, true_pitches
from .near_camera import rest_places
from .parameters import inflation
from .report import estimate
from .residual import Error, error_of, errors, motion_rms
from .time_layer import MATERIAL
from .verdict import Verdict

WHOLE = 1.1  # of a frame that a camera's readout takes at most, its clock being a little off
MORE = 1.2  # of the error, held out or fitted, that is left without a folded mode that shows


@dataclass(frozen=True, eq=False)
class Seen:
    """One effect of the camera."""

    effect: dict  # as the report gives it
    share: float  # of the motion, rms
    before: Error | None  # without it; None: see Heard.far
    shows: bool = True  # beside the noise

    @property
    def material(self) -> bool:
        """Whether it counts as an effect."""
        return self.share >= MATERIAL and self.shows


def camera_effects(heard: Heard, verdict: Verdict) -> list[Seen]:
    """What the camera does that the final fit and the rest places show: a fold, the strongest
    where there are more, a near lens, and rows that lag.
    """
    return [*_folded(heard, verdict.final), *_near(heard, verdict), *_late(heard, verdict.final)]


def true_frequency(heard: Heard, found: TimeFit) -> np.ndarray:
    """(K,) Hz natural, unfolded where the frame rate folded it: the damped pitch is what folds."""
    rate = 1 / found.law.takes[found.law.fitted[0]].frame
    damped = found.frequency * np.sqrt(1 - found.damping_ratio**2)
    true = true_pitches(damped, heard.match.modes, heard.body.modes.frequency, rate)
    natural = np.hypot(true, found.damping_ratio * found.frequency)
    return np.where(true != damped, natural, found.frequency)


def unfold(heard: Heard, found: TimeFit) -> TimeFit:
    """The fit with every folded mode at its true pitch, as a bake plays it."""
    true, seen, K = true_frequency(heard, found), found.frequency, found.law.modes
    p, law = found.parameters.copy(), replace(found.law, damping="free")
    for at in range(0, found.law.sizes()[0], 2 * K):
        p[at + K : at + 2 * K] = found.damping_ratio
    a, _, _ = found.law.sizes()
    rate = 1 / found.law.takes[found.law.fitted[0]].frame
    for k in np.flatnonzero(true != seen):
        p[k] = np.log(true[k])
        p[K + k] *= seen[k] / true[k]
        back, on = (
            abs(np.round(x / rate) * rate - x) for x in (true[k] + seen[k], true[k] - seen[k])
        )
        for take in range(len(found.law.fitted)):
            if back < on:  # n r - f runs through the same places the other way round
                p[a + 2 * K * take + K + k] *= -1
    return replace(found, law=law, parameters=p)


def _folded(heard: Heard, found: TimeFit) -> list[Seen]:
    law = found.law
    data = law.takes[law.fitted[0]]
    true, seen = true_frequency(heard, found), found.frequency
    out = []
    for k in np.flatnonzero(true != seen):
        half = SURE * seen[k] * np.sqrt(found.covariance[k, k] * inflation(found))
        waves = [np.outer(u[:, k], found.shapes[k]) for u in found.motions]
        wave = waves[0]
        share = np.sqrt(np.mean((wave / data.sigma)[data.fit] ** 2)) / motion_rms(law.takes)
        without = list(found.predicted)
        for index, one in zip(law.fitted, waves, strict=True):
            without[index] = without[index] - one
        told = {
            "name": "aliasing",
            "parameters": {"frequency": estimate(true[k], true[k] - half, true[k] + half, "Hz")},
            "probability": 1.0,
            "twins": [],
        }
        before = error_of(law.takes, without)
        shows = any(before.over(errors(found), MORE))
        out.append(Seen(told, float(share), before, shows))
    return sorted(out, key=lambda one: -one.share)[:1]


def _near(heard: Heard, verdict: Verdict) -> list[Seen]:
    final = verdict.final if heard.far is None else heard.far.declared
    if any(effect.name == "perspective" for effect in final.law.effects):
        return []
    near = rest_places(heard, final)
    if near is None:
        return []
    behind = final.law.setting.behind
    (known,) = perspective.EFFECT.parameters
    half = SURE * np.hypot(near.sigma, known.form * near.slope)
    distance, low, high = (1 / max(near.slope + way * half, 1e-9) + behind for way in (0, 1, -1))
    told = {
        "name": "perspective",
        "parameters": {"distance": estimate(distance, low, high, "m")},
        "probability": 1.0,
        "twins": [],
    }
    return [Seen(told, MATERIAL, errors(final) if heard.far is None else None)]


def _late(heard: Heard, found: TimeFit) -> list[Seen]:
    law, shutter = found.law, rolling_shutter.EFFECT
    there = any(effect.name == shutter.name for effect in law.effects)
    turning = [k for k in law.turning if heard.match.modes[k] is not None]
    if there or not turning or shutter.requires(law.setting, [law.takes[i] for i in law.fitted]):
        return []
    k = max(turning, key=lambda n: found.swings[n])
    alike = [
        n for n, i in enumerate(law.fitted) if law.condition[i] == law.condition[law.fitted[0]]
    ]
    ellipses = [_ellipse(heard, found, k, take) for take in alike]
    told = rolling_shutter.lag(ellipses)
    frame = law.takes[law.fitted[0]].frame
    if told is None or not told.certain or abs(told.readout) > WHOLE * frame:
        return []
    without, changes = list(found.predicted), []
    for take, one in zip(alike, ellipses, strict=True):
        index = law.fitted[take]
        data = law.takes[index]
        on = ~data.support
        wave = np.exp(one.pole * data.time)[:, None] * (one.nearest(0.0) - one.amplitude)
        change = np.zeros_like(data.values)
        change[:, on] = wave.real * data.sigma[on]
        without[index] = without[index] + change
        changes.append((wave.real)[data.fit])
    share = np.sqrt(np.mean(np.concatenate(changes) ** 2)) / motion_rms(law.takes)
    half = student_t.ppf(0.975, told.free) * told.sigma
    readout = estimate(told.readout, told.readout - half, told.readout + half, "s")
    effect = {
        "name": shutter.name,
        "parameters": {"readout": readout},
        "probability": 1.0,
        "twins": [],
    }
    before = error_of(law.takes, without)
    return [Seen(effect, float(share), before)]


def _ellipse(heard: Heard, found: TimeFit, k: int, take: int) -> Ellipse:
    """How mode k swings in a fitted take, with its partner."""
    law = found.law
    data, condition = law.takes[law.fitted[take]], law.condition[law.fitted[take]]
    body, on, first = heard.bodies[condition], ~data.support, law.own * condition
    omega, _, ((moved, speed),), _ = unpack(law, found.parameters[None], take)
    pole = complex(poles(found.frequency[k], found.damping_ratio[k]))
    start = moved[k] + 1j * (pole.real * moved[k] - speed[k]) / pole.imag
    amplitude = start * found.coefficients[:, first + k]
    if k in law.turning:
        across = found.coefficients[:, first + law.modes + law.turning.index(k)]
        amplitude = amplitude + start * across * pole / omega[0, k]
    for effect, shape in zip(law.effects, found.column_shapes(take), strict=True):
        if is_of(effect, k):
            amplitude = amplitude + shape[:, 0] - 1j * shape[:, 1]
    own = body.modes.frequency
    pair = np.abs(own / own[heard.match.modes[k]] - 1) < 2 * PAIR
    return Ellipse(
        (amplitude / data.sigma)[on],
        (body.seen(data)[pair] / data.sigma)[:, on],
        data.row[on],
        pole,
    )
