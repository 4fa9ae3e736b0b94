"""Tetrahedra kept in a file: cutting is slow and never the same twice."""

import hashlib
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from .data import Surface, TetMesh
from .errors import DataError, MeshError


def tets_key(surface: Surface, elements: int) -> str:
    """What the tetrahedra were made from: 16 hexadecimal digits that change with any vertex,

    face or number of elements asked for.
    """
    digest = hashlib.sha256()
    for part in (np.asarray(surface.vertices, "<f8"), np.asarray(surface.faces, "<i8")):
        digest.update(np.ascontiguousarray(part).tobytes())
    digest.update(str(int(elements)).encode())
    return digest.hexdigest()[:16]


def save_tets(path: Path | str, mesh: TetMesh, key: str) -> None:
    """Write `mesh` and its `tets_key` to the .npz `path`, whole or not at all."""
    path = Path(path)
    draft = path.with_name(path.name + ".part")
    with draft.open("wb") as file:
        np.savez_compressed(file, nodes=mesh.nodes, tets=mesh.tets, key=np.array(key))
    draft.replace(path)


def load_tets(path: Path | str, key: str | None = None) -> TetMesh:
    """The mesh kept at `path`; with `key`, only if it was made from the same surface and number.

    Raises MeshError, one line, when the file is absent, is not such a file, or is stale.
    """
    path = Path(path)
    if not path.is_file():
        raise MeshError(f"{path}: no tetrahedra are kept there. Tetrahedralize again.")
    try:
        with np.load(path, allow_pickle=False) as kept:
            nodes, tets, made_from = kept["nodes"], kept["tets"], str(kept["key"])
        mesh = TetMesh(nodes, tets)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile, DataError) as error:
        raise MeshError(
            f"{path.name}: it does not hold tetrahedra ({error}). Delete it and run again."
        ) from error
    if key is not None and made_from != key:
        raise MeshError(
            f"{path.name}: its tetrahedra are stale; the mesh or the number of elements has "
            "changed since. Tetrahedralize again."
        )
    return mesh
