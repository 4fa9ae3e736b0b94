"""Make the extension's zips, one a platform, with the wheels of requirements.txt inside.

python build_extension.py [--platform linux-x64 ...] [--out dist]      Python with bpy and packaging

Wheels are fetched unmodified for the Python of each supported Blender; numpy stays out, Blender
has it. Each zip is built and validated by Blender's own tool, which comes with bpy.
"""

import argparse
import ast
import email.message
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent
PYTHONS = ("3.11", "3.13")  # Blender 4.5 LTS and 5.0; 5.1 and 5.2 LTS
LINUX = ("2_17", "2_24", "2_26", "2_27", "2_28")
PLATFORMS = {  # Blender's name: pip's tags, and what markers see
    "linux-x64": (
        ("manylinux2014_x86_64", *(f"manylinux_{version}_x86_64" for version in LINUX)),
        {"sys_platform": "linux", "platform_system": "Linux", "platform_machine": "x86_64"},
    ),
    "windows-x64": (
        ("win_amd64",),
        {"sys_platform": "win32", "platform_system": "Windows", "platform_machine": "AMD64"},
    ),
    "macos-arm64": (
        (
            *(f"macosx_{version}_0_arm64" for version in range(11, 16)),
            *(f"macosx_{version}_universal2" for version in ("10_9", "10_13", "11_0")),
        ),
        {"sys_platform": "darwin", "platform_system": "Darwin", "platform_machine": "arm64"},
    ),
}
CONTENTS = ("__init__.py", "LICENSE", "README.md", "core", "addon")
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.pyc", ".*")
BLENDERS_OWN = {
    *("bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "blf", "aud", "bl_operators", "bl_ui"),
    *("bpy_extras", "bl_math", "imbuf", "freestyle", "addon_utils", "rna_prop_ui", "numpy"),
}

FULL_TEXT_ONLY = {"cvxopt": "GPL-3.0-or-later"}  # named only within the licence's text
NOT_NEEDED = {
    "core",  # ours, under its name in a child process
    "kvxopt",  # tried where cvxopt is absent
}


def main(argv: list[str]) -> int:
    """Build the zips asked for and print their sizes."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--platform", action="append", choices=PLATFORMS)
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    parser.add_argument("--wheels", type=Path, default=ROOT / "wheels", help="kept between runs")
    options = parser.parse_args(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    for platform in options.platform or PLATFORMS:
        wheels = fetch_wheels(platform, options.wheels / platform)
        path = build(platform, wheels, options.out)
        size = path.stat().st_size / 1e6
        print(f"{path}  {size:.1f} MB, {len(wheels)} wheels, sources {sources_size(path):.2f} MB")
    return 0


def fetch_wheels(platform: str, folder: Path) -> list[Path]:
    """The pinned wheels of all Pythons, checked to be complete. Exits where one is lacking."""
    tags, facts = PLATFORMS[platform]
    wheels = set()
    for python in PYTHONS:
        mine = folder / python
        command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(mine)]
        command += ["--disable-pip-version-check", "--only-binary", ":all:", "--abi", "none"]
        command += ["--implementation", "cp", "--python-version", python, "--abi", "abi3"]
        command += ["--abi", f"cp{python.replace('.', '')}", "-r", str(ROOT / "requirements.txt")]
        for tag in tags:
            command += ["--platform", tag]
        shutil.rmtree(mine, ignore_errors=True)
        if subprocess.run(command, check=False).returncode:
            sys.exit(f"{platform}, Python {python}: a wheel of requirements.txt is lacking.")
        found = sorted(mine.glob("*.whl"))
        check_complete(found, f"{platform}, Python {python}", facts | {"python_version": python})
        wheels.update(found)
    return sorted({wheel.name: wheel for wheel in wheels}.values())


def check_complete(wheels: list[Path], where: str, facts: dict) -> None:
    """Exits unless every import of ours and every need of a wheel is in a wheel, or Blender's."""
    modules, names, needs = set(), {"numpy"}, set()
    environment = default_environment() | facts | {"extra": ""}
    for wheel in wheels:
        meta, inside = read_wheel(wheel)
        names.add(canonicalize_name(meta["Name"]))
        modules |= inside
        for line in meta.get_all("Requires-Dist") or []:
            need = Requirement(line)
            if need.marker is None or need.marker.evaluate(environment):
                needs.add(canonicalize_name(need.name))
    ours = imports_of(ROOT / "core") | imports_of(ROOT / "addon")
    lacking = ours - modules - BLENDERS_OWN - NOT_NEEDED - set(sys.stdlib_module_names)
    if lacking or needs - names:
        sys.exit(f"{where}: no wheel has {', '.join(sorted(lacking | (needs - names)))}.")


def read_wheel(wheel: Path) -> tuple[email.message.Message, set[str]]:
    """A wheel's metadata and the names that it lets one import."""
    with zipfile.ZipFile(wheel) as archive:
        files = archive.namelist()
        meta = next(name for name in files if name.endswith(".dist-info/METADATA"))
        message = email.message_from_bytes(archive.read(meta))
    return message, {name.split("/")[0].split(".")[0] for name in files}


def imports_of(folder: Path) -> set[str]:
    """Top-level names that the Python files import absolutely."""
    names = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names.add(node.module.split(".")[0])
    return names


def build(platform: str, wheels: list[Path], out: Path) -> Path:
    """A validated zip of the sources and the wheels, made by Blender's own tool."""
    manifest = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    facts = tomllib.loads(manifest)
    target = out.resolve() / f"{facts['id']}-{facts['version']}-{platform}.zip"
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder, facts["id"])
        stage.mkdir()
        for name in CONTENTS:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, stage / name, ignore=LEFT_OUT)
            elif (ROOT / name).exists():
                shutil.copy(ROOT / name, stage)
        (stage / "wheels").mkdir()
        for wheel in wheels:
            shutil.copy(wheel, stage / "wheels")
        (stage / "LICENSES.md").write_text(licences(wheels), encoding="utf-8")
        (stage / "blender_manifest.toml").write_text(
            bundled(manifest, platform, [wheel.name for wheel in wheels]), encoding="utf-8"
        )
        blender_ext("build", "--source-dir", str(stage), "--output-filepath", str(target))
    blender_ext("validate", str(target))
    return target


def bundled(manifest: str, platform: str, wheels: list[str]) -> str:
    """The manifest with the platform and the wheels in it, before its first table."""
    lines = manifest.splitlines()
    first = next((k for k, line in enumerate(lines) if line.startswith("[")), len(lines))
    listed = "".join(f'  "./wheels/{name}",\n' for name in wheels)
    return "\n".join(
        [
            *lines[:first],
            f'platforms = ["{platform}"]',
            f"wheels = [\n{listed}]",
            "",
            *lines[first:],
        ]
    )


def licences(wheels: list[Path]) -> str:
    """What is bundled, its licence and home; each wheel has its licence's text inside."""
    rows = {}
    for wheel in wheels:
        meta, _ = read_wheel(wheel)
        rows[meta["Name"]] = (
            f"| {meta['Name']} | {meta['Version']} | {licence(meta)} | {home(meta)} |"
        )
    head = "# Bundled libraries\n\nUnmodified; each wheel holds the text of its licence.\n\n"
    table = "| library | version | licence | home |\n|---|---|---|---|\n"
    return head + table + "\n".join(rows[name] for name in sorted(rows, key=str.lower)) + "\n"


def licence(meta: email.message.Message) -> str:
    """The licence's name, from whichever field the wheel fills in. Exits where none does."""
    classed = [
        line.rsplit(" :: ", 1)[-1]
        for line in meta.get_all("Classifier") or []
        if line.startswith("License ::")
    ]
    short = str(meta["License"] or "").strip()
    short = "" if "\n" in short or len(short) > 60 else short
    found = (
        meta["License-Expression"]
        or short
        or ", ".join(classed)
        or FULL_TEXT_ONLY.get(meta["Name"])
    )
    if not found:
        sys.exit(f"{meta['Name']}: its wheel does not name its licence.")
    return found


def home(meta: email.message.Message) -> str:
    """The library's address, from whichever field the wheel fills in."""
    links = dict(line.split(", ", 1) for line in meta.get_all("Project-URL") or [])
    by_name = {name.lower(): link for name, link in links.items()}
    keys = ("homepage", "repository", "source", "source code", "github", "download")
    found = [by_name[key] for key in keys if key in by_name]
    return meta["Home-page"] or next(iter([*found, *links.values()]), "")


def blender_ext(*arguments: str) -> None:
    """Run Blender's own extension tool. Exits with its words where it fails."""
    import bpy  # only to find the tool

    scripts = Path(bpy.utils.system_resource("SCRIPTS"))
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    done = subprocess.run(
        [sys.executable, str(tool), *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"blender_ext.py {arguments[0]}: {done.stdout}{done.stderr}")


def sources_size(path: Path) -> float:
    """MB in the zip that are not wheels."""
    with zipfile.ZipFile(path) as archive:
        return (
            sum(one.compress_size for one in archive.infolist() if "wheels/" not in one.filename)
            / 1e6
        )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
