"""One more mode of the body that no computed mode was matched to: part of it, not an effect.

Law         one more decaying motion with a pitch, a damping ratio and a shape of its own
Tells       a pole that is no overtone, no combination and no double of a known one
Looks like  an overtone or a combination tone when its pitch happens to be there
Source      Ewins, Modal Testing (2000), 4.4: residual modes
"""

from dataclasses import replace

import numpy as np

from .base import Effect, of_takes, ring

STRAY = 0.05  # relative, that its pitch may move
EDGE = 0.98  # of that, from which it is at the bound
LIGHT, DAMPED = 1e-4, 0.4  # damping ratio, at least and at most
TIMES = 3.0  # what it was heard with, that its damping ratio may be
LAYER = "mode"


def further_mode(frequency: float, damping_ratio: float, takes: tuple = ()) -> Effect:
    """The mode heard at `frequency` Hz; theta = (log of its pitch over that, damping ratio).

    takes: see `of_takes`.
    """

    def columns(theta, setting, time, u):
        omega = 2 * np.pi * frequency * np.exp(theta[:, 0])[:, None]
        return ring(omega, theta[:, 1][:, None], time)

    return Effect(
        name=f"mode at {frequency:.3g} Hz",
        layer=LAYER,
        parameters=(),
        twins=(),
        settle="",
        low=(-STRAY, LIGHT),
        high=(STRAY, float(np.clip(TIMES * damping_ratio, 3 * LIGHT, DAMPED))),
        starts=lambda setting, residual: [(0.0, damping_ratio)],
        columns=columns,
        of_release=True,
        phased=True,
        channels=of_takes(takes),
        report=lambda theta, setting, shape: {"frequency": frequency * np.exp(theta[0])},
    )


def pitch_of(effect: Effect, theta: np.ndarray) -> float:
    """Hz"""
    return float(effect.report(theta, None, None)["frequency"])


def is_further(effect: Effect) -> bool:
    """Whether an effect is one of these."""
    return effect.layer == LAYER


def is_a_mode(effect: Effect, theta: np.ndarray) -> bool:
    """Whether it stayed clear of what it may be: at the bounds it takes up something else."""
    return abs(theta[0]) < EDGE * STRAY and 2 * LIGHT < theta[1] < 0.95 * effect.high[1]


def heard_anew(effect: Effect, theta: np.ndarray) -> Effect:
    """The mode, heard where a fit moved it to if that is the bound of its pitch."""
    return effect if abs(theta[0]) < EDGE * STRAY else as_it_is(effect, theta)


def as_it_is(effect: Effect, theta: np.ndarray) -> Effect:
    """The mode, heard as a fit found it, but damped by half of its bound at most: its pitch may
    move as far from there as from where it was, its damping keeps the bound that it has.
    """
    damping_ratio = np.clip(theta[1], 2 * LIGHT, effect.high[1] / 2)
    anew = further_mode(pitch_of(effect, theta), damping_ratio)
    return replace(anew, channels=effect.channels, high=(STRAY, effect.high[1]))


def of_take(found, take: int) -> list[tuple[int, Effect, np.ndarray]]:
    """Number among the effects, effect and theta of the further modes in a take of a fit (TimeFit),
    by its number among the fitted ones.
    """
    law = found.law
    data = law.takes[law.fitted[take]]
    return [
        (i, effect, theta[0])
        for i, (effect, theta) in enumerate(zip(law.effects, found.theta, strict=True))
        if is_further(effect)
        and (effect.channels is None or effect.channels(law.setting, data).any())
    ]


def ran_off(found) -> bool:
    """Whether a further mode of a fit (TimeFit) is one no longer."""
    return any(
        is_further(effect) and not is_a_mode(effect, theta[0])
        for effect, theta in zip(found.law.effects, found.theta, strict=True)
    )
