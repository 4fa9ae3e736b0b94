"""From a case to a report: planted truths, kept tetrahedra, refusals."""

import numpy as np
import pytest

from core.command import main
from core.pipeline import calibrate_case
from core.report import check_report
from tests.truth import make


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    truth = make("null", 4, folder)
    return folder, truth, calibrate_case(folder / "case.toml", tets=folder / "kept.npz")


def test_a_body_that_lacks_nothing_is_adequate(plain):
    _, truth, result = plain
    check_report(result.report)
    assert result.report["diagnosis"]["verdict"] == "adequate"
    error = result.report["error"]
    assert error["before"] < 1.3 * error["floor"]


def test_the_material_modulus_is_the_true_one(plain):
    _, truth, result = plain
    young = result.report["youngs_modulus"]["material"]["value"]
    assert abs(young / truth["youngs_modulus"] - 1) < 0.03


def test_pitch_and_damping_are_the_true_ones(plain):
    _, truth, result = plain
    mode = result.report["modes"][0]
    nearest = np.argmin(
        np.abs(np.array(truth["frequency_hz"]) - mode["natural_frequency_hz"]["value"])
    )
    assert abs(mode["natural_frequency_hz"]["value"] / truth["frequency_hz"][nearest] - 1) < 3e-3
    assert abs(mode["damping_ratio"]["value"] / truth["damping_ratio"][nearest] - 1) < 0.1


def test_kept_tetrahedra_give_the_same_report_again(plain):
    folder, _, result = plain
    again = calibrate_case(folder / "case.toml", tets=folder / "kept.npz").report
    first = dict(result.report)
    for report in (again, first):
        report.pop("seconds", None)
    assert again == first


def test_a_bake_swings_as_the_markers_were_predicted_to(plain):
    _, _, result = plain
    motion = result.motion
    assert motion.time[-1] == pytest.approx(result.time[-1])
    reach = np.abs(motion.shapes[:, :, 0] * motion.weights[0, 0]).max()
    assert reach > 0.2 * np.nanmax(np.abs(result.predicted - result.predicted[-1]))


@pytest.mark.slow
def test_coarse_meshes_need_other_moduli_for_one_material(tmp_path):
    make("null", 4, tmp_path)
    apparent, material = [], []
    for elements in (400, 1200, 3500):
        report = calibrate_case(tmp_path / "case.toml", elements=elements, element="p1").report
        apparent.append(report["youngs_modulus"]["apparent"]["value"])
        material.append(report["youngs_modulus"]["material"]["value"])
    assert np.ptp(apparent) > 0.1 * np.mean(apparent)
    assert np.ptp(material) < 0.02 * np.mean(material)


def test_what_is_refused_gets_one_line_and_nothing_is_written(tmp_path, capsys):
    make("null", 4, tmp_path)
    case = tmp_path / "case.toml"
    case.write_text(case.read_text().replace("density", "densty"))
    assert main(["calibrate", str(case), "--out", str(tmp_path / "report.json")]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "densty" in told and "density" in told
    assert not (tmp_path / "report.json").exists()
