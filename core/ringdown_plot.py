"""One picture of what a video's points say: where, when, at what pitch, and how sure."""

from pathlib import Path

import numpy as np

from .files import written_whole
from .harmonic_inversion import fit_poles
from .video import Video, frame_at

ORDERS = 4  # further orders in the stabilization diagram


def plot_video_modes(modes, clip: Video, path: str | Path) -> None:
    """Write the picture (png, svg, pdf): points and deflection, motion, spectrum, stabilization.

    modes: core.ringdown_command.VideoModes.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 9), layout="constrained")
    FigureCanvasAgg(figure)
    places, motion, spectrum, stable = figure.subplots(2, 2).ravel()
    _places(places, modes, clip)
    _motion(motion, modes)
    _spectrum(spectrum, modes)
    _stability(stable, modes)
    with written_whole(path) as draft:
        figure.savefig(draft, dpi=120)


def _places(axes, modes, clip) -> None:
    tracks, found = modes.tracks, modes.ringdown
    axes.imshow(frame_at(clip, int(tracks.frames[0])).grey, cmap="gray", vmin=0, vmax=255)
    shape = modes.deflection[0]
    turn = np.exp(-1j * np.angle(np.sum(shape**2)) / 2)  # the phase in which most of it is real
    real = (shape * turn).real
    scale = 0.08 * clip.size[0] / max(np.abs(real).max(), 1e-9)
    axes.quiver(*tracks.points.T, *(scale * real).T, color="C1", angles="xy", scale=1, units="xy")
    axes.plot(*tracks.points.T, "o", color="C0", ms=3)
    axes.set(title=f"deflection at {found.frequency[0]:.4g} Hz, {scale:.3g} times", xlabel="u, px")


def _motion(axes, modes) -> None:
    tracks, found = modes.tracks, modes.ringdown
    best = modes.channels[0]
    flat = tracks.values.reshape(len(tracks.time), -1)
    after = tracks.time >= found.t0
    middle = found.offset[best]
    axes.plot(tracks.time, flat[:, best] - middle, color="C0", lw=0.7, label="tracked")
    fitted = found.predict(tracks.time[after])[:, best] - middle
    axes.plot(tracks.time[after], fitted, color="C1", lw=0.7, label="modes")
    axes.set(title="the clearest point", xlabel="time, s", ylabel="px")
    axes.legend(loc="upper right")


def _spectrum(axes, modes) -> None:
    tracks, found = modes.tracks, modes.ringdown
    step = float(np.median(np.diff(tracks.time)))
    even = np.arange(found.t0, tracks.time[-1], step)
    for channel in modes.channels:
        column = tracks.values.reshape(len(tracks.time), -1)[:, channel]
        known = np.isfinite(column)
        filled = np.interp(even, tracks.time[known], column[known])
        lines = np.abs(np.fft.rfft((filled - filled.mean()) * np.hanning(len(even))))
        axes.semilogy(np.fft.rfftfreq(len(even), step), lines / len(even) * 4, lw=0.6)
    for frequency in found.frequency:
        axes.axvline(frequency, color="k", lw=0.5, ls=":")
    axes.set(title="spectrum of the channels used", xlabel="frequency, Hz", ylabel="px")


def _stability(axes, modes) -> None:
    """Poles against the model's order: what is a mode stays, what is noise wanders."""
    tracks, found = modes.tracks, modes.ringdown
    after = tracks.time >= found.t0
    flat = tracks.values.reshape(len(tracks.time), -1)[after][:, modes.channels]
    time, m = tracks.time[after], len(found.frequency)
    rng = np.random.default_rng(0)
    highest = 0.5 / np.median(np.diff(time))
    for order in range(1, m + ORDERS + 1):
        start = np.concatenate([found.frequency, rng.uniform(0.05, 0.95, ORDERS) * highest])[:order]
        ratio = np.concatenate([found.damping_ratio, np.full(ORDERS, 0.01)])[:order]
        fit = fit_poles(time, flat, start, ratio)
        stays = np.array([np.min(np.abs(f / found.frequency - 1)) < 0.01 for f in fit.frequency])
        axes.plot(fit.frequency[stays], np.full(stays.sum(), order), "o", color="C0")
        axes.plot(fit.frequency[~stays], np.full((~stays).sum(), order), "x", color="0.6")
    axes.set(title="poles, by the number of modes allowed", xlabel="frequency, Hz", ylabel="modes")
    axes.set_xlim(0, highest)
