"""A drag on modes that nobody heard."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import dragged, lowest
from core.dragged import with_drag
from core.pipeline import calibrate_case
from core.time_layer import Candidate
from core.verdict import Verdict, Whole
from tests.truth import make

COMPUTED = np.array([1.0, 1.02, 2.5])  # Hz at 1 Pa


@dataclass(frozen=True)
class Law:
    effects: tuple = ()
    setting: object = None
    takes: tuple = ()


def fit_of(chi2, pitches=5.0 * COMPUTED, damping=0.02, ahead=0.1, acts=("air_drag",), still=1e3):
    """What is asked of a fit; of 100 samples, so that 130 is more than noise. still: chi2 with its
    last number at nought.
    """
    pitches = np.asarray(pitches, float)
    return SimpleNamespace(
        chi2=chi2,
        samples=100,
        unknowns=10,
        frequency=pitches,
        damping_ratio=np.broadcast_to(damping, pitches.shape),
        loudest=0,
        ahead=ahead,
        parameters=np.array([still, 0.3]),
        law=Law(tuple(SimpleNamespace(name=name, marched=False) for name in acts)),
    )


@pytest.fixture
def plainly(monkeypatch):
    """Fits as they are given: with a drag, and with the same modes without."""
    body = SimpleNamespace(modes=SimpleNamespace(frequency=COMPUTED))
    heard = SimpleNamespace(body=body, match=SimpleNamespace(modes=(0, 1, 2)))

    fits = {}
    monkeypatch.setattr(dragged, "DRAG", SimpleNamespace(name="air_drag", requires=lambda *_: ""))
    monkeypatch.setattr(lowest, "widened", lambda *_: (heard, Law()))
    for module in dragged, lowest:
        monkeypatch.setattr(
            module,
            "fitted",
            lambda lowest, found, begins: [fits["drag" if len(begins[0]) else "plain"]],
        )
        monkeypatch.setattr(
            module,
            "judge",
            lambda names, found, declared: Candidate(names, found, 500.0, 0.9, 0.9),
        )
    at_nought = lambda _, P: np.where(P[:, -1] == 0, P[:, 0], 0.0)  # noqa: E731
    monkeypatch.setattr(dragged, "misfits", at_nought)
    monkeypatch.setattr(lowest, "owes", lambda *_: False)
    monkeypatch.setattr(lowest, "vetoed", lambda *_: False)
    monkeypatch.setattr(lowest, "bends_the_body", lambda *_: False)
    monkeypatch.setattr(lowest, "at_a_bound", lambda *_: [])
    monkeypatch.setattr(lowest, "errors", lambda one: SimpleNamespace(held_out=one.ahead))
    monkeypatch.setattr(lowest, "of_heard", lambda best, before: ("heard of", best))

    def asked(verdict, drag, plain=900.0, **how):
        fits["drag"] = drag if isinstance(drag, list) else [drag]
        fits["plain"] = [fit_of(plain)]
        return with_drag(heard, verdict, **how)

    return asked


def verdict_of(said, *names, chi2=300.0, ahead=0.1, whole=None, shown=0.0):
    rows = [(None, fit_of(1000.0, acts=())), *((name, fit_of(chi2, ahead=ahead)) for name in names)]
    own = tuple(Candidate((name,), rows[-1][1], 400.0, 0.8, 0.8) for name in names)
    ranked = (*own, Candidate(("air_drag",), rows[-1][1], 300.0, shown, 0.8)) if shown else own
    return Verdict(said, tuple(rows), own, ((),) * len(own), ranked, (), whole=whole)


def test_a_drag_on_all_modes_takes_the_place_of_what_does_not_explain(plainly):
    best = fit_of(105.0)
    told = plainly(verdict_of("unexplained", "dry_friction", "contact"), [fit_of(120.0), best])
    assert told.verdict == "explained" and told.names == ("air_drag",)
    assert told.chain[-1] == ("air_drag", ("heard of", best)) and len(told.chain) == 2
    assert told.whole.found is best
    assert [c.names for c in told.ranked] == [("air_drag",), ("dry_friction",), ("contact",)]


@pytest.mark.parametrize(
    ("drag", "still", "pair", "alone", "modes", "named"),
    [
        (200.0, 900.0, 105.0, 400.0, 400.0, ("air_drag", "contact")),
        (310.0, 900.0, 105.0, 400.0, 400.0, None),
        (200.0, 210.0, 105.0, 400.0, 400.0, None),
        (200.0, 900.0, 140.0, 400.0, 400.0, None),
        (200.0, 900.0, 105.0, 110.0, 400.0, None),
        (200.0, 900.0, 105.0, 400.0, 110.0, None),
    ],
    ids=[
        "both",
        "less than was found",
        "does nothing",
        "leaves more than noise",
        "without it",
        "from the modes alone",
    ],
)
def test_a_drag_and_what_shows_beside_it_explain_together(
    plainly, monkeypatch, drag, still, pair, alone, modes, named
):
    both = fit_of(pair, acts=("air_drag", "contact"))
    both.law = Law((dragged.DRAG, *both.law.effects[1:]))
    both.theta = [np.array([[0.2]]), np.zeros((1, 0))]
    two = Candidate(("air_drag", "contact"), both, 500.0, 0.99, 0.99)
    dropped = replace(two, outdone=True, found=fit_of(100.0, acts=("air_drag", "clock")))
    monkeypatch.setattr(dragged, "seconds", lambda *_: [[dropped, two]])
    monkeypatch.setattr(dragged, "without", lambda found, i: fit_of(alone if i == 0 else 0.0))
    before = verdict_of("unexplained", "relaxation")
    told = plainly(before, [fit_of(drag, still=still), fit_of(400.0)], modes, beside=True)
    assert (told and told.names) == named
    assert plainly(before, fit_of(drag)) is None  # where two are yet to be sought
    if told:
        assert [name for name, _ in told.chain] == [None, *named]
        assert told.whole.found is both and told.twins == ((), ())


def test_a_law_of_damping_stays_before_it(plainly):
    before = verdict_of("unexplained", "structural_damping", "contact")
    told = plainly(before, fit_of(105.0))
    assert told.names == ("structural_damping", "air_drag")
    assert told.chain[:2] == before.chain[:2]


@pytest.mark.parametrize("doubt", ["owes", "vetoed", "bends_the_body", "at_a_bound"])
def test_a_drag_that_is_in_doubt_is_none(plainly, monkeypatch, doubt):
    monkeypatch.setattr(lowest, doubt, lambda *_: ["air_drag"])
    assert plainly(verdict_of("unexplained", "contact"), fit_of(105.0)) is None


def test_what_explains_gives_way_to_what_tells_clearly_more(plainly):
    before = verdict_of("explained", "air_drag", "contact", chi2=120.0)
    assert plainly(before, fit_of(110.0)) is None
    assert plainly(before, fit_of(95.0)) is not None
    assert plainly(replace(before, verdict="unexplained"), fit_of(110.0)) is not None


def test_none_is_sought_where_this_recording_shows_none_or_a_force_is_declared(
    plainly, monkeypatch
):
    monkeypatch.setattr(lowest, "widened", lambda *_: 1 / 0)
    before = verdict_of("unexplained", "contact")
    drag = SimpleNamespace(name="air_drag", requires=lambda *_: "no computed mode fits")
    with monkeypatch.context() as patch:
        patch.setattr(dragged, "DRAG", drag)
        assert plainly(before, fit_of(105.0)) is None
    before.chain[0][1].law = Law((SimpleNamespace(name="dry_friction", marched=True),))
    assert plainly(before, fit_of(105.0)) is None


@pytest.mark.parametrize(
    "drag",
    [
        fit_of(135.0),
        fit_of(105.0, 5.0 * COMPUTED * [1, 1.2, 1]),
        fit_of(105.0, ahead=0.2),
        fit_of(299.9),
    ],
    ids=["leaves more than noise", "in another body", "foretells less", "leaves as much"],
)
def test_what_is_no_explanation_leaves_the_verdict(plainly, drag):
    assert plainly(verdict_of("unexplained", "contact"), drag) is None


def test_a_mode_that_does_not_ring_may_be_anywhere(plainly):
    gone = fit_of(105.0, 5.0 * COMPUTED * [1, 1, 1.3], damping=[0.02, 0.02, 0.6])
    assert plainly(verdict_of("unexplained", "contact"), gone) is not None


def test_no_drag_is_told_where_the_modes_alone_do_as_well(plainly):
    assert plainly(verdict_of("unexplained", "contact"), fit_of(105.0), plain=107.0) is None


@pytest.mark.parametrize(
    ("said", "names", "left", "shown", "asks"),
    [
        ("unexplained", (), 300.0, 0.0, True),
        ("adequate", (), 300.0, 0.5, False),
        ("explained", ("dry_friction",), 105.0, 0.5, False),
        ("explained", ("dry_friction",), 125.0, 0.5, True),
        ("explained", ("dry_friction",), 125.0, 0.2, False),
        ("explained", ("air_drag",), 105.0, 0.0, False),
        ("explained", ("air_drag", "dry_friction"), 105.0, 0.0, True),
        ("explained", ("contact", "dry_friction"), 105.0, 0.5, False),
    ],
)
def test_a_drag_is_sought_where_something_is_not_told_or_another_effect_stands_in(
    plainly, monkeypatch, said, names, left, shown, asks
):
    seen = []
    monkeypatch.setattr(lowest, "widened", lambda *_: seen.append(1))
    plainly(verdict_of(said, *names, chi2=left, shown=shown), fit_of(100.0))
    assert bool(seen) is asks


def test_a_drag_that_is_told_so_is_not_sought_again(plainly, monkeypatch):
    monkeypatch.setattr(lowest, "widened", lambda *_: 1 / 0)
    told = verdict_of("explained", "air_drag", chi2=125.0, whole=Whole(None, fit_of(125.0)))
    assert plainly(told, fit_of(100.0)) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "wrong"), [(604418, 0.03), (913578, 0.03), (811001, 0.02)], ids=str
)
def test_a_strong_drag_is_told_though_hardly_a_mode_is_heard(seed, wrong, tmp_path):
    """Two brackets of which two near modes sound as a creep or a hum, and a pudding's pairs."""
    truth = make("air_drag", seed, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert report["diagnosis"]["verdict"] == "explained"
    (effect,) = report["diagnosis"]["effects"]
    assert effect["name"] == "air_drag"
    planted = truth["parameters"]["air_drag"]["coefficient"]
    assert effect["parameters"]["coefficient"]["value"] == pytest.approx(planted, rel=0.1)
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=wrong)


@pytest.mark.slow
def test_an_uneven_stiffness_beside_a_strong_drag_is_told_with_it(tmp_path):
    """A bracket of whose two near modes each damps the other: it was told as a creep beside it."""
    truth = make("two:asymmetric_stiffness+air_drag", 604417, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report["diagnosis"]
    assert report["verdict"] == "explained"
    told = {one["name"]: one["parameters"] for one in report["effects"]}
    assert set(told) == {"air_drag", "asymmetric_stiffness"}
    planted = truth["parameters"]["air_drag"]["coefficient"]
    assert told["air_drag"]["coefficient"]["value"] == pytest.approx(planted, rel=0.15)
