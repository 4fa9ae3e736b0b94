"""case.toml: what it says arrives in SI, and each way of being wrong is refused by name."""

import re
from pathlib import Path

import numpy as np
import pytest

from core.case import read_case
from core.errors import CaseError, CoreError

MEASURED = Path(__file__).parents[2].parent / "shared" / "measured"

BEAM = """\
v 0 0 0
v 0.1 0 0
v 0.1 0.02 0
v 0 0.02 0
v 0 0 0.02
v 0.1 0 0.02
v 0.1 0.02 0.02
v 0 0.02 0.02
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
f 4 1 5
f 4 5 8
"""
CASE = """\
name = "beam"
[object]
mesh = "beam.obj"
density = 1070.0
[[pin]]
box = { min = [-0.01, -0.1, -0.1], max = [0.002, 0.1, 0.1] }
[recording]
tracks = "tracks.csv"
[[marker]]
name = "tip"
position = [0.1, 0.01, 0.01]
"""
FLAT = """\
[camera]
kind = "orthographic"
metres_per_pixel = 0.0005
right = [1, 0, 0]
down = [0, 0, -1]
principal_point = [640, 360]
"""
PINHOLE = """\
[camera]
kind = "pinhole"
position = [0.05, -0.5, 0.01]
look = [0, 1, 0]
down = [0, 0, -1]
focal_px = 1000.0
principal_point = [640, 360]
"""


def tracks(columns="tip.x,tip.y,tip.z", frames=40, rows=()):
    """Text of a tracks file: the tip swings by 1 mm at 5 Hz, 100 frames a second."""
    t = np.arange(frames) / 100
    lines = [f"time,{columns}"]
    lines += [f"{s:.4f},0.1,0.01,{0.01 + 1e-3 * np.cos(31.4 * s):.7f}" for s in t]
    return "\n".join([*lines, *rows]) + "\n"


def pixels(frames=40, middle=(840, 340)):
    """The same seen by FLAT, or about another pixel."""
    t = np.arange(frames) / 100
    lines = [f"{middle[0]:.1f},{middle[1] - 2 * np.cos(31.4 * s):.4f}" for s in t]
    return "\n".join(["tip.u,tip.v", *lines]) + "\n"


@pytest.fixture
def read(tmp_path):
    """Read a case made of these texts."""

    def read(case=CASE, csv=None, mesh=BEAM, **more):
        (tmp_path / "case.toml").write_text(case)
        (tmp_path / "tracks.csv").write_text(tracks() if csv is None else csv)
        (tmp_path / "beam.obj").write_text(mesh)
        for name, text in more.items():
            (tmp_path / f"{name}.csv").write_text(text)
        return read_case(tmp_path / "case.toml")

    return read


def refused(read, words, *args, **kwargs):
    """The text of the refusal, which is one line and holds the words."""
    with pytest.raises(CoreError) as caught:
        read(*args, **kwargs)
    message = str(caught.value)
    assert "\n" not in message and message.rstrip().endswith((".", "?")), message
    for word in words:
        assert word in message, message
    return message


# --- what is said arrives -------------------------------------------------------------------------


def test_a_minimal_case_has_the_contracts_defaults(read):
    case = read()
    assert (case.name, case.shape, case.declared) == ("beam", "equilibrium", ())
    assert (case.material.density, case.material.poisson_ratio) == (1070.0, 0.48)
    assert case.claimed_youngs_modulus is None and case.takes[0].gravity is None
    assert len(case.takes) == 1 and not case.takes[0].held_out
    recording = case.takes[0].recording
    assert (recording.start, recording.stop, recording.camera) == (None, None, None)
    assert recording.values.shape == (40, 1, 3) and recording.markers[0].on == "object"
    np.testing.assert_allclose(np.diff(recording.time), 0.01)


def test_every_field_of_the_contract_arrives(read):
    text = """
        name = "all"
        [object]
        mesh = "beam.obj"
        length_unit = "m"
        density = 900
        poisson_ratio = 0.3
        youngs_modulus = 2.6e5
        gravity = [0, 0, -9.81]
        shape = "unloaded"
        [[pin]]
        vertices = [0, 3, 4, 7]
        [[pin]]
        sphere = { centre = [0, 0, 0], radius = 0.01 }
        [[load]]
        mass = 0.0005
        position = [0.1, 0.0, 0.0]
        [model]
        declared = ["viscous_damping", "gravity_preload"]
        [recording]
        tracks = "tracks.csv"
        capture_fps = 100.0
        start = 0.05
        stop = 0.3
        [[take]]
        tracks = "second.csv"
        held_out = true
        load = [{ mass = 0.052, position = [0.1, 0.0, 0.01] }]
        gravity = [0.0, 0.0, 9.81]
        [[take]]
        tracks = "second.csv"
        load = []
        [[marker]]
        name = "tip"
        position = [0.1, 0.01, 0.01]
        pixel = [812, 344.5]
    """
    case = read(text, second=tracks())
    first, second, third = case.takes
    assert case.material.poisson_ratio == 0.3 and case.claimed_youngs_modulus == 2.6e5
    assert case.shape == "unloaded" and case.declared == ("viscous_damping", "gravity_preload")
    assert (first.recording.start, first.recording.stop) == (0.05, 0.3)
    assert first.loads[0].mass == 0.0005 and first.gravity[2] == -9.81
    assert second.held_out and second.loads[0].mass == 0.052 and second.gravity[2] == 9.81
    assert not third.held_out and third.loads == () and third.gravity[2] == -9.81
    assert case.pinned.tolist() == [True, False, False, True, True, False, False, True]
    assert first.recording.markers[0].pixel == (812.0, 344.5)


def test_length_unit_scales_the_mesh_and_nothing_else(read):
    big = re.sub(r"0\.(\d+)", lambda m: str(float(m[0]) * 1000), BEAM)
    case = read(CASE.replace("density", 'length_unit = "mm"\ndensity'), mesh=big)
    np.testing.assert_allclose(case.surface.vertices, read().surface.vertices, atol=1e-12)
    assert case.pinned.tolist() == read().pinned.tolist()
    np.testing.assert_array_equal(case.takes[0].recording.markers[0].position, [0.1, 0.01, 0.01])


def test_a_folder_stands_for_the_case_in_it(read, tmp_path):
    read()
    assert read_case(tmp_path).name == "beam"


def test_frames_without_a_time_column_are_spaced_by_the_capture_rate(read):
    text = "\n".join(line.split(",", 1)[1] for line in tracks().splitlines())
    case = read(CASE.replace("[[marker]]", "capture_fps = 240\n[[marker]]"), text)
    np.testing.assert_allclose(case.takes[0].recording.time, np.arange(40) / 240, rtol=1e-14)


def test_a_time_column_at_odds_with_the_capture_rate_is_warned_of(read):
    slow = CASE.replace("[[marker]]", "capture_fps = 240\n[[marker]]")
    assert any("240" in line for line in read(slow).takes[0].recording.warnings)
    right = CASE.replace("[[marker]]", "capture_fps = 100\n[[marker]]")
    assert read(right).takes[0].recording.warnings == ()


def test_a_sample_out_of_place_for_one_frame_is_left_out_with_a_warning(read):
    lines = tracks().splitlines()
    time, x, y, z = lines[21].split(",")
    lines[21] = f"{time},{x},{y},{float(z) + 0.02}"
    recording = read(CASE, "\n".join(lines)).takes[0].recording
    assert np.isnan(recording.values[20]).all() and np.isnan(recording.values).sum() == 3
    (warning,) = recording.warnings
    assert "1 sample jumps" in warning and "tip" in warning and "left out" in warning


@pytest.mark.skipif(not MEASURED.is_dir(), reason="the measured recordings are not here")
@pytest.mark.parametrize("name", ["silicone_beam_gravity_a", "silicone_beam_load52_a"])
def test_the_measured_cases_are_read_whole(name):
    case = read_case(MEASURED / name / "case.toml")
    recording = case.takes[0].recording
    assert recording.values.shape[1:] == (6, 3) and case.pinned.any() and not case.pinned.all()
    assert {marker.on for marker in recording.markers} == {"object", "support"}


# --- cameras --------------------------------------------------------------------------------------


def flat_case(camera=FLAT):
    return CASE.replace("[[marker]]", f"capture_fps = 100\n{camera}[[marker]]")


def test_an_orthographic_camera_sees_the_origin_at_the_principal_point(read):
    camera = read(flat_case(), pixels()).takes[0].recording.camera
    np.testing.assert_allclose(camera.project(np.zeros(3)), [640, 360])
    np.testing.assert_allclose(camera.project([0.1, 7.0, 0.01]), [840, 340])  # 0.5 mm a pixel
    assert camera.image_size == (1280, 720) and camera.readout is None


def test_a_pinhole_camera_sees_what_is_on_its_axis_at_the_principal_point(read):
    camera = read(flat_case(PINHOLE), pixels()).takes[0].recording.camera
    np.testing.assert_allclose(camera.project([0.05, 3.0, 0.01]), [640, 360])
    right_and_down = camera.project([0.05 + 0.1, 0.5, 0.01 - 0.2])  # 1 m away: 1000 px a metre
    np.testing.assert_allclose(right_and_down, [740, 560])


@pytest.mark.parametrize("behind", [False, True])
def test_a_place_that_is_looked_at_is_told_from_a_direction_by_where_the_markers_are(read, behind):
    """The tip is at (0.1, 0.01, 0.01) m, and seen in the middle by who looks there."""
    place = [0.1, 0.5, 0.3] if behind else [0.1, -0.5, -0.3]
    table = PINHOLE.replace("[0.05, -0.5, 0.01]", str(place))
    looks_at = table.replace("look = [0, 1, 0]", "look = [0.1, 0.01, 0.01]")
    recording = read(flat_case(looks_at), pixels(middle=(640, 360))).takes[0].recording
    np.testing.assert_allclose(recording.camera.project([0.1, 0.01, 0.01]), [640, 360])
    assert any("place that is looked at" in told for told in recording.warnings)
    away = np.array([0.1, 0.01, 0.01]) - place
    right = table.replace("look = [0, 1, 0]", f"look = {away.tolist()}")
    recording = read(flat_case(right), pixels(middle=(640, 360))).takes[0].recording
    np.testing.assert_allclose(recording.camera.project([0.1, 0.01, 0.01]), [640, 360])
    assert recording.warnings == ()


def looking(position, look):
    """[camera] of a pinhole at a place."""
    table = PINHOLE.replace("[0.05, -0.5, 0.01]", str(position))
    return table.replace("look = [0, 1, 0]", f"look = {look}")


def test_the_origin_may_be_looked_at(read):
    table = looking([0.0, -0.5, -0.3], [0, 0, 0])
    at = 640 + 1000 * 0.1 / 0.6  # near the middle, wherever exactly
    camera = read(flat_case(table), pixels(middle=(at, 360))).takes[0].recording.camera
    np.testing.assert_allclose(camera.project([0, 0, 0]), [640, 360])


@pytest.mark.parametrize("middle", [(640, 360), (1400, 360), (9000, 360)])
def test_a_marker_behind_a_camera_is_refused_where_no_place_looked_at_would_do(read, middle):
    """The place would be seen 0 px, 760 px and 8360 px from the marker, were it looked at."""
    case = flat_case(looking([0.1, 0.5, 0.3], [0.1, 0.01, 0.01]))
    if middle == (640, 360):
        assert read(case, pixels(middle=middle)).takes[0].recording.warnings
        return
    refused(read, ["tip", "behind", "Turn look"], case, pixels(middle=middle))


def test_a_direction_that_has_the_markers_nearly_where_they_are_stays_one(read):
    """However well the place fits, which lies but a degree aside."""
    case = flat_case(looking([0.1, -5.0, 0.01], [0, 1, 0]))
    recording = read(case, pixels(middle=(656.7, 358.3))).takes[0].recording
    np.testing.assert_allclose(recording.camera.rows[2], [0, 1, 0])
    assert recording.warnings == ()


def test_of_two_takes_in_pixels_both_get_the_camera_and_the_first_one_the_warning(read):
    case = flat_case(looking([0.1, 0.5, 0.3], [0.1, 0.01, 0.01]))
    more = '\n[[take]]\ntracks = "other.csv"\ncapture_fps = 100\n'
    seen = pixels(middle=(640, 360))
    one, two = read(case + more, seen, other=seen).takes
    assert one.recording.camera is two.recording.camera
    assert len(one.recording.warnings) == 1 and two.recording.warnings == ()


def test_tracks_in_metres_are_no_help_where_a_marker_is_behind_the_camera(read):
    case = CASE + "\n" + looking([0.1, 0.5, 0.3], [0.1, 0.01, 0.01])
    refused(read, ["tip", "behind", "Turn look"], case)


def test_camera_axes_come_out_orthonormal(read):
    leaning = FLAT.replace("down = [0, 0, -1]", "down = [0.02, 0, -3]")
    rows = read(flat_case(leaning), pixels()).takes[0].recording.camera.rows
    np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(np.cross(rows[0], rows[1]), rows[2], atol=1e-14)
    tilted = PINHOLE.replace("look = [0, 1, 0]", "look = [0, 1, -0.4]")
    rows = read(flat_case(tilted), pixels()).takes[0].recording.camera.rows
    np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rows) == pytest.approx(1) and rows[0] @ [0, 0, 1] == pytest.approx(0)


@pytest.mark.parametrize(
    ("camera", "words"),
    [
        (FLAT.replace("down = [0, 0, -1]", "down = [0.2, 0, -1]"), ["right and down", "90"]),
        (FLAT.replace("down = [0, 0, -1]", "down = [0, 0, 0]"), ["down", "direction"]),
        (FLAT.replace("right = [1, 0, 0]\n", ""), ["right", "lacks"]),
        (FLAT + "focal_px = 1200\n", ["focal_px", "pinhole"]),
        (FLAT.replace("0.0005", "0"), ["metres_per_pixel", "1e-09 <= x <= 10"]),
        (FLAT + "readout = -0.1\n", ["readout", "0 <= x <= 1"]),
        (FLAT + "image_size = [1280]\n", ["image_size", "2 whole numbers"]),
        (FLAT.replace("orthographic", "fisheye"), ["kind", "fisheye", "pinhole"]),
        (PINHOLE.replace("down = [0, 0, -1]", "down = [0, 2, 0]"), ["down", "look"]),
        (PINHOLE.replace("look = [0, 1, 0]", "look = [0, -1, 0]"), ["tip", "behind"]),
        (PINHOLE.replace("focal_px = 1000.0\n", ""), ["focal_px", "lacks"]),
        ("", ["[camera]", "pixels", "missing"]),
    ],
)
def test_a_wrong_camera_is_refused_by_field(read, camera, words):
    refused(read, words, flat_case(camera), pixels())


def test_two_dimensional_tracks_need_a_capture_rate(read):
    refused(
        read,
        ["capture_fps", "[recording]"],
        CASE.replace("[[marker]]", FLAT + "[[marker]]"),
        pixels(),
    )


# --- refusals of fields ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name = "beam"\n', "", ["name", "lacks"]),
        ('mesh = "beam.obj"\n', "", ["[object]", "mesh", "lacks"]),
        ("density = 1070.0\n", "", ["[object]", "density", "lacks"]),
        ('tracks = "tracks.csv"\n', "", ["[recording]", "tracks", "video"]),
        ('[recording]\ntracks = "tracks.csv"\n', "", ["recording", "lacks"]),
        ("position = [0.1, 0.01, 0.01]\n", "", ["[[marker]] 1", "position", "lacks"]),
        ("density", "densty = 3\ndensity", ["densty", "density", "Did you mean"]),
        ("[recording]", "[recordings]", ["recordings", "Did you mean recording?"]),
        ("1070.0", "0", ["density", "1 <= x <= 30000 kg/m3"]),
        ("1070.0", "-1070", ["density = -1070"]),
        ("1070.0", "1.07e-6", ["density", "1 <= x"]),
        ("1070.0", '"heavy"', ["density", "number"]),
        ("1070.0", "true", ["density", "number"]),
        ("1070.0", "nan", ["density", "finite"]),
        ("1070.0", "[1070.0]", ["density", "number"]),
        ("1070.0", "1070\npoisson_ratio = 0.5", ["poisson_ratio = 0.5", "0 <= x < 0.5", "0.499"]),
        ("1070.0", "1070\npoisson_ratio = -0.1", ["poisson_ratio", "0 <= x < 0.5"]),
        ("1070.0", "1070\nyoungs_modulus = 0", ["youngs_modulus", "more than 0 Pa"]),
        ("1070.0", "1070\ngravity = [0, -9.81]", ["gravity", "3 numbers"]),
        ("1070.0", "1070\ngravity = [0, 0, -9810]", ["gravity", "100 m/s2"]),
        ("1070.0", '1070\nshape = "hanging"', ["shape", "equilibrium", "unloaded"]),
        ("1070.0", '1070\nlength_unit = "inch"', ["length_unit", "inch", '"mm"']),
        ("[recording]", "[[load]]\nmass = 0\nposition=[0,0,0]\n[recording]", ["[[load]] 1 mass"]),
        ("[recording]", '[model]\ndeclared = ["drag"]\n[recording]', ["drag", "declared"]),
        ("[recording]", '[model]\ndeclared = "clock"\n[recording]', ["declared", "list"]),
        ("tracks =", "capture_fps = 0\ntracks =", ["capture_fps", "1 <= x"]),
        ("tracks =", "capture_fps = 2e6\ntracks =", ["capture_fps", "1e+06"]),
        ("tracks =", "start = 0.5\ntracks =", ["start = 0.5", "0 to 0.39 s"]),
        ("tracks =", "stop = -1\ntracks =", ["stop = -1", "0 to 0.39 s"]),
        ("tracks =", "start = 0.3\nstop = 0.2\ntracks =", ["start before stop"]),
        ("tracks =", 'video = "a.mp4"\ntracks =', ["both", "one of them"]),
        ("tracks.csv", "track.csv", ["track.csv", "no such file", "tracks.csv"]),
        ("beam.obj", "bean.obj", ["mesh", "bean.obj", "Did you mean beam.obj"]),
        ('name = "tip"', 'name = "tip"\non = "table"', ["on", "table", "support"]),
        ('name = "tip"', 'name = "tip"\non = "support"', ["support", "at least one on the object"]),
        ('[[marker]]\nname = "tip"', '[marker]\nname = "tip"', ["marker", "such tables"]),
        ("name = \"beam\"", "name = beam", ["TOML", "line 1"]),
    ],
)  # fmt: skip
def test_a_wrong_field_is_refused_by_name(read, old, new, words):
    assert old in CASE
    refused(read, words, CASE.replace(old, new, 1))


def test_two_markers_of_one_name_are_refused(read):
    again = '[[marker]]\nname = "tip"\nposition = [0.1, 0, 0]\n'
    refused(read, ["tip", "twice"], CASE + again)


def test_an_absent_case_file_is_refused(tmp_path):
    with pytest.raises(CaseError, match="no such file"):
        read_case(tmp_path / "case.toml")


# --- refusals of geometry -------------------------------------------------------------------------


def pin(text):
    return re.sub(r"box = .*", text, CASE)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["[[pin]] 1", "one of box, sphere"]),
        ("vertices = [0]\nsphere = { centre = [0, 0, 0], radius = 0.1 }", ["one of box, sphere"]),
        ("vertices = []", ["vertices", "one or more"]),
        ("vertices = [0, 8]", ["8 does not exist", "0 to 7"]),
        ("vertices = [-1]", ["vertices", "none below 0"]),
        ("vertices = [0.5]", ["vertices", "whole"]),
        ("vertices = [0, 1, 2, 3, 4, 5, 6, 7]", ["whole surface", "nothing is left"]),
        ("box = { min = [1, 1, 1], max = [0, 2, 2] }", ["min below max"]),
        ("box = { min = [1, 1, 1] }", ["box", "max", "lacks"]),
        ("box = { min = [1, 1, 1], max = [2, 2, 2] }", ["holds nothing", "length_unit"]),
        ("box = { min = [0.04, 0.005, 0.005], max = [0.06, 0.015, 0.015] }", ["holds nothing"]),
        ("box = { min = [-1, -1, -1], max = [1, 1, 1] }", ["whole surface"]),
        ("sphere = { centre = [0.05, 0.01, 0.01], radius = 0.0099 }", ["holds nothing"]),
        ("sphere = { centre = [0, 0, 0], radius = 0 }", ["radius", "more than 0 m"]),
        ("sphere = { centre = [0, 0, 0], radius = 9 }", ["whole surface"]),
    ],
)
def test_a_pin_that_holds_nothing_or_everything_is_refused(read, text, words):
    refused(read, words, pin(text))


@pytest.mark.parametrize(
    "text",
    [
        "box = { min = [0.05, -1, -1], max = [0.0501, 1, 1] }",
        "box = { min = [0.0517, 0.0093, 0.0199], max = [0.0518, 0.0094, 0.0201] }",
        "sphere = { centre = [0.05, 0.01, 0.01], radius = 0.0101 }",
    ],
)
def test_a_region_between_the_corners_of_a_large_triangle_holds_it(read, text):
    case = read(pin(text))
    assert not case.pinned.any() and len(case.pin_regions) == 1


def test_clamping_both_ends_of_a_box_holds_all_vertices_and_not_everything(read):
    far = "\n[[pin]]\nbox = { min = [0.099, -1, -1], max = [0.2, 1, 1] }"
    case = read(re.sub(r"(box = .*)", r"\1" + far, CASE))
    assert case.pinned.all()


@pytest.mark.parametrize("place", ["[100, 10, 10]", "[0.1, 0.1, 0.01]"])
def test_a_marker_far_off_the_object_is_refused_with_the_distance(read, place):
    message = refused(read, ["tip", "length_unit"], CASE.replace("[0.1, 0.01, 0.01]", place))
    assert "0.08 m off" in message or "100" in message


def test_a_mesh_in_another_unit_than_is_said_is_known_by_its_markers(read):
    big = re.sub(r"0\.(\d+)", lambda m: str(float(m[0]) * 1000), BEAM)
    more = "".join(
        f'[[marker]]\nname = "{name}"\nposition = {place}\n'
        for name, place in (("side", "[0.05, 0.02, 0.01]"), ("top", "[0.02, 0.01, 0.02]"))
    )
    text = CASE.replace("density", 'length_unit = "cm"\ndensity') + more
    for said in ("cm", "m"):
        words = ["length_unit", f'"{said}"', '"mm"']
        refused(read, words, text.replace('"cm"', f'"{said}"'), mesh=big)
    csv = tracks().splitlines()
    csv = [csv[0] + ",side.x,side.y,side.z,top.x,top.y,top.z"] + [
        line + ",0.05,0.02,0.01,0.02,0.01,0.02" for line in csv[1:]
    ]
    case = read(text.replace('"cm"', '"mm"'), "\n".join(csv), mesh=big)
    assert len(case.takes[0].recording.markers) == 3


def test_a_marker_a_little_off_the_surface_is_welcome_and_a_far_one_on_the_support_too(read):
    text = CASE.replace("[0.1, 0.01, 0.01]", "[0.12, 0.01, 0.01]")
    text += '[[marker]]\nname = "wall"\nposition = [-0.3, 0, 0]\non = "support"\n'
    csv = tracks().splitlines()
    csv = [csv[0] + ",wall.x,wall.y,wall.z"] + [line + ",-0.3,0,0" for line in csv[1:]]
    assert len(read(text, "\n".join(csv)).takes[0].recording.markers) == 2


def test_a_load_of_more_than_a_thousand_bodies_is_refused_and_a_lesser_one_is_not(read):
    load = "[[load]]\nmass = {}\nposition = [0.1, 0, 0]\n[recording]"
    heavy = 1000 * 1070 * 0.1 * 0.02 * 0.02
    message = refused(
        read, ["load 1 mass", "body"], CASE.replace("[recording]", load.format(1.01 * heavy))
    )
    assert "0.0428 kg" in message
    case = read(CASE.replace("[recording]", load.format(0.99 * heavy)))
    assert case.takes[0].loads[0].mass == pytest.approx(0.99 * heavy)


def test_an_unloaded_shape_without_gravity_gets_a_warning_and_with_it_none(read):
    unloaded = CASE.replace("1070.0", '1070.0\nshape = "unloaded"')
    assert "no sag" in " ".join(read(unloaded).takes[0].recording.warnings)
    heavy = unloaded.replace("[[pin]]", "gravity = [0, 0, -9.81]\n[[pin]]")
    assert not read(heavy).takes[0].recording.warnings


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("vertices = [0]", ["[[pin]] 1", "single place"]),
        ("vertices = [3, 3, 3]", ["[[pin]] 1", "single place"]),
        ("vertices = [0, 1]", ["[[pin]] 1", "one line"]),
        ("sphere = { centre = [0, 0, 0], radius = 1e-6 }", ["[[pin]] 1", "single place"]),
        ("box = { min = [-1, -1e-7, -1e-7], max = [1, 1e-7, 1e-7] }", ["[[pin]] 1", "one line"]),
        ("vertices = [0, 3, 4]\n[[pin]]\nvertices = [6]", ["[[pin]] 2", "single place"]),
    ],
)
def test_a_pin_that_holds_a_point_or_a_line_is_refused_by_its_number(read, text, words):
    refused(read, words, pin(text))


@pytest.mark.parametrize(
    "text",
    ["vertices = [0, 3, 4]", "sphere = { centre = [0, 0, 0], radius = 1e-3 }"],
)
def test_a_pin_that_holds_three_corners_or_a_small_patch_is_welcome(read, text):
    assert read(pin(text)).pinned.any()


def test_a_load_far_off_the_object_is_refused(read):
    load = "[[load]]\nmass = 0.1\nposition = [1, 0, 0]\n[recording]"
    refused(read, ["load 1", "0.9 m off"], CASE.replace("[recording]", load))


@pytest.mark.parametrize(
    "mesh", ["", "solid nothing\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "f 1 2 3\n"]
)
def test_a_file_that_is_no_mesh_is_refused(read, mesh):
    refused(read, ["beam.obj"], mesh=mesh)


def test_tracks_in_millimetres_are_refused(read):
    text = tracks().replace(",0.1,0.01,", ",100,10,")
    refused(read, ["tracks.csv", "tip", "metres"], csv=text)


# --- a video in place of tracks -------------------------------------------------------------------

FILMED = flat_case().replace('tracks = "tracks.csv"', 'video = "film.avi"')


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FILMED, ["film.avi", "no such file"]),
        (FILMED.replace("film.avi", "tracks.csv"), ["tip", "lacks the field pixel"]),
        (
            FILMED.replace("film.avi", "tracks.csv") + "pixel = [1280, 3]\n",
            ["pixel", "outside the image of 1280 x 720"],
        ),
        (
            FILMED.replace("film.avi", "tracks.csv").replace("capture_fps = 100\n", ""),
            ["[recording]", "capture_fps", "playback"],
        ),
        (CASE.replace("tracks =", "capture_fps = 9\nvideo ="), ["[camera]", "missing"]),
        (FILMED.replace("film.avi", "tracks.csv") + "pixel = [9, 3]\n", ["tracks.csv"]),
    ],
)
def test_a_video_that_cannot_be_followed_is_refused(read, text, words):
    refused(read, words, text)


def test_a_video_is_followed_from_the_pixels_of_the_markers(read, tmp_path):
    cv2 = pytest.importorskip("cv2")
    path = str(tmp_path / "film.avi")
    film = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*"MJPG"), 30, (320, 240))
    grain = np.random.default_rng(0).integers(0, 255, (24, 32)).astype(np.uint8)
    picture = cv2.resize(grain, (320, 240), interpolation=cv2.INTER_CUBIC)
    shifts = [3 * np.sin(0.3 * k) for k in range(40)]
    for shift in shifts:
        move = np.array([[1, 0, shift], [0, 1, 0]])
        film.write(cv2.cvtColor(cv2.warpAffine(picture, move, (320, 240)), cv2.COLOR_GRAY2BGR))
    film.release()
    text = FILMED.replace("[640, 360]", "[160, 120]") + "pixel = [160, 120]\n"
    recording = read(text).takes[0].recording
    assert recording.values.shape[1:] == (1, 2)
    assert recording.capture_fps == 100
    np.testing.assert_allclose(np.diff(recording.time), 0.01, rtol=1e-9)
    seen = recording.values[:, 0, 0] - recording.values[0, 0, 0]
    assert np.abs(seen - shifts[: len(seen)]).max() < 0.3


# --- anything at all ------------------------------------------------------------------------------

WHOLE = (
    flat_case()
    .replace("[[pin]]", "poisson_ratio = 0.4\ngravity = [0, 0, -9.81]\n[[pin]]")
    .replace('"tracks.csv"', '"tracks.csv"\nstart = 0.1\nstop = 0.3')
    + '[[load]]\nmass = 0.1\nposition = [0, 0, 0]\n[[take]]\ntracks = "tracks.csv"\ncapture_fps = 9'
    + '\n[model]\ndeclared = ["clock"]\n[[pin]]\nsphere = { centre = [0, 0, 0], radius = 0.01 }\n'
)
JUNK = ("0", "-1", "1e300", "inf", "nan", '""', '"a\\nb"', "true", "[]", "[[]]", "[nan, 0, 0]")
JUNK += ("{}", "2020-01-01", '{ min = "a" }', "[1, 2]", "99999999999999999999")


def is_read(read, text):
    """Whether it becomes a case; a refusal must be one line, and anything else is an error."""
    try:
        return read(text, pixels())
    except CoreError as error:
        lines = str(error).splitlines()
    assert len(lines) == 1, text
    return None


def test_whatever_stands_in_a_field_ends_in_a_case_or_in_one_line(read):
    lines = WHOLE.splitlines()
    places = [k for k, line in enumerate(lines) if " = " in line]
    read(WHOLE, pixels())
    refusals = 0
    for place in places:
        for junk in JUNK:
            name = lines[place].split(" = ")[0]
            text = "\n".join([*lines[:place], f"{name} = {junk}", *lines[place + 1 :]])
            refusals += not is_read(read, text)
    assert refusals > 0.8 * len(places) * len(JUNK)
