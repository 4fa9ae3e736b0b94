"""Modes of the body that nobody heard, and that a force which was found rings: a rub's stick, a
stop, a stiffness that grows.

Such a force drowns what was let go, so that few modes are heard by themselves. With those alone
what it does to the others stays in the residual. Their pitches, and how a place shares in them,
are known of the body; what the march of all of them foretells is what the heard ones' is beside it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from .baseline import reference_weights, with_body
from .effects.base import Effect
from .effects.further_mode import is_further
from .hearings import whole_ground
from .joint import Heard
from .law import Law, TimeFit
from .match import Match
from .residual import NOISY, errors, excess
from .settle import CLOSE, Recorded, told_elsewhere
from .sufficiency import CLEARLY, CLEARLY_BOTH, at_a_bound, bends_the_body, owes
from .time_layer import Candidate, judge
from .timefit import at_first, conclude, walked
from .verdict import Verdict

MORE, FEWEST = 3, 5  # modes beside those that were heard, and altogether where few were
SILENT = 1e-3  # of the first mode's swing, from which those begin that were not heard
LIGHT = 0.02  # damping ratio that they begin with at most: what rubs damps the heard ones, too
HIGHEST = 0.8  # of half the frame rate
NEAREST = 24  # places that are tried, where the heard modes tell something of it
FIERCER, TRAVELS = (0.6, 1.0), (-5.0, -4.0)  # what else a rub may be: its strength, its travel
STARTS = 24  # that are walked
SHARES = (0.3, 0.6, 1.0)  # of the record
LOOKS = 20
LESS = 0.5  # of what was left beyond noise, rms, is then left at most


@dataclass(frozen=True, eq=False)
class Stirred:
    """A verdict that counts modes which were not heard, and the motion with these."""

    verdict: Verdict  # its final fit tells of the heard modes, and foretells what all of them do
    heard: Heard  # with the others in its match and its turns
    found: TimeFit  # of all of them


def with_stirred(heard: Heard, verdict: Verdict) -> Stirred | None:
    """The verdict with the body's lowest modes that a found force may ring; None where there is no
    such force, where all but noise is told without them, or where they do not leave far less.

    What stays unexplained for that is explained if nothing but noise is left then.
    """
    found = verdict.final
    names = set(verdict.names[verdict.laws :])
    forces = [e for e in found.law.effects if e.force and e.name in names]
    if not forces or found.chi2 < NOISY * found.samples:
        return None
    wider = _widened(heard, found)
    if wider is None:
        return None
    more, law = wider
    best = _fitted(law, found)
    known = found.law.modes
    apart = np.abs(np.log(best.frequency[:known] / found.frequency))
    if (
        excess(best) > LESS * excess(found)
        or errors(best).held_out > errors(found).held_out
        or max(best.swings[known:]) > max(best.swings[:known])
        or (apart > CLOSE).any()
        or bends_the_body(best)
    ):
        return None
    return Stirred(_retold(verdict, best), more, best)


def _widened(heard: Heard, found: TimeFit) -> tuple[Heard, Law] | None:
    """What was heard, and the law of `found` without its further modes, with the body's lowest
    modes beside the heard ones; None where there are none, or where loads part the takes.
    """
    ground, old = whole_ground(heard), found.law
    if ground is None:
        return None
    body, at = heard.body, ground.fitted[0]
    data, computed = heard.takes[at], body.modes.frequency
    scale = found.frequency[0] / computed[heard.match.modes[0]]
    count = max(old.modes + MORE, FEWEST)
    low = np.flatnonzero(computed[:count] * scale * data.frame < HIGHEST / 2)
    new = [int(j) for j in low if j not in heard.match.modes][: count - old.modes]
    if not new:
        return None
    turn = np.hstack([heard.turns[0], np.eye(len(computed))[:, new]])
    poles, modes = heard.match.poles, heard.match.modes
    match = Match((*poles, *[poles[0]] * len(new)), (*modes, *new))
    more = replace(heard, match=match, turns=(turn, *heard.turns[1:]))
    return more, _with_modes(old, ground, turn, new, scale * computed[new])


def _with_modes(old: Law, ground: Recorded, turn: np.ndarray, new: list, pitches) -> Law:
    """The law with the computed modes `new` of those `pitches` (Hz) behind its own."""
    at = ground.fitted[0]
    data, body = ground.takes[at], ground.bodies[ground.condition[at]]
    seen = body.seen(data)[new]
    seen[:, data.support] = 0.0
    rows = np.array([reference_weights(shape, data) for shape in seen])
    unit = seen / np.einsum("kc,kc->k", rows, seen)[:, None]
    couple = np.r_[old.setting.couple, unit @ old.reference[0]]
    none = np.zeros((len(couple), 0))
    setting = replace(
        old.setting,
        omega=np.r_[old.setting.omega, 2 * np.pi * pitches],
        zeta=np.r_[old.setting.zeta, np.full(len(new), LIGHT)],
        couple=couple,
        places=couple[None, 1:],
        levers=np.ones(1),
        planes=np.zeros((0, 2, len(couple) - 1)),
        skin=none,
        facing=none,
        wind=none.T,
        masses=np.ones(len(couple)),
        carried=(),
    )
    law = replace(
        old,
        effects=tuple(e for e in old.effects if not is_further(e)),
        reference=np.vstack([old.reference, rows]),
        gauges=tuple(np.vstack([one, rows]) for one in old.gauges),
        ways=(*old.ways, *(body.seen(data)[[j]].T for j in new)) if old.ways else (),
        setting=setting,
    )
    return told_elsewhere(ground, with_body(law, data, body, turn), turn)


def _fitted(law: Law, found: TimeFit) -> TimeFit:
    """The best fit of the wider law, from what may be of `found` with it."""
    pairs = zip(found.law.effects, found.theta, strict=True)
    inner = [list(_begins(e, t[0], found.law.modes, law)) for e, t in pairs if not is_further(e)]
    outer = _outer(found, law)
    starts = np.array([np.concatenate([outer, *some]) for some in product(*inner)])
    likely = np.argsort(at_first(law, starts, SHARES[0]))[:STARTS]
    p, jacobian, _ = walked(law, starts[likely], SHARES, LOOKS)[0]
    return conclude(law, p, jacobian)


def _outer(found: TimeFit, law: Law) -> np.ndarray:
    """Pitches, damping ratios and starts of a fit, and those of the law's further modes, which are
    hardly let go: at rest a shape would have no size.
    """
    K, (a, b, _), out = found.law.modes, found.law.sizes(), []
    more = law.modes - K
    ratio = np.log(law.setting.omega[K:] / law.setting.omega[0])
    for pitch, damping in found.parameters[:a].reshape(-1, 2, K):
        out += [pitch, pitch[0] + ratio, damping, np.full(more, min(LIGHT, damping.min()))]
    for place, speed in found.parameters[a : a + b].reshape(-1, 2, K):
        small = np.full(more, SILENT * np.abs(place).max())
        out += [place, small, speed, np.zeros(more)]
    return np.concatenate(out)


def _begins(effect: Effect, theta: np.ndarray, heard: int, law: Law) -> Iterator[np.ndarray]:
    """The effect's numbers beside so many `heard` modes, with what its place may share in the
    others: as the places do that share as nearly in the heard ones.
    """
    if not effect.force:
        yield theta
        return
    own, places, n = len(effect.low), law.setting.places, heard - 1
    couples, across = theta[own : own + n], theta[own + n :]
    far = ((places[:, :n] - couples) ** 2).sum(axis=1)
    some = np.argsort(far, kind="stable")[: NEAREST if n else 1 + effect.places]
    laws = [theta[:own]]
    if effect.sudden and own == 2:
        laws += [np.array([f * theta[0], t]) for f in FIERCER for t in TRAVELS]
    rest = [across, np.zeros(places.shape[1] - n)] if effect.axes > 1 else []
    for law_of_it, i in product(laws, some):
        yield np.concatenate([law_of_it, couples, places[i, n:], *rest])


def _retold(verdict: Verdict, best: TimeFit) -> Verdict:
    """The verdict with its final fit as the heard modes are in the `best` one."""
    before, declared = verdict.final, verdict.chain[0][1]
    final = _of_heard(best, before)

    def retold(one: Candidate) -> Candidate:
        return judge(one.names, final, declared) if one.found is before else one

    several = len(verdict.effects) - verdict.laws > 1
    clearly = CLEARLY_BOTH if several else CLEARLY
    told = best.chi2 < NOISY * best.samples and not owes(best, declared, clearly)
    told = told and not at_a_bound(best, declared)
    return replace(
        verdict,
        verdict="explained" if told else verdict.verdict,
        chain=(*verdict.chain[:-1], (verdict.chain[-1][0], final)),
        effects=tuple(map(retold, verdict.effects)),
        ranked=tuple(map(retold, verdict.ranked)),
    )


def _of_heard(best: TimeFit, before: TimeFit) -> TimeFit:
    """What a fit of more modes says of those of the one `before`; what it foretells is of all."""
    law = best.law
    K, N, (a, b, _) = before.law.modes, law.modes, law.sizes()
    modes, each = np.arange(N) < K, np.ones
    inner = [
        np.r_[each(len(e.low), bool), np.tile(modes[1:], e.axes if e.force else 0)]
        for e in law.effects
    ]
    kept = np.concatenate([np.tile(modes, (a + b) // N), *inner])
    turning = each(len(law.turning), bool)
    own = np.tile(np.r_[modes, turning], law.conditions)
    rest = each(best.coefficients.shape[1] - len(own), bool)
    return replace(
        best,
        law=replace(before.law, effects=law.effects),
        parameters=best.parameters[kept],
        covariance=best.covariance[np.ix_(kept, kept)],
        coefficients=best.coefficients[:, np.r_[own, rest]],
        jacobian=best.jacobian[:, kept],
        motions=tuple(u[:, :K] for u in best.motions),
    )
