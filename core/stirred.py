"""Modes of the body that nobody heard, and that a force which was found rings: a rub's stick, a
stop, a stiffness that grows.

Such a force drowns what was let go, so that few modes are heard by themselves. With those alone
what it does to the others stays in the residual. Their pitches, and how a place shares in them,
are known of the body; what the march of all of them foretells is what the heard ones' is beside it.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, product

import numpy as np

from .baseline import reference_weights, with_body
from .carried import carrying
from .diagnosis import sharpened
from .effects.base import FINE, Effect
from .effects.further_mode import is_further
from .effects.partner import is_of
from .foils import weakens
from .hearings import whole_ground
from .joint import Heard
from .law import Law, TimeFit
from .match import PAIR, Match
from .residual import NOISY, bic, errors, excess
from .settle import CLOSE, MUCH, STRAY, Recorded, told_elsewhere
from .sufficiency import CLEARLY, at_a_bound, bends_the_body, owes
from .time_layer import judge, vetoed
from .timefit import at_first, conclude, misfits, walked
from .unmatched import UNSEEN
from .verdict import Verdict, Whole, twins_of
from .widen import begun, placed

MORE, FEWEST = 3, 5  # modes beside those that were heard, and altogether where few were
# of the largest swing, from which those begin that were not heard: at rest a shape has no size
SILENT = 1e-3
LIGHT = 0.02  # damping ratio that they begin with at most: what rubs damps the heard ones, too
HIGHEST = 0.8  # of half the frame rate
OFTEN, MOST = 4, 3 * FINE  # steps per period of the highest of them, and of the first mode at most
NEAREST, BESIDE = 24, 4  # places that are tried, where the heard modes tell something; of several
STARTS = 24  # that are walked
ENDS = 6  # of them that are looked at: a mode that hardly swings may have gone anywhere
SHARES = (0.3, 0.6, 1.0)  # of the record
LOOKS = 20
LESS = 0.5  # of what was left beyond noise, rms, is then left at most
ASIDE = 0.5  # of a computed mode, at least, that lies across the heard ones
ITSELF = 0.5  # of what they gain, that they may gain where no force acts on them


def with_stirred(heard: Heard, verdict: Verdict) -> Verdict | None:
    """The verdict with the body's lowest modes that a found force may ring; None where it counts
    some already, where there is no such force, where all but noise is told without them, or where
    they do not leave far less.

    One effect that leaves too much without them explains all where nothing but noise is left then.
    Where it leaves less, held out too, than two that do not explain, it takes their place.
    """
    if verdict.whole:
        return None
    whole = _of_all(heard, verdict)
    if whole or verdict.verdict != "unexplained" or len(verdict.effects) - verdict.laws < 2:
        return whole
    each = (_of_all(heard, one) for one in _each_alone(verdict))
    able = [one for one in each if one and _takes_the_place(one, verdict)]
    return min(able, key=lambda one: bic(one.complete), default=None)


def _takes_the_place(one: Verdict, of: Verdict) -> bool:
    """Whether one effect with modes that nobody heard explains, and tells more than those of a
    verdict do without, held out too.
    """
    likelier = bic(one.complete) < bic(of.final)
    ahead = errors(one.complete).held_out <= errors(of.final).held_out
    return one.verdict == "explained" and likelier and ahead


def _each_alone(verdict: Verdict) -> Iterator[Verdict]:
    """The verdict with one of its effects only, for each of them that is a force."""
    known, ranked = verdict.laws, verdict.ranked[verdict.laws :]
    for name in verdict.names[known:]:
        alone = (c for c in ranked if c.names == (name,) and c.found.law.effects[-1].force)
        one = next(alone, None)
        if one is None:
            continue
        found = sharpened(one.found)
        yield replace(
            verdict,
            chain=(*verdict.chain[: known + 1], (name, found)),
            effects=(*verdict.effects[:known], judge((name,), found, verdict.damped)),
            twins=(*verdict.twins[:known], twins_of(one, ranked)),
        )


def _of_all(heard: Heard, verdict: Verdict) -> Verdict | None:
    """As `with_stirred` has it, of all that a verdict names."""
    found = verdict.final
    names = set(verdict.names[verdict.laws :])
    forces = [e for e in found.law.effects if e.force and e.name in names]
    if not forces or found.chi2 < NOISY * found.samples:
        return None
    wider = widened(heard, found)
    if wider is None:
        return None
    more, law = wider
    able = (one for one in _fitted(law, found) if _is_better(one, found, verdict.damped))
    best = next(able, None)
    return best and replace(_retold(verdict, best), whole=Whole(more, best))


def _is_better(best: TimeFit, found: TimeFit, declared: TimeFit) -> bool:
    """Whether a fit with further modes leaves far less, held out too, in this body; whether those
    are its own, or too damped to ring, as what gives where a force acts; and the force rings them.
    """
    known = found.law.modes
    if excess(best) > LESS * excess(found) or errors(best).held_out > errors(found).held_out:
        return False
    if bends_the_body(best) or vetoed(best) or at_a_bound(best, declared):
        return False
    apart = np.abs(np.log(2 * np.pi * best.frequency / best.law.setting.omega))
    heard = np.abs(np.log(best.frequency[:known] / found.frequency))
    rings = best.damping_ratio[known:] < MUCH
    if (heard > CLOSE).any() or (apart[known:][rings] > STRAY).any():
        return False
    if max(best.swings[known:]) > max(best.swings[:known]):
        return False
    gain = found.chi2 - best.chi2
    return misfits(best.law, _untouched(best, known)[None])[0] - best.chi2 > (1 - ITSELF) * gain


def _untouched(best: TimeFit, known: int) -> np.ndarray:
    """The fit's numbers with no force on the modes after the first `known`."""
    p, at = best.parameters.copy(), sum(best.law.sizes()[:2])
    for effect, theta in zip(best.law.effects, best.theta, strict=True):
        if effect.force:
            place = p[at + len(effect.low) : at + theta.shape[1]].reshape(effect.axes, -1)
            place[:, known - 1 :] = 0.0
        at += theta.shape[1]
    return p


def widened(
    heard: Heard, found: TimeFit, fewest: int = FEWEST, steps: int = MOST
) -> tuple[Heard, Law] | None:
    """What was heard, and the law of `found` without its further modes, with the body's lowest
    modes beside the heard ones, so many altogether or a few more than those, that so many `steps`
    per period of the first one can follow; None where there are none, or loads part the takes.
    """
    ground, old = whole_ground(heard), found.law
    if ground is None:
        return None
    computed, (first, *_) = heard.body.modes.frequency, heard.match.modes
    scale = found.frequency[0] / computed[first]
    frame = max(heard.takes[i].frame for i in ground.fitted)
    top = min(HIGHEST / 2 / frame / scale, steps / OFTEN * computed[first])
    new, own = _unheard(heard, old, top, fewest)
    if not new:
        return None
    turn = np.hstack([heard.turns[0], *own])
    poles, modes = heard.match.poles, heard.match.modes
    match = Match((*poles, *[poles[0]] * len(new)), (*modes, *new))
    more = replace(heard, match=match, turns=(turn, *heard.turns[1:]))
    return more, _with_modes(old, ground, turn, scale * computed[new])


def _unheard(
    heard: Heard, law: Law, top: float, fewest: int = FEWEST
) -> tuple[list[int], list[np.ndarray]]:
    """The body's lowest modes below `top`, Hz as computed, that were not heard but are seen; of
    each the combination (m, 1) of computed modes that lies across the heard ones.
    """
    body, known, turn = heard.body, heard.match.modes, heard.turns[0]
    data = heard.takes[law.fitted[0]]
    computed, new, out = body.modes.frequency, [], []
    size = np.linalg.norm(body.seen(data)[:, ~data.support], axis=1)
    count = max(law.modes + MORE, fewest)
    for j in np.flatnonzero(computed[:count] < top):
        pair = [k for k, m in enumerate(known) if abs(computed[j] / computed[m] - 1) < PAIR]
        if j in known or size[j] < UNSEEN * size.max() or _crosses(law, pair):
            continue
        own = np.eye(len(computed))[:, [j]]
        own = own - turn @ np.linalg.lstsq(turn, own, rcond=None)[0]
        if np.linalg.norm(own) > ASIDE and len(new) < count - law.modes:
            own = own / np.linalg.norm(own)
            turn, new, out = np.hstack([turn, own]), [*new, int(j)], [*out, own]
    return new, out


def _crosses(law: Law, pair: list[int]) -> bool:
    """Whether the other direction of one of the heard modes `pair` swings in the fit already."""
    return any(k in law.turning or any(is_of(e, k) for e in law.effects) for k in pair)


def _with_modes(old: Law, ground: Recorded, turn: np.ndarray, pitches: np.ndarray) -> Law:
    """The law with the last ones of the `turn` (m, K), of those `pitches` (Hz), behind its own."""
    at = ground.fitted[0]
    data, body = ground.takes[at], ground.bodies[ground.condition[at]]
    seen = turn[:, old.modes :].T @ body.seen(data)
    ways = [one[:, None] for one in seen]
    seen = np.where(data.support, 0.0, seen)
    rows = np.array([reference_weights(shape, data) for shape in seen])
    unit = seen / np.einsum("kc,kc->k", rows, seen)[:, None]
    couple = np.r_[old.setting.couple, unit @ old.reference[0]]
    none = np.zeros((len(couple), 0))
    omega = np.r_[old.setting.omega, 2 * np.pi * pitches]
    setting = replace(
        old.setting,
        omega=omega,
        zeta=np.r_[old.setting.zeta, np.full(len(pitches), LIGHT)],
        couple=couple,
        places=couple[None, 1:],
        levers=np.ones(1),
        planes=np.zeros((0, 2, len(couple) - 1)),
        skin=none,
        facing=none,
        wind=none.T,
        masses=np.ones(len(couple)),
        carried=(),
        steps=max(old.setting.steps, FINE, OFTEN * omega.max() / omega[0]),
    )
    law = replace(
        old,
        effects=tuple(e for e in old.effects if not is_further(e)),
        reference=np.vstack([old.reference, rows]),
        gauges=tuple(np.vstack([one, rows]) for one in old.gauges),
        ways=(*old.ways, *ways) if old.ways else (),
        setting=setting,
    )
    return told_elsewhere(ground, with_body(law, data, body, turn), turn)


def _fitted(law: Law, found: TimeFit) -> Iterator[TimeFit]:
    """The best fits of the wider law, best first, from what may be of `found` with it; then those
    from where its further modes are as the body has them.
    """
    K, omega = found.law.modes, law.setting.omega
    pairs = zip(found.law.effects, found.theta, strict=True)
    own = [(e, t[0]) for e, t in pairs if not is_further(e)]
    few = None if sum(bool(e.force) for e, _ in own) < 2 else BESIDE  # all choices of two are many
    inner = [list(islice(_begins(e, t, K, law), few)) for e, t in own]
    outer = begun(
        found,
        np.log(omega[K:] / omega[0]),
        lambda ratios: min(LIGHT, ratios.min()),
        lambda starts: (SILENT * np.hypot(*starts).max(), 0.0),
    )
    starts = np.array([np.concatenate([outer, *some]) for some in product(*inner)])
    likely = np.argsort(at_first(law, starts, SHARES[0]))[:STARTS]
    ratios = np.log(omega[K:] / omega[0])
    # a mode that hardly swings runs off its pitch; one that is held there may be damped otherwise
    for tied in (), tuple((K + k, float(ratio)) for k, ratio in enumerate(ratios)):
        walks = walked(replace(law, tied=tied), starts[likely], SHARES, LOOKS, most=ENDS)
        if tied:
            places = np.array([p for p, _, _ in walks])
            walks = walked(law, places, SHARES[-1:], LOOKS, most=ENDS)
        for p, jacobian, _ in walks:
            yield carrying(conclude(law, p, jacobian))


def _begins(effect: Effect, theta: np.ndarray, heard: int, law: Law) -> Iterator[np.ndarray]:
    """What an effect's numbers `theta`, found with so many `heard` modes, may be with the law's."""
    n = len(effect.low)
    most = NEAREST if heard > 1 else 1 + effect.places
    for own in [theta[:n], *(effect.otherwise(theta[:n]) if effect.otherwise else ())]:
        yield from placed(effect, np.r_[own, theta[n:]], heard, law.setting.places, most)


def _retold(verdict: Verdict, best: TimeFit) -> Verdict:
    """The verdict with its final fit as the heard modes are in the `best` one. How it compares with
    others is told without the modes that these do not have.
    """
    before, damped = verdict.final, verdict.damped
    final, own = of_heard(best, before), verdict.effects[verdict.laws :]
    told = len(own) == 1 and best.chi2 < NOISY * best.samples
    told = told and not owes(best, damped, CLEARLY)
    told = told and not weakens(damped, judge(own[0].names, best, damped))
    return replace(
        verdict,
        verdict="explained" if told else verdict.verdict,
        chain=(*verdict.chain[:-1], (verdict.chain[-1][0], final)),
        bare=before,
    )


def of_heard(best: TimeFit, before: TimeFit) -> TimeFit:
    """What a fit of more modes says of those of the one `before`; what it foretells is of all."""
    law = best.law
    K, N, (a, b, _) = before.law.modes, law.modes, law.sizes()
    modes = np.arange(N) < K
    inner = [
        np.r_[np.ones(len(e.low), bool), np.tile(modes[1:], e.axes if e.force else 0)]
        for e in law.effects
    ]
    kept = np.concatenate([np.tile(modes, (a + b) // N), *inner])
    turning = np.ones(len(law.turning), bool)
    own = np.tile(np.r_[modes, turning], law.conditions)
    rest = np.ones(best.coefficients.shape[1] - len(own), bool)
    return replace(
        best,
        law=replace(before.law, effects=law.effects),
        parameters=best.parameters[kept],
        covariance=best.covariance[np.ix_(kept, kept)],
        coefficients=best.coefficients[:, np.r_[own, rest]],
        jacobian=best.jacobian[:, kept],
        motions=tuple(u[:, :K] for u in best.motions),
    )
