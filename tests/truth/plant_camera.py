"""Planted effects of camera, clock and tracker."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from . import forces
from .film import Planted, look

NEEDS = {
    "rolling_shutter": {"flat": True, "portrait": True, "markers": (5, 13), "fps": "slow"},
    "lost_frames": {"bare": True},
    "tracker_drift": {"markers": (5, 13)},
    "base_motion": {"markers": (4, 13), "support": 0.75},
    "perspective": {
        "flat": True, "tilt": 1.0, "markers": (6, 13), "snr": (32, 50), "damping": (0.01, 0.03),
        "release": "pull",
    },
    "aliasing": {"fps": "alias", "release": "knock", "reach": (0.3, 0.65), "damping": (0.008, 0.03),
                 "markers": (5, 13), "objects": ("bar", "strip", "bracket")},
    "clock": {"release": "gravity"},
    "exposure": {},
}  # fmt: skip


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


def base_motion(rng, stage) -> Planted:
    """The camera or the support moves: smooth and random, or a wobble that dies out; in a plane the
    support goes two ways, each as it likes.
    """
    who, path, form = shake(rng, stage)
    paths, ways = [path], [across(rng, stage)]
    if stage.plane:
        who = "support"
        paths += [shake(rng, stage)[1]]
        ways += [across(rng, stage)]
    inertia = np.array([stage.body.mass @ np.tile(way, len(stage.body.nodes)) for way in ways])
    share = np.sqrt(1 / len(ways))

    def moved(t, order=0):
        """(n, ...) along each of the ways."""
        return share * np.array([path(t, order) for path in paths])

    def force(s, system):
        return forces.Shaken(
            system.basis.T @ inertia.T, lambda t: s * stage.amplitude * moved(t, 2)
        )

    return Planted(
        "base_motion", 0.05, (0.001, 0.6),
        lambda s, film: {"rms": s * stage.amplitude, "who": str(who), "form": str(form)},
        force=force if who == "support" else None,
        shift=lambda s, t: s * stage.amplitude * moved(t).T @ ways,
    )  # fmt: skip


def shake(rng, stage) -> tuple:
    """Who moves, the path of rms 1 in the record, and its form."""
    who, form = rng.choice(["camera", "camera", "support"]), rng.choice(["random", "wobble"])
    span = stage.duration * 1.3
    time = np.arange(-2.0, span + 0.5, min(0.002, stage.period / 100))
    if form == "random":
        f, phase = rng.uniform(0.3, 4.0, 5) / span * 3, rng.uniform(0, 2 * np.pi, 5)
        path = (np.sin(2 * np.pi * np.outer(time, f) + phase) * rng.uniform(0.4, 1, 5)).sum(1)
    else:
        f = rng.uniform(0.25, 0.6) / stage.period
        late = np.maximum(time, 0)
        path = late**2 / (late**2 + 0.05**2) * np.sin(2 * np.pi * f * late + rng.uniform(0, 6))
        path = path * np.exp(-late * rng.uniform(1.0, 2.5) / span)
    inside = path[(time >= 0) & (time <= stage.duration)]
    return who, CubicSpline(time, path / inside.std()), form


def across(rng, stage) -> np.ndarray:
    """A random direction that the camera sees."""
    way = rng.standard_normal(3)
    if stage.camera is not None:
        way -= (way @ stage.camera.look) * stage.camera.look
    return way / np.linalg.norm(way)


def perspective(rng, stage) -> Planted:
    """A real lens near by, while the case says orthographic."""
    size = np.linalg.norm(np.ptp(stage.body.nodes, axis=0))

    def change(s, film):
        new = again(film, camera=replace(film.camera, distance=size / s))
        new.values = look(new)
        return new

    return Planted(
        "perspective", 0.15, (0.05, 0.5), lambda s, film: {"distance": size / s}, film=change,
        layer="modal",
    )  # fmt: skip


def aliasing(rng, stage) -> Planted:
    """A mode above half the frame rate: the scene does it, see `scene.rate`."""

    def facts(s, film):
        f = film.system.frequency
        above = f[(f > 0.5 * stage.fps) & (f < stage.limit)]
        return {"frequency": [float(one) for one in above]}  # any of them is right

    return Planted("aliasing", 1.0, (1, 1), facts, tunable=False)


def clock(rng, stage) -> Planted:
    """The camera ran `factor` times as fast as declared."""
    factor = rng.choice([rng.uniform(0.78, 0.92), rng.uniform(1.1, 1.3)])
    rest = stage.before / stage.fps
    stage.margin = 1.35

    def change(s, film):
        new = again(film, time=rest + (film.nominal - rest) / factor)
        new.values = look(new)
        return new

    return Planted(
        "clock", 1.0, (1, 1), lambda s, film: {"factor": factor}, film=change, tunable=False,
        layer="modal",
    )  # fmt: skip


def exposure(rng, stage) -> Planted:
    """The shutter stays open for a good part of the frame: less amplitude, nothing else."""
    part = rng.uniform(0.3, 0.95)

    def change(s, film):
        inside = (np.arange(7) - 3) / 7 * part / stage.fps
        new = again(film)
        new.values = np.mean([look(film, film.time + d) for d in inside], axis=0)
        return new

    return Planted(
        "exposure", 1.0, (1, 1), lambda s, film: {"share": part}, film=change, tunable=False
    )
