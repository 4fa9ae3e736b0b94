"""What `look` of a pinhole camera is: a direction, or the place that is looked at.

The case format does not say which. A direction is meant unless the markers are seen where only a
camera that looks at the place would see them.
"""

from dataclasses import replace

import numpy as np

from .camera_fields import make_camera
from .case_fields import shown
from .data import Camera, Marker, Recording, Take
from .errors import CaseError

NEARER = 0.1  # of how far off the markers are by the direction, for the place to be meant


def cameras(fields: dict, where: str, markers: tuple[Marker, ...]) -> list[Camera]:
    """The cameras that the checked `fields` may mean, all with the markers in front.

    Raises CaseError as `make_camera` does, and where a marker is behind every one.
    """
    readings = [fields]
    own = fields["look"], fields["position"]
    if fields["kind"] == "pinhole" and all(one is not None for one in own):
        readings.append(fields | {"look": own[0] - own[1]})
    out, refused = [], []
    for one in readings:
        try:
            out.append(_in_front(one, where, markers))
        except CaseError as error:
            refused.append(error)
    if not out:
        raise refused[0]
    return out


def as_seen(
    takes: tuple[Take, ...], possible: list[Camera], fields: dict, where: str
) -> tuple[Take, ...]:
    """The takes by the camera among the `possible` ones that has the markers where they are seen;
    with a warning where that is the one which looks at a place.

    Raises CaseError where no camera has them in the picture, as `cameras` does.
    """
    first = takes[0].recording
    if first.camera is None or first.camera.kind != "pinhole":
        return takes
    off = [_misplaced(camera, first) for camera in possible]
    camera = possible[-1] if off[-1] < NEARER * off[0] else possible[0]
    look = fields["look"] / np.linalg.norm(fields["look"])
    if camera.rows[2] @ look > 1 - 1e-9:
        return takes
    if off[-1] > np.hypot(*camera.image_size):
        _in_front(fields, where, first.markers)
    told = (
        f"{where} look = {shown(fields['look'].tolist())} is taken for the place that is looked "
        "at: by a direction the markers would not be where they are seen. Give the direction: the "
        "place less position."
    )
    return tuple(replace(take, recording=_by(camera, take.recording, told)) for take in takes)


def _by(camera: Camera, recording: Recording, told: str) -> Recording:
    return replace(recording, camera=camera, warnings=(told, *recording.warnings))


def _misplaced(camera: Camera, recording: Recording) -> float:
    """px from where a camera has the markers to where they are seen, the median."""
    places = camera.project(np.array([marker.position for marker in recording.markers]))
    return float(np.median(np.linalg.norm(np.nanmedian(recording.values, axis=0) - places, axis=1)))


def _in_front(fields: dict, where: str, markers: tuple[Marker, ...]) -> Camera:
    """The camera of the `fields`. Raises CaseError where a marker is behind it."""
    camera = make_camera(fields, where)
    for marker in markers if camera.kind == "pinhole" else ():
        depth = float(camera.rows[2] @ (marker.position - camera.position))
        if depth <= 0:
            raise CaseError(
                f"{where}: the marker {marker.name} is {-depth:.3g} m behind it; it must be in "
                "front. Turn look around, or check position."
            )
    return camera
