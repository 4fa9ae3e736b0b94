"""From tracks without a body to what rings in them: the story behind `ringdown VIDEO`."""

from dataclasses import dataclass

import numpy as np

from .data import RingDown, seal
from .errors import RecordingError
from .harmonic_inversion import invert
from .release import find_release

__all__ = ["Heard", "aliases", "find_release", "hear", "ringdown_report"]

NORMAL = 1.959964  # standard deviations in half a 95 % interval
CROWDED = 0.3  # of the frame rate: slower motion has over three frames a period and is believed
FOLDS = 2.0  # frame rates up to which true frequencies are listed
PERIODS = 2.0  # of the strongest mode that a recording must hold
SEEN = 0.5  # of the frames that a point must be seen in
STEADY = 1e-4  # damping ratio below which nothing soft, and few forks, can stay
MOST_MODES = 8


@dataclass(frozen=True, eq=False)
class Heard:
    """What was found in the tracks of one clip, with what it was found from."""

    time: np.ndarray  # (T,) s, the whole clip
    values: np.ndarray  # (T, n, d) px or m, the points that were used; NaN = missing
    start: float  # s, the free motion begins
    stop: float  # s, and ends
    ring: RingDown  # of the channels point by axis, in the order of `values`
    aliases: tuple[tuple[float, ...], ...]  # Hz, one for each mode
    fps: float  # frames per second of real time
    points: np.ndarray  # (n,) which of the points given were used
    unit: str  # "px" | "m"
    warnings: tuple[str, ...] = ()

    def __post_init__(self):
        seal(self, "time", float, (None,))
        seal(self, "values", float, (len(self.time), None, None), finite=False)
        seal(self, "points", int, (self.values.shape[1],))

    @property
    def deflection(self) -> np.ndarray:
        """(m, n, d) complex amplitudes of the points at the release, unit as `values`."""
        return self.ring.amplitude.reshape(len(self.ring.frequency), *self.values.shape[1:])

    @property
    def amplitude(self) -> np.ndarray:
        """(m,) peak displacement of the point that moves most."""
        return np.linalg.norm(self.deflection, axis=2).max(axis=1)


def hear(
    tracks,
    fps: float,
    *,
    start: float | None = None,
    stop: float | None = None,
    metres_per_pixel: float | None = None,
    max_modes: int = MOST_MODES,
) -> Heard:
    """Modes of `tracks`: anything with `time` (T,) s, `values` (T, n, d) px and `warnings`.

    `fps`: frames per second of real time. `start`, `stop` (s): the free motion, else detected.
    With `metres_per_pixel` the amplitudes are in metres. Raises RecordingError where nothing
    moves, no mode stands out, or fewer than two periods of the strongest one are there.
    """
    time, values = np.asarray(tracks.time, float), np.asarray(tracks.values, float)
    scale = 1.0 if metres_per_pixel is None else metres_per_pixel
    start, stop = _window(time, values, start, stop)
    inside = (time >= start - 1e-9) & (time <= stop + 1e-9)
    points = _usable(values[inside])
    values = values[:, points] * scale
    part = values[inside].reshape(inside.sum(), -1)
    ring = invert(time[inside], part, max_modes=max_modes)
    _check(ring, time[inside])
    folds = tuple(tuple(aliases(f, fps)) for f in ring.frequency)
    dropped = np.asarray(tracks.values).shape[1] - len(points)
    warnings = (*tracks.warnings, *_warnings(ring, folds, fps, dropped))
    unit = "px" if metres_per_pixel is None else "m"
    return Heard(time, values, start, stop, ring, folds, fps, points, unit, warnings)


def aliases(frequency: float, fps: float, limit: float | None = None) -> list[float]:
    """True frequencies (Hz) that sampling at `fps` could show as `frequency`; empty where unlikely.

    They are |k fps +- f|, up to `limit` (Hz, default twice `fps`). Motion that has more than three
    frames in a period is taken at its word, unless a `limit` asks.
    """
    if limit is None and frequency < CROWDED * fps:
        return []
    limit = FOLDS * fps if limit is None else limit
    folds = [k * fps + sign * frequency for k in range(1, int(limit / fps) + 2) for sign in (-1, 1)]
    return sorted(f for f in folds if 0 < f <= limit and abs(f / frequency - 1) > 1e-9)


def ringdown_report(heard: Heard) -> dict:
    """ringdown.json as the contract has it; `amplitude_px` where no scale is known."""
    modes = []
    ring = heard.ring
    for k, (f, z) in enumerate(zip(ring.frequency, ring.damping_ratio, strict=True)):
        spread_f, spread_z = NORMAL * ring.frequency_sigma[k], NORMAL * ring.damping_sigma[k]
        modes.append(
            {
                "natural_frequency_hz": {
                    "value": float(f),
                    "ci95": [float(f - spread_f), float(f + spread_f)],
                },
                "damping_ratio": {
                    "value": float(z),
                    "ci95": [float(max(z - spread_z, 0)), float(z + spread_z)],
                },
                f"amplitude_{heard.unit}": float(heard.amplitude[k]),
                "aliases_hz": list(heard.aliases[k]),
            }
        )
    return {"modes": modes, "warnings": list(heard.warnings)}


def _window(time, values, start, stop) -> tuple[float, float]:
    if start is None or stop is None:
        late = time >= (-np.inf if start is None else start)
        late &= time <= (np.inf if stop is None else stop)
        if late.sum() < 2:
            raise RecordingError("Ring-down: no frames between start and stop. Mend them.")
        found = find_release(time[late], values[late].reshape(late.sum(), -1))
        start = found[0] if start is None else start
        stop = found[1] if stop is None else stop
    return start, stop


def _usable(values: np.ndarray) -> np.ndarray:
    """Indices of points that are seen for long enough."""
    seen = np.isfinite(values).all(axis=2).mean(axis=0)
    points = np.flatnonzero(seen >= SEEN)
    if not len(points):
        raise RecordingError(
            f"Ring-down: the best of {len(seen)} points is seen in {max(seen, default=0):.0%} of "
            f"the frames; {SEEN:.0%} are needed. Choose points that stay in view."
        )
    return points


def _check(ring: RingDown, time: np.ndarray) -> None:
    if not len(ring.frequency):
        raise RecordingError(
            "Ring-down: no oscillation stands out of the noise. Release it from further out, come "
            "closer with the camera, or film sooner after the release."
        )
    cycles = ring.frequency[0] * np.ptp(time)
    if cycles < PERIODS:
        raise RecordingError(
            f"Ring-down: the clip holds {np.ptp(time):.3g} s of free motion, {cycles:.2g} periods "
            f"of the strongest mode; {PERIODS:g} are needed. Record longer."
        )


def _warnings(ring: RingDown, folds, fps: float, dropped: int) -> list[str]:
    said = []
    if dropped:
        said.append(f"{dropped} points were seen in less than {SEEN:.0%} of the frames: left out.")
    for f, z, sigma, others in zip(
        ring.frequency, ring.damping_ratio, ring.damping_sigma, folds, strict=True
    ):
        if others:
            listed = ", ".join(f"{other:.5g}" for other in others)
            said.append(
                f"A mode is seen at {f:.5g} Hz with {fps / f:.2g} frames a period at {fps:g} "
                f"frames/s: it may truly be at {listed} Hz. A second frame rate would tell."
            )
        if z + NORMAL * sigma < STEADY:
            said.append(
                f"The motion at {f:.5g} Hz does not decay: it looks driven (a motor, the mains), "
                "or the capture rate is not what was declared."
            )
    return said
