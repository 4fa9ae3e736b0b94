"""Stiffer one way than the other: a curved wall, a fold, a preload that slackens.

Law         u'' + ... + w^2 u = -w^2 b |x|^p A^(1-p), p = 1 (bilinear) to 2 (quadratic)
Tells       the mean shifts with amplitude, a second harmonic; both flip with the side of release
Looks like  contact, relaxation, perspective; release from both sides settles it
Source      Nayfeh and Mook, Nonlinear Oscillations (1979), 2.3.1 (quadratic), ch. 3 (bilinear)
"""

import numpy as np

from . import perspective
from .base import Effect, Parameter


def force(theta, setting):
    """Even force at the reference; theta = (b, p)."""
    stiffness = -(setting.omega[0] ** 2) * theta[:, 0] * setting.amplitude
    power = theta[:, 1]
    return lambda state: stiffness * (np.abs(state.x) / setting.amplitude + 1e-12) ** power


def report(theta, setting, shape):
    """Secant stiffness of the stiffer side over the other at the first amplitude, of the mode that
    it bends most: a degenerate pair may swing across where it acts, too.
    """
    place = np.r_[1.0, theta[2 : 1 + len(setting.omega)]]
    bends = place**2 * setting.masses * (setting.omega[0] / setting.omega) ** 2
    b = min(abs(theta[0]) * bends.max(), 0.95)
    return {"ratio": (1 + b) / (1 - b)}


EFFECT = Effect(
    name="asymmetric_stiffness",
    layer="time",
    bends=True,
    parameters=(Parameter("ratio", "1", 1.0, 40.0),),
    twins=("contact", "relaxation", "perspective"),
    settle="release it once from the other side: the shift of the mean changes its sign",
    low=(-0.8, 1.0),
    high=(0.8, 2.0),
    starts=lambda setting, residual: [(0.05, 1.0), (0.05, 1.5)],
    force=force,
    scales=True,
    report=report,
    rival=perspective.instead,
)
