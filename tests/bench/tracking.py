"""Frames per second of the tracker beside a plain OpenCV call, 20 points, 1280 x 720, noisy.

Run: python tests/bench/tracking.py [frames]. Both read the same mp4, decoding included, and both
are held against the places where the points truly are.
"""

import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from core.track import track

SIZE, POINTS, NOISE = (1280, 720), 20, 2.0


def shift_of(k: int) -> np.ndarray:
    """(2,) px in frame k."""
    return np.array([6 * np.sin(0.2 * k), 4 * (np.cos(0.13 * k) - 1)])


def make_clip(path: Path, frames: int) -> None:
    rng = np.random.default_rng(0)
    big = cv2.GaussianBlur(rng.uniform(0, 255, (760 * 4, 1320 * 4)).astype(np.float32), (0, 0), 8)
    big = np.clip(128 + (big - big.mean()) / big.std() * 45, 0, 255)
    grain = [NOISE * rng.standard_normal(SIZE[::-1]).astype(np.float32) for _ in range(8)]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 60, SIZE, False)
    for k in range(frames):
        dx, dy = shift_of(k)
        move = np.float32([[4, 0, 80 - 4 * dx], [0, 4, 80 - 4 * dy]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        picture = cv2.warpAffine(big, move, SIZE, flags=flags) + grain[k % 8]
        writer.write(np.clip(np.round(picture), 0, 255).astype(np.uint8))
    writer.release()


def plain(path: Path, points: np.ndarray) -> np.ndarray:
    """Lucas-Kanade against the first frame and nothing else (T, n, 2)."""
    capture = cv2.VideoCapture(str(path))
    first = last = begin = None
    found = []
    while True:
        good, picture = capture.read()
        if not good:
            return np.array(found)
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        if first is None:
            first, begin = grey, points.astype(np.float32).reshape(-1, 1, 2)
            last = begin.copy()
        last, _, _ = cv2.calcOpticalFlowPyrLK(first, grey, begin, last, winSize=(31, 31), flags=4)
        found.append(last[:, 0].copy())


def with_ecc(path: Path, points: np.ndarray) -> np.ndarray:
    """The same with OpenCV's affine ECC refinement of every point (T, n, 2)."""
    capture = cv2.VideoCapture(str(path))
    coarse = plain(path, points)
    centre = np.round(points).astype(int)
    first, found = None, []
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1e-3)
    for places in coarse:
        grey = cv2.cvtColor(capture.read()[1], cv2.COLOR_BGR2GRAY)
        first = grey if first is None else first
        row = []
        for (u, v), (x, y) in zip(centre, places, strict=True):
            low = np.array([u - 31, v - 31])
            move = np.float32([[1, 0, x - 15 - low[0]], [0, 1, y - 15 - low[1]]])
            window = first[v - 15 : v + 16, u - 15 : u + 16]
            area = grey[low[1] : low[1] + 63, low[0] : low[0] + 63]
            with suppress(cv2.error):
                _, move = cv2.findTransformECC(window, area, move, cv2.MOTION_AFFINE, stop)
            row.append(move @ [15, 15, 1] + low)
        found.append(row)
    return np.array(found)


def main(frames: int) -> None:
    rng = np.random.default_rng(1)
    points = np.stack([rng.integers(60, SIZE[0] - 60, POINTS), rng.integers(60, 660, POINTS)], 1)
    points = points.astype(float)
    truth = points + np.array([shift_of(k) for k in range(frames)])[:, None]
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.mp4"
        make_clip(clip, frames)
        rows = (
            ("Lucas-Kanade, window 31", lambda: plain(clip, points)),
            ("the same and ECC affine", lambda: with_ecc(clip, points)),
            ("this tracker", lambda: track(clip, points, capture_fps=60).values),
        )
        rates = []
        print(f"{frames} frames of {SIZE[0]} x {SIZE[1]}, {POINTS} points, decoding included")
        for name, call in rows:
            begin, spent = time.perf_counter(), time.process_time()
            values = call()
            spent = 1e3 * (time.process_time() - spent) / frames
            rates.append(frames / (time.perf_counter() - begin))
            error = np.sqrt(np.nanmean((values - truth[: len(values)]) ** 2))
            says = f"{rates[-1]:7.0f} frames/s  {spent:5.1f} ms CPU each  {error:.4f} px RMS"
            print(f"{name:26s} {says}")
        print(f"ratio to Lucas-Kanade alone {rates[-1] / rates[0]:.2f}")
        print(f"ratio to it with ECC        {rates[-1] / rates[1]:.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
