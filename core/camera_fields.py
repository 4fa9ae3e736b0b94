"""[camera] of case.toml -> Camera."""

import numpy as np

from .case_fields import Field, choice, integers, number, shown, vector
from .data import Camera
from .errors import CaseError

SQUARE = np.deg2rad(2.0)  # how far `right` and `down` may be from a right angle
PARALLEL = np.deg2rad(5.0)  # how near `down` may come to `look`

CAMERA_FIELDS = {
    "kind": Field(choice("orthographic", "pinhole"), required=True),
    "metres_per_pixel": Field(number(low=1e-9, high=10, unit="m")),
    "right": Field(vector(3)),
    "down": Field(vector(3), required=True),
    "position": Field(vector(3, unit="m")),
    "look": Field(vector(3)),
    "focal_px": Field(number(above=0, unit="px")),
    "principal_point": Field(vector(2, unit="px"), required=True),
    "image_size": Field(integers(size=2, low=1)),
    "readout": Field(number(low=0, high=1, unit="s")),
}
OWN = {
    "orthographic": ("metres_per_pixel", "right"),
    "pinhole": ("position", "look", "focal_px"),
}


def make_camera(fields: dict, where: str) -> Camera:
    """The camera of checked `fields`; its axes become exactly orthonormal.

    Orthographic: `right` and `down` are image axes, square within 2 degrees; it looks along
    right x down. Pinhole: `look` is the optical axis and `down` only says which way is down in the
    picture, so what it has along `look` is dropped.
    Raises CaseError for a field of the other kind, a missing one, and axes that span nothing.
    """
    kind = fields["kind"]
    for owner, names in OWN.items():
        for name in names:
            if owner == kind and fields[name] is None:
                raise CaseError(f"{where} lacks the field {name}; {kind} needs it. Add it.")
            if owner != kind and fields[name] is not None:
                raise CaseError(
                    f'{where} {name} belongs to kind = "{owner}", this is "{kind}". Take it out.'
                )
    if kind == "orthographic":
        rows = _orthographic_rows(fields, where)
        position, scale = np.zeros(3), 1 / fields["metres_per_pixel"]
    else:
        rows = _pinhole_rows(fields, where)
        position, scale = fields["position"], fields["focal_px"]
    size = fields["image_size"]
    if size is None:
        size = np.maximum(np.round(2 * fields["principal_point"]), 1)
    return Camera(
        kind,
        rows,
        position,
        scale,
        fields["principal_point"],
        (int(size[0]), int(size[1])),
        fields["readout"],
    )


def _orthographic_rows(fields: dict, where: str) -> np.ndarray:
    right, down = (_unit(fields[name], f"{where} {name}") for name in ("right", "down"))
    lean = np.arcsin(np.clip(right @ down, -1, 1))
    if abs(lean) > SQUARE:
        raise CaseError(
            f"{where} right and down meet at {90 - np.rad2deg(lean):.1f} degrees; 90 within "
            f"{np.rad2deg(SQUARE):g} are needed. Give the image's x and y axes in object axes."
        )
    down = _unit(down - (down @ right) * right, where)
    return np.stack([right, down, np.cross(right, down)])


def _pinhole_rows(fields: dict, where: str) -> np.ndarray:
    look, down = (_unit(fields[name], f"{where} {name}") for name in ("look", "down"))
    across = down - (down @ look) * look
    if np.linalg.norm(across) < np.sin(PARALLEL):
        raise CaseError(
            f"{where} down = {shown(fields['down'].tolist())} points along look; the direction that"
            " is down in the picture is needed, across look. Correct it."
        )
    down = _unit(across, where)
    return np.stack([np.cross(down, look), down, look])


def _unit(x: np.ndarray, where: str) -> np.ndarray:
    length = np.linalg.norm(x)
    if length == 0:
        raise CaseError(f"{where} = [0, 0, 0]; a direction is needed. Correct it.")
    return x / length
