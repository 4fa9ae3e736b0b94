"""The closed circle: simulated by one program, rendered by another, tracked and calibrated by ours.

A soft bar of the independent simulator is given a speckled side, Blender renders its swing into an
mp4, and from that file alone come its tracks, its stiffness and its damping.
"""

import cv2
import numpy as np
import pytest

pytest.importorskip("bpy")

from core.pipeline import calibrate_case
from core.track import track
from core.video import open_video, read_frames
from tests.addon.rendered import Sheet, View, render
from tests.core.clips import store
from tests.truth import bodies, film, scene, write

FPS, FRAMES = 60.0, 110
DAMPING = 0.025
MARKERS = (6, 10, 14, 18, 21, 24)  # columns of nodes along the bar
SIZE = (560, 144)


class Circle:
    """The truth and the film of it."""

    def __init__(self, folder):
        self.body = bodies.bar(np.random.default_rng(5))
        nodes = self.body.nodes
        front = np.flatnonzero(np.isclose(nodes[:, 1], nodes[:, 1].min()))
        self.rest = nodes[front]
        x, z = np.unique(self.rest[:, 0]), np.abs(self.rest[:, 2])
        middle = np.flatnonzero(z < 0.2 * z.max())
        self.markers = [middle[np.argmin(abs(self.rest[middle, 0] - x[k]))] for k in MARKERS]
        self.places = swing(self.body, front)
        low, high = self.rest.min(axis=0), self.rest.max(axis=0)
        self.view = View(tuple((low + high) / 2), 1.09 * (high - low)[0] / SIZE[0], SIZE)
        speckle = ((self.rest - low) / np.maximum(high - low, 1e-9))[:, [0, 2]]
        sheet = Sheet(self.places, quads(self.body, front), speckle)
        self.clip = render(sheet, self.view, folder / "clip.mp4", FPS)
        self.pixels = self.view.project(self.places[:, self.markers])


def swing(body, nodes) -> np.ndarray:
    """(T, V, 3) m of the nodes, let go from a pull at the free end."""
    tip = int(nodes[np.argmax(body.nodes[nodes, 0] - np.abs(body.nodes[nodes, 2]))])
    stage = scene.Scene(
        body=body,
        ratio=np.full(scene.MODES, DAMPING),
        release="pull",
        node=tip,
        direction=np.array([0.0, 0.0, 1.0]),
        amplitude=0.04 * body.size,
        markers=[int(n) for n in nodes],
        support=[],
        fps=FPS,
        frames=FRAMES,
        limit=25.0,
    )
    return film.shoot(stage, [], []).values


def quads(body, nodes) -> np.ndarray:
    """(F, 4) rows of `nodes`: a quarter of every nine-node face that has all of its nodes there."""
    row = {int(n): k for k, n in enumerate(nodes)}
    inside = [face for face in body.faces if all(int(n) in row for n in face)]
    square = np.array([[row[int(n)] for n in face] for face in inside]).reshape(-1, 3, 3)
    a, b = square[:, :-1], square[:, 1:]
    return np.stack([a[..., :-1], b[..., :-1], b[..., 1:], a[..., 1:]], -1).reshape(-1, 4)


@pytest.fixture(scope="module")
def circle(tmp_path_factory):
    return Circle(tmp_path_factory.mktemp("circle"))


def error_of(circle, path, frames=FRAMES):
    tracks = track(path, circle.pixels[0], capture_fps=FPS)
    error = tracks.values - circle.pixels[:frames]
    return tracks, float(np.sqrt(np.mean(error**2)))


def test_a_rendered_swing_is_tracked_to_three_hundredths_of_a_pixel(circle):
    tracks, error = error_of(circle, circle.clip)
    assert np.isfinite(tracks.values).all()
    assert np.ptp(circle.pixels[:, -1, 1]) > 20  # px: it does swing
    assert error < 0.03
    assert tracks.warnings == ()


def test_noise_blur_and_compression_each_cost_precision_and_sigma_knows(circle, tmp_path):
    pictures = [frame.grey for frame in read_frames(open_video(circle.clip))][:60]
    rng = np.random.default_rng(0)

    def noisy(picture, level):
        seen = picture + level * rng.standard_normal(picture.shape)
        return np.clip(seen, 0, 255).astype(np.uint8)

    spoilt = {
        "plain": (pictures, ""),
        "noise": ([noisy(p, 12) for p in pictures], ""),
        "blur": ([noisy(cv2.GaussianBlur(p, (0, 0), 3), 12) for p in pictures], ""),
        "compressed": (pictures, "mp4v"),
    }
    errors = {}
    for name, (frames, codec) in spoilt.items():
        folder = tmp_path / name
        folder.mkdir()
        tracks, errors[name] = error_of(circle, store(folder, frames, codec, FPS), 60)
        assert np.isfinite(tracks.values).all()
        assert 0.3 * errors[name] < np.sqrt(np.mean(tracks.sigma**2)) < 2 * errors[name]
    assert errors["plain"] < errors["noise"] < errors["blur"] < 0.5
    assert errors["plain"] < errors["compressed"] < 0.1


def test_the_rendered_film_alone_gives_stiffness_and_damping(circle, tmp_path):
    report = calibrate_case(write_case(circle, tmp_path), elements=1500).report
    material = report["youngs_modulus"]["material"]["value"]
    assert material == pytest.approx(circle.body.young, rel=0.01)
    assert report["modes"][0]["damping_ratio"]["value"] == pytest.approx(DAMPING, rel=0.05)
    frequency = bodies.modes(circle.body, 1)[0][0]
    assert report["modes"][0]["natural_frequency_hz"]["value"] == pytest.approx(frequency, rel=1e-3)


def write_case(circle, folder):
    """The case as its author would write it, with nothing but what he can know."""
    body, view = circle.body, circle.view
    write.surface(folder / "body.obj", body.vertices, body.triangles)
    (folder / "clip.mp4").write_bytes(circle.clip.read_bytes())
    thing = {"mesh": "body.obj", "length_unit": "m"}
    thing |= {"density": body.density, "poisson_ratio": body.poisson}
    camera = {
        "kind": "orthographic",
        "metres_per_pixel": view.metres_per_pixel,
        "right": [1, 0, 0],
        "down": [0, 0, -1],
        "principal_point": view.principal_point,
        "image_size": list(view.size),
    }
    tables = [
        ("[object]", thing),
        ("[[pin]]", {"box": {"min": body.pin_box[0], "max": body.pin_box[1]}}),
        ("[model]", {"declared": ["viscous_damping"]}),
        ("[recording]", {"video": "clip.mp4", "capture_fps": FPS, "start": 0.0}),
        ("[camera]", camera),
    ]
    for k, node in enumerate(circle.markers):
        pixel = circle.pixels[0, k]
        entry = {"name": f"m{k}", "position": circle.rest[node], "pixel": pixel}
        tables.append(("[[marker]]", entry))
    write.case(folder, {"name": "circle"}, tables)
    return folder / "case.toml"
