"""A textured sheet, moved vertex by vertex, as Blender renders it into a clip."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np


@dataclass(frozen=True, eq=False)
class Sheet:
    """What is rendered: the places of its corners in every frame."""

    places: np.ndarray  # (T, V, 3) m
    faces: np.ndarray  # (F, 4) rows of the corners
    speckle: np.ndarray  # (V, 2) place of each corner on the texture, 0..1


@dataclass(frozen=True)
class View:
    """An orthographic camera that looks along +y; x is right and z is up."""

    centre: tuple[float, float, float]  # m, in the middle of the picture
    metres_per_pixel: float
    size: tuple[int, int]  # px

    @property
    def principal_point(self) -> list[float]:
        """px where the object's origin is seen; whole pixels are the centres of pixels."""
        u = self.size[0] / 2 - 0.5 - self.centre[0] / self.metres_per_pixel
        v = self.size[1] / 2 - 0.5 + self.centre[2] / self.metres_per_pixel
        return [u, v]

    def project(self, x: np.ndarray) -> np.ndarray:
        """px (..., 2) of places (..., 3) m."""
        flat = np.stack([x[..., 0], -x[..., 2]], -1) / self.metres_per_pixel
        return flat + self.principal_point


def speckles(width: int, height: int, seed: int = 0) -> np.ndarray:
    """Grey levels (height, width) 0..1 of blotches some ten texels wide."""
    rng = np.random.default_rng(seed)
    noise = np.fft.rfft2(rng.standard_normal((height, width)))
    fy, fx = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None]
    noise *= np.exp(-((np.hypot(fx, fy) * 10) ** 2) * np.pi)
    grey = np.fft.irfft2(noise, (height, width))
    return np.clip(0.5 + 0.22 * grey / grey.std(), 0, 1)


def render(sheet: Sheet, view: View, path: Path, fps: float) -> Path:
    """Write the mp4 at `path` (H.264, as good as lossless) with Workbench."""
    scene = bpy.data.scenes.new("film")
    mesh = _mesh(sheet)
    thing = bpy.data.objects.new("sheet", mesh)
    scene.collection.objects.link(thing)
    _camera(scene, view)
    _settings(scene, view, path, fps, len(sheet.places))

    def move(where, *_):
        at = sheet.places[where.frame_current - 1].astype(np.float32)
        mesh.vertices.foreach_set("co", at.ravel())
        mesh.update()

    bpy.app.handlers.frame_change_pre.append(move)
    try:
        bpy.ops.render.render(animation=True, scene=scene.name)
    finally:
        bpy.app.handlers.frame_change_pre.remove(move)
        bpy.data.scenes.remove(scene)
    return path


def _mesh(sheet: Sheet):
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata(sheet.places[0].tolist(), [], sheet.faces.tolist())
    layer = mesh.uv_layers.new(name="texture")
    corners = np.array([loop.vertex_index for loop in mesh.loops])
    layer.data.foreach_set("uv", sheet.speckle[corners].astype(np.float32).ravel())
    span = np.ptp(sheet.places[0], axis=0)
    width = 1024
    grey = speckles(width, max(32, round(width * span[2] / span[0])))
    image = bpy.data.images.new("speckles", grey.shape[1], grey.shape[0])
    pixels = np.ones((*grey.shape, 4), np.float32)
    pixels[..., :3] = grey[..., None]
    image.pixels.foreach_set(pixels.ravel())
    material = bpy.data.materials.new("speckled")
    material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
    mesh.materials.append(material)
    return mesh


def _camera(scene, view: View) -> None:
    camera = bpy.data.cameras.new("camera")
    camera.type = "ORTHO"
    camera.ortho_scale = max(view.size) * view.metres_per_pixel
    camera.clip_start, camera.clip_end = 1e-3, 10
    eye = bpy.data.objects.new("camera", camera)
    eye.location = (view.centre[0], view.centre[1] - 1, view.centre[2])
    eye.rotation_euler = (np.pi / 2, 0, 0)
    scene.collection.objects.link(eye)
    scene.camera = eye


def _settings(scene, view: View, path: Path, fps: float, frames: int) -> None:
    render = scene.render
    render.engine = "BLENDER_WORKBENCH"
    shading = scene.display.shading
    shading.light, shading.color_type = "FLAT", "TEXTURE"
    scene.display.render_aa = "8"
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("grey")
    render.resolution_x, render.resolution_y = view.size
    render.resolution_percentage = 100
    scene.frame_start, scene.frame_end = 1, frames
    render.fps = round(fps)
    render.filepath = str(path)
    if bpy.app.version >= (5, 0, 0):
        render.image_settings.media_type = "VIDEO"
    render.image_settings.file_format = "FFMPEG"
    render.ffmpeg.format, render.ffmpeg.codec = "MPEG4", "H264"
    render.ffmpeg.constant_rate_factor = "PERC_LOSSLESS"
    render.ffmpeg.gopsize = 12
    render.use_file_extension = False
