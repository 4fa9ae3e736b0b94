"""Planted effects that change the body itself: seen in frequencies and shapes."""

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from . import bodies, scene, solid
from .film import Planted

TWO_MODES = {
    "release": "knock", "reach": (0.3, 0.65), "markers": (6, 13), "damping": (0.008, 0.025),
    "snr": (28, 50), "fps": "fast",
}  # fmt: skip
NEEDS = {
    "added_mass": TWO_MODES,
    "compliant_pin": TWO_MODES,
    "graded_stiffness": TWO_MODES,
    "poisson_ratio": TWO_MODES
    | {"objects": ("bracket", "pudding", "jelly"), "turn": (0.3, 1.2), "off_centre": True},
    "split_modes": {
        "objects": ("bar", "pudding", "jelly", "strip"), "symmetric": True, "turn": (0.5, 1.07),
        "damping": (0.008, 0.025), "markers": (4, 13),
    },
    "gravity_preload": TWO_MODES | {"objects": ("strip", "jelly")},
    "density": {},
    "loss": {"release": "pull", "markers": (1, 4)},
    "mesh_stiffening": TWO_MODES,
}  # fmt: skip
G = np.array([0.0, 0.0, -9.81])


def modal(name, strength, facts, body) -> Planted:
    """An effect as strong as drawn: its size is judged by frequencies, not by the noise."""
    return Planted(
        name, strength, (strength, strength), facts, body=body, layer="modal", tunable=False
    )


def log_uniform(rng, low, high) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def weighted(body, node: int, mass: float):
    """The mass matrix with `mass` kg glued on around a node, on a patch and not on a point."""
    row = sparse.csr_matrix(scene.grip(body, node))
    return body.mass + sparse.kron(mass * (row.T @ row), sparse.eye(3), format="csr")


def added_mass(rng, stage) -> Planted:
    node = scene.pick(rng, stage.body, 0.35, 1.0)
    whole = stage.body.weight

    def change(s, plain):
        return replace(plain, mass=weighted(plain, node, s * whole)), None

    def facts(s, film):
        return {"mass": s * whole, "position": stage.body.nodes[node].tolist()}

    return modal("added_mass", log_uniform(rng, 0.06, 0.4), facts, change)


def compliant_pin(rng, stage) -> Planted:
    body = stage.body
    reach = body.young / body.size

    def bed(k):
        on = body.pinned[body.faces].all(1)
        area = np.linalg.norm(solid.area_vectors(body.nodes, body.faces[on]), axis=1)
        return sparse.diags(np.repeat(k * area, 3)).tocsr()

    def change(s, plain):
        return plain, bed(1.5 * reach / s)

    def facts(s, film):
        return {"stiffness": 1.5 * reach / s}

    return modal("compliant_pin", log_uniform(rng, 0.1, 0.6), facts, change)


def stiffness_of(body, modulus, poisson=None):
    """At E = 1 Pa times the field `modulus`, with the body's Poisson ratio or another one."""
    nu = body.poisson if poisson is None else poisson
    return solid.matrices(body.nodes, body.cells, nu, modulus)[0]


def restiffened(body, modulus, poisson=None):
    """The planting of another field of E (times its own) or another Poisson ratio."""
    K = stiffness_of(body, modulus, poisson)
    return lambda s, plain: (replace(plain, stiffness=plain.young * K), None)


def graded_stiffness(rng, stage) -> Planted:
    body = stage.body
    form = rng.choice(["linear", "exponential"])
    ratio = log_uniform(rng, 1.5, 3.0) ** rng.choice([-1, 1])
    start = body.nodes @ body.axis

    def modulus(x):
        s = (x @ body.axis - start.min()) / np.ptp(start)
        return 1 + (ratio - 1) * s if form == "linear" else ratio**s

    def facts(s, film):
        return {"ratio": ratio, "axis": body.axis.tolist(), "form": str(form)}

    return modal("graded_stiffness", ratio, facts, restiffened(body, modulus))


def poisson_ratio(rng, stage) -> Planted:
    """The stuff has another Poisson ratio than the case says."""
    low = stage.body.poisson < 0.46
    value = 0.49 if low and rng.random() < 0.3 else float(rng.uniform(0.15, 0.36))
    change = restiffened(stage.body, None, value)
    return modal("poisson_ratio", value, lambda s, film: {"value": value}, change)


def split_modes(rng, stage) -> Planted:
    """The mesh is symmetric, the stuff is stiffer on two opposite sides."""
    body = stage.body
    side = np.cross(body.axis, body.swing)
    way = rng.choice([-1, 1])
    half = np.ptp(body.nodes @ body.swing) / 2

    def lobes(x):
        return way * ((x @ side) ** 2 - (x @ body.swing) ** 2) / half**2

    part, _ = solid.matrices(body.nodes, body.cells, body.poisson, lobes)

    def change(s, plain):
        return replace(plain, stiffness=plain.stiffness + s * body.young * part), None

    def facts(s, film):
        f = film.system.frequency
        return {"split": float((f[1] - f[0]) / f[:2].mean())}

    strength = log_uniform(rng, 0.05, 0.5)
    return modal("split_modes", strength, facts, change)


def sink(body, gravity) -> np.ndarray:
    """(3N,) m: nonlinear equilibrium of the body under its weight, by Newton's method."""
    load = body.mass @ np.tile(gravity, len(body.nodes))
    free, u = body.free, np.zeros(3 * len(body.nodes))
    for _ in range(12):
        inner, K = solid.bent(body.nodes, body.cells, body.poisson, u)
        left = (load - body.young * inner)[free]
        step = splu((body.young * K)[free][:, free].tocsc()).solve(left)
        u[free] += step
        if abs(step).max() < 1e-9 * body.size:
            break
    return u


def loaded(body, gravity) -> tuple[np.ndarray, sparse.csr_matrix]:
    """Displacement (N, 3) m under the weight, and the stiffness about it."""
    u = sink(body, gravity)
    _, rest = solid.bent(body.nodes, body.cells, body.poisson, 0 * u)
    _, K = solid.bent(body.nodes, body.cells, body.poisson, u)
    return u.reshape(-1, 3), body.stiffness + body.young * (K - rest)


def gravity_preload(rng, stage) -> Planted:
    """The given mesh is the body as it hangs or stands; its weight is in its stiffness."""
    first = rng.uniform(1.6, 2.6) if stage.body.name == "strip" else rng.uniform(3.2, 4.8)
    body = bodies.tuned(stage.body, first)
    u, tangent = loaded(body, G)
    while bodies.modes(replace(body, stiffness=tangent), 1)[0][0] < 0.6 * first:  # near to buckling
        first *= 1.25
        body = bodies.tuned(body, first)
        u, tangent = loaded(body, G)
    used, faces = np.unique(body.faces, return_inverse=True)
    seen = replace(body, nodes=body.nodes + u, vertices=(body.nodes + u)[used])
    seen = replace(seen, triangles=solid.triangles(faces.reshape(-1, 9)))
    stage.body = replace(seen, stiffness=seen.young * stiffness_of(seen, None))
    stage.weighed = G
    one = modal("gravity_preload", 1.0, lambda s, film: {}, None)
    one.body = lambda s, plain: (replace(plain, stiffness=tangent), None)
    if body.name == "jelly" and rng.random() < 0.5:

        def turned():
            down, other = loaded(body, -G)
            return replace(stage.body, nodes=body.nodes + down, stiffness=other)

        one.turned = turned
    return one


# --- what Young's modulus or damping swallows ------------------------------------------------


def density(rng, stage) -> Planted:
    """The case states a wrong density."""
    factor = rng.choice([rng.uniform(0.7, 0.88), rng.uniform(1.12, 1.35)])
    stage.said["density"] = stage.body.density * factor
    return Planted("density", 1.0, (1, 1), lambda s, film: {"factor": factor}, tunable=False)


def loss(rng, stage) -> Planted:
    """One loss factor, but only one mode to see it in."""
    stage.ratio = np.full_like(stage.ratio, stage.ratio[0])
    eta = 2 * stage.ratio[0]
    return Planted("loss", 1.0, (1, 1), lambda s, film: {"loss_factor": eta}, tunable=False)


def mesh_stiffening(rng, stage) -> Planted:
    """Nothing is wrong but the mesh that is asked for."""
    return Planted("mesh_stiffening", 1.0, (1, 1), lambda s, film: {}, tunable=False)
