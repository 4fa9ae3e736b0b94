"""From a scene and planted effects to what the camera or the markers give."""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

from . import reduced, scene

SPAN = 1.0  # rad of the quickest swing that a step may hold: beyond 2.8 the scheme runs away


@dataclass(eq=False)
class Planted:
    """One effect with its hooks; every hook takes the strength first and may be left out."""

    name: str
    strength: float
    limits: tuple[float, float]
    parameters: object = None  # (strength, film) -> dict in the contract's units
    body: object = None  # (strength, body) -> (body, ground)
    system: object = None  # (strength, system) -> system
    force: object = None  # (strength, system) -> force
    shift: object = None  # (strength, time (T,)) -> (T, 3) m, added to every marker
    film: object = None  # (strength, Film) -> Film: camera, clock, tracker
    layer: str = "time"  # "modal": judged against the body's own frequencies and shapes
    tunable: bool = True
    turned: object = None  # () -> body, turned over for a second take


@dataclass(eq=False)
class Film:
    """A clean or noisy recording."""

    nominal: np.ndarray  # (T,) s, what the time column says; 0 = first frame
    time: np.ndarray  # (T,) s, when each frame was really taken
    values: np.ndarray  # (T, n, d) m or px; support markers last
    scene: scene.Scene
    system: reduced.System
    motion: object  # callable time (T,) s from the release -> (T, n, 3) m, absolute
    camera: object = None  # the one that really films
    facts: dict = field(default_factory=dict)


def shoot(stage: scene.Scene, planted: list, strengths: list) -> Film:
    """Simulate and film without noise."""
    pairs = list(zip(planted, strengths, strict=True))
    system = model(stage, pairs)
    acting = [p.force(s, system) for p, s in pairs if p.force]
    state, rest = scene.start_of(stage, system, acting)
    for one in acting:
        if hasattr(one, "commit"):
            one.place = one.row @ state[: system.size]
    rate = max(scene.STEPS / max(stage.period, 1e-9), quickest(system, state, acting) / SPAN)
    per_frame = int(np.ceil(rate / stage.fps))
    step = 1 / (stage.fps * per_frame)
    count = int(stage.frames * stage.margin + 12) * per_frame
    track = reduced.run(system, state, step, count, acting)
    motion = mover(stage, system, track, rest, [(p, s) for p, s in pairs if p.shift])
    nominal = np.arange(stage.frames + stage.before) / stage.fps
    film = Film(nominal, nominal, None, stage, system, motion, stage.camera)
    film.facts["peak"] = peak(stage, system, track)
    film.values = look(film)
    for p, s in pairs:
        if p.film:
            film = p.film(s, film)
    return film


def quickest(system, state, acting) -> float:
    """rad/s that the steepest of the forces at nodes could make something swing with.

    A node may go as far as all that is in the motion at first would bend the body there; what is
    fed in later is not counted.
    """
    r = system.size
    q, v = state[:r], state[r : 2 * r]
    energy = (q @ system.K @ q + v @ system.M @ v) / 2
    rates = [0.0]
    for one in acting:
        if hasattr(one, "steepest"):
            for row in np.atleast_2d(one.row):
                reach = np.sqrt(2 * energy * (row @ np.linalg.solve(system.K, row)))
                light = row @ np.linalg.solve(system.M, row)
                rates.append(np.sqrt(one.steepest(reach) * light))
        if hasattr(one, "fastest"):
            rates.append(one.fastest(one.row @ np.linalg.solve(system.M, one.row)))
    return max(rates)


def model(stage, pairs) -> reduced.System:
    """The reduced system with every change of body and of matrices."""
    body, ground = stage.body, None
    changed = [(p, s) for p, s in pairs if p.body]
    for p, s in changed:
        body, bed = p.body(s, body)
        ground = bed if bed is not None else ground
    key = id(stage)
    if changed or stage.plain is None or stage.plain[0] != key:
        system = scene.system_of(stage, body, ground)
        if not changed:
            stage.plain = (key, system)
    else:
        system = stage.plain[1]
    for p, s in pairs:
        if p.system:
            system = p.system(s, system)
    return system


def mover(stage, system, track, rest, shifts):
    """Absolute places (T, n, 3) of all markers at any instants (s from the release)."""
    nodes = stage.markers
    rows = np.array([system.at(n) for n in nodes])
    path = CubicSpline(track.time, np.einsum("nir,tr->tni", rows, track.q + rest))
    home = stage.body.nodes[list(nodes) + list(stage.support)]

    def motion(t):
        out = np.repeat(home[None], len(t), axis=0)
        out[:, : len(nodes)] += path(np.clip(t, 0, track.time[-1]))
        for p, s in shifts:
            out += p.shift(s, t)[:, None]
        return out

    return motion


def peak(stage, system, track) -> dict:
    """Largest motion (m) of the marker that moves most, and which one."""
    size = [np.linalg.norm(track.q @ system.at(n).T, axis=1) for n in stage.markers]
    most = int(np.argmax([np.sqrt(np.mean(s**2)) for s in size]))
    return {"marker": most, "amplitude": float(size[most].max())}


def look(film: Film, time=None) -> np.ndarray:
    """(T, n, d) as seen at the frames' own instants, row after row where the shutter rolls."""
    released = (film.time if time is None else time) - film.scene.before / film.scene.fps
    camera = film.camera
    if camera is None:
        return film.motion(released)
    pixels = camera.see(film.motion(released))
    if camera.readout:
        for _ in range(3):
            late = camera.readout * pixels[..., 1] / camera.size[1]
            for n in range(pixels.shape[1]):
                pixels[:, n] = camera.see(film.motion(released + late[:, n])[:, n])
    return pixels
