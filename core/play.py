"""The found motion of the whole body, as shapes and weights that a bake can play."""

import numpy as np

from .arcs import aside_of, loudest
from .data import Motion
from .elasticity import gravity_force, point_operator, static
from .joint import Heard
from .law import TimeFit
from .timefit import trajectories

SAMPLES_PER_PERIOD = 32
COARSER = 4  # times as few in a period of modes that were not heard, at least


def motion(heard: Heard, found: TimeFit, youngs_modulus: float, known: int | None = None) -> Motion:
    """Modal shapes at the artist's vertices with their weights over time, effects included.

    Motions that are known at the markers only (a slow return, a drive, a second direction) are
    spread over the body as the combination of its lowest modes that shows them best there.
    known: how many of the modes, the first ones, were heard; all by default. Of the others no
    pitch is told, and they are not sampled as finely.
    """
    body, law = heard.body, found.law
    data = law.takes[law.fitted[0]]
    K = law.modes if known is None else known
    top = max(found.frequency[:K].max(), found.frequency.max() / COARSER)
    time = np.arange(0, data.time[-1] + 1e-12, 1 / (SAMPLES_PER_PERIOD * top))
    time = np.r_[time, data.time[-1]] if time[-1] < data.time[-1] else time
    u, columns = trajectories(found, time)
    skin = point_operator(body.model, body.case.surface.vertices)
    if heard.turns[0] is None:
        names, shapes, weights = [], np.zeros((len(body.case.surface.vertices), 3, 0)), u[:, :0]
    else:
        seen = heard.turns[0].T @ body.seen(data)
        unit = np.einsum("kc,kc->k", law.reference, seen)
        shapes_of = heard.shapes() / unit
        shapes = _spread(skin, shapes_of)
        names = [f"mode {k + 1}: {f:.3g} Hz" for k, f in enumerate(found.frequency[:K])]
        names += [f"mode {k + 1}, not heard" for k in range(K, law.modes)]
        weights = u
        if data.arcs:
            arcs, products, labels = _arcs(heard, shapes_of, u)
            shapes = np.concatenate([shapes, _spread(skin, arcs)], axis=2)
            weights, names = np.hstack([weights, products]), [*names, *labels]
    extra = _extra(heard, found, columns)
    if extra is not None:
        fields, weight, labels = extra
        shapes = np.concatenate([shapes, _spread(skin, fields)], axis=2)
        weights, names = np.hstack([weights, weight]), [*names, *labels]
    case = body.case
    if case.shape == "unloaded" and case.takes[0].gravity is not None:
        sag = static(body.model, gravity_force(body.model, case.takes[0].gravity), youngs_modulus)
        shapes = np.concatenate([shapes, _spread(skin, sag[:, :, None])], axis=2)
        weights, names = np.hstack([weights, np.ones((len(time), 1))]), [*names, "sag"]
    return Motion(tuple(names), shapes, time, weights)


def _arcs(heard: Heard, shapes: np.ndarray, u: np.ndarray):
    """Fields (P, 3, q), weights (T, q) and names of the arcs on which the modes (P, 3, K) go that
    swing by u (T, K).
    """
    body = heard.body
    loud = loudest(u.std(axis=0) * np.linalg.norm(shapes, axis=(0, 1)))
    pitch = body.modes.frequency[list(heard.match.modes)][loud]
    pairs, aside = aside_of(body, shapes[:, :, loud], pitch)
    products = np.stack([u[:, loud[j]] * u[:, loud[k]] for j, k in pairs], axis=1)
    labels = [
        f"arc of mode {loud[j] + 1}" + (f" with mode {loud[k] + 1}" if j != k else "")
        for j, k in pairs
    ]
    return aside, products, labels


def _spread(skin, fields: np.ndarray) -> np.ndarray:
    return (skin @ fields.reshape(-1, fields.shape[2])).reshape(-1, 3, fields.shape[2])


def _extra(heard: Heard, found: TimeFit, columns: list):
    """Fields (P, 3, q), weights (T, q) and names of what effects add with a shape of their own."""
    law, body = found.law, heard.body
    data = law.takes[law.fitted[0]]
    at = law.own * law.conditions + 1
    seen = body.seen(data)[: max(6, law.modes)]
    fields, weights, labels = [], [], []
    for effect, values in columns:
        width = values.shape[1]
        strength = found.coefficients[:, at : at + width]
        at += width
        if effect.layer == "camera":
            continue
        ridge = 1e-4 * np.trace(seen @ seen.T) / len(seen) * np.eye(len(seen))
        share = np.linalg.solve(seen @ seen.T + ridge, seen @ strength)
        fields.append(body.modes.shapes[:, :, : len(seen)] @ share)
        weights.append(values)
        labels += [f"{effect.name} {j + 1}" if width > 1 else effect.name for j in range(width)]
    if not fields:
        return None
    return np.concatenate(fields, axis=2), np.hstack(weights), labels
