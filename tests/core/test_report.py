"""report.json: the contract's form is kept to the letter, and the file is whole or absent."""

import copy
import json

import numpy as np
import pytest

from core.data import Estimate
from core.errors import CaseError
from core.report import (
    check_report,
    check_ringdown,
    estimate,
    estimate_of,
    write_report,
    write_ringdown,
)
from core.tell import _turn, told_claim


@pytest.fixture
def report():
    return {
        "case": "beam",
        "version": "0.1.0",
        "seconds": 3.2,
        "mesh": {"nodes": 900, "tets": 3000, "element": "tet4", "stiffening": 0.18},
        "youngs_modulus": {
            "apparent": estimate(2.2e5, 2.1e5, 2.3e5, "Pa"),
            "material": estimate(2.6e5, 2.4e5, 2.8e5, "Pa"),
        },
        "modes": [
            {
                "natural_frequency_hz": estimate(7.74, 7.7, 7.8),
                "damping_ratio": estimate(0.05, 0.045, 0.055),
                "amplitude_m": 0.01,
                "model_frequency_hz": 7.74,
                "mac": 0.999,
            }
        ],
        "error": {
            "floor": 0.01,
            "before": 0.3,
            "after": 0.02,
            "chain": [
                {"added": None, "held_out": 0.3, "fit": 0.2},
                {"added": "relaxation", "held_out": 0.02, "fit": 0.015},
            ],
        },
        "diagnosis": {
            "verdict": "explained",
            "effects": [
                {
                    "name": "added_mass",
                    "parameters": {
                        "mass": estimate(0.05, 0.049, 0.051, "kg"),
                        "position": estimate([0.1, 0, 0], [0.09, -0.01, 0], [0.11, 0.01, 0], "m"),
                    },
                    "probability": 0.9,
                    "twins": ["compliant_pin"],
                }
            ],
            "ranking": [{"name": "added_mass", "held_out": 0.02, "probability": 0.9}],
            "budget": {"offset": 0.75, "second harmonic": 0.25},
            "advice": ["hang a known mass on the tip and film again"],
            "minor": [{"name": "air_drag", "share": 0.002}],
        },
        "warnings": [],
    }


def put(report, path, value):
    """A deep copy with `value` at the dotted path; a value of KeyError takes the key out."""
    changed = copy.deepcopy(report)
    *way, last = [int(key) if key.isdigit() else key for key in path.split(".")]
    place = changed
    for key in way:
        place = place[key]
    if value is KeyError:
        del place[last]
    else:
        place[last] = value
    return changed


def leaves(value, path=""):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield f"{path}{key}"
            yield from leaves(inner, f"{path}{key}.")


def test_a_report_of_the_contracts_form_passes(report):
    check_report(report)
    nulls = put(put(report, "modes.0.mac", None), "modes.0.model_frequency_hz", None)
    check_report(nulls)


def test_taking_out_any_field_is_noticed(report):
    free = ("diagnosis.budget.", "diagnosis.effects.")
    fields = [path for path in leaves(report) if not path.startswith(free)]
    assert len(fields) > 25
    for path in fields:
        with pytest.raises(ValueError, match=path.rsplit(".", 1)[-1]):
            check_report(put(report, path, KeyError))


def test_a_field_that_the_contract_does_not_know_is_noticed_on_every_level(report):
    for level in ("", "mesh.", "modes.0.", "error.", "error.chain.0.", "diagnosis.effects.0."):
        with pytest.raises(ValueError, match="extra"):
            check_report(put(report, f"{level}extra", 1))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("seconds", float("nan")),
        ("seconds", "3 s"),
        ("mesh.nodes", 0),
        ("mesh.tets", 3.5),
        ("mesh.stiffening", float("inf")),
        ("youngs_modulus.apparent.value", 3e5),
        ("youngs_modulus.apparent.ci95", [2.3e5, 2.1e5]),
        ("youngs_modulus.apparent.ci95", [float("nan"), 2.3e5]),
        ("youngs_modulus.apparent.unit", None),
        ("modes.0.natural_frequency_hz", 7.74),
        ("modes.0.amplitude_m", -0.1),
        ("modes.0.mac", 1.2),
        ("modes.0.mac", None),
        ("error.before", None),
        ("error.floor", True),
        ("error.chain.0.added", "relaxation"),
        ("diagnosis.verdict", "fine"),
        ("diagnosis.effects", []),
        ("diagnosis.effects.0.name", "magic"),
        ("diagnosis.effects.0.twins", ["magic"]),
        ("diagnosis.effects.0.probability", 1.1),
        ("diagnosis.effects.0.parameters.position.ci95", [[0, 0], [1, 1]]),
        ("diagnosis.budget.offset", 0.5),
        ("diagnosis.advice", "film again"),
        ("warnings", [3]),
    ],
)
def test_a_value_of_the_wrong_kind_is_noticed(report, path, value):
    with pytest.raises(ValueError, match=path.split(".")[0]):
        check_report(put(report, path, value))


def test_a_refused_recording_may_leave_its_errors_open(report):
    refused = put(put(report, "diagnosis.verdict", "refused"), "error.after", None)
    check_report(refused)


def test_names_of_markers_are_a_parameter_without_an_interval(report):
    names = {"value": ["tip", "ear"], "ci95": None, "unit": ""}
    check_report(put(report, "diagnosis.effects.0.parameters", {"markers": names}))
    wrong = {"markers": names | {"ci95": [0, 1]}}
    with pytest.raises(ValueError, match="markers"):
        check_report(put(report, "diagnosis.effects.0.parameters", wrong))


def test_what_is_read_back_is_what_was_written(report, tmp_path):
    report["mesh"]["nodes"] = np.int64(900)
    report["modes"][0]["amplitude_m"] = np.float64(1 / 3)
    write_report(report, tmp_path / "report.json")
    back = json.loads((tmp_path / "report.json").read_text())
    assert back["mesh"]["nodes"] == 900
    assert back["modes"][0]["amplitude_m"] == pytest.approx(1 / 3, rel=1e-11)
    check_report(back)


def test_an_estimate_carries_its_unit_only_where_asked():
    noun = Estimate(2.0, 1.0, 3.0, "Pa")
    assert estimate_of(noun) == {"value": 2.0, "ci95": [1.0, 3.0], "unit": "Pa"}
    assert estimate_of(noun, unit=False) == {"value": 2.0, "ci95": [1.0, 3.0]}


def test_a_wrong_report_leaves_the_old_file_and_no_scraps(report, tmp_path):
    path = tmp_path / "report.json"
    write_report(report, path)
    before = path.read_bytes()
    with pytest.raises(ValueError, match="seconds"):
        write_report(put(report, "seconds", float("nan")), path)
    assert path.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == ["report.json"]


def test_a_break_while_writing_leaves_the_old_file_and_no_scraps(report, tmp_path, monkeypatch):
    path = tmp_path / "report.json"
    write_report(report, path)
    before = path.read_bytes()

    def interrupted(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_report(put(report, "seconds", 9.0), path)
    assert path.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == ["report.json"]


def test_a_folder_that_is_not_there_is_refused_in_one_line(report, tmp_path):
    with pytest.raises(CaseError, match=r"nowhere.*cannot be written"):
        write_report(report, tmp_path / "nowhere" / "report.json")


@pytest.mark.parametrize("amplitude", ["amplitude_m", "amplitude_px"])
def test_a_ringdown_without_a_scale_gives_pixels(amplitude, tmp_path):
    axis = {amplitude: estimate(0.4, 0.39, 0.41), "phase_rad": estimate(1.0, 0.9, 1.1)}
    mode = {
        "natural_frequency_hz": estimate(128, 127.9, 128.1),
        "damping_ratio": estimate(0.001, 0.0008, 0.0012),
        amplitude: 0.4,
        "aliases_hz": [372.0],
        "deflection": [{"pixel": [20.0, 30.0], "u": axis, "v": axis}],
    }
    other = {"amplitude_px" if amplitude == "amplitude_m" else "amplitude_m": axis[amplitude]}
    unlike = [{"pixel": [20.0, 30.0], "u": axis, "v": axis | other}]
    write_ringdown({"modes": [mode], "warnings": []}, tmp_path / "ringdown.json")
    for wrong in (
        mode | {"mac": 1.0},
        mode | {"aliases_hz": [-3]},
        mode | {"deflection": unlike},
        {"aliases_hz": []},
    ):
        with pytest.raises(ValueError, match="modes"):
            check_ringdown({"modes": [wrong], "warnings": []})


def test_effects_stand_as_in_the_errors_chain():
    names = ["contact", "clock", "viscous_damping", "relaxation"]
    assert sorted(names, key=_turn) == ["viscous_damping", "clock", "contact", "relaxation"]


@pytest.mark.parametrize(
    ("claim", "words"),
    [
        (None, ""),
        (2.5e5, "4.0% above the claimed 2.5e+05 Pa, which is within its interval"),
        (4e5, "35.0% below the claimed 4e+05 Pa, which is outside its interval"),
    ],
)
def test_a_claimed_modulus_is_compared_with_and_told(claim, words):
    assert words in told_claim(claim, Estimate(2.6e5, 2.4e5, 2.8e5, "Pa"))
    assert bool(told_claim(claim, Estimate(2.6e5, 2.4e5, 2.8e5, "Pa"))) == bool(words)
