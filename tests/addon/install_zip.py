"""Install a zip of the extension into a fresh Blender, calibrate the example, bake it.

python tests/addon/install_zip.py ZIP CASE.toml       Python with bpy and nothing else of ours

A script, not a test module: it needs an environment without the development packages.
"""

import importlib
import importlib.util
import json
import os
import sys
import tempfile
from pathlib import Path


def main(archive: str, case: str) -> int:
    lent = [name for name in ("scipy", "cv2", "pytetwild") if importlib.util.find_spec(name)]
    if lent:
        sys.exit(f"This Python has {', '.join(lent)}: it would hide what the zip lacks.")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["BLENDER_USER_RESOURCES"] = folder  # before Blender looks for its folders
        import bpy

        bpy.ops.extensions.package_install_files(
            filepath=str(Path(archive).resolve()), repo="user_default", enable_on_install=True
        )
        package = "bl_ext.user_default.ringdown"
        if package not in bpy.context.preferences.addons:
            sys.exit(f"{package} is installed and not enabled.")
        work = Path(folder, "work")
        work.mkdir()
        report, picture, baked = (work / name for name in ("r.json", "r.png", "baked.blend"))
        batch = importlib.import_module(f"{package}.addon.batch")
        status = batch.main(
            [case, "--out", str(report), "--plot", str(picture), "--bake", str(baked)]
        )
        if status:
            sys.exit(f"Calibrating {case} ended with status {status}.")
        check(bpy, report, picture, baked)
        bpy.ops.preferences.addon_disable(module=package)
    return 0


def check(bpy, report: Path, picture: Path, baked: Path) -> None:
    """Exits unless all three were made and the baked object has keyed shape keys."""
    modulus = json.loads(report.read_text())["youngs_modulus"]["material"]["value"]
    if not modulus > 0 or picture.stat().st_size < 10_000:
        sys.exit(f"The report gives {modulus} Pa, the picture has {picture.stat().st_size} bytes.")
    bpy.ops.wm.open_mainfile(filepath=str(baked))
    keyed = [
        key
        for key in bpy.data.shape_keys
        if key.animation_data and key.animation_data.action and len(key.key_blocks) > 1
    ]
    if not keyed:
        sys.exit("The baked file has no object with animated shape keys.")
    version = bpy.app.version_string
    print(f"Blender {version}: installed, {modulus:.4g} Pa, {len(keyed[0].key_blocks) - 1} keys.")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
