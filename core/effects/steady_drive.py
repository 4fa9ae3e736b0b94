"""A steady outside vibration: a fan, a pump, traffic.

Law         the support moves by a sin(2 pi F t + p)
Tells       a line that does not decay, and stays after the ring-down
Looks like  a lightly damped mode while the record is short
Source      Den Hartog, Mechanical Vibrations (1956), 2.8
"""

from dataclasses import replace

import numpy as np

from .base import Effect, Parameter, along_modes, companion
from .further_mode import further_mode

RESONANT = 0.06  # relative distance from a pitch
LIVELIEST = 0.3  # of the first mode's damping ratio that a mode has at least
HIDDEN = 0.31  # of a motion anywhere in space that a flat view shows at least, 19 times of 20
UNSEEN = 0.2  # of the clearest direction: a support's motion seen less than that is not told
CYCLES = 2.0  # in the longest fitted take, what was held out of it included: fewer may be anything
STILL = 1.2  # misfit per sample that a true line at resonance leaves at most


def columns(theta, setting, time, u):
    """cos and sin of the line, each with a shape of its own; theta = log of its frequency."""
    phase = 2 * np.pi * np.exp(theta[:, 0])[:, None] * time
    return np.stack([np.cos(phase), np.sin(phase)], axis=2)


def starts(setting, residual):
    """The three strongest lines of the second half of the residual [(time, (T, C))]."""
    time, values = residual
    half = len(time) // 2
    tail, span = values[half:], time[-1] - time[half]
    step = np.median(np.diff(time))
    grid = np.arange(1 / max(span, 1e-9), 0.45 / step, 0.2 / max(span, 1e-9))
    if not len(grid):
        return []
    wave = np.exp(-2j * np.pi * np.outer(grid, time[half:]))
    power = (np.abs(wave @ np.nan_to_num(tail - np.nanmean(tail, axis=0))) ** 2).sum(axis=1)
    found = []
    for i in np.argsort(-power):
        if all(abs(grid[i] - f) > 1.5 / span for f in found):
            found.append(grid[i])
        if len(found) == 3:
            break
    return [(np.log(f),) for f in found]


def report(theta, setting, shape):
    """Hz, and m of the support: what it must do for the body to be seen as it is."""
    frequency, response = np.exp(theta[0]), shape @ np.array([1, -1j])
    if setting.support is None:  # the first mode's motion, as if it moved as a whole
        r = 2 * np.pi * frequency / setting.omega[0]
        gain = 1 / abs(1 - r**2 + 2j * setting.zeta[0] * r)
        return {"frequency": frequency, "amplitude": abs(setting.reference[0] @ response) / gain}
    path = np.linalg.lstsq(setting.support(frequency), response, rcond=UNSEEN)[0]
    sway = np.linalg.norm(np.array([path.real, path.imag]), 2)  # an ellipse's longer half axis
    return {"frequency": frequency, "amplitude": float(sway)}


def carries(found, i, take):
    """The body's own motion, without what the support moves it by."""
    law, rate = found.law, np.exp(found.theta[i][0][0])
    seen = found.column_shapes(take)[i]
    if law.setting.support is not None:
        response = seen @ np.array([1, -1j])
        sway = np.linalg.lstsq(law.setting.support(rate), response, rcond=UNSEEN)[0]
        own = response - law.takes[law.fitted[take]].directions @ sway
        seen = np.stack([own.real, -own.imag], axis=1)
    size = along_modes(found, seen, take)

    def path(time):
        phase = 2 * np.pi * rate * time
        return np.stack([np.cos(phase), np.sin(phase)], axis=1) @ size.T

    return path


def alike(theta, setting, shape):
    """A support may move along where the camera looks as well."""
    told = report(theta, setting, shape)
    if setting.support is not None:
        clear = np.linalg.svd(setting.support(told["frequency"]), compute_uv=False)
        if len(clear) == 3 and clear[2] > UNSEEN * clear[0]:
            return []
    return [told | {"amplitude": told["amplitude"] / HIDDEN}]


def rival(found):
    """A mode of the body at the same pitch: what dies away is none of the world's doing."""
    setting, frequency = found.law.setting, np.exp(found.theta[-1][0][0])
    usual = float(np.clip(setting.zeta[0], 1e-3, 0.3))
    mode = further_mode(frequency, usual)
    return replace(mode, low=(mode.low[0], LIVELIEST * usual))


def veto(found):
    """A line at the first pitch and in its shape mimics whatever bends the envelope."""
    law, frequency = found.law, np.exp(found.theta[-1][0][0])
    # what was held out of a take counts: a line must foretell it to be told
    if frequency * max(np.ptp(law.takes[i].time) for i in law.fitted) < CYCLES:
        return "too few cycles"
    near = _is_near(frequency, found.frequency[:1])
    if near and companion(found, 0) and found.chi2 > STILL * found.samples:
        return "it goes with the first mode"
    return ""


def is_resonant(found):
    """Whether a fit holds such a line, at the pitch of one of its modes."""
    return any(
        e.name == EFFECT.name and _is_near(np.exp(theta[0][0]), found.frequency)
        for e, theta in zip(found.law.effects, found.theta, strict=True)
    )


def _is_near(frequency, pitches):
    return bool((np.abs(np.log(frequency / pitches)) < RESONANT).any())


EFFECT = Effect(
    name="steady_drive",
    layer="time",
    parameters=(
        Parameter("frequency", "Hz", 0.0, 1e4, 0.0),
        Parameter("amplitude", "m", 0.0, 10.0),
    ),
    twins=(),
    settle="film the object at rest: a line that stays comes from outside",
    low=(np.log(0.02),),
    high=(np.log(2e3),),
    starts=starts,
    columns=columns,
    carries=carries,
    phased=True,
    veto=veto,
    report=report,
    alike=alike,
    rival=rival,
)
