"""Calibrate, and what is done with the result."""

import json
import tomllib
from pathlib import Path

import bpy
import numpy as np

from ..core.bake import load_motion, save_motion
from ..core.camera_fields import CAMERA_FIELDS
from ..core.case_fields import read_table
from ..core.data import Marker, TetMesh
from ..core.errors import CoreError
from ..core.looked_at import as_seen, read_camera
from ..core.tets import key, save_tets
from . import folder as case_folder
from . import job, keep, ready, running, windows

SURFACE, TETS = "surface.npz", Path(job.REPORT).with_suffix(".npz")


class RINGDOWN_OT_calibrate(running.Running, bpy.types.Operator):
    """Fit the body to the recording and find what is missing. Runs beside Blender; Esc cancels"""

    bl_idname = "ringdown.calibrate"
    bl_label = "Calibrate"
    bl_options = {"REGISTER", "UNDO"}
    what = "Calibration"
    alone = True

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_calibration(context))

    def start(self, context, obj, folder: Path) -> job.Job:
        surface = case_folder.write_case(context, obj, folder)
        np.savez(folder / SURFACE, vertices=surface.vertices, faces=surface.faces)
        use_cage(obj, surface, folder)
        line = job.calibration(folder / case_folder.CASE, folder, obj.ringdown.elements)
        return job.Job([*line, *options()], folder, running.threads())

    def finish(self, context, obj, folder: Path) -> None:
        write_result(obj, folder)
        context.window_manager.ringdown_short = not bpy.app.background  # it is what one waited for


def use_cage(obj: bpy.types.Object, surface, folder: Path) -> None:
    """The kept tetrahedra beside the case, where they are still those of this very shape."""
    facts = obj.ringdown.facts
    if not facts.cage:
        return
    cage = keep.unpack(facts.cage)
    if np.array_equal(cage["of"], surface.vertices):
        mesh = TetMesh(cage["nodes"], cage["tets"])
        save_tets(folder / TETS, mesh, key(surface, obj.ringdown.elements))


def options() -> list[str]:
    element = running.element()
    return ["--element", element] if element else []


def write_result(obj: bpy.types.Object, folder: Path) -> None:
    """Report, motion and picture go with the object."""
    text = (folder / job.REPORT).read_text(encoding="utf-8")
    json.loads(text)
    motion, more = load_motion(folder / job.MOTION)
    with np.load(folder / SURFACE) as file:
        surface = {"vertices": file["vertices"], "faces": file["faces"].astype(np.int32)}
    save_motion(folder / "kept.npz", motion, **surface, **followed(folder, more))
    facts = obj.ringdown.facts
    facts.motion = keep.pack_bytes((folder / "kept.npz").read_bytes())
    facts.report = text
    picture = folder / job.PICTURE
    facts.picture = keep.pack_bytes(picture.read_bytes()) if picture.is_file() else ""


def followed(folder: Path, more: dict) -> dict:
    """Measured and predicted markers (T, n, 3) m over time, and the shapes' modal masses.

    Pixels are moved in the picture's plane.
    """
    found = {"marker_time": more["clock"]}
    if "modal_mass" in more:
        found["modal_mass"] = more["modal_mass"]
    fields = tomllib.loads((folder / case_folder.CASE).read_text(encoding="utf-8"))
    places = np.array([marker["position"] for marker in fields["marker"]], float)
    flat = more["measured"].shape[2] == 2
    if flat:
        table = read_table(fields["camera"], CAMERA_FIELDS, "[camera]")
        markers = [Marker(one["name"], one["position"]) for one in fields["marker"]]
        camera = as_seen(read_camera(table, "[camera]", markers), places, more["measured"])
        back = np.linalg.pinv(camera.jacobian(places))  # (n, 3, 2) metres per pixel
    for name in ("measured", "predicted"):
        values = more[name]
        if flat:
            values = places + np.einsum("nij,tnj->tni", back, values - camera.project(places))
        found[f"marker_{name}"] = values
    return found


class RINGDOWN_OT_picture(bpy.types.Operator):
    """Show the report's picture in an Image Editor"""

    bl_idname = "ringdown.picture"
    bl_label = "Show Picture"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        why = ready.for_result(context)
        if not why and not ready.target(context).ringdown.facts.picture:
            why = "The calibration left no picture"
        return ready.refuse(cls, why)

    def execute(self, context):
        obj = ready.target(context)
        image = picture_of(obj)
        windows.editor(context, "IMAGE_EDITOR", lambda space: setattr(space, "image", image))
        return {"FINISHED"}


def picture_of(obj: bpy.types.Object) -> bpy.types.Image:
    """The kept picture as a packed image of this file; the one shown before is replaced."""
    name = f"Ringdown {obj.name}"
    old = bpy.data.images.get(name)
    path = Path(bpy.app.tempdir or ".", "ringdown_report.png")
    path.write_bytes(keep.unpack_bytes(obj.ringdown.facts.picture))
    image = bpy.data.images.load(str(path))
    image.pack()
    path.unlink()
    if old:
        old.user_remap(image)
        bpy.data.images.remove(old)
    image.name = name
    return image


class RINGDOWN_OT_export(bpy.types.Operator):
    """Write the object as a case folder that the command line calibrates to the same numbers"""

    bl_idname = "ringdown.export"
    bl_label = "Export Case"
    bl_options = {"REGISTER"}
    directory: bpy.props.StringProperty(subtype="DIR_PATH")

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_calibration(context))

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        obj, folder = ready.target(context), Path(bpy.path.abspath(self.directory))
        try:
            surface = case_folder.write_case(context, obj, folder, whole=True)
            use_cage(obj, surface, folder)
        except (CoreError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if obj.ringdown.facts.report:
            (folder / job.REPORT).write_text(obj.ringdown.facts.report, encoding="utf-8")
        self.report({"INFO"}, f"Case written to {folder}")
        return {"FINISHED"}


class RINGDOWN_OT_export_report(bpy.types.Operator):
    """Write report.json"""

    bl_idname = "ringdown.export_report"
    bl_label = "Export Report"
    bl_options = {"REGISTER"}
    filepath: bpy.props.StringProperty(subtype="FILE_PATH", default="report.json")
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_result(context))

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        path = Path(bpy.path.abspath(self.filepath))
        try:
            path.write_text(ready.target(context).ringdown.facts.report, encoding="utf-8")
        except OSError as error:
            self.report({"ERROR"}, f"{path}: cannot be written ({error.strerror}).")
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (
    RINGDOWN_OT_calibrate,
    RINGDOWN_OT_picture,
    RINGDOWN_OT_export,
    RINGDOWN_OT_export_report,
)
