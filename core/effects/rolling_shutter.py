"""Rows are exposed one after another, so low markers are seen later.

Law         a marker at row r of H is seen at t + readout r/H; readout < 0 where the picture was
            turned upside down after the rows were read
Tells       the phase of each mode shape is linear in the row. A degenerate pair may swing in any
            ellipse, so free shapes take that up: there the body's own shapes tell, for in the
            plane that both its directions span no marker lags by its row
Looks like  non-proportional damping when the markers share few rows
Source      Liang, Chang, Chen, IEEE Trans. Image Process. 17 (2008) 1323
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import f as f_law

from .base import Effect, Parameter, too_faint

DOUBTFUL = 4.0  # standard deviations
MOST = 0.8  # share of what a pair's own directions leave, that a shutter must take
CHANCE = 1e-6  # that wrong shapes look like a shutter
LOOKS = 41  # readouts that a search begins from


@dataclass(frozen=True, eq=False)
class Ellipse:
    """How a degenerate pair swings in one take."""

    amplitude: np.ndarray  # (C,) complex, in noise
    directions: np.ndarray  # (n, C) how the body's own directions look, in noise
    row: np.ndarray  # (C,)
    pole: complex  # 1/s

    def nearest(self, readout: float) -> np.ndarray:
        """(C,) the ellipse of the body's own directions nearest to it, with such a readout."""
        seen = self.directions.T * np.exp(self.pole * readout * self.row)[:, None]
        return seen @ np.linalg.lstsq(seen, self.amplitude, rcond=1e-8)[0]

    def left(self, readout: float) -> float:
        """What that leaves, squared."""
        return float((np.abs(self.amplitude - self.nearest(readout)) ** 2).sum())


@dataclass(frozen=True)
class Lag:
    """What the ellipses say of the readout."""

    readout: float  # s
    sigma: float  # s
    certain: bool  # that there is one
    free: int  # degrees of freedom behind sigma


def lag(ellipses: list[Ellipse]) -> Lag | None:
    """The readout by which markers lag beside a body's own directions; None where too few show."""
    free = sum(2 * len(one.amplitude) - 2 * len(one.directions) for one in ellipses) - 1
    if free < 1:
        return None

    def left(readout):
        return sum(one.left(readout) for one in ellipses)

    reach = EFFECT.high[0] * 2 * np.pi / max(abs(one.pole) for one in ellipses)
    tries = np.linspace(-reach, reach, LOOKS)
    step = tries[1] - tries[0]
    best = tries[np.argmin([left(t) for t in tries])]
    best = minimize_scalar(
        left, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-4 * step}
    ).x
    rest, before = left(best), left(0.0)
    h = 0.1 * step
    bend = max((left(best + h) - 2 * rest + left(best - h)) / h**2, 1e-300)
    sigma = np.sqrt(2 * rest / free / bend)
    gain = before - rest
    certain = (
        abs(best) > DOUBTFUL * sigma
        and gain > MOST * before
        and f_law.sf(gain / (rest / free), 1, free) < CHANCE
    )
    return Lag(float(best), float(sigma), bool(certain), free)


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
    parameters=(Parameter("readout", "s", -0.1, 0.1, 0.0),),
    twins=(),
    settle="turn the camera by a quarter: the delay turns with it",
    low=(-0.5,),
    high=(0.5,),
    starts=lambda setting, residual: [(0.01,)],
    delay=delay,
    report=lambda theta, setting, shape: {"readout": theta[0] * 2 * np.pi / setting.omega[0]},
    requires=requires,
    veto=too_faint,
)
