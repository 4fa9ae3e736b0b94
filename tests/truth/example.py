"""The example in assets: a cat of jelly on a plate, nudged aside by a spoon and let go, twice.

    python -m tests.truth.example [FOLDER]

The jelly creeps (a relaxing branch, RATIO and TIME), which its case does not declare. The tracks
are those of a phone on a tripod, 120 frames/s, with some noise. The second take is gentler and
from the other side: without it a one-sided stiffness would explain the creeping mean as well.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from . import bodies, camera, film, scene, write

FOLDER = Path(__file__).parents[2] / "assets" / "jelly"
WIDE, DEEP, HIGH = 0.040, 0.034, 0.046  # m: half axes of the base, height of the head
RATIO, TIME = 0.22, 1.6  # of the relaxing branch: stiffness over the static one; s
FIRST, DAMPING = 4.6, 0.022  # Hz, ratio
FPS, FRAMES, BEFORE, NOISE = 120.0, 390, 30, 0.12  # 1/s, frames, px
NUDGE = 0.009  # m
FACE = {  # name: (x, height) on the side that the camera sees, m
    "left_ear": (-0.0185, 0.058),
    "right_ear": (0.0185, 0.058),
    "left_eye": (-0.0115, 0.034),
    "right_eye": (0.0115, 0.034),
    "nose": (0.0, 0.028),
    "left_whisker": (-0.023, 0.024),
    "right_whisker": (0.023, 0.024),
    "belly": (0.0, 0.012),
    "left_paw": (-0.022, 0.008),
    "right_paw": (0.022, 0.008),
}


def cat(u: np.ndarray) -> np.ndarray:
    """Unit coordinates (N, 3) to a sitting cat of jelly: a soft dome with two ears, m."""
    flat = bodies.disc(2 * u[:, :2] - 1)
    far = np.linalg.norm(flat, axis=1)
    w = u[:, 2]
    head = 1 - 0.30 * w**1.5 + 0.10 * np.sin(np.pi * w) - 0.05 * np.sin(2 * np.pi * w)
    plan = flat * [WIDE, DEEP] * head[:, None]
    dome = HIGH * (1 - 0.16 * far**2)
    ears = sum(
        0.017 * np.exp(-((((plan[:, 0] - x) / 0.0085) ** 2 + (plan[:, 1] / 0.0085) ** 2) ** 1.2))
        for x in (-0.0185, 0.0185)
    )
    height = w * dome + w**3 * ears
    return np.column_stack([plan, height])


def body() -> bodies.Body:
    """The jelly on a fine mesh of quadratic cells, its base held by the plate."""
    plain = bodies.build(
        "jelly cat", cat, (8, 8, 7), crowded=(1, 1, 1.2), axis=[0, 0, 1], swing=[1, 0, 0],
        surface_counts=(14, 14, 9), density=1040.0, poisson=0.48,
    )  # fmt: skip
    return bodies.tuned(plain, FIRST)


def nearest(thing: bodies.Body, x: float, height: float) -> int:
    """The free surface node on the camera's side next to a place of the face."""
    skin = scene.places(thing)
    skin = skin[thing.nodes[skin, 1] < 0.004]
    away = thing.nodes[skin][:, [0, 2]] - [x, height]
    return int(skin[np.argmin(np.linalg.norm(away, axis=1) + 0.1 * thing.nodes[skin, 1])])


def stage() -> scene.Scene:
    """Spoon, markers and camera."""
    thing = body()
    markers = [nearest(thing, *place) for place in FACE.values()]
    held = np.flatnonzero(thing.pinned)
    plate = [int(held[np.argmin(thing.nodes[held, 1])]), int(held[np.argmax(thing.nodes[held, 0])])]
    lens = camera.Camera(
        np.array([1.0, 0, 0]), np.array([0.0, 0, -1]), np.array([0.0, 0, 0.028]), 1.0e-4
    )
    ratio = DAMPING * np.linspace(1, 1.6, scene.MODES)
    spoon = nearest(thing, 0.03, 0.036)
    way = np.array([1.0, 0.15, -0.1])
    return scene.Scene(
        thing, ratio, "pull", spoon, way / np.linalg.norm(way), NUDGE, markers, plate, FPS, FRAMES,
        BEFORE, BEFORE / FPS, camera=lens, hold=3 * TIME, limit=18.0,
    )  # fmt: skip


def make(folder: Path) -> dict:
    """Write the case in `folder`; return what is in it."""
    session = stage()
    creep = film.Planted(
        "relaxation",
        RATIO,
        (RATIO, RATIO),
        system=lambda s, plain: replace(plain, branch=(s, TIME)),
    )
    rng = np.random.default_rng(20)
    folder.mkdir(parents=True, exist_ok=True)
    thing = session.body
    write.surface(folder / "jelly.obj", thing.vertices, thing.triangles)
    names = [*FACE, "plate_front", "plate_side"]
    for name, amplitude in (("tracks", NUDGE), ("tracks2", -0.7 * NUDGE)):
        session.amplitude = amplitude
        shot = film.shoot(session, [creep], [RATIO])
        values = shot.values + NOISE * rng.standard_normal(shot.values.shape)
        write.tracks(folder / f"{name}.csv", names, values)
    write.case(folder, {"name": "jelly cat, nudged by a spoon"}, tables(session, names))
    return {
        "effects": {"relaxation": {"ratio": RATIO, "time": TIME}},
        "youngs_modulus": thing.young,
        "frequency_hz": shot.system.frequency[:6],
        "damping_ratio": session.ratio[:6],
        "amplitude_px": float(np.ptp(shot.values[BEFORE:], axis=0).max() / 2),
    }


def tables(session, names) -> list:
    """The sections of its case."""
    thing = session.body
    low, high = (np.round(side, 4) for side in thing.pin_box)
    filmed = {"capture_fps": FPS, "start": round(BEFORE / FPS, 6)}
    out = [
        ("[object]", {
            "mesh": "jelly.obj", "length_unit": "m", "density": thing.density,
            "poisson_ratio": thing.poisson,
        }),
        ("[[pin]]", {"box": {"min": low, "max": high}}),
        ("[model]", {"declared": ["viscous_damping"]}),
        ("[recording]", {"tracks": "tracks.csv", **filmed}),
        ("[[take]]", {"tracks": "tracks2.csv", **filmed}),
        ("[camera]", session.camera.entry("orthographic")),
    ]  # fmt: skip
    for name, node in zip(names, [*session.markers, *session.support], strict=True):
        on = "support" if name.startswith("plate") else "object"
        out.append(("[[marker]]", {"name": name, "on": on, "position": thing.nodes[node]}))
    return out


if __name__ == "__main__":
    for key, value in make(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER).items():
        print(f"{key}: {value}")
