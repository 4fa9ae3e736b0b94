"""Which effect in time explains what the declared modes leave: race, fit, confirm.

1. every effect is started from several places on a short horizon; the best few are fitted whole
2. an effect counts when the evidence is strong (BIC), when it is material, when it accounts for
   most of what was left, and when it also predicts what was held out
3. one that does nearly as well as the best is its twin
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .baseline import px_per_metre
from .effects import TIME_EFFECTS, base_motion, lost_frames, tracker_drift
from .effects.base import FINE, Effect
from .law import TRUST, Law, TimeFit
from .pair import across, crossed
from .refit import instead, modes_freed, swapped, with_modes_held
from .residual import NOISY, misfit
from .side_by_side import side_by_side
from .simulate import COARSE
from .timefit import as_it_stands, best_fit, extend, fit, screen

EVIDENCE = 20.0  # least gain in BIC (Kass and Raftery 1995 call 10 very strong)
MATERIAL = 0.005  # least share of the motion's RMS
NEARLY = 0.80  # of the best one's gain makes a twin
PROMISE = 8.0  # least gain in chi2 that a score test must see before an effect is fitted
SETTLED = 0.95  # share of the excess from which what comes later gets one start only
BEGUN = 7  # places that a fit begins from: the marker and the six farthest apart on the body
AT_ONCE = 2  # the most promising effects, which may settle the rest
RUNNERS = 2  # starting places of an effect that are fitted
MOSTLY, BETTER = 0.6, 0.9  # share that the best one must take, misfit that it leaves then
HORIZONS = (0.4, 1.0)  # shares of the fitted part: from short to long, lest a phase slip traps


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fit with effects added, and how much of the declared fit's excess it takes away."""

    names: tuple[str, ...]
    found: TimeFit
    evidence: float  # gain in BIC over the declared fit, held-out misfit included
    share: float  # of the excess over noise, fitted part; NaN where there is none
    held_share: float  # of the excess over noise, held-out part; NaN where there is none
    outdone: bool = False  # a plainer effect does as well, as things stand

    @property
    def confirmed(self) -> bool:
        """Accounts for most of the excess where it was fitted and where it was not."""
        return not (self.share < 0.8 or self.held_share < 0.7)


def judge(names, found: TimeFit, start: TimeFit) -> Candidate:
    """Compare `found` with the declared fit `start`.

    The evidence is the gain in BIC where it was fitted, and in misfit where it only predicted.
    """
    parameters = found.unknowns - start.unknowns
    parameters += sum(e.free for e in found.law.effects) - sum(e.free for e in start.law.effects)
    evidence = start.chi2 - found.chi2 - parameters * np.log(max(found.samples, 2))
    ahead, count = misfit(found.law.takes, found.predicted, True)
    evidence += misfit(start.law.takes, start.predicted, True)[0] - max(ahead, count)
    share = _taken(found, start, False)
    return Candidate(names, found, float(evidence), share, _taken(found, start, True))


def _taken(found: TimeFit, start: TimeFit, held: bool) -> float:
    before, count = misfit(start.law.takes, start.predicted, held)
    after, _ = misfit(found.law.takes, found.predicted, held)
    over = before - count
    if over <= (0.5 * count if held else 0):
        return np.nan
    return float((before - max(after, 0)) / max(over, 1e-9))


def able(start: TimeFit, effects) -> list[Effect]:
    """Those of the effects that this recording can show and that are not there yet."""
    law = start.law
    there = {e.name for e in law.effects}
    return [
        e
        for e in effects
        if e.name not in there and not (e.requires and e.requires(law.setting, law.takes))
    ]


def read_off(start: TimeFit) -> list[Effect]:
    """Effects that are made from what a fit leaves."""
    law, out = start.law, []
    data = law.takes[law.fitted[0]]
    residual = data.values - start.predicted[law.fitted[0]]
    if len(np.unique(data.marker[~data.support])) >= 3:
        left = tuple(
            t.values - p if p is not None else 0 * t.values
            for t, p in zip(law.takes, start.predicted, strict=True)
        )
        swings = law.setting.duration * law.setting.omega[0] / (2 * np.pi)
        out += tracker_drift.propose(law.takes, left, law.fitted[0], swings)
    if len(law.fitted) == 1 and np.isfinite(residual).all(axis=1).sum() > 12:
        out += _jumps(start, data)
    if _common_is_possible(start, data):
        shared = tuple(
            base_motion.common_motion(t, t.values - p) if p is not None else 0 * t.values
            for t, p in zip(law.takes, start.predicted, strict=True)
        )
        free = int(data.fit.sum()) * data.take.recording.values.shape[2]
        rms = base_motion.size(data, residual) / px_per_metre(data)
        out.append(base_motion.shaken(shared, rms, free))
        if data.support.any() and len(law.takes) == 1:
            out.append(base_motion.shaken(shared, rms, free, base_motion.support_path(data)))
    return out


def _jumps(start: TimeFit, data) -> list[Effect]:
    """The one effect whose jumps, all whole frames, the residual shows, if it shows any."""
    jumps, found = (), start
    for _ in range(3):
        seen = _sight(found, data)
        more = [(when, round(g) * data.frame) for when, g in lost_frames.next_jumps(seen)]
        if not any(gain for _, gain in more):
            break
        jumps = lost_frames.gathered(jumps, more, data.frame)
        found = _with_jumps(start, jumps, data)
    for at in range(len(jumps)):
        for shift in (-2, -1, 1, 2):
            moved = [*jumps]
            moved[at] = (jumps[at][0] + shift * data.frame, jumps[at][1])
            better = instead(found, lost_frames.lost(tuple(moved), data.frame))
            if better:
                jumps, found = tuple(moved), better
                break
    jumps = lost_frames.gathered(jumps, (), data.frame)  # two that were moved together may be none
    if not jumps or not _sight(found, data).are_whole(jumps):
        return []
    return [lost_frames.lost(jumps, data.frame)]


def _with_jumps(start: TimeFit, jumps, data) -> TimeFit:
    law, p = extend(start, (lost_frames.lost(jumps, data.frame),), [()])
    return fit(law, p, evaluations=2)


def _sight(found: TimeFit, data) -> lost_frames.Sight:
    index = found.law.fitted[0]
    u, s = found.motions[0], data.time[:, None] / data.time[-1]
    v = np.gradient(u, data.time, axis=0) / found.law.setting.omega
    basis = np.hstack([u, v, s * u, s * v, np.ones((len(u), 1))])
    return lost_frames.Sight(data, found.predicted[index], basis)


def _common_is_possible(start: TimeFit, data) -> bool:
    """A marker on the support shows it; else the markers must not sit together."""
    if data.support.any():
        return True
    markers = np.unique(data.marker)
    size = [np.linalg.norm(start.shapes[0][data.marker == m]) for m in markers]
    return len(markers) >= 3 and min(size) < 0.35 * max(size)


def race(
    start: TimeFit,
    effect: Effect,
    begins: list,
    promise: np.ndarray,
    *,
    runners: int = RUNNERS,
    horizons: tuple = HORIZONS,
) -> TimeFit:
    """The best fit of `start` with `effect`, from the most promising of its starting places."""
    first = unlike(effect, begins, promise)[:runners]
    still = with_modes_held(start)
    tries = [extend(still, (effect,), [begins[i]])[1] for i in first]
    found = best_fit(raced(still, effect), np.array(tries), horizons if effect.marched else (1.0,))
    if still is not start:
        found = modes_freed(found, raced(start, effect), start)
    return across(found) if effect.force else found


def raced(start: TimeFit, *effects: Effect) -> Law:
    """The law of `start` with `effects`, as they are searched for."""
    law = replace(start.law, effects=(*start.law.effects, *effects))
    # with misfit beyond noise a weight in noise units would be too weak
    trust = TRUST * max(np.sqrt(start.chi2 / start.samples), 1.0)
    steps = FINE if any(e.sudden for e in law.effects) else COARSE
    return replace(law, trust=trust, setting=replace(start.law.setting, steps=steps))


def unlike(effect: Effect, begins: list, promise: np.ndarray) -> list[int]:
    """The most promising starting places first, of each strength only the best place on the body:
    the search moves a place more easily than it turns a law round.
    """
    out, seen = [], set()
    for i in np.argsort(-promise):
        own = tuple(begins[i][: len(effect.low)])
        if own not in seen:
            out.append(int(i))
            seen.add(own)
    return out


def entries(start: TimeFit, effects) -> list[tuple[np.ndarray, Effect, list]]:
    """(promise, effect, where it begins) of those that this recording can show, best first."""
    index = start.law.fitted[0]
    data = start.law.takes[index]
    residual = (data.time[data.fit], (data.values - start.predicted[index])[data.fit])
    out, places = [], start.law.setting.places[:BEGUN]
    for effect in able(start, effects):
        begins = effect.starts(start.law.setting, residual)
        if effect.force:
            begins = [(*b, *place) for b in begins for place in places]
            begins = list(dict.fromkeys(begins))
        if begins:
            out.append((screen(start, effect, begins), effect, begins))
    return sorted(out, key=lambda entry: -entry[0].max())


def singles(
    start: TimeFit,
    before: tuple[str, ...] = (),
    against: TimeFit | None = None,
    most: int = 10,
) -> list[Candidate]:
    """The best candidate of every name that a score test promises something, best first."""
    best = {}
    effects = [*TIME_EFFECTS, *read_off(start)]
    chosen = _chosen(entries(start, effects), most)
    first = len(chosen) if before else AT_ONCE
    for some in (chosen[:first], chosen[first:]):
        settled = any(c.share > SETTLED for c in best.values())
        for name, found, plainer in _tried(start, some, runners=1 if settled else RUNNERS):
            if found is None:
                continue
            candidate = judge((*before, name), found, against or start)
            if name not in best or candidate.evidence > best[name].evidence:
                best[name] = replace(candidate, outdone=plainer)
    ranked = sorted(best.values(), key=lambda c: -c.evidence)
    if ranked:
        ranked[0] = _again(start, ranked[0], chosen, against or start)
    return ranked


def _again(start: TimeFit, best: Candidate, chosen: list, against: TimeFit) -> Candidate:
    """The best candidate, or a better one of its effect from all its strengths on the whole record.

    Two modes close together make a short part of it look like what it is not.
    """
    effect = best.found.law.effects[-1]
    entry = next((one for one in chosen if one[1] is effect), None)
    told = best.found.chi2 < NOISY * best.found.samples
    if entry is None or told or not effect.marched or best.share < MOSTLY:
        return best
    found = race(start, effect, entry[2], entry[0], runners=len(entry[2]), horizons=(1.0,))
    if found.chi2 > BETTER * best.found.chi2 or refuted(found):
        return best
    return max(best, judge(best.names, found, against), key=lambda c: c.evidence)


def _chosen(raced_for: list, most: int) -> list:
    """The `entries` of the `most` names that a score test promises something, best first."""
    names, out = set(), []
    least = max([PROMISE, *(0.01 * promise.max() for promise, _, _ in raced_for[:1])])
    for promise, effect, begins in raced_for:
        if promise.max() < least and not effect.clock:  # that may show where it was not fitted
            continue
        if effect.name in names or len(names) < most:
            names.add(effect.name)
            out.append((promise, effect, begins))
    return out


def _tried(start: TimeFit, chosen: list, *, runners: int) -> list:
    """(name, fit or None where it is vetoed, whether it is outdone) of everyone `chosen`."""

    def tried(promise, effect, begins):
        found = race(start, effect, begins, promise, runners=runners)
        return None if vetoed(found) else (found, outdone(found))

    def unpack(n, packed):
        if packed is None:
            return None
        p, plainer = packed
        law = raced(start, chosen[n][1])
        return as_it_stands(law if len(p) == sum(law.sizes()) else crossed(law), p), plainer

    done = side_by_side(
        [partial(tried, *entry) for entry in chosen],
        pack=lambda one: one and (one[0].parameters, one[1]),
        unpack=unpack,
    )
    return [
        (effect.name, *(one or (None, False)))
        for (_, effect, _), one in zip(chosen, done, strict=True)
    ]


def refuted(found: TimeFit) -> bool:
    """Whether the last effect is none by what was fitted, or a plainer one does as well."""
    return vetoed(found) or outdone(found)


def vetoed(found: TimeFit) -> bool:
    """Whether the last effect is none by what was fitted."""
    effect = found.law.effects[-1]
    return bool(effect.veto and effect.veto(found))


def outdone(found: TimeFit) -> bool:
    """Whether a plainer effect in the last one's place does as well."""
    effect = found.law.effects[-1]
    plain = effect.rival and effect.rival(found)
    if not plain:
        return False
    law, starts = swapped(found, plain, plain.starts(None, None)[:1])
    return fit(law, starts[0], evaluations=15).chi2 < found.chi2 + PROMISE
