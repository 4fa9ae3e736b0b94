"""When the loop names nothing: too little to decide by, or a cause that it does not know."""

import re

import numpy as np
import pytest

from core.case import read_case
from core.errors import RecordingError
from core.listen import listen
from core.pipeline import calibrate_case
from tests.truth import make

BOX = [(x, y, z) for x in (0, 0.1) for y in (0, 0.015) for z in (0, 0.015)]
FACES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))


def case(folder, motion, fps, seconds, noise=5e-6):
    """A bar on a pin with one marker that moves by motion(t) m upwards."""
    rng = np.random.default_rng(2)
    lines = [f"v {x} {y} {z}" for x, y, z in BOX] + ["f {} {} {} {}".format(*f) for f in FACES]
    (folder / "bar.obj").write_text("\n".join(lines))
    time = np.arange(int(seconds * fps)) / fps
    place = np.array([0.1, 0.0075, 0.015]) + np.outer(motion(time), [0, 0, 1])
    place += noise * rng.standard_normal(place.shape)
    rows = [f"{t:.9g}," + ",".join(f"{v:.9g}" for v in p) for t, p in zip(time, place, strict=True)]
    (folder / "tracks.csv").write_text("time,m.x,m.y,m.z\n" + "\n".join(rows))
    (folder / "case.toml").write_text(
        'name = "bar"\n[object]\nmesh = "bar.obj"\nlength_unit = "m"\ndensity = 1000.0\n'
        "[[pin]]\nbox = { min = [-0.001, -1, -1], max = [0.001, 1, 1] }\n"
        '[model]\ndeclared = ["viscous_damping"]\n[recording]\ntracks = "tracks.csv"\n'
        '[[marker]]\nname = "m"\nposition = [0.1, 0.0075, 0.015]\n'
    )
    return folder / "case.toml"


def declare(path, name):
    """The case with one more effect declared."""
    text, declared = path.read_text(), 'declared = ["viscous_damping"'
    assert declared in text
    path.write_text(text.replace(declared, f'{declared}, "{name}"'))
    return path


def swing(frequency, ratio, size=5e-3):
    w = 2 * np.pi * frequency
    return lambda t: size * np.exp(-ratio * w * t) * np.cos(w * np.sqrt(1 - ratio**2) * t)


def test_a_plain_ring_down_is_adequate(tmp_path):
    report = calibrate_case(case(tmp_path, swing(5, 0.03), 120, 4), elements=300).report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert not any(line.startswith("Without") for line in report["warnings"])


def test_what_the_found_effect_is_worth_to_youngs_modulus_is_told(tmp_path):
    """A branch of ratio r swings along: taken for plain stiffness it is 1 + r times as stiff."""
    ringing = swing(5, 0.03)
    report = calibrate_case(
        case(tmp_path, lambda t: ringing(t) + 1e-3 * np.exp(-t / 0.8), 120, 4), elements=300
    ).report
    (found,) = report["diagnosis"]["effects"]
    assert found["name"] == "relaxation"
    (line,) = [w for w in report["warnings"] if w.startswith("Without relaxation")]
    without, with_it = (float(n) for n in re.findall(r"([\d.e+]+) Pa", line))
    assert with_it == pytest.approx(report["youngs_modulus"]["material"]["value"], rel=1e-3)
    ratio = found["parameters"]["ratio"]["value"]
    assert without / with_it == pytest.approx(1 + ratio, rel=0.02)


def test_two_frames_a_swing_decide_nothing_and_the_advice_says_so(tmp_path):
    report = calibrate_case(case(tmp_path, swing(4.4, 0.01), 10, 12), elements=300).report
    assert report["diagnosis"]["verdict"] == "refused"
    assert "frames a swing" in report["diagnosis"]["advice"][0]


def test_few_frames_a_swing_are_warned_of_with_the_pitch_that_folds_to_it(tmp_path):
    report = calibrate_case(case(tmp_path, swing(7, 0.03), 10, 12), elements=300).report
    assert any("6.99" in line and "frames/s" in line for line in report["warnings"])


def test_a_motion_that_dies_within_one_swing_is_refused_in_one_line(tmp_path):
    path = case(tmp_path, swing(4, 0.7), 120, 2)
    with pytest.raises(RecordingError, match="dies within one swing"):
        calibrate_case(path, elements=300)


def test_a_case_goes_on_without_a_later_take_that_dies_within_one_swing(tmp_path):
    path = case(tmp_path, swing(4, 0.7), 120, 2)
    (tmp_path / "tracks.csv").rename(tmp_path / "stopped.csv")
    alone = calibrate_case(case(tmp_path, swing(5, 0.03), 120, 4), elements=300).report
    text = path.read_text()
    path.write_text(text.replace("[[marker]]", '[[take]]\ntracks = "stopped.csv"\n[[marker]]'))
    report = calibrate_case(path, elements=300).report
    assert report["diagnosis"]["verdict"] == "adequate" and "takes" not in report["error"]
    assert report["youngs_modulus"] == alone["youngs_modulus"]
    (line,) = [w for w in report["warnings"] if w not in alone["warnings"]]
    assert line.startswith("recording stopped.csv: the motion dies") and "without it" in line


def test_amplitudes_are_those_at_the_release_between_two_frames(tmp_path):
    path = case(tmp_path, swing(5, 0.08), 30, 4, noise=1e-6)
    path.write_text(path.read_text().replace("[[marker]]", "start = 0.05\n[[marker]]"))
    _, ring = listen(read_case(path).takes[0], None)
    pole = 2 * np.pi * 5 * (-0.08 + 1j * np.sqrt(1 - 0.08**2))
    assert ring.t0 == 0
    assert abs(ring.amplitude[0, 2] / (5e-3 * np.exp(0.05 * pole)) - 1) < 0.01


def test_an_instant_that_was_rounded_up_keeps_its_frame(tmp_path):
    path = case(tmp_path, swing(5, 0.08), 30, 4)
    path.write_text(path.read_text().replace("[[marker]]", "start = 0.066667\n[[marker]]"))
    data, _ = listen(read_case(path).takes[0], None)
    assert data.time[0] == 0 and len(data.time) == 118


@pytest.mark.parametrize(("seconds", "enough"), [(0.405, True), (0.395, False)])
def test_two_periods_are_counted_from_the_release_on(tmp_path, seconds, enough):
    path = case(tmp_path, swing(5, 0.03), 200, seconds + 0.0025, noise=1e-6)
    path.write_text(path.read_text().replace("[[marker]]", "start = 0\n[[marker]]"))
    take = read_case(path).takes[0]
    if enough:
        assert listen(take, None)[1].frequency[0] == pytest.approx(5, rel=1e-3)
    else:
        with pytest.raises(RecordingError, match="2 are needed"):
            listen(take, None)


def test_a_frame_that_was_exposed_around_the_release_bends_no_pitch(tmp_path):
    def seen(t):
        return swing(5, 0.08)(t) * np.where(t > 0, 1.0, 0.6)

    path = case(tmp_path, seen, 100, 3, noise=1e-6)
    path.write_text(path.read_text().replace("[[marker]]", "start = 0\n[[marker]]"))
    data, ring = listen(read_case(path).takes[0], None)
    assert data.time[0] == pytest.approx(0.01)
    assert len(ring.frequency) == 1
    assert ring.frequency[0] == pytest.approx(5, rel=1e-4)
    assert np.abs(ring.amplitude).max() == pytest.approx(5e-3, rel=0.01)


@pytest.mark.slow
def test_a_pitch_that_jumps_all_at_once_is_not_called_a_drift(tmp_path):
    def cracked(t):
        w = 2 * np.pi * np.where(t < 1.4, 5.0, 4.6)
        phase = np.concatenate([[0], np.cumsum(w[:-1] * np.diff(t))])
        return 5e-3 * np.exp(-0.4 * t) * np.cos(phase)

    report = calibrate_case(case(tmp_path, cracked, 120, 5), elements=300).report
    assert report["diagnosis"]["verdict"] == "unexplained"


@pytest.mark.slow
def test_a_pitch_that_drifts_steadily_is_a_drift(tmp_path):
    def warmed(t):
        return 5e-3 * np.exp(-0.4 * t) * np.cos(2 * np.pi * (5.0 * t - 0.04 * t**2))

    report = calibrate_case(case(tmp_path, warmed, 120, 5), elements=300).report
    assert report["diagnosis"]["verdict"] == "explained"
    found = [e["name"] for e in report["diagnosis"]["effects"]]
    twins = [t for e in report["diagnosis"]["effects"] for t in e["twins"]]
    assert "stiffness_drift" in found + twins


def test_frames_that_were_dropped_are_counted(tmp_path):
    def skipped(t):
        index = np.arange(len(t))
        later = index + np.where(index >= 150, 2, 0) + np.where(index >= 260, 1, 0)
        return swing(5, 0.02)(later / 120)

    report = calibrate_case(case(tmp_path, skipped, 120, 4), elements=300).report
    (effect,) = report["diagnosis"]["effects"]
    assert effect["name"] == "lost_frames"
    assert effect["parameters"]["frames"]["value"] == 3
    assert report["error"]["after"] < 1.1 * report["error"]["floor"] < report["error"]["before"]


def test_gaps_in_the_tracks_are_no_effect(tmp_path):
    path = case(tmp_path, swing(5, 0.03), 120, 4)
    rng, tracks = np.random.default_rng(5), path.with_name("tracks.csv")
    head, *rows = tracks.read_text().splitlines()
    rows = [
        ",".join(
            [row.split(",")[0]] + ["" if rng.random() < 0.3 else v for v in row.split(",")[1:]]
        )
        for row in rows
    ]
    tracks.write_text("\n".join([head, *rows]))
    report = calibrate_case(path, elements=300).report
    assert report["diagnosis"]["verdict"] == "adequate"


def crossed(folder, hung, gravity=True, sag=0.0):
    """The bar swinging up and down at 3.5 Hz and sideways at 5 Hz, where it should be one pitch,
    about a place `sag` m below where it is without its weight.
    """
    path = case(folder, swing(3.5 if hung else 5.0, 0.02), 120, 5)
    table = np.genfromtxt(folder / "tracks.csv", delimiter=",", names=True)
    sideways = table["my"] + swing(5.0, 0.02, 3e-3)(table["time"])
    rows = [
        f"{t:.9g},{x:.9g},{y:.9g},{z:.9g}"
        for t, x, y, z in zip(table["time"], table["mx"], sideways, table["mz"] - sag, strict=True)
    ]
    (folder / "tracks.csv").write_text("time,m.x,m.y,m.z\n" + "\n".join(rows))
    if gravity:
        shape = 'shape = "unloaded"\n' if sag else ""
        text = path.read_text().replace("density", f"gravity = [0, 0, -9.81]\n{shape}density")
        path.write_text(text)
    return path


def test_a_body_turned_over_tells_the_clock_however_its_marker_was_put(tmp_path):
    """A uniform cantilever sags by 1.545 g/w^2; the sag is seen in true metres, w in false time."""
    factor, put, true = 1.15, 0.0014, 10.0
    sag = 1.545 * 9.81 / (2 * np.pi * true) ** 2
    path = case(tmp_path, lambda t: swing(true / factor, 0.02, 2e-3)(t) + sag - put, 120, 4)
    (tmp_path / "tracks.csv").rename(tmp_path / "over.csv")
    case(tmp_path, lambda t: swing(true / factor, 0.02, 2e-3)(t) - sag - put, 120, 4)
    held = 'gravity = [0, 0, -9.81]\nshape = "unloaded"\ndensity'
    path.write_text(path.read_text().replace("density", held))
    alone = calibrate_case(path, elements=300).report
    over = '[[take]]\ntracks = "over.csv"\ngravity = [0, 0, 9.81]\nheld_out = false\n'
    path.write_text(path.read_text().replace("[[marker]]", f"{over}[[marker]]"))
    report = calibrate_case(path, elements=300).report
    assert alone["diagnosis"]["verdict"] == "adequate"  # the two errors are alike there
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["clock"]
    found = report["diagnosis"]["effects"][0]["parameters"]["factor"]
    assert found["value"] == pytest.approx(factor, rel=0.03)
    assert found["ci95"][0] < factor < found["ci95"][1]
    stiffer = [r["youngs_modulus"]["material"]["value"] for r in (report, alone)]
    assert stiffer[0] / stiffer[1] == pytest.approx(factor**2, rel=0.06)


def test_a_body_that_stands_and_hangs_tells_its_weight_though_one_pitch_is_heard(tmp_path):
    """A beam's own weight adds g/L times the integral of (1 - x) phi'^2 over that of phi^2."""
    x, turns = np.linspace(0, 1, 2001), 1.8751
    ratio = (np.cosh(turns) + np.cos(turns)) / (np.sinh(turns) + np.sin(turns))
    y = turns * x
    phi = np.cosh(y) - np.cos(y) - ratio * (np.sinh(y) - np.sin(y))
    tension = ((1 - x) * np.gradient(phi, x) ** 2).sum() / (phi**2).sum()
    free, more = (2 * np.pi * 5.0) ** 2, tension * 9.81 / 0.1
    stands, hangs = (np.sqrt(free + way * more) / (2 * np.pi) for way in (-1, 1))
    path = case(tmp_path, swing(5.0, 0.02, 2e-3), 120, 4)
    plain = calibrate_case(path, elements=300).report["youngs_modulus"]["material"]["value"]
    case(tmp_path, swing(hangs, 0.02, 2e-3), 120, 4)
    (tmp_path / "tracks.csv").rename(tmp_path / "hangs.csv")
    case(tmp_path, swing(stands, 0.02, 2e-3), 120, 4)
    over = '[[take]]\ntracks = "hangs.csv"\ngravity = [9.81, 0, 0]\n[[marker]]'
    text = path.read_text().replace("density", "gravity = [-9.81, 0, 0]\ndensity")
    path.write_text(text.replace("[[marker]]", over))
    report = calibrate_case(path, elements=300).report
    assert report["diagnosis"]["verdict"] == "explained"
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["gravity_preload"]
    assert report["youngs_modulus"]["material"]["value"] == pytest.approx(plain, rel=0.02)
    assert report["error"]["before"] > 10 * report["error"]["after"]


@pytest.mark.slow
@pytest.mark.parametrize("lump", [0.0, 0.005])
def test_a_known_mass_on_top_tells_one_that_nobody_declared_though_one_pitch_is_heard(
    tmp_path, lump
):
    """Rayleigh: 33/136 of a cantilever swings with what sits at its tip."""
    body, known = 33 / 136 * 1000.0 * 0.1 * 0.015**2, 0.004
    bare, laden = (20.0 * np.sqrt(body / (body + lump + more)) for more in (0.0, known))
    case(tmp_path, swing(laden, 0.02, 2e-3), 240, 2)
    (tmp_path / "tracks.csv").rename(tmp_path / "laden.csv")
    path = case(tmp_path, swing(bare, 0.02, 2e-3), 240, 2)
    inside = "position = [0.1, 0.0075, 0.0075]"  # at half height nothing moves lengthwise
    path.write_text(path.read_text().replace("position = [0.1, 0.0075, 0.015]", inside))
    alone = calibrate_case(path, elements=300).report
    load = f"load = [{{ mass = {known}, position = [0.1, 0.0075, 0.0075] }}]"
    over = f'[[take]]\ntracks = "laden.csv"\n{load}\n[[marker]]'
    path.write_text(path.read_text().replace("[[marker]]", over))
    report = calibrate_case(path, elements=300).report
    assert alone["diagnosis"]["verdict"] == "adequate"  # one pitch goes into Young's modulus
    moduli = [r["youngs_modulus"]["material"]["value"] for r in (report, alone)]
    heavier = 1 + lump / body
    assert moduli[0] / moduli[1] == pytest.approx(heavier, rel=0.1)
    if not lump:
        assert report["diagnosis"]["verdict"] == "adequate"
        return
    assert report["diagnosis"]["verdict"] == "explained"
    (effect,) = report["diagnosis"]["effects"]
    assert effect["name"] == "added_mass"
    mass = effect["parameters"]["mass"]
    assert mass["value"] == pytest.approx(lump, rel=0.2)
    assert mass["ci95"][0] < lump < mass["ci95"][1]
    assert report["error"]["before"] > 10 * report["error"]["after"]


@pytest.mark.slow
def test_a_known_mass_that_hangs_on_a_soft_body_is_no_other_mass(tmp_path):
    """Its weight stiffens, too: by 1.2 times that over the length, as of a string's first half."""
    body, known = 33 / 136 * 1000.0 * 0.1 * 0.015**2, 0.004
    stiff = body * (2 * np.pi * 3.0) ** 2
    laden = np.sqrt((stiff + 1.2 * known * 9.81 / 0.1) / (body + known)) / (2 * np.pi)
    case(tmp_path, swing(laden, 0.02, 2e-3), 120, 4)
    (tmp_path / "tracks.csv").rename(tmp_path / "laden.csv")
    path = case(tmp_path, swing(3.0, 0.02, 2e-3), 120, 4)
    load = f"load = [{{ mass = {known}, position = [0.1, 0.0075, 0.0075] }}]"
    over = f'[[take]]\ntracks = "laden.csv"\n{load}\n[[marker]]'
    text = path.read_text().replace("density", "gravity = [9.81, 0, 0]\ndensity")
    text = text.replace("position = [0.1, 0.0075, 0.015]", "position = [0.1, 0.0075, 0.0075]")
    path.write_text(text.replace("[[marker]]", over))
    report = calibrate_case(path, elements=300).report
    assert report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
def test_a_hanging_mass_is_told_by_the_swing_that_it_leaves_alone(tmp_path):
    (tmp_path / "plain").mkdir()
    plain = calibrate_case(crossed(tmp_path / "plain", hung=False), elements=300).report
    report = calibrate_case(crossed(tmp_path, hung=True), elements=300).report
    assert plain["diagnosis"]["verdict"] == "adequate"
    assert report["diagnosis"]["effects"][-1]["name"] == "added_mass"
    moduli = [r["youngs_modulus"]["material"]["value"] for r in (plain, report)]
    assert moduli[1] == pytest.approx(moduli[0], rel=0.03)
    body = 1000.0 * 0.1 * 0.015**2
    tip = 0.2427 * body * ((5.0 / 3.5) ** 2 - 1)  # Rayleigh: 33/136 of a cantilever swings
    low, high = report["diagnosis"]["effects"][-1]["parameters"]["mass"]["ci95"]
    assert low < 1.1 * tip and high > tip


@pytest.mark.slow
def test_the_sag_that_is_told_is_that_of_the_body_with_what_was_found_on_it(tmp_path):
    body = 1000.0 * 0.1 * 0.015**2
    tip = 0.2427 * body * ((5.0 / 3.5) ** 2 - 1)
    sag = 9.81 * (tip + 0.375 * body) / (0.2427 * body * (2 * np.pi * 5.0) ** 2)
    report = calibrate_case(crossed(tmp_path, hung=True, sag=sag), elements=300).report
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["added_mass"]
    (line,) = [w for w in report["warnings"] if w.startswith("Sag of")]
    measured, predicted = (float(x) for x in re.findall(r"([0-9][-+.e0-9]*) m ", line))
    assert measured == pytest.approx(sag, rel=0.02)
    assert predicted == pytest.approx(sag, rel=0.1)  # the bare body sags a fifth less
    for mode in report["modes"]:  # the bare body's first pitch is 43 % higher
        measured = mode["natural_frequency_hz"]["value"]
        assert mode["model_frequency_hz"] == pytest.approx(measured, rel=0.03)


@pytest.mark.slow
def test_a_ring_down_that_foretells_the_tail_is_modes_and_no_effect(tmp_path):
    truth = make("added_mass", 1, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert [e["name"] for e in diagnosis["effects"]] == truth["effects"]


@pytest.mark.slow
def test_a_declared_load_on_a_soft_top_is_no_effect(tmp_path):
    make("null", 83, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
def test_a_load_that_brings_out_a_mode_below_what_is_heard_first_is_no_effect(tmp_path):
    make("null", 73865, tmp_path)
    assert calibrate_case(tmp_path / "case.toml").report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
def test_a_marker_that_wanders_at_random_is_set_aside(tmp_path):
    truth = make("tracker_drift", 131, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    (found,) = report["diagnosis"]["effects"]
    assert found["name"] == "tracker_drift"
    assert (
        found["parameters"]["markers"]["value"] == truth["parameters"]["tracker_drift"]["markers"]
    )


def test_a_mode_that_goes_unheard_beside_a_strong_one_is_tried(tmp_path):
    make("asymmetric_stiffness", 617, tmp_path)  # a bar that swings both ways, bent by a stop
    result = calibrate_case(tmp_path / "case.toml")
    assert {0, 1} <= set(result.heard.match.modes)
    assert [e["name"] for e in result.report["diagnosis"]["effects"]] == ["asymmetric_stiffness"]


@pytest.mark.slow
def test_a_second_cause_is_not_hidden_by_a_close_mode_that_both_bend(tmp_path):
    make("stiffness_drift", 802, tmp_path)  # a bracket whose first modes lie 7 % apart
    result = calibrate_case(tmp_path / "case.toml")
    assert {0, 1} <= set(result.heard.match.modes)
    diagnosis = result.report["diagnosis"]
    assert [e["name"] for e in diagnosis["effects"]] == ["stiffness_drift"]
    assert diagnosis["verdict"] == "explained"


@pytest.mark.slow
def test_a_steady_line_is_found_beside_what_makes_a_dying_one_do_as_well(tmp_path):
    truth = make("two:steady_drive+stiffness_drift", 801, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert {e["name"] for e in diagnosis["effects"]} == set(truth["effects"])


@pytest.mark.slow
def test_what_leaves_much_of_the_tail_does_not_explain_it(tmp_path):
    make("absent:stick_slip", 801, tmp_path)  # friction takes most of it, and still is another law
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "unexplained"


@pytest.mark.slow
def test_a_stop_whose_overtones_outnumber_the_modes_is_heard_all_the_same(tmp_path):
    make("contact", 803, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert [e["name"] for e in diagnosis["effects"]] == ["contact"]


@pytest.mark.slow
def test_a_small_second_effect_counts_where_it_leaves_nothing(tmp_path):
    truth = make("two:lost_frames+relaxation", 804, tmp_path)  # the one is a seventh of the other
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert {e["name"] for e in diagnosis["effects"]} == set(truth["effects"])


@pytest.mark.slow
def test_what_is_seen_but_immaterial_leaves_the_model_adequate(tmp_path):
    make("trap:density", 804, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "adequate"


@pytest.mark.slow
def test_a_second_mode_of_nearly_the_first_ones_pitch_is_no_hum(tmp_path):
    """A search needs a while until the two have come apart."""
    make("trap:density", 604419, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "adequate" and not diagnosis["effects"]


@pytest.mark.slow
def test_a_body_answers_to_the_support_that_a_marker_shows_to_move(tmp_path):
    make("base_motion", 806, tmp_path)  # at the pitch of its first mode, nearly
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["effects"][0]["name"] == "base_motion"
    assert report["diagnosis"]["verdict"] == "explained"
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]


@pytest.mark.slow
def test_the_swing_of_a_support_is_told_through_all_the_bodys_modes(tmp_path):
    truth = make("steady_drive", 805, tmp_path)  # half-way between two modes of a bar
    report = calibrate_case(tmp_path / "case.toml").report
    told = report["diagnosis"]["effects"][0]["parameters"]["amplitude"]
    assert told["value"] == pytest.approx(
        truth["parameters"]["steady_drive"]["amplitude"], rel=0.05
    )


@pytest.mark.slow
def test_what_the_camera_does_not_see_of_a_motion_counts_in_its_amplitude(tmp_path):
    truth = make("large_amplitude", 931, tmp_path)  # seen aslant: 5 % of the swing is hidden
    report = calibrate_case(tmp_path / "case.toml").report
    told = report["diagnosis"]["effects"][0]["parameters"]["shift_per_metre2"]
    low, high = told["ci95"]
    assert low < truth["parameters"]["large_amplitude"]["shift_per_metre2"] < high


@pytest.mark.slow
def test_two_close_modes_that_mimic_what_bends_one_do_not_hide_it(tmp_path):
    make("large_amplitude", 808, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["large_amplitude"]


@pytest.mark.slow
def test_what_is_far_off_where_it_was_held_out_is_not_adequate(tmp_path):
    make("lost_frames", 931, tmp_path)  # doubled where nothing was fitted, eight times the noise
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["error"]["before"] > 4 * report["error"]["floor"]
    assert report["diagnosis"]["verdict"] != "adequate"


@pytest.mark.slow
def test_a_change_of_the_body_shows_beside_a_damping_that_nobody_declared(tmp_path):
    make("graded_stiffness", 805, tmp_path)
    case = tmp_path / "case.toml"
    text = case.read_text()
    assert 'declared = ["viscous_damping"]' in text
    case.write_text(text.replace('declared = ["viscous_damping"]', "declared = []"))
    report = calibrate_case(case).report
    damping, graded = (e["name"] for e in report["diagnosis"]["effects"])
    assert damping in ("viscous_damping", "structural_damping")
    assert graded == "graded_stiffness"
    chain = report["error"]["chain"]
    assert [row["added"] for row in chain] == [None, damping, graded]
    undamped, damped, all_told = (row["held_out"] for row in chain)
    assert undamped > damped > 2 * all_told
    assert all_told < 1.1 * report["error"]["floor"]


@pytest.mark.slow
def test_a_near_camera_that_the_rest_places_show_is_no_uneven_stiffness(tmp_path):
    make("perspective", 940, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert [e["name"] for e in diagnosis["effects"]] == ["perspective"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed", "names", "most"),
    [
        pytest.param(
            "viscous_damping", 8125, {"viscous_damping"}, 1.1,
            id="two close modes settle where they were heard",
        ),
        pytest.param(
            "compliant_pin", 8125, {"compliant_pin"}, 1.2,
            id="a pair that a load parts in one take is no effect in time",
        ),
        pytest.param(
            "two:steady_drive+air_drag", 6755, {"steady_drive", "air_drag"}, 1.4,
            id="free modes that run off do not stand for a second effect",
        ),
        pytest.param(
            "two:dry_friction+stiffness_drift", 85021, {"dry_friction", "stiffness_drift"}, 1.4,
            id="a rub that weakens does not stand in for a rub and a drift",
        ),
        pytest.param(
            "two:relaxation+large_amplitude", 37049, {"relaxation", "large_amplitude"}, 1.1,
            id="an uneven stiffness bends itself to do nearly what two others do",
        ),
        pytest.param(
            "large_amplitude", 40350, {"large_amplitude"}, 1.1,
            id="a search that stops short in a bent valley does not lose to a drift",
        ),
        pytest.param(
            "stiffness_drift", 7642, {"stiffness_drift"}, 1.1,
            id="two near modes without symmetry are two, and both drift",
        ),
        pytest.param(
            "split_modes", 7643, {"split_modes"}, 1.1,
            id="a partner that would part further than it may is none",
        ),
        pytest.param(
            "split_modes", 67688, {"split_modes"}, 1.1,
            id="the pair that is split need not be the strongest mode's",
        ),
        pytest.param(
            "split_modes", 90213, {"split_modes"}, 1.1,
            id="a pair that is split far has its pitch in the middle",
        ),
        pytest.param(
            "split_modes", 516752, {"split_modes"}, 1.1,
            id="a pair that hardly begins to beat is opened",
        ),
        pytest.param(
            "split_modes", 173205, {"split_modes"}, 1.1,
            id="two pitches of a pair that only meshing parts are a split pair's",
        ),
        pytest.param(
            "two:added_mass+relaxation", 173205, {"added_mass", "relaxation"}, 1.1,
            id="poles that tell all but a small effect are a heavily laden body's",
        ),
        pytest.param(
            "added_mass", 905239, {"added_mass"}, 1.1,
            id="all that swings is a laden body's, of whose modes the plain one lacks two",
        ),
        pytest.param(
            "rolling_shutter", 67690, {"rolling_shutter"}, 1.2,
            id="a pair's other direction shows once the rows are known to be late",
        ),
        pytest.param(
            "rolling_shutter", 61502, {"rolling_shutter"}, 1.1,
            id="a pair's ellipse takes up the rows that lag, the body's own directions do not",
        ),
        pytest.param(
            "steady_drive", 92656, {"steady_drive"}, 1.1,
            id="a line that stays while the modes die is none of them",
        ),
        pytest.param(
            "air_drag", 92655, {"air_drag"}, 1.1,
            id="a further mode that another one pushes to its bound has stood in for a force",
        ),
        pytest.param(
            "tracker_drift", 92655, {"tracker_drift"}, 1.1,
            id="beside a pair's pitch its other direction is no further mode",
        ),
        pytest.param(
            "large_amplitude", 67691, {"large_amplitude"}, 1.1,
            id="what bends one direction of a pair is no split",
        ),
        pytest.param(
            "added_mass", 82438, {"added_mass"}, 1.1,
            id="a mass that parts a pair is told by the other pitches",
        ),
        pytest.param(
            "perspective", 82439, {"perspective"}, 1.1,
            id="a near lens shows a mode that moves towards it",
        ),
        pytest.param(
            "perspective", 82440, {"perspective"}, 1.1,
            id="two faint modes within their width sound as one, and tell of no mass",
        ),
        pytest.param(
            "gravity_preload", 94140, {"gravity_preload"}, np.inf,
            id="two modes that lie near turn into one another",
        ),
        pytest.param(
            "steady_drive", 94141, {"steady_drive"}, 1.1,
            id="a drive that beats with what it rings is no second blow",
        ),
        pytest.param(
            "dry_friction", 94142, {"dry_friction"}, 1.4,
            id="a rub that weakens must tell what was fitted better, not what was held out alone",
        ),
        pytest.param(
            "dry_friction", 40351, {"dry_friction"}, 1.2,
            id="a search for a rub begins with less damping than it makes",
        ),
        pytest.param(
            "dry_friction", 61501, {"dry_friction"}, 1.2,
            id="what shows late is not judged by half of the record",
        ),
        pytest.param(
            "air_drag", 109881, {"air_drag"}, 1.2,
            id="a mode that has become another one leaves its own free",
        ),
        pytest.param(
            "aliasing", 61503, {"aliasing"}, 1.2,
            id="a fold near nought looks heavily damped",
        ),
        pytest.param(
            "two:lost_frames+relaxation", 93968, {"lost_frames", "relaxation"}, 1.9,
            id="frames lost after the fitted part show beside what acts in it",
        ),
        pytest.param(
            "two:lost_frames+relaxation", 271103, {"lost_frames", "relaxation"}, 1.3,
            id="frames lost where nothing was fitted gain nothing there, and are sought too",
        ),
        pytest.param(
            "lost_frames", 994377, {"lost_frames"}, 1.1,
            id="two jumps close together look like one",
        ),
        pytest.param(
            "stiffness_drift", 271103, {"stiffness_drift"}, 1.1,
            id="a quiet fit that foretells badly lacks a mode",
        ),
        pytest.param(
            "added_mass", 141503, {"added_mass"}, 2.5,
            id="a mass parts one pair more than can be heard, and the others",
        ),
        pytest.param(
            "relaxation", 687816, {"relaxation"}, 1.1,
            id="a mean that creeps is no mode of which two periods are wanted",
        ),
        pytest.param(
            "two:relaxation+dry_friction", 72003, {"relaxation", "dry_friction"}, 1.8,
            id="a line at a pitch does not stand in for a rub",
        ),
        pytest.param(
            "two:compliant_pin+dry_friction", 772001, {"compliant_pin", "dry_friction"}, 1.4,
            id="a rub bends no pitches as a soft pin does, whichever mode is which",
        ),
        pytest.param(
            "two:compliant_pin+dry_friction", 368665, {"compliant_pin", "dry_friction"}, 1.3,
            id="a rub that bends what was heard hides no soft pin",
        ),
        pytest.param(
            "two:compliant_pin+dry_friction", 161803, {"compliant_pin", "dry_friction"}, 1.8,
            id="a faint mode that a rub made sound elsewhere leaves the others their pitches",
        ),
        pytest.param(
            "two:compliant_pin+dry_friction", 577215, {"compliant_pin", "dry_friction"}, 4.5,
            id="a motion that is read off the record gives way to a mode of the body",
        ),
        pytest.param(
            "two:base_motion+large_amplitude", 161803, {"base_motion", "large_amplitude"}, 1.1,
            id="a support that shakes as a whole below all pitches is no high mode",
        ),
        pytest.param(
            "plane:base_motion", 772002, {"base_motion"}, 1.4,
            id="a support that shakes both ways shakes the body both ways",
        ),
        pytest.param(
            "two:relaxation+large_amplitude", 93968, {"relaxation", "large_amplitude"}, 1.1,
            id="from one of two twins a short way leads to the other",
        ),
        pytest.param(
            "two:large_amplitude+tracker_drift", 450839, {"large_amplitude", "tracker_drift"}, 1.1,
            id="from what drifts with time to what bends with amplitude, on growing shares",
        ),
        pytest.param(
            "dry_friction", 450840, {"dry_friction"}, 1.1,
            id="a rub that led by half of the record and came to nothing is sought anew",
        ),
        pytest.param(
            "dry_friction", 460175, {"dry_friction"}, 1.1,
            id="the place that promises most of many may be a chance one",
        ),
        pytest.param(
            "dry_friction", 460177, {"dry_friction"}, 1.1,
            id="a rub that is off ahead though it tells what was fitted is sought anew",
        ),
        pytest.param(
            "rolling_shutter", 460177, {"rolling_shutter"}, 1.1,
            id="what late rows sound like at twice a pitch is no mode",
        ),
        pytest.param(
            "perspective", 910007, {"perspective"}, 1.1,
            id="a near lens looks at the picture's middle, not at the object's origin",
        ),
        pytest.param(
            "compliant_pin", 993311, {"compliant_pin"}, 1.1,
            id="a body that is struck was still, however few of its swings were filmed",
        ),
        pytest.param(
            "added_mass", 41005, {"added_mass"}, 1.1,
            id="a mass that bends the strongest mode beyond knowing leaves the others theirs",
        ),
    ],
)  # fmt: skip
def test_what_was_planted_is_named_and_nothing_else(kind, seed, names, most, tmp_path):
    make(kind, seed, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert {e["name"] for e in report["diagnosis"]["effects"]} == names
    assert report["error"]["after"] < most * report["error"]["floor"]


@pytest.mark.slow
def test_a_second_one_is_sought_beside_what_fits_best_too(tmp_path):
    """Not only beside what foretells best; a creep and an uneven stiffness are twins here, and
    rounding decides which is named.
    """
    make("two:relaxation+dry_friction", 72001, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    named = {e["name"]: e["twins"] for e in report["diagnosis"]["effects"]}
    assert len(named) == 2
    assert "dry_friction" in named
    assert "relaxation" in named or "relaxation" in named.get("asymmetric_stiffness", ())
    assert report["error"]["after"] < 1.4 * report["error"]["floor"]


@pytest.mark.slow
def test_what_foretells_badly_alone_may_tell_most_of_what_was_fitted(tmp_path):
    """A rub, beside which a drift is found on some meshes and not on others."""
    make("two:dry_friction+stiffness_drift", 771001, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    names = {e["name"] for e in report["diagnosis"]["effects"]}
    assert "dry_friction" in names
    assert names <= {"dry_friction", "stiffness_drift"}


@pytest.mark.slow
def test_two_modes_that_ran_into_one_another_are_opened_again(tmp_path):
    """Four markers in a plane, and one direction of the pudding's pair is seen a tenth as far."""
    truth = make("null", 774365, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
    found = [mode["natural_frequency_hz"]["value"] for mode in report["modes"]]
    for pitch in truth["frequency_hz"][:2]:
        assert np.abs(np.array(found) / pitch - 1).min() < 0.002


@pytest.mark.slow
def test_a_trifle_that_tells_all_that_is_off_ahead_counts(tmp_path):
    """A drift, or its twin, beside a rub: which of them ends first turns on the last digits."""
    make("two:dry_friction+stiffness_drift", 460175, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    rub, other = sorted(report["diagnosis"]["effects"], key=lambda e: e["name"] != "dry_friction")
    assert rub["name"] == "dry_friction"
    assert "stiffness_drift" in (other["name"], *other["twins"])
    assert report["error"]["after"] < 1.2 * report["error"]["floor"]


@pytest.mark.slow
def test_a_declared_weight_is_in_the_body_and_no_effect(tmp_path):
    truth = make("gravity_preload", 7641, tmp_path)
    report = calibrate_case(declare(tmp_path / "case.toml", "gravity_preload")).report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert report["error"]["before"] < 1.1 * report["error"]["floor"]
    found = report["youngs_modulus"]["material"]["value"]
    assert found == pytest.approx(truth["youngs_modulus"], rel=0.03)


@pytest.mark.slow
def test_a_loud_mode_that_the_declared_body_does_not_have_puts_it_in_doubt(tmp_path):
    """A mass that more than halves the pitches, so that one computed mode only is matched."""
    truth = make("added_mass", 8126, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    (found,) = report["diagnosis"]["effects"]
    assert found["name"] == "added_mass" and report["diagnosis"]["verdict"] != "adequate"
    # meshes differ from run to run: of six, the mass was 2 % above to 16 % below the planted one
    mass = truth["parameters"]["added_mass"]["mass"]
    assert found["parameters"]["mass"]["value"] == pytest.approx(mass, rel=0.3)
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.2)


@pytest.mark.slow
def test_a_change_of_the_body_that_tells_most_of_its_pitches_is_named_as_a_part(tmp_path):
    """A lump on a corner of a bracket: how wide it sits moves one pitch by as much as it may."""
    truth = make("added_mass", 90210, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert [e["name"] for e in report["diagnosis"]["effects"]] == ["added_mass"]
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.1)  # without it a third off


@pytest.mark.slow
def test_a_pitch_that_bends_may_sound_as_two_modes_that_beat_one_of_which_is_none(tmp_path):
    make("stiffness_drift", 832277, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "explained"
    assert [e["name"] for e in diagnosis["effects"]] == ["stiffness_drift"]


@pytest.mark.slow
def test_a_drive_beside_a_mode_is_told_from_it(tmp_path):
    make("steady_drive", 583728, tmp_path)  # a twentieth below its pitch
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "explained"
    assert [e["name"] for e in diagnosis["effects"]] == ["steady_drive"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [73856, 128757], ids=["faint", "where pitches differ a little"])
def test_a_mode_that_no_body_has_there_is_told(seed, tmp_path):
    """An absorber inside, which rings by itself at a fiftieth or a fifth of the motion."""
    make("absent:tuned_absorber", seed, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "unexplained"
    assert any("has no such mode" in line for line in report["warnings"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed"), [("relaxation", 7643), ("lost_frames", 7641), ("compliant_pin", 7642)]
)
def test_what_is_declared_is_in_the_model_and_not_named(kind, seed, tmp_path):
    make(kind, seed, tmp_path)
    report = calibrate_case(declare(tmp_path / "case.toml", kind)).report
    assert report["diagnosis"]["verdict"] == "adequate" and not report["diagnosis"]["effects"]
    assert [row["added"] for row in report["error"]["chain"]] == [None]
    assert report["error"]["before"] < 1.1 * report["error"]["floor"]


@pytest.mark.slow
def test_well_measured_pitches_a_per_cent_apart_tell_another_poisson_ratio(tmp_path):
    make("poisson_ratio", 40353, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert [e["name"] for e in diagnosis["effects"]] == ["poisson_ratio"]


@pytest.mark.slow
def test_the_pitch_of_a_faint_mode_names_no_change_of_the_body(tmp_path):
    make("null", 40358, tmp_path)  # two close ones, a thousandth of the loudest, taken for one
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "adequate"


@pytest.mark.slow
def test_a_weak_mode_that_is_but_a_share_of_a_loud_one_makes_nothing_of_nothing(tmp_path):
    make("null", 37058, tmp_path)  # its pitch runs into that of the loud one
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "adequate"


@pytest.mark.slow
def test_a_pitch_that_hangs_on_how_a_load_sits_is_no_strangers(tmp_path):
    make("null", 71205, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
def test_close_modes_that_foretell_all_of_a_loaded_take_are_no_effect(tmp_path):
    make("null", 185345, tmp_path)  # eight, two and two together
    assert calibrate_case(tmp_path / "case.toml").report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [85207, 85210, 14205])
def test_a_pair_that_a_load_parts_in_one_take_has_a_partner_there(seed, tmp_path):
    make("null", seed, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert diagnosis["verdict"] == "adequate"


@pytest.mark.slow
def test_modes_that_one_load_alone_shows_are_no_effect(tmp_path):
    make("null", 14200, tmp_path)  # so heavy that nearly all pitches and shapes are others
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert report["error"]["before"] < 1.1 * report["error"]["floor"]


@pytest.mark.slow
def test_near_modes_that_a_coarse_mesh_has_nearer_are_no_split_pair(tmp_path):
    """Of a bracket, at 4.31 and 4.39 Hz; a coarse mesh has them 0.3 % apart."""
    make("mesh_stiffening", 905239, tmp_path)
    report = calibrate_case(tmp_path / "case.toml", elements=100).report
    assert report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
def test_a_pair_that_is_faint_beside_loud_modes_is_no_effect(tmp_path):
    make("null", 994380, tmp_path)  # within their width, a two-hundredth of the motion
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert report["error"]["before"] < 1.1 * report["error"]["floor"]


@pytest.mark.slow
def test_a_trifle_in_time_does_not_hide_what_the_sag_says(tmp_path):
    truth = make("clock", 37052, tmp_path)  # its sag is a quarter off
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["effects"][0]["name"] == "clock"
    modulus = report["youngs_modulus"]["material"]["value"]
    assert abs(modulus / truth["youngs_modulus"] - 1) < 0.03


@pytest.mark.slow
def test_modes_that_a_loaded_take_alone_leaves_are_no_effect(tmp_path):
    make("null", 109885, tmp_path)  # four of them, heavily damped, within a tone
    assert calibrate_case(tmp_path / "case.toml").report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
def test_a_mode_that_goes_astray_in_a_loaded_take_alone_is_none_of_the_shared_ones(tmp_path):
    make("null", 128765, tmp_path)  # it takes the place of one that this load alone shows
    assert calibrate_case(tmp_path / "case.toml").report["diagnosis"]["verdict"] == "adequate"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("poisson_ratio", 109880),  # two near modes turn into one another
        ("aliasing", 109883),  # a mode that was not matched is folded, too
        ("base_motion", 109881),  # a line of the camera's lies where a fold would
        ("lost_frames", 109883),  # a mode shows once the jump is known, and not in even steps
        ("added_mass", 109881),  # on a rim, between the surface's vertices
    ],
)
def test_what_is_planted_is_named_alone_with_nothing_left(kind, seed, tmp_path):
    truth = make(kind, seed, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert [e["name"] for e in report["diagnosis"]["effects"]] == [kind]
    assert report["diagnosis"]["verdict"] == "explained"
    modulus = report["youngs_modulus"]["material"]["value"]
    assert abs(modulus / truth["youngs_modulus"] - 1) < 0.03


@pytest.mark.slow
def test_a_body_that_nothing_known_explains_has_a_modulus_as_unsure_as_its_modes_say(tmp_path):
    """A mass that swings inside a bar shifts its first pitch to 82 % and leaves the second."""
    truth = make("absent:tuned_absorber", 673882, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "unexplained"
    low, high = report["youngs_modulus"]["material"]["ci95"]
    assert low < truth["youngs_modulus"] < high


@pytest.mark.slow
@pytest.mark.parametrize("seed", [542492, 542495, 526545])
def test_a_lump_is_found_where_it_sits_and_not_where_a_look_around_first_gets_stuck(seed, tmp_path):
    """Far from it, on a soft seat near the pins or round a corner, others do nearly as well."""
    truth = make("added_mass", seed, tmp_path)
    diagnosis = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    (found,) = diagnosis["effects"]
    assert diagnosis["verdict"] == "explained"
    mass, place = (truth["parameters"]["added_mass"][name] for name in ("mass", "position"))
    low, high = found["parameters"]["mass"]["ci95"]
    assert found["name"] == "added_mass" and low < mass < high
    assert found["parameters"]["mass"]["value"] == pytest.approx(mass, rel=0.15)
    assert np.linalg.norm(np.subtract(found["parameters"]["position"]["value"], place)) < 0.003


@pytest.mark.slow
def test_a_change_of_the_body_does_not_stand_in_for_what_still_shows_in_time(tmp_path):
    make("absent:pumped_stiffness", 526542, tmp_path)  # its side line is taken for a mode
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "unexplained"


@pytest.mark.slow
def test_what_foretells_worse_than_nothing_at_all_is_no_explanation(tmp_path):
    """A brake that ends a bar's swings: free modes foretell 18 times the motion, a creep 1.7."""
    make("absent:eddy_brake", 893632, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["error"]["before"] > 10 and report["diagnosis"]["verdict"] == "unexplained"


@pytest.mark.slow
def test_what_leaves_a_strip_to_stop_within_a_swing_is_no_explanation(tmp_path):
    """A brake at one place: a rub and a stop leave a tenth of what was off, and a damped mode."""
    make("absent:eddy_brake", 161804, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "unexplained"


@pytest.mark.slow
def test_a_pitch_that_a_twin_moves_names_no_change_of_the_body(tmp_path):
    """A strip that is stiffer one way creeps as well, for all that the record shows."""
    truth = make("asymmetric_stiffness", 526544, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    (found,) = report["diagnosis"]["effects"]
    assert "asymmetric_stiffness" in [found["name"], *found["twins"]]
    modulus = report["youngs_modulus"]["material"]  # by a mode that the stiffer side bends less
    low, high = modulus["ci95"]
    assert low < truth["youngs_modulus"] < high
    assert modulus["value"] == pytest.approx(truth["youngs_modulus"], rel=0.05)


@pytest.mark.slow
def test_a_rub_on_many_modes_is_sought_from_many_places(tmp_path):
    make("dry_friction", 687816, tmp_path)  # a pudding
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["effects"][0]["name"] == "dry_friction"


@pytest.mark.slow
def test_a_spring_that_softens_beside_a_moving_camera_is_told_as_no_drift(tmp_path):
    """It draws two modes of a bracket together; a drift does nearly as well."""
    truth = make("two:base_motion+large_amplitude", 450839, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert {e["name"] for e in report["diagnosis"]["effects"]} == {"base_motion", "large_amplitude"}
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed", "within"),
    [
        ("two:steady_drive+air_drag", 322897, 0.05),  # it led the strongest mode an octave away
        ("two:steady_drive+stiffness_drift", 640117, 0.02),  # with one more mode, unlike its own
        ("two:added_mass+relaxation", 289760, 0.1),  # a mode lies below the body's lowest
        ("two:added_mass+relaxation", 322897, 0.2),  # a twin bends the first mode, not the others
        ("two:relaxation+large_amplitude", 271829, 0.02),  # one stands in for both but for a little
    ],
)
def test_two_effects_are_told_together(tmp_path, kind, seed, within):
    truth = make(kind, seed, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert {e["name"] for e in report["diagnosis"]["effects"]} == set(truth["effects"])
    assert report["diagnosis"]["verdict"] == "explained"
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=within)
