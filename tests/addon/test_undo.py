"""Undo, save, copy, append, override: the file's data stay what they were, and go on."""

import tomllib

import bpy
import pytest

from tests.addon.driven import message, png, prepared, select, state


def do_place(obj, tmp_path):
    return bpy.ops.ringdown.place(index=0, position=(0.05, 0, 0.01))


STEPS = {
    "use": lambda o, t: bpy.ops.ringdown.use(),
    "material": lambda o, t: bpy.ops.ringdown.material(preset="DRAGON_30"),
    "pins": lambda o, t: bpy.ops.ringdown.pins(),
    "read": lambda o, t: bpy.ops.ringdown.read(),
    "slow_motion": lambda o, t: bpy.ops.ringdown.slow_motion(factor=4),
    "place": do_place,
    "calibrate": lambda o, t: bpy.ops.ringdown.calibrate(),
    "picture": lambda o, t: bpy.ops.ringdown.picture(),
    "pluck": lambda o, t: bpy.ops.ringdown.pluck(vertex=3),
    "bake": lambda o, t: bpy.ops.ringdown.bake(),
    "remove": lambda o, t: bpy.ops.ringdown.remove(),
}


@pytest.mark.parametrize("upto", list(STEPS))
def test_undo_after_each_step_restores_the_file(bar, fake, tmp_path, upto):
    select(bar, lambda co: co.x < 0.001)
    bar.ringdown.recording.source = "CSV"
    bar.ringdown.recording.path = str(tmp_path / "tracks.csv")
    names = list(STEPS)
    for name in names[: names.index(upto)]:
        if name != "picture":
            assert STEPS[name](bar, tmp_path) == {"FINISHED"}
    if upto == "picture":
        bar.ringdown.facts.picture = png(tmp_path)
    bpy.ops.ed.undo_push(message="before")
    before = state()
    assert STEPS[upto](bpy.data.objects[0], tmp_path) == {"FINISHED"}
    bpy.ops.ed.undo_push(message=upto)
    assert state() != before
    bpy.ops.ed.undo()
    assert state() == before


OTHERS = {
    "case_open": lambda case: bpy.ops.ringdown.case_open(filepath=str(case)),
    "measure": lambda case: bpy.ops.ringdown.measure(),
    "free_part": lambda case: bpy.ops.ringdown.free_part(),
}


@pytest.mark.parametrize("name", list(OTHERS))
def test_undo_after_an_operator_beside_the_road_restores_the_file(bar, fake, tmp_path, name):
    prepared(bar, tmp_path)
    case = exported(tmp_path, "")
    bar.ringdown.facts.look = ""
    bpy.ops.ed.undo_push(message="before")
    before = state()
    assert OTHERS[name](case) == {"FINISHED"}
    bpy.ops.ed.undo_push(message=name)
    assert state() != before
    bpy.ops.ed.undo()
    assert state() == before


def exported(tmp_path, recording):
    """The case folder of what is prepared, with more lines under [recording]."""
    assert bpy.ops.ringdown.export(directory=str(tmp_path / "case")) == {"FINISHED"}
    path = tmp_path / "case" / "case.toml"
    path.write_text(path.read_text().replace("[recording]", f"[recording]\n{recording}"))
    return path


@pytest.mark.parametrize(
    "given", [{"start": 0.25}, {"stop": 1.5}, {"start": 0.25, "stop": 1.5}, {}]
)
def test_release_and_stop_of_an_opened_case_come_back_out_as_they_went_in(
    bar, fake, tmp_path, given
):
    prepared(bar, tmp_path)
    lines = "\n".join(f"{end} = {value}" for end, value in given.items())
    assert OTHERS["case_open"](exported(tmp_path, lines)) == {"FINISHED"}
    assert bpy.ops.ringdown.export(directory=str(tmp_path / "again")) == {"FINISHED"}
    found = tomllib.loads((tmp_path / "again" / "case.toml").read_text())["recording"]
    assert {end: found[end] for end in ("start", "stop") if end in found} == given


def test_an_opened_case_is_named_from_the_saved_file_on(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    case = exported(tmp_path, "")
    bpy.ops.wm.save_as_mainfile(filepath=str(case.parent / "file.blend"))
    assert OTHERS["case_open"](case) == {"FINISHED"}
    recording = bpy.context.scene.ringdown_object.ringdown.recording
    assert (recording.case_file, recording.path) == ("//case.toml", "//tracks.csv")
    assert bpy.ops.ringdown.read() == {"FINISHED"}


@pytest.mark.parametrize("upto", ["use", "pins", "read", "calibrate", "bake"])
def test_a_file_saved_after_any_step_goes_on_from_there(bar, fake, tmp_path, upto):
    select(bar, lambda co: co.x < 0.001)
    bar.ringdown.recording.source = "CSV"
    bar.ringdown.recording.path = str(tmp_path / "tracks.csv")
    names = ["use", "pins", "read", "calibrate", "bake"]
    for name in names[: names.index(upto) + 1]:
        STEPS[name](bar, tmp_path)
    before = state()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "file.blend"))
    assert state() == before
    for name in names[names.index(upto) + 1 :]:
        assert STEPS[name](bpy.data.objects[0], tmp_path) == {"FINISHED"}
    assert len(bpy.data.shape_keys) == 1


def test_a_copied_object_takes_its_calibration_along(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    assert copy is not bar
    bpy.context.scene.ringdown_object = copy
    assert bpy.ops.ringdown.bake() == {"FINISHED"}
    assert copy.data.shape_keys
    assert bar.data.shape_keys is None


def test_an_appended_object_brings_its_calibration_and_bakes(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "from.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "from.blend")) as (there, here):
        here.objects = list(there.objects)
    obj = here.objects[0]
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.ringdown.bake() == {"FINISHED"}
    assert len(obj.data.shape_keys.key_blocks) == 2


def test_a_linked_object_is_refused_with_the_way_out(bar, fake, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "from.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "from.blend"), link=True) as (there, here):
        here.objects = list(there.objects)
    bpy.context.collection.objects.link(here.objects[0])
    bpy.context.view_layer.objects.active = here.objects[0]
    assert "make it local" in message(bpy.ops.ringdown.calibrate)


def test_settings_on_a_library_override_can_be_edited_and_survive_reload(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.material(preset="DRAGON_30")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "from.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "from.blend"), link=True) as (there, here):
        here.objects = list(there.objects)
    mine = here.objects[0].override_create()
    bpy.context.collection.objects.link(mine)
    mine.ringdown.elements = 777
    mine.ringdown.material.density = 1111
    name = mine.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "over.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "over.blend"))
    mine = next(o for o in bpy.data.objects if o.name == name and o.override_library)
    assert mine.ringdown.elements == 777
    assert mine.ringdown.material.density == 1111
