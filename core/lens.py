"""A pinhole's bend: what comes nearer is seen larger, which is no overtone of the body."""

import numpy as np

from .body import Body
from .channels import Channels
from .data import replace

ROUNDS = 3  # in which what is bent no longer counts as motion
ALIKE = 0.05  # of the clearest shape: what the camera hardly sees apart is not told apart


def straightened(
    data: Channels, body: Body, turn: np.ndarray, known: tuple[np.ndarray, np.ndarray] | None = None
) -> Channels:
    """The take as it would be seen if displacements moved pixels in proportion.

    How far the markers move in depth is read off the computed shapes (turn (m, K) from
    `match.align`) that show best what the channels show (Hartley and Zisserman, Multiple View
    Geometry, 2004, 6.1): in all that they do where the modes' motions (T, K) and seen shapes (K, C)
    are not `known`, else in what these leave, for a mode that moves towards the camera is hardly
    seen in one frame and clearly in all. Orthographic and 3-D takes are as they were.
    """
    camera = data.take.recording.camera
    if camera is None or camera.kind == "orthographic":
        return data
    places = np.array([m.position for m in data.take.recording.markers])
    shapes = body.modes.shapes @ turn
    moved = (body.markers @ shapes.reshape(-1, turn.shape[1])).reshape(len(places), 3, -1)
    seen = np.einsum("ci,cik->ck", data.directions, moved[data.marker])
    seen[data.support] = 0
    away = np.nan_to_num(data.values - np.nanmean(data.values, axis=0))
    u = 0.0
    if known is not None:
        motion, shown = known
        shown = np.where(data.support, 0.0, shown)
        own = np.einsum("kc,ck->k", shown, seen) / np.maximum((seen**2).sum(axis=0), 1e-300)
        swung = (motion - motion.mean(axis=0)) @ shown
        u, away = motion * own, np.where(np.isfinite(data.values), away - swung, 0.0)
    read = np.linalg.pinv(seen, rcond=ALIKE).T
    still = data.support[:: data.rest.size // len(places)]
    bend = np.zeros_like(away)
    for _ in range(ROUNDS):
        d = np.einsum("tk,nik->tni", u + (away - bend + bend.mean(axis=0)) @ read, moved)
        d[:, still] = 0
        bent = camera.project((places + d).reshape(-1, 3)).reshape(len(d), -1) - data.rest
        bend = bent - np.einsum("ci,tci->tc", data.directions, d[:, data.marker])
    return replace(data, values=data.values - bend)
