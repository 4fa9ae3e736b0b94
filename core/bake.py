"""From a motion to what an animation program plays: keys on curves, or a cache of points."""

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from threadpoolctl import threadpool_limits

from .data import Motion, poles, seal
from .errors import DataError

FAITHFUL = 5e-5  # of the motion: what all curves together may leave of it, between keys too
BLOCK, TILE = 24, 1 << 13  # frames, and numbers of each, that are worked out in a core's cache
ROOM = 1 << 23  # numbers, most that a block of frames may hold


@dataclass(frozen=True, eq=False)
class Keys:
    """Keys of one curve per shape: between two keys runs the cubic that has these slopes."""

    frame: np.ndarray  # (n,) frames, ascending
    value: np.ndarray  # (n, k)
    slope: np.ndarray  # (n, k) per frame

    def __post_init__(self):
        seal(self, "frame", float, (None,))
        seal(self, "value", float, (len(self.frame), None))
        seal(self, "slope", float, self.value.shape)


def sample(motion: Motion, time: np.ndarray) -> np.ndarray:
    """Weights (n, k) at the instants `time` (n,) s; held still before the first and past the end.

    A cubic spline through the motion's own samples: its error falls as their step to the fourth.
    """
    return _spline(motion)(np.clip(time, motion.time[0], motion.time[-1]))


def keys(motion: Motion, fps: float, *, first: float = 1.0, last: float | None = None) -> Keys:
    """Keys that follow `motion`, the release at frame `first`, one a frame where that suffices.

    Where a frame is too long for the wobble, each is cut in halves until the curve is within
    FAITHFUL of the motion at all times, so that motion blur and other frame rates see the truth.
    `last` is the last frame, the motion's end when None. Raises DataError for a rate that is not
    positive or a range without a frame.
    """
    if not fps > 0:
        raise DataError(f"keys: {fps} frames/s; more than 0 is needed.")
    end = float(np.ceil((motion.time[-1] - motion.time[0]) * fps)) if last is None else last - first
    if not end >= 1:
        raise DataError(f"keys: frames {first:g} to {first + end:g} hold no motion. End later.")
    curve = _spline(motion)
    peak = np.maximum(np.abs(motion.weights).max(axis=0), np.finfo(float).tiny)
    probe = np.linspace(0, end, 2 * max(len(motion.time), int(end)) + 1)
    truth = sample(motion, motion.time[0] + probe / fps)
    finest = 1 / np.median(np.diff(motion.time))  # keys a second that the motion can fill
    cuts = 1
    while True:
        frame = np.linspace(0, end, int(np.ceil(end * cuts)) + 1)
        found = _hermite(motion, curve, frame / fps)
        off = np.abs(CubicHermiteSpline(frame / fps, *found)(probe / fps) - truth).max(axis=0)
        if (off <= FAITHFUL / len(peak) * peak).all() or cuts * fps >= finest:
            return Keys(first + frame, found[0], found[1] / fps)
        cuts *= 2


def strongest(motion: Motion, count: int | None = None, amplitude: float = 1.0) -> Motion:
    """The `count` shapes that move most (all when None), times `amplitude`, weights of peak 1.

    A key of value 1 is then the largest displacement that this shape reaches.
    Raises DataError when nothing moves.
    """
    peak = np.abs(motion.weights).max(axis=0)
    reach = peak * np.sqrt((motion.shapes**2).sum(axis=1)).max(axis=0)
    order = np.argsort(-reach, kind="stable")
    order = order[reach[order] > 1e-6 * reach.max()][:count]
    if not len(order):
        raise DataError("Bake: no shape moves. Calibrate first, or ask for at least one mode.")
    return Motion(
        tuple(motion.names[i] for i in order),
        motion.shapes[:, :, order] * (amplitude * peak[order]),
        motion.time,
        motion.weights[:, order] / peak[order],
    )


def carried(motion: Motion, rows: np.ndarray, share: np.ndarray, linear: np.ndarray) -> Motion:
    """The same motion at other points: point i moves as `share` (n, 3) of vertices `rows` (n, 3).

    `linear` (3, 3) then turns every displacement from metres into the points' own axes and unit.
    """
    shapes = np.einsum("nc,ncdk->ndk", share, motion.shapes[rows])
    return replace(motion, shapes=np.einsum("ed,ndk->nek", linear, shapes))


def plucked(
    motion: Motion,
    frequency: np.ndarray,
    damping_ratio: np.ndarray,
    pull: tuple[int, np.ndarray],
    *,
    modal_mass: np.ndarray | float = 1.0,
) -> Motion:
    """The body let go from a pull: `pull` = (vertex, displacement (3,) m of that vertex).

    A force at the vertex along the displacement bends each shape by its flexibility,
    q_k = phi_k(v).d / (m_k (2 pi f_k)^2), scaled so that the vertex is displaced by |d| along d;
    each then rings with its own frequency (k,) Hz and damping ratio (k,), from rest. `modal_mass`
    (k,) m_k = x^T M x in any unit; shapes with a frequency of NaN stay still.
    Raises DataError when no shape moves that vertex that way.
    """
    vertex, displacement = pull[0], np.asarray(pull[1], float)
    length = np.linalg.norm(displacement)
    if not (0 <= vertex < len(motion.shapes) and length > 0):
        raise DataError(f"Pluck: vertex {vertex} pulled by {length:g} m. Pick a vertex and a pull.")
    rings = np.isfinite(frequency) & (frequency > 0)
    direction = displacement / length
    seen = np.where(rings, direction @ motion.shapes[vertex], 0)
    stiffness = modal_mass * (2 * np.pi * frequency) ** 2
    q = np.divide(seen, stiffness, where=rings, out=np.zeros(len(seen)))
    if not q @ seen > 0:
        raise DataError(f"Pluck: no mode moves vertex {vertex} that way. Pick one off the pins.")
    q *= length / (q @ seen)
    fastest = frequency[rings & (np.abs(q) > 0)].max()
    step = 1 / (64 * fastest)
    time = np.arange(0, motion.time[-1] - motion.time[0] + step, step)
    weights = np.zeros((len(time), len(q)))
    p = poles(frequency[rings], damping_ratio[rings])
    # from rest: Re(a exp(pt)) with a = 1 + i Re p / Im p has value 1 and slope 0 at t = 0
    weights[:, rings] = q[rings] * ((1 + 1j * p.real / p.imag) * np.exp(np.outer(time, p))).real
    return replace(motion, time=time, weights=weights)


def write_pc2(path: Path, rest: np.ndarray, motion: Motion, frames: tuple) -> None:
    """Positions `rest` (V, 3) + motion as a PC2 cache, in the unit of `rest` and the shapes.

    `frames` = (count, fps): sample i is i / fps seconds after the release. Written beside and
    moved into place, so that a file is whole or absent. Raises OSError when it cannot be written.
    """
    count, fps = frames
    weights = sample(motion, motion.time[0] + np.arange(count) / fps)
    weights = np.append(weights, np.ones((count, 1)), axis=1).astype(np.float32)
    parts = motion.shapes.reshape(-1, len(motion.names)).T
    parts = np.append(parts, rest.reshape(1, -1), axis=0).astype(np.float32)  # rest, once always
    head = np.zeros(1, PC2_HEAD)
    head[0] = (b"POINTCACHE2", 1, len(rest), 0.0, 1.0, count)
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb", buffering=0) as file, threadpool_limits(1, user_api="blas"):
            _reserve(file, head.nbytes + 4 * count * parts.shape[1])
            _write_all(file, head)
            for block in _blocks(weights, parts):
                _write_all(file, block)
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _reserve(file, size: int) -> None:
    """Room on the disk at once: growing a file piece by piece costs as much as filling it."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, size)
    else:
        file.truncate(size)


def _blocks(weights: np.ndarray, parts: np.ndarray) -> Iterator[np.ndarray]:
    """weights (count, k) @ parts (k, size) in blocks of rows: the next is worked out meanwhile."""
    (count, size), rows = (len(weights), parts.shape[1]), max(1, min(BLOCK, ROOM // parts.shape[1]))
    rooms = np.empty((2, rows, size), np.float32)
    starts = range(0, count, rows)
    with ThreadPoolExecutor(1) as pool:
        ahead = pool.submit(_fill, weights[:rows], parts, rooms[0])
        for k, first in enumerate(starts):
            block = ahead.result()
            following = weights[first + rows : first + 2 * rows]
            ahead = pool.submit(_fill, following, parts, rooms[(k + 1) % 2])
            yield block


def _fill(weights: np.ndarray, parts: np.ndarray, room: np.ndarray) -> np.ndarray:
    """weights @ parts in `room`, a piece after another that stays in the cache."""
    room = room[: len(weights)]
    for begin in range(0, parts.shape[1], TILE):
        piece = slice(begin, begin + TILE)
        np.matmul(weights, parts[:, piece], out=room[:, piece])
    return room


def _write_all(file, block: np.ndarray) -> None:
    """An unbuffered file may take less than it is given."""
    left = memoryview(block.view(np.uint8)).cast("B")
    while left:
        left = left[file.write(left) :]


PC2_HEAD = np.dtype(
    [
        ("signature", "S12"),
        ("version", "<i4"),
        ("points", "<i4"),
        ("start", "<f4"),
        ("rate", "<f4"),
        ("samples", "<i4"),
    ]
)


def save_motion(path: Path, motion: Motion, **more: np.ndarray) -> None:
    """A motion as .npz: names, shapes, time, weights, and whatever arrays go along."""
    fields = {name: getattr(motion, name) for name in ("shapes", "time", "weights")}
    np.savez(path, names=np.array(motion.names, dtype=str), **fields, **more)


def load_motion(path: Path) -> tuple[Motion, dict]:
    """What `save_motion` wrote: the motion, and the other arrays by name.

    Raises DataError when the file is not there or not one of ours.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        names = tuple(str(name) for name in arrays.pop("names"))
        return Motion(names, *(arrays.pop(n) for n in ("shapes", "time", "weights"))), arrays
    except (OSError, KeyError, ValueError) as error:
        raise DataError(f"Motion {path}: not readable ({error}). Calibrate again.") from error


def _spline(motion: Motion) -> CubicSpline:
    if len(motion.time) < 4:
        raise DataError(f"Motion: {len(motion.time)} samples in time; 4 are needed.")
    return CubicSpline(motion.time, motion.weights)


def _hermite(motion: Motion, curve: CubicSpline, time: np.ndarray) -> tuple:
    """Values and slopes (per second) at `time` after the release; still past the end."""
    at = motion.time[0] + time
    inside = np.clip(at, motion.time[0], motion.time[-1])
    slope = np.where((at <= motion.time[-1])[:, None], curve(inside, 1), 0)
    return curve(inside), slope
