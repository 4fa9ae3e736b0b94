"""Two effects found together: what they must bring to be told at all."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from core import by_two as module
from core import diagnosis
from core.by_two import by_two, or_their_twins
from core.effects import dry_friction, relaxation
from core.residual import EVIDENCE
from core.sufficiency import CLEARLY, CLEARLY_BOTH
from core.time_layer import Candidate
from core.verdict import Verdict
from tests.core.test_together import both_of, creeping_and_rubbed


@pytest.mark.parametrize(("evidence", "verdict"), [(1.5, "explained"), (0.5, "unexplained")])
def test_two_effects_without_evidence_tell_nothing(monkeypatch, evidence, verdict):
    """However much of a little they take: so may chance."""
    fit = SimpleNamespace(law=SimpleNamespace(effects=()), chi2=1.0, samples=1.0)
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


@pytest.mark.parametrize("broken", [False, True])
def test_two_that_are_no_explanation_lead_to_one_that_is(monkeypatch, broken):
    """If it tells as much as they do, and no sudden change tells more."""
    fit = SimpleNamespace(law=SimpleNamespace(effects=()), chi2=1.0, samples=1.0)
    both = Candidate(("contact", "dry_friction"), fit, 10 * EVIDENCE, 0.99, 0.99)
    alone, asked = Candidate(("dry_friction",), fit, 9.5 * EVIDENCE, 0.98, 0.98), []
    for name, value in {
        "pairs": [both],
        "to_their_end": [both],
        "exchanged": [both],
        "polished": [both],
        "sufficient": False,  # they need another body
        "is_broken": broken,
        "weakens": False,
        "twins_of": (),
    }.items():
        monkeypatch.setattr(module, name, lambda *_, _value=value, **__: _value)
    monkeypatch.setattr(module, "one_of", lambda *given: asked.append(given[3]) or alone)
    told = by_two(((None, fit),), ([], (), [], {}), 0.1, lambda found, effects: found)
    assert asked == [9 * EVIDENCE]
    assert told.verdict == ("unexplained" if broken else "explained")
    assert told.names == (() if broken else ("dry_friction",))


@pytest.mark.parametrize(
    ("left", "owing", "adding", "astray", "names"),
    [
        (1.0, True, True, False, ("split_modes", "base_motion")),
        (1.5, True, True, False, ("split_modes",)),
        (1.0, False, True, False, ("split_modes",)),
        (1.0, True, False, False, ("split_modes",)),
        (1.0, True, True, True, ("split_modes",)),
        (1.5, 1.0, False, True, ("split_modes",)),
        (1.5, 0.5, False, True, ("split_modes",)),
    ],
    ids=[
        "a cause",
        "more than noise is left",
        "none is owed",
        "not most of it",
        "off ahead",
        "both owe none",
        "both owe none, and the second takes half",
    ],
)
def test_what_one_effect_owes_has_a_cause_however_small_beside_the_first(
    monkeypatch, left, owing, adding, astray, names
):
    fit = SimpleNamespace(law=SimpleNamespace(effects=()), chi2=left, samples=1.0)
    both = Candidate(("split_modes", "base_motion"), fit, 10 * EVIDENCE, 0.99, 0.99)
    one = SimpleNamespace(**vars(fit))
    alone = Candidate(("split_modes",), one, 9 * EVIDENCE, 0.97, 0.98)
    for name, value in {
        "pairs": [both],
        "to_their_end": [both],
        "exchanged": [both],
        "polished": [both],
        "sufficient": True,
        "is_broken": False,
        "one_of": alone,
        "strays": astray,
        "vetoed": False,
        "turned": fit,
        "weakens": False,
        "twins_of": (),
        "adds": adding,
        "excess": 0.0,
    }.items():
        monkeypatch.setattr(module, name, lambda *_, _value=value, **__: _value)
    # True: both owe; a number: the two owe none, and the second takes such a share
    share = 1.0 if isinstance(owing, bool) else owing

    def owes(found, declared, clearly=CLEARLY):
        return owing if isinstance(owing, bool) else found is one or clearly != CLEARLY_BOTH

    monkeypatch.setattr(module, "owes", owes)
    judged = {("base_motion",): 1.0, ("split_modes",): 2.0, both.names: 2 * EVIDENCE}
    monkeypatch.setattr(
        module, "judge", lambda n, *_: Candidate(n, fit, judged.get(n, 1.0), share, share)
    )
    told = by_two(((None, fit),), ([alone], (), [], {}), 0.1, lambda found, effects: found)
    assert told.names == names and told.verdict == "explained"
    assert (told.rather is not None) == (owing == 1.0 and not isinstance(owing, bool))
    assert not told.rather or told.rather.names == both.names


@pytest.mark.parametrize(
    ("verdict", "lacks", "laws", "kept"),
    [
        ("unexplained", False, 0, False),
        ("explained", False, 0, True),
        ("unexplained", True, 0, True),
        ("unexplained", False, 1, True),
    ],
    ids=["nothing else explains it", "explained", "the two owe as well", "beside another law"],
)
def test_two_effects_take_the_place_of_one_that_stays_unexplained(
    monkeypatch, verdict, lacks, laws, kept
):
    monkeypatch.setattr(diagnosis, "_sharpened", lambda told: told)
    monkeypatch.setattr(diagnosis, "_lacks", lambda told: lacks)
    two = Verdict("explained", ((None, None),), (), (), (), ())
    one = SimpleNamespace(verdict=verdict, rather=two, laws=laws)
    assert diagnosis.with_both(one) is (None if kept else two)


@pytest.mark.parametrize("more", [True, False])
def test_of_what_stays_unexplained_two_are_parts_or_the_one_that_they_lead_to(monkeypatch, more):
    """A search for either alone that went astray is no reason to name what tells less."""
    found = creeping_and_rubbed()
    both = both_of(found, dry_friction.EFFECT, relaxation.EFFECT)
    astray = Candidate(("contact",), both.found, 2 * EVIDENCE, 0.4, 0.4)
    for name, value in {
        "pairs": [both],
        "to_their_end": [both],
        "exchanged": [both],
        "polished": [both],
        "sufficient": False,
        "adds": more,
    }.items():
        monkeypatch.setattr(module, name, lambda *_, _value=value, **__: _value)
    singles = ([], (astray,), [astray], {})
    told = by_two(((None, found),), singles, 0.1, lambda found, effects: found)
    assert told.verdict == "unexplained"
    names = ("dry_friction", "relaxation")
    if more:
        assert set(told.names) == set(names) and told.final is both.found
        return
    (part,) = told.effects
    assert part.evidence > astray.evidence
    assert part.names[0] in names and part.found.law.effects[-1].name == part.names[0]
    assert len(part.found.law.effects) == 1


@pytest.mark.parametrize(
    ("bends", "left", "verdict"),
    [(True, 1.2, "unexplained"), (False, 1.2, "explained"), (True, 1.0, "explained")],
    ids=["another body", "the same", "another, but less leaves noise"],
)
def test_two_that_tell_less_are_not_the_explanation_where_more_needs_another_body(
    monkeypatch, bends, left, verdict
):
    found = creeping_and_rubbed()
    more = both_of(found, dry_friction.EFFECT, relaxation.EFFECT)
    fit = replace(more.found, chi2=left * more.found.samples)
    names = "contact", "relaxation"
    less = replace(more, names=names, found=fit, evidence=more.evidence - 2 * EVIDENCE)
    for name, value in {
        "pairs": [more, less],
        "to_their_end": [more, less],
        "exchanged": [more, less],
        "polished": [more, less],
        "is_broken": False,
        "one_of": None,
        "strays": False,
        "bends_the_body": bends,
    }.items():
        monkeypatch.setattr(module, name, lambda *_, _value=value, **__: _value)
    monkeypatch.setattr(module, "sufficient", lambda c, *_, **__: c is less)
    told = by_two(((None, found),), ([], (), [], {}), 0.1, lambda found, effects: found)
    assert told.verdict == verdict
    assert set(told.names) == set((more if verdict == "unexplained" else less).names)


@pytest.mark.parametrize(
    ("share", "held", "shown"), [(0.7, 0.05, True), (0.7, -0.1, False), (0.5, 0.05, False)]
)
def test_a_part_that_takes_most_need_but_do_no_harm_ahead(share, held, shown):
    fit = SimpleNamespace(law=SimpleNamespace(effects=()))
    assert module._shows(Candidate(("air_drag",), fit, 2 * EVIDENCE, share, held)) == shown


@pytest.mark.parametrize(
    ("share", "ahead", "first"),
    [(0.95, 0.99, "steady_drive"), (0.95, 0.97, "base_motion"), (0.5, 0.99, "base_motion")],
    ids=["foretells more", "foretells less", "misses what was fitted"],
)
def test_a_line_that_foretells_comes_before_a_shared_motion_that_is_read_off(share, ahead, first):
    """What is read off the record fits it, held out too, whatever made it."""
    shaken = Candidate(("air_drag", "base_motion"), None, 1000.0, 0.98, 0.98)
    other = Candidate(("contact", "steady_drive"), None, 950.0, 0.97, 0.99)
    line = Candidate(("steady_drive", "air_drag"), None, 900.0, share, ahead)
    assert first in module._line_first([shaken, other, line])[0].names
    assert module._line_first([line, shaken]) == [line, shaken]


@pytest.mark.parametrize(
    ("misfit", "left", "free", "miss"),
    [(2.0, 0.3, 0, True), (1.2, 0.3, 0, False), (2.0, 0.4, 0, False), (2.0, 0.3, 1, False)],
    ids=["far less", "the best leaves noise", "not far less", "read off the record"],
)
def test_two_that_foretell_by_chance_give_way_to_what_misses_less(
    monkeypatch, misfit, left, free, miss
):
    best = SimpleNamespace(chi2=misfit, samples=1.0, excess=0.5)
    effects = [SimpleNamespace(free=free), SimpleNamespace(free=0)]
    other = SimpleNamespace(law=SimpleNamespace(effects=effects), excess=left)
    more = Candidate(("contact", "relaxation"), other, 2 * EVIDENCE, 0.99, 0.5)
    monkeypatch.setattr(module, "_stand", list)
    monkeypatch.setattr(module, "excess", lambda found: found.excess)
    assert module._miss_less([more], best) is miss


def test_a_twin_of_the_lesser_of_two_does_nearly_what_that_one_does_beside_the_other():
    """All that the greater one does tells nothing of it."""

    def told(*names, evidence):
        return Candidate(names, fit, evidence, 0.9, 0.9)

    fit = creeping_and_rubbed()
    alone = [told("steady_drive", evidence=900.0), told("air_drag", evidence=50.0)]
    best = told("steady_drive", "air_drag", evidence=1000.0)
    near = told("steady_drive", "dry_friction", evidence=985.0)
    far = told("contact", "steady_drive", evidence=960.0)
    other = told("base_motion", "air_drag", evidence=900.0)
    two = module._two(((None, fit),), best, [best, near, far, other], (), alone)
    assert two.names == ("steady_drive", "air_drag")
    assert two.twins == (("base_motion",), ("dry_friction",))


@pytest.mark.parametrize(
    ("other", "more", "enough", "one", "taken"),
    [
        ("large_amplitude", 2.0, True, None, True),
        ("large_amplitude", 0.5, True, None, False),
        ("large_amplitude", 2.0, False, None, False),
        ("large_amplitude", 2.0, True, "one of them alone", False),
        ("asymmetric_stiffness", 2.0, True, None, False),
    ],
    ids=["twins tell more", "not clearly", "not enough", "one does alone", "the same two"],
)
def test_the_twins_of_two_take_their_place_where_they_tell_clearly_more(
    monkeypatch, other, more, enough, one, taken
):
    """What shows beside the best single effect need not be there: that one may stand in for two."""
    fit = SimpleNamespace(law=SimpleNamespace(effects=()), chi2=1.0, samples=1.0)
    pair = Candidate(("asymmetric_stiffness", "relaxation"), fit, 100.0, 0.99, 0.99)
    better = Candidate(("relaxation", other), fit, 100.0 + more * EVIDENCE, 0.99, 0.99)
    for name, value in {
        "exchanged": [better, pair],
        "vetoed": False,
        "turned": fit,
        "sufficient": enough,
        "one_of": one,
    }.items():
        monkeypatch.setattr(module, name, lambda *_, _value=value, **__: _value)
    monkeypatch.setattr(module, "judge", lambda names, *_: replace(pair, names=names))
    own = tuple(replace(pair, names=(name,)) for name in pair.names)
    rows = ((None, fit), *((name, fit) for name in pair.names))
    told = or_their_twins(Verdict("explained", rows, own, ((), ()), (), ()), ([], ()), 0.1)
    names = better.names if taken else pair.names
    assert told.names == names and [name for name, _ in told.chain] == [None, *names]
