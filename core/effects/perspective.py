"""Motion towards the camera is seen as scale: the camera is nearer than was declared.

Law         pixel = principal + (pixel - principal) / (1 - d/D), d the motion towards the camera
Tells       a second harmonic at once (no dynamics), patterned by the place in the picture
Looks like  asymmetric_stiffness, whose second harmonic is filtered by the mode
Source      Hartley and Zisserman, Multiple View Geometry (2004), 6.3: weak perspective's next term
"""

import numpy as np

from .base import Effect, Parameter

ALIKE = 0.5  # least cosine between the squares' pattern and a near camera's
NEAREST = 20.0  # amplitudes: no camera is nearer


def columns(theta, setting, time, u):
    """The squares and products of the modal motions, seen at once."""
    first, second = np.triu_indices(min(u.shape[2], 2))
    return u[:, :, first] * u[:, :, second] / setting.amplitude


def veto(found):
    """The squares must follow the places in the picture as a near camera makes them."""
    setting, shape = found.law.setting, found.column_shapes()[-1]
    if setting.towards is None:
        return ""
    seen, pattern = shape[:, 0], setting.towards
    power = np.linalg.norm(seen) * np.linalg.norm(pattern)
    if power == 0 or seen @ pattern < ALIKE * power:
        return "the squares have another pattern"
    near = report((), setting, shape)["distance"]
    return "" if near > NEAREST * setting.amplitude else "the camera would be inside the object"


def requires(setting, takes):
    """Only pixels can show it."""
    return "" if takes[0].values.size and takes[0].take.recording.camera else "the tracks are 3-D"


def report(theta, setting, shape):
    """m: how near the camera must be for the squares to be as strong as they are."""
    if setting.towards is None:
        return {"distance": np.nan}
    seen = shape[:, 0] / setting.amplitude  # per m2 of u_1
    slope = (setting.towards @ seen) / (setting.towards @ setting.towards)
    return {"distance": 1 / slope if slope > 0 else np.nan}


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
)
