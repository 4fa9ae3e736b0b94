"""Planted effects of the time layer, as physical forces. Each draws its own form by seed."""

import numpy as np

from . import forces, scene, solid
from .film import Planted

HAND = ("pull", "pull", "knock")
LONG = {"damping": (0.01, 0.03), "release": HAND}
OTHER = LONG | {"ratio": 5.0}
KNOCKED = {"damping": (0.012, 0.03), "release": "knock", "fps": "fast", "reach": (0.3, 0.65)}
NEEDS = {
    "large_amplitude": LONG,
    "dry_friction": {"damping": (0.01, 0.03)},
    "air_drag": {"damping": (0.01, 0.03), "amplitude": (0.1, 0.2), "release": HAND},
    "relaxation": {"release": ("pull", "pull", "gravity"), "damping": (0.015, 0.06)},
    "contact": {"release": "pull"},
    "asymmetric_stiffness": {"release": HAND},
    "stiffness_drift": {"release": HAND},
    "steady_drive": {"bare": True, "damping": (0.015, 0.06)},
    "structural_damping": KNOCKED,
    "viscous_damping": KNOCKED,
    "stick_slip": OTHER,
    "tuned_absorber": OTHER,
    "sudden_crack": OTHER | {"bare": True},
    "intermittent_touch": OTHER | {"bare": True},
}


def stiffness_at(stage, node: int) -> float:
    """N/m of the body at a node along the release."""
    push = scene.nodal(stage.body, node, stage.direction)
    return 1 / float(push @ scene.bodies.respond(stage.body, push[:, None])[:, 0])


def share_at(stage, film, node: int) -> float:
    """Motion of the marker that moves most over that of `node`, in what swings lowest."""
    mode = swinging(stage, film.system)
    marker = stage.markers[film.facts["peak"]["marker"]]
    here = abs(stage.direction @ film.system.at(node) @ mode)
    return float(np.linalg.norm(film.system.at(marker) @ mode) / here)


def swinging(stage, system) -> np.ndarray:
    """(r,) what swings lowest along the release: one of the two lowest modes, or their mixture.

    Two modes of one pitch have no directions of their own: they swing as one, along the release.
    """
    row = (stage.direction @ system.at(stage.node)) / system.frequency**2
    mode = np.zeros(len(row))
    first, second = system.frequency[:2]
    low = slice(2) if second < 1.03 * first else [int(np.argmax(abs(row[:2])))]
    mode[low] = row[low]
    return mode / np.linalg.norm(mode)


def touch(stage, rng, low=0.5, high=1.0) -> tuple[int, float, float]:
    """A node for a force: its number, local stiffness (N/m) and about how far it will move (m)."""
    node = scene.pick(rng, stage.body, low, high)
    stage.touched.append(node)
    _, shapes = scene.bodies.modes(stage.body, 2)
    moves = abs(stage.direction @ shapes.reshape(-1, 3, 2)[[node, stage.node]])
    best = int(np.argmax(moves[1]))
    return node, stiffness_at(stage, node), stage.amplitude * moves[0, best] / moves[1, best]


def row_of(stage, system, node):
    return stage.direction @ system.at(node)


def large_amplitude(rng, stage) -> Planted:
    node, k, far = touch(stage, rng, 0.7)
    sign = 1 if rng.random() < 0.65 else -1
    form = rng.choice(["cubic", "sinh"]) if sign > 0 else "soft"

    def law(s):
        y = {
            "cubic": lambda x: k * s * x * (x / far) ** 2,
            "sinh": lambda x: k * s * far * 0.75 * (np.sinh(2 * x / far) - 2 * x / far),
            "soft": lambda x: -k * s * x * (x / far) ** 2 / (1 + (x / far) ** 2),
        }
        return y[form]

    def facts(s, film):
        mode = swinging(stage, film.system)
        row = row_of(stage, film.system, node) @ mode
        cubic = sign * k * s / far**2
        square = mode**2 @ (2 * np.pi * film.system.frequency) ** 2
        at_node = (
            3 / 8 * cubic * row**4 / square / row**2
        )  # Duffing: per squared motion of the node
        return {"shift_per_metre2": at_node / share_at(stage, film, node) ** 2, "form": str(form)}

    top = 2.0 if sign > 0 else 0.6
    return Planted(
        "large_amplitude", 0.2, (0.005, top), facts,
        force=lambda s, system: forces.Spring(row_of(stage, system, node), law(s)),
    )  # fmt: skip


def asymmetric_stiffness(rng, stage) -> Planted:
    node, k, far = touch(stage, rng, 0.6)
    form, sign = rng.choice(["bilinear", "quadratic"]), rng.choice([-1, 1])

    def law(s):
        if form == "bilinear":
            return lambda x: k * s * max(sign * x, 0.0) * sign
        most = 0.45 * far / s  # beyond, it goes on evenly: a tenth of the body's stiffness is left

        def quadratic(x):
            near = min(max(x, -most), most)
            return k * s * sign * near * (2 * x - near) / far

        return quadratic

    def facts(s, film):
        return {"form": str(form), "local_ratio": 1 + s if form == "bilinear" else None}

    return Planted(
        "asymmetric_stiffness", 0.15, (0.005, 1.5 if form == "bilinear" else 0.5), facts,
        force=lambda s, system: forces.Spring(row_of(stage, system, node), law(s)),
    )  # fmt: skip


def contact(rng, stage) -> Planted:
    node, k, far = touch(stage, rng, 0.6)
    near = (0.01, 0.05) if stage.needs.get("gapless") else (0.25, 0.7)
    gap, side = far * rng.uniform(*near), rng.choice([-1, 1])

    def law(s):
        return lambda x: k * s * max(side * x - gap, 0.0) * side

    def facts(s, film):
        return {"gap": gap * share_at(stage, film, node), "local_stiffness": k * s}

    return Planted(
        "contact", 1.0, (0.05, 30.0), facts,
        force=lambda s, system: forces.Spring(row_of(stage, system, node), law(s)),
    )  # fmt: skip


def dry_friction(rng, stage) -> Planted:
    node, k, far = touch(stage, rng, 0.4)
    stiff = rng.uniform(20, 60)

    def force(s, system):
        if stage.plane:
            sideways = np.cross(stage.direction, np.eye(3)[np.abs(stage.direction).argmin()])
            rows = np.array([stage.direction, sideways / np.linalg.norm(sideways)])
            return forces.PlaneRub(rows @ system.at(node), s * k * far, stiff * k)
        return forces.Rub(row_of(stage, system, node), lambda speed: s * k * far, stiff * k)

    return Planted(
        "dry_friction", 0.02, (0.001, 0.12), lambda s, film: {"force": s * k * far}, force=force
    )


def air_drag(rng, stage) -> Planted:
    body = stage.body
    area = solid.middle_areas(body.nodes, body.faces)
    skin = body.faces[:, 4]
    area, skin = area[~body.pinned[skin]], skin[~body.pinned[skin]]
    thick = body.weight / body.density / np.linalg.norm(area, axis=1).sum() * 4
    guess = body.density * thick / stage.amplitude

    def force(s, system):
        motion = system.basis.reshape(-1, 3, system.size)[skin].reshape(-1, system.size)
        return forces.Drag(motion, area, s * guess)

    return Planted(
        "air_drag",
        min(0.05, 1000 / guess),
        (10 / guess, 3000 / guess),
        lambda s, film: {"coefficient": s * guess},
        force=force,
    )


def relaxation(rng, stage) -> Planted:
    time = stage.duration * np.exp(rng.uniform(np.log(0.1), np.log(0.5)))
    stage.hold = np.inf if stage.release == "gravity" else time * rng.choice([0.7, 2.0, 10.0])

    def system(s, plain):
        return scene.reduced.System(**{**vars(plain), "branch": (s, time)})

    return Planted(
        "relaxation", 0.1, (0.005, 0.6), lambda s, film: {"ratio": s, "time": time}, system=system
    )


def stiffness_drift(rng, stage) -> Planted:
    sign = rng.choice([-1, 1])
    bend = rng.choice([0.0, 0.7])  # 0: straight in time, else it levels off
    span = stage.duration

    def share(s):
        if bend:
            return lambda t: sign * s * (1 - np.exp(-t / (bend * span)))
        return lambda t: sign * s * t / span

    def facts(s, film):
        rate = sign * s / span / bend if bend else sign * s / span
        return {"rate": rate, "form": "levelling" if bend else "straight"}

    return Planted(
        "stiffness_drift", 0.05, (0.002, 0.3), facts,
        force=lambda s, system: forces.Fading(system.K, share(s)),
    )  # fmt: skip


def steady_drive(rng, stage) -> Planted:
    first = scene.bodies.modes(stage.body, 2)[0]
    while True:
        f = first[0] * np.exp(rng.uniform(np.log(0.35), np.log(2.6)))
        if (abs(f / first - 1) > 0.1).all() and f < 0.35 * stage.fps:
            break
    phase = rng.uniform(0, 2 * np.pi)
    w = 2 * np.pi * f
    body, d = stage.body, stage.direction
    inertia = body.mass @ np.tile(d, len(body.nodes))

    def force(s, system):
        a = s * stage.amplitude
        return forces.Shaken(system.basis.T @ inertia, lambda t: -a * w * w * np.sin(w * t + phase))

    def shift(s, t):
        return s * stage.amplitude * np.sin(w * t + phase)[:, None] * d

    return Planted(
        "steady_drive", 0.03, (0.0005, 0.5),
        lambda s, film: {"frequency": f, "amplitude": s * stage.amplitude},
        force=force, shift=shift,
    )  # fmt: skip


def viscous_damping(rng, stage) -> Planted:
    """The case declares no damping at all."""
    stage.declared = ()
    ratio = stage.ratio[:3].tolist()
    return Planted(
        "viscous_damping", 1.0, (1, 1), lambda s, film: {"damping_ratio": ratio}, tunable=False
    )


def structural_damping(rng, stage) -> Planted:
    """One loss factor for every mode, and the case declares no damping."""
    stage.declared = ()
    stage.ratio = np.full_like(stage.ratio, stage.ratio[0])
    eta = 2 * float(stage.ratio[0])
    return Planted(
        "structural_damping", 1.0, (1, 1), lambda s, film: {"loss_factor": eta}, tunable=False
    )
