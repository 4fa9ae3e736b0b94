"""`make(kind, seed, folder)`: one case on disk and, returned only, what is really in it.

kind: an effect's name, "null", "plane:x", "two:a+b", "absent:x", "twin:a|b" or "trap:x".
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
    plant,
    plant_absent,
    plant_body,
    plant_camera,
    scene,
    strength,
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
    snr, ratio = strength.loudness(rng, given)
    shot, strengths, sigma, error = strength.tune(stage, planted, snr, ratio)
    shot, error = strength.trim(stage, planted, shot, sigma, error)
    error = max(error, strength.unseen(stage, planted, shot))
    truth = truth_of(kind, seed, stage, planted, strengths, shot, sigma, error)
    if kind == "mesh_stiffening":
        truth["elements"] = int(rng.integers(150, 400))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    takes = [noisy(rng, shot, sigma)]
    more = None if given.get("takes") == 1 else second(rng, kind, stage, planted)
    if more is not None:
        other, planted, entry = more
        again = film.shoot(other, planted, strengths)
        takes.append(noisy(rng, again, sigma))
        truth["takes"], truth["second"] = 2, entry
        parts = [whole_of(other, again)] if entry.get("held_out") else tails(stage, shot, again)
        truth["floor_tail"] = floor(parts, sigma)
    store(folder, f"{kind} {seed} {stage.body.name}", stage, shot, takes, rng, more and more[2])
    return truth


def stand(kind, seed, rng, given):
    """The scene, its planted effects, and what is given or needed for them."""
    names = kinds.planted_in(kind, seed)
    needs = together(names)
    if kind.startswith("trap"):
        needs |= {"release": ("pull", "knock") if kind != "trap:loss" else "pull"}
    needs |= kinds.TWINS.get(kind.split(":")[-1], {}) | kinds.IN_PLANE.get(kind, {})
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
    stage.plane = kind in kinds.IN_PLANE
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
    """A lumped mass that the case declares, beside those that are there."""
    node = scene.pick(rng, stage.body, 0.6, 1.0)
    mass = stage.body.weight * (share or rng.uniform(0.05, 0.25))
    stage.loads = [*stage.loads, (node, mass)]
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
        entry["load"] = [{"mass": m, "position": stage.body.nodes[n]} for n, m in other.loads]
    return other, planted, entry


def noisy(rng, shot, sigma) -> np.ndarray:
    """The film with white noise and, in one of five, some samples missing in short runs."""
    values = shot.values + sigma * rng.standard_normal(shot.values.shape)
    if rng.random() < 0.2:
        for _ in range(int(rng.integers(1, 6))):
            at, marker = rng.integers(len(values)), rng.integers(values.shape[1])
            values[at : at + int(rng.integers(1, 6)), marker] = np.nan
    return values


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
    hidden = {
        "trap:clock",
        "trap:density",
        "clock",
        "poisson_ratio",
        "graded_stiffness",
        "split_modes",
    }
    return {
        "acceptable": right, "verdict": verdict, "modulus_identifiable": kind not in hidden,
        "takes": 1, "second": None, "elements": None,
    }  # fmt: skip


def tails(stage, *shots) -> list:
    """The last third of each film after the release, object's markers only."""
    free = [shot.values[stage.before :, : len(stage.markers)] for shot in shots]
    return [values[-(len(values) // 3) :] for values in free]


def whole_of(stage, shot) -> np.ndarray:
    """A held-out take from two periods after the release on."""
    skip = stage.before + int(np.ceil(2 * stage.period * stage.fps))
    return shot.values[skip:, : len(stage.markers)]


def floor(parts: list, sigma: float) -> float:
    """Held-out NRMSE of the truth itself: the noise over the measured motion about its mean."""
    moved = np.concatenate([((p - p.mean(0)) ** 2).ravel() for p in parts]).mean()
    return float(sigma / np.sqrt(moved + sigma**2))


def truth_of(kind, seed, stage, planted, strengths, shot, sigma, error) -> dict:
    """What the suite scores against."""
    system, body = shot.system, stage.body
    facts = {p.name: p.parameters(s, shot) for p, s in zip(planted, strengths, strict=True)}
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
        "snr_db": float(20 * np.log10(strength.spread(shot, stage) / sigma)),
        "sigma": sigma,
        "floor_tail": floor(tails(stage, shot), sigma),
        "declared_error": error / strength.spread(shot, stage),
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
