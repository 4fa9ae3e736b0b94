"""How long a bake takes, and whether the frame rate changes what it shows. Prints two tables.

python tests/bench/bake.py      with the bpy module
"""

import importlib.util
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RATES = (12, 24, 30, 60, 120)
FREQUENCY, DAMPING = 3.0, 0.02


def extension():
    """The checkout as one package, as Blender loads it."""
    spec = importlib.util.spec_from_file_location("ringdown_extension", ROOT / "__init__.py")
    sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[spec.name])
    names = ("core.bake", "core.data", "addon.write", "addon.read")
    return [importlib.import_module(f"{spec.name}.{name}") for name in names]


bake, data, write, read = extension()


def fresh():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def grid(count: int) -> bpy.types.Object:
    """A square sheet of about `count` vertices."""
    side = round(count**0.5)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1, size=1)
    return bpy.context.object


def beam() -> bpy.types.Object:
    """A bar of 20 x 2 x 2 cm along x, held at its left end."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=20, y_subdivisions=2, size=1)
    obj = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.extrude_region_move(TRANSFORM_OT_translate={"value": (0, 0, 1)})
    bpy.ops.object.mode_set(mode="OBJECT")
    for vertex in obj.data.vertices:
        x, y, z = vertex.co
        vertex.co = (x + 0.5) * 2.0, y * 0.2, z * 0.2
    held = obj.vertex_groups.new(name="Pins")
    held.add([v.index for v in obj.data.vertices if v.co.x < 0.01], 1.0, "REPLACE")
    return obj


def ringing(obj: bpy.types.Object, modes: int = 1) -> "data.Motion":
    """Damped modes at the object's vertices, the k-th at (k + 1) times the first one's pitch."""
    rest = read.rest(obj).astype(float)
    x = (rest[:, 0] - rest[:, 0].min()) / np.ptp(rest[:, 0])
    shapes = np.zeros((len(rest), 3, modes))
    shapes[:, 2] = 0.1 * x[:, None] ** np.arange(2, modes + 2)
    times = np.arange(0, 8, 1 / (64 * modes * FREQUENCY))
    w = 2 * np.pi * FREQUENCY * np.arange(1, modes + 1) * times[:, None]
    names = tuple(f"mode {k + 1}" for k in range(modes))
    return data.Motion(names, shapes, times, np.exp(-DAMPING * w) * np.cos(w))


def timing() -> None:
    frames, fps = 250, 24
    print(
        f"A bake of {frames} frames, 100,000 vertices, 10 modes, Blender {bpy.app.version_string}"
    )
    fresh()
    obj = grid(100_000)
    motion = ringing(obj, modes=10)
    span = write.Range(first=1, last=frames)
    start = time.perf_counter()
    write.shape_keys(obj, bake.strongest(motion), span)
    seconds = time.perf_counter() - start
    print(f"  shape keys  {seconds:6.2f} s   (under 2 s is wanted)")
    write.remove(obj)
    rest = read.rest(obj).astype(float)
    block = np.ones(frames * rest.size + 8, np.float32)  # the header is eight numbers long
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.pc2")
        ours, plain = [], []
        for _ in range(10):
            ours.append(timed(lambda: bake.write_pc2(path, rest, motion, (frames, fps)), path))
            plain.append(timed(lambda: block.tofile(path), path))
    (wall, work), (wall_plain, work_plain) = (np.min(column, axis=0) for column in (ours, plain))
    print(
        f"  PC2         {wall:6.2f} s   {block.nbytes / 1e6:.0f} MB, a plain write takes ", end=""
    )
    print(f"{wall_plain:.2f} s: ratio {wall / wall_plain:.2f} by the clock, ", end="")
    print(f"{work / work_plain:.2f} by processor time   (at most 2 is wanted)")


def timed(action, path: Path) -> tuple[float, float]:
    """Seconds by the clock and of the processor; what was written goes."""
    start = time.perf_counter(), time.process_time()
    action()
    found = time.perf_counter() - start[0], time.process_time() - start[1]
    path.unlink()
    return found


def played(obj: bpy.types.Object, vertex: int, seconds: np.ndarray, fps: int) -> np.ndarray:
    """Height of a vertex at the instants, which may lie between frames."""
    found = []
    for frame in 1 + seconds * fps:
        bpy.context.scene.frame_set(int(frame), subframe=float(frame - int(frame)))
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        found.append(evaluated.data.vertices[vertex].co.z)
    return np.array(found)


def pitch(height: np.ndarray, step: float, middle: float | None = None) -> float:
    """Frequency (Hz) by zero crossings about the middle; NaN where it does not swing."""
    y = height - (np.median(height) if middle is None else middle)
    cross = np.flatnonzero(np.diff(np.sign(y)) != 0)
    if len(cross) < 3:
        return float("nan")
    at = cross + y[cross] / (y[cross] - y[cross + 1])
    return (len(at) - 1) / (2 * np.ptp(at) * step)


def soft_body(fps: int) -> float:
    """Pitch (Hz) of the same bar as Blender's soft body, dropped under its weight."""
    fresh()
    scene = bpy.context.scene
    scene.render.fps, scene.frame_end = fps, int(12 * fps)
    obj = beam()
    body = obj.modifiers.new("Softbody", "SOFT_BODY")
    own = body.settings
    own.vertex_group_goal, own.mass, own.effector_weights.gravity = "Pins", 0.01, 0.03
    own.pull, own.push, own.use_stiff_quads = 0.9, 0.9, True
    own.friction = own.damping = 0.0
    body.point_cache.frame_end = scene.frame_end
    tip = max(obj.data.vertices, key=lambda v: v.co.x).index
    height = []
    for frame in range(1, scene.frame_end + 1):
        scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        height.append(evaluated.data.vertices[tip].co.z)
    return pitch(np.array(height), 1 / fps)


def baked(fps: int, seconds: np.ndarray) -> np.ndarray:
    fresh()
    bpy.context.scene.render.fps = fps
    obj = beam()
    write.shape_keys(obj, bake.strongest(ringing(obj)))
    tip = max(obj.data.vertices, key=lambda v: v.co.x).index
    return played(obj, tip, seconds, fps)


def rates() -> None:
    seconds = np.linspace(0, 4, 481)
    truth = 0.1 * np.exp(-DAMPING * (w := 2 * np.pi * FREQUENCY * seconds)) * np.cos(w)
    print(f"\nThe same bar at every frame rate; the baked mode is {FREQUENCY:g} Hz")
    print("  frames/s   baked, Hz   largest difference   soft body, Hz")
    for fps in RATES:
        height = baked(fps, seconds)
        off = np.abs(height - height[0] + truth[0] - truth).max() / 0.1
        hertz = pitch(height - height[0] + truth[0], seconds[1], 0.0)
        print(f"  {fps:8d}   {hertz:9.3f}   {off:17.4%}    {soft_body(fps):12.2f}")


if __name__ == "__main__":
    timing()
    rates()
