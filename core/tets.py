"""Tetrahedra that are kept: the tetrahedralizer never gives the same ones twice."""

import hashlib
import json
import zipfile
from pathlib import Path

import numpy as np

from .data import Surface, TetMesh
from .files import written_whole
from .tetrahedralize import tetrahedralize

CUT = "girth"  # how they are cut: those that were kept before that are stale, too


def key(surface: Surface, elements: int) -> str:
    """What the tetrahedra were cut from: they are stale when it changes."""
    digest = hashlib.sha256(CUT.encode())
    digest.update(np.ascontiguousarray(surface.vertices).tobytes())
    digest.update(np.ascontiguousarray(surface.faces).tobytes())
    return f"{digest.hexdigest()[:24]}-{elements}"


def save_tets(path: str | Path, mesh: TetMesh, label: str, warnings: tuple[str, ...] = ()) -> None:
    """Keep `mesh` at `path` (.npz), whole or not at all."""
    with written_whole(Path(path)) as draft:
        np.savez_compressed(
            draft, nodes=mesh.nodes, tets=mesh.tets, key=label, warnings=json.dumps(warnings)
        )


def load_tets(path: str | Path, label: str) -> tuple[TetMesh, tuple[str, ...]] | None:
    """The mesh kept at `path` and what was said of it; None where it is absent or stale."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            if str(kept["key"]) != label:
                return None
            warnings = tuple(json.loads(str(kept["warnings"])))
            return TetMesh(kept["nodes"], kept["tets"]), warnings
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return None


def kept_or_cut(
    surface: Surface, elements: int, path, progress=None
) -> tuple[TetMesh, tuple[str, ...]]:
    """The tetrahedra of `surface` kept at `path` where it is not None, or else new ones.

    `save_tets` keeps those. Raises MeshError as `tetrahedralize` does.
    """
    label = key(surface, elements)
    kept = load_tets(path, label) if path is not None else None
    if kept is not None:
        return kept
    mesh, told = tetrahedralize(surface, elements, progress=progress)
    return mesh, told.warnings
