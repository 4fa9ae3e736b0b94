"""Planted effects that change the body itself: seen in frequencies and shapes."""

from dataclasses import replace

import numpy as np
from scipy import sparse

from . import scene, solid
from .film import Planted

TWO_MODES = {"release": "knock", "reach": (0.35, 0.65), "markers": (6, 13), "damping": (0.008, 0.025)}
NEEDS = {"added_mass": TWO_MODES, "compliant_pin": TWO_MODES}


def modal(name, strength, facts, body) -> Planted:
    """An effect as strong as drawn: its size is judged by frequencies, not by the noise."""
    return Planted(
        name, strength, (strength, strength), facts, body=body, layer="modal", tunable=False
    )


def added_mass(rng, stage) -> Planted:
    node = scene.pick(rng, stage.body, 0.35, 1.0)
    whole = stage.body.weight

    def body(s, plain):
        extra = np.zeros(3 * len(plain.nodes))
        extra[3 * node : 3 * node + 3] = s * whole
        return replace(plain, mass=plain.mass + sparse.diags(extra)), None

    def facts(s, film):
        return {"mass": s * whole, "position": stage.body.nodes[node].tolist()}

    share = np.exp(rng.uniform(np.log(0.05), np.log(0.4)))
    return modal("added_mass", share, facts, body)


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

    return modal("compliant_pin", np.exp(rng.uniform(np.log(0.06), np.log(0.5))), facts, change)
