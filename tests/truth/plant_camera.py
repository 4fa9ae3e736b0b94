"""Planted effects of camera, clock and tracker."""

from dataclasses import replace

import numpy as np

from .film import Planted, look

FLAT = {"flat": True}
NEEDS = {
    "rolling_shutter": {"flat": True, "portrait": True, "markers": (5, 13), "fps": 60.0},
    "lost_frames": {"bare": True},
    "tracker_drift": {"markers": (5, 13)},
}


def again(film, **changes):
    """The same film with some fields changed, keeping its own facts."""
    new = replace(film, **changes)
    new.facts = dict(film.facts)
    return new


def rolling_shutter(rng, stage) -> Planted:
    frame = 1 / stage.fps

    def change(s, film):
        new = again(film, camera=replace(film.camera, readout=s * frame))
        new.values = look(new)
        return new

    return Planted(
        "rolling_shutter", 0.7, (0.05, 0.98), lambda s, film: {"readout": s * frame},
        film=change, layer="modal",
    )  # fmt: skip


def lost_frames(rng, stage) -> Planted:
    count = int(rng.integers(1, 5))
    doubled = rng.random() < 0.25
    places = np.sort(rng.choice(np.arange(8, int(0.75 * stage.frames)), count, replace=False))

    def change(s, film):
        total = len(film.nominal)
        if doubled:
            index = np.sort(np.concatenate([np.arange(total), places]))[:total]
        else:
            index = np.delete(np.arange(total + count), places)[:total]
        time = index / stage.fps
        new = again(film, time=time)
        new.values = look(new)
        return new

    return Planted(
        "lost_frames", 1.0, (1.0, 1.0), lambda s, film: {"frames": count, "doubled": bool(doubled)},
        film=change, tunable=False,
    )  # fmt: skip


def tracker_drift(rng, stage) -> Planted:
    which = int(rng.integers(len(stage.markers)))
    form = rng.choice(["ramp", "walk", "jump"])
    seed = int(rng.integers(2**31))

    def change(s, film):
        own = np.random.default_rng(seed)
        total, axes = len(film.nominal), film.values.shape[2]
        x = np.linspace(0, 1, total)
        if form == "ramp":
            path = x ** own.choice([1.0, 1.5, 2.0])
        elif form == "walk":
            path = np.cumsum(own.standard_normal(total)) / np.sqrt(total)
        else:
            path = (x > own.uniform(0.15, 0.6)).astype(float)
        way = own.standard_normal(axes)
        way /= np.linalg.norm(way)
        unit = 1.0 if film.camera is None else 1 / film.camera.metres_per_pixel
        values = film.values.copy()
        values[:, which] += s * stage.amplitude * unit * path[:, None] * way
        return again(film, values=values)

    return Planted(
        "tracker_drift", 0.1, (0.002, 1.0),
        lambda s, film: {"markers": [f"m{which + 1}"], "form": str(form)}, film=change,
    )  # fmt: skip
