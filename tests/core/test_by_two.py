"""Two effects found together: what they must bring to be told at all."""

from types import SimpleNamespace

import pytest

from core import by_two as module
from core.by_two import by_two
from core.time_layer import EVIDENCE, Candidate


@pytest.mark.parametrize(("evidence", "verdict"), [(1.5, "explained"), (0.5, "unexplained")])
def test_two_effects_without_evidence_tell_nothing(monkeypatch, evidence, verdict):
    """However much of a little they take: so may chance."""
    fit = SimpleNamespace(law=SimpleNamespace(effects=()))
    both = Candidate(("contact", "relaxation"), fit, evidence * EVIDENCE, 0.99, 0.99)
    for name, value in {
        "pairs": [both],
        "to_their_end": [both],
        "exchanged": [both],
        "polished": [both],
        "sufficient": True,
        "is_broken": False,
        "one_of": None,
        "strays": False,
        "vetoed": False,
        "turned": fit,
    }.items():
        monkeypatch.setattr(module, name, lambda *_, _value=value, **__: _value)
    monkeypatch.setattr(module, "judge", lambda names, *_: Candidate(names, fit, 1.0, 1.0, 1.0))
    told = by_two(((None, fit),), ([], (), [], {}), 0.1, lambda found, effects: found)
    assert told.verdict == verdict
    assert [c.names for c in told.effects] == [("contact",), ("relaxation",)] * (evidence > 1)
