"""One picture of what a video's points say: where, when, at what pitch, and how sure."""

from pathlib import Path

import numpy as np

from .files import written_whole
from .stabilization import stabilization
from .video import Video, frame_at

ORDERS = 24  # highest one in the stabilization diagram


def plot_video_modes(modes, clip: Video, path: str | Path) -> None:
    """Write the picture (png, svg, pdf): points and deflection, motion, spectrum, stabilization.

    modes: core.video_modes.VideoModes.
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
    after = (tracks.time >= found.t0) & (tracks.time <= modes.stop)
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
    free = (tracks.time >= found.t0) & (tracks.time <= modes.stop)
    flat = tracks.values.reshape(len(tracks.time), -1)[free][:, modes.channels]
    poles = stabilization(tracks.time[free], flat, ORDERS)
    for stays, look in ((False, {"marker": "x", "color": "0.6"}), (True, {"color": "C0"})):
        which = poles.stable == stays
        axes.scatter(poles.frequency[which], poles.order[which], s=14, **look)
    for frequency in found.frequency:
        axes.axvline(frequency, color="k", lw=0.5, ls=":")
    axes.set(title="poles; dots stay from order to order", xlabel="frequency, Hz", ylabel="order")
    axes.set_xlim(0, 0.5 / np.median(np.diff(tracks.time)))
