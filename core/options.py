"""What stands on a command line: refusals in one line, before any work and before any file."""

import argparse
import math
import os
import re
import tomllib
from pathlib import Path

from .errors import CaseError

PICTURES = ("png", "svg", "pdf", "jpg", "jpeg", "tif", "tiff", "webp")
LONGEST = 40  # characters of what was given that a message repeats


class Parser(argparse.ArgumentParser):
    """An argument parser that raises CaseError, where argparse prints its usage and exits."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # -5,60 is a value, no option

    def error(self, message: str):
        """Raises CaseError, one line."""
        raise CaseError(f"{message.removeprefix('argument ')}. See {self.prog} --help.")


def count(text: str) -> int:
    """A number of tetrahedra. Raises argparse.ArgumentTypeError for what cannot be one."""
    good = text.isascii() and text.isdigit() and len(text) <= 7
    if not good or not 4 <= int(text) <= 1_000_000:
        shown = text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
        raise argparse.ArgumentTypeError(f'"{shown}"; a whole number of 4 to 1000000 is needed')
    return int(text)


def pair(text: str) -> tuple[float, float]:
    """U,V in pixels. Raises argparse.ArgumentTypeError for anything else."""
    try:
        u, v = (float(part) for part in text.split(","))
    except ValueError:
        u = v = math.nan
    if not (math.isfinite(u) and math.isfinite(v)):
        raise argparse.ArgumentTypeError(f'"{text[:LONGEST]}"; U,V in pixels is needed')
    return u, v


def above_zero(text: str) -> float:
    """A finite number above 0. Raises argparse.ArgumentTypeError for anything else."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f'"{text[:LONGEST]}"; a number above 0 is needed')
    return value


def check_outputs(
    outputs: dict[str, Path | None], inputs: tuple[Path, ...], *, makes: tuple[str, ...] = ()
) -> None:
    """Raises CaseError, naming the option, for an output that cannot or must not be written.

    That is one which is a folder, has none to be put into, is one of the `inputs`, or is another
    output. None: not asked for. The folders of the options `makes` need not be there yet.
    """
    taken = {_key(path): f"the input {path.name}" for path in inputs}
    for option, path in outputs.items():
        if path is None:
            continue
        if path.is_dir():
            raise CaseError(f"{option}: {path} is a folder; a file is needed. Add a file's name.")
        _check_folder(option, path, option in makes)
        there = taken.get(_key(path))
        if there is not None:
            raise CaseError(f"{option}: {path} is {there} as well. Name another file.")
        taken[_key(path)] = f"the file of {option}"


def check_picture(path: Path | None) -> None:
    """Raises CaseError where the suffix of `path` names no kind of picture."""
    if path is not None and path.suffix.lower().lstrip(".") not in PICTURES:
        raise CaseError(
            f'--plot: {path} ends in "{path.suffix}", which is no kind of picture known here. '
            f"End it in .{', .'.join(PICTURES[:-1])} or .{PICTURES[-1]}."
        )


def kept_beside(report: Path) -> Path:
    """Where the tetrahedra of the report at `report` are kept."""
    return report.with_suffix(".npz") if report.name else report


def case_files(case: Path) -> tuple[Path, ...]:
    """The case.toml (or that of the folder `case`) and the files that it names, as far as told."""
    case = case / "case.toml" if case.is_dir() else case
    try:
        table = tomllib.loads(case.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return (case,)  # whoever reads it in earnest says what is wrong
    takes = table.get("take")
    tables = [table.get("object"), table.get("recording")]
    tables += takes if isinstance(takes, list) else []
    names = [
        one[key]
        for one in tables
        if isinstance(one, dict)
        for key in ("mesh", "tracks", "video")
        if isinstance(one.get(key), str) and one[key].isprintable()
    ]
    return (case, *(case.parent / name for name in names))


def _check_folder(option: str, path: Path, made: bool) -> None:
    folder = path.absolute().parent
    while made and not folder.exists():
        folder = folder.parent
    if not folder.exists():
        raise CaseError(f"{option}: {path}: its folder does not exist. Make it, or name another.")
    if not folder.is_dir():
        raise CaseError(f"{option}: {path}: {folder} is a file, not a folder. Name another.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise CaseError(f"{option}: {path}: the folder may not be written to. Name another.")


def _key(path: Path) -> object:
    """Equal for two paths to one file, also by links or in other capitals where that is one."""
    try:
        found = path.stat()
    except OSError:
        return os.path.normcase(os.path.realpath(path))
    return found.st_dev, found.st_ino
