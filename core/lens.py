"""A pinhole's bend: what comes nearer is seen larger, which is no overtone of the body."""

from dataclasses import dataclass

import numpy as np

from .body import Body
from .channels import Channels
from .data import replace
from .law import TimeFit

ALIKE = 0.05  # of the clearest shape: what the camera hardly sees apart is not told apart
ROUNDS = 3  # in which what is bent no longer counts as motion, and the bend tells depths
WIDER = 0.01  # relative, of a mode's motion towards the lens, by which its bend is asked for
DOUBT = 0.5  # relative, that a mode may move further towards it than its seen shape says
MOST = 4.0  # times that, at most


@dataclass(frozen=True, eq=False)
class Fitted:
    """What a fit says of a take."""

    motion: np.ndarray  # (T, K) of the modes
    shown: np.ndarray  # (K, C) their seen shapes
    left: np.ndarray  # (T, C) what it leaves


def fitted(found: TimeFit, take: int, data: Channels) -> Fitted:
    """What a fit says of its fitted take of that number, which was seen as `data`."""
    left = data.values - found.predicted[found.law.fitted[take]]
    return Fitted(found.motions[take], found.shapes_of(take), left)


def straightened(
    data: Channels, body: Body, turn: np.ndarray, known: Fitted | None = None
) -> Channels:
    """The take as it would be seen if displacements moved pixels in proportion.

    How far the markers move in depth is read off the computed shapes (turn (m, K) from
    `match.align`) that show best what the channels show (Hartley and Zisserman, Multiple View
    Geometry, 2004, 6.1): frame by frame in all that they do, or, where the modes' motions are
    `known`, mode by mode and then in what these leave, for a mode that moves towards the camera is
    hardly seen in one frame and clearly in all. How far it moves there, its bend says better than
    its seen shape does. Orthographic and 3-D takes are as they were.
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

    def bent(d: np.ndarray) -> np.ndarray:
        pixels = camera.project((places + d).reshape(-1, 3)).reshape(len(d), -1)
        return pixels - data.rest - np.einsum("ci,tci->tc", data.directions, d[:, data.marker])

    told = 0.0
    if known is not None:
        told = _displacement(data, moved, seen, known, bent)
        swung = (known.motion - known.motion.mean(axis=0)) @ np.where(data.support, 0, known.shown)
        away = np.where(np.isfinite(data.values), away - swung, 0.0)
    read, bend = np.linalg.pinv(seen, rcond=ALIKE).T, np.zeros_like(away)
    for _ in range(ROUNDS):
        u = (away - bend + bend.mean(axis=0)) @ read
        bend = bent(told + np.einsum("tk,nik->tni", u, moved))
    return replace(data, values=data.values - bend)


def _displacement(data: Channels, moved, seen, known: Fitted, bent) -> np.ndarray:
    """(T, n, 3) m of the markers: across the view as the modes are seen to move, towards the lens
    as their computed shapes `moved` (n, 3, K), `seen` (C, K), do.
    """
    shown = np.where(data.support, 0.0, known.shown)
    each = data.directions.reshape(len(moved), 2, 3)
    own = np.einsum("kc,ck->k", shown, seen) / np.maximum((seen**2).sum(axis=0), 1e-300)
    across = np.linalg.pinv(each) @ shown.T.reshape(len(moved), 2, -1)
    ray = np.cross(each[:, 0], each[:, 1])
    ray = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    towards = own * np.einsum("ni,nik->nk", ray, moved)[:, None] * ray[:, :, None]

    def at(size: np.ndarray, rows=slice(None)) -> np.ndarray:
        return np.einsum("tk,nik->tni", known.motion[rows], across + size * towards)

    rows = data.fit & np.isfinite(known.left).all(axis=1)
    return at(_sizes(lambda size: bent(at(size, rows)), known.left[rows], shown, data.sigma))


def _sizes(bent, left: np.ndarray, shown: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """(K,) by how much further each mode moves towards the lens for its bend to be most of what a
    fit `left` (T, C): least squares, each of them about one.

    What goes in the modes' own shapes (K, C) tells nothing: so does what acts on the body.
    """
    size = np.ones(len(shown))
    if not left.size:
        return size
    q, _ = np.linalg.qr((shown / sigma).T)

    def strange(seen: np.ndarray) -> np.ndarray:
        seen = (seen - seen.mean(axis=0)) / sigma
        return (seen - (seen @ q) @ q.T).ravel()

    for _ in range(ROUNDS):
        now = bent(size)
        J = np.array([strange(bent(size + WIDER * one) - now) / WIDER for one in np.eye(len(size))])
        short = J @ strange(left - now) + (1 - size) / DOUBT**2
        step = np.linalg.solve(J @ J.T + np.eye(len(size)) / DOUBT**2, short)
        size = np.clip(size + step, 0.0, MOST)
    return size
