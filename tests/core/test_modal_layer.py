"""Bodies in a small basis against the same ones solved in full."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import block_diag, eigh

from core.all_told import damps_alike
from core.boundary import face_points
from core.compare import STRANGE, UNFOLDING, Measured, compare
from core.data import Material
from core.doubt import DOUBT, chance_of
from core.effects import added_mass, compliant_pin, graded_stiffness, poisson_ratio
from core.elasticity import assemble, hold, lump_operator, lump_radius
from core.folds import folds_of
from core.ground import parted
from core.match import mac
from core.modal_layer import _fit, improved
from core.modes import solve_modes
from tests.core.solids import block, box_surface

STOCKY, SLENDER = ((6, 2, 2), (0.1, 0.03, 0.02)), ((12, 2, 2), (0.2, 0.01, 0.01))


@pytest.fixture(scope="module", params=[STOCKY, SLENDER], ids=["stocky", "slender"])
def body(request):
    counts, size = request.param
    surface = box_surface(size)
    free = assemble(block(counts, size, jitter=0.2), Material(1000.0, 0.45))
    model = hold(free, surface, surface.vertices[:, 0] < 1e-9)
    return SimpleNamespace(model=model, modes=solve_modes(model, 16))


def reduced(body, effect):
    shapes = body.modes.shapes.reshape(-1, 16)
    return effect.families(body, lambda model, n: improved(model, shapes[:, :n]))


def differ(family, theta, model):
    """The most that one of the six lowest pitches is off."""
    K, M = family.matrices(np.asarray(theta, float))
    told = np.sqrt(eigh(K, M, eigvals_only=True)[:6]) / (2 * np.pi)
    return np.abs(told / solve_modes(model, 6).frequency - 1).max()


@pytest.mark.parametrize("ratio", [0.1, 0.4, 2.5, 10.0])
def test_a_graded_body_has_the_pitches_of_the_whole_one(body, ratio):
    for n, family in enumerate(reduced(body, graded_stiffness)):
        axis = graded_stiffness._axes(body.model)[n]
        linear = graded_stiffness.change_model(body.model, (ratio, *axis))
        assert differ(family, (0, np.log(ratio)), linear) < 2e-3
        steep = graded_stiffness._scaled(
            body.model, ratio ** graded_stiffness._along(body.model, axis)
        )
        assert differ(family, (1, np.log(ratio)), steep) < 4e-3


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_axis_of_a_gradient_points_away_from_where_the_body_is_held(body, way, monkeypatch):
    """Whatever sign it came with: the ratio is the far end's over the held one's."""
    held = body.model.points[body.model.pinned].mean(axis=0)
    outwards = body.model.points.mean(axis=0) - held
    own = np.eye(3)[[np.argmax(np.abs(outwards))]]
    monkeypatch.setattr(graded_stiffness, "_axes", lambda model: way * own)
    (family,) = reduced(body, graded_stiffness)
    assert family.report(np.array([0, 0.3]), 1.0)["axis"] @ outwards > 0


@pytest.mark.parametrize(("effect", "values", "told"), [
    (poisson_ratio, (0.1, 0.36, 0.48), lambda value: value),
    (compliant_pin, (5.0, 60.0, 900.0), np.log),
])  # fmt: skip
def test_a_changed_body_has_the_pitches_of_the_whole_one(body, effect, values, told):
    (family,) = reduced(body, effect)
    for value in values:
        changed = effect.change_model(body.model, (value,))
        assert differ(family, (told(value),), changed) < 2e-3


def sprung(model, place, mass, radius, k, over_foot=True):
    """Pitches (6,) Hz and shapes (P, 3, 6) with a lump on a spring of k N/m, solved in full."""
    free = model.free
    N = lump_operator(model, place[None], radius, over_foot=over_foot).toarray()[:, free]
    K, M = (m[free][:, free].toarray() for m in (model.stiffness, model.mass))
    K = np.block([[K + k * N.T @ N, -k * N.T], [-k * N, k * np.eye(3)]])
    values, x = eigh(K, block_diag(M, mass * np.eye(3)), subset_by_index=[0, 5])
    shapes = np.zeros((3 * len(model.points), 6))
    shapes[free] = x[:-3]
    return np.sqrt(values) / (2 * np.pi), shapes.reshape(-1, 3, 6)


@pytest.mark.parametrize("share", [0.03, 0.3, 1.5])
@pytest.mark.parametrize("sits", range(len(added_mass.SITS)))
def test_a_body_with_a_lump_on_it_is_as_near_in_a_few_shapes(body, share, sits):
    """In the body's modes and what gives under the lump, at any of the places."""
    case = SimpleNamespace(takes=[SimpleNamespace(gravity=None)])
    bearer = added_mass.Bearer.of(
        SimpleNamespace(model=body.model, modes=body.modes, case=case, bare=body.model)
    )
    on = [p for p in face_points(body.model) if not body.model.pinned[p]]
    places = body.model.points[np.random.default_rng(2).choice(on, 3, replace=False)]
    search = added_mass.Search(places, np.log([share]), (0.5,), added_mass.SITS, 0.01)
    family = added_mass._family(bearer, search)
    seat = added_mass.SITS[sits]
    radius = seat.width * lump_radius(bearer.mass * share)
    for n, place in enumerate(places):
        theta = np.array([n, 0, sits, np.log(0.5), np.log(share)])
        K, M = family.matrices(theta)
        values, x = eigh(K, M, subset_by_index=[0, 5])
        pitch, shapes = sprung(
            body.model, place, bearer.mass * share, radius, radius / 0.5, seat.over_foot
        )
        assert np.sqrt(values) / (2 * np.pi) == pytest.approx(pitch, rel=1e-4)
        told = (family.basis @ (family.within(theta) @ x)).reshape(shapes.shape)
        for k in range(3):
            assert mac(told[:, :, k].ravel(), shapes[:, :, k].ravel()) > 0.999


def test_a_lump_is_sought_around_places_that_lie_apart_and_no_heavier_than_it_may_be(body):
    one = SimpleNamespace(model=body.model, modes=body.modes, bare=body.model)
    bearer = added_mass.Bearer.of(one)
    on = body.model.points[face_points(body.model)]
    reach, away = np.ptp(on, axis=0).max() / 4, np.linalg.norm(on - on[0], axis=1)
    places = on[[0, int(np.argsort(away)[1]), int(np.argmax(away))]]
    heavy = np.log(added_mass.HEAVIEST)
    lumps = [np.array([n, 0, 0, 0.0, heavy]) for n in (0, 1, 2)]
    rigid, plain = added_mass.GIVES[:1], added_mass.SITS[:1]
    search = added_mass.Search(places, np.zeros(1), rigid, plain, reach)
    assert [lump[0] for lump in search.chosen(lumps)] == [0, 2]
    closer = search.around(bearer, lumps[2:])
    assert np.allclose(closer.places[0], places[2])
    assert closer.sizes.max() == pytest.approx(heavy) and closer.sizes.min() < heavy
    off = np.linalg.norm(closer.places[1:] - places[2], axis=1)
    assert (off > closer.reach / 4).all() and closer.reach <= reach


@pytest.mark.parametrize(
    "sits", [(1.0, True, 2.0), (1.0, True, 0.5), (1.7, False, 0.02), (1.3, True, 0.02)]
)
@pytest.mark.parametrize("place", [(0.1, 0.0225, 0.015), (0.07, 0.03, 0.005), (0.05, 0.0, 0.02)])
def test_a_lump_is_found_where_it_sits_however_it_does(place, sits):
    """However wide its patch, whether it reaches over a rim, and however soft the seat is."""
    width, over_foot, give = sits
    counts, size = STOCKY
    surface = box_surface(size)
    model = hold(
        assemble(block(counts, size, jitter=0.2), Material(1000.0, 0.45)),
        surface,
        surface.vertices[:, 0] < 1e-9,
    )
    modes = solve_modes(model, 16)
    case = SimpleNamespace(surface=surface, takes=[SimpleNamespace(gravity=None)])
    corners = np.random.default_rng(7).choice(len(model.points), 12, replace=False)
    one = SimpleNamespace(
        model=model, modes=modes, case=case, bare=model,
        seen=lambda data, shapes=modes.shapes: shapes[corners].reshape(36, -1).T,
    )  # fmt: skip
    mass, x, young = 0.1 * model.mesh.volume * 1000.0, np.array(place), 2e4
    radius = width * lump_radius(mass)
    pitch, shapes = sprung(model, x, mass, radius, radius / give, over_foot)
    shapes = one.seen(None, shapes)
    errors = np.full(6, 0.003), np.abs(shapes).max(axis=1, keepdims=True) * np.full((6, 36), 0.02)
    measured = Measured(pitch * np.sqrt(young), errors[0], shapes, errors[1])
    values = (2 * np.pi * modes.frequency) ** 2
    base = compare(measured, values, one.seen(None))
    ground = SimpleNamespace(
        body=one,
        data=None,
        measured=measured,
        base=base,
        shrink=np.ones(16),
        pull=None,
        shifts=(),
        shifted=0,
    )
    first = modes.shapes.reshape(-1, 16)
    families = added_mass.families(one, lambda m, n: improved(m, first[:, :n]))
    found = _fit(added_mass.EFFECT, families, ground)
    known = sits[0] == 1.0  # how it sits is among what is looked for
    assert found.told["mass"] == pytest.approx(mass, rel=0.08 if known else 0.13)
    masses = [told["mass"] for _, told, _ in found.near]
    assert min(masses) < 1.03 * mass and max(masses) > 0.97 * mass
    off = np.linalg.norm(found.told["position"] - x) / lump_radius(mass)
    assert off < (0.2 if known else 0.3)
    assert found.hypothesis.modulus == pytest.approx(young, rel=0.02)


def test_a_solve_begun_near_the_modes_ends_nearer(body):
    shapes = body.modes.shapes.reshape(-1, 16)[:, :8]
    changed = poisson_ratio.change_model(body.model, (0.48,))
    whole = solve_modes(changed, 4).frequency
    off = []
    for basis in (shapes, improved(changed, shapes)):
        K, M = (basis.T @ (m @ basis) for m in (changed.stiffness, changed.mass))
        told = np.sqrt(eigh(K, M, eigvals_only=True)[:4]) / (2 * np.pi)
        off.append(np.abs(told / whole - 1).max())
    assert off[1] < 1e-3 < off[0]


@pytest.mark.parametrize(
    ("longer", "doubted"), [(1.1, False), (0.9, False), (1.2, True), (0.8, True)]
)
def test_a_sag_that_does_not_fit_the_pitches_is_doubted_however_well_these_fit(longer, doubted):
    pitch, young = np.array([5.0, 7.0, 31.0, 44.0]), 2e5
    shapes, unit = np.eye(4), np.array([1.0, -2.0, 0.5, 0.0])
    measured = Measured(
        pitch, np.full(4, 0.006), shapes, np.full((4, 4), 0.02), sag=unit / young * longer
    )
    body = compare(measured, (2 * np.pi * pitch) ** 2 / young, shapes, unit)
    assert (chance_of(body, measured) < DOUBT) == doubted


def test_two_modes_may_turn_into_one_another_by_how_near_they_lie():
    rng = np.random.default_rng(3)
    shapes = np.linalg.qr(rng.standard_normal((12, 3)))[0].T
    cost = []
    for gap in (0.005, 0.027, 0.09, 0.2):
        pitch = np.array([3.0, 7.0, 7.0 * (1 + gap)])
        seen = np.stack([shapes[0], shapes[1] + 0.8 * shapes[2]])
        measured = Measured(pitch[:2], np.full(2, 0.003), seen, np.full(seen.shape, 0.02))
        cost.append(compare(measured, (2 * np.pi * pitch) ** 2, shapes).chi2)
    assert cost[0] < 1e-6 and cost[1] < 10
    assert 10 * cost[1] < cost[2] < cost[3] and cost[3] > 300


@pytest.mark.parametrize(("noise", "mode"), [(0.05, 1), (3.0, 2)], ids=["clear", "mere noise"])
def test_a_shape_tells_a_mode_by_what_of_it_is_no_noise(noise, mode):
    """The second pitch is that of mode 2, and what is seen of its shape goes as mode 1."""
    shapes = np.linalg.qr(np.random.default_rng(5).standard_normal((12, 3)))[0].T
    pitch, error = np.array([3.0, 7.0, 9.0]), np.array([[0.02], [noise * 12**-0.5]])
    measured = Measured(
        pitch[[0, 2]], np.full(2, 0.003), shapes[:2], np.broadcast_to(error, (2, 12))
    )
    assert compare(measured, (2 * np.pi * pitch) ** 2, shapes).modes == (0, mode)


@pytest.mark.parametrize(("aslant", "mode"), [(0.02, 0), (0.2, 2)])
def test_a_lone_pitch_is_the_lowest_modes_unless_another_moves_clearly_more_like_it(aslant, mode):
    """One marker sees three modes go upwards, the lowest a little or much aslant."""
    shapes = np.array([[1.0, aslant], [0.0, 1.0], [0.8, 0.001]])
    measured = Measured(
        np.array([5.0]), np.full(1, 0.003), np.array([[1.0, 0.0]]), np.full((1, 2), 0.02)
    )
    assert compare(measured, np.array([1.0, 9.0, 30.0]), shapes).modes == (mode,)


def test_a_faint_mode_far_off_its_pitch_moves_nothing():
    """What moves as the last one does, and lies where none is, may be the fold of a higher one."""
    shapes = np.linalg.qr(np.random.default_rng(7).standard_normal((12, 4)))[0].T
    own, error = np.array([3.0, 7.0, 9.0, 15.0]), 0.003
    values = (2 * np.pi * own) ** 2
    heard = Measured(
        own * np.array([1.0, 1.002, 0.999, 0.8]), np.full(4, error), shapes, np.full((4, 12), 0.02)
    )
    without = Measured(heard.frequency[:3], heard.error[:3], shapes[:3], np.full((3, 12), 0.02))
    true = compare(without, values, shapes)
    loud, faint = compare(heard, values, shapes), compare(replace(heard, faint=1), values, shapes)
    assert faint.modulus == pytest.approx(true.modulus, rel=1e-9)
    assert faint.chi2 == pytest.approx(true.chi2 + STRANGE)
    assert loud.chi2 > 1000 and abs(loud.modulus / true.modulus - 1) > 0.05
    both = replace(heard, faint=2, frequency=own * np.array([1.0, 1.002, 0.9, 0.8]))
    assert chance_of(compare(both, values, shapes), both) < DOUBT  # but two of them are no chance
    near = replace(heard, faint=1, frequency=own * np.array([1.0, 1.002, 0.999, 1.004]))
    assert compare(near, values, shapes).chi2 == pytest.approx(
        compare(replace(near, faint=0), values, shapes).chi2
    )  # one that is where it was computed counts as any


@pytest.mark.parametrize(
    ("seen", "cost"),
    [((5.0, 19.0, 53.5), UNFOLDING), ((5.0, 19.0, 66.5), 0.0), ((5.0, 53.5, 66.5), None)],
    ids=["a fold", "none", "another mode's"],
)
def test_a_pitch_is_read_as_it_was_seen_or_as_what_folds_to_it(seen, cost):
    """Modes at 5, 19 and 66.5 Hz, filmed with 120 frames/s."""
    shapes = np.linalg.qr(np.random.default_rng(8).standard_normal((12, 3)))[0].T
    values, error = (2 * np.pi * np.array([5.0, 19.0, 66.5])) ** 2, np.full(3, 0.003)
    folds = folds_of(np.array(seen), np.full(3, 1e-3), 120.0, (0,))
    heard = Measured(np.array(seen), error, shapes, np.full((3, 12), 0.02), folds=folds)
    found = compare(heard, values, shapes)
    if cost is None:  # near neither: a mode at 53.5 Hz or 66.5 Hz moves as the second one does
        assert found.chi2 > 1000
        return
    assert found.chi2 == pytest.approx(cost, abs=0.01)
    assert found.pitch_chi2 == pytest.approx(found.chi2, abs=0.01)  # by which a body is judged
    assert found.modulus == pytest.approx(1.0, rel=1e-4)
    assert found.read == pytest.approx([5.0, 19.0, 66.5], rel=1e-4)


def test_what_may_be_a_fold_costs_a_body_nothing_that_has_the_pitch_as_seen():
    """Of two modes that a camera sees nearly alike, one lies where the other one would fold."""
    values, rng = (2 * np.pi * np.array([5.0, 53.5, 66.5])) ** 2, np.random.default_rng(9)
    for _ in range(40):
        first, second, other = np.linalg.qr(rng.standard_normal((6, 3)))[0].T
        shapes = np.stack([first, second, second + 0.2 * other])
        seen = np.stack([first, second + 0.1 * other])
        heard = Measured(
            np.array([5.0, 53.5]),
            np.full(2, 0.003),
            seen,
            np.full((2, 6), 0.02),
            folds=((1, 66.5),),
        )
        plain = compare(replace(heard, folds=()), values, shapes)
        assert compare(heard, values, shapes).chi2 <= plain.chi2 + 1e-9


def test_what_may_be_a_fold_lies_near_half_the_frame_rate_and_dies_as_a_mode():
    seen, known = np.array([3.0, 55.0, 53.5, 30.0, 66.5, 130.0, 250.0]), (0, 1)
    z = np.array([0.02, 0.02, 0.02, 0.02, 1e-4, 0.02, 0.02])
    ((k, other),) = folds_of(seen, z, 120.0, known)
    decay, damped = (z * seen)[2], seen[2] * np.sqrt(1 - z[2] ** 2)
    assert k == 2 and other == pytest.approx(np.hypot(120 - damped, decay), rel=1e-12)


def test_what_parts_one_pair_of_a_body_parts_its_other_pairs():
    """A bar that is stiffer one way: both bending pairs lie 8 % apart, the twist where it was."""
    shapes = np.linalg.qr(np.random.default_rng(6).standard_normal((12, 4)))[0].T
    own = np.array([7.2, 28.8, 37.5, 37.5])
    pitch = own * np.array([1.0, 1.0, 0.96, 1.04])  # of the first pair the middle was taken
    measured = Measured(pitch, np.full(4, 0.003), shapes, np.full((4, 12), 0.02))
    values = (2 * np.pi * own) ** 2
    doubted = compare(measured, values, shapes)
    told = compare(parted(measured, doubted.modes, own, (0, 0.04)), values, shapes)
    assert chance_of(doubted, measured) < 1e-6 and chance_of(told, measured) > 0.05
    other = replace(measured, frequency=own * np.array([1.0, 1.04, 1.0, 1.0]))
    twisted = compare(parted(other, doubted.modes, own, (0, 0.04)), values, shapes)
    assert chance_of(twisted, other) < 1e-6  # which no pair explains


@pytest.mark.parametrize(("pitch", "ratio", "can_be"), [
    (40.0, 0.02, True),  # as the others
    (40.0, 0.14, True),  # steeper than its pitch, a little
    (40.0, 0.2, False),
    (400.0, 0.3, False),  # nothing that dies at once
    (40.0, 0.004, False),
])  # fmt: skip
def test_a_further_mode_is_damped_as_the_others_or_as_its_pitch_is_higher(pitch, ratio, can_be):
    assert damps_alike(pitch, ratio, np.array([8.0, 16.0]), np.array([0.02, 0.04])) == can_be
