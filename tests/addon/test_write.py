"""A bake follows the motion in seconds, and leaves everything that is the artist's."""

import bpy
import numpy as np
import pytest

F, Z = np.array([3.7, 9.1]), np.array([0.02, 0.05])


@pytest.fixture
def ball():
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.05)
    return bpy.context.object


@pytest.fixture
def ringing(rd, ball):
    """Two damped modes and a creeping offset at the ball's vertices, and its closed form."""
    shapes = np.random.default_rng(3).standard_normal((len(ball.data.vertices), 3, 3)) * 0.01

    def weights(t):
        wave = np.exp(-2 * np.pi * Z * F * t[:, None]) * np.cos(2 * np.pi * F * t[:, None] + 0.4)
        return np.concatenate([wave, 0.2 * np.exp(-t[:, None] / 0.8)], axis=1)

    time = np.linspace(0, 2, int(2 * 40 * F.max()) + 1)
    motion = rd.data.Motion(("mode 1", "mode 2", "creep"), shapes, time, weights(time))
    motion_at = lambda t: np.einsum("vdk,tk->tvd", shapes, weights(np.clip(t, 0, 2)))  # noqa: E731
    return motion, motion_at


def seen(obj, frames):
    """(n, V, 3) evaluated local positions at the frames, which may lie between whole ones."""
    found = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame), subframe=float(frame - int(frame)))
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        co = np.empty(3 * len(evaluated.data.vertices), np.float32)
        evaluated.data.vertices.foreach_get("co", co)
        found.append(co.reshape(-1, 3))
    return np.array(found, float)


def set_rate(fps):
    bpy.context.scene.render.fps = fps


@pytest.mark.parametrize("fps", [12, 24, 30, 60, 120])
def test_a_saved_bake_opened_again_follows_the_motion_in_seconds(rd, ball, ringing, fps, tmp_path):
    motion, truth = ringing
    set_rate(fps)
    rd.write.shape_keys(ball, rd.bake.strongest(motion), rd.write.Range(first=11))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "baked.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "baked.blend"))
    ball = bpy.data.objects[0]
    rest = rd.read.rest(ball)
    seconds = np.linspace(0, 1.9, 33)  # between frames too
    off = seen(ball, 11 + seconds * fps) - rest - truth(seconds)
    assert np.abs(off).max() < 1e-4 * np.abs(truth(seconds)).max()


@pytest.mark.parametrize("fps", [24, 30, 60])
def test_a_cache_plays_the_motion_at_every_frame(rd, ball, ringing, fps, tmp_path):
    motion, truth = ringing
    set_rate(fps)
    rd.write.cache(ball, motion, tmp_path / "ball.pc2", rd.write.Range(first=5))
    frames = np.arange(5, 5 + int(1.5 * fps), 4)
    off = seen(ball, frames) - rd.read.rest(ball) - truth((frames - 5) / fps)
    assert np.abs(off).max() < 1e-4 * np.abs(truth(frames * 0.0)).max()


def artists_setup(ball):
    """A keyed shape key, a driver, an object action and modifiers, as an artist may have them."""
    ball.shape_key_add(name="Basis", from_mix=False)
    smile = ball.shape_key_add(name="smile", from_mix=False)
    for point in smile.points:
        point.co.z *= 1.3
    smile.value = 0
    smile.keyframe_insert("value", frame=1)
    smile.value = 1
    smile.keyframe_insert("value", frame=41)
    ball.keyframe_insert("location", frame=1)
    ball.modifiers.new("Cast", "CAST").factor = 0.2
    bpy.context.view_layer.update()


def everything(obj):
    """All that the artist can see of his own: keys, curves, modifiers, positions."""
    keys = obj.data.shape_keys
    data = keys.animation_data if keys else None
    return {
        "blocks": [(b.name, b.value, b.slider_min, b.mute) for b in keys.key_blocks]
        if keys
        else None,
        "action": data.action.name if data and data.action else None,
        "slot": data.action_slot.identifier if data and data.action else None,
        "tracks": len(data.nla_tracks) if data else None,
        "modifiers": [(m.name, m.type, m.show_viewport) for m in obj.modifiers],
        "object": obj.animation_data.action.name if obj.animation_data else None,
        "actions": sorted(a.name for a in bpy.data.actions),
        "properties": sorted(obj.keys()),
        "active": obj.active_shape_key_index,
    }


@pytest.mark.parametrize("kind", ["keys", "cache"])
@pytest.mark.parametrize("setup", [artists_setup, lambda ball: None], ids=["artist", "bare"])
def test_remove_takes_exactly_ours_away(rd, ball, ringing, kind, setup, tmp_path):
    setup(ball)
    bpy.context.scene.frame_set(1)
    before, places = everything(ball), seen(ball, [1, 20, 41])
    bpy.context.scene.frame_set(1)
    for _ in range(2):  # again replaces only ours
        if kind == "keys":
            rd.write.shape_keys(ball, rd.bake.strongest(ringing[0]))
            assert len(rd.marks.shape_keys(ball)) == 3
        else:
            rd.write.cache(ball, ringing[0], tmp_path / "a.pc2")
            assert len(rd.marks.modifiers(ball)) == 1
    assert everything(ball) != before
    assert rd.write.remove(ball)
    bpy.context.scene.frame_set(1)
    assert everything(ball) == before
    assert (seen(ball, [1, 20, 41]) == places).all()
    assert not rd.write.remove(ball)


@pytest.mark.parametrize("kind", ["keys", "cache"])
def test_the_artists_own_keys_go_on_playing_under_the_wobble(rd, ball, ringing, kind, tmp_path):
    artists_setup(ball)
    ball.modifiers.clear()
    alone = seen(ball, [9, 25])
    if kind == "keys":
        rd.write.shape_keys(ball, rd.bake.strongest(ringing[0]))
    else:
        rd.write.cache(ball, ringing[0], tmp_path / "a.pc2")
    off = seen(ball, [9, 25]) - alone - ringing[1](np.array([8, 24]) / 24)
    reach = np.abs(ringing[1](np.zeros(1))).max()
    # Blender's Integrate turns a cache with the faces that the artist's key has turned
    assert np.abs(off).max() < (1e-4 if kind == "keys" else 0.35) * reach


def test_keys_that_the_artist_adds_to_our_action_stay(rd, ball, ringing):
    rd.write.shape_keys(ball, rd.bake.strongest(ringing[0]))
    own = ball.shape_key_add(name="own", from_mix=False)
    own.keyframe_insert("value", frame=3)
    ball.data.shape_keys.key_blocks[1].name = "renamed by the artist"
    rd.write.remove(ball)
    assert [b.name for b in ball.data.shape_keys.key_blocks] == ["Basis", "own"]
    action = ball.data.shape_keys.animation_data.action
    assert [c.data_path for c in action.layers[0].strips[0].channelbags[0].fcurves] == [
        'key_blocks["own"].value'
    ]


def test_a_strip_of_the_artist_plays_on_beside_ours(rd, ball, ringing):
    artists_setup(ball)
    ball.modifiers.clear()
    data = ball.data.shape_keys.animation_data
    action, slot = data.action, data.action_slot
    data.action = None
    strip = data.nla_tracks.new().strips.new("smile", 1, action)
    strip.action_slot = slot
    alone = seen(ball, [9, 25])
    rd.write.shape_keys(ball, rd.bake.strongest(ringing[0]))
    off = seen(ball, [9, 25]) - alone - ringing[1](np.array([8, 24]) / 24)
    assert np.abs(off).max() < 1e-4 * np.abs(ringing[1](np.zeros(1))).max()
    rd.write.remove(ball)
    assert len(data.nla_tracks) == 1
    assert np.allclose(seen(ball, [9, 25]), alone, atol=1e-9)


def test_scale_parent_and_units_change_no_metre(rd, ball):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    plain = rd.read.surface(ball, depsgraph)
    parent = bpy.data.objects.new("parent", None)
    bpy.context.collection.objects.link(parent)
    ball.parent = parent
    parent.rotation_euler = (0.3, 0.7, 1.1)
    parent.scale = (10, 10, 10)
    parent.location = (3, 4, 5)
    bpy.context.scene.unit_settings.scale_length = 0.1
    bpy.context.view_layer.update()
    turned = rd.read.surface(ball, depsgraph)
    assert np.allclose(plain.vertices, turned.vertices, atol=1e-8)


def test_absolute_shape_keys_are_refused_with_the_way_out(rd, ball, ringing):
    ball.shape_key_add(name="Basis")
    ball.data.shape_keys.use_relative = False
    with pytest.raises(rd.write.BlenderError, match=r"absolute.*Relative"):
        rd.write.shape_keys(ball, rd.bake.strongest(ringing[0]))
