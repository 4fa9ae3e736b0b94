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
from core.weight import carries_weight, with_weight
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
