"""What `look` of a pinhole camera is: a direction, or the place that is looked at.

The case format does not say which. A direction is meant unless the markers are seen where only a
camera that looks at the place would see them.
"""

from dataclasses import dataclass, replace

import numpy as np

from .camera_fields import make_camera
from .case_fields import shown
from .data import Camera, Marker, Take
from .errors import CaseError

NEARER = 0.1  # of how far off the markers are by the direction, for the place to be meant
OFF = 0.1  # of the picture's diagonal: no direction that is meant has them so far off, nor a place


@dataclass(frozen=True, eq=False)
class Reading:
    """The cameras that a table may mean; None where a marker would be behind it."""

    direction: Camera | None
    place: Camera | None
    refused: CaseError | None = None  # why it is not the direction

    @property
    def camera(self) -> Camera:
        """The one that is meant as far as the table tells."""
        return self.direction or self.place


def read_camera(fields: dict, where: str, markers: tuple[Marker, ...]) -> Reading:
    """The camera of checked `fields` by either reading.

    Raises CaseError as `make_camera` does, and where a marker is behind both.
    """
    own = fields["look"], fields["position"]
    place = None
    if fields["kind"] == "pinhole" and all(one is not None for one in own):
        place, _ = _tried(fields | {"look": own[0] - own[1]}, where, markers)
    direction, refused = _tried(fields, where, markers)
    if refused and place is None:
        raise refused
    return Reading(direction, place, refused)


def as_seen(reading: Reading, places: np.ndarray, values: np.ndarray) -> Camera:
    """The camera that has what is at the `places` (n, 3) m where it is seen, (T, n, 2) px.

    Raises CaseError where the direction was refused and the place is no help.
    """
    if reading.place is None:
        return reading.direction
    seen = np.nanmedian(values, axis=0)

    def off(camera):
        return float(np.median(np.linalg.norm(seen - camera.project(places), axis=1)))

    much, there = OFF * np.hypot(*reading.place.image_size), off(reading.place)
    if reading.direction is None:
        if there > much:
            raise reading.refused
        return reading.place
    here = off(reading.direction)
    return reading.place if there < NEARER * here and here > much else reading.direction


def with_camera(
    takes: tuple[Take, ...], reading: Reading, look: np.ndarray | None, where: str
) -> tuple[Take, ...]:
    """The takes in pixels by the camera that has the markers where the first of them shows them;
    with a warning where that is the one which looks at the place `look` (3,).

    Raises CaseError as `as_seen` does, and where none is in pixels and the direction was refused.
    """
    flat = [n for n, take in enumerate(takes) if take.recording.camera is not None]
    if not flat:
        if reading.refused:
            raise reading.refused
        return takes
    first = takes[flat[0]].recording
    camera = as_seen(reading, np.array([m.position for m in first.markers]), first.values)
    if camera is reading.direction:
        return takes
    told = (
        f"{where} look = {shown(look.tolist())} is taken for the place that is looked at: only so "
        "are the markers near where they are seen. Give the direction: the place less position."
    )
    out = list(takes)
    for n in flat:
        more = (told,) if n == flat[0] else ()
        recording = takes[n].recording
        recording = replace(recording, camera=camera, warnings=(*more, *recording.warnings))
        out[n] = replace(takes[n], recording=recording)
    return tuple(out)


def _tried(fields: dict, where: str, markers) -> tuple[Camera | None, CaseError | None]:
    """The camera of the `fields`, or why it is none: a marker is behind it, or no axes."""
    try:
        camera = make_camera(fields, where)
        for marker in markers if camera.kind == "pinhole" else ():
            depth = float(camera.rows[2] @ (marker.position - camera.position))
            if depth <= 0:
                raise CaseError(
                    f"{where}: the marker {marker.name} is {-depth:.3g} m behind it; it must be in "
                    "front. Turn look around, or check position."
                )
    except CaseError as error:
        return None, error
    return camera, None
