"""A pinhole's bend: what comes nearer is seen larger, which is no overtone of the body."""

from dataclasses import dataclass

import numpy as np

from .body import Body
from .channels import Channels
from .data import replace
from .law import TimeFit

ALIKE = 0.05  # of the clearest shape: what the camera hardly sees apart is not told apart
ROUNDS = 3  # in which what is bent no longer counts as motion, and the bend tells depths
WIDER = 0.01  # relative, of a mode's motion, by which its bend is asked for
DOUBT = 0.5  # relative, that a mode may move more or less than its seen shape says


@dataclass(frozen=True, eq=False)
class Known:
    """What a fit says of a take."""

    motion: np.ndarray  # (T, K) of the modes
    shown: np.ndarray  # (K, C) their seen shapes
    left: np.ndarray  # (T, C) what it leaves


def known_of(found: TimeFit, take: int) -> Known:
    """What a fit says of its fitted take of that number."""
    index = found.law.fitted[take]
    left = found.law.takes[index].values - found.predicted[index]
    return Known(found.motions[take], found.shapes_of(take), left)


def straightened(
    data: Channels, body: Body, turn: np.ndarray, known: Known | None = None
) -> Channels:
    """The take as it would be seen if displacements moved pixels in proportion.

    How far the markers move in depth is read off the computed shapes (turn (m, K) from
    `match.align`) that show best what the channels show (Hartley and Zisserman, Multiple View
    Geometry, 2004, 6.1): frame by frame in all that they do, or, where the modes' motions are
    `known`, mode by mode and then in what these leave, for a mode that moves towards the camera is
    hardly seen in one frame and clearly in all. How much it moves, its bend says better than its
    seen shape does. Orthographic and 3-D takes are as they were.
    """
    camera = data.take.recording.camera
    if camera is None or camera.kind == "orthographic":
        return data
    places = np.array([m.position for m in data.take.recording.markers])
    shapes = body.modes.shapes @ turn
    moved = (body.markers @ shapes.reshape(-1, turn.shape[1])).reshape(len(places), 3, -1)
    moved[data.support[:: data.rest.size // len(places)]] = 0
    seen = np.einsum("ci,cik->ck", data.directions, moved[data.marker])
    away = np.nan_to_num(data.values - np.nanmean(data.values, axis=0))

    def bent(u: np.ndarray) -> np.ndarray:
        d = np.einsum("tk,nik->tni", u, moved)
        pixels = camera.project((places + d).reshape(-1, 3)).reshape(len(d), -1)
        return pixels - data.rest - np.einsum("ci,tci->tc", data.directions, d[:, data.marker])

    u, bend = 0.0, np.zeros_like(away)
    if known is not None:
        shown = np.where(data.support, 0.0, known.shown)
        own = np.einsum("kc,ck->k", shown, seen) / np.maximum((seen**2).sum(axis=0), 1e-300)
        # across the view it moves as it is seen to
        across = np.linalg.pinv(data.directions.reshape(len(places), -1, 3))
        off = (shown / np.where(own == 0, np.inf, own)[:, None]).T - seen
        moved = moved + np.einsum("nic,nck->nik", across, off.reshape(len(places), -1, len(own)))
        seen = seen + off
        u = known.motion * own * _sized(known.motion * own, bent, known.left, data)
        swung = (known.motion - known.motion.mean(axis=0)) @ shown
        away = np.where(np.isfinite(data.values), away - swung, 0.0)
    read = np.linalg.pinv(seen, rcond=ALIKE).T
    for _ in range(ROUNDS):
        bend = bent(u + (away - bend + bend.mean(axis=0)) @ read)
    return replace(data, values=data.values - bend)


def _sized(u: np.ndarray, bent, left: np.ndarray, data: Channels) -> np.ndarray:
    """(K,) by how much more each mode moves than u (T, K) says, for its bend to be most of what a
    fit `left`: least squares, each of them about one.
    """
    rows = data.fit & np.isfinite(left).all(axis=1)
    size = np.ones(u.shape[1])
    if not rows.any():
        return size

    def weighed(seen: np.ndarray) -> np.ndarray:
        return ((seen - seen.mean(axis=0)) / data.sigma).ravel()

    for _ in range(ROUNDS):
        now = bent(u[rows] * size)
        slopes = [
            weighed(bent(u[rows] * (size + WIDER * one)) - now) / WIDER for one in np.eye(len(size))
        ]
        J = np.array([*slopes]).T
        short = J.T @ weighed(left[rows] - now) + (1 - size) / DOUBT**2
        size = size + np.linalg.solve(J.T @ J + np.eye(len(size)) / DOUBT**2, short)
    return size
