"""Rows are exposed one after another, so low markers are seen later.

Law         a marker at row r of H is seen at t + readout r/H
Tells       the phase of each mode shape is linear in the row
Looks like  non-proportional damping when the markers share few rows
Source      Liang, Chang, Chen, IEEE Trans. Image Process. 17 (2008) 1323
"""

import numpy as np

from .base import Effect, Parameter


def delay(theta, setting, row):
    """s (B, C, T) for rows (C, T); theta = readout in periods of the first mode."""
    return theta[:, :1, None] * (2 * np.pi / setting.omega[0]) * (row - row.mean())


def requires(setting, takes):
    """Pixels on two rows at least, and a readout that is not known."""
    camera = takes[0].take.recording.camera
    if camera is None:
        return "the tracks are 3-D"
    if camera.readout is not None:
        return "the readout is declared"
    return "" if np.ptp(takes[0].row) > 0.02 else "all markers lie on one row"


EFFECT = Effect(
    name="rolling_shutter",
    layer="camera",
    parameters=(Parameter("readout", "s", 0.0, 0.1, 0.0),),
    twins=(),
    settle="turn the camera by a quarter: the delay turns with it",
    low=(-0.5,),
    high=(0.5,),
    starts=lambda setting, residual: [(0.01,)],
    delay=delay,
    report=lambda theta, setting, shape: {"readout": theta[0] * 2 * np.pi / setting.omega[0]},
    requires=requires,
)
