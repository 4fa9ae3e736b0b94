"""What acts on all of the body or damps it, alone or by two, on modes that nobody heard."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import lowest
from core import on_all_modes as module
from core.effects import TIME_EFFECTS, dry_friction, stiffness_drift
from core.lowest import LIGHT, Lowest, in_place, starts_of
from core.on_all_modes import (
    ALONE,
    PLACES,
    RUBS,
    SPEED,
    STAGES,
    _acts_on_all,
    _begun,
    _End,
    _ended,
    _further,
    _Search,
    with_all_modes,
)
from core.pipeline import calibrate_case
from core.sufficiency import CLEARLY, CLEARLY_BOTH
from core.time_layer import judge
from core.timefit import extend, fit
from core.verdict import Verdict
from tests.core.test_timefit import Rub, channels, declared, moved
from tests.truth import make


def test_what_acts_on_all_is_neither_at_a_place_nor_the_cameras_nor_read_off():
    assert {e.name for e in TIME_EFFECTS if _acts_on_all(e)} == {
        "steady_drive", "relaxation", "stiffness_drift", "large_amplitude",
    }  # fmt: skip


def fit_of(chi2, told=1.0, effects=2):
    """What is asked of a fit, of 100 samples; `told`: what `clearly` must be that it explains."""
    law = SimpleNamespace(effects=(None,) * effects)
    return SimpleNamespace(chi2=chi2, samples=100, told=told, law=law, theta=[np.zeros((1, 1))] * 2)


@pytest.fixture
def plainly(monkeypatch):
    """Searches that end where they are told to."""
    given = {"alone": 900.0, "plain": 900.0, "weakens": False, "broken": False}
    given |= {"refuted": (), "turned": fit_of(1.0), "first": None, "second": None}

    def search(names, misfit):
        effects = tuple(SimpleNamespace(name=name) for name in names)
        return _Search(SimpleNamespace(apart=None, heard="heard"), effects, np.zeros(1), misfit)

    values = {
        "lowest_of": lambda heard, found: "lowest",
        "_further": lambda one, share, looks: one,
        "_ended": lambda one: given["ends"][tuple(e.name for e in one.effects)],
        "excess": lambda found: np.sqrt(max(found.chi2 / 100 - 1, 0)),
        "tells_more": lambda found, verdict: found.chi2 < verdict.complete.chi2,
        "bic": lambda found: found.chi2,
        "turned": lambda found: given["turned"],
        "refuted": lambda found: found in given["refuted"],
        "is_broken": lambda *_: given["broken"],
        "explains": lambda found, declared, apart, clearly: clearly >= found.told > 0,
        "without": lambda found, i: fit_of(given["first" if i else "second"] or given["alone"]),
        "with_effects": lambda lowest, *effects: lowest,
        "least_of": lambda *_: given["plain"],
        "judge": lambda names, found, declared: SimpleNamespace(names=names, found=found),
        "weakens": lambda *_: given["weakens"],
        "weakens_rather": lambda *_: given["weakens"],
        "in_place": lambda verdict, heard, fits, said, alone, twins=(): (said, fits, twins, alone),
    }
    for name, value in values.items():
        monkeypatch.setattr(module, name, value)

    def asked(ends, said="unexplained", left=1000.0, misfits=None, found=(), whole=None, **how):
        given.update(how, ends=ends)
        ranked = [SimpleNamespace(names=(name,)) for name in found]
        some = [search(names, (misfits or {}).get(names, 1.0)) for names in ends]
        monkeypatch.setattr(module, "_begun", lambda *_: some)
        verdict = SimpleNamespace(
            verdict=said, damped=None, complete=fit_of(left), names=found, laws=0, ranked=ranked,
            whole=whole,
        )  # fmt: skip
        return with_all_modes(None, verdict)

    return asked


def test_the_best_of_what_explains_is_told_and_what_tells_as_much_is_its_twin(plainly):
    best = fit_of(101.0)
    said, fits, twins, alone = plainly(
        {
            ("stiffness_drift", "dry_friction"): best,
            ("large_amplitude", "dry_friction"): fit_of(104.0),
        }
    )
    assert said == "explained" and fits[-1] == ("dry_friction", best)
    assert [name for name, _ in fits] == ["stiffness_drift", "dry_friction"]
    assert twins == (("large_amplitude",), ())
    assert {name: one.chi2 for name, one in alone.items()} == {
        "stiffness_drift": 900.0, "dry_friction": 900.0,
    }  # fmt: skip


def test_of_two_that_one_is_told_first_which_leaves_less_alone(plainly):
    ends = {("relaxation", "air_drag"): fit_of(101.0)}
    for first, second in (300.0, 500.0), (500.0, 300.0):
        _, fits, _, alone = plainly(ends, first=first, second=second)
        names = ["relaxation", "air_drag"][:: 1 if first < second else -1]
        assert [name for name, _ in fits] == names and fits[0][1] is alone[names[0]]
        assert (alone["relaxation"].chi2, alone["air_drag"].chi2) == (first, second)


def test_what_does_not_tell_all_is_no_twin(plainly):
    names, other = ("stiffness_drift", "dry_friction"), ("large_amplitude", "dry_friction")
    assert plainly({names: fit_of(101.0), other: fit_of(104.0, told=0.0)})[2] == ((), ())


def test_two_are_judged_more_strictly_than_one(plainly):
    nearly = fit_of(101.0, told=(CLEARLY + CLEARLY_BOTH) / 2)
    assert plainly({("relaxation",): nearly})[0] == "explained"
    assert plainly({("relaxation", "air_drag"): nearly})[0] == "unexplained"


def test_few_go_on_to_the_end(plainly):
    names = [("relaxation",), ("steady_drive",), ("stiffness_drift",)]
    ends = {name: fit_of(103.0 - n) for n, name in enumerate(names)}
    misfits = {name: 1.0 + 0.1 * n for n, name in enumerate(names)}
    *_, most = STAGES[-1]
    assert plainly(ends, misfits=misfits)[1][0][0] == names[most - 1][0]


def test_a_search_goes_on_from_its_best_places(monkeypatch):
    walks = [(np.array([3.0]), None, 7.0), (np.array([1.0]), None, 9.0)]
    monkeypatch.setattr(module, "walked", lambda law, places, shares, looks, most: walks)
    gone = _further(_Search(SimpleNamespace(law=None), (), np.zeros((5, 1))), 0.3, 8)
    assert gone.misfit == 7.0 and gone.places.tolist() == [[3.0], [1.0]]


def test_each_begins_where_it_promises_most_and_a_drag_alone_not_again(monkeypatch):
    effect = SimpleNamespace(name="relaxation")
    one = SimpleNamespace(effect=effect, begins=[(1.0,), (2.0,), (3.0,)], promise=np.r_[1, 5, 2])
    for name, value in {
        "able": lambda found, effects: effects,
        "entries": lambda found, effects: [one],
        "with_effects": lambda lowest, *effects: effects,
        "starts_of": lambda lowest, found, begins: begins,
    }.items():
        monkeypatch.setattr(module, name, value)
    setting = SimpleNamespace(places=np.arange(20.0)[:, None])
    law = SimpleNamespace(setting=setting)
    found = {
        tuple(e.name for e in one.effects): one.places
        for one in _begun(SimpleNamespace(law=law), None)
    }
    assert set(found) == {
        ("relaxation",), ("dry_friction",), ("relaxation", "dry_friction"),
        ("relaxation", "air_drag"),
    }  # fmt: skip
    assert np.array_equal(found["relaxation",], [[2.0]])
    assert {p[0] for p in found["relaxation", "air_drag"]} == {2.0}
    rubs, beside = found["dry_friction",], found["relaxation", "dry_friction"]
    assert {p[-1] for p in rubs} == set(range(ALONE)) and len(rubs) == len(RUBS) * ALONE
    assert {p[-1] for p in beside} == set(range(PLACES)) and {p[0] for p in beside} == {2.0}


def test_one_alone_is_told_and_ranked_with_others_of_all_modes(plainly):
    best, other = fit_of(101.0), fit_of(300.0, told=0.0)
    ends = {("stiffness_drift",): best, ("relaxation",): other}
    said, fits, _, alone = plainly(ends)
    assert said == "explained" and fits == [("stiffness_drift", best)]
    assert alone == {"stiffness_drift": best, "relaxation": other}


def test_what_explains_goes_before_what_leaves_less_and_does_not(plainly):
    ends = {("stiffness_drift",): fit_of(110.0), ("relaxation",): fit_of(101.0, told=0.0)}
    assert plainly(ends)[1][0][0] == "stiffness_drift"


def test_parts_are_told_where_far_less_is_left(plainly):
    pair = {("stiffness_drift", "dry_friction"): fit_of(200.0, told=0.0)}
    assert plainly(pair)[0] == "unexplained"
    assert plainly(pair, left=400.0) is None  # 1 beyond noise per sample, and 3 before


@pytest.mark.parametrize("two", [False, True])
def test_none_is_told_that_the_modes_or_one_of_two_do_without(plainly, two):
    names = ("relaxation", "dry_friction")[: 1 + two]
    assert plainly({names: fit_of(101.0)}) is not None
    assert plainly({names: fit_of(101.0)}, plain=110.0) is None
    assert (plainly({names: fit_of(101.0)}, plain=900.0, alone=110.0) is None) is two


def test_a_second_one_that_is_not_needed_does_not_hide_the_one_that_is(plainly):
    """However badly it is fitted again without that, its own search tells."""
    one, two = fit_of(108.0), fit_of(101.0)
    ends = {("relaxation", "dry_friction"): two, ("dry_friction",): one}
    assert plainly(ends)[1] == [("dry_friction", one)]


def test_a_rub_that_weakens_explains_nothing(plainly):
    pair, rub, other = ("relaxation", "dry_friction"), ("dry_friction",), ("relaxation", "air_drag")
    assert plainly({pair: fit_of(101.0)}, weakens=True) is None
    assert plainly({rub: fit_of(101.0)}, weakens=True) is None
    assert plainly({rub: fit_of(200.0, told=0.0)}, weakens=True)[0] == "unexplained"  # a part
    assert plainly({other: fit_of(101.0)}, weakens=True) is not None
    assert plainly({other: fit_of(101.0)}, weakens=True, found=rub) is None
    assert plainly({other: fit_of(101.0)}, weakens=False, found=rub) is not None


def test_parts_give_way_to_a_sudden_change_that_tells_more(plainly):
    part = {("relaxation",): fit_of(200.0, told=0.0)}
    assert plainly(part, broken=True) is None
    assert plainly({("relaxation",): fit_of(101.0)}, broken=True) is not None


def test_neither_of_two_may_be_refuted(plainly):
    found, turned = fit_of(101.0), fit_of(99.0)
    ends = {("relaxation", "air_drag"): found}
    assert plainly(ends, turned=turned, refuted=(found,)) is None
    assert plainly(ends, refuted=(turned,)) is None
    assert plainly({("relaxation",): found}) is not None  # one has no other way round


def test_what_foretells_less_than_what_was_found_is_not_told(plainly, monkeypatch):
    monkeypatch.setattr(module, "tells_more", lambda *_: False)
    assert plainly({("relaxation",): fit_of(101.0)}) is None


def test_nothing_is_sought_where_all_is_told(plainly, monkeypatch):
    ends = {("relaxation",): fit_of(101.0)}
    assert plainly(ends, said="explained") is None
    assert plainly(ends, said="explained", found=("relaxation",)) is None
    monkeypatch.setattr(module, "lowest_of", lambda *_: 1 / 0)
    assert plainly(ends, said="explained", found=("contact", "tracker_drift")) is None


def test_one_takes_the_place_of_two_where_it_explains_with_modes_that_nobody_heard(plainly):
    """However little the two leave: one of them has stood in for these modes."""
    two, one = ("stiffness_drift", "steady_drive"), fit_of(98.0)
    asked = {"said": "explained", "found": two, "left": 110.0}
    ends = {("stiffness_drift",): one, ("relaxation",): fit_of(90.0)}
    ends[("steady_drive", "dry_friction")] = fit_of(80.0)
    assert plainly(ends, **asked)[:2] == ("explained", [("stiffness_drift", one)])
    assert plainly({("stiffness_drift",): fit_of(98.0, told=0.0)}, **asked) is None
    assert plainly({("stiffness_drift",): fit_of(111.0)}, **asked) is None
    assert plainly({("relaxation",): fit_of(90.0)}, **asked) is None
    assert plainly(ends, **asked, whole="all modes") is None


def test_what_lags_far_behind_on_a_share_of_the_record_ends_there(plainly):
    behind = min(behind for _, _, behind, _ in STAGES)
    ends = {("relaxation",): fit_of(101.0), ("stiffness_drift",): fit_of(105.0)}
    assert plainly(ends, misfits={("relaxation",): 0.9 * behind})[1][0][0] == "relaxation"
    late = plainly(ends, misfits={("relaxation",): 1.1 * behind})
    assert late[1][0][0] == "stiffness_drift"


@pytest.mark.parametrize(("bent", "leaves"), [(False, 112.0), (True, 112.0), (True, 140.0)])
def test_a_rub_in_another_body_is_sought_from_more_places(monkeypatch, bent, leaves):
    places = np.arange(40.0)[:, None]
    rub, looks = SimpleNamespace(force=True), []
    law = SimpleNamespace(effects=(rub,), modes=2, setting=SimpleNamespace(places=places))
    first = SimpleNamespace(chi2=110.0, samples=100, parameters=np.array([5.0, 20.2]))
    other = SimpleNamespace(chi2=leaves, samples=100)

    def best_from(one, starts, looks_):
        looks.append(starts)
        return first if len(looks) == 1 else other

    monkeypatch.setattr(module, "_best_from", best_from)
    monkeypatch.setattr(module, "bends_the_body", lambda found: bent and found is first)
    search = _Search(SimpleNamespace(law=law), (rub,), np.zeros((1, 2)))
    assert _ended(search) is (other if bent and leaves < 130 else first)
    assert len(looks) == 1 + bent
    if bent:
        assert sorted(looks[1][:, 1]) == list(range(15, 27)) and (looks[1][:, 0] == 5.0).all()


def test_searches_begin_with_what_damps_last_and_each_with_its_own_numbers():
    found = declared(channels(moved(Rub(0.03, 0.05))))
    searches = _begun(Lowest(None, found.law, np.zeros(found.law.modes)), found)
    names = [tuple(e.name for e in one.effects) for one in searches]
    assert ("dry_friction",) in names and not {(), ("air_drag",)} & set(names)
    assert {"relaxation", "stiffness_drift"} < {some[0] for some in names}
    assert {some[-1] for some in names if len(some) > 1} <= {"dry_friction", "air_drag"}
    assert len(set(names)) == len(names)
    for one in searches:
        law = one.lowest.law
        assert law.effects == (*found.law.effects, *one.effects)
        assert one.places.shape[1] == sum(law.sizes())
        if one.effects[-1].name == "dry_friction":  # of one mode a place has no numbers
            assert set(one.places[:, -2]) == set(RUBS)
            assert np.allclose(one.places[:, -1], np.log(SPEED))


@pytest.mark.parametrize(("apart", "swings"), [(0.1, [None, 0.5, -0.5]), (0.5, [None])])
def test_modes_begin_where_the_body_has_them_and_near_ones_swing_too(apart, swings):
    found = declared(channels(moved()))
    law = replace(found.law, reference=np.tile(found.law.reference, (2, 1)))
    starts = starts_of(Lowest(None, law, np.array([0.0, apart])), found, [np.zeros(0)])
    pitch = np.log(found.frequency[0])
    assert np.allclose(starts[:, :2], [pitch, pitch + apart])
    assert np.allclose(starts[:, 2:4], LIGHT)  # what acts has damped the heard one more
    assert len(starts) == len(swings)
    for start, part in zip(starts, swings, strict=True):
        own = found.parameters[2:]  # place and speed of the first mode at the release
        assert np.allclose(start[4::2], own)
        if part is not None:
            assert np.allclose(start[5::2], part * own)
        else:
            assert np.abs(start[5::2]).max() < 0.01 * np.abs(own).max()


def test_one_of_two_effects_is_fitted_without_the_other():
    found = declared(channels(moved(Rub(0.03, 0.05))))
    effects = stiffness_drift.EFFECT, dry_friction.EFFECT
    law, p = extend(found, effects, [[0.01, 0.0], [0.03, np.log(0.05)]])
    end = _End(_Search(None, effects, p[None]), fit(law, p, evaluations=5))
    for name, alone in end.alone.items():
        assert [e.name for e in alone.law.effects] == [name]
    assert end.alone["dry_friction"].chi2 < 0.5 * end.alone["stiffness_drift"].chi2


def test_what_is_told_is_ranked_by_fits_of_as_many_modes(monkeypatch):
    """With those others of heard modes only that were not sought on all."""
    monkeypatch.setattr(lowest, "of_heard", lambda found, before: found)
    found = declared(channels(moved(Rub(0.03, 0.05))))
    begins = {"stiffness_drift": [0.01, 0.0], "dry_friction": [0.03, np.log(0.05)]}
    fits = {}
    for effect in stiffness_drift.EFFECT, dry_friction.EFFECT:
        law, p = extend(found, (effect,), [begins[effect.name]])
        fits[effect.name] = fit(law, p, evaluations=10)
    rub, drift = fits["dry_friction"], fits["stiffness_drift"]
    known = (judge(("dry_friction",), drift, found), judge(("contact",), drift, found))
    verdict = Verdict("unexplained", ((None, found),), (), (), known, ())
    told = in_place(verdict, "all", [("dry_friction", rub)], said="explained", alone=fits)
    assert told.verdict == "explained" and told.names == ("dry_friction",)
    assert told.ranked[0].names == ("dry_friction",)
    assert {c.names[0]: c.found for c in told.ranked} == {**fits, "contact": drift}
    assert told.bare is None and told.whole.found is rub
    plain = in_place(verdict, "all", [("dry_friction", rub)])
    assert plain.bare is drift  # unlike the others, which were fitted with the heard modes
    two = [("stiffness_drift", drift), ("dry_friction", rub)]
    parts = in_place(verdict, "all", two, said="unexplained", twins=(("x",), ()))
    assert parts.verdict == "unexplained" and parts.twins == (("x",), ())


@pytest.mark.slow
def test_a_drift_is_told_though_a_mode_was_not_heard(tmp_path):
    """Alone it left five times the noise; a marker's own drift stood beside it."""
    truth = make("stiffness_drift", 271829, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    (effect,) = report["diagnosis"]["effects"]
    assert report["diagnosis"]["verdict"] == "explained" and effect["name"] == "stiffness_drift"
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.02)


@pytest.mark.slow
def test_two_that_hide_each_other_are_told_on_all_modes(tmp_path):
    """A bracket of which one mode was heard, by what it never was: told as a shaken support."""
    truth = make("two:steady_drive+air_drag", 368665, tmp_path)
    report = calibrate_case(tmp_path / "case.toml").report
    assert {e["name"] for e in report["diagnosis"]["effects"]} == set(truth["effects"])
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]
    modulus = report["youngs_modulus"]["material"]["value"]
    assert modulus == pytest.approx(truth["youngs_modulus"], rel=0.03)
