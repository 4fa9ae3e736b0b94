"""What pitches and shapes add to a verdict in time."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import doubt, examine, modulus
from core import ground as ground_file
from core.compare import NO_SHIFTS, Measured, compare
from core.doubt import DOUBT, EVIDENCE, is_able, mends_all
from core.effects import (
    added_mass,
    compliant_pin,
    dry_friction,
    graded_stiffness,
    gravity_preload,
    split_modes,
    stiffness_drift,
)
from core.effects.base import Family
from core.examine import _as_declared, _in_time, _turned_over, _unsure
from core.findings import Findings
from core.ground import Ground, looked_at_closely
from core.modal_layer import Suspect, _looker
from core.residual import Error
from core.tell_change import body_lines, sag_lines, sag_span

PITCH = np.array([3.0, 7.0, 11.0])
SHAPES = np.linalg.qr(np.random.default_rng(4).standard_normal((12, 3)))[0].T


def looked_at(pitch):
    """(what was measured of a body with these pitches, how it fits one with PITCH)."""
    measured = Measured(pitch, np.full(3, 0.003), SHAPES, np.full((3, 12), 0.02))
    return measured, compare(measured, (2 * np.pi * PITCH) ** 2, SHAPES)


def suspect(hypothesis, evidence, effect=added_mass.EFFECT, near=(), told=None):
    return Suspect(effect, hypothesis, np.zeros(1), told or {}, evidence, 0.0, list(near), [])


def ground(measured, base):
    return Ground(None, None, measured, base, np.ones(3), *np.zeros((3, 3)))


@pytest.mark.parametrize(("lowest", "is_one"), [(1.0, True), (-0.1, False)])
def test_a_body_that_buckles_is_none(lowest, is_one):
    """Its own weight may take away more of a stiffness than there is."""
    measured, _ = looked_at(PITCH)
    stiffness = np.diag((2 * np.pi * PITCH) ** 2 * [lowest, 1.0, 1.0])
    family = Family(
        basis=np.eye(3),
        matrices=lambda theta: (stiffness, np.eye(3)),
        grid=np.zeros((1, 1)),
        low=np.zeros(1),
        high=np.ones(1),
        report=lambda theta, young: {},
    )
    body = SimpleNamespace(
        model=SimpleNamespace(points=np.zeros((1, 3))),
        case=SimpleNamespace(takes=[SimpleNamespace(gravity=None)]),
        seen=lambda data, shapes: measured.shapes,
    )
    known = {"data": None, "pull": None, "shifts": (), "shrink": np.ones(3)}
    look = _looker(
        compliant_pin.EFFECT, family, SimpleNamespace(body=body, measured=measured, **known)
    )
    found, cost = look(np.zeros(1))
    assert (found is not None) == np.isfinite(cost) == is_one


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


@pytest.mark.parametrize(("evidence", "left", "strange", "mends"), [
    (30.0, 0.001, 0, True),
    (19.0, 0.001, 0, False),  # not twice as clear as it must be
    (30.0, 0.02, 0, False),  # it leaves a pitch off
    (30.0, 0.001, 1, False),  # or a faint mode aside that the declared body holds
], ids=["mends", "hardly clear", "leaves", "sets aside"])  # fmt: skip
def test_beside_what_bends_shapes_a_change_of_the_body_must_mend_all(
    evidence, left, strange, mends
):
    measured, base = looked_at(PITCH * [1.0, 1.1, 0.9])
    _, found = looked_at(PITCH * [1.0, 1.0 + left, 1.0 - left])
    one = suspect(replace(found, strange=strange), evidence)
    assert mends_all(one, base, measured) == mends


@pytest.mark.parametrize(("evidence", "share", "signs", "able"), [
    (11.0, 0.9, (0.5, 0.9), True),
    (9.0, 0.9, (0.5, 0.9), False),
    (11.0, 0.5, (0.5, 0.9), False),
    (11.0, 0.9, (0.9, 1.1), False),  # as stiff at both ends is no gradient
], ids=["able", "not clear", "takes half", "may be nothing"])  # fmt: skip
def test_a_change_of_the_body_is_able_where_it_is_clear_takes_most_and_is_surely_something(
    evidence, share, signs, able
):
    measured, base = looked_at(PITCH * [1.0, 1.1, 0.9])
    found = replace(base, chi2=base.chi2 * (1 - share))
    near = [(0.0, {"ratio": ratio}, None) for ratio in signs]
    one = suspect(found, evidence, graded_stiffness.EFFECT, near)
    assert is_able(one, ground(measured, base)) == able


def test_what_the_author_declares_of_the_body_is_what_others_are_held_against():
    measured, base = looked_at(PITCH * [1.0, 1.1, 0.9])
    _, mended = looked_at(PITCH)
    mended = replace(mended, modulus=4.0)
    near = [(0.0, {}, mended.pitches / np.sqrt(ratio)) for ratio in (0.8, 1.25)]
    pin = suspect(mended, 40.0, compliant_pin.EFFECT, near)
    mass = suspect(base, 55.0)
    heard = SimpleNamespace(
        body=SimpleNamespace(case=SimpleNamespace(declared=("compliant_pin",))),
        match=SimpleNamespace(modes=(0, 1, 2)),
    )
    plain = Findings("adequate", [], [], [], [])
    stiff = np.array([0.0, 0.02, 0.04])
    found, there, others = _as_declared(plain, ground(measured, base), [mass, pin], heard, stiff)
    assert there.base is mended and [s.effect.name for s in others] == ["added_mass"]
    assert others[0].evidence == pytest.approx(15.0)
    assert found.mesh_frequency(9.0, 2) == pytest.approx(mended.pitches[2] * np.sqrt(1.04))
    assert found.modulus_span(1) == pytest.approx((0.8, 1.25))
    # what it does not explain is no part of the body
    idle = suspect(mended, -1.0, compliant_pin.EFFECT)
    same, where, others = _as_declared(plain, there, [mass, idle], heard, stiff)
    assert same is plain and where is there and others[0].evidence == 55.0


@pytest.mark.parametrize(("found", "mended", "stay"), [
    (["dry_friction", "contact"], True, 2),
    (["split_modes", "contact"], False, 2),
    (["split_modes", "contact"], True, 1),  # a changed body parts its own pairs
    ([], True, 0),
])  # fmt: skip
def test_a_law_of_damping_and_a_needless_split_are_no_effects_beside_a_changed_body(
    found, mended, stay
):
    names = ["structural_damping", *found]
    verdict = SimpleNamespace(effects=[SimpleNamespace(names=(n,)) for n in names], laws=1)
    assert _in_time(verdict, mended) == stay


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("clock", "named"), [(1.02, ""), (1.08, "1.08"), (0.8, "0.8")])
def test_a_sag_that_is_off_tells_the_clock_that_would_mend_it(clock, named, turned):
    """Pitches that are really `clock` times as high make a body as much stiffer: it sags less."""
    channels = SimpleNamespace(
        marker=np.array([0, 1]),
        sigma=np.full(2, 1e-5),
        take=SimpleNamespace(
            recording=SimpleNamespace(
                camera=None, markers=[SimpleNamespace(name=n) for n in ("root", "tip")]
            )
        ),
    )
    sag = np.array([-1e-3, -4e-3])
    measured = SimpleNamespace(sag=sag, sag_error=0.05)
    seen = SimpleNamespace(data=channels, measured=measured, turned=turned)
    body = SimpleNamespace(sag=sag * clock**2)
    (line,) = sag_lines(seen, body)
    assert line.startswith("Sag of tip: 0.004 m measured")
    assert (f"capture rate {named} times" in line) if named else "capture" not in line
    other = "another place of one" if turned else "another shape without"
    assert (other in line) is bool(named)
    other = clock**2 if named else 1.0  # the modulus that the sag tells, over that of the pitches
    assert sag_span(seen, body) == pytest.approx((min(other, 1.0), max(other, 1.0)))


@pytest.mark.parametrize(
    ("names", "most"),
    [
        (("relaxation", "steady_drive"), DOUBT),  # these add to the swings
        (("relaxation", "contact"), DOUBT**2),
        (("lost_frames",), DOUBT),
    ],
)
def test_a_body_is_in_doubt_the_sooner_where_nothing_bends_its_modes(names, most, monkeypatch):
    monkeypatch.setattr(doubt, "_is_slight", lambda verdict: False)
    effects = [SimpleNamespace(name=name, layer="time") for name in names]
    final = SimpleNamespace(law=SimpleNamespace(effects=effects))
    damped = SimpleNamespace(law=SimpleNamespace(effects=[]))
    assert doubt.least_chance(SimpleNamespace(final=final, damped=damped)) == most


@pytest.mark.parametrize(
    ("bend", "sure", "told_by"),
    [(0.1, 0.001, 1), (0.001, 0.001, 0), (0.1, 0.2, 0)],
    ids=["bent", "hardly bent", "the others are less sure"],
)
def test_the_mode_that_an_uneven_stiffness_bends_less_tells_the_modulus(
    bend, sure, told_by, monkeypatch
):
    """Two octaves up it bends a pitch by a sixteenth."""
    monkeypatch.setattr(modulus, "bent", lambda final: bend)
    monkeypatch.setattr(modulus, "_spread", lambda final: np.array([0.001, sure]))
    true, clear = np.array([5.0, 20.0]), [(0, 0), (1, 3)]
    final = SimpleNamespace(loudest=0)
    assert modulus._least_bent(final, true, clear, np.full(4, 0.002)) == told_by


@pytest.mark.parametrize(("mass", "said"), [(0.3, False), (0.5, True)])
def test_a_mass_that_is_more_than_the_bodys_own_is_told(mass, said):
    effects = [
        {"name": "relaxation", "parameters": {}},
        {"name": "added_mass", "parameters": {"mass": {"value": mass}}},
    ]
    assert bool(added_mass.told(effects, 0.4)) is said
    assert not added_mass.told(effects[:1], 0.4)


def test_takes_turned_over_tell_of_the_weight_alone(monkeypatch):
    """Clear as another change of the body may be: nothing was the matter without them."""
    _, base = looked_at(PITCH)
    some = [suspect(base, 50.0), suspect(base, -5.0, gravity_preload.EFFECT)]
    case = SimpleNamespace(declared=(), takes=[SimpleNamespace(loads=())])
    heard = SimpleNamespace(body=SimpleNamespace(carried=None, case=case))
    gain, seen = EVIDENCE, {1: 1}
    monkeypatch.setattr(
        examine, "suspects", lambda _, names: [s for s in some if s.effect.name not in names]
    )
    monkeypatch.setattr(examine, "weighs", lambda *_: gain)
    monkeypatch.setattr(examine, "turned", lambda *_: seen)

    def told():
        return [s.effect.name for s in _turned_over(None, heard, SimpleNamespace(final=None))]

    assert told() == []
    gain = EVIDENCE + 10
    assert told() == ["gravity_preload"]
    seen = {}
    assert told() == []
    seen, heard.body.carried = {1: 1}, 1e4
    assert told() == []
    heard.body.carried, case.declared = None, ("gravity_preload",)
    assert told() == []


COMMON = np.array([0.004, 0.001, 0.002])  # how much a rim takes off each pitch, relatively


def looked_closely_at(pitch, unit=None, **more):
    """As `looked_at`, where what all pitches are off by at once is known to be as COMMON."""
    error, shape_error = np.full(3, 0.0007), np.full((3, 12), 0.02)
    measured = Measured(pitch, error, SHAPES, shape_error, common=COMMON[None], **more)
    return measured, compare(measured, (2 * np.pi * PITCH) ** 2, SHAPES, unit)


@pytest.mark.parametrize("sag", [None, 1.03])
@pytest.mark.parametrize(
    ("off", "is_it"),
    [(1.5 * COMMON, True), (6.0 * COMMON, False), ([0.0, 0.0, 0.005], False)],
    ids=["as rims do", "as no rim does", "one of them"],
)
def test_what_rims_do_to_all_pitches_at_once_is_forgiven_and_as_much_of_one_is_not(off, is_it, sag):
    """As generalized least squares with the whole covariance has it."""
    unit = None if sag is None else -np.linspace(0.5, 1.5, 12)
    more = {} if sag is None else {"sag": sag * unit, "sag_error": 0.04}
    measured, found = looked_closely_at(PITCH * np.exp(off), unit, **more)
    assert (doubt.chance_of(found, measured) > DOUBT) is is_it
    error, common = measured.weight**-0.5, np.r_[COMMON, 0.0]
    ratio = np.r_[np.log(measured.frequency / PITCH), -0.5 * np.log(sag or 1.0)]
    n = 3 if sag is None else 4
    weight = np.linalg.inv(np.diag(error[:n] ** 2) + np.outer(common[:n], common[:n]))
    sure, left = weight.sum(), ratio[:n] - weight.sum(axis=0) @ ratio[:n] / weight.sum()
    assert np.log(found.modulus) == pytest.approx(2 * (ratio[:n] - left)[0], abs=1e-9)
    assert found.pitch_chi2 == pytest.approx(left @ weight @ left)
    if sag is not None:  # which is off by itself, and by what the mean is
        assert found.free[3] == pytest.approx(1 - 1 / (sure * error[3] ** 2))


def test_a_faint_pole_that_is_none_of_the_bodys_does_not_pass_for_rims():
    """It is set aside, and the loud ones are left as they are."""
    _, found = looked_closely_at(PITCH * [1.0, 1.0, 1.05], faint=1)
    assert found.strange == 1 and np.abs(found.together) < 0.1
    assert np.abs(found.pitch_pull[:2]).max() < 0.1


def test_a_close_look_trusts_pitches_further_and_shares_what_sizes_and_convergence_leave(
    monkeypatch,
):
    measured, base = looked_at(PITCH)
    doubt = np.array([0.006, 0.002, 0.004])
    computed = np.hypot(0.003, 0.5 * doubt)
    measured = replace(measured, error=np.hypot(computed, [0.0, 0.002, 0.0]))
    body = SimpleNamespace(modes=SimpleNamespace(frequency=PITCH), seen=lambda data: SHAPES)
    far = replace(ground(measured, base), body=body, doubt=doubt, computed=computed)
    slopes = np.arange(12.0).reshape(3, 4)  # of four modes
    monkeypatch.setattr(ground_file, "size_slopes", lambda _: slopes)
    close = looked_at_closely(far)
    own = np.hypot(0.0007, 0.125 * doubt)
    assert close.measured.error == pytest.approx(np.hypot(own, [0.0, 0.002, 0.0]))
    assert close.measured.together[:, 3] == pytest.approx(0.0)  # the sag's
    assert close.measured.together[0, :3] == pytest.approx(doubt)
    assert close.measured.together[1:, :3] == pytest.approx(0.002 * slopes[:, :3])
    assert close.base.chi2 == pytest.approx(0.0, abs=1e-9)
    body.seen = lambda data: SHAPES[:, ::-1]  # no low mode moves as the first one
    assert looked_at_closely(far) is None


@pytest.mark.parametrize(
    ("off", "more", "loads", "carried", "acting", "near"),
    [
        (0.008, {}, (), None, (), True),
        (0.03, {}, (), None, (), False),
        (0.03, {"error": np.array([0.003, 0.003, 0.02])}, (), None, (), True),  # hardly heard
        (0.03, {"faint": 1}, (), None, (), True),  # that one may be none of the body's
        (0.008, {}, ("a load",), None, (), False),
        (0.008, {}, (), 1e4, (), False),  # how much its weight is depends on the modulus
        (0.008, {}, (), None, ("contact",), False),
    ],
    ids=["near", "far", "unsure", "a faint one", "laden", "heavy", "bent"],
)
def test_a_body_is_looked_at_closely_where_loud_pitches_are_nearly_its_own(
    off, more, loads, carried, acting, near
):
    measured, base = looked_at(PITCH * [1.0, 1.0, 1.0 - off])
    base, computed = replace(base, frequency=PITCH), np.full(3, 0.003)
    case = SimpleNamespace(takes=[SimpleNamespace(loads=loads)])
    body = SimpleNamespace(case=case, carried=carried)
    there = replace(ground(replace(measured, **more), base), body=body, computed=computed)
    effects = [SimpleNamespace(name=name, layer="time") for name in acting]
    verdict = SimpleNamespace(final=SimpleNamespace(law=SimpleNamespace(effects=effects)))
    assert examine._may_be_near(verdict, there) is near
    for pull, still in ((-2.5, False), (-1.5, near)):  # as another load has it
        shifts = replace(NO_SHIFTS, pull=np.array([[0.5, pull]]))
        shifted = replace(there, base=replace(base, shifts=shifts))
        assert examine._may_be_near(verdict, shifted) is still


@pytest.mark.parametrize(
    ("verdict", "names", "told"),
    [
        ("explained", ["graded_stiffness"], True),
        ("unexplained", ["graded_stiffness"], False),
        ("explained", [], False),
    ],
)
def test_a_close_look_names_what_explains_and_says_nothing_else(verdict, names, told, monkeypatch):
    close = ground(*looked_closely_at(PITCH * [1.0, 1.0, 1.005]))
    found = Findings(verdict, [{"name": name} for name in names], [], [], [])
    monkeypatch.setattr(examine, "looked_at_closely", lambda _: close)
    monkeypatch.setattr(examine, "_otherwise", lambda *_: found)
    assert examine._closely(*[None] * 5) is (found if told else None)
    close = ground(*looked_closely_at(PITCH))  # nothing is the matter
    assert examine._closely(*[None] * 5) is None


@pytest.mark.parametrize(
    ("declared", "weight", "strange", "near", "closer", "told"),
    [
        (True, [1], True, True, True, "weight"),
        (True, [], True, True, True, "strange"),
        (True, [], False, True, True, "closer"),
        (True, [], False, True, False, "plain"),
        (True, [], False, False, True, "plain"),
        (False, [], False, True, True, "closer"),
        (False, [1], True, True, False, "otherwise"),
        (False, [], False, False, True, "otherwise"),
    ],
)
def test_what_is_told_first_of_a_body_that_is_nearly_as_declared(
    declared, weight, strange, near, closer, told, monkeypatch
):
    answers = {
        "_is_as_declared": declared,
        "_turned_over": weight,
        "_changed": "weight",
        "_may_be_near": near,
        "_closely": "closer" if closer else None,
        "_otherwise": "otherwise",
    }
    for name, answer in answers.items():
        monkeypatch.setattr(examine, name, lambda *_, answer=answer: answer)
    monkeypatch.setattr(
        examine, "_unless_strange", lambda plain, *_: "strange" if strange else plain
    )
    assert examine._told("plain", None, None, None, None) == told


@pytest.mark.parametrize(
    ("names", "laws", "verdict", "told"),
    [
        (("base_motion",), 0, "explained", True),
        (("structural_damping", "base_motion"), 1, "explained", True),
        (("relaxation",), 0, "explained", False),  # which bends pitches
        (("base_motion", "relaxation"), 0, "explained", False),
        ((), 0, "adequate", True),
        (("base_motion",), 0, "unexplained", False),  # so it is already
    ],
)
def test_a_stranger_leaves_unexplained_what_only_shakes(names, laws, verdict, told, monkeypatch):
    said = SimpleNamespace(
        verdict=verdict,
        names=names,
        laws=laws,
        final=SimpleNamespace(law=SimpleNamespace(fitted=(0,))),
    )
    heard = SimpleNamespace(condition=(0,), turns=(1,), match=SimpleNamespace(modes=()))
    monkeypatch.setattr(examine, "softer", lambda final: (1.0, 1.0, 1.0))
    monkeypatch.setattr(examine, "ground_of", lambda *_: ground(*looked_at(PITCH)))
    # what is told of one that is as declared asks for strangers itself
    monkeypatch.setattr(examine, "_told", lambda plain, there, heard, said, stiff: (
        examine._unless_strange(plain, said, there) if verdict == "adequate" else plain
    ))  # fmt: skip
    monkeypatch.setattr(examine, "strangers", lambda *_: [2.55])
    found = examine._examine_body(heard, said, None, None)
    assert (found.verdict == "unexplained") is (told or verdict == "unexplained")
    assert any("2.55 Hz" in line for line in found.warnings) is told


def test_a_pitch_that_is_read_as_folded_is_told():
    measured, base = looked_at(PITCH)
    there = replace(ground(measured, base), data=SimpleNamespace(frame=1 / 25))
    assert body_lines(there, base) == []
    (line,) = body_lines(there, replace(base, read=np.array([3.0, 7.0, 14.0]), folded=(2,)))
    assert line.startswith("11 Hz is taken for 14 Hz") and "25 frames/s" in line


@pytest.mark.parametrize(
    ("acting", "evidence", "misfit", "in_damped_terms", "verdict", "decides"),
    [
        (dry_friction, 30.0, 1.0, 0.9, "explained", "final"),
        (stiffness_drift, 30.0, 1.0, 0.9, "explained", "damped"),  # its own modes were heard
        (split_modes, 30.0, 1.0, 0.9, "explained", "damped"),  # which the change may be instead of
        (dry_friction, 15.0, 1.0, 0.9, "explained", "damped"),  # which may mend what was bent
        (dry_friction, 30.0, 99.0, 0.9, "explained", "damped"),  # nor the shapes
        (dry_friction, 30.0, 1.0, 0.3, "explained", "damped"),  # where it shows already
        (dry_friction, 30.0, 1.0, 0.9, "unexplained", "damped"),  # a fit that tells of nothing
    ],
    ids=["bent", "straight", "split", "hardly clear", "other shapes", "seen", "unexplained"],
)
def test_where_the_declared_fits_modes_were_bent_the_final_fit_shows_what_a_change_mends(
    acting, evidence, misfit, in_damped_terms, verdict, decides, monkeypatch
):
    measured, base = looked_at(PITCH * [1.0, 1.1, 0.9])
    _, found = looked_at(PITCH)
    found = replace(found, chi2=misfit)
    law = SimpleNamespace(effects=[acting.EFFECT])
    fits = {"damped": SimpleNamespace(law=law), "final": SimpleNamespace(law=law)}
    left = {"damped": (in_damped_terms, 1.0, 0.1), "final": (0.2, 2.0, 0.15)}
    of = {id(fit): left[name] for name, fit in fits.items()}

    def body_error(declared, there, one, alike=(), fit=None):
        assert declared is fits["damped"] and alike == ([7] if one is base else ())
        with_it, before, _ = of[id(fit)]
        return Error(*(2 * [with_it if one is found else before]))

    monkeypatch.setattr(doubt, "body_error", body_error)
    monkeypatch.setattr(doubt, "errors", lambda fit: Error(*(2 * [of[id(fit)][2]])))
    said = SimpleNamespace(**fits, verdict=verdict)
    there = ground(measured, base)
    seen, told = doubt.judged(said, there, suspect(found, evidence), [7])
    assert tuple(one.held_out for one in seen) == left["damped"]
    assert tuple(one.held_out for one in told) == left[decides]


@pytest.mark.parametrize(
    ("then", "loudest", "does", "off"),
    [
        ([3.0, 7.0, 11.44], 0, True, [0.0, 0.0, 0.0196, 0.0]),  # a faint one was heard badly
        ([3.0, 7.28, 11.22], 1, True, [0.0196, 0.0196, 0.0196, 0.0196]),  # it bends the loudest
        ([3.0, 7.28, 11.22], 1, False, [0.0, 0.0, 0.0, 0.0]),  # nothing acts
    ],
)
def test_what_acts_in_time_makes_a_pitch_as_unsure_as_it_moved_that_or_the_loudest(
    monkeypatch, then, loudest, does, off
):
    """The last one is a further mode, of which nobody knows what moved it."""
    for name, value in (("acts", lambda _: does), ("bent", lambda _: 0.0), ("twins", lambda _: ())):
        monkeypatch.setattr(ground_file, name, value)
    law = SimpleNamespace(modes=3)
    final = SimpleNamespace(frequency=PITCH, law=law, loudest=loudest)
    damped = SimpleNamespace(frequency=np.array(then))
    bias = ground_file._biased(SimpleNamespace(final=final, damped=damped), np.r_[PITCH, 20.0])
    assert bias == pytest.approx(off, abs=2e-4)


@pytest.mark.parametrize("moved", [(0.0, 0.0), (0.0, 0.1)])
def test_what_moves_one_pitch_is_not_slight(monkeypatch, moved):
    monkeypatch.setattr(doubt, "gained", lambda *_: 0.0)
    monkeypatch.setattr(doubt, "creeps", lambda _: False)
    monkeypatch.setattr(doubt, "moved", lambda *_: np.array(moved))
    slight = doubt._is_slight(SimpleNamespace(final=None, damped=None))
    assert bool(slight) is (max(moved) == 0.0)
