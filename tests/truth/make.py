"""`make(kind, seed, folder)`: one case on disk and, returned only, what is really in it.

kind: an effect's name, "null", "two:a+b", "absent:x", "twin:a|b" or "trap:x".
"""

import zlib
from pathlib import Path

import numpy as np

from . import bodies, camera, film, linear_fit, plant, plant_body, plant_camera, scene, write

MODULES = (plant, plant_body, plant_camera)
NEEDS = {name: needs for module in MODULES for name, needs in module.NEEDS.items()}
EFFECTS = (
    "added_mass", "compliant_pin", "large_amplitude", "dry_friction", "air_drag", "relaxation",
    "stiffness_drift", "contact", "steady_drive", "tracker_drift", "lost_frames", "rolling_shutter",
)  # fmt: skip
KINDS = ("null", *EFFECTS)


def effect(name: str):
    """The planting function of an effect."""
    for module in MODULES:
        if hasattr(module, name):
            return getattr(module, name)
    raise KeyError(f"truth: no effect {name!r} can be planted.")


def names_of(kind: str) -> list:
    """Effects that `kind` plants."""
    if kind == "null":
        return []
    return kind.split(":")[-1].split("+")


def make(kind: str, seed: int, folder, **given) -> dict:
    """Write the case of `kind` and `seed` in `folder`; return the truth, which is not written there.

    `given`: object= a name of bodies.OBJECTS, flat= True for 2-D, snr= dB, ratio= declared error
    over the noise floor.
    """
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    names = names_of(kind)
    needs = {}
    for name in names:
        needs |= NEEDS.get(name, {})
    body = bodies.OBJECTS[given.get("object") or str(rng.choice(list(bodies.OBJECTS)))](rng)
    stage = scene.draw(rng, body, needs)
    flat = given.get("flat", needs.get("flat", rng.random() < 0.45))
    if flat:
        stage.camera = camera.draw(rng, body, portrait=needs.get("portrait", False))
    planted = [effect(name)(rng, stage) for name in names]
    snr, ratio = loudness(rng, given)
    shot, strengths, sigma, error = tune(stage, planted, snr, ratio)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    noisy = shot.values + sigma * rng.standard_normal(shot.values.shape)
    lose(rng, noisy)
    store(folder, f"{kind} {seed} {body.name}", stage, shot, noisy, rng)
    return truth_of(kind, seed, stage, planted, strengths, shot, sigma, error)


def loudness(rng, given) -> tuple[float, float]:
    """Signal to noise (dB) and the declared model's error over the noise floor."""
    snr = given.get("snr") or rng.uniform(20, 50)
    noise = 10 ** (-snr / 20)
    low, high = max(2.0, 0.012 / noise), min(10.0, 0.3 / noise)
    ratio = np.exp(rng.uniform(np.log(min(low, high)), np.log(max(low, high))))
    return snr, given.get("ratio") or ratio


def error_of(stage, planted, shot) -> float:
    """RMS (m or px) that the declared linear model leaves of a clean film."""
    late = stage.before
    values = shot.values[late:].reshape(len(shot.values) - late, -1)
    values = values[:, : len(stage.markers) * shot.values.shape[2]]
    time = shot.nominal[late:] - shot.nominal[late]
    plain = film.model(stage, [])
    flat = np.array([seen(stage, shot, plain.at(n)) for n in stage.markers]).reshape(-1, plain.size)
    start, _ = scene.start_of(stage, plain)
    r = plain.size
    size = np.hypot(start[:r], start[r : 2 * r] / (2 * np.pi * plain.frequency))
    size = size * np.linalg.norm(flat, axis=0) * (plain.frequency < 0.5 * stage.fps)
    strong = np.sort(np.argsort(size)[::-1][:4])
    strong = strong[size[strong] > 0.01 * size.max()]
    shapes = flat[:, strong] if any(p.layer == "modal" for p in planted) else None
    left = linear_fit.leftover(time, values, plain.frequency[strong], plain.damping_ratio[strong], shapes)
    return float(np.sqrt(np.mean(left**2)))


def seen(stage, shot, motion) -> np.ndarray:
    """Motion (3, r) of a marker as (d, r) of its channels, by the declared camera."""
    if shot.values.shape[2] == 3:
        return motion
    rows = np.array([stage.camera.right, stage.camera.down]) / stage.camera.metres_per_pixel
    return rows @ motion


def tune(stage, planted, snr: float, ratio: float):
    """Strengths that leave `ratio` times the noise, by secant in the logarithm; else less noise."""
    strengths = [p.strength for p in planted]
    shot = film.shoot(stage, planted, strengths)
    rms = spread(shot, stage)
    sigma = rms * 10 ** (-snr / 20)
    wanted = sigma * np.sqrt(ratio**2 - 1)
    if not planted:
        return shot, strengths, sigma, 0.0
    if not any(p.tunable for p in planted):
        return shot, strengths, sigma, error_of(stage, planted, shot)
    errors = []
    for i, one in enumerate(planted):
        strengths[i], error = tune_one(stage, one, wanted)
        if one.tunable:
            errors.append(error)
    shot = film.shoot(stage, planted, strengths)
    sigma = min(max(min(errors) / np.sqrt(ratio**2 - 1), rms * 10**-2.5), rms * 0.1)
    return shot, strengths, sigma, error_of(stage, planted, shot)


def tune_one(stage, one, wanted: float) -> tuple[float, float]:
    """Strength whose leftover (m or px) is near `wanted`, and the leftover."""
    s, power = one.strength, 1.0
    error = error_of(stage, [one], film.shoot(stage, [one], [s]))
    for _ in range(3 if one.tunable else 0):
        if abs(np.log(max(error, 1e-30) / wanted)) < 0.15:
            break
        new = float(np.clip(s * (wanted / max(error, 1e-30)) ** (1 / power), *one.limits))
        if abs(np.log(new / s)) < 0.02:
            break
        after = error_of(stage, [one], film.shoot(stage, [one], [new]))
        power = np.clip(np.log(after / error) / np.log(new / s), 0.4, 3.0)
        s, error = new, after
    return s, error


def spread(shot, stage) -> float:
    """RMS (m or px) of the object's markers about their means, after the release."""
    values = shot.values[stage.before :, : len(stage.markers)]
    return float(np.sqrt(np.mean((values - values.mean(0)) ** 2)))


def lose(rng, values) -> None:
    """In one recording of five some samples are missing, in short runs."""
    if rng.random() < 0.2:
        for _ in range(int(rng.integers(1, 6))):
            at, marker = rng.integers(len(values)), rng.integers(values.shape[1])
            values[at : at + int(rng.integers(1, 6)), marker] = np.nan


def store(folder, title, stage, shot, noisy, rng, **more) -> None:
    """The case as its author would write it: what he knows, and nothing else."""
    body = stage.body
    names = [f"m{i + 1}" for i in range(len(stage.markers))]
    names += [f"s{i + 1}" for i in range(len(stage.support))]
    timed = stage.camera is None or rng.random() < 0.5
    write.surface(folder / "body.obj", body.vertices, body.triangles)
    write.tracks(folder / "tracks.csv", names, noisy, shot.nominal if timed else None)
    thing = {"mesh": "body.obj", "length_unit": "m", "density": body.density}
    thing["poisson_ratio"] = body.poisson
    if stage.gravity is not None:
        thing |= {"gravity": stage.gravity, "shape": "unloaded"}
    recording = {"tracks": "tracks.csv", "capture_fps": stage.fps}
    if stage.start is not None:
        recording["start"] = round(stage.start, 6)
    low, high = (np.round(side, 6) for side in body.pin_box)
    tables = [
        ("[object]", thing),
        ("[[pin]]", {"box": {"min": low, "max": high}}),
        ("[model]", {"declared": ["viscous_damping"]}),
        ("[recording]", recording),
        ("[camera]", stage.camera.entry("orthographic") if stage.camera else None),
    ]
    for name, node in zip(names, [*stage.markers, *stage.support], strict=True):
        on = "object" if name[0] == "m" else "support"
        tables.append(("[[marker]]", {"name": name, "on": on, "position": body.nodes[node]}))
    write.case(folder, {"name": title}, tables)


def truth_of(kind, seed, stage, planted, strengths, shot, sigma, error) -> dict:
    """What the suite scores against."""
    system, body = shot.system, stage.body
    values = shot.values[stage.before :, : len(stage.markers)]
    tail = values[-(len(values) // 3) :]
    facts = {p.name: p.parameters(s, shot) for p, s in zip(planted, strengths, strict=True)}
    moved = float(np.sqrt(np.mean((tail - tail.mean(0)) ** 2)))
    return {
        "kind": kind,
        "seed": seed,
        "object": body.name,
        "effects": list(facts),
        "parameters": facts,
        "youngs_modulus": body.young,
        "poisson_ratio": body.poisson,
        "frequency_hz": system.frequency[:6].tolist(),
        "damping_ratio": stage.ratio[:6].tolist(),
        "acceptable": list(facts),
        "verdict": "explained" if planted else "adequate",
        "snr_db": float(20 * np.log10(spread(shot, stage) / sigma)),
        "sigma": sigma,
        "floor_tail": sigma / np.hypot(moved, sigma),
        "declared_error": error / spread(shot, stage),
        "ratio": float(np.hypot(error, sigma) / sigma),
        "dimensions": int(shot.values.shape[2]),
        "markers": len(stage.markers),
        "frames": stage.frames,
        "fps": stage.fps,
        "release": stage.release,
    }


def cases(subset: str = "quick", seed: int = 1) -> list:
    """(kind, seed) of a subset: "quick" one of each kind, "whole" what the confusion matrix needs."""
    count = 1 if subset == "quick" else 4
    return [(kind, seed + n) for kind in KINDS for n in range(count if kind != "null" else 5 * count)]
