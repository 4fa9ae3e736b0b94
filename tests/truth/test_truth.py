"""The simulator itself, held to closed forms."""

import ast
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.special import ellipk

from tests.truth import bodies, film, forces, linear_fit, plant_body, reduced, scene, solid
from tests.truth.make import load_known, second

RUBBER = {"density": 1000.0, "poisson": 0.3}


@pytest.fixture(scope="module")
def beam():
    """A slender square bar, 1 Pa: 0.2 m by 8 mm."""
    size = 0.2 * np.array([1, 0.04, 0.04])
    return bodies.build(
        "beam", lambda u: size * (u - [0, 0.5, 0.5]), (16, 1, 1), axis=[1, 0, 0], swing=[0, 0, 1],
        **RUBBER,
    )  # fmt: skip


def oscillator(omega=2 * np.pi, ratio=0.0, branch=None) -> reduced.System:
    """One mass of 1 kg."""
    one = np.ones((1, 1))
    return reduced.System(
        np.ones((3, 1)), one, 2 * ratio * omega * one, omega**2 * one,
        np.array([omega / 2 / np.pi]), np.array([ratio]), branch,
    )  # fmt: skip


def ring(system, start, seconds=10.0, acting=(), per_second=220):
    return reduced.run(
        system, np.array(start, float), 1 / per_second, int(seconds * per_second), acting
    )


def tops(x) -> np.ndarray:
    """Local maxima of |x|, refined by a parabola."""
    a = np.abs(x)
    i = np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:])) + 1
    bend = a[i - 1] - 2 * a[i] + a[i + 1]
    return a[i] - (a[i + 1] - a[i - 1]) ** 2 / (8 * bend)


def test_nothing_of_the_code_under_test_is_imported():
    for path in Path(solid.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] in ("core", "ringdown") for name in names), path


def test_a_slender_clamped_beam_rings_as_euler_and_bernoulli_say(beam):
    length, side = 0.2, 0.008
    swung = np.sqrt(1 / RUBBER["density"]) * side / np.sqrt(12) / (2 * np.pi * length**2)
    f = bodies.modes(beam, 6)[0]
    bending = f[[0, 2]]  # each twice, in two planes
    assert bending == pytest.approx(np.array([1.8751, 4.6941]) ** 2 * swung, rel=0.012)
    assert f[1] == pytest.approx(f[0], rel=1e-6)


@pytest.mark.slow
def test_the_objects_are_within_half_a_per_cent_of_a_mesh_twice_as_fine():
    for name in ("bar", "strip"):
        coarse, fine = (bodies.OBJECTS[name](np.random.default_rng(5), fine=n) for n in (1, 2))
        assert coarse.young == pytest.approx(fine.young, rel=5e-3)


@pytest.mark.parametrize("name", bodies.OBJECTS)
def test_the_given_surface_is_closed_and_holds_the_bodys_volume(name):
    body = bodies.OBJECTS[name](np.random.default_rng(3))
    v, t = body.vertices, body.triangles
    corners = v[t]
    volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    edges = np.sort(t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert volume == pytest.approx(body.weight / body.density, rel=4e-3)


def test_rigid_motions_cost_no_energy_and_the_mass_is_the_mass(beam):
    x = beam.nodes
    rigid = [np.tile(e, len(x)) for e in np.eye(3)]
    rigid += [np.cross(e, x).ravel() for e in np.eye(3)]
    scale = abs(beam.stiffness).sum(0).max() * abs(x).max()
    assert max(abs(beam.stiffness @ u).max() for u in rigid) < 1e-11 * scale
    assert beam.weight == pytest.approx(RUBBER["density"] * 0.2 * 0.008**2, rel=1e-12)


def test_the_bent_tangent_is_the_slope_of_the_inner_force_and_starts_linear(beam):
    rng = np.random.default_rng(0)
    u, d = (1e-3 * rng.standard_normal(3 * len(beam.nodes)) for _ in range(2))
    up, down = (solid.bent(beam.nodes, beam.cells, 0.3, u + s * 1e-4 * d)[0] for s in (1, -1))
    force, K = solid.bent(beam.nodes, beam.cells, 0.3, u)
    assert np.linalg.norm((up - down) / 2e-4 - K @ d) < 1e-6 * np.linalg.norm(K @ d)
    free = solid.bent(beam.nodes, beam.cells, 0.3, 0 * u)
    assert np.abs(free[0]).max() == 0


def test_a_hanging_strips_pitch_rises_as_rayleigh_says(beam):
    """w^2 = w0^2 + g * integral of weight below times slope^2 over that of mode^2."""
    hung = replace(bodies.tuned(beam, 4.0), axis=np.array([1.0, 0, 0]))
    gravity = np.array([9.81, 0, 0])
    u = plant_body.sink(hung, gravity)
    _, K = solid.bent(hung.nodes, hung.cells, hung.poisson, u)
    _, rest = solid.bent(hung.nodes, hung.cells, hung.poisson, 0 * u)
    loaded = replace(hung, stiffness=hung.stiffness + hung.young * (K - rest))
    s = np.linspace(0, 1, 2001)
    b = 1.8751
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    w = np.cosh(b * s) - np.cos(b * s) - ratio * (np.sinh(b * s) - np.sin(b * s))
    slope = np.gradient(w, s)
    rise = 9.81 / 0.2 * trapezoid((1 - s) * slope**2, s) / trapezoid(w**2, s)
    found = bodies.modes(loaded, 1)[0][0] ** 2 - 16.0
    assert found * (2 * np.pi) ** 2 == pytest.approx(rise, rel=0.02)


def test_viscous_decay_has_the_drawn_logarithmic_decrement():
    z = 0.03
    x = ring(oscillator(ratio=z), [1, 0]).q[:, 0]
    peaks = tops(x)[:15]
    decrement = np.log(peaks[:-2] / peaks[2:])
    assert decrement == pytest.approx(2 * np.pi * z / np.sqrt(1 - z**2), rel=2e-4)


def test_a_cubic_spring_without_loss_keeps_its_energy_and_duffings_period():
    w, a = 2 * np.pi, 1.0
    cubic = 0.8 * w**2
    spring = forces.Spring(np.ones(1), lambda x: cubic * x**3)
    track = ring(oscillator(), [a, 0], acting=[spring])
    energy = track.v[:, 0] ** 2 / 2 + w**2 * track.q[:, 0] ** 2 / 2 + cubic * track.q[:, 0] ** 4 / 4
    assert np.ptp(energy) < 1e-6 * energy[0]
    big = w**2 + cubic * a**2  # exact: T = 4 K(m) / sqrt(big), m = cubic a^2 / (2 big)
    period = 4 * ellipk(cubic * a**2 / (2 * big)) / np.sqrt(big)
    x = track.q[:, 0]
    i = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    crossings = track.time[i] + (track.time[1]) * x[i] / (x[i] - x[i + 1])
    assert np.diff(crossings) == pytest.approx(period, rel=3e-4)


def test_dry_friction_takes_four_times_the_force_over_the_stiffness_each_cycle():
    w, force = 2 * np.pi, 0.03 * (2 * np.pi) ** 2
    rub = forces.Rub(np.ones(1), lambda speed: force, 3e3 * w**2, place=1.0)
    x = ring(oscillator(), [1, 0], acting=[rub], per_second=3000).q[:, 0]
    peaks = tops(x)
    assert (peaks[:-2] - peaks[2:])[:12] == pytest.approx(4 * force / w**2, rel=0.03)
    assert np.ptp(x[-3000:]) < 2 * force / w**2 * 1.05  # dead stop


def test_a_support_that_goes_two_ways_pushes_as_both_do():
    rng = np.random.default_rng(3)
    inertia, q = rng.standard_normal((4, 2)), np.zeros(4)
    both = forces.Shaken(inertia, lambda t: np.array([np.sin(t), t]))
    one = forces.Shaken(inertia[:, 0], np.sin)
    other = forces.Shaken(inertia[:, 1], lambda t: t)
    assert both.force(q, q, 0.7) == pytest.approx(one.force(q, q, 0.7) + other.force(q, q, 0.7))
    assert one.force(q, q, 0.7) == pytest.approx(-inertia[:, 0] * np.sin(0.7))  # it stays behind


def test_what_rubs_in_a_plane_has_no_direction_of_its_own():
    """Turned, a straight swing rubs as along a line, and a round one falls as a spiral does."""
    w, force = 2 * np.pi, 0.03 * (2 * np.pi) ** 2
    two = reduced.System(
        np.eye(3, 2), np.eye(2), np.zeros((2, 2)), w**2 * np.eye(2), np.ones(2), np.zeros(2)
    )
    turned = np.array([[0.8, -0.6], [0.6, 0.8]])
    line = forces.Rub(np.ones(1), lambda speed: force, 3e3 * w**2, place=1.0)
    x = ring(oscillator(), [1, 0], seconds=4, acting=[line], per_second=3000).q[:, 0]
    plane = forces.PlaneRub(turned, force, 3e3 * w**2, place=turned @ [0.6, 0.8])
    q = ring(two, [0.6, 0.8, 0, 0], seconds=4, acting=[plane], per_second=3000).q
    assert q @ [0.6, 0.8] == pytest.approx(x, abs=1e-3)
    assert q @ [0.8, -0.6] == pytest.approx(0, abs=1e-3)
    plane = forces.PlaneRub(turned, force, 3e3 * w**2, place=turned @ [1.0, 0.0])
    q = ring(two, [1, 0, 0, w], seconds=4, acting=[plane], per_second=3000).q
    radius = np.linalg.norm(q, axis=1)
    time = np.arange(len(radius)) / 3000
    assert radius == pytest.approx(1 - force / w / 2 * time, abs=0.02)


def test_a_stiff_rub_on_soft_stuff_holds_still_what_moves_less_than_it_can_hold():
    """The stuff round the node is light and yields: its own swing on the bristle is a quick one."""
    slow, light = (2 * np.pi * np.array([7.0, 325.0])) ** 2
    system = reduced.System(
        np.eye(3, 2), np.eye(2), np.diag([0.2, 800.0]), np.diag([slow, light]), np.zeros(2),
        np.zeros(2),
    )  # fmt: skip
    row = np.array([1.8, 140.0])
    rub = forces.Rub(row, lambda speed: 0.05, 3400.0, place=row @ [3e-5, 0.0])
    start = np.array([3e-5, 0.0, 0.0, 0.0])
    rate = film.quickest(system, start, [rub]) / film.SPAN
    track = reduced.run(system, start, 1 / rate, int(rate), [rub])
    moved = np.abs(track.q @ row - track.q[0] @ row).max()
    assert moved < 0.05 / 3400  # no slip
    ups = np.diff(track.time[1:][np.diff(np.sign(track.q[:, 0] - track.q[-1000:, 0].mean())) > 0])
    stiff = np.diag([slow, light]) + 3400 * np.outer(row, row)
    assert 1 / ups.mean() == pytest.approx(
        np.sqrt(np.linalg.eigvalsh(stiff)[0]) / 2 / np.pi, rel=0.01
    )


def test_quadratic_drag_takes_a_share_that_grows_with_amplitude():
    """Per half period A' = A - (4/3) c A^2 / m, to first order in c."""
    c = 0.01
    area = np.array([[c, 0, 0], [-c, 0, 0]])  # front and back of a plate
    drag = forces.Drag(np.tile(np.array([[1.0], [0], [0]]), (2, 1)), area, 1.0)
    peaks = tops(ring(oscillator(), [1, 0], acting=[drag]).q[:, 0])
    lost = 1 / peaks[1:] - 1 / peaks[:-1]
    assert lost == pytest.approx(4 / 3 * c, rel=0.02)


def test_a_relaxing_branch_creeps_back_with_its_own_time():
    system = oscillator(omega=60.0, ratio=0.05, branch=(0.3, 0.7))
    track = ring(system, [1, 0, 1], seconds=3, per_second=2000)
    mean = track.q[2000:, 0]
    late = track.time[2000:]
    slow = 0.7 * 1.3  # at rest q = r s / (1 + r), so s' = -s / (tau (1 + r))
    fit = np.polyfit(late, np.log(mean), 1)
    assert fit[0] == pytest.approx(-1 / slow, rel=0.02)


def test_a_stiffer_bed_brings_a_compliant_pin_back_to_the_clamp(beam):
    stage = type("S", (), {"body": beam})
    pin = plant_body.compliant_pin(np.random.default_rng(0), stage)
    soft, hard = (bodies.modes(*_bed(pin, beam, s))[0][0] for s in (0.3, 1e-4))
    clamped = bodies.modes(beam, 1)[0][0]
    assert soft < 0.95 * clamped
    assert hard == pytest.approx(clamped, rel=2e-3)


@pytest.mark.parametrize("name", ["graded_stiffness", "poisson_ratio"])
def test_a_change_of_the_stuff_leaves_a_load_of_another_take_on_it(beam, name):
    stage = type("S", (), {"body": beam})
    change = getattr(plant_body, name)(np.random.default_rng(0), stage)
    tip = int(np.argmax(beam.nodes @ beam.axis))
    heavy = replace(beam, mass=plant_body.weighted(beam, tip, 0.5 * beam.weight))
    bare, laden = (bodies.modes(change.body(change.strength, b)[0], 1)[0][0] for b in (beam, heavy))
    assert laden < 0.8 * bare


def test_a_second_take_declares_every_load_that_is_on_its_body(beam):
    """A take's loads stand for the case's, so that what stays on is told again."""
    rng = np.random.default_rng(1)
    for once in ((), (0,)):
        stage = SimpleNamespace(body=beam, loads=[], release="pull", amplitude=1e-3)
        for _ in once:
            load_known(rng, stage)
        some = (second(rng, "added_mass", stage, []) for _ in range(100))
        other, _, entry = next(one for one in some if one)
        more = (other.body.mass - beam.mass).sum() / 3
        assert sum(one["mass"] for one in entry["load"]) == pytest.approx(more)
        assert len(entry["load"]) == 1 + len(once)


def test_a_pair_that_is_one_by_symmetry_is_damped_alike():
    rng = np.random.default_rng(3)
    pudding = bodies.pudding(rng)
    ratio = scene.in_pairs(pudding, rng.uniform(0.01, 0.03, scene.MODES))
    pitch = bodies.modes(pudding, scene.MODES)[0]
    assert pitch[1] == pytest.approx(pitch[0], rel=1e-6)
    assert ratio[1] == ratio[0] != ratio[2]


def _bed(pin, body, strength):
    changed, ground = pin.body(strength, body)
    return changed, 1, ground


def test_a_linear_record_leaves_nothing_and_a_line_that_stays_is_left():
    t = np.arange(400) / 100
    wave = np.exp(-0.4 * t) * np.cos(2 * np.pi * 3 * t)
    shapes = np.array([1.0, -0.5, 0.2])
    start = np.array([2.9]), np.array([0.03])
    assert linear_fit.leftover(t, np.outer(wave, shapes), *start) < 2e-3
    steady = 0.1 * np.sin(2 * np.pi * 4.7 * t)[:, None]
    left = linear_fit.leftover(t, np.outer(wave, shapes) + steady, *start)
    assert left == pytest.approx(0.1 / np.sqrt(2), rel=0.05)


def test_a_pull_starts_at_the_static_shape_and_at_rest(beam):
    body = bodies.tuned(beam, 3.0)
    stage = scene.draw(np.random.default_rng(1), body, {"release": "pull"})
    stage.limit = 1e9
    system = scene.system_of(stage, body)
    state, _ = scene.start_of(stage, system)
    push = np.outer(scene.grip(body, stage.node), stage.direction).ravel()
    u = bodies.respond(body, push[:, None])[:, 0]
    u *= stage.amplitude / (push @ u)
    q = state[: system.size]
    assert np.abs(system.basis @ q - u).max() < 1e-6 * np.abs(u).max()
    assert not state[system.size :].any()


def test_forces_that_ask_for_the_same_response_count_once(beam):
    push = np.zeros((beam.mass.shape[0], 2))
    push[-1], push[-2, 1] = 1.0, 1e-9
    one, two = (reduced.reduce(beam, 4, push[:, :n]) for n in (1, 2))
    assert two.size == one.size
    assert two.frequency[:5] == pytest.approx(one.frequency[:5], rel=1e-6)


def test_shapes_of_one_frequency_are_the_same_whichever_way_they_were_found_turned():
    rng = np.random.default_rng(8)
    omega2, shapes = np.array([1.0, 1.0, 2.0, 3.0, 3.0]), rng.standard_normal((30, 5))
    some = rng.standard_normal(30)
    turned = shapes.copy()
    for pair, angle in (([0, 1], 0.7), ([3, 4], -2.0)):
        c, s = np.cos(angle), np.sin(angle)
        turned[:, pair] = shapes[:, pair] @ np.array([[c, -s], [s, c]])
    turned[:, [1, 2]] *= -1
    one, other = (bodies.directed(omega2, x, some) for x in (shapes, turned))
    assert other == pytest.approx(one, abs=1e-12)
    spans = [np.linalg.matrix_rank(np.hstack([one[:, p], shapes[:, p]])) for p in ([0, 1], [2])]
    assert spans == [2, 1]
