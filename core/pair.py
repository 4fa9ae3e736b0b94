"""The other direction of a degenerate pair, where a recording shows it."""

import numpy as np

from .effects.partner import AT_BOUND, SPREAD, Where, crossing, partner
from .law import Law, TimeFit, unpack
from .match import SPLIT
from .refit import led, swapped, without
from .residual import EVIDENCE, NOISY, SHARE, pays
from .settle import displaced
from .timefit import best_fit, extend, fit, misfits, walked, within

LOOKS = 20  # of a search
TO_THE_END = 100  # of one that may still be on its way
FORCE = 0.5  # of what that motion leaves, that the force must take to be one
LEFT = 3.0  # misfit per sample: a free motion that leaves more may stand for anything
HINT = 0.5  # of that, which its columns could take before anything is searched
FIRST, HOPE = 6, 2.0  # looks after which one that leaves so many times LEFT is given up
APART = np.geomspace(0.001, 0.1, 9)  # of its mean, that a split pair's pitches may lie apart
FURTHER = (0.02, 0.06)  # beyond the gap, from where a pair that is split further is sought


def with_partner(found: TimeFit, k: int, gap: float, take: int = 0) -> TimeFit:
    """The fit with the partner of mode `k`, last among the effects, where it shows; else itself.

    gap: how far, relatively, the body itself parts the pair. Where takes carry different loads,
    the partner is that of the body in fitted take number `take`.
    """
    at = _where(found, k, take)
    effect = partner(at, gap)
    wider = _wider(found, effect)
    if not pays(wider, found) or effect.veto(wider) or displaced(wider, found):
        return found
    if gap > SPREAD:  # two pitches that lie apart trade their swings along a flat valley; one that
        # is none at its end stays as good as it was
        longer = fit(wider.law, wider.parameters, evaluations=TO_THE_END)
        wider = wider if effect.veto(longer) or displaced(longer, found) else longer
    return found if _parts(wider, partner(at, SPLIT), gap) else wider


def _where(found: TimeFit, k: int, take: int) -> Where:
    law = found.law
    index = law.fitted[take]
    omega, zeta, _, _ = unpack(law, found.parameters[None], take)
    return Where(
        k,
        float(omega[0, k] / (2 * np.pi)),
        float(zeta[0, k]),
        take,
        law.pitch[index],
        law.condition[index],
        law.loaded_alike(take),
    )


def _parts(wider: TimeFit, freer, gap: float) -> bool:
    """Whether the last effect stands as far from the pair's pitch as it may, and with the bounds
    of `freer` it would do better further on: then it is no partner.
    """
    effect, theta = wider.law.effects[-1], wider.theta[-1][0]
    if AT_BOUND * effect.low[0] < theta[0] < AT_BOUND * effect.high[0]:
        return False
    begins = [theta, *(np.r_[way * (gap + more), theta[1:]] for way in (-1, 1) for more in FURTHER)]
    law, starts = swapped(wider, freer, begins)
    return best_fit(law, starts, evaluations=LOOKS).chi2 < wider.chi2 - EVIDENCE


def opened(found: TimeFit) -> TimeFit:
    """The fit with the two pitches of a pair that is split as far apart as tells most; itself where
    no effect parts one.

    While they have hardly begun to beat, ever larger swings that cancel do nearly as well the
    nearer the two lie: a search creeps along that valley and ends where it is.
    """
    law = found.law
    parting = [i for i, effect in enumerate(law.effects) if effect.parts]
    if not parting:
        return found
    a, b, _ = law.sizes()
    at = a + b + sum(len(theta[0]) for theta in found.theta[: parting[0]])
    pair, heard = law.setting.pair, law.setting.omega[law.setting.pair] / (2 * np.pi)
    both = np.log([found.frequency[pair], heard * (1 + found.parameters[at])])
    starts = np.tile(found.parameters, (2 * len(APART), 1))
    for p, gap in zip(starts, np.r_[APART, -APART], strict=True):
        p[pair : a : 2 * law.modes] += both.mean() - gap / 2 - both[0]
        p[at] = np.exp(both.mean() + gap / 2) / heard - 1
    starts = within(law, starts)
    likeliest = starts[np.argsort(misfits(law, starts, found.samples))[:2]]
    looks = LOOKS if any(effect.marched for effect in law.effects) else TO_THE_END
    return min(found, best_fit(law, likeliest, evaluations=looks), key=lambda one: one.chi2)


def across(found: TimeFit) -> TimeFit:
    """The fit of a force on a degenerate mode with what swings across it, where that shows.

    Turned to where the force acts, the pair is one mode that feels it and one that swings freely.
    """
    law = found.law
    told = found.chi2 < NOISY * found.samples
    if told or not _may_cross(law) or any(e.layer == "pair" for e in law.effects):
        return found
    effect = _crossing(law)
    if not _hinted(found, effect):
        return found
    wider = _in_hope(found, effect, LEFT * found.samples)
    if wider is None or not pays(wider, found):
        return found
    wider = led(wider)
    bare = without(wider, len(law.effects))  # what swings across may tell all by itself
    gain, left = bare.chi2 - wider.chi2, bare.chi2 - bare.samples
    return wider if gain > FORCE * left and pays(wider, bare) else found


def _may_cross(law: Law) -> bool:
    return law.setting.paired and law.setting.pair_gap is not None


def _crossing(law: Law):
    return crossing(law.setting.pair, law.setting.pair_gap)


def _wider(found: TimeFit, effect) -> TimeFit:
    """The fit with the effect as well."""
    law, starts = _begun(found, effect)
    return best_fit(law, starts, evaluations=LOOKS)


def _in_hope(found: TimeFit, effect, most: float) -> TimeFit | None:
    """The same; None where it leaves more than `most`, or by its first looks far more."""
    law, starts = _begun(found, effect)
    walks = walked(law, starts, (1.0,), FIRST)
    if walks[0][2] > HOPE * most:
        return None
    wider = best_fit(law, np.array([p for p, _, _ in walks]), evaluations=LOOKS - FIRST)
    return None if wider.chi2 > most else wider


def _begun(found: TimeFit, effect) -> tuple[Law, np.ndarray]:
    """The law with the effect as well, and where a search for it begins (S, p)."""
    starts = effect.starts(found.law.setting, None)
    tries = [extend(found, (effect,), [start]) for start in starts]
    return tries[0][0], np.array([p for _, p in tries])


def _hinted(found: TimeFit, effect) -> bool:
    """Whether it takes enough, from where a search for it begins, for that to be worth while.

    Beside it the mode's own shape may be other than its reference asks for; a search mends that.
    """
    left = misfits(*_begun(found, effect), found.samples).min()
    before = (found.residuals[: found.samples] ** 2).sum()
    return before - left > HINT * SHARE * (found.chi2 - found.samples)
