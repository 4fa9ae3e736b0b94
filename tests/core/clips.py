"""Films of a known texture moved in a known way, written by another road than they are read."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np

SIZE = (160, 120)
CENTRE = np.array([80.0, 60.0])
POINTS = np.array([[80, 60], [50.3, 40.7], [110.5, 80.25], [60.9, 75.1], [100, 45]])


@dataclass(frozen=True)
class Texture:
    """A sum of plane waves: its value anywhere is exact, so that nothing is interpolated."""

    seed: int = 0
    waves: int = 40
    shortest: float = 7.0  # px

    def __call__(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        rng = np.random.default_rng(self.seed)
        k = rng.uniform(0.05, 2 * np.pi / self.shortest, self.waves)
        angle, phase = rng.uniform(0, 2 * np.pi, (2, self.waves))
        grey = np.full(np.shape(x), 128.0)
        for wave in range(self.waves):
            along = np.cos(angle[wave]) * x + np.sin(angle[wave]) * y
            grey += 55 / np.sqrt(self.waves) * np.cos(k[wave] * along + phase[wave])
        return grey


@dataclass(frozen=True)
class Swing:
    """Turn, stretch and shift about the picture's centre, at rest in frame 0."""

    rate: float = 0.5  # rad a frame of the first shift
    shift: float = 6.0  # px
    turn: float = 0.1  # rad
    stretch: float = 0.05
    decay: float = 0.0  # 1 a frame

    def at(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        fade = np.exp(-self.decay * t)
        a, s = self.turn * np.sin(0.74 * self.rate * t), 1 + self.stretch * np.sin(0.46 * t)
        A = s * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
        b = np.array([np.sin(self.rate * t), 0.5 * np.sin(0.62 * self.rate * t)])
        return A, fade * self.shift * b

    def places(self, points: np.ndarray, times) -> np.ndarray:
        """(T, n, 2) px where `points` (n, 2) of frame 0 are."""
        moves = [self.at(t) for t in times]
        return np.array([(points - CENTRE) @ A.T + CENTRE + b for A, b in moves])

    def picture(self, texture, t: float) -> np.ndarray:
        """The texture as moved until frame `t` (which need not be whole)."""
        A, b = self.at(t)
        y, x = np.mgrid[: SIZE[1], : SIZE[0]].astype(float)
        back = np.linalg.inv(A)
        u, v = x - CENTRE[0] - b[0], y - CENTRE[1] - b[1]
        return texture(
            back[0, 0] * u + back[0, 1] * v + CENTRE[0], back[1, 0] * u + back[1, 1] * v + CENTRE[1]
        )


def film(swing: Swing, times, *, noise: float = 0.0, blur: float = 0.0, seed: int = 0) -> list:
    """Pictures (height, width) uint8 at the instants `times`, in frames."""
    rng = np.random.default_rng(seed)
    pictures = []
    for grey in _pure(swing, tuple(map(float, times))):
        seen = cv2.GaussianBlur(grey, (0, 0), blur) if blur else grey
        seen = seen + noise * rng.standard_normal(grey.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


@cache
def _pure(swing: Swing, times: tuple) -> list:
    return [swing.picture(Texture(), t) for t in times]


def store(folder: Path, pictures: list, codec: str = "", fps: float = 30.0) -> Path:
    """Write them as a folder of png (no codec), or as a video with the four letters `codec`."""
    if not codec:
        folder = folder / "pictures"
        folder.mkdir()
        for k, picture in enumerate(pictures):
            cv2.imwrite(str(folder / f"f_{k:04d}.png"), picture)
        return folder
    path = folder / ("clip.avi" if codec == "MJPG" else "clip.mp4")
    size = pictures[0].shape[::-1]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), fps, size, False)
    assert writer.isOpened()
    for picture in pictures:
        writer.write(picture)
    writer.release()
    return path
