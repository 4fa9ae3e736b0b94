"""A further mode that was heard off its pitch, beside one mode that is known."""

from dataclasses import make_dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from core.all_told import Told, _mimics, cleared, foretells, modes_of, tells_all
from core.data import poles
from core.effects import large_amplitude, lost_frames, stiffness_drift
from core.effects.further_mode import further_mode, is_further, pitch_of
from core.further import _bases, _clear, _poles, _staying, with_modes_of
from core.harmonic_inversion import fit_poles, invert
from core.law import replace
from core.linear_part import fitted_instants
from core.match import mac
from core.ready import widened
from core.refit import LESS, lighter
from core.residual import errors, noise_share
from core.shutter import overtone
from core.time_layer import judge
from core.timefit import extend, fit
from tests.core.test_simulate import AMPLITUDE
from tests.core.test_timefit import (
    NOISE,
    SHAPE,
    TIME,
    Backbone,
    W,
    channels,
    declared,
    moved,
    raced,
)

FIRST = W / (2 * np.pi)  # Hz
OTHER = np.array([0.3, -0.5, 0.8, 0.6])  # how the markers show the further mode


def ringing(times, zeta=0.03):
    """(T,) a swing `times` as high as the known mode."""
    w = times * W
    return np.exp(-zeta * w * TIME) * np.cos(w * np.sqrt(1 - zeta**2) * TIME + 0.7)


def sounding(times, zeta=0.03):
    """The known mode with a further one `times` as high, found without the latter."""
    wave = ringing(times, zeta)
    return declared(channels(moved() + 0.3 * AMPLITUDE * np.outer(wave, OTHER)))


@pytest.mark.parametrize("heard", [2.5, 2.64, 2.36])
def test_a_mode_is_found_where_it_is_though_it_was_heard_beside(heard):
    found, count = _staying(sounding(2.5), [further_mode(heard * FIRST, 0.03)], 0)
    assert count == 1
    pitch = pitch_of(found.law.effects[0], found.theta[0][0])
    assert pitch == pytest.approx(2.5 * FIRST, rel=2e-3)
    assert found.chi2 < 1.1 * found.samples


def test_faint_modes_beside_an_effect_are_heard_in_what_the_take_would_show_without_it():
    values = moved(Backbone(0.05, 0.0))
    for times, shape in ((2.2, OTHER), (2.6, OTHER[::-1])):
        values = values + 0.03 * AMPLITUDE * np.outer(ringing(times), shape)
    without = declared(channels(values))
    found = raced(without, large_amplitude.EFFECT)
    told = cleared(found, 0)
    assert np.sort(told.ring.frequency) / FIRST == pytest.approx([1, 2.2, 2.6], rel=0.01)
    assert told.ring.frequency[list(told.at)] == pytest.approx(found.frequency, rel=1e-3)
    left = told.values - cleared(without, 0).values
    assert np.abs(left).max() > 5 * NOISE  # the backbone, that is taken away


def beside(values, *further, late=None):
    """The values (T, C) with further modes (times, size, shape), seen `late` (T, C) s."""
    when = TIME[:, None] + (np.zeros(values.shape) if late is None else late)
    for times, size, shape in further:
        w, z = times * W, 0.03
        wave = np.exp(-z * w * when) * np.cos(w * np.sqrt(1 - z**2) * when + 0.7)
        values = values + size * AMPLITUDE * wave * shape
    return values


def test_what_frames_that_were_lost_made_of_a_take_is_undone_before_it_is_heard():
    lost, keep = 3, len(TIME) - 3
    whole = beside(moved(), (2.2, 0.3, OTHER), (2.6, 0.3, OTHER[::-1]))
    values = np.vstack([whole[:30], whole[30 + lost :]])
    start = declared(channels(values, time=TIME[:keep]))
    takes = start.law.takes
    jumps = (((takes[0].time[30] - 1e-6, lost * takes[0].frame),),)
    effect = lost_frames.lost(jumps, takes)
    law, p = extend(start, (effect,), [()])
    found = fit(law, p, evaluations=20)
    told = cleared(found, 0)
    assert np.sort(told.ring.frequency) / FIRST == pytest.approx([1, 2.2, 2.6], rel=0.01)
    assert tells_all(found, 0, told)
    assert not tells_all(found, 0, replace(told, time=takes[0].time))


def test_rows_that_are_late_are_no_misfit_of_what_is_heard():
    """Linear motion, seen by a rolling shutter that is known."""
    readout, rows = 0.02, np.tile([0.1, 0.3, 0.6, 0.9], (len(TIME), 1))
    first = np.sqrt(1 - 0.02**2) * W
    when = TIME[:, None] + readout * rows
    values = AMPLITUDE * SHAPE * np.exp(-0.02 * W * when) * np.cos(first * when)
    values = values + NOISE * np.random.default_rng(3).standard_normal(values.shape)
    data = channels(beside(values, (2.2, 0.1, OTHER), late=readout * rows))
    data.take.recording.camera = SimpleNamespace(readout=readout)
    found = declared(replace(data, rows=rows))
    told = cleared(found, 0)
    assert np.sort(told.ring.frequency) / FIRST == pytest.approx([1, 2.2], rel=0.01)
    assert tells_all(found, 0, told)


@pytest.mark.parametrize(
    ("creep", "turned", "told"),
    [(0.0, False, True), (0.14, False, True), (0.5, False, False), (0.14, True, False)],
    ids=["nothing else", "a small effect", "a large one", "what comes is another motion"],
)
def test_poles_beside_a_small_effect_are_modes_where_they_foretell(creep, turned, told):
    """Two modes that nobody matched, as loud as the first, and a mean that creeps."""
    values = beside(moved(), (0.5, 1.0, OTHER), (0.7, 1.0, OTHER[::-1]))
    values = values + creep * AMPLITUDE * np.outer(np.exp(-2 * TIME), SHAPE)
    use = channels(values).fit
    values[~use] *= -1 if turned else 1
    found = declared(channels(values))
    data, pitches = found.law.takes[0], found.frequency[0] * np.array([1.0, 0.5, 0.7])
    ring = fit_poles(TIME[use], values[use], pitches, np.full(3, 0.02), noise=data.sigma)
    both = Told(ring, data.time, data.values, (0,))
    assert found.chi2 > 500 * found.samples
    assert foretells(found, 0, both) is told
    assert tells_all(found, 0, both) is (creep == 0)


def test_where_a_mode_is_not_heard_nothing_is_told():
    assert cleared(declared(channels(moved())), 0) is not None
    still = NOISE * np.random.default_rng(0).standard_normal((len(TIME), 4))
    assert cleared(declared(channels(still)), 0) is None


@pytest.mark.parametrize(
    ("heard", "own", "shown"),
    [
        (5.6, True, False),  # of the pair that is left to what parts it
        (11.2, True, True),  # of another pair
        (23.0, True, True),  # beside a mode that is none of a pair, in another way
        (23.0, False, False),  # in the same way
    ],
)
def test_of_two_pairs_the_one_that_is_parted_is_left_to_what_parts_it(heard, own, shown):
    """Modes at 5, 11 and 22.6 Hz are matched; those at 5 and 11 Hz are computed twice."""
    rng = np.random.default_rng(6)
    pitches, shapes = np.array([5.0, 11.0, 22.6]), rng.standard_normal((4, 12))
    if not own:
        shapes[3] = shapes[2] + 0.3 * shapes[3]
    ring = SimpleNamespace(
        frequency=np.r_[pitches, heard],
        damping_ratio=np.full(4, 0.02),
        amplitude=shapes.astype(complex),
    )
    setting = SimpleNamespace(paired=True, pair=0)
    data = seen_by(None)
    law = SimpleNamespace(takes=(data,), fitted=[0], pitch=(0,), setting=setting, effects=())
    found = SimpleNamespace(
        law=law,
        theta=[],
        pitches=lambda take: pitches,
        damping_ratio=np.full(3, 0.02),
        shapes_of=lambda take: shapes[:3],
    )
    computed = np.array([5.0, 5.001, 11.0, 11.002, 22.6, 40.0])
    body = SimpleNamespace(modes=SimpleNamespace(frequency=computed))
    match = SimpleNamespace(modes=(0, 2, 4))
    assert modes_of(found, 0, match, body, ring) == ([(heard, 0.02)] if shown else [])


def seen_by(camera):
    """A take of six markers in a picture, or of twelve along one axis."""
    recording = SimpleNamespace(camera=camera)
    take = SimpleNamespace(loads=(), recording=recording)
    return SimpleNamespace(support=np.zeros(12, bool), take=take, frame=0.01)


def rolling(readout):
    return SimpleNamespace(readout=readout, image_size=(1280, 720))


@pytest.mark.parametrize(
    ("camera", "late", "size", "shown"),
    [
        (rolling(None), True, 0.9, False),
        (rolling(0.01), True, 0.9, True),  # that is taken out
        (None, True, 0.9, True),  # no rows
        (rolling(None), False, 0.9, True),  # another motion
        (rolling(None), True, 3.0, True),  # no readout makes so much
    ],
)
def test_what_late_rows_sound_like_at_twice_a_pitch_is_no_mode(camera, late, size, shown):
    rng = np.random.default_rng(6)
    first, other = 40 * (rng.standard_normal((2, 12)) + 1j * rng.standard_normal((2, 12)))
    made = overtone(first, complex(poles(5.0, 0.02)), 0.01 / 720)
    double = size * made if late else other * np.linalg.norm(made) / np.linalg.norm(other)
    ring = SimpleNamespace(
        frequency=np.array([5.0, 17.0, 10.1, 26.0]),
        damping_ratio=np.full(4, 0.02),
        amplitude=np.array([first, rng.standard_normal(12), double, rng.standard_normal(12)]),
    )
    law = SimpleNamespace(
        takes=(seen_by(camera),),
        fitted=[0],
        pitch=(0,),
        setting=SimpleNamespace(paired=False, pair=0),
        effects=(),
    )
    found = SimpleNamespace(
        law=law,
        theta=[],
        pitches=lambda take: ring.frequency[:2],
        damping_ratio=np.full(2, 0.02),
        shapes_of=lambda take: ring.amplitude[:2].real,
    )
    body = SimpleNamespace(modes=SimpleNamespace(frequency=np.array([5.0, 17.0, 30.0])))
    told = modes_of(found, 0, SimpleNamespace(modes=(0, 1)), body, ring)
    assert told == [*([(10.1, 0.02)] if shown else []), (26.0, 0.02)]


@pytest.mark.parametrize(("faintest", "count"), [(0.0, 2), (5e-3, 1)])
def test_a_faint_mode_is_named_where_all_are_asked_for(faintest, count):
    still = 0.1 * NOISE * np.random.default_rng(0).standard_normal((len(TIME), 4))
    values = beside(still, (1.0, 1.0, SHAPE), (2.2, 0.004, OTHER))
    ring = invert(TIME, values, noise=np.full(4, 0.1 * NOISE), faintest=faintest)
    assert len(ring.frequency) == count


def test_what_turns_out_an_overtone_is_no_mode():
    bare = sounding(2.0)
    found, count = _staying(bare, [further_mode(2.15 * FIRST, 0.03)], 0)
    assert count == 0
    assert found is bare


def test_the_damping_of_a_mode_that_is_heard_anew_keeps_its_bound():
    found, count = _staying(sounding(2.38, 0.075), [further_mode(2.6 * FIRST, 0.02)], 0)
    assert count == 0


def test_time_that_stands_still_is_left_out_of_what_is_heard():
    found = declared(channels(moved()))
    (data,) = found.law.takes
    jumps = (((data.time[20] - 1e-6, -2 * data.frame),),)  # frames doubled
    law = replace(found.law, effects=(lost_frames.lost(jumps, found.law.takes),))
    time, use = fitted_instants(law, [np.zeros((1, 0))], data)
    assert (np.diff(time) > 0).all() and data.fit.sum() - use.sum() == 2
    assert not use[20:22].any()


def test_a_take_of_its_own_condition_has_its_own_shapes():
    one, other = channels(moved()), channels(moved(shape=SHAPE[::-1]))
    found = declared(one, other, condition=(0, 1))
    for take, shape in enumerate((SHAPE, SHAPE[::-1])):
        own = found.shapes_of(take)[0]
        assert mac(own, shape) > 0.999
    assert np.array_equal(found.shapes_of(0), found.shapes)


def test_damping_that_may_be_something_elses_is_less():
    found = declared(channels(moved(zeta=0.06)))
    less = lighter(found)
    assert less.damping_ratio[0] == pytest.approx(found.damping_ratio[0] / LESS)
    assert less.frequency == found.frequency and less.chi2 > found.chi2


def test_a_motion_in_the_span_of_a_loud_pair_is_none_of_its_own():
    """A softening bends a pair as one: what it makes is like neither partner, and both."""
    rng = np.random.default_rng(4)
    known = rng.standard_normal((3, 12))
    pair = known[0] - known[1]
    for shape, f, partner, alike in [
        (pair, 5.6, 5.2, True),
        (pair, 9.0, 5.2, False),  # the partner is too far from it
        (pair, 5.6, 6.0, False),  # no pair: each bends by itself
        (known[0], 5.9, 5.2, True),
        (known[0], 10.1, 5.2, True),  # where it has an overtone
        (known[0], 9.0, 5.2, False),
        (known[2], 5.6, 5.2, False),
        (pair + 2 * rng.standard_normal(12), 5.6, 5.2, False),
    ]:
        assert _mimics(shape, f, known, np.array([5.0, partner, 11.0]), 100.0) is alike
    # four times its pitch, folded at 28 frames/s
    assert _mimics(known[0], 8.0, known, np.array([5.0, 5.2, 11.0]), 28.0)


def test_a_mode_that_one_take_shows_is_foretold_of_another_as_it_moves_there():
    """The first take hardly stirs it, so its columns there are noise and say no shape."""
    ringing_alone = 0.3 * AMPLITUDE * np.outer(ringing(2.5), OTHER)
    takes = [channels(moved() + size * ringing_alone) for size in (0.0, 1.0, -2.0)]
    kind = make_dataclass("Held", ["recording", "held_out", "name"])
    last = kind(takes[-1].take.recording, True, "last")
    takes[-1] = replace(takes[-1], take=last, fit=TIME <= 0.4)
    found = declared(*takes, condition=(0, 0, 0))
    law, p = extend(found, (further_mode(2.5 * FIRST, 0.03),), [(0.0, 0.03)], 0)
    found = fit(law, p, evaluations=20)
    assert errors(found).held_out < 1.2 * noise_share(found.law.takes, True)


@pytest.mark.parametrize("turned", [0.0, 0.4, 0.8, 1.2])
def test_a_mode_is_one_direction_of_a_pair_however_the_mesh_turned_that(turned):
    """It rings where an overtone would lie, so its shape must be a computed one's beyond doubt."""
    found = sounding(2.0)
    rng = np.random.default_rng(8)
    both, _ = np.linalg.qr(np.column_stack([OTHER, rng.standard_normal(4)]))
    turn = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    pair = turn @ both.T
    computed = np.array([FIRST, 2 * FIRST, 2.001 * FIRST, 9 * FIRST])
    seen = np.vstack([SHAPE, pair, rng.standard_normal(4)])
    body = SimpleNamespace(modes=SimpleNamespace(frequency=computed), seen=lambda data: seen)
    ((pitch, _),) = _poles(found, 0, SimpleNamespace(modes=(0,)), body)
    assert pitch == pytest.approx(2 * FIRST, rel=0.01)
    apart = SimpleNamespace(
        modes=SimpleNamespace(frequency=computed * [1, 1, 1.2, 1]), seen=lambda data: seen
    )
    alone = len(_poles(found, 0, SimpleNamespace(modes=(0,)), apart))
    assert alone == (turned == 0.0)


@pytest.mark.parametrize(
    ("size", "faint", "clear"), [(0.02, 0.5, False), (0.2, 0.5, True), (0.02, 0.03, True)]
)
def test_no_combination_is_louder_than_a_share_of_all_that_it_combines(size, faint, clear):
    """Of modes at 5 and 9 Hz, the latter `faint`, and a line of that size at 14 Hz."""
    rows = np.array([1.0, faint])[:, None] * AMPLITUDE * np.exp(-TIME) * np.cos(40 * TIME)
    data = channels(np.zeros((len(TIME), 4)))
    found = SimpleNamespace(
        law=SimpleNamespace(takes=(data,), fitted=(0,)),
        motions=(rows.T,),
        shapes_of=lambda take: np.vstack([SHAPE, SHAPE]),
        pitches=lambda take: np.array([5.0, 9.0]),
    )
    line = 14.05, 0.02, size * AMPLITUDE * SHAPE
    bases = _bases(found, 0, line, np.ones(4, bool))
    assert _clear(14.05, [5.0, 9.0], False, bases) is clear
    assert _clear(14.05, [5.0, 9.0], True, bases)


@pytest.mark.parametrize("there", [True, False])
def test_what_one_fit_laid_bare_is_tried_in_another_one(there):
    """At the bound of its pitch in the one, and just as well there in the other, if it is there."""
    plain = sounding(2.5) if there else declared(channels(moved()))
    law, p = extend(sounding(2.5), (further_mode(2.64 * FIRST, 0.03),), [(0.0, 0.03)])
    other = fit(law, p, evaluations=20)
    before = raced(plain, large_amplitude.EFFECT)
    wider = with_modes_of(before, other, 1)
    if not there:
        assert wider is before
        return
    mode, effect = wider.law.effects
    assert is_further(mode) and effect.name == "large_amplitude"
    assert pitch_of(mode, wider.theta[0][0]) == pytest.approx(2.5 * FIRST, rel=2e-3)
    assert wider.chi2 < 1.1 * wider.samples < before.chi2


def test_no_mode_that_is_known_is_tried_again():
    """However much another one, which neither fit knows, leaves."""
    values = moved() + 0.2 * AMPLITUDE * np.outer(ringing(2.5), OTHER)
    start = declared(channels(values + 0.2 * AMPLITUDE * np.outer(ringing(3.7), OTHER[::-1])))
    first, second = (
        fit(*extend(start, (further_mode(times * FIRST, 0.03),), [(0.0, 0.03)]), evaluations=20)
        for times in (2.5, 2.51)
    )
    assert first.chi2 > 2 * first.samples
    assert with_modes_of(first, second, 0) is first


def test_effects_that_vie_are_compared_with_all_modes_that_any_of_them_laid_bare():
    """Each hears another mode of the body, and neither the other's."""
    values = moved(Backbone(0.05, 0.0))
    for times, shape in ((2.2, OTHER), (2.6, OTHER[::-1])):
        values = values + 0.1 * AMPLITUDE * np.outer(ringing(times), shape)
    start = declared(channels(values))
    heard = {"large_amplitude": 2.2, "stiffness_drift": 2.6}
    found = [raced(start, effect) for effect in (large_amplitude.EFFECT, stiffness_drift.EFFECT)]
    first, second = (judge((f.law.effects[-1].name,), f, start) for f in found)

    def widen(one, effects):
        mode = further_mode(heard[one.law.effects[-1].name] * FIRST, 0.03)
        law, p = extend(one, (mode,), [(0.0, 0.03)], len(one.law.effects) - effects)
        return fit(law, p, evaluations=20)

    for c in widened([first, second], start, widen):
        modes = [
            pitch_of(e, t[0]) / FIRST
            for e, t in zip(c.found.law.effects, c.found.theta, strict=True)
            if is_further(e)
        ]
        assert sorted(modes) == pytest.approx([2.2, 2.6], rel=5e-3)
        assert c.found.law.effects[-1].name == c.names[0]
