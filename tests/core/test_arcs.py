"""Markers on arcs, against a slender cantilever's closed form: it bends and keeps its length."""

from types import SimpleNamespace

import numpy as np
import pytest

from core.arcs import _shows, aside_of
from core.data import Material
from core.elasticity import assemble, hold_points
from core.modes import solve_modes
from core.pipeline import calibrate_case
from tests.core.solids import block, box_surface

LONG, WIDE, THICK = 0.1, 0.015, 0.01
ROOT = 1.8751040687  # of cos x cosh x = -1: the first mode of a clamped and free bar
X = np.linspace(0, LONG, 2001)


def curve(x, degree=0):
    """The first mode of a cantilever (Rayleigh, The Theory of Sound, vol. 1, 173), one at its tip;
    or its slope.
    """
    k = ROOT / LONG
    ratio = (np.cosh(ROOT) + np.cos(ROOT)) / (np.sinh(ROOT) + np.sin(ROOT))

    def shape(z):
        return np.cosh(z) - np.cos(z) - ratio * (np.sinh(z) - np.sin(z))

    def slope(z):
        return k * (np.sinh(z) + np.sin(z) - ratio * (np.cosh(z) - np.cos(z)))

    return (slope if degree else shape)(k * np.asarray(x)) / shape(ROOT)


def shortening(x):
    """1/m: how far a place (n,) m of the bar comes nearer to its root, per swing of a metre squared
    at the tip: half of the slope squared, summed up to there.
    """
    slope = curve(X, 1) ** 2 / 2
    sums = np.r_[0, np.cumsum((slope[1:] + slope[:-1]) / 2 * np.diff(X))]
    return np.interp(x, X, sums)


@pytest.fixture(scope="module")
def bar():
    """A slender bar that is held at its foot."""
    model = assemble(block((24, 4, 3), (LONG, WIDE, THICK)), Material(1000.0, 0.3), "p2")
    model = hold_points(model, np.flatnonzero(model.points[:, 0] < 1e-9))
    return SimpleNamespace(model=model, modes=solve_modes(model, 6))


def test_a_cantilevers_tip_comes_nearer_its_root_by_the_slope_squared(bar):
    model, modes = bar.model, bar.modes
    off = abs(model.points[:, 1:] - [WIDE / 2, THICK / 2])
    middle = (off < [1e-9, THICK / 5]).all(axis=1)
    pairs, aside = aside_of(bar, modes.shapes[:, :, :1], modes.frequency[:1])
    assert pairs == ((0, 0),)
    x, size = model.points[middle, 0], np.abs(modes.shapes[:, :, 0]).max()
    assert aside[middle, 0, 0] == pytest.approx(
        -(size**2) * shortening(x), abs=0.03 * size**2 * shortening(LONG)
    )


def test_the_products_of_two_modes_are_those_of_their_sum(bar):
    """f(a + b, a + b) = f(a, a) + 2 f(a, b) + f(b, b), by what any one mixture of both does."""
    shapes, pitch = bar.modes.shapes, bar.modes.frequency
    pairs, aside = aside_of(bar, shapes[:, :, :2], pitch[:2])
    assert pairs == ((0, 0), (0, 1), (1, 1))
    _, one = aside_of(bar, shapes[:, :, :2] @ np.array([[0.6], [-0.8]]), pitch[:1])
    both = aside @ np.array([0.6**2, -0.6 * 0.8, 0.8**2])
    assert one[:, 0, 0] == pytest.approx(both[:, 0], abs=1e-4 * np.abs(both).max())


def test_what_follows_a_swing_late_is_no_arc(bar):
    """Bent both ways a bar twists: at once, while its torsion lies far above the two."""
    model, modes = bar.model, bar.modes
    pairs, aside = aside_of(bar, modes.shapes[:, :, :3], modes.frequency[:3])
    own = modes.shapes.reshape(-1, len(modes.frequency)).T
    slow, fast = pairs.index((0, 1)), pairs.index((1, 2))
    along = np.abs(own @ (model.mass @ aside.reshape(-1, len(pairs))))
    torsion = along[:, slow].argmax()
    mean = [modes.frequency[[j, k]].mean() for j, k in pairs]
    assert 3 * mean[slow] < modes.frequency[torsion] < 3 * mean[fast]
    assert along[torsion, fast] < 1e-6 * along[torsion, slow]


@pytest.mark.parametrize(("loud", "shown"), [(0.0, True), (2.0, True), (20.0, False)])
def test_arcs_show_where_they_are_a_part_of_what_is_left(loud, shown):
    """One that drowns in what else acts across the modes agrees with that by chance."""
    time, across = np.arange(4000) / 100, np.linalg.qr(np.eye(6) + 0.3)[0]
    arcs = 3 * np.outer(np.cos(4 * time) ** 2, across[1])
    data = SimpleNamespace(
        support=np.zeros(6, bool), known=np.ones((4000, 6), bool), sigma=np.ones(6),
        fit=np.ones(4000, bool),
    )  # fmt: skip
    noise = np.random.default_rng(3).standard_normal((4000, 6))
    left = arcs + loud * 3 * np.outer(np.cos(5.3 * time) ** 2, across[2]) + noise
    free = SimpleNamespace(
        law=SimpleNamespace(takes=(data,), fitted=(0,)),
        shapes_of=lambda n: across[:1], missed=lambda n: left,
    )  # fmt: skip
    assert _shows([arcs], free) == shown


def filmed(folder, arcs, size=0.012):
    """A case: the bar let go `size` m from rest, its markers going aside by so many times what the
    closed form says.
    """
    rng = np.random.default_rng(5)
    box = box_surface((LONG, WIDE, THICK))
    lines = ["v {} {} {}".format(*place) for place in box.vertices]
    lines += ["f {} {} {}".format(*(face + 1)) for face in box.faces]
    (folder / "bar.obj").write_text("\n".join(lines))
    time, w, z = np.arange(480) / 120, 2 * np.pi * 4.0, 0.015
    u = size * np.exp(-z * w * time) * np.cos(w * np.sqrt(1 - z**2) * time)
    places = [(x, y, h) for x in (0.05, 0.075, 0.1) for y, h in ((0.0, THICK), (WIDE, 0.0))]
    columns, text = [], ""
    for n, (x, y, h) in enumerate(places):
        above = h - THICK / 2
        along = -above * curve(x, 1) * u - arcs * shortening(x) * u**2
        up = curve(x) * u - arcs * above * curve(x, 1) ** 2 / 2 * u**2
        columns += [x + along, np.full(len(time), y), h + up]
        text += f'[[marker]]\nname = "m{n}"\nposition = [{x}, {y}, {h}]\n'
    values = np.transpose(columns) + 1e-5 * rng.standard_normal((len(time), len(columns)))
    values[rng.random(values.shape) < 0.02] = np.nan
    head = "time," + ",".join(f"m{n}.{a}" for n in range(len(places)) for a in "xyz")
    rows = [
        ",".join("" if np.isnan(v) else f"{v:.9g}" for v in (t, *row))
        for t, row in zip(time, values, strict=True)
    ]
    (folder / "tracks.csv").write_text("\n".join([head, *rows]))
    (folder / "case.toml").write_text(
        'name = "bar"\n[object]\nmesh = "bar.obj"\nlength_unit = "m"\ndensity = 1000.0\n'
        "poisson_ratio = 0.1\n[[pin]]\nbox = { min = [-0.001, -1, -1], max = [0.001, 1, 1] }\n"
        '[model]\ndeclared = ["viscous_damping"]\n[recording]\ntracks = "tracks.csv"\n' + text
    )
    return folder / "case.toml"


def told(report):
    return [line for line in report["warnings"] if "arcs" in line]


def test_a_bar_that_swings_far_is_adequate_and_its_arcs_are_told(tmp_path):
    """Taken for forces, they are another stiffness one way than the other."""
    result = calibrate_case(filmed(tmp_path, 1.0), elements=600)
    report = result.report
    assert report["diagnosis"]["verdict"] == "adequate"
    assert len(told(report)) == 1
    at_tip = result.case.surface.vertices[:, 0] > 0.99 * LONG
    along, _, up = np.tensordot(
        result.motion.shapes[at_tip].mean(axis=0), result.motion.weights, (1, 1)
    )
    arc = shortening(LONG) * up**2
    assert -along == pytest.approx(arc, abs=0.06 * arc.max())
    line = 1000.0 * WIDE * THICK * (2 * np.pi * 4.0) ** 2 * LONG**4 / ROOT**4
    young = line / (WIDE * THICK**3 / 12)
    assert report["youngs_modulus"]["material"]["value"] == pytest.approx(young, rel=0.03)
    assert report["error"]["after"] < 1.1 * report["error"]["floor"]


@pytest.mark.slow
@pytest.mark.parametrize("arcs", [0.0, -1.0, 2.5])
def test_arcs_that_are_not_the_bodys_are_left_in_what_was_filmed(tmp_path, arcs):
    report = calibrate_case(filmed(tmp_path, arcs), elements=600).report
    assert not told(report)
    assert (report["diagnosis"]["verdict"] == "adequate") == (arcs == 0.0)


@pytest.mark.slow
def test_an_element_without_a_nonlinear_form_knows_of_no_arcs(tmp_path):
    report = calibrate_case(filmed(tmp_path, 1.0), elements=300, element="p2_mixed").report
    assert not told(report) and report["diagnosis"]["verdict"] != "adequate"
