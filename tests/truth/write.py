"""The case folder: case.toml, surface, tracks."""

from pathlib import Path

import numpy as np


def toml(value) -> str:
    """One TOML value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(f"{float(value):.9g}"))


def section(title: str, entries: dict) -> str:
    return "\n".join([title, *(f"{k} = {toml(v)}" for k, v in entries.items()), ""])


def case(folder: Path, head: dict, tables: list) -> None:
    """Write case.toml: `head` first, then (title, entries) in order."""
    text = [*(f"{k} = {toml(v)}" for k, v in head.items()), ""]
    text += [section(title, entries) for title, entries in tables if entries]
    (folder / "case.toml").write_text("\n".join(text), encoding="utf-8")


def surface(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    lines = ["v {:.7g} {:.7g} {:.7g}".format(*v) for v in vertices]
    lines += ["f {} {} {}".format(*(t + 1)) for t in triangles]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def tracks(path: Path, names: list, values: np.ndarray, time=None) -> None:
    """values (T, n, d); NaN becomes an empty cell; `time` (T,) s or None = no such column."""
    axes = "xyz" if values.shape[2] == 3 else "uv"
    digits = 8 if values.shape[2] == 3 else 4
    head = [f"{name}.{a}" for name in names for a in axes]
    rows = []
    for n, row in enumerate(values.reshape(len(values), -1)):
        cells = ["" if np.isnan(x) else f"{x:.{digits}f}" for x in row]
        rows.append(",".join(([f"{time[n]:.6f}"] if time is not None else []) + cells))
    head = (["time"] if time is not None else []) + head
    path.write_text(",".join(head) + "\n" + "\n".join(rows) + "\n", encoding="ascii")
