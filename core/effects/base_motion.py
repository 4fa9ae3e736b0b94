"""The support or the camera moves: every marker moves along.

Law         y_m += s(t), the same for all markers
Tells       what is left is common to all markers, those on the support included
Looks like  mode 1 when the markers sit close together; a marker on the support settles it
Source      Ewins, Modal Testing (2000), 3.3: the reference must be measured
"""

import numpy as np

from .base import Effect, Parameter

SETTLE = "stick a marker on the support, or film something that stands still beside it"


def common_motion(data, residual: np.ndarray) -> np.ndarray:
    """(T, C) what the other markers share, per axis; from the support's markers where there are."""
    axes = np.zeros(len(data.marker), int)
    for m in np.unique(data.marker):
        axes[data.marker == m] = np.arange((data.marker == m).sum())
    shared = np.zeros_like(residual)
    some_support = data.support.any()
    for axis in np.unique(axes):
        on = np.flatnonzero(axes == axis)
        for c in on:
            pool = [o for o in on if o != c and (data.support[o] or not some_support)]
            if not pool:
                continue
            weight = np.where(np.isnan(residual[:, pool]), 0, 1 / data.sigma[pool] ** 2)
            sums = np.nansum(residual[:, pool] * weight, axis=1)
            shared[:, c] = sums / np.maximum(weight.sum(axis=1), 1e-300)
    return shared


def shaken(shared: tuple[np.ndarray, ...], rms: float, free: int) -> Effect:
    """The motion `shared`, per take (T, C), taken off; `rms` of it in m, `free` numbers in it."""
    return Effect(
        name="base_motion",
        layer="camera",
        parameters=(Parameter("rms", "m", 0.0, 10.0),),
        twins=(),
        settle=SETTLE,
        starts=lambda setting, residual: [()],
        given=lambda take: shared[take],
        free=free,
        report=lambda theta, setting, shape: {"rms": rms},
    )
