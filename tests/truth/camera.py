"""The camera that really filmed, and what the case says about it."""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True, eq=False)
class Camera:
    """Pixels u right, v down. `distance` None = orthographic, else a pinhole that far away."""

    right: np.ndarray  # (3,) unit
    down: np.ndarray  # (3,) unit
    centre: np.ndarray  # (3,) m, the place in the middle of the picture
    metres_per_pixel: float  # at the centre
    size: tuple[int, int] = (1280, 720)  # px
    distance: float | None = None  # m, from the centre
    readout: float = 0.0  # s, first to last row

    @property
    def look(self) -> np.ndarray:
        return np.cross(self.right, self.down)

    @property
    def middle(self) -> np.ndarray:
        return np.array(self.size) / 2

    def see(self, x: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of places (..., 3) m."""
        away = x - self.centre
        flat = np.stack([away @ self.right, away @ self.down], -1) / self.metres_per_pixel
        if self.distance is not None:
            flat = flat / (1 + (away @ self.look) / self.distance)[..., None]
        return self.middle + flat

    def entry(self, declared: str) -> dict:
        """The case's [camera], as `declared` kind."""
        vector = [round(float(a), 9) for a in self.down]
        if declared == "pinhole":
            eye = self.centre - self.distance * self.look
            return {
                "kind": "pinhole",
                "position": [float(a) for a in eye],
                "look": [float(a) for a in self.look],
                "down": vector,
                "focal_px": self.distance / self.metres_per_pixel,
                "principal_point": [float(a) for a in self.middle],
                "image_size": list(self.size),
            }
        origin = replace(self, distance=None).see(np.zeros(3))
        return {
            "kind": "orthographic",
            "metres_per_pixel": self.metres_per_pixel,
            "right": [round(float(a), 9) for a in self.right],
            "down": vector,
            "principal_point": [float(a) for a in origin],
            "image_size": list(self.size),
        }


def draw(rng, body, tilt: float = 0.35, portrait: bool = False) -> Camera:
    """A camera that sees the plane of the softest bending, turned by up to `tilt` rad."""
    up = np.array([0.0, 0, 1])
    flat = body.axis if abs(body.axis @ up) < 0.5 else body.swing
    angle = rng.uniform(-tilt, tilt)
    right = np.cos(angle) * flat + np.sin(angle) * np.cross(up, flat)
    down = -up
    if portrait and abs(body.axis @ up) < 0.5:
        right, down = up, np.cross(up, np.cross(right, up))
    centre = (body.nodes.max(0) + body.nodes.min(0)) / 2
    span = max(np.ptp(body.nodes @ down) / 720, np.ptp(body.nodes @ right) / 1280)
    return Camera(right, down, centre, span / rng.uniform(0.45, 0.7))
