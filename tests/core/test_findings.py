"""What pitches and shapes add to a verdict in time."""

from types import SimpleNamespace

import numpy as np
import pytest

from core.findings import Findings, _unsure


def suspect(name, modulus, least, most):
    return SimpleNamespace(
        effect=SimpleNamespace(name=name),
        hypothesis=SimpleNamespace(modulus=modulus),
        moduli=(np.array(least), np.array(most)),
    )


def test_a_body_that_may_be_another_one_has_a_modulus_as_unsure_as_that():
    plain = Findings("explained", [], [], [], ["as it was"])
    base = SimpleNamespace(modulus=100e3)
    assert _unsure(plain, [], base, (0, 2)) is plain
    soft = suspect("compliant_pin", 116e3, [0.9, 0.95], [1.1, 1.05])
    graded = suspect("graded_stiffness", 90e3, [0.9, 0.98], [1.1, 1.02])
    found = _unsure(plain, [soft, graded], base, (0, 2))
    assert found.modulus_span(0) == pytest.approx((0.81, 1.276))
    assert found.modulus_span(2) == pytest.approx((0.882, 1.218))
    assert found.modulus_span(1) == (1.0, 1.0) and found.verdict == "explained"
    assert "compliant_pin or graded_stiffness" in found.warnings[-1]
