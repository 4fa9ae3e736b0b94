"""A clip's tracks and the scene's camera become what a case holds, in metres and pixels."""

import importlib
import tomllib

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Euler, Vector

NAME = "bl_ext.user_default.ringdown"
SIZE = 160, 120
METRES_PER_PIXEL, MIDDLE = 0.0006, (70.0, 65.0)


@pytest.fixture
def film(rd):
    return importlib.import_module(f"{NAME}.addon.film")


@pytest.fixture
def camera_of(rd):
    return importlib.import_module(f"{NAME}.core.camera_fields")


@pytest.fixture
def block(rd):
    bpy.ops.mesh.primitive_cube_add(size=0.04)
    obj = bpy.context.object
    obj.rotation_euler = Euler((0.3, -0.2, 0.5))
    obj.location = (1.0, 2.0, 3.0)
    bpy.context.view_layer.update()
    return obj


@pytest.fixture
def clip(rd, tmp_path):
    """Forty pictures as a movie clip, without tracks yet."""
    for frame in range(1, 41):
        image = bpy.data.images.new("frame", *SIZE)
        image.filepath_raw, image.file_format = str(tmp_path / f"f_{frame:04d}.png"), "PNG"
        image.save()
        bpy.data.images.remove(image)
    return bpy.data.movieclips.load(str(tmp_path / "f_0001.png"))


def track(clip, name, pixels):
    """A track at pixels (T, 2), u right, v down from the middle of the first one."""
    found = clip.tracking.tracks.new(name=name, frame=1)
    for frame, (u, v) in enumerate(pixels, start=1):
        co = (u + 0.5) / SIZE[0], 1 - (v + 0.5) / SIZE[1]
        found.markers.insert_frame(frame, co=co)


def seen_from_front(world):
    """Pixels (n, 2) of offsets (n, 3) from the block's origin along the world's axes."""
    return np.stack([world[:, 0], -world[:, 2]], axis=1) / METRES_PER_PIXEL + MIDDLE


def test_scale_and_axes_come_back_from_points_placed_on_a_turned_object(
    rd, film, camera_of, block, clip, tmp_path
):
    local = np.array([[0.02, 0.02, 0.02], [-0.02, 0.02, -0.02], [0.02, -0.02, 0.0]])
    turn = np.array(block.matrix_world.to_3x3())
    home = seen_from_front(local @ turn.T)
    wobble = 6 * np.exp(-np.arange(40) / 6)[:, None] * np.cos(np.arange(40))[:, None]
    for k in range(3):
        track(clip, f"p{k}", home[k] + wobble * [1, 0.3])
    recording = block.ringdown.recording
    recording.source, recording.clip, recording.capture_fps = "CLIP", clip, 120
    assert bpy.ops.ringdown.read() == {"FINISHED"}
    for k, place in enumerate(local):
        bpy.ops.ringdown.place(index=k, position=place)
    block.vertex_groups.new(name="Pins").add([0, 1], 1.0, "REPLACE")
    block.ringdown.pins = "Pins"
    bpy.ops.ringdown.export(directory=str(tmp_path / "case"))
    case = tomllib.loads((tmp_path / "case" / "case.toml").read_text())
    assert np.isclose(case["camera"]["metres_per_pixel"], METRES_PER_PIXEL, rtol=0.01)
    right, down = (np.array(case["camera"][axis]) for axis in ("right", "down"))
    assert np.allclose(turn @ right, (1, 0, 0), atol=1e-6)
    assert np.allclose(turn @ down, (0, 0, -1), atol=1e-6)
    rows = (tmp_path / "case" / "tracks.csv").read_text().splitlines()
    assert rows[0].startswith("time,p0.u,p0.v,p1.u")
    first = [float(x) for x in rows[1].split(",")]
    assert np.allclose(first[1:3], home[0] + wobble[0] * [1, 0.3], atol=1e-3)
    assert np.isclose(float(rows[2].split(",")[0]), 1 / 120)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("shape", [(160, 120), (120, 160)])
def test_the_scenes_camera_projects_as_blender_does(rd, film, camera_of, block, kind, shape):
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = shape
    lens = bpy.data.cameras.new("Camera")
    lens.type, lens.lens, lens.ortho_scale = kind, 40, 0.3
    lens.shift_x, lens.shift_y = 0.1, -0.05
    scene.camera = bpy.data.objects.new("Camera", lens)
    scene.collection.objects.link(scene.camera)
    scene.camera.location = (1.1, 1.4, 3.1)
    scene.camera.rotation_euler = (np.deg2rad(80), 0.05, 0.1)
    bpy.context.view_layer.update()
    block.ringdown.recording.scale = "CAMERA"
    table = film.camera(bpy.context, block, {})
    fields = dict.fromkeys(camera_of.CAMERA_FIELDS) | {
        key: np.array(value) if isinstance(value, list) else value for key, value in table.items()
    }
    camera = camera_of.make_camera(fields, "[camera]")
    for vertex in block.data.vertices:
        there = block.matrix_world @ vertex.co
        x, y, _ = world_to_camera_view(scene, scene.camera, Vector(there))
        blender = x * shape[0] - 0.5, (1 - y) * shape[1] - 0.5
        found = rd.read.axes(block, scene)
        ours = camera.project(np.array(vertex.co) @ found.stretch.T)
        assert np.allclose(ours, blender, atol=2e-3)


def test_a_track_that_is_gone_is_named(rd, film, clip):
    track(clip, "p0", np.ones((4, 2)))
    with pytest.raises(Exception, match='no track "p9"'):
        film.clip_tracks(clip, ["p9"])


def test_points_in_one_place_give_no_scale(rd, film, block, clip):
    for name in ("a", "b"):
        track(clip, name, np.full((9, 2), 30.0))
    block.ringdown.recording.source, block.ringdown.recording.clip = "CLIP", clip
    bpy.ops.ringdown.read()
    with pytest.raises(Exception, match="two points apart"):
        film.camera(bpy.context, block, film.rest_pixels(block))
    block.ringdown.recording.scale = "LENGTH"
    block.ringdown.recording.length, block.ringdown.recording.length_px = 0.2, 50
    table = film.camera(bpy.context, block, film.rest_pixels(block))
    assert np.isclose(table["metres_per_pixel"], 0.2 / 50)


def test_a_table_of_another_program_is_read_with_its_gaps(rd, film, tmp_path):
    path = tmp_path / "dlc.csv"
    path.write_text(
        "scorer,n,n,n\nbodyparts,tip,tip,tip\ncoords,x,y,likelihood\n4,10,20,1\n6,12,22,0.9\n"
    )
    seen = film.table_tracks(path)
    assert seen.names == ["tip"]
    assert seen.pixels[[0, 2], 0].tolist() == [[10, 20], [12, 22]]
    assert np.isnan(seen.pixels[1]).all()
