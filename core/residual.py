"""What a prediction leaves: how much, against which noise, and by which signature."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .channels import Channels
from .law import TimeFit

QUIET = 1.1  # misfit per sample below which there is nothing to look for
NOISY = 1.3  # misfit per sample above which noise alone is no explanation
FAR_OFF = 2.0  # times its noise, from which a held-out error is that of something not modelled
AHEAD = 1.5  # the same, from which what an effect leaves ahead shows a second one, or a better fit
SHARE = 0.2  # of what is left, that a wider law must take: less may be what acts in time
EVIDENCE = 20.0  # least gain in BIC (Kass and Raftery 1995 call 10 very strong)


def parts(takes: tuple[Channels, ...], held: bool) -> list[np.ndarray]:
    """Per take (T, C) bool: the known samples that are held out, or that are fitted.

    Of a whole held-out take its first two periods do not count; `fit` marks them.
    """
    out = []
    for data in takes:
        rows = ~data.fit if held else (data.fit & (not data.take.held_out))
        out.append(data.known & rows[:, None] & ~data.support[None])
    whole = any(t.take.held_out for t in takes)
    if whole and held:  # thirds are held out only where no whole take is
        out = [o if t.take.held_out else o & False for o, t in zip(out, takes, strict=True)]
    return out


def _nrmse(takes, predicted, uses) -> float | None:
    """RMS of measured minus predicted over RMS of the motion about its mean, over the samples
    `uses` [(T, C), ...]; None where there are none.
    """
    wrong = moved = 0.0
    for data, guess, use in zip(takes, predicted, uses, strict=True):
        if not use.any():
            continue
        values = np.where(use, data.values, np.nan)
        busy = use.any(axis=0)
        mean = np.nanmean(values[:, busy], axis=0)
        moved += np.nansum((values[:, busy] - mean) ** 2)
        wrong += ((data.values - guess)[use] ** 2).sum()
    return float(np.sqrt(wrong / max(moved, 1e-300))) if any(u.any() for u in uses) else None


def bic(found: TimeFit) -> float:
    """Of the fitted part (Schwarz 1978); the noise is known."""
    return found.chi2 + found.unknowns * np.log(max(found.samples, 2))


def pays(wider: TimeFit, found: TimeFit) -> bool:
    """Whether what the law was widened by takes its share of what was left, and brings evidence."""
    less = found.chi2 - wider.chi2 > SHARE * (found.chi2 - found.samples)
    return bool(less and bic(wider) < bic(found) - EVIDENCE)


def noise_share(takes: tuple[Channels, ...], held: bool, doubted: bool = False) -> float:
    """The recording's own noise in the normalisation of `Error`; with what is `doubted` besides."""
    noise = moved = 0.0
    for data, use in zip(takes, parts(takes, held), strict=True):
        if not use.any():
            continue
        values = np.where(use, data.values, np.nan)
        busy = use.any(axis=0)
        mean = np.nanmean(values[:, busy], axis=0)
        moved += np.nansum((values[:, busy] - mean) ** 2)
        noise += (use * (data.unsure if doubted else data.sigma) ** 2).sum()
    return float(np.sqrt(noise / max(moved, 1e-300)))


def misfit(takes: tuple[Channels, ...], predicted, held: bool) -> tuple[float, int]:
    """Sum of squared residuals over noise and doubt, and how many samples it is over."""
    total, count = 0.0, 0
    for data, guess, use in zip(takes, predicted, parts(takes, held), strict=True):
        if use.any():
            left = np.where(use, (data.values - guess) / data.unsure, 0.0)
            total += float((left**2).sum())
            count += int(use.sum())
    return total, count


def motion_rms(takes: tuple[Channels, ...]) -> float:
    """RMS over the fitted samples of the motion about its mean, in noise units."""
    total, count = 0.0, 0
    for data, use in zip(takes, parts(takes, False), strict=True):
        if use.any():
            values = np.where(use, data.values / data.sigma, np.nan)
            busy = use.any(axis=0)
            total += np.nansum((values[:, busy] - np.nanmean(values[:, busy], axis=0)) ** 2)
            count += int(use.sum())
    return float(np.sqrt(total / max(count, 1)))


def excess(found: TimeFit) -> float:
    """RMS of what is left over noise, as a share of the motion's RMS (fitted part)."""
    left, count = misfit(found.law.takes, found.predicted, False)
    return float(np.sqrt(max(left / max(count, 1) - 1, 0)) / motion_rms(found.law.takes))


@dataclass(frozen=True)
class Error:
    """NRMSE of a prediction, of all takes together and, of several, of each one by itself."""

    held_out: float
    fit: float
    each: tuple[tuple[str, float | None, float | None], ...] = ()  # take, held out, fitted

    def over(self, other: "Error", factor: float) -> tuple[bool, bool]:
        """Whether it is more than `factor` times the other one, held out and fitted."""
        return self.held_out > factor * other.held_out, self.fit > factor * other.fit


def error_of(takes: tuple[Channels, ...], predicted) -> Error:
    """The error of what is `predicted` [(T, C), ...] of the takes."""
    both = [parts(takes, held) for held in (True, False)]
    whole = [_nrmse(takes, predicted, uses) or 0.0 for uses in both]
    if len(takes) == 1:
        return Error(*whole)
    alone = [
        [_nrmse((t,), (p,), (u,)) for t, p, u in zip(takes, predicted, uses, strict=True)]
        for uses in both
    ]
    return Error(*whole, tuple(zip(map(_label, takes), *alone, strict=True)))


def _label(data: Channels) -> str:
    """The take's file as the case names it, without a path that holds on one machine only."""
    file = Path(data.take.name)
    return file.name if file.is_absolute() else data.take.name


def errors(found: TimeFit) -> Error:
    """The error of a fit."""
    return error_of(found.law.takes, found.predicted)


def strays(found: TimeFit, much: float = FAR_OFF) -> bool:
    """Whether what was held out is mispredicted by `much` times its noise."""
    takes = found.law.takes
    return errors(found).held_out > much * noise_share(takes, True, doubted=True) > 0
