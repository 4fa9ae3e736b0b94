"""Tracks that other programs wrote, as arrays in pixels: u right, v down, NaN where missing.

Blender's own (a table with name, frame, x, y in shares of the picture, origin bottom left), Tracker
(physlets.org/tracker: one table a point, t, x, y) and DeepLabCut's wide form (three header rows:
scorer, bodyparts, coords).
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .case_fields import suggestion
from .data import seal
from .errors import RecordingError
from .tracks_csv import Tracks

PAIRS = (["x", "y"], ["pixelx", "pixely"])  # the second are Tracker's own pixels
LIKELY = 0.6  # DeepLabCut's own customary cut: a sample below it was guessed


@dataclass(frozen=True, eq=False)
class ImportedTracks:
    """What the table holds."""

    names: tuple[str, ...]  # n
    values: np.ndarray  # (T, n, 2) px, or the table's own unit where Tracker was calibrated
    frames: np.ndarray | None = None  # (T,) frame numbers, where they are given
    time: np.ndarray | None = None  # (T,) s, where given
    kind: str = ""  # "blender" | "tracker" | "deeplabcut"

    def __post_init__(self):
        seal(self, "values", float, (None, len(self.names), 2), finite=False)


def foreign(path: Path) -> bool:
    """Whether the table at `path` has the form of one of the three programs."""
    try:
        return _kind(_rows(path)) != ""
    except RecordingError:
        return False


def tracks_of(path: Path, names: tuple[str, ...], size, rate: float | None) -> Tracks:
    """Another program's table as tracks (T, n, 2) px of the markers `names`, in their order.

    Frame numbers become seconds by `rate` frames/s, so that missing rows are gaps in time. Raises
    RecordingError as `import_tracks`, and for a marker that the table lacks.
    """
    found = import_tracks(path, size)
    for name in names:
        if name not in found.names:
            raise RecordingError(
                f"{path.name}: no track is named {name}. {suggestion(name, found.names)}"
            )
    time = found.time
    if time is None and rate is not None and found.frames is not None:
        time = (found.frames - found.frames[0]) / rate
    others = [name for name in found.names if name not in names]
    said = (f"{path.name}: tracks of no [[marker]], left out: {', '.join(others)}.",)
    values = found.values[:, [found.names.index(name) for name in names]]
    return Tracks(time, values, said if others else ())


def import_tracks(path: str | Path, size: tuple[int, int] | None = None) -> ImportedTracks:
    """The tracks in the CSV at `path`, whichever of the three programs wrote it.

    `size` (width, height) px of the picture, needed for Blender's. Raises RecordingError for a
    file that is absent, empty, of no known form, or has text where a number is needed.
    """
    path = Path(path)
    rows = _rows(path)
    kind = _kind(rows)
    if kind in ("deeplabcut", "blender"):
        _check_lengths(path, rows)
    if kind == "deeplabcut":
        return _deeplabcut(path, rows)
    if kind == "blender":
        return _blender(path, rows, [cell.strip().lower() for cell in rows[0]], size)
    if kind == "tracker":
        return _tracker(path, rows, next(k for k in range(3) if _is_tracker(rows[k])))
    raise RecordingError(
        f"{path.name}: its header is {', '.join(rows[0][:6])}; tracks of Blender (name, frame, x, "
        "y), Tracker (t, x, y) or DeepLabCut (scorer, bodyparts, coords) are known. Rename columns."
    )


def blender_pixels(shares: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """(..., 2) px of Blender's marker coordinates, shares of the picture from its bottom left.

    Blender counts from the picture's corner, pixels here from the centre of the first one.
    """
    width, height = size
    shares = np.asarray(shares, float)
    return np.stack([shares[..., 0] * width - 0.5, (1 - shares[..., 1]) * height - 0.5], -1)


def _kind(rows) -> str:
    head = [cell.strip().lower() for cell in rows[0]]
    if head[0] == "scorer" or (len(rows) > 2 and rows[1][0].strip().lower() == "bodyparts"):
        return "deeplabcut"
    if {"name", "frame", "x", "y"} <= set(head):
        return "blender"
    return "tracker" if any(_is_tracker(cells) for cells in rows[:3]) else ""


def _rows(path: Path) -> list[list[str]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise RecordingError(f"{path}: there is no such file. Give a CSV of tracks.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path.name}: cannot be read ({error}). Save it as UTF-8.") from error
    lines = [line for line in text.splitlines() if line.strip()]
    separator = next((mark for mark in ("\t", ";") if lines and mark in lines[0]), ",")
    try:
        rows = [row for row in csv.reader(lines, delimiter=separator) if any(map(str.strip, row))]
    except csv.Error as error:
        raise RecordingError(f"{path.name}: no table ({error}). Export it again.") from error
    if len(rows) < 2:
        raise RecordingError(f"{path.name}: {len(rows)} rows; a header and samples are needed.")
    return rows


def _check_lengths(path: Path, rows) -> None:
    for k, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise RecordingError(
                f"{path.name}, row {k + 1}: {len(row)} cells, {len(rows[0])} as in the first row "
                "are needed. Export it again."
            )


def _number(path: Path, cell: str, where: str) -> float:
    text = cell.strip()
    if not text or text.lower() in ("nan", "none", "null"):
        return np.nan
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise RecordingError(
            f'{path.name}, {where}: "{text}" is not a number. Empty the cell where a sample is '
            "missing."
        ) from None


def _deeplabcut(path: Path, rows) -> ImportedTracks:
    first = [row[0].strip().lower() for row in rows]
    top = first.index("bodyparts") if "bodyparts" in first else len(rows)
    if first[top + 1 : top + 2] != ["coords"] or len(rows) < top + 3:
        raise RecordingError(
            f"{path.name}: rows named bodyparts and coords, and samples below, are needed in "
            "DeepLabCut's form. Export it again."
        )
    parts, kinds = rows[top][1:], [cell.strip().lower() for cell in rows[top + 1][1:]]
    names = tuple(dict.fromkeys(part.strip() for part in parts))
    table = np.array(
        [
            [_number(path, cell, f"row {top + 3 + k}") for cell in row[: len(parts) + 1]]
            for k, row in enumerate(rows[top + 2 :])
        ]
    )
    column = {
        (p.strip(), kind): 1 + k for k, (p, kind) in enumerate(zip(parts, kinds, strict=True))
    }
    missing = [f"{n} {axis}" for n in names for axis in "xy" if (n, axis) not in column]
    if missing:
        raise RecordingError(f"{path.name}: the column {missing[0]} is missing. Export it again.")
    values = np.stack([table[:, [column[n, "x"], column[n, "y"]]] for n in names], axis=1)
    for k, name in enumerate(names):
        if (name, "likelihood") in column:
            values[table[:, column[name, "likelihood"]] < LIKELY, k] = np.nan
    return ImportedTracks(names, values, frames=table[:, 0], kind="deeplabcut")


def _blender(path: Path, rows, head, size) -> ImportedTracks:
    if size is None:
        raise RecordingError(
            f"{path.name}: Blender's coordinates are shares of the picture. Give its size in px."
        )
    column = {name: head.index(name) for name in ("name", "frame", "x", "y")}
    mute = head.index("mute") if "mute" in head else None
    names = tuple(dict.fromkeys(row[column["name"]].strip() for row in rows[1:]))
    samples = {}
    for k, row in enumerate(rows[1:]):
        where = f"row {k + 2}"
        frame = _number(path, row[column["frame"]], where)
        if not np.isfinite(frame):
            raise RecordingError(f"{path.name}, {where}: the frame's number is missing. Put it in.")
        place = [_number(path, row[column[axis]], where) for axis in "xy"]
        if mute is None or row[mute].strip().lower() not in ("1", "true", "yes"):
            samples[frame, row[column["name"]].strip()] = place
    if not samples:
        raise RecordingError(f"{path.name}: every sample is muted. Unmute what is right.")
    frames = np.array(sorted({frame for frame, _ in samples}))
    gap = [np.nan, np.nan]
    shares = np.array([[samples.get((frame, name), gap) for name in names] for frame in frames])
    pixels = blender_pixels(shares.reshape(len(frames), len(names), 2), size)
    return ImportedTracks(names, pixels, frames=frames, kind="blender")


def _is_tracker(cells) -> bool:
    names = [cell.strip().lower() for cell in cells]
    return names[0] in ("t", "frame", "time") and names[1:3] in PAIRS


def _tracker(path: Path, rows, head: int) -> ImportedTracks:
    """Columns t, x, y [, x, y ...]; a row above the header may name the points.

    Tracker itself puts one point's name above the time.
    """
    titles = [cell.strip().lower() for cell in rows[head]]
    us = [k for k in range(1, len(titles) - 1) if titles[k : k + 2] in PAIRS]
    above = [cell.strip() for cell in rows[head - 1]] if head else []
    if above and not any(above[1:]):
        above[1:2] = [above[0]]
    names = tuple(
        (above[u] if u < len(above) and above[u] else f"point_{k + 1}") for k, u in enumerate(us)
    )
    body = [row + [""] * (len(titles) - len(row)) for row in rows[head + 1 :]]
    table = np.array(
        [
            [_number(path, cell, f"row {head + 2 + k}") for cell in row[: len(titles)]]
            for k, row in enumerate(body)
        ]
    )
    values = np.stack([table[:, u : u + 2] for u in us], axis=1)
    counted = titles[0] == "frame"
    return ImportedTracks(
        names,
        values,
        frames=table[:, 0] if counted else None,
        time=None if counted else table[:, 0],
        kind="tracker",
    )
