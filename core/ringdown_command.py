"""`ringdown VIDEO`: the modes of a video alone, no mesh needed. The story from clip to JSON."""

from pathlib import Path

import numpy as np

from .deflection import polar
from .magnify import magnify_mode
from .report import write_ringdown
from .video import open_video
from .video_modes import VideoModes, video_modes


def ringdown_command(  # noqa: PLR0913  (all but three by keyword only)
    video: str | Path,
    capture_fps: float,
    points: np.ndarray | None = None,
    *,
    static: np.ndarray | None = None,
    readout: float = 0.0,
    metres_per_pixel: float | None = None,
    out: str | Path | None = None,
    plot: str | Path | None = None,
    magnify: str | Path | None = None,
    progress=None,
) -> dict:
    """ringdown.json of the clip, written to `out` where given; `plot` is a picture of it all.

    `points` (n, 2) px in the first frame, else picked where texture moves. `static` (s, 2) px:
    points whose common motion is the camera's. `readout` s of a rolling shutter. `magnify`: an mp4
    in which the strongest mode's motion is exaggerated. `progress(fraction, text)`. Raises
    RecordingError for what no modes can be read from.
    """
    clip = open_video(video)
    modes = video_modes(
        clip, capture_fps, points, static=static, readout=readout, progress=progress
    )
    report = ringdown_json(modes, metres_per_pixel)
    if magnify is not None:
        magnify_mode(clip, modes.tracks, modes.ringdown, magnify)
    if plot is not None:
        from .ringdown_plot import plot_video_modes  # matplotlib takes its time to import

        plot_video_modes(modes, clip, plot)
    if out is not None:
        write_ringdown(report, out)
    return report


def ringdown_json(modes: VideoModes, metres_per_pixel: float | None = None) -> dict:
    """ringdown.json as a dict: modes strongest first, amplitudes in px or m at the onset."""
    found = modes.ringdown
    unit, scale = ("px", 1.0) if metres_per_pixel is None else ("m", metres_per_pixel)
    rows = []
    for k in range(len(found.frequency)):
        largest = np.sqrt((np.abs(modes.deflection[k]) ** 2).sum(-1)).max()
        rows.append(
            {
                "natural_frequency_hz": _interval(found.frequency[k], found.frequency_sigma[k]),
                "damping_ratio": _interval(found.damping_ratio[k], found.damping_sigma[k]),
                f"amplitude_{unit}": float(scale * largest),
                "aliases_hz": list(modes.aliases[k]),
                "deflection": _deflection(modes, k, unit, scale),
            }
        )
    rows.sort(key=lambda row: -row[f"amplitude_{unit}"])
    return {"modes": rows, "warnings": list(modes.warnings)}


def table(report: dict) -> str:
    """The modes as lines for a person, and what to know of them."""
    lines = [f"{'pitch, Hz':>22}{'damping ratio':>22}{'amplitude':>14}   or a fold of"]
    for mode in report["modes"]:
        unit = "px" if "amplitude_px" in mode else "m"
        folds = ", ".join(f"{f:.5g}" for f in mode["aliases_hz"][:3])
        pitch, ratio = _told(mode["natural_frequency_hz"]), _told(mode["damping_ratio"])
        amplitude = f"{mode[f'amplitude_{unit}']:.3g} {unit}"
        lines.append(f"{pitch:>22}{ratio:>22}{amplitude:>14}   {folds}".rstrip())
    return "\n".join([*lines, *(f"note: {line}" for line in report["warnings"])])


def _told(one: dict) -> str:
    half = (one["ci95"][1] - one["ci95"][0]) / 2
    return f"{one['value']:.5g} +- {half:.2g}"


def _deflection(modes: VideoModes, k: int, unit: str, scale: float) -> list[dict]:
    """What every point that was seen does in mode k, along u and along v."""
    shape = modes.deflection[k]
    covariance = modes.covariance[k].reshape(len(shape), 2, 2, 2)
    out = []
    for point, moved, spread in zip(modes.tracks.points, shape, covariance, strict=True):
        if not np.isfinite(spread).all():
            continue
        row = {"pixel": [float(x) for x in point]}
        for axis, value, own in zip("uv", moved, spread, strict=True):
            amplitude, phase = polar(value, own)
            row[axis] = {
                f"amplitude_{unit}": _three(amplitude, scale),
                "phase_rad": _three(phase),
            }
        out.append(row)
    return out


def _three(numbers: tuple, scale: float = 1.0) -> dict:
    value, low, high = (float(scale * x) for x in numbers)
    return {"value": value, "ci95": [low, high]}


def _interval(value: float, sigma: float) -> dict:
    value, reach = float(value), 1.96 * float(sigma)
    return {"value": value, "ci95": [max(value - reach, 0.0), value + reach]}
