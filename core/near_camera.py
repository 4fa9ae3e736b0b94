"""What is heard once a camera that stands nearer than was declared is put where it stands."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .body import Body
from .data import Camera, Case
from .effects import perspective
from .joint import Heard
from .law import TimeFit
from .residual import NOISY, excess


def rest_places(heard: Heard, found: TimeFit) -> perspective.Nearness | None:
    """What a fit's rest places say of a camera that is near without doubt; None where they show
    none, or where another cause moves them.
    """
    if heard.body.case.shape == "unloaded" and heard.body.case.takes[0].gravity is not None:
        return None  # the weight moves them too
    return perspective.near(found)


def as_seen_nearby(heard: Heard, hear: Callable[[Body], Heard]) -> Heard | None:
    """The takes heard anew through a lens at the distance that their rest places show without
    doubt: motion towards it is seen too, and more of the body's modes with it.

    None where they show none, or where more is left so.
    """
    near = rest_places(heard, heard.declared)
    if near is None or perspective.EFFECT.name in heard.body.case.declared:
        return None
    again = hear(replace(heard.body, case=_through_a_lens(heard.body.case, 1 / near.slope)))
    quiet = again.declared.chi2 < NOISY * again.declared.samples
    better = quiet or excess(again.declared) < excess(heard.declared)
    return again if better and None not in again.match.modes else None


def _through_a_lens(case: Case, distance: float) -> Case:
    """The case with a lens that far (m) from the markers' middle."""
    recording = case.takes[0].recording
    middle = np.mean([m.position for m in recording.markers], axis=0)
    near = lens(recording.camera, middle, distance)
    takes = [replace(t, recording=replace(t.recording, camera=near)) for t in case.takes]
    return replace(case, takes=tuple(takes))


def lens(far: Camera, middle: np.ndarray, distance: float) -> Camera:
    """The pinhole camera `distance` (m) from `middle` (3,) m that sees the plane through it, square
    to the view, as the orthographic one does (Hartley and Zisserman, Multiple View Geometry, 2004,
    6.3). What it looks at is in the picture's middle, wherever the object's origin may be.
    """
    look, picture = far.rows[2], far.principal_point
    if all(far.image_size):
        picture = np.array(far.image_size) / 2
    aside = (picture - far.principal_point) / far.scale @ far.rows[:2]
    here = far.position + aside + look * (look @ (middle - far.position) - distance)
    return replace(
        far, kind="pinhole", position=here, scale=far.scale * distance, principal_point=picture
    )
