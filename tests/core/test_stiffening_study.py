import json
from argparse import ArgumentParser

import numpy as np
import pytest

from core.boundary import boundary
from core.data import Material, Surface
from core.elasticity import assemble, hold_points
from core.errors import CaseError
from core.stiffening_study import add_arguments, parse_pin, stiffening_main, study_mesh, table
from tests.core.solids import block, box_surface


def build(mesh, element):
    model = assemble(mesh, Material(1000.0, 0.48), element)
    return hold_points(model, np.flatnonzero(model.points[:, 0] == 0))


def test_linear_elements_ring_too_high_and_quadratic_ones_nearly_right():
    rows = study_mesh(build, block((6, 2, 2), (0.5, 0.1, 0.1)), ("p1", "p1_smoothed", "p2"), 2)
    error = {row.element: row.pitch_error[0] for row in rows}
    assert error["p1"] > 0.5
    assert abs(error["p1_smoothed"]) < 0.2
    assert 0 < error["p2"] < 0.1
    assert table(rows).count("\n") == 3


def test_pins_are_read_as_boxes_spheres_and_vertices():
    surface = box_surface((1, 1, 1))
    assert parse_pin("box=0,0,0,1,1,0.5", surface).contains(np.array([[0.5, 0.5, 0.4]])).all()
    assert not parse_pin("sphere=0,0,0,0.1", surface).contains(np.array([[0.5, 0.5, 0.4]])).any()
    assert (parse_pin("vertices=0,3", surface).indices == [0, 3]).all()


@pytest.mark.parametrize("text", ["box=1,2", "ball=0,0,0,1", "sphere=a,b,c,d", "vertices=0.5", ""])
def test_a_pin_that_makes_no_sense_is_refused_with_the_three_forms(text):
    with pytest.raises(CaseError, match="vertices=0,1,2"):
        parse_pin(text, box_surface((1, 1, 1)))


def obj(surface: Surface) -> str:
    lines = [f"v {x} {y} {z}" for x, y, z in surface.vertices]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in surface.faces])


@pytest.mark.slow
def test_the_command_writes_a_table_and_a_picture(tmp_path):
    mesh = block((6, 2, 2), (0.5, 0.1, 0.1))
    (tmp_path / "bar.obj").write_text(obj(Surface(mesh.nodes, boundary(mesh).corners)))
    parser = ArgumentParser()
    add_arguments(parser)
    pins = "--pins=box=-1,-1,-1,0.001,1,1"
    words = [str(tmp_path / "bar.obj"), pins, "--out", str(tmp_path / "o"), "--elements", "300,700"]
    text = stiffening_main(parser.parse_args(words))
    rows = json.loads((tmp_path / "o" / "stiffening.json").read_text())
    assert len(rows) == 8 == text.count("\n")
    assert (tmp_path / "o" / "stiffening.png").read_bytes()[1:4] == b"PNG"
    first = {(r["element"], r["tets"]): abs(r["pitch_error"][0]) for r in rows}
    assert all(v < 0.06 for (e, _), v in first.items() if e == "p2")


def test_resolutions_that_are_not_numbers_are_refused(tmp_path):
    (tmp_path / "box.obj").write_text(obj(box_surface((1, 1, 1))))
    parser = ArgumentParser()
    add_arguments(parser)
    words = [str(tmp_path / "box.obj"), "--pins", "vertices=0,1,2,3", "--out", str(tmp_path)]
    with pytest.raises(CaseError, match="whole numbers"):
        stiffening_main(parser.parse_args([*words, "--elements", "many"]))
