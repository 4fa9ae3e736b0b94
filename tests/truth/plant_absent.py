"""Planted physics that the library of effects does not hold."""

import numpy as np

from . import forces, scene
from .film import Planted
from .plant import row_of, swinging, touch

NEEDS = {}


def stick_slip(rng, stage) -> Planted:
    """Rubbing that weakens with speed: not in the library."""
    node, k, far = touch(stage, rng, 0.5)
    pace = far * 2 * np.pi / stage.period * rng.uniform(0.1, 0.25)
    ratio = rng.uniform(3.0, 6.0)

    def force(s, system):
        low = s * k * far
        return forces.Rub(
            row_of(stage, system, node),
            lambda speed: low * (1 + (ratio - 1) * np.exp(-((speed / pace) ** 2))),
            40 * k,
        )

    return Planted(
        "stick_slip", 0.02, (0.001, 0.1), lambda s, film: {"force": s * k * far}, force=force
    )


def sudden_crack(rng, stage) -> Planted:
    """The stiffness of a slice drops at an instant: not in the library."""
    when = stage.duration * rng.uniform(0.2, 0.5)
    place = rng.uniform(0.0, 0.4)
    body = stage.body
    part, _ = scene.bodies.solid.matrices(
        body.nodes, body.cells, body.poisson,
        lambda x: body.young * np.exp(-0.5 * ((level(body, x) - place) / 0.08) ** 2),
    )  # fmt: skip

    def force(s, system):
        K = system.basis.T @ (part @ system.basis)
        return forces.Fading(K, lambda t: -s * (t >= when))

    return Planted("sudden_crack", 0.2, (0.01, 0.8), lambda s, film: {"time": when}, force=force)


def pumped_stiffness(rng, stage) -> Planted:
    """The stiffness goes up and down, slower than the body swings: not in the library."""
    pace = 2 * np.pi / stage.period * rng.uniform(0.25, 0.75)
    begin = rng.uniform(0, 2 * np.pi)

    def force(s, system):
        return forces.Fading(system.K, lambda t: s * np.sin(pace * t + begin))

    return Planted("pumped_stiffness", 0.1, (0.01, 0.5), lambda s, film: {"depth": s}, force=force)


def eddy_brake(rng, stage) -> Planted:
    """A magnet brakes what passes near its rest place, the more gently the further: not in the
    library.
    """
    node, k, far = touch(stage, rng, 0.6)
    reach = far * rng.uniform(0.15, 0.4)
    pace = 2 * np.pi / stage.period

    def force(s, system):
        return forces.Brake(row_of(stage, system, node), s * k / pace, reach)

    return Planted("eddy_brake", 0.1, (0.005, 2.0), lambda s, film: {"damping": s}, force=force)


def level(body, x) -> np.ndarray:
    """Height 0..1 of any places (..., 3)."""
    s = body.nodes @ body.axis
    return (x @ body.axis - s.min()) / np.ptp(s)


def intermittent_touch(rng, stage) -> Planted:
    """Something leans on the body in spells: not in the library."""
    node, k, far = touch(stage, rng, 0.5)
    span = stage.duration
    spells, t = [], rng.uniform(0.05, 0.15) * span
    while t < span:
        long = rng.uniform(0.1, 0.2) * span
        spells.append((t, t + long))
        t += long + rng.uniform(0.1, 0.25) * span
    pace = 2 * np.pi / stage.period

    def force(s, system):
        return forces.Touch(row_of(stage, system, node), s * k, 0.1 * s * k / pace, spells)

    return Planted(
        "intermittent_touch", 0.15, (0.01, 0.8), lambda s, film: {"spells": spells}, force=force
    )


def tuned_absorber(rng, stage) -> Planted:
    """A weight on a spring inside, tuned near the first mode: not in the library."""
    node, _, _ = touch(stage, rng, 0.6)
    tune, loss = rng.uniform(0.85, 1.15), rng.uniform(0.02, 0.06)

    def system(s, plain):
        row, r = row_of(stage, plain, node), plain.size
        mode = swinging(stage, plain)
        w = 2 * np.pi * (mode**2 @ plain.frequency) * tune
        mass = s / (row @ mode) ** 2
        link = np.append(row, -1.0)
        grown = [np.pad(m, (0, 1)) for m in (plain.M, plain.C, plain.K)]
        grown[0][r, r] = mass
        grown[1] += 2 * loss * w * mass * np.outer(link, link)
        grown[2] += w**2 * mass * np.outer(link, link)
        basis = np.hstack([plain.basis, np.zeros((len(plain.basis), 1))])
        frequency = np.append(plain.frequency, w / 2 / np.pi)
        return scene.reduced.System(basis, *grown, frequency, np.append(plain.damping_ratio, loss))

    return Planted(
        "tuned_absorber", 0.01, (0.0005, 0.2), lambda s, film: {"share": s}, system=system
    )
