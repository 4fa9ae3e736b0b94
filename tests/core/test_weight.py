"""Young's modulus of a body whose own weight is declared to stiffen or soften it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import weight
from core.body import Body, build_body
from core.data import Material
from core.doubt import EVIDENCE
from core.elasticity import assemble, gravity_force, hold_points, static
from core.errors import DataError
from core.ground import converged_sag
from core.modes import solve_modes
from core.turned import sag_between, weighs
from core.weight import (
    Tells,
    carries_weight,
    each_modulus,
    elastic_share,
    modulus_of_all,
    with_weight,
)
from tests.core.solids import block

YOUNG = 3e4  # Pa; of a strip that hangs or stands, its weight a good part of its stiffness


def body(gravity, declared=("gravity_preload",)):
    """A slender block held at one end, without its weight."""
    mesh = block((10, 2, 2), (0.2, 0.02, 0.03))
    model = assemble(mesh, Material(1000.0, 0.4))
    bare = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
    marker = SimpleNamespace(position=np.array([0.2, 0.01, 0.015]))
    recording = SimpleNamespace(markers=[marker])
    take = SimpleNamespace(recording=recording, loads=(), gravity=gravity)
    case = SimpleNamespace(takes=(take,), declared=declared)
    return build_body(case, bare, take)


def listener(*pitches, frame=0.0):
    """What is heard of any body: its lowest modes, with these pitches (Hz)."""
    count = len(pitches)
    law = SimpleNamespace(fitted=[0], takes=[SimpleNamespace(frame=frame or 1e-9)])
    free = SimpleNamespace(law=law, frequency=np.array(pitches), damping_ratio=np.full(count, 1e-6))

    def hear(one: Body):
        match = SimpleNamespace(modes=tuple(range(count)))
        return SimpleNamespace(body=one, match=match, free=free)

    return hear


@pytest.mark.parametrize("g", [9.81, -0.6])
def test_the_modulus_is_that_with_which_the_loaded_body_has_the_pitch(g):
    plain = body(np.array([g, 0.0, 0.0]))
    case = plain.case
    pitch = build_body(case, plain.bare, case.takes[0], YOUNG).modes.frequency[0] * np.sqrt(YOUNG)
    heard = with_weight(plain, listener(pitch))
    assert heard.body.carried == pytest.approx(YOUNG, rel=0.003)
    bare = (pitch / plain.modes.frequency[0]) ** 2
    assert (bare > YOUNG) == (g > 0)  # what hangs would be taken for stiffer stuff


def test_a_mode_that_is_hardly_elastic_is_no_gauge_of_the_modulus():
    """A first pitch two per cent high would make a strip far stiffer; nor are three of five modes
    that something moves, where the others tell more.
    """
    plain, soft = body(np.array([9.81, 0.0, 0.0])), 1e4
    carrying = build_body(plain.case, plain.bare, plain.case.takes[0], soft)
    pitches = carrying.modes.frequency[:5] * np.sqrt(soft) * [1.02, 1.02, 1.0, 1.02, 1.0]
    assert elastic_share(carrying)[0] < 0.06
    assert with_weight(plain, listener(*pitches)).body.carried == pytest.approx(soft, rel=0.005)
    alone = with_weight(plain, listener(pitches[0])).body.carried
    assert alone / soft > 1.25


@pytest.mark.parametrize("soft", [6e3, 1e4])
def test_a_strip_that_hangs_nearly_as_a_chain_does_tells_its_modulus(soft):
    """In the shape that it has without its weight no modulus gives the pitch, nor in a stiffer
    one's.
    """
    plain = body(np.array([9.81, 0.0, 0.0]))
    carrying = build_body(plain.case, plain.bare, plain.case.takes[0], soft)
    heard = with_weight(plain, listener(carrying.modes.frequency[0] * np.sqrt(soft)))
    assert heard.body.carried == pytest.approx(soft, rel=0.01)


def test_a_pitch_that_the_frame_rate_folds_tells_the_modulus_of_the_true_one():
    plain = body(np.array([9.81, 0.0, 0.0]))
    carrying = build_body(plain.case, plain.bare, plain.case.takes[0], YOUNG)
    true = carrying.modes.frequency[:3] * np.sqrt(YOUNG)
    rate = 1.6 * true[2]
    assert true[1] < rate / 2
    seen = listener(*true[:2], rate - true[2], frame=1 / rate)
    assert with_weight(plain, seen).body.carried == pytest.approx(YOUNG, rel=0.005)


@pytest.mark.parametrize("turned", [True, False])
def test_a_strip_turned_over_tells_its_weight_from_what_rings_alike_both_ways(turned):
    """It hangs in the first take and stands, or lies as it did, in the second."""
    hanging = body(np.array([9.81, 0.0, 0.0]))
    take = hanging.case.takes[0]
    other = SimpleNamespace(**vars(take) | {"gravity": np.array([-2.0, 0.0, 0.0])})
    hanging.case.takes = (take, other if turned else take)
    pitches = [
        build_body(hanging.case, hanging.bare, one, 1e5).modes.frequency[:2]
        for one in hanging.case.takes
    ]
    heard = SimpleNamespace(body=hanging, match=SimpleNamespace(modes=(0, 1)))

    def found(*heard_pitches):
        logs = [np.r_[np.log(f), 0.02, 0.02] for f in heard_pitches]
        law = SimpleNamespace(fitted=[0, 1], pitch=(0, int(turned)), modes=2)
        law.takes, law.setting = [SimpleNamespace(frame=0.01)], SimpleNamespace(omega=[10.0])
        return SimpleNamespace(
            law=law, parameters=np.concatenate(logs), covariance=1e-8 * np.eye(8), chi2=1, samples=1
        )

    weighty, alike = found(*pitches), found(pitches[0], pitches[0])
    if not turned:
        assert weighs(heard, weighty, 1e5) == 0
        return
    assert weighs(heard, weighty, 1e5) > 50
    assert weighs(heard, alike, 1e5) < -50
    stiff = [
        build_body(hanging.case, hanging.bare, one, 4e7).modes.frequency[:2]
        for one in hanging.case.takes
    ]
    assert 0.003 < abs(np.log(stiff[1] / stiff[0])[0]) < 0.006  # so little is clear all the same
    assert weighs(heard, found(*stiff), 4e7) > EVIDENCE


@pytest.mark.parametrize(
    ("gravity", "loads", "pitch", "known"),
    [
        (-9.81, (), 7.01, True),
        (-9.81, (), 7.1, False),  # it hangs, and stands
        (-2.0, (), 7.01, False),
        (9.81, (), 7.01, False),
        (-9.81, ("a mass",), 7.01, False),
    ],
)
def test_a_sag_is_told_between_a_body_and_the_same_body_turned_right_over(
    gravity, loads, pitch, known
):
    down, rest = np.array([9.81, 0.0, 0.0]), [np.array([3.0, 1.0]), np.array([-1.0, 2.0])]
    other = SimpleNamespace(gravity=gravity / 9.81 * down, loads=loads)
    takes = [SimpleNamespace(take=SimpleNamespace(gravity=down, loads=())), SimpleNamespace()]
    takes.append(SimpleNamespace(take=other))  # the one between is held out
    law = SimpleNamespace(fitted=[0, 2], takes=takes)
    pitches = np.array([[3.0, 7.0], [4.0, pitch]])  # of which the first is faint
    found = {"rest": lambda n=0: rest[n], "pitches": lambda n: pitches[n], "loudest": 1}
    sag = sag_between(SimpleNamespace(law=law, **found))
    assert sag == pytest.approx([2.0, -0.5]) if known else sag is None


@pytest.mark.parametrize(("element", "off"), [("p1", 0.3), ("p1_smoothed", 0.005)])
def test_a_sag_converges_with_the_modes_that_are_in_it(element, off):
    """Against quadratic elements on a finer mesh, where bending is `off` too stiff or too soft."""

    def sagging(divisions, element):
        model = assemble(block(divisions, (0.1, 0.015, 0.02)), Material(1000.0, 0.3), element)
        model = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
        modes = solve_modes(model, 6)
        tip = np.argmin(np.linalg.norm(model.points - [0.1, 0.0075, 0.02], axis=1))
        weight = gravity_force(model, np.array([0.0, 0.0, -9.81]))
        values = (2 * np.pi * modes.frequency) ** 2
        held = np.einsum("pim,pi->m", modes.shapes, weight.reshape(-1, 3)) / values
        sag = static(model, weight, 1.0).reshape(-1, 3)[tip, 2:]
        return sag, modes.shapes[tip, 2:].T, held, values

    coarse, shapes, held, values = sagging((12, 3, 3), element)
    (fine,), *_, converged = sagging((16, 4, 4), "p2")
    assert abs(coarse[0] - fine) > off * abs(fine)
    corrected = converged_sag(coarse, shapes, held, converged / values)
    assert abs(corrected[0] - fine) < 0.1 * abs(coarse[0] - fine)


def tells(share, stiff=0.0, *, young=YOUNG, carried=YOUNG, stiff_sigma=0.0):
    """What modes of a body with the modulus `young` say, on a mesh that carries `carried`."""
    share, stiff = np.asarray(share, float), np.full(len(share), stiff)
    # of the computed stiffness at `carried`: what a converged mesh's elastic part would be
    elastic = 1 / (1 + stiff) - (1 - share)
    over = young * elastic + carried * (1 - share)
    return Tells(share, over, np.full(share.size, 1e-6), stiff, np.full(share.size, stiff_sigma))


@pytest.mark.parametrize("share", [[0.3, 0.8, 0.9], [1.7, 1.1, 1.02]])
@pytest.mark.parametrize("carried", [0.9 * YOUNG, 1.2 * YOUNG])
def test_of_the_weight_s_part_of_a_pitch_the_mesh_stiffens_nothing(share, carried):
    """What hangs, and what stands."""
    some = tells(share, 0.03, carried=carried)
    assert each_modulus(carried, some)[1] == pytest.approx(YOUNG, rel=1e-9)
    _, material = modulus_of_all(carried, some)
    assert material.value == pytest.approx(YOUNG, rel=1e-9)
    assert material.high < 1.03 * material.low


def test_what_the_mesh_stiffens_unsurely_counts_the_more_the_more_is_weight():
    for share in (0.2, 1.0):
        middle, wide = (
            modulus_of_all(YOUNG, tells([share], 0.05 + more, stiff_sigma=sigma))[1]
            for more, sigma in ((0.0, 0.01), (0.0, 0.02))
        )
        a, b = (tells([share], 0.05 + h) for h in (0.0, 1e-6))
        over = a.over  # what was measured stays
        moved = [
            each_modulus(
                YOUNG,
                Tells(
                    share=x.share,
                    over=over,
                    sigma=x.sigma,
                    stiff=x.stiff,
                    stiff_sigma=x.stiff_sigma,
                ),
            )[1, 0]
            for x in (a, b)
        ]
        slope = np.log(moved[1] / moved[0]) / 1e-6
        widths = [(np.log(e.high / e.low) / 2 / 1.959964) ** 2 for e in (middle, wide)]
        assert np.sqrt((widths[1] - widths[0]) / 3) == pytest.approx(0.01 * slope, rel=1e-3)


def test_modes_that_hang_on_the_weight_say_little_and_the_interval_holds_the_truth():
    share, inside, errors = np.array([0.25, 0.8, 0.9, 0.95, 0.95]), 0, []
    rng, exact = np.random.default_rng(1), tells([0.25, 0.8, 0.9, 0.95, 0.95], 0.01)
    for _ in range(400):
        off = replace(exact, over=exact.over * (1 + 0.01 * rng.normal(size=5)))
        _, found = modulus_of_all(YOUNG, off)
        inside += found.low < YOUNG < found.high
        errors.append(np.log(found.value / YOUNG))
    assert 0.85 < inside / 400 < 0.97  # of five modes the scatter is known to a third
    assert np.std(errors) < 1.1 * 0.01 / np.linalg.norm(share)
    assert abs(np.mean(errors)) < 0.002


def test_what_hangs_on_its_weight_alone_tells_no_modulus():
    some = tells([0.02, 0.04])
    assert np.isnan(each_modulus(YOUNG, some)).all()
    found, _ = modulus_of_all(YOUNG, some)
    assert found.low == 0
    assert found.high > 10 * YOUNG


def test_the_elastic_share_is_what_a_stiffer_body_s_pitches_follow():
    plain = body(np.array([9.81, 0.0, 0.0]))
    one, two = (
        build_body(plain.case, plain.bare, plain.case.takes[0], y).modes.frequency[:4] * np.sqrt(y)
        for y in (YOUNG, 1.02 * YOUNG)
    )
    share = elastic_share(build_body(plain.case, plain.bare, plain.case.takes[0], 1.01 * YOUNG))
    assert share[:4] == pytest.approx(2 * np.log(two / one) / np.log(1.02), rel=0.01)
    assert share[0] < 0.8  # it hangs
    assert elastic_share(plain) == pytest.approx(1.0)


def test_a_pitch_that_no_modulus_gives_leaves_the_body_as_it_is():
    plain = body(np.array([9.81, 0.0, 0.0]))
    assert with_weight(plain, listener(0.1)).body is plain  # it swings faster as a mere pendulum


def test_a_body_that_stands_with_no_modulus_is_refused(monkeypatch):
    def falls(*_):
        raise DataError("it would come apart")

    plain = body(np.array([9.81, 0.0, 0.0]))
    monkeypatch.setattr(weight, "build_body", falls)
    with pytest.raises(DataError, match="come apart"):
        with_weight(plain, listener(20.0))


def test_without_gravity_or_unless_declared_it_is_no_part_of_the_body():
    assert carries_weight(body(np.array([9.81, 0.0, 0.0])))
    assert not carries_weight(body(None))
    assert not carries_weight(replace(body(np.array([9.81, 0.0, 0.0]), declared=())))
