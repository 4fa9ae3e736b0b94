"""Takes as channels: one column per marker and axis, with its noise, its row and its fit part."""

from dataclasses import dataclass, replace

import numpy as np

from .data import Take, seal
from .errors import RecordingError
from .shutter import height, rows_of

FITTED = 2 / 3  # of the free motion of a take that is not held out


@dataclass(frozen=True, eq=False)
class Channels:
    """The free motion of one take, flattened to C = markers x axes columns.

    `directions` maps a displacement of the channel's marker to the channel, metres to metres
    (3-D) or metres to pixels (2-D), at the marker's rest place.
    """

    time: np.ndarray  # (T,) s since the release
    values: np.ndarray  # (T, C) m or px; NaN = missing
    sigma: np.ndarray  # (C,) noise, rms
    fit: np.ndarray  # (T,) bool: samples that may be fitted; the others are held out
    marker: np.ndarray  # (C,) index into the recording's markers
    support: np.ndarray  # (C,) bool: sits on the support
    directions: np.ndarray  # (C, 3)
    row: np.ndarray  # (C,) share of the picture's height, 0 top to 1 bottom; 0 for 3-D
    rows: np.ndarray  # (T, C) the same as seen in each frame
    rest: np.ndarray  # (C,) where the declared rest place is seen
    quiet: np.ndarray  # (C,) mean before the release, NaN where nothing was recorded
    take: Take
    doubt: np.ndarray | None = None  # (C,) by how much what is foretold of it may be off, rms
    arcs: float = 0.0  # rms over the motion's, of how far its markers go aside, which is taken off

    def __post_init__(self):
        T, C = len(self.time), len(self.sigma)
        seal(self, "time", float, (None,))
        seal(self, "values", float, (T, C), finite=False)
        seal(self, "sigma", float, (C,))
        seal(self, "fit", bool, (T,))
        if self.doubt is not None:
            seal(self, "doubt", float, (C,))

    @property
    def known(self) -> np.ndarray:
        """(T, C) bool: samples that exist."""
        return np.isfinite(self.values)

    @property
    def late(self) -> np.ndarray | None:
        """(T, C) s by which a known rolling shutter took each sample after its frame's instant."""
        camera = self.take.recording.camera
        return camera.readout * self.rows if camera is not None and camera.readout else None

    @property
    def unsure(self) -> np.ndarray:
        """(C,) noise and doubt, rms: less than that shows nothing."""
        return self.sigma if self.doubt is None else np.hypot(self.sigma, self.doubt)

    @property
    def frame(self) -> float:
        """s, the usual step between two samples."""
        return float(np.median(np.diff(self.time)))


def axes_of(data) -> np.ndarray:
    """(C,) the axis of every channel, from nought."""
    axes = np.zeros(len(data.marker), int)
    for m in np.unique(data.marker):
        axes[data.marker == m] = np.arange((data.marker == m).sum())
    return axes


def reaches(data: Channels) -> tuple[np.ndarray, np.ndarray]:
    """(C,) and (C,), on any scale, what the channels see of one shared motion: all the same, as
    where the camera turns; and, where it or the support goes aside, the more the nearer they are.
    """
    camera, alike = data.take.recording.camera, np.ones(len(data.marker))
    if camera is None:
        return alike, alike
    return alike, np.einsum("ci,ci->c", data.directions, camera.rows[axes_of(data)])


def free_motion(take: Take, window: tuple[float, float], noise: np.ndarray) -> Channels:
    """The channels (C = n d) of `take` between the release and the end, `window` in s.

    `noise` (C,) is each channel's rms noise in its own unit. The last third of one that is fitted
    is kept back. Raises RecordingError where fewer than 12 frames are left.
    """
    recording = take.recording
    inside = (recording.time >= window[0] - 1e-9) & (recording.time <= window[1] + 1e-9)
    T, n, d = recording.values.shape
    if inside.sum() < 12:
        raise RecordingError(
            f"recording {take.name}: {inside.sum()} frames of free motion; 12 are needed. "
            "Move start and stop apart, or record longer."
        )
    values = recording.values.reshape(T, n * d)
    time = recording.time[inside] - window[0]
    before = recording.time < window[0] - 0.02
    quiet = np.full(n * d, np.nan)
    if before.sum() >= 3 and np.isfinite(values[before]).any(axis=0).all():
        quiet = np.nanmedian(values[before], axis=0)
    places = np.array([marker.position for marker in recording.markers])
    directions, rest, row = _geometry(recording, places, d)
    share = 1.0 if take.held_out else FITTED
    return Channels(
        time=time,
        values=values[inside],
        sigma=noise,
        fit=time <= time[-1] * share + 1e-12,
        marker=np.repeat(np.arange(n), d),
        support=np.repeat([m.on == "support" for m in recording.markers], d),
        directions=directions,
        row=row,
        rows=np.zeros(values[inside].shape) if d == 3 else _rows(recording, values[inside], rest),
        rest=rest,
        quiet=quiet,
        take=take,
    )


def cut(data: Channels, n: int) -> Channels:
    """The first n frames of a take."""
    rows = {name: getattr(data, name)[:n] for name in ("time", "values", "fit", "rows")}
    return replace(data, **rows)


def _geometry(recording, places, d):
    """Directions (C, 3), rest (C,), rows (C,) of all channels."""
    n = len(places)
    if d == 3:
        return np.tile(np.eye(3), (n, 1)), places.ravel(), np.zeros(n * 3)
    camera = recording.camera
    seen = camera.project(places)
    row = _rows(recording, seen.reshape(1, -1), seen.ravel())[0]
    return camera.jacobian(places).reshape(-1, 3), seen.ravel(), row


def _rows(recording, values, rest):
    camera = recording.camera
    return rows_of(values, rest, height(camera))
