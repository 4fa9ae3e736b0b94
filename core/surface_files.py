"""The three surface formats: .obj, .stl and .ply, in the file's own numbers.

Each reader returns vertices (V, 3) and triangles (F, 3); a polygon becomes a fan. Vertices of
.obj and .ply keep the file's order, because pins name them by index; .stl has no vertices of its
own, so equal corners become one, numbered in the order in which they first appear.

Sources     Wavefront, Object Files, appendix B1; the PLY format, G. Turk 1994; StL, 3D Systems 1989
"""

from pathlib import Path

import numpy as np

from .errors import MeshError

PLY_TYPES = {
    **{"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2"},
    **{"ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4"},
    **{"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"},
}


def fan(polygons: list[list[int]]) -> np.ndarray:
    """Triangles (F, 3) of polygons, each cut from its first corner."""
    triangles = [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def read_obj(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """`v` and `f` lines; normals, texture, groups and lines are passed over."""
    vertices, polygons = [], []
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for line in text.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append([float(w) for w in words[1:4]])
        elif words[0] == "f":
            corners = [int(w.split("/", 1)[0]) for w in words[1:]]
            polygons.append([c - 1 if c > 0 else c + len(vertices) for c in corners])
    return np.array(vertices, float).reshape(-1, 3), fan(polygons)


def weld(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Loose triangles (F, 3, 3) to vertices in order of appearance, and faces."""
    flat = corners.reshape(-1, 3) + 0.0  # -0.0 and 0.0 are one place
    _, first, same = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), int)
    rank[np.argsort(first)] = np.arange(len(first))
    return flat[np.sort(first)], rank[same.reshape(-1)].reshape(-1, 3)


def read_stl(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Binary when the length fits the count in the header, else ascii."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "u2")])
        return weld(np.frombuffer(data, record, offset=84)["corners"].astype(float))
    if not data.lstrip().startswith(b"solid"):
        raise ValueError(f"{len(data)} bytes do not hold the {count} triangles of its header")
    rows = [line.split()[1:4] for line in data.splitlines() if line.split()[:1] == [b"vertex"]]
    return weld(np.array(rows, float).reshape(-1, 3, 3))


def ply_header(lines: list[str]) -> tuple[str, list[tuple[str, int, list[list[str]]]]]:
    """Its encoding, and the elements (name, count, properties as words)."""
    encoding, elements = "", []
    for words in (line.split() for line in lines):
        if words[:1] == ["format"]:
            encoding = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f'its format is "{encoding}"')
    return encoding, elements


def binary_rows(data: bytes, count: int, properties: list[list[str]], order: str):
    """Rows of one binary element as lists, and the bytes after them."""
    if all(p[0] != "list" for p in properties):
        record = np.dtype([(p[1], order + PLY_TYPES[p[0]]) for p in properties])
        rows = np.frombuffer(data, record, count)
        return [rows[p[1]] for p in properties], data[count * record.itemsize :]
    columns, at = [[] for _ in properties], 0
    for _ in range(count):
        for column, words in zip(columns, properties, strict=True):
            length = 1
            if words[0] == "list":
                kind = np.dtype(order + PLY_TYPES[words[1]])
                length = int(np.frombuffer(data, kind, 1, at)[0])
                at += kind.itemsize
            kind = np.dtype(order + PLY_TYPES[words[-2]])
            column.append(np.frombuffer(data, kind, length, at).tolist())
            at += length * kind.itemsize
    return columns, data[at:]


def ascii_rows(lines: list[str], count: int, properties: list[list[str]]):
    """Rows of one ascii element as columns, and the lines after them."""
    columns = [[] for _ in properties]
    for line in lines[:count]:
        words, at = line.split(), 0
        for column, kind in zip(columns, properties, strict=True):
            if kind[0] == "list":
                length = int(words[at])
                column.append([int(float(w)) for w in words[at + 1 : at + 1 + length]])
                at += 1 + length
            else:
                column.append(float(words[at]))
                at += 1
    return columns, lines[count:]


def read_ply(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Ascii and binary of both byte orders; elements other than vertex and face are passed over."""
    data = path.read_bytes()
    head, mark, body = data.partition(b"end_header")
    if not data.startswith(b"ply") or not mark:
        raise ValueError("it has no ply header")
    encoding, elements = ply_header(head.decode("ascii", "replace").splitlines())
    body = body[body.index(b"\n") + 1 :]
    rest = body.decode("ascii", "replace").split("\n") if encoding == "ascii" else body
    if encoding == "ascii":
        rest = [line for line in rest if line.strip()]
    order = ">" if encoding == "binary_big_endian" else "<"
    found = {"vertex": {}, "face": {}}
    for name, count, properties in elements:
        if encoding == "ascii":
            columns, rest = ascii_rows(rest, count, properties)
        else:
            columns, rest = binary_rows(rest, count, properties, order)
        found[name] = {p[-1]: c for p, c in zip(properties, columns, strict=True)}
    vertices = np.column_stack([np.asarray(found["vertex"][a], float).ravel() for a in "xyz"])
    polygons = found["face"].get("vertex_indices") or found["face"].get("vertex_index") or []
    return vertices, fan([[int(c) for c in p] for p in polygons])


READERS = {".obj": read_obj, ".stl": read_stl, ".ply": read_ply}


def read_triangles(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) in the file's unit and triangles (F, 3).

    Raises MeshError, one line, when the file is absent, empty, of another format or broken.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError(f'{path.name}: "{path.suffix}" is not read; .obj, .stl or .ply is needed.')
    if not path.is_file():
        raise MeshError(f"{path}: there is no such file. Name a mesh, .obj, .stl or .ply.")
    if path.stat().st_size == 0:
        raise MeshError(f"{path.name}: the file is empty. Export the mesh again.")
    try:
        return reader(path)
    except (ValueError, KeyError, IndexError) as error:
        raise MeshError(
            f"{path.name}: it is not a {path.suffix.lower()} mesh ({error}). Export it again."
        ) from error
