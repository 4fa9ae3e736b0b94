"""A video's modes: its points followed, their free motion inverted, and what that cannot say."""

from dataclasses import dataclass, replace

import numpy as np

from .aliases import aliases, doubted_rate, fold_warnings
from .data import RingDown, poles, seal
from .deflection import deflection_covariance
from .errors import RecordingError
from .harmonic_inversion import fit_poles, invert
from .match import select
from .pursuit import DEAD
from .ringdown import find_release
from .shutter import at_once, rows_of
from .sift import sift
from .track import Tracks, track
from .track_clarity import clarity, commotion
from .track_points import check_points, pick_points
from .track_steady import relative_to
from .video import FEWEST_FRAMES, Video, frame_at

CHANNELS = 8  # that the modes are read from, the clearest; more tell the same again
CLEAR = 0.1  # of the clearest channel: what is seen less clearly only adds noise
MOST_MODES = 8
PERIODS = 2.0  # of the strongest mode that a clip must hold
RINGING = 1e-5  # damping ratio below which nothing real swings
AUDIBLE = 20e3  # Hz: no camera sees a body swing faster


@dataclass(frozen=True, eq=False)
class VideoModes:
    """The modes of a video and how its points take part in them."""

    tracks: Tracks
    ringdown: RingDown  # the channels are u and v of every point
    covariance: np.ndarray  # (m, 2n, 2, 2) px2 of the real and imaginary part of its amplitudes
    channels: np.ndarray  # indices of the channels that the poles were read from
    stop: float  # s, the end of the free motion; it begins at ringdown.t0
    aliases: tuple[tuple[float, ...], ...] = ()  # Hz, of every mode
    warnings: tuple[str, ...] = ()

    def __post_init__(self):
        seal(self, "channels", int, (None,))
        seal(self, "covariance", float, (None, None, 2, 2), finite=False)

    @property
    def deflection(self) -> np.ndarray:
        """(m, n, 2) complex px: amplitude and phase of every point in every mode, at t0."""
        m = len(self.ringdown.frequency)
        return self.ringdown.amplitude.reshape(m, -1, 2)


def video_modes(
    clip: Video, capture_fps: float, points=None, *, static=None, readout=0.0, progress=None
) -> VideoModes:
    """Modes of the motion of `points` (n, 2) px, or of points picked by themselves (None, empty).

    static (s, 2) px: points on what stands still; their common motion is the camera's and is taken
    out. readout: s, of a rolling shutter from the first row to the last. Raises RecordingError
    where nothing moves, no mode is found, or fewer than two periods of the strongest one are there.
    """
    fixed = np.zeros((0, 2)) if static is None else np.asarray(static, float).reshape(-1, 2)
    if len(fixed):
        check_points(frame_at(clip, 0).grey, fixed)
    given = points is not None and len(points)
    picked = np.asarray(points, float) if given else pick_points(clip, static=fixed)
    both = np.vstack([fixed, picked])
    tracks = track(clip, both, capture_fps=capture_fps, progress=progress)
    if len(fixed):
        tracks = relative_to(tracks, np.arange(len(both)) < len(fixed))
    return modes_of(tracks, clip, capture_fps, readout=readout)


def modes_of(tracks: Tracks, clip: Video, capture_fps: float, *, readout=0.0) -> VideoModes:
    """Modes of the motion of `tracks`, which are of `clip`. Raises as `video_modes` does."""
    tracks = _well_seen(tracks)
    flat = tracks.values.reshape(len(tracks.time), -1)
    channels = _clearest(tracks, flat, clip)
    start, stop = find_release(tracks.time, flat[:, channels])
    free = (tracks.time >= start - 1e-9) & (tracks.time <= stop + 1e-9)
    time = tracks.time[free]
    found = invert(time, flat[free][:, channels], max_modes=MOST_MODES)
    _check_modes(clip, found, np.ptp(time), tracks.warnings)
    enough = np.isfinite(flat[free]).sum(axis=0) >= FEWEST_FRAMES
    everywhere = fit_poles(
        time, flat[free][:, enough], found.frequency, found.damping_ratio, fit=False
    )
    everywhere = _in_the_order_of(found, everywhere, enough)
    covariance = deflection_covariance(time, flat[free], everywhere)
    late = readout * rows_of(flat[free], tracks.points.ravel(), clip.size[1]) if readout else None
    pole = poles(everywhere.frequency, everywhere.damping_ratio)
    everywhere = replace(everywhere, amplitude=at_once(everywhere.amplitude, pole, late))
    modes, told = sift(found, capture_fps)
    found, everywhere = select(found, tuple(modes)), select(everywhere, tuple(modes))
    doubted = doubted_rate(clip, capture_fps)
    folds = tuple(
        tuple(aliases(f, z, capture_fps, doubted=doubted))
        for f, z in zip(found.frequency, found.damping_ratio, strict=True)
    )
    warnings = tracks.warnings + found.warnings + told + _senseless(found, capture_fps)
    warnings += fold_warnings(found, folds, capture_fps)
    return VideoModes(tracks, everywhere, covariance[modes], channels, stop, folds, warnings)


def _clearest(tracks: Tracks, flat: np.ndarray, clip: Video) -> np.ndarray:
    clear = clarity(flat)
    clear = clear if clear.any() else commotion(flat)
    if not clear.any():
        raise RecordingError(
            f"{clip.path.name}: no motion in it; of {len(tracks.points)} followed points none "
            f"moves beyond the noise of {np.nanmedian(tracks.sigma):.2g} px. Film the motion "
            "closer, or pick points that move."
        )
    order = np.argsort(-clear, kind="stable")[:CHANNELS]
    return order[clear[order] > CLEAR * clear[order[0]]]


def _well_seen(tracks: Tracks) -> Tracks:
    """The tracks without points that were lost in most frames; `track` has said so already."""
    seen = np.isfinite(tracks.values[..., 0]).mean(axis=0)
    keep = seen > min(0.5, seen.max() / 2)
    return replace(
        tracks,
        values=tracks.values[:, keep],
        sigma=tracks.sigma[:, keep],
        points=tracks.points[keep],
    )


def _check_modes(clip: Video, found: RingDown, seconds: float, warnings) -> None:
    damage = "".join(f" {said}" for said in warnings if "damaged" in said)
    if not len(found.frequency):
        raise RecordingError(
            f"{clip.path.name}: something moves, but no decaying vibration was found in "
            f"{seconds:.3g} s. Film a free swing of two periods or more: pluck it, let go, and "
            f"keep filming.{damage}"
        )
    periods = seconds * found.frequency[0]
    if periods < PERIODS:
        raise RecordingError(
            f"{clip.path.name}: {seconds:.3g} s after the onset hold {periods:.2g} periods of its "
            f"{found.frequency[0]:.3g} Hz; {PERIODS:g} are needed at least. Film "
            f"longer.{damage}"
        )


def _in_the_order_of(found: RingDown, everywhere: RingDown, enough: np.ndarray) -> RingDown:
    """`found` with the amplitudes that `everywhere` gives the same poles in the channels `enough`.

    The other channels, seen too rarely, get none.
    """
    apart = np.abs(found.frequency[:, None] - everywhere.frequency)
    apart += found.frequency[:, None] * np.abs(
        found.damping_ratio[:, None] - everywhere.damping_ratio
    )
    amplitude = np.zeros((len(found.frequency), len(enough)), complex)
    amplitude[:, enough] = everywhere.amplitude[np.argmin(apart, axis=1)]
    offset, noise = np.zeros(len(enough)), np.zeros(len(enough))
    offset[enough], noise[enough] = everywhere.offset, everywhere.noise
    return replace(found, amplitude=amplitude, offset=offset, noise=noise, t0=everywhere.t0)


def _senseless(found: RingDown, capture_fps: float) -> tuple[str, ...]:
    """Warnings where the modes speak against the declared rate, or the rate against the modes."""
    said = []
    f, z = float(found.frequency[0]), float(found.damping_ratio[0])
    if z > DEAD:
        said.append(
            f"the strongest mode, {f:.3g} Hz, has a damping ratio of {z:.2g}: it hardly swings. "
            "Its frequency means little; look for a drift of the camera or of the light."
        )
    if z + 2 * found.damping_sigma[0] < RINGING:
        said.append(
            f"the strongest mode, {f:.3g} Hz, does not decay: something drives it, or the clip is "
            "a loop. A damping ratio cannot be told."
        )
    if f > AUDIBLE:
        said.append(
            f"the strongest mode has {f:.4g} Hz; no camera sees that. Is capture_fps = "
            f"{capture_fps:g} frames/s right?"
        )
    return tuple(said)
