"""tracks.csv: a header, then one row a frame, NAME.x .y .z in metres or NAME.u .v in pixels."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .case_fields import suggestion
from .data import seal
from .errors import CaseError

AXES = {3: "xyz", 2: "uv"}
FEWEST_FRAMES = 3
MOST = {3: (1e6, "m"), 2: (1e9, "px")}  # by number of axes: beyond it, no camera saw it
LONGEST = 1e9  # s
WRITTEN = range(2, 8)  # decimals that instants may be written to


@dataclass(frozen=True, eq=False)
class Tracks:
    """What a tracks file holds for the markers asked of it."""

    time: np.ndarray | None  # (T,) s, ascending; None: the file has no column `time`
    values: np.ndarray  # (T, n, d) m (d = 3) or px (d = 2); NaN = missing
    warnings: tuple[str, ...] = ()

    def __post_init__(self):
        seal(self, "values", float, (None, None, None), finite=False)


def read_tracks(path: str | Path, names: tuple[str, ...]) -> Tracks:
    """The columns of the markers `names`, in their order.

    Raises CaseError, naming row and column, for a file that is absent or not a table, a missing or
    repeated column, text in a cell, times that go back, fewer than three frames, a marker without
    samples, and tracks in which nothing moves.
    """
    path = Path(path)
    header, rows = _read_rows(path)
    columns, dimension = _marker_columns(path, header, names)
    wanted = [header.index("time")] if "time" in header else []
    first = len(wanted)
    wanted += [header.index(column) for column in columns]
    limits = [(LONGEST, "s")] * first + [MOST[dimension]] * len(columns)
    numbers = _numbers(path, header, rows, dict(zip(wanted, limits, strict=True)))
    if len(numbers) < FEWEST_FRAMES:
        raise CaseError(
            f"{path.name}: {len(numbers)} frames; {FEWEST_FRAMES} at the very least are needed, "
            "and several periods to learn something. Record longer."
        )
    time = _check_time(path, numbers[:, 0], rows) if first else None
    values = numbers[:, first:].reshape(len(numbers), len(names), dimension)
    _check_samples(path, values, names)
    return Tracks(time, values, _ignored(path, header, columns))


def _read_rows(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The header, and (line number, cells) of every row that is not blank; without a column `time`
    a row of empty cells is a frame in which nothing was seen, but for those at the end.
    """
    if not path.is_file():
        near = suggestion(path.name, [one.name for one in path.parent.glob("*.csv")] or ["no .csv"])
        raise CaseError(f"{path.name}: there is no such file in {path.parent}. {near}")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise CaseError(
            f"{path.name}: not a text table ({error}). Save the tracks as comma-separated text."
        ) from error
    lines = [(number, row) for number, row in lines if len(row) > 1 or any(row)]
    while lines and not any(lines[-1][1]):
        lines.pop()
    while lines and not any(lines[0][1]):
        lines.pop(0)
    if not lines:
        raise CaseError(f"{path.name}: it is empty; a header and one row a frame are needed.")
    header = lines[0][1]
    if "time" in header:
        lines = [(number, row) for number, row in lines if any(row)]
    if len(header) == 1 and ";" in header[0]:
        raise CaseError(f"{path.name}: the cells are parted by semicolons; save it with commas.")
    for number, row in lines[1:]:
        if len(row) != len(header):
            raise CaseError(
                f"{path.name}, line {number}: {len(row)} cells where the header has "
                f"{len(header)}. Leave a missing sample's cell empty, but keep its comma."
            )
    return header, lines[1:]


def _marker_columns(path: Path, header: list[str], names: tuple[str, ...]) -> tuple[list[str], int]:
    """The column names, marker by marker, and the number of axes."""
    twice = sorted({one for one in header if one and header.count(one) > 1})
    if twice:
        raise CaseError(f"{path.name}: the column {twice[0]} stands there twice. Remove one.")
    sets = {d: [f"{name}.{axis}" for name in names for axis in AXES[d]] for d in AXES}
    dimension = max(AXES, key=lambda d: sum(one in header for one in sets[d]) / len(sets[d]))
    for column in sets[dimension]:
        if column not in header:
            others = [one for one in header if one not in sets[dimension] and one != "time"]
            near = suggestion(column, others)
            raise CaseError(f"{path.name}: the column {column} is missing. {near}")
    return sets[dimension], dimension


def _numbers(path: Path, header: list[str], rows, wanted: dict[int, tuple]) -> np.ndarray:
    """(T, columns) numbers of the `wanted` columns (largest, unit), NaN where a cell is empty."""
    table = np.full((len(rows), len(wanted)), np.nan)
    for r, (line, row) in enumerate(rows):
        for c, (index, limit) in enumerate(wanted.items()):
            where = f"{path.name}, line {line}, column {header[index]}"
            table[r, c] = _cell(row[index], where, limit)
    return table


def _cell(cell: str, where: str, limit: tuple[float, str]) -> float:
    if cell == "":
        return np.nan
    try:
        value = float(cell.replace("_", "?"))  # Python would read 1_0 as ten
    except ValueError as error:
        raise CaseError(
            f'{where}: "{cell}" is not a number. Leave the cell empty for a missing sample.'
        ) from error
    if not np.isfinite(value):
        raise CaseError(f"{where}: {cell} is not a finite number. Leave the cell empty instead.")
    if abs(value) > limit[0]:
        raise CaseError(
            f"{where}: {cell} is beyond {limit[0]:g} {limit[1]}, no measurement. Correct the cell, "
            "or leave it empty."
        )
    return value


def _check_time(path: Path, time: np.ndarray, rows) -> np.ndarray:
    missing = np.flatnonzero(np.isnan(time))
    if missing.size:
        raise CaseError(
            f"{path.name}, line {rows[missing[0]][0]}: the time is empty. Fill it in, or leave the "
            "column out and give capture_fps."
        )
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        k = back[0] + 1
        raise CaseError(
            f"{path.name}, line {rows[k][0]}: the time {time[k]:g} s comes after {time[k - 1]:g} s;"
            " it must grow from row to row. Sort the rows, drop doubled ones."
        )
    return unrounded(time)


def unrounded(time: np.ndarray) -> np.ndarray:
    """Instants (T,) s as the frames' own where only how they were written sets them off these.

    A step of 1/60 s written to the millisecond would shake a motion by more than its noise.
    """
    if len(time) < 3:
        return time
    for digits in WRITTEN:
        written = np.round(time, digits)
        if np.abs(written - time).max() < 1e-9:
            break
    else:
        return time
    frame = np.cumsum(np.r_[0, np.maximum(np.round(np.diff(time) / np.median(np.diff(time))), 1)])
    even = np.polyval(np.polyfit(frame, time, 1), frame)
    off = np.abs(even - time).max()
    return even if 1e-9 < off <= 0.51 * 10.0**-digits else time


def _check_samples(path: Path, values: np.ndarray, names: tuple[str, ...]) -> None:
    whole = np.isfinite(values).all(axis=2)  # a sample lacks nothing
    if not whole.any():
        raise CaseError(f"{path.name}: every sample is missing. Track the markers again.")
    for name, count in zip(names, whole.sum(axis=0), strict=True):
        if count < FEWEST_FRAMES:
            raise CaseError(
                f"{path.name}: the marker {name} has {count} samples; {FEWEST_FRAMES} at the very "
                "least are needed. Track it again, or take its [[marker]] out."
            )
    if (np.nanmax(values, axis=0) == np.nanmin(values, axis=0)).all():
        raise CaseError(
            f"{path.name}: no marker moves, all its values are constant. Choose a recording of the "
            "object wobbling."
        )


def _ignored(path: Path, header: list[str], columns: list[str]) -> tuple[str, ...]:
    extra = [one for one in header if one not in columns and one != "time" and one]
    if not extra:
        return ()
    some = ", ".join(extra[:6]) + (", ..." if len(extra) > 6 else "")
    return (f"{path.name}: columns of no [[marker]], left out: {some}.",)
