"""Modes that nobody heard and that a found force rings."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import stirred
from core.effects import air_drag, contact, dry_friction
from core.law import numbers
from core.pipeline import calibrate_case
from core.settle import CLOSE
from core.stirred import _begins, _crosses, _is_better, _unheard, of_heard, with_stirred
from core.time_layer import Candidate
from core.timefit import extend, fit
from core.verdict import Verdict, Whole
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import NOISE, RATE, SHAPE, TIME, Rub, W, channels, declared, moved
from tests.truth import make

RUB = (0.03, np.log(0.02))
ACROSS = np.array([0.2, -0.5, 0.4, 1.0])  # how the second mode is seen
SHARE = 5.0  # of a rub at its place, by which that acts on the second mode
HIGHER = 2.7  # its pitch, times the first one's


def rubbed(share, start, pitch):
    """(T, C) two modes that a rub stops at one place, by symplectic Euler's rule; the second is let
    go from `start` times the first one's amplitude.
    """
    h, w, z = 1 / (400 * RATE), W * np.array([1.0, pitch]), np.array([0.01, 0.02])
    u, v, slip = AMPLITUDE * np.array([1.0, start]), np.zeros(2), 0.0
    couple, size = np.array([1.0, share]), RUB[0] * W**2 * AMPLITUDE
    out = []
    for i in range(400 * len(TIME)):
        if i % 400 == 0:
            out.append(u.copy())
        slip = min(max(slip + h * (couple @ v) / (np.exp(RUB[1]) * AMPLITUDE), -1.0), 1.0)
        v += h * (-(w**2) * u - 2 * z * w * v - size * slip * couple)
        u += h * v
    seen = np.array(out) @ np.vstack([SHAPE, ACROSS])
    return seen + NOISE * np.random.default_rng(0).standard_normal(seen.shape)


def test_none_is_looked_for_without_a_found_force_or_beside_noise(monkeypatch):
    monkeypatch.setattr(stirred, "widened", lambda heard, found: asked.append(found))

    def looks(names, left):
        asked.clear()
        law = SimpleNamespace(effects=[dry_friction.EFFECT])
        final = SimpleNamespace(law=law, chi2=left * 100, samples=100)
        verdict = SimpleNamespace(final=final, names=names, laws=0, verdict="explained", whole=None)
        return with_stirred(None, verdict) is None and bool(asked)

    asked = []
    assert not looks(("dry_friction",), 1.2)
    assert not looks((), 5.0)
    assert not looks(("air_drag",), 5.0)
    assert looks(("dry_friction",), 5.0)


def test_the_best_of_the_searches_that_end_well_is_taken(monkeypatch):
    monkeypatch.setattr(stirred, "widened", lambda heard, found: ("heard", "law"))
    monkeypatch.setattr(stirred, "_fitted", lambda law, found: iter(["astray", "good", "worse"]))
    monkeypatch.setattr(stirred, "_is_better", lambda best, found, declared: best in able)
    monkeypatch.setattr(stirred, "_retold", lambda verdict, best: verdict)
    law = SimpleNamespace(effects=[dry_friction.EFFECT])
    final = SimpleNamespace(law=law, chi2=500.0, samples=100)
    one = Candidate(("dry_friction",), final, 1.0, 0.9, 0.9)
    rows = ((None, final), ("dry_friction", final))
    verdict = Verdict("explained", rows, (one,), ((),), (one,), ())
    able = ("good", "worse")
    told = with_stirred(None, verdict)
    assert told.whole.found == "good" and told.whole.heard == "heard"
    assert with_stirred(None, told) is None  # it is counted already
    able = ()
    assert with_stirred(None, verdict) is None


def test_where_modes_run_off_they_are_held_where_the_body_has_them_and_freed_then(
    monkeypatch, heard_only
):
    law, asked = with_another(heard_only, HIGHER), []

    def walked(law, starts, shares, looks, most):
        asked.append((law.tied, shares))
        return [(np.asarray(starts[0]), None, 0.0)]

    monkeypatch.setattr(stirred, "walked", walked)
    monkeypatch.setattr(stirred, "conclude", lambda law, p, jacobian: law.tied)
    monkeypatch.setattr(stirred, "carrying", lambda found: found)
    some = stirred._fitted(law, heard_only)
    assert next(some) == () and asked == [((), stirred.SHARES)]
    assert next(some) == ()
    assert asked[1:] == [(((1, pytest.approx(np.log(HIGHER))),), stirred.SHARES), ((), (1.0,))]
    assert not list(some)


@pytest.fixture(scope="module")
def heard_only():
    start = declared(channels(moved(Rub(0.03, 0.02))))
    return fit(*extend(start, (dry_friction.EFFECT,), [RUB]), evaluations=20)


def with_another(found, pitch):
    """The law with a second mode, computed at that pitch over the first one's."""
    old = found.law
    setting = replace(
        old.setting,
        omega=W * np.array([1.0, pitch]),
        zeta=np.full(2, 0.02),
        couple=np.ones(2),
        places=np.array([[0.0], [3.0]]),
        levers=np.ones(2),
        masses=np.ones(2),
    )
    reference = np.vstack([old.reference, ACROSS / (ACROSS @ ACROSS)])
    return replace(old, reference=reference, setting=setting, gauges=(reference,))


def outer(pitch, start=1e-5):
    return np.r_[
        np.log(W / 2 / np.pi * np.array([1.0, pitch])), 0.01, 0.02, AMPLITUDE, start, 0.0, 0.0
    ]


@pytest.fixture(scope="module")
def wider(heard_only):
    """A fit of two modes, the second of which was not heard."""
    law = with_another(heard_only, 1.7)
    return fit(law, np.r_[outer(1.7), RUB, 0.5], evaluations=3)


def test_what_is_said_of_the_heard_modes_foretells_what_all_of_them_do(heard_only, wider):
    told = of_heard(wider, heard_only)
    assert len(told.parameters) == sum(told.law.sizes())
    assert told.coefficients.shape == heard_only.coefficients.shape
    assert told.frequency == pytest.approx(wider.frequency[:1])
    assert told.damping_ratio == pytest.approx(wider.damping_ratio[:1])
    assert (told.theta[0][0] == wider.theta[0][0, :2]).all()
    assert (told.shapes == wider.shapes[:1]).all()
    assert (told.rest() == wider.rest()).all()
    assert (told.column_shapes()[0] == wider.column_shapes()[0]).all()
    assert told.covariance[1, 1] == wider.covariance[2, 2]  # of the first one's damping ratio
    assert told.covariance[-1, -1] == wider.covariance[-2, -2]  # of the rub's travel
    assert told.predicted is wider.predicted and told.chi2 == wider.chi2


def test_the_numbers_of_the_heard_modes_are_picked_in_every_take_and_condition():
    """Two of four modes, the first of which turns; two conditions, three takes, a rub in a plane
    and a drag; the numbers say where they stand.
    """
    effects = (dry_friction.IN_PLANE, air_drag.EFFECT)
    drag = len(air_drag.EFFECT.low)
    wide = 2 * 4 * 2, 2 * 4 * 3, 2 + 2 * 3 + drag
    law = SimpleNamespace(modes=4, effects=effects, turning=(0,), conditions=2, sizes=lambda: wide)

    @dataclass(frozen=True)
    class Fit:
        law: object
        parameters: np.ndarray
        covariance: np.ndarray
        coefficients: np.ndarray
        jacobian: np.ndarray
        motions: tuple = ()

    @dataclass(frozen=True)
    class Law:
        modes: int
        effects: tuple = ()

    p = np.arange(float(sum(wide)))
    found = Fit(law, p, np.diag(p), np.arange(15.0)[None], p[None])
    told = of_heard(found, Fit(Law(2), p, p, p, p))
    blocks = [p[at + k] for at in range(0, 40, 4) for k in (0, 1)]
    rub = [40, 41, 42, 45]  # its law, its share in the second mode along and across
    assert told.parameters.tolist() == blocks + rub + list(range(48, 48 + drag))
    assert (np.diag(told.covariance) == told.parameters).all()
    # of each condition two modes and the turn of the first, then what no mode has
    assert told.coefficients[0].tolist() == [0, 1, 4, 5, 6, 9, 10, 11, 12, 13, 14]


def rung(share, start, pitch):
    """The fit with a second mode, that without, and the declared one."""
    first = declared(channels(rubbed(share, start, pitch)))
    found = fit(*extend(first, (dry_friction.EFFECT,), [RUB]), evaluations=30)
    law = with_another(found, HIGHER)
    best = fit(law, np.r_[outer(pitch, max(start * AMPLITUDE, 1e-5)), RUB, share], evaluations=40)
    assert best.chi2 < 1.2 * best.samples < 0.5 * found.chi2
    return best, found, first


@pytest.fixture(scope="module")
def rung_by_the_rub():
    return rung(SHARE, 0.0, HIGHER)


def test_the_bodys_own_mode_that_the_force_rings_counts(rung_by_the_rub):
    assert _is_better(*rung_by_the_rub)


@pytest.mark.parametrize(
    ("share", "start", "pitch"),
    [(0.0, 0.3, HIGHER), (SHARE, 0.0, 0.8 * HIGHER)],
    ids=["rings by itself", "rung, but another one"],
)
def test_another_mode_than_the_bodys_own_does_not_count_or_one_that_rings_by_itself(
    share, start, pitch
):
    assert not _is_better(*rung(share, start, pitch))


def test_a_mode_that_swings_more_than_what_was_heard_would_have_been_heard(rung_by_the_rub):
    best, *before = rung_by_the_rub
    size = 1.1 * best.swings[0] / best.swings[1]
    louder = replace(best, motions=tuple(u * [1, size] for u in best.motions))
    assert not _is_better(louder, *before)


def test_a_mode_that_moves_the_pitch_of_what_was_heard_takes_its_part(rung_by_the_rub):
    best, found, first = rung_by_the_rub
    elsewhere = found.parameters.copy()
    elsewhere[0] += 2 * CLOSE
    assert not _is_better(best, replace(found, parameters=elsewhere), first)


@pytest.mark.parametrize(
    ("effects", "left", "doubts", "verdict"),
    [
        (1, 1.1, (), "explained"),
        (2, 1.1, (), "unexplained"),
        (1, 1.5, (), "unexplained"),
        (1, 1.1, ("owes",), "unexplained"),
        (1, 1.1, ("weakens",), "unexplained"),
    ],
)
def test_one_effect_explains_all_where_no_more_than_noise_is_left(
    effects, left, doubts, verdict, monkeypatch
):
    for name in ("owes", "weakens"):
        monkeypatch.setattr(stirred, name, lambda *_, name=name: name in doubts)
    monkeypatch.setattr(stirred, "judge", lambda *_: None)
    monkeypatch.setattr(stirred, "of_heard", lambda best, before: best)
    rows = [(None, "declared"), *[("dry_friction", "before")] * effects]
    one = Candidate(("dry_friction",), "before", 1.0, 0.9, 0.9)
    before = Verdict("unexplained", tuple(rows), (one,) * effects, ((),) * effects, (one,), ())
    told = stirred._retold(before, SimpleNamespace(chi2=left * 100, samples=100))
    assert told.verdict == verdict
    assert told.final.chi2 == left * 100 and told.bare == "before"
    assert told.effects == before.effects and told.ranked == before.ranked


TWO = ("dry_friction", "contact")


@pytest.mark.parametrize(
    ("verdict", "names", "law", "whole", "alone", "told"),
    [
        ("unexplained", TWO, "", None, "explained", "dry_friction"),
        ("unexplained", TWO, "structural_damping", None, "explained", "dry_friction"),
        ("unexplained", TWO, "", None, "unexplained", None),
        ("unexplained", TWO, "", "unexplained", "explained", "both"),
        ("explained", TWO, "", None, "explained", None),
        ("unexplained", ("dry_friction",), "structural_damping", None, "explained", None),
        ("unexplained", ("air_drag", "contact"), "", None, "explained", "contact"),
    ],
    ids=["likelier", "beside a law", "neither", "both do", "both explain", "alone", "the force"],
)
def test_one_force_with_modes_that_nobody_heard_takes_the_place_of_two_effects(
    verdict, names, law, whole, alone, told, monkeypatch
):
    """Where these do not explain, with such modes or without, and it does: the likelier one."""
    known = {
        "contact": contact.ABOVE,
        "air_drag": replace(air_drag.EFFECT, force=None),
        "dry_friction": dry_friction.EFFECT,
    }
    each = {
        name: Candidate((name,), SimpleNamespace(law=SimpleNamespace(effects=[e])), 10.0, 0.9, 0.9)
        for name, e in known.items()
    }
    each |= {law: Candidate((law,), "damped", 99.0, 0.9, 0.9)} if law else {}
    own = (law, *names) if law else names
    before = Verdict(
        verdict,
        ((None, "declared"), *((name, name) for name in own)),
        tuple(each[name] for name in own),
        ((),) * len(own),
        tuple(each[name] for name in (own[:1] if law else ()) + tuple(known)),
        (),
    )

    def found_by(heard, one):
        said = whole if one is before else alone
        return said and replace(one, verdict=said, whole=Whole(heard, one.names[-1]))

    monkeypatch.setattr(stirred, "_of_all", found_by)
    monkeypatch.setattr(stirred, "sharpened", lambda found: ("sharp", found))
    monkeypatch.setattr(stirred, "judge", lambda names, found, declared: each[names[0]])
    monkeypatch.setattr(stirred, "bic", {"dry_friction": 1.0, "contact": 2.0}.get)
    monkeypatch.setattr(stirred, "_takes_the_place", lambda one, of: one.verdict == "explained")
    out = stirred.with_stirred(None, before)
    if told in (None, "both"):
        assert (out and out.names) == (told and own)
        return
    rows = [(None, "declared")] + ([(law, law)] if law else [])
    rows.append((told, ("sharp", each[told].found)))
    assert list(out.chain) == rows
    assert out.names == tuple(name for name, _ in rows[1:])
    likely = [name for name in known if name != told]
    assert out.twins == ((),) * (len(rows) - 2) + (tuple(likely),)


@pytest.mark.parametrize(
    ("verdict", "cost", "ahead", "takes"),
    [
        ("explained", 1.0, 0.1, True),
        ("unexplained", 1.0, 0.1, False),
        ("explained", 3.0, 0.1, False),
        ("explained", 1.0, 0.3, False),
    ],
    ids=["tells more", "explains nothing", "less likely", "worse ahead"],
)
def test_one_takes_the_place_of_two_where_it_tells_more(verdict, cost, ahead, takes, monkeypatch):
    known = {"one": (cost, ahead), "two": (2.0, 0.2)}
    monkeypatch.setattr(stirred, "bic", lambda found: known[found][0])
    monkeypatch.setattr(stirred, "errors", lambda found: SimpleNamespace(held_out=known[found][1]))
    one = SimpleNamespace(verdict=verdict, complete="one")
    assert stirred._takes_the_place(one, SimpleNamespace(final="two")) is takes


@pytest.mark.parametrize("effect", [dry_friction.EFFECT, dry_friction.IN_PLANE, air_drag.EFFECT])
def test_every_begin_has_the_numbers_of_the_wider_law(effect):
    rng = np.random.default_rng(1)
    heard, modes = 2, 4
    law = SimpleNamespace(setting=SimpleNamespace(places=rng.standard_normal((30, modes - 1))))
    theta = rng.standard_normal(numbers(effect, heard))
    begins = list(_begins(effect, theta, heard, law))
    assert {len(one) for one in begins} == {numbers(effect, modes)}
    own = len(effect.low)
    assert (begins[0][:own] == theta[:own]).all()
    if effect.force:  # first as the place does that shares most nearly as much in the heard modes
        nearest = np.argmin(np.abs(law.setting.places[:, 0] - theta[own]))
        assert (begins[0][own : own + 3] == [theta[own], *law.setting.places[nearest, 1:]]).all()
    if effect.axes > 1:
        assert (begins[0][own + 3 :] == [theta[own + 1], 0, 0]).all()


def test_modes_that_were_not_heard_are_seen_low_and_lie_across_those_that_were():
    """The first of a pair was heard as it lies aslant; the third mode moves along the view."""
    pitches = np.array([1.0, 1.001, 2.0, 3.0, 3.5, 4.0, 9.0])
    seen = np.eye(7, 9)
    seen[2] *= 0.01
    turn = np.zeros((7, 1))
    turn[:2, 0] = 0.8, 0.6
    heard = SimpleNamespace(
        body=SimpleNamespace(
            modes=SimpleNamespace(frequency=pitches), seen=lambda data: seen.copy()
        ),
        match=SimpleNamespace(modes=(0,)),
        turns=(turn,),
        takes=[SimpleNamespace(support=np.arange(9) == 8)],
    )
    law = SimpleNamespace(fitted=[0], modes=1, turning=(), effects=())
    new, own = _unheard(heard, law, 3.7)
    assert new == [1, 3, 4]
    assert np.abs(own[0][:2, 0]) == pytest.approx([0.6, 0.8])
    assert np.hstack([turn, *own]).T @ np.hstack([turn, *own]) == pytest.approx(np.eye(4))
    assert _unheard(heard, SimpleNamespace(**{**vars(law), "turning": (0,)}), 3.7)[0] == [3, 4]


def test_a_direction_that_swings_in_the_fit_already_is_not_counted_twice():
    law = SimpleNamespace(turning=(1,), effects=())
    assert _crosses(law, [1]) and not _crosses(law, [0]) and not _crosses(law, [])


@pytest.mark.slow
def test_a_rub_foretells_what_the_modes_do_that_it_rings(tmp_path):
    """A bracket's; with the heard mode alone three times the noise is left of what is to come."""
    truth = make("dry_friction", 881003, tmp_path)
    result = calibrate_case(tmp_path / "case.toml")
    report = result.report
    (effect,) = report["diagnosis"]["effects"]
    assert effect["name"] == "dry_friction"
    silent = [name for name in result.motion.names if name.endswith("not heard")]
    assert silent
    assert report["error"]["after"] < 1.5 * report["error"]["floor"]
    low, high = effect["parameters"]["force"]["ci95"]
    assert low < truth["parameters"]["dry_friction"]["force"] < high
    assert len(result.motion.names) > len(report["modes"]) + len(silent)
