"""What pitches and shapes add to a verdict in time."""

import pytest

from core.findings import Findings, _unsure


@pytest.mark.parametrize("declared", [(1.0, 1.0), (0.9, 1.2)])
def test_a_body_that_may_be_another_one_has_a_modulus_as_unsure_as_that(declared):
    moduli = dict.fromkeys((0, 2), declared)
    plain = Findings("explained", [], [], [], ["as it was"], moduli=moduli)
    assert _unsure(plain, []) is plain
    soft = {0: (1.1, 1.25), 2: (1.0, 1.1)}
    graded = {0: (0.8, 0.95), 2: (0.9, 1.05)}
    found = _unsure(plain, [("compliant_pin", soft), ("graded_stiffness", graded)])
    low, high = declared
    assert found.modulus_span(0) == pytest.approx((0.8 * low, 1.25 * high))
    assert found.modulus_span(2) == pytest.approx((0.9 * low, 1.1 * high))
    assert found.modulus_span(1) == (1.0, 1.0) and found.verdict == "explained"
    assert found.warnings[:-1] == ["as it was"]
    assert "compliant_pin or graded_stiffness" in found.warnings[-1]
