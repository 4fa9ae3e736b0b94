"""A rubbing contact: a force of constant size against the motion, after some elastic slip.

Law         f = -F z, z' = x'/d while |z| < 1 (Jenkins element: a spring of travel d and a slider;
            the body gives way where it is rubbed, and that is part of d); along a line, or, where
            the place goes to and fro and sideways, in a plane: x, z and f have two components
Tells       the envelope falls by the same amount each cycle, a dead stop, an offset that stays
Looks like  air_drag of negative sign with more damping; stiffness_drift for a short record
Source      Iwan, J. Appl. Mech. 33 (1966) 893; Rayleigh, The Theory of Sound, vol. 1, 46
"""

from dataclasses import replace

import numpy as np

from .base import Effect, Parameter, too_faint

FIERCER, TRAVELS = (0.6, 1.0), (-5.0, -4.0)  # what else it may be beside modes that it rings


def force(theta, setting):
    """theta = (force over modal stiffness times amplitude, log of travel over amplitude)."""
    per_metre = np.exp(-theta[:, 1]) / setting.amplitude
    size = theta[:, 0] * setting.omega[0] ** 2 * setting.amplitude
    slip, most, against = np.zeros(len(theta)), np.ones(len(theta)), -size
    least = -most

    def push(state):
        np.add(slip, state.dx * (state.h * per_metre), out=slip)
        np.minimum(slip, most, out=slip)
        np.maximum(slip, least, out=slip)
        return against * slip

    return push


def force_in_plane(theta, setting):
    """theta as for `force`; the slider goes where it is drawn, so what rubs along rubs across."""
    per_metre = np.exp(-theta[:, 1]) / setting.amplitude
    size = theta[:, 0] * setting.omega[0] ** 2 * setting.amplitude
    slip = np.zeros((2, len(theta)))

    def push(state):
        np.add(slip, state.dx * (state.h * per_metre), out=slip)
        np.divide(slip, np.maximum(np.hypot(slip[0], slip[1]), 1.0), out=slip)
        return -size * slip

    return push


def report(theta, setting, shape):
    """N where the rub most likely sits; elsewhere it is as much larger as the place moves less."""
    stiffness = setting.modal_mass * setting.omega[0] ** 2
    place = theta[2 : 1 + len(setting.omega)]
    return {"force": theta[0] * stiffness * setting.amplitude / setting.lever(place)}


EFFECT = Effect(
    name="dry_friction",
    layer="time",
    damps=True,
    parameters=(Parameter("force", "N", 0.0, 1e3),),
    twins=("air_drag",),
    settle="film until it stands still, and once with the suspected place lifted or oiled",
    low=(0.0, np.log(2e-4)),
    high=(0.5, np.log(5.0)),  # a place may move more than the reference in mode 1 does
    starts=lambda setting, residual: [
        (0.001, np.log(0.005)),
        (0.01, np.log(0.01)),
        (0.04, np.log(0.05)),
        (0.15, np.log(0.05)),
        (0.03, np.log(0.3)),
        (0.1, np.log(0.5)),
        (0.003, np.log(2.0)),
    ],
    force=force,
    otherwise=lambda theta: [np.array([f * theta[0], t]) for f in FIERCER for t in TRAVELS],
    places=48,  # with many modes none of a few may be near
    sudden=True,
    report=report,
    veto=too_faint,
)

IN_PLANE = replace(EFFECT, force=force_in_plane, axes=2)
