"""Surfaces: three formats, geometry, and what is refused."""

import struct

import numpy as np
import pytest

from core.data import Surface
from core.errors import MeshError
from core.surface import (
    bounding_box,
    closest_point,
    enclosed_volume,
    in_morton_order,
    is_closed,
    read_surface,
    simplified,
)
from tests.core.surfaces import SIDES, TRIANGLES, box, scan, sphere

CORNERS = box((1, 2, 3)).vertices


def obj(path, negative=False):
    shift = len(CORNERS) if negative else -1
    lines = ["# a box", *(f"v {x} {y} {z}" for x, y, z in CORNERS), "vn 0 0 1", "vt 0 0"]
    lines += ["f " + " ".join(f"{i - shift}//1" for i in side) for side in SIDES]
    path.write_text("\n".join(lines))


def ascii_stl(path):
    lines = ["solid box"]
    for face in TRIANGLES:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*CORNERS[i]) for i in face] + ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid box"]))


def binary_stl(path):
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *CORNERS[face].ravel(), 0) for face in TRIANGLES)
    path.write_bytes(b"solid but binary".ljust(80) + struct.pack("<I", len(TRIANGLES)) + body)


def ply(path, encoding):
    head = (
        f"ply\nformat {encoding} 1.0\ncomment of a box\nelement vertex 8\nproperty double x\n"
        "property float y\nproperty float z\nproperty uchar red\nelement face 6\n"
        "property list uchar int vertex_indices\nproperty short quality\nend_header\n"
    )
    if encoding == "ascii":
        rows = ["{} {} {} 7".format(*v) for v in CORNERS]
        rows += ["4 " + " ".join(map(str, s)) + " 5" for s in SIDES]
        path.write_text(head + "\n".join(rows) + "\n")
        return
    order = "<" if "little" in encoding else ">"
    body = b"".join(struct.pack(order + "dffB", *v, 7) for v in CORNERS)
    body += b"".join(struct.pack(order + "B4ih", 4, *s, 5) for s in SIDES)
    path.write_bytes(head.encode() + body)


WRITERS = {
    "positive.obj": obj,
    "negative.obj": lambda path: obj(path, negative=True),
    "ascii.stl": ascii_stl,
    "binary.stl": binary_stl,
    "ascii.ply": lambda path: ply(path, "ascii"),
    "little.ply": lambda path: ply(path, "binary_little_endian"),
    "big.ply": lambda path: ply(path, "binary_big_endian"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_closed_box(tmp_path, name):
    WRITERS[name](tmp_path / name)
    surface = read_surface(tmp_path / name, "cm")
    assert enclosed_volume(surface) == pytest.approx(6e-6, rel=1e-12)
    assert len(surface.vertices) == 8
    assert is_closed(surface)


@pytest.mark.parametrize("name", [n for n in WRITERS if not n.endswith(".stl")])
def test_vertices_keep_the_files_order(tmp_path, name):
    WRITERS[name](tmp_path / name)
    assert np.array_equal(read_surface(tmp_path / name, "m").vertices, CORNERS)


REFUSED = {
    "absent": ("mesh.obj", None, "no such file"),
    "empty": ("mesh.obj", b"", "empty"),
    "unknown format": ("mesh.abc", b"v 0 0 0", "is not read"),
    "text": ("mesh.obj", b"v a b c\nf 1 2 3", "not a .obj mesh"),
    "no mesh in it": ("mesh.obj", b"hello there", "no faces"),
    "points only": ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0", "no faces"),
    "flat": ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "enclose no volume"),
    "one place": ("mesh.obj", b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3", "enclose no volume"),
    "wild index": ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9", "do not exist"),
    "not finite": ("mesh.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "not finite"),
    "torn stl": ("mesh.stl", b"\0" * 80 + b"\5\0\0\0" + b"\0" * 30, "not a .stl mesh"),
    "torn ply": ("mesh.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n", "not a .ply mesh"),
    "ply without faces": (
        "mesh.ply",
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        b"property float z\nend_header\n0 0 0\n",
        "no faces",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_surface_is_refused_in_one_line(tmp_path, case):
    name, data, said = REFUSED[case]
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(MeshError, match=said) as refusal:
        read_surface(tmp_path / name, "m")
    assert "\n" not in str(refusal.value)
    assert "mesh." in str(refusal.value)


def test_an_unknown_unit_is_refused():
    with pytest.raises(MeshError, match='"inch"'):
        read_surface("mesh.obj", "inch")


def test_the_closest_point_of_a_box_is_the_clamped_point():
    places = np.random.default_rng(1).uniform(-2, 5, (500, 3))
    outside = places[((places < 0) | (places > (1, 2, 3))).any(axis=1)]
    surface = box((1, 2, 3))
    points, faces, distance = closest_point(surface, outside)
    exact = np.clip(outside, 0, (1, 2, 3))
    assert np.abs(points - exact).max() < 1e-12
    assert np.abs(distance - np.linalg.norm(outside - exact, axis=1)).max() < 1e-12
    corners = surface.vertices[surface.faces[faces]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.abs(np.einsum("ni,ni->n", normal, points - corners[:, 0])).max() < 1e-12


def test_volume_does_not_care_where_the_origin_is_nor_which_way_faces_look():
    body = sphere(4)
    far = Surface(body.vertices + 1000.0, body.faces[:, ::-1])
    assert enclosed_volume(far) == pytest.approx(enclosed_volume(body), rel=1e-9)
    assert enclosed_volume(body) == pytest.approx(4 / 3 * np.pi, rel=1e-2)


def test_a_box_without_its_lid_is_open():
    assert is_closed(box((1, 1, 1)))
    assert not is_closed(Surface(CORNERS, TRIANGLES[2:]))


def test_morton_order_brings_neighbours_together_and_changes_no_place():
    scattered = scan(5)
    ordered = in_morton_order(scattered)

    def reach(surface):
        return np.ptp(surface.faces, axis=1).mean()

    assert reach(ordered) < 0.1 * reach(scattered)
    before = np.sort(scattered.vertices[scattered.faces].reshape(-1, 9), axis=0)
    # the same corners in another order: sums over faces agree to rounding
    after = np.sort(ordered.vertices[ordered.faces].reshape(-1, 9), axis=0)
    assert np.array_equal(before, after)


def test_thinning_keeps_volume_and_stays_near():
    fine = sphere(6)
    coarse = simplified(fine, 2000)
    assert 1500 < len(coarse.faces) <= 2100
    assert enclosed_volume(coarse) == pytest.approx(enclosed_volume(fine), rel=5e-3)
    assert closest_point(coarse, fine.vertices[::50])[2].max() < 0.01


def test_the_box_is_of_what_faces_use():
    stray = Surface(np.vstack([CORNERS, [[9, 9, 9]]]), TRIANGLES)
    assert np.array_equal(bounding_box(stray)[1], (1, 2, 3))
