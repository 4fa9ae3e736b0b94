"""`ringdown VIDEO`: the modes of a video alone, no mesh needed. The story from clip to JSON."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .data import RingDown, seal
from .errors import RecordingError
from .harmonic_inversion import fit_poles, invert
from .magnify import magnify_mode
from .report import write_ringdown
from .ringdown import find_release
from .track import Tracks, track
from .track_clarity import clarity, commotion
from .track_points import pick_points
from .video import FEWEST_FRAMES, Video, open_video

CHANNELS = 8  # that the modes are read from, the clearest; more tell the same again
CLEAR = 0.1  # of the clearest channel: what is seen less clearly only adds noise
MOST_MODES = 8
PERIODS = 2.0  # of the strongest mode that a clip must hold
FOLDED = 0.2  # of the frame rate: a mode seen above it may be a fold of a higher one
FOLDS = 3  # multiples of the frame rate about which such modes are sought
DEAD, RINGING = 0.5, 1e-5  # damping ratios beyond which a declared rate or a mode makes no sense
AUDIBLE = 20e3  # Hz: no camera sees a body swing faster


@dataclass(frozen=True, eq=False)
class VideoModes:
    """The modes of a video and how its points take part in them."""

    tracks: Tracks
    ringdown: RingDown  # the channels are u and v of every point
    channels: np.ndarray  # indices of the channels that the poles were read from
    stop: float  # s, the end of the free motion; it begins at ringdown.t0
    warnings: tuple[str, ...] = ()

    def __post_init__(self):
        seal(self, "channels", int, (None,))

    @property
    def deflection(self) -> np.ndarray:
        """(m, n, 2) complex px: amplitude and phase of every point in every mode, at t0."""
        m = len(self.ringdown.frequency)
        return self.ringdown.amplitude.reshape(m, -1, 2)


def ringdown_command(  # noqa: PLR0913  (four of them by keyword only)
    video: str | Path,
    capture_fps: float,
    points: np.ndarray | None = None,
    *,
    out: str | Path | None = None,
    plot: str | Path | None = None,
    magnify: str | Path | None = None,
    progress=None,
) -> dict:
    """ringdown.json of the clip, written to `out` where given; `plot` is a picture of it all.

    `points` (n, 2) px in the first frame, else picked where texture moves. `magnify`: an mp4 in
    which the strongest mode's motion is exaggerated. `progress(fraction, text)`. Raises
    RecordingError for what no modes can be read from.
    """
    clip = open_video(video)
    modes = video_modes(clip, capture_fps, points, progress)
    report = ringdown_json(modes, capture_fps)
    if magnify is not None:
        magnify_mode(clip, modes.tracks, modes.ringdown, magnify)
    if plot is not None:
        from .ringdown_plot import plot_video_modes  # matplotlib takes its time to import

        plot_video_modes(modes, clip, plot)
    if out is not None:
        write_ringdown(report, out)
    return report


def video_modes(clip: Video, capture_fps: float, points=None, progress=None) -> VideoModes:
    """Modes of the motion of `points` (n, 2) px, or of points picked by themselves (None, empty).

    Raises RecordingError where nothing moves, no mode is found, or fewer than two periods of the
    strongest one are there.
    """
    picked = pick_points(clip) if points is None or not len(points) else np.asarray(points, float)
    tracks = track(clip, picked, capture_fps=capture_fps, progress=progress)
    tracks = _well_seen(tracks)
    flat = tracks.values.reshape(len(tracks.time), -1)
    clear = clarity(flat)
    clear = clear if clear.any() else commotion(flat)
    if not clear.any():
        raise RecordingError(
            f"{clip.path.name}: no motion in it; {len(tracks.points)} points were followed and "
            f"none moves beyond the noise of {np.nanmedian(tracks.sigma):.2g} px. Film the motion "
            "closer, or pick points that move."
        )
    order = np.argsort(-clear, kind="stable")[:CHANNELS]
    channels = order[clear[order] > CLEAR * clear[order[0]]]
    start, stop = find_release(tracks.time, flat[:, channels])
    free = (tracks.time >= start - 1e-9) & (tracks.time <= stop + 1e-9)
    time = tracks.time[free]
    found = invert(time, flat[free][:, channels], max_modes=MOST_MODES)
    _check_modes(clip, found, np.ptp(time))
    enough = np.isfinite(flat[free]).sum(axis=0) >= FEWEST_FRAMES
    everywhere = fit_poles(
        time, flat[free][:, enough], found.frequency, found.damping_ratio, fit=False
    )
    everywhere = _in_the_order_of(found, everywhere, enough)
    warnings = tracks.warnings + found.warnings + _senseless(found, clip, capture_fps)
    return VideoModes(tracks, everywhere, channels, stop, warnings)


def ringdown_json(modes: VideoModes, capture_fps: float) -> dict:
    """ringdown.json as a dict: modes strongest first, amplitudes in px at the onset."""
    found = modes.ringdown
    rows = []
    for k in range(len(found.frequency)):
        largest = np.sqrt((np.abs(modes.deflection[k]) ** 2).sum(-1)).max()
        rows.append(
            {
                "natural_frequency_hz": _interval(found.frequency[k], found.frequency_sigma[k]),
                "damping_ratio": _interval(found.damping_ratio[k], found.damping_sigma[k]),
                "amplitude_px": float(largest),
                "aliases_hz": aliases(found.frequency[k], found.damping_ratio[k], capture_fps),
            }
        )
    rows.sort(key=lambda row: -row["amplitude_px"])
    return {"modes": rows, "warnings": list(modes.warnings)}


def aliases(frequency: float, damping_ratio: float, capture_fps: float) -> list[float]:
    """Hz, natural frequencies that `capture_fps` would show at `frequency`, lowest first.

    What is sampled is the damped frequency f_d = f sqrt(1 - z^2); k F - f_d and k F + f_d look
    the same at F frames/s. Empty where there are five frames or more in a period: a body that
    swings at that pace and is seen so evenly is rarely one that swings ten times faster.
    """
    damped = frequency * np.sqrt(1 - damping_ratio**2)
    if damped < FOLDED * capture_fps:
        return []
    decay = frequency * damping_ratio  # the envelope is not folded
    folds = [k * capture_fps + sign * damped for k in range(1, FOLDS + 1) for sign in (-1, 1)]
    return [float(np.hypot(fold, decay)) for fold in folds]


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


def _check_modes(clip: Video, found: RingDown, seconds: float) -> None:
    if not len(found.frequency):
        raise RecordingError(
            f"{clip.path.name}: something moves, but no decaying vibration was found in "
            f"{seconds:.3g} s. Film a free swing: pluck it, let go, and keep filming."
        )
    periods = seconds * found.frequency[0]
    if periods < PERIODS:
        raise RecordingError(
            f"{clip.path.name}: {seconds:.3g} s after the onset hold {periods:.2g} periods of its "
            f"{found.frequency[0]:.3g} Hz; {PERIODS:g} are needed at least. Film longer."
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


def _senseless(found: RingDown, clip: Video, capture_fps: float) -> tuple[str, ...]:
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
    for frequency, ratio in zip(found.frequency, found.damping_ratio, strict=True):
        folds = aliases(frequency, ratio, capture_fps)
        if frequency > 0.4 * capture_fps:
            said.append(
                f"the mode seen at {frequency:.4g} Hz is near half of the {capture_fps:g} "
                f"frames/s: it may as well be {folds[0]:.4g}, {folds[1]:.4g} or {folds[2]:.4g} Hz. "
                "Film at a higher rate, or at a slightly different one, to tell."
            )
    return tuple(said)


def _interval(value: float, sigma: float) -> dict:
    value, reach = float(value), 1.96 * float(sigma)
    return {"value": value, "ci95": [max(value - reach, 0.0), value + reach]}
