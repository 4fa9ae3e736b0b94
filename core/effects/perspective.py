"""What comes towards the camera is seen larger: the camera is nearer than was declared.

Law         pixel = middle + (pixel - middle) / (1 - d/D), middle that of the picture, d the motion
            towards the camera; D is told of the object's middle
Tells       the rest places: what is nearer is further from the picture's middle, each marker
            by its depth; and a second harmonic at once (no dynamics) with the same pattern
Enters      as a pinhole camera at that distance, where the rest places tell it (`near_camera`)
Looks like  asymmetric_stiffness, whose second harmonic is filtered by the mode
Source      Hartley and Zisserman, Multiple View Geometry (2004), 6.3: weak perspective's next term
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import f as f_law

from ..dac import SURE
from .base import Effect, Parameter

POSE = 6  # numbers of an orthographic camera that is put a little wrong
FREE = 3  # least coordinates beyond those and the distance
CHANCE = 1e-4  # that misplaced markers look like a near camera
MOST = 0.8  # share of the markers' misplacement that a near camera must take
CLOSEST = 3.0  # times the depth's spread that the camera is away at least
DOUBTFUL = 4.0  # standard deviations
ALIKE = 0.5  # least cosine between the squares' pattern and a near camera's
FAINT = 0.3  # of the slope that the squares say, below which the rest places deny it
NEAREST = 20.0  # amplitudes: no camera is nearer


@dataclass(frozen=True)
class Nearness:
    """What the rest places say of the camera's distance."""

    slope: float  # 1/m, one over the distance of the markers' middle
    sigma: float  # 1/m
    certain: bool  # that it is near


def nearness(data, offset: np.ndarray) -> Nearness | None:
    """One over the camera's distance from where the markers rest; None where they cannot tell.

    offset (C,) px: where each channel rests. A shift, a scale and a turn of the declared camera
    are fitted along, so only what follows the depth counts.
    """
    camera = data.take.recording.camera
    if camera is None or camera.kind != "orthographic":
        return None
    places = np.array([m.position for m in data.take.recording.markers])
    z = places @ camera.rows[2]
    z = z - z.mean()
    p = data.rest.reshape(-1, 2)
    p = p - p.mean(axis=0)
    y = (offset - data.rest).reshape(-1, 2) + p
    free = 2 * len(z) - POSE - 1
    if free < FREE or not np.isfinite(y).all() or np.ptp(z) < 1e-3 * np.ptp(places, axis=0).max():
        return None

    def left(slope: float) -> np.ndarray:
        q = p / (1 + slope * z)[:, None]
        one, none = np.ones_like(z), np.zeros_like(z)
        u = np.stack([q[:, 0], -q[:, 1], one, none, z, none], axis=1)
        v = np.stack([q[:, 1], q[:, 0], none, one, none, z], axis=1)
        A = np.vstack([u, v])
        both = y.T.ravel()
        return both - A @ np.linalg.lstsq(A, both, rcond=None)[0]

    far = 1 / (CLOSEST * np.ptp(z))
    best = minimize_scalar(
        lambda s: (left(s) ** 2).sum(), bounds=(-far, far), method="bounded",
        options={"xatol": 1e-6 * far},
    ).x  # fmt: skip
    rest, before = (left(best) ** 2).sum(), (left(0.0) ** 2).sum()
    step = 1e-4 * far
    change = (left(best + step) - left(best - step)) / (2 * step)
    noise = np.mean(data.sigma**2) / data.fit.sum()
    power = max((change**2).sum(), 1e-300)
    sigma = np.sqrt(max(rest / free, noise) / power)
    gain = before - rest
    certain = (
        best > DOUBTFUL * sigma
        and gain > MOST * before
        and f_law.sf(gain / max(rest / free, noise), 1, free) < CHANCE
    )
    return Nearness(float(best), float(sigma), bool(certain))


def columns(theta, setting, time, u):
    """The squares and products of the modal motions, seen at once."""
    first, second = np.triu_indices(min(u.shape[2], 2))
    return u[:, :, first] * u[:, :, second] / setting.amplitude


def _told(found) -> Nearness | None:
    law = found.law
    return nearness(law.takes[law.fitted[0]], found.rest())


def near(found) -> Nearness | None:
    """What a fit's rest places say, where they show without doubt that the camera is near."""
    told = _told(found)
    return told if told is not None and told.certain else None


def instead(found):
    """What an effect must do better than where the camera is near: it makes overtones by itself."""
    told = any(effect.name == EFFECT.name for effect in found.law.effects)
    return EFFECT if not told and near(found) else None


def veto(found):
    """The squares must follow the places in the picture as a near camera makes them."""
    setting, shape = found.law.setting, found.column_shapes()[-1]
    told = _told(found)
    if setting.towards is None or (told is not None and told.certain):
        return ""
    seen, pattern = shape[:, 0], setting.towards
    power = np.linalg.norm(seen) * np.linalg.norm(pattern)
    if power == 0 or seen @ pattern < ALIKE * power:
        return "the squares have another pattern"
    distance = report((), setting, shape)["distance"]
    if told is not None and told.slope + DOUBTFUL * told.sigma < FAINT / distance:
        return "the rest places show no near camera"
    return "" if distance > NEAREST * setting.amplitude else "the camera would be inside the object"


def requires(setting, takes):
    """Only pixels can show it, of a camera that was declared to be far away."""
    camera = takes[0].take.recording.camera
    return "" if camera and camera.kind == "orthographic" else "the camera's place is known"


def report(theta, setting, shape):
    """m: as the rest places show it, or as near as the squares of the motion need it."""
    if setting.near:
        return {"distance": 1 / setting.near.slope + setting.behind}
    if setting.towards is None:
        return {"distance": np.nan}
    seen = shape[:, 0] / setting.amplitude  # per m2 of u_1
    need = (setting.towards @ seen) / (setting.towards @ setting.towards)
    return {"distance": 1 / need + setting.behind if need > 0 else np.nan}


def alike(theta, setting, shape):
    """The rest places leave the distance open by their own error."""
    if not setting.near:
        return []
    ends = setting.near.slope + SURE * setting.near.sigma * np.array([-1.0, 1.0])
    return [{"distance": 1 / end + setting.behind} for end in ends]


EFFECT = Effect(
    name="perspective",
    layer="camera",
    parameters=(Parameter("distance", "m", 1e-3, 1e3),),
    twins=("asymmetric_stiffness",),
    settle="film from twice the distance with the lens zoomed in",
    starts=lambda setting, residual: [()],
    columns=columns,
    requires=requires,
    veto=veto,
    report=report,
    alike=alike,
)
