"""What the panel keeps, on the object: it travels with save, copy and append."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .choices import SCALES, SOURCES, VIEWS

HIDDEN = {"HIDDEN"}
RELATIVE = {"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"}


def _meshes_only(_self, obj):
    return obj.type == "MESH"


class RINGDOWN_PG_point(bpy.types.PropertyGroup):
    """A point that was followed in the recording, and where it sits on the mesh."""

    name: StringProperty(name="Track", description="Column of the table, or track of the clip")
    position: FloatVectorProperty(
        name="Place", description="On the object: metres in its own axes", precision=5
    )
    placed: BoolProperty(name="Placed", description="Whether its place on the mesh is known")
    support: BoolProperty(
        name="On Support", description="Sits on what holds the object: shows the support's motion"
    )


class RINGDOWN_PG_material(bpy.types.PropertyGroup):
    """What is known of the stuff."""

    name: StringProperty(name="Material", default="")
    source: StringProperty(name="Source", options=HIDDEN)
    density: FloatProperty(
        name="Density",
        description="Mass per volume in kg/m³. Weigh the object and divide by its volume",
        default=1000.0,
        min=1.0,
        max=30_000.0,
        soft_max=3000.0,
        precision=0,
        step=1000,
    )
    poisson_ratio: FloatProperty(
        name="Poisson Ratio",
        description="0.5 keeps its volume when squeezed, 0 does not bulge. Rubbers: 0.48 to 0.499",
        default=0.48,
        min=0.0,
        max=0.4999,
        precision=3,
        step=1,
    )
    modulus: FloatProperty(
        name="Expected Modulus",
        description="Young's modulus in kPa to compare with, 0 when unknown. "
        "The result does not depend on it",
        default=0.0,
        min=0.0,
        precision=1,
        step=1000,
    )


class RINGDOWN_PG_recording(bpy.types.PropertyGroup):
    """What was filmed, how fast, and from where."""

    source: EnumProperty(name="Source", items=SOURCES, default="CLIP")
    path: StringProperty(
        name="Table", description="Tracks as .csv", subtype="FILE_PATH", options=RELATIVE
    )
    clip: PointerProperty(
        name="Clip", description="The film as a movie clip", type=bpy.types.MovieClip
    )
    capture_fps: FloatProperty(
        name="Capture Rate",
        description="Frames per second of real time. A slow-motion clip plays slower than this",
        default=240.0,
        min=0.001,
        max=1e6,
        soft_min=24.0,
        soft_max=2000.0,
        precision=2,
        step=100,
    )
    own_start: BoolProperty(
        name="Set Release", description="Say when the object is let go; else it is found"
    )
    own_stop: BoolProperty(
        name="Set Stop", description="Say until when the object swings freely; else it is found"
    )
    start: FloatProperty(
        name="Release",
        description="First instant of free motion",
        unit="TIME_ABSOLUTE",
        precision=3,
    )
    stop: FloatProperty(
        name="Stop", description="End of the free motion", unit="TIME_ABSOLUTE", precision=3
    )
    scale: EnumProperty(name="Scale By", items=SCALES, default="POINTS")
    view: EnumProperty(
        name="View", description="Which side of the object the film shows", items=VIEWS
    )
    length: FloatProperty(
        name="Length", description="A true length", unit="LENGTH", default=0.1, min=1e-6
    )
    length_px: FloatProperty(
        name="Seen As",
        description="The same length in the picture, in pixels",
        default=100.0,
        min=1.0,
    )
    gravity: BoolProperty(
        name="Bends It",
        description="The scene's gravity bends the object and stiffens or softens it",
    )
    unloaded: BoolProperty(
        name="Mesh Has No Sag",
        description="The mesh is the shape free of its weight; off: as it hangs at rest",
    )
    case_file: StringProperty(
        name="Case",
        description="A case.toml that also gives loads, takes and the camera",
        subtype="FILE_PATH",
        options=RELATIVE,
    )
    frames: IntProperty(options=HIDDEN)
    found: StringProperty(options=HIDDEN)  # what the last look at the recording told, one line
    solid: BoolProperty(options=HIDDEN)  # tracks in metres: no camera is needed
    timed: BoolProperty(options=HIDDEN)  # the table says its own time


class RINGDOWN_PG_facts(bpy.types.PropertyGroup):
    """What operators have worked out, so that drawing need not."""

    look: StringProperty(options=HIDDEN)  # the mesh that this holds for
    size: FloatVectorProperty(options=HIDDEN)  # m, of the box about the rest shape
    volume: FloatProperty(options=HIDDEN)  # m3
    closed: BoolProperty(options=HIDDEN)
    pins: StringProperty(options=HIDDEN)  # area and share, and the warning for small ones
    pins_small: BoolProperty(options=HIDDEN)
    cage: StringProperty(options=HIDDEN)  # nodes and tets as text
    cage_look: StringProperty(options=HIDDEN)
    cage_says: StringProperty(options=HIDDEN)
    report: StringProperty(options=HIDDEN)  # report.json
    motion: StringProperty(options=HIDDEN)  # motion.npz as text, with the calibrated surface
    picture: StringProperty(options=HIDDEN)  # png as text


class RINGDOWN_PG_bake(bpy.types.PropertyGroup):
    """How the wobble is played."""

    motion: EnumProperty(
        name="Motion",
        items=(
            ("RECORDED", "Recorded", "The ring-down of the film"),
            ("PLUCKED", "Plucked", "Pull one vertex, and let go"),
        ),
    )
    target: EnumProperty(
        name="To",
        items=(
            ("KEYS", "Keys", "One shape key per mode with editable curves"),
            ("CACHE", "Cache", "A PC2 file with every vertex at every frame"),
        ),
    )
    first: IntProperty(name="Release Frame", description="Where the wobble begins", default=1)
    to_end: BoolProperty(name="To the End", description="Until the motion ends", default=True)
    last: IntProperty(name="Last Frame", default=250)
    amplitude: FloatProperty(
        name="Amplitude", description="1: as large as filmed", default=1.0, min=0.0, soft_max=3.0
    )
    count: IntProperty(name="Modes", description="The strongest so many", default=10, min=1, max=64)
    vertex: IntProperty(name="Vertex", description="The vertex that is pulled", default=-1, min=-1)
    pull: FloatVectorProperty(
        name="Pull",
        description="How far and where to, in the object's own axes",
        default=(0.0, 0.0, 0.01),
        unit="LENGTH",
    )


class RINGDOWN_PG_object(bpy.types.PropertyGroup):
    """All of it, as `object.ringdown`."""

    material: PointerProperty(type=RINGDOWN_PG_material)
    recording: PointerProperty(type=RINGDOWN_PG_recording)
    facts: PointerProperty(type=RINGDOWN_PG_facts)
    bake: PointerProperty(type=RINGDOWN_PG_bake)
    points: CollectionProperty(type=RINGDOWN_PG_point)
    point: IntProperty(name="Point", options=HIDDEN)
    elements: IntProperty(
        name="Tetrahedra",
        description="How finely the body is cut. More is truer and slower",
        default=1500,
        min=100,
        max=200_000,
        soft_min=500,
        soft_max=20_000,
        step=500,
    )
    pins: StringProperty(name="Pins", description="The vertex group that is held")
    show_cage: BoolProperty(name="Show Cage", description="Draw the tetrahedra", default=True)
    show_pins: BoolProperty(name="Show Pins", description="Draw the held vertices", default=True)
    show_ghost: BoolProperty(
        name="Show Markers",
        description="Draw the measured and the predicted place of each point at this frame",
    )


CLASSES = (
    RINGDOWN_PG_point,
    RINGDOWN_PG_material,
    RINGDOWN_PG_recording,
    RINGDOWN_PG_facts,
    RINGDOWN_PG_bake,
    RINGDOWN_PG_object,
)


def overridable(group: type) -> None:
    """Every property of the group may be changed on a library override, and is then kept."""
    for deferred in group.__annotations__.values():
        rules = {"LIBRARY_OVERRIDABLE"}
        if deferred.function is CollectionProperty:
            rules.add("USE_INSERTION")
        deferred.keywords["override"] = rules


def register():
    for one in CLASSES:
        overridable(one)
        bpy.utils.register_class(one)
    bpy.types.Object.ringdown = PointerProperty(
        type=RINGDOWN_PG_object, override={"LIBRARY_OVERRIDABLE"}
    )
    bpy.types.WindowManager.ringdown_short = BoolProperty(
        name="Result Only",
        description="Hide the steps that lead to the result",
        options={"SKIP_SAVE"},
    )
    bpy.types.Scene.ringdown_object = PointerProperty(
        name="Object",
        description="The mesh to calibrate; empty: the active one",
        type=bpy.types.Object,
        poll=_meshes_only,
    )


def unregister():
    del bpy.types.Scene.ringdown_object
    del bpy.types.WindowManager.ringdown_short
    del bpy.types.Object.ringdown
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
