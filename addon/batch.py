"""Calibrate and bake without a window.

blender -b [FILE.blend] --python addon/batch.py -- CASE.toml --out report.json [--bake baked.blend]
python addon/batch.py -- CASE.toml ...      with the bpy module
blender -c ringdown CASE.toml ...           with the extension enabled
"""

import sys
from pathlib import Path

if __package__ in (None, ""):  # run as a file: Blender gives scripts no package to import from
    import importlib.util

    root = Path(__file__).resolve().parents[1]
    spec = importlib.util.spec_from_file_location("ringdown_extension", root / "__init__.py")
    sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[spec.name])
    batch = importlib.import_module("ringdown_extension.addon.batch")
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    sys.exit(batch.main(given))

import tempfile
import tomllib
from argparse import Namespace

import bpy

from ..core import bake
from ..core.command import main as core_main
from ..core.errors import CoreError
from ..core.options import Parser, case_files, check_outputs, count, kept_beside
from ..core.surface import read_surface
from . import write
from .marks import RECORD
from .mesh import new_object


def main(argv: list[str]) -> int:
    """Exit status 0: done. 2: refused, one line on standard error."""
    try:
        options = _parse(argv)
        _check_outputs(options)
        _object(options.object, ())  # before a minute of work, not after
    except CoreError as error:
        print(f"ringdown: {error}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        motion = Path(folder, "motion.npz")
        arguments = ["calibrate", str(options.case), "--out", str(options.out)]
        arguments += ["--motion", str(motion)] if options.bake else []
        arguments += ["--plot", str(options.plot)] if options.plot else []
        arguments += ["--elements", str(options.elements)] if options.elements else []
        status = core_main(arguments)
        if status or not options.bake:
            return status
        try:
            _bake(options, bake.load_motion(motion)[0])
        except CoreError as error:
            print(f"ringdown: {error}", file=sys.stderr)
            return 2
    return 0


def _parse(argv: list[str]) -> Namespace:
    parser = Parser(prog="blender -c ringdown", description=__doc__.split("\n")[0])
    parser.add_argument("case", type=Path, metavar="CASE.toml")
    parser.add_argument("--out", type=Path, required=True, metavar="report.json")
    parser.add_argument("--plot", type=Path, metavar="report.png")
    parser.add_argument("--bake", type=Path, metavar="baked.blend")
    parser.add_argument("--object", metavar="NAME", help="bake onto this object of the open file")
    parser.add_argument("--elements", type=count, metavar="N", help="tetrahedra")
    parser.add_argument("--modes", type=int, metavar="N", help="bake the N strongest only")
    parser.add_argument("--start", type=int, default=1, metavar="FRAME", help="of the release")
    return parser.parse_args(argv)


def _check_outputs(options: Namespace) -> None:
    outputs = {"--out": options.out, "the tetrahedra kept beside --out": kept_beside(options.out)}
    outputs |= {"--plot": options.plot, "--bake": options.bake}
    check_outputs(outputs, case_files(options.case), makes=("--bake",))


def _bake(options: Namespace, motion: bake.Motion) -> None:
    if not bpy.data.filepath:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    surface, names = _surface(options.case)
    obj = _object(options.object, names)
    new = obj is None
    if new:
        obj = new_object(bpy.context, names[0], surface)
    span = write.Range(first=options.start, count=options.modes)
    write.shape_keys(obj, write.place(obj, surface, motion, span), span)
    if new:  # nobody's frame range yet
        bpy.context.scene.frame_start = options.start
        bpy.context.scene.frame_end = obj[RECORD]["last"]
    target = options.bake.resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(target), copy=True)
    print(f"Baked {obj.name} into {options.bake}")


def _surface(case: Path) -> tuple:
    """The case's surface (m), and the names by which a file may know its object."""
    path = case / "case.toml" if case.is_dir() else case
    fields = tomllib.loads(path.read_text(encoding="utf-8"))
    body = fields["object"]
    mesh = path.parent / body["mesh"]
    return read_surface(mesh, body.get("length_unit", "m")), (mesh.stem, fields["name"])


def _object(wanted: str | None, names: tuple) -> bpy.types.Object | None:
    """The object asked for, or one named as the case or its mesh; None when there is none."""
    meshes = {obj.name: obj for obj in bpy.context.scene.objects if obj.type == "MESH"}
    if wanted and wanted not in meshes:
        known = ", ".join(sorted(meshes)) or "none"
        raise CoreError(f'--object: the file has no mesh "{wanted}". It has: {known}.')
    return next((meshes[name] for name in (wanted, *names) if name in meshes), None)
