"""Young's modulus of a body whose own weight is declared to stiffen or soften it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from core import weight
from core.body import Body, build_body
from core.data import Material
from core.elasticity import assemble, hold_points
from core.errors import DataError
from core.turned import weighs
from core.weight import carries_weight, elastic_share, moduli, with_weight
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


def listener(pitch):
    """What is heard of any body: its first mode, with that pitch (Hz)."""

    def hear(one: Body):
        return SimpleNamespace(
            body=one,
            match=SimpleNamespace(modes=(0,)),
            free=SimpleNamespace(frequency=np.array([pitch])),
        )

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


def told(rng, share, off, stiff):
    """The two moduli of modes whose squared pitches are off by a relative `off`."""
    share, stiff = np.asarray(share), np.asarray(stiff)
    # w^2 = Y k + g of the true body; the mesh's k is 1 + s / (share of a converged one) times it
    fine = 1 / (1 + stiff)  # of the computed stiffness
    heavy = 1 - share
    elastic = fine - heavy
    over = 0.9 * YOUNG * (elastic / 0.9 + heavy) * (1 + off * rng.normal(size=share.size))
    return moduli(0.9 * YOUNG, share, over, np.full(share.size, 1e-6), stiff, np.zeros(share.size))


def test_the_weight_s_part_of_a_pitch_takes_none_of_the_mesh_s_stiffening():
    _, material = told(np.random.default_rng(0), [0.3, 0.8, 0.9], 0.0, [0.02, 0.03, 0.06])
    assert material.value == pytest.approx(YOUNG, rel=1e-9)
    assert material.high < 1.02 * material.low


def test_modes_that_hang_on_the_weight_say_little_and_the_interval_holds_the_truth():
    share, inside, errors = [0.25, 0.8, 0.9, 0.95, 0.95], 0, []
    rng = np.random.default_rng(1)
    for _ in range(400):
        _, found = told(rng, share, 0.01, np.full(5, 0.01))
        inside += found.low < YOUNG < found.high
        errors.append(np.log(found.value / YOUNG))
    assert 0.85 < inside / 400 < 0.97  # of five modes the scatter is known to a third
    assert np.std(errors) < 1.1 * 0.01 / np.linalg.norm(share)
    assert abs(np.mean(errors)) < 0.002


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
