"""`make(kind, seed, folder)`: one case on disk and, returned only, what is really in it.

kind: an effect's name, "null", "two:a+b", "absent:x", "twin:a|b" or "trap:x".
"""

import copy
from dataclasses import replace
from pathlib import Path

import numpy as np

from . import (
    bodies,
    camera,
    film,
    kinds,
    linear_fit,
    plant,
    plant_absent,
    plant_body,
    plant_camera,
    scene,
    write,
)

MODULES = (plant, plant_absent, plant_body, plant_camera)
NEEDS = {name: needs for module in MODULES for name, needs in module.NEEDS.items()}
SECOND = {  # kinds that sometimes come with a second take, and of which sort
    "null": ("softer", "loaded"), "large_amplitude": ("softer",), "dry_friction": ("softer",),
    "air_drag": ("softer",), "asymmetric_stiffness": ("other_side",), "contact": ("other_side",),
    "relaxation": ("other_side", "softer"), "added_mass": ("loaded",),
    "compliant_pin": ("loaded",), "graded_stiffness": ("loaded",),
}  # fmt: skip


def effect(name: str):
    """The planting function of an effect."""
    for module in MODULES:
        if hasattr(module, name):
            return getattr(module, name)
    raise KeyError(f"truth: no effect {name!r} can be planted.")


def make(kind: str, seed: int, folder, **given) -> dict:
    """Write the case of `kind` and `seed` in `folder`; return the truth, which is not there.

    `given`: object= a name of bodies.OBJECTS, flat= True for 2-D, snr= dB, ratio= declared error
    over the noise floor, takes= 1 for a single take.
    """
    rng = np.random.default_rng([seed, kinds.number(kind)])
    stage, planted, given = stand(kind, seed, rng, given)
    snr, ratio = loudness(rng, given)
    shot, strengths, sigma, error = tune(stage, planted, snr, ratio)
    shot, error = trim(stage, planted, shot, sigma, error)
    truth = truth_of(kind, seed, stage, planted, strengths, shot, sigma, error)
    if kind == "mesh_stiffening":
        truth["elements"] = int(rng.integers(150, 400))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    takes = [noisy(rng, shot, sigma)]
    more = None if given.get("takes") == 1 else second(rng, kind, stage, planted)
    if more is not None:
        other, planted, entry = more
        takes.append(noisy(rng, film.shoot(other, planted, strengths), sigma))
        truth["takes"], truth["second"] = 2, entry
    store(folder, f"{kind} {seed} {stage.body.name}", stage, shot, takes, rng, more and more[2])
    return truth


def stand(kind, seed, rng, given):
    """The scene, its planted effects, and what is given or needed for them."""
    names = kinds.planted_in(kind, seed)
    needs = together(names)
    if kind.startswith("trap"):
        needs |= {"release": ("pull", "knock") if kind != "trap:loss" else "pull"}
    needs |= kinds.TWINS.get(kind.split(":")[-1], {})
    choice = needs.get("objects", tuple(bodies.OBJECTS))
    name = given.get("object") or choice[(seed + kinds.number(kind)) % len(choice)]
    body = bodies.OBJECTS[name](rng, symmetric=needs.get("symmetric", False))
    stage = scene.draw(rng, body, needs)
    flat = given.get("flat", needs.get("flat", rng.random() < 0.45))
    if flat:
        tilt = needs.get("tilt", 0.35)
        stage.camera = camera.draw(rng, stage.body, tilt, portrait=needs.get("portrait", False))
        if rng.random() < 0.2 and "perspective" not in names:
            size = np.linalg.norm(np.ptp(body.nodes, axis=0))
            stage.pinhole = True
            stage.camera = replace(stage.camera, distance=size * rng.uniform(3, 10))
    if kind == "null" and rng.random() < 0.2:
        load_known(rng, stage)
    planted = [effect(name)(rng, stage) for name in names]
    return stage, planted, {**needs, **given}


def together(names: list) -> dict:
    """What several effects need, with a way of release that suits all of them."""
    needs, ways = {}, None
    for name in names:
        own = NEEDS.get(name, {})
        needs |= own
        if "release" in own:
            mine = {own["release"]} if isinstance(own["release"], str) else set(own["release"])
            ways = mine if ways is None else ways & mine
    if len(names) > 1 and ways is not None:
        needs["release"] = tuple(sorted(ways)) or "pull"
    return needs


def load_known(rng, stage, share=None) -> None:
    """A lumped mass that the case declares."""
    node = scene.pick(rng, stage.body, 0.6, 1.0)
    mass = stage.body.weight * (share or rng.uniform(0.05, 0.25))
    stage.loads = [(node, mass)]
    stage.body = replace(stage.body, mass=plant_body.weighted(stage.body, node, mass))


def second(rng, kind, stage, planted):
    """Sometimes another take: (scene, planted, its entry in the case) or None."""
    if planted and getattr(planted[0], "turned", None):
        other = copy.copy(stage)
        body = planted[0].turned()
        other.body = replace(stage.body, nodes=body.nodes)
        again = copy.copy(planted[0])
        again.body = lambda s, plain: (body, None)
        return other, [again], {"gravity": -stage.weighed}
    if kind not in SECOND or stage.release == "gravity" or rng.random() > 0.35:
        return None
    how = str(rng.choice(SECOND[kind]))
    other = copy.copy(stage)
    other.plain = None
    entry = {"held_out": bool(rng.random() < 0.4)} if how != "loaded" else {}
    if how == "other_side":
        other.direction = stage.direction
        other.amplitude = -stage.amplitude * rng.uniform(0.6, 1.0)
    elif how == "softer":
        other.amplitude = stage.amplitude * rng.uniform(0.3, 0.6)
    else:
        load_known(rng, other)
        place = stage.body.nodes[other.loads[0][0]]
        entry["load"] = [{"mass": other.loads[0][1], "position": place}]
    return other, planted, entry


def noisy(rng, shot, sigma) -> np.ndarray:
    """The film with white noise and, in one of five, some samples missing in short runs."""
    values = shot.values + sigma * rng.standard_normal(shot.values.shape)
    if rng.random() < 0.2:
        for _ in range(int(rng.integers(1, 6))):
            at, marker = rng.integers(len(values)), rng.integers(values.shape[1])
            values[at : at + int(rng.integers(1, 6)), marker] = np.nan
    return values


def loudness(rng, given) -> tuple[float, float]:
    """Signal to noise (dB) and the declared model's error over the noise floor."""
    snr = given.get("snr", (20, 50))
    snr = rng.uniform(*snr) if isinstance(snr, tuple) else snr
    noise = 10 ** (-snr / 20)
    if given.get("ratio"):
        return snr, min(given["ratio"], max(0.35 / noise, 1.5))
    low, high = max(2.0, 0.012 / noise), min(10.0, 0.3 / noise)
    ratio = np.exp(rng.uniform(np.log(min(low, high)), np.log(max(low, high))))
    return snr, ratio


def error_of(stage, planted, shot) -> float:
    """RMS (m or px) that the declared linear model leaves of a clean film, for the effects' sake.

    What it leaves of the same film without any effect (modes too many to fit) does not count.
    """
    modal = any(p.layer == "modal" for p in planted)
    key = (modal, len(shot.values))
    if any(p.name == "aliasing" for p in planted):
        stage.without[key] = 0.0
    if key not in stage.without:
        stage.without[key] = left_of(stage, film.shoot(stage, [], []), modal, len(shot.values))
    return float(np.sqrt(max(left_of(stage, shot, modal) ** 2 - stage.without[key] ** 2, 0.0)))


def left_of(stage, shot, modal: bool, count=None) -> float:
    """RMS (m or px) of what a fit of the strongest modes leaves."""
    values = shot.values[stage.before : count, : len(stage.markers)]
    values = values.reshape(len(values), -1)
    time = shot.nominal[stage.before : count] - shot.nominal[stage.before]
    plain = film.model(stage, [])
    flat = np.array([seen(stage, shot, plain.at(n)) for n in stage.markers]).reshape(-1, plain.size)
    start, _ = scene.start_of(stage, plain)
    r = plain.size
    size = np.hypot(start[:r], start[r : 2 * r] / (2 * np.pi * plain.frequency))
    size = size * np.linalg.norm(flat, axis=0) * (plain.frequency < 0.5 * stage.fps)
    if not modal:  # free shapes: of two modes at one frequency the stronger will do
        twin = np.abs(np.diff(plain.frequency)) < 2e-3 * plain.frequency[1:]
        weaker = np.flatnonzero(twin) + (size[:-1][twin] > size[1:][twin])
        size[weaker] = 0
    strong = np.sort(np.argsort(size)[::-1][:6])
    strong = strong[size[strong] > 0.003 * size.max()]
    f, z = plain.frequency[strong], plain.damping_ratio[strong]
    return linear_fit.leftover(time, values, f, z, flat[:, strong] if modal else None)


def seen(stage, shot, motion) -> np.ndarray:
    """Motion (3, r) of a marker as (d, r) of its channels, by the declared camera."""
    if shot.values.shape[2] == 3:
        return motion
    rows = np.array([stage.camera.right, stage.camera.down]) / stage.camera.metres_per_pixel
    return rows @ motion


def trim(stage, planted, shot, sigma: float, error: float):
    """Stop filming where nothing is seen to move any more, as anybody would."""
    values = shot.values[stage.before :, : len(stage.markers)]
    third = len(values) // 3
    while stage.frames > 100 and (values[-third:].std(0) ** 2).mean() < (2 * sigma) ** 2:
        stage.frames = max(int(stage.frames * 0.85), 100)
        values, third = values[: stage.frames], stage.frames // 3
    whole = stage.before + stage.frames
    if whole < len(shot.values):
        shot.nominal, shot.time, shot.values = (
            a[:whole] for a in (shot.nominal, shot.time, shot.values)
        )
        error = error_of(stage, planted, shot) if planted else error
    return shot, error


def tune(stage, planted, snr: float, ratio: float):
    """Strengths that leave `ratio` times the noise, by secant in the logarithm; else less noise."""
    strengths = [p.strength for p in planted]
    shot = film.shoot(stage, planted, strengths)
    rms = spread(shot, stage)
    sigma = rms * 10 ** (-snr / 20)
    wanted = sigma * np.sqrt(ratio**2 - 1)
    if not planted:
        return shot, strengths, sigma, left_of(stage, shot, False)
    alone = {}
    for i, one in enumerate(planted):
        strengths[i], alone[one.name] = tune_one(stage, one, wanted)
    shot = film.shoot(stage, planted, strengths)
    shot.facts["alone"] = alone
    fitted = [alone[p.name] for p in planted if p.tunable or p.name == "lost_frames"]
    if fitted:
        sigma = min(max(min(fitted) / np.sqrt(ratio**2 - 1), rms * 10**-2.5), rms * 0.1)
    return shot, strengths, sigma, error_of(stage, planted, shot)


def tune_one(stage, one, wanted: float) -> tuple[float, float]:
    """Strength whose leftover (m or px) is near `wanted`, and the leftover."""
    s, power = one.strength, 1.0
    error = error_of(stage, [one], film.shoot(stage, [one], [s]))
    if not np.isfinite(error):
        raise ValueError(f"truth: {one.name} of strength {s} blows up.")
    for _ in range(3 if one.tunable else 0):
        if abs(np.log(max(error, 1e-30) / wanted)) < 0.15:
            break
        new = float(np.clip(s * (wanted / max(error, 1e-30)) ** (1 / power), *one.limits))
        if abs(np.log(new / s)) < 0.02:
            break
        after = error_of(stage, [one], film.shoot(stage, [one], [new]))
        if min(after, error) > 0:
            power = np.clip(np.log(after / error) / np.log(new / s), 0.4, 3.0)
        s, error = new, after
    return s, error


def spread(shot, stage) -> float:
    """RMS (m or px) of the object's markers about their means, after the release."""
    values = shot.values[stage.before :, : len(stage.markers)]
    return float(np.sqrt(np.mean((values - values.mean(0)) ** 2)))


def store(folder, title, stage, shot, takes, rng, more=None) -> None:
    """The case as its author would write it: what he knows, and nothing else."""
    body = stage.body
    names = [f"m{i + 1}" for i in range(len(stage.markers))]
    names += [f"s{i + 1}" for i in range(len(stage.support))]
    timed = stage.camera is None or rng.random() < 0.5
    write.surface(folder / "body.obj", body.vertices, body.triangles)
    for n, values in enumerate(takes):
        where = folder / f"tracks{n + 1 if n else ''}.csv"
        write.tracks(where, names, values, shot.nominal if timed else None)
    thing = {"mesh": "body.obj", "length_unit": "m", "density": body.density}
    thing["poisson_ratio"] = body.poisson
    if stage.gravity is not None:
        thing |= {"gravity": stage.gravity, "shape": "unloaded"}
    if stage.weighed is not None:
        thing |= {"gravity": stage.weighed, "shape": "equilibrium"}
    thing |= stage.said
    recording = {"tracks": "tracks.csv", "capture_fps": stage.fps}
    if stage.start is not None:
        recording["start"] = round(stage.start, 6)
    again = recording | {"tracks": "tracks2.csv"} | (more or {}) if len(takes) > 1 else None
    known = [{"mass": m, "position": body.nodes[n]} for n, m in stage.loads]
    lens = "pinhole" if stage.pinhole else "orthographic"
    low, high = (np.round(side, 6) for side in body.pin_box)
    tables = [
        ("[object]", thing),
        ("[[pin]]", {"box": {"min": low, "max": high}}),
        *(("[[load]]", one) for one in known),
        ("[model]", {"declared": list(stage.declared)}),
        ("[recording]", recording),
        ("[[take]]", again),
        ("[camera]", stage.camera.entry(lens) if stage.camera else None),
    ]
    for name, node in zip(names, [*stage.markers, *stage.support], strict=True):
        on = "object" if name[0] == "m" else "support"
        tables.append(("[[marker]]", {"name": name, "on": on, "position": body.nodes[node]}))
    write.case(folder, {"name": title}, tables)


def expected(kind: str, names: list) -> dict:
    """Which names are right, which verdict, and whether the case can show Young's modulus."""
    group = kind.split(":")[0]
    right, verdict = names, "explained" if names else "adequate"
    if group == "twin":
        right = kind.split(":")[1].split("|")
    if kind == "structural_damping":
        right = ["structural_damping", "viscous_damping"]
    if group == "trap":
        right, verdict = [], "adequate"
    if group == "absent":
        right, verdict = [], "unexplained"
    hidden = {"trap:clock", "trap:density", "clock", "poisson_ratio", "graded_stiffness"}
    return {
        "acceptable": right, "verdict": verdict, "modulus_identifiable": kind not in hidden,
        "takes": 1, "second": None, "elements": None,
    }  # fmt: skip


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
        "youngs_modulus_dynamic": body.young * (1 + facts.get("relaxation", {}).get("ratio", 0.0)),
        "poisson_ratio": body.poisson,
        "frequency_hz": system.frequency[:6].tolist(),
        "damping_ratio": stage.ratio[:6].tolist(),
        **expected(kind, list(facts)),
        "snr_db": float(20 * np.log10(spread(shot, stage) / sigma)),
        "sigma": sigma,
        "floor_tail": sigma / np.hypot(moved, sigma),
        "declared_error": error / spread(shot, stage),
        "ratio": float(np.hypot(error, sigma) / sigma),
        "ratios": {
            k: float(np.hypot(e, sigma) / sigma) for k, e in shot.facts.get("alone", {}).items()
        },
        "dimensions": int(shot.values.shape[2]),
        "markers": len(stage.markers),
        "frames": stage.frames,
        "fps": stage.fps,
        "release": stage.release,
    }
