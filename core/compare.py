"""Measured pitches and shapes against those of one computed body, at its best Young's modulus.

Young's modulus scales all pitches alike, so it is fitted along with every body. A pitch counts
with its own error and the model's (from mesh convergence), a shape with its noise and the share
by which computed shapes and marker places are trusted. A stiffness that is a little off turns modes
into one another by that over the distance of their eigenvalues (first-order perturbation: Courant
and Hilbert, Methods of Mathematical Physics I, V.13), so a mode may hold some of its neighbours,
which costs the more the further they lie apart.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dgesv

from .match import PAIR, TURNED

PITCH_FLOOR = 0.003  # relative error of a computed pitch that convergence does not see
SHAPE_FLOOR = 0.02  # of a shape's largest entry
PIECES = 6.0  # independent pieces of evidence in one shape, however many channels show it
UNSEEN = 1e-9  # weight of a channel that shows no mode
DEPENDENT = 1e-12  # squared sine below which two modes look the same
MIXING = 0.01  # half of the stiffness that a body may be off by, relatively: over that distance it
# is the share by which they do
STRANGE = 16.0  # misfit of a faint mode's pitch from which it is taken for none of the body's, and
# the most that it costs
UNFOLDING = 9.0  # what it costs that a pitch was folded by the frame rate
LIKE = 0.4  # MAC from which a computed mode may be a measured one
FIRST = 3  # of the lowest computed modes, that the first measured one may be
CHANCE = 1.0  # misfit by which a higher one must be the better first one


@dataclass(frozen=True, eq=False)
class Measured:
    """Pitches and shapes as they were found, and what is known of the sag."""

    frequency: np.ndarray  # (K,) Hz
    error: np.ndarray  # (K,) relative, measurement and model together
    shapes: np.ndarray  # (K, C)
    shape_error: np.ndarray  # (K, C)
    sag: np.ndarray | None = None  # (C,) offset by which the weight moved the channels
    softer: float = 1.0  # static over dynamic stiffness, where a relaxation was found
    sag_error: float = 0.05  # relative: geometry, creep, and where markers were put
    faint: int = 0  # the last so many are faint, and may be none of the body's modes
    common: np.ndarray | None = None  # (q, K) relative, ways in which all may be off at once
    folds: tuple[tuple[int, float], ...] = ()  # modes, and the Hz of which theirs may be the fold

    @cached_property
    def weight(self) -> np.ndarray:
        """(K + 1,) of every pitch's logarithm, and of half the sag's."""
        return np.r_[self.error, self.sag_error / 2] ** -2.0

    @cached_property
    def together(self) -> np.ndarray:
        """(q, K + 1) by which logarithms of all pitches may be off at once; the sag's is not."""
        none = np.zeros((0, len(self.error)))
        return np.pad(none if self.common is None else self.common, ((0, 0), (0, 1)))

    @cached_property
    def means(self) -> tuple["_Mean", "_Mean"]:
        """Of all pitches' logarithms, and of these with half the sag's."""
        K = len(self.error)
        return tuple(_mean(self.weight[:n], self.together[:, :n]) for n in (K, K + 1))

    @cached_property
    def seen(self) -> np.ndarray:
        """(K,) how many channels tell anything of each shape."""
        return (1 / self.shape_error > UNSEEN).sum(axis=1)

    @cached_property
    def weighed(self) -> np.ndarray:
        """(K, C) shapes over their errors."""
        return self.shapes / self.shape_error

    @cached_property
    def interval(self) -> np.ndarray:
        """(K,) of every pitch from the first one, a logarithm."""
        return np.log(self.frequency / self.frequency[0])

    @cached_property
    def power(self) -> np.ndarray:
        """(K,) of every shape."""
        return (self.shapes**2).sum(axis=1)

    @cached_property
    def sure(self) -> np.ndarray:
        """(K,) share of every shape that is no noise, by which it tells a mode."""
        power = (self.weighed**2).sum(axis=1) / self.seen
        return np.maximum(power - 1, 0) / np.maximum(power, 1)


@dataclass(frozen=True, eq=False)
class ShiftsLeft:
    """By how much logarithms of K modes' pitches in s takes with other loads are off."""

    pull: np.ndarray  # (s, K) standard deviations, beyond what all are off by at once
    error: np.ndarray  # (s, K) these deviations themselves
    common: float  # standard deviations that all are off by at once
    way: np.ndarray  # (s, K) one of these

    @property
    def chi2(self) -> float:
        """Misfit of all of them."""
        return float((self.pull**2).sum()) + self.common**2

    def beyond(self, forgive) -> np.ndarray:
        """(s, K) what each is off by; `forgive` takes off standard deviations what is forgiven."""
        return forgive(self.pull) * self.error + forgive(np.array(self.common)) * self.way


NO_SHIFTS = ShiftsLeft(np.zeros((0, 0)), np.zeros((0, 0)), 0.0, np.zeros((0, 0)))


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One body against the measurements, at its best Young's modulus."""

    chi2: float
    modulus: float  # Pa
    modes: tuple[int, ...]  # computed partner of every measured mode
    frequency: np.ndarray  # (K,) Hz
    read: np.ndarray  # (K,) Hz, the measured pitches, unfolded where that costs less
    shapes: np.ndarray  # (K, C) scaled to the measured ones
    pitch_pull: np.ndarray  # (K,) standard deviations, beyond what all are off by at once; (K + 1,)
    # with that of the sag
    free: np.ndarray  # the same, share of each pull's variance that the fit leaves it
    together: np.ndarray  # (q,) standard deviations, by how much all pitches are off at once
    shape_chi2: np.ndarray  # (K,)
    sag: np.ndarray | None = None  # (C,)
    folded: tuple[int, ...] = ()  # measured modes whose pitches are read as folded
    strange: int = 0  # faint modes that are none of the body's; their pulls are the most they cost
    shifts: ShiftsLeft = NO_SHIFTS

    @property
    def pitch_chi2(self) -> float:
        """Misfit of the pitches, those under other loads too, and the sag."""
        pulls = self.pitch_pull @ self.pitch_pull + self.together @ self.together
        return float(pulls + UNFOLDING * len(self.folded) + self.shifts.chi2)

    @property
    def pitches(self) -> np.ndarray:
        """(K,) Hz at 1 Pa."""
        return self.frequency / np.sqrt(self.modulus)


def compare(measured: Measured, values, shapes, unit=None, *, most=np.inf) -> Hypothesis | None:
    """The measurements against eigenvalues (m,) at 1 Pa and shapes (m, C) as seen.

    unit (C,): the sag at 1 Pa as seen, or None. None where no low mode moves as the first
    measured one does, or where it costs more than `most`.
    """
    own = np.sqrt(np.maximum(values, 1e-300)) / (2 * np.pi)
    best, limit = None, most + CHANCE  # else a lower one is passed over that a higher one must beat
    alike = _alike(measured, shapes, own)
    for first in np.flatnonzero(own <= own[:FIRST][-1] * (1 + TURNED)):  # near ones change places
        for partners in _ways(measured, own, alike, first):
            best = _at_best_modulus(measured, own, shapes, partners, unit, most=limit) or best
            limit = limit if best is None else best.chi2
        limit = limit if best is None else best.chi2 - CHANCE
    return best if best is not None and best.chi2 < most else None


def rematched(measured: Measured, values, shapes, unit, found: Hypothesis) -> Hypothesis:
    """The hypothesis with another computed mode for a measured one where that fits better; one that
    is another's already changes places with it.

    Two computed modes that lie close together may change places from mesh to mesh, and a body
    that is as declared must not pay for it. Arguments as `compare` has them.
    """
    own = np.sqrt(np.maximum(values, 1e-300)) / (2 * np.pi)
    alike = _alike(measured, shapes, own)
    for k in range(1, len(found.modes)):
        for j in np.flatnonzero(alike[:, k] > LIKE):
            other = found.modes.index(j) if j in found.modes else k
            if other == 0 or alike[found.modes[k], other] <= LIKE:
                continue
            modes = [found.modes[k] if mode == j else mode for mode in found.modes]
            modes[k] = int(j)
            most = found.chi2
            found = _at_best_modulus(measured, own, shapes, tuple(modes), unit, most=most) or found
    return found


def _ways(measured, own, alike, first) -> list[tuple[int, ...]]:
    """Partners, the first one being `first`: by the pitches as they were seen, and where some may
    be folds by the nearer one; none where the first one does not move so.
    """
    if alike[first, 0] < LIKE:
        return []
    off = np.log(own / own[first])
    seen = np.abs(measured.interval[:, None] - off)
    away = seen.copy()
    for k, other in measured.folds:
        away[k] = np.minimum(away[k], np.abs(np.log(other / measured.frequency[0]) - off))
    ways = [_partners(measured, alike, first, one) for one in (seen, away)]
    return list(dict.fromkeys(ways))


def _partners(measured, alike, first, away) -> tuple[int, ...]:
    """Computed mode of every measured one by likeness (m, K) and how far it is `away` (K, m)."""
    taken = [int(first)]
    for k in range(1, len(measured.frequency)):
        score = measured.sure[k] * alike[:, k] - away[k]
        score[taken] = -np.inf
        taken.append(int(score.argmax()))
    return tuple(taken)


def _alike(measured, shapes, own) -> np.ndarray:
    """(m, K) MAC of every computed mode, or the pair that it belongs to, with the measured ones."""
    gram, across = shapes @ shapes.T, shapes @ measured.shapes.T
    alike = across**2 / np.maximum(gram.diagonal()[:, None] * measured.power, 1e-300)
    pairs = np.abs(own / own[:, None] - 1) < PAIR
    done = {}
    for j in np.flatnonzero(pairs.sum(axis=1) > 1):
        both = pairs[j].tobytes()
        if both not in done:
            at = np.flatnonzero(pairs[j])
            shares = _solved(gram[at[:, None], at], across[at])
            done[both] = (across[at] * shares).sum(axis=0) / measured.power
        alike[j] = done[both]
    return alike


def _solved(gram: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The normal equations' least solution: two modes of a pair may look the same."""
    size = np.sqrt(np.maximum(gram.diagonal(), 1e-300))
    known = gram / (size[:, None] * size)
    known.flat[:: len(size) + 1] += DEPENDENT  # so that no pivot is nought
    return (dgesv(known, (right.T / size).T)[2].T / size).T


def _mixed(modes, wanted, gap, many: float) -> tuple[np.ndarray, float]:
    """How much of every one of the `modes` (n, C) makes the `wanted` shape (C,), both over its
    errors, and what having them costs; `gap` (n,): of their pitches to the matched one's, relative.
    """
    gram, across = modes @ modes.T, modes @ wanted
    if len(modes) == 1:
        return across / max(float(gram[0, 0]), 1e-300), 0.0
    scale = gram.diagonal().max() / max(wanted @ wanted, 1e-12)
    keep = np.where(gap < PAIR, 0.0, (gap / MIXING) ** 2 * scale)
    gram.flat[:: len(keep) + 1] += keep / many
    part = _solved(gram, across)
    return part, keep @ part**2


@dataclass(frozen=True, eq=False)
class _Mean:
    """By generalized least squares the mean of logarithms, each with its own weight, that may be
    off together; which is the same for every body.
    """

    ways: np.ndarray  # (1 + q, n) the mean, and by how much they may be off at once
    solve: np.ndarray  # (1 + q, n) the mean and how far all are off at once, of the logarithms
    root: np.ndarray  # (n,) 1 / standard deviation
    free: np.ndarray  # (n,) share of the variance of each one's pull that the fit leaves

    def pulled(self, ratio: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
        """Of logarithms `ratio` (n,) the mean, how far each is off beyond it (n,), in standard
        deviations, `free`, and how far all are off at once (q,), in those.
        """
        best = self.solve @ ratio
        return float(best[0]), (ratio - best @ self.ways) * self.root, self.free, best[1:]


def _mean(weight: np.ndarray, together: np.ndarray) -> _Mean:
    """weight (n,): 1 / variance; together (q, n): see `Measured`."""
    ways = np.vstack([np.ones(len(weight)), together])
    weighed = ways * weight
    inverse = np.linalg.inv(weighed @ ways.T + np.diag([0.0] + [1.0] * len(together)))
    leverage = ((inverse @ ways) * weighed).sum(axis=0)
    return _Mean(ways, inverse @ weighed, np.sqrt(weight), 1 - leverage)


def _at_best_modulus(measured, own, shapes, partners, unit, *, most=np.inf):
    """The hypothesis with these partners, None where it costs no less than `most`; each pitch read
    as it was measured or as what may have been folded to it, whichever costs less.
    """
    best, readings = None, [(measured.frequency, ())]
    for k, other in measured.folds:
        at = np.arange(len(measured.frequency)) == k
        readings += [(np.where(at, other, one), (*folded, k)) for one, folded in readings]
    for reading in sorted(readings, key=lambda one: len(one[1])):
        if UNFOLDING * len(reading[1]) >= most:
            break
        found = _as_read(measured, own, shapes, (partners, *reading), unit, most)
        best, most = (found, found.chi2) if found else (best, most)
    return best


def _as_read(measured, own, shapes, reading, unit, most):
    """The hypothesis with this `reading`: partners, pitches (K,) Hz, and which are folded."""
    partners, pitches, folded = reading
    chosen = own[list(partners)]
    ratio = np.log(pitches / chosen)
    sag = None
    weigh = unit is not None and measured.sag is not None
    if weigh:
        size = (unit @ measured.sag) / (unit @ unit) * measured.softer  # 1/Pa times softer
        if size > 0:
            ratio = np.r_[ratio, -0.5 * np.log(size)]
    faint, strange = np.zeros((2, len(ratio)), bool)
    faint[len(chosen) - measured.faint : len(chosen)] = True
    log_root, pull, free, shares = measured.means[len(ratio) - len(chosen)].pulled(ratio)
    while faint.any():  # the farthest off first, for it draws the others' mean
        off = np.where(faint & ~strange, pull**2 / np.maximum(free, 0.1), 0.0)
        if off.max() <= STRANGE:
            break
        strange[off.argmax()] = True
        n = len(ratio)
        left = np.where(strange, 0.0, measured.weight[:n])
        log_root, pull, free, shares = _mean(left, measured.together[:, :n]).pulled(ratio)
    pull = np.where(strange, np.sqrt(STRANGE), pull)
    whole = float(pull @ pull + shares @ shares) + UNFOLDING * len(folded)
    if not whole < most:
        return None
    modulus = float(np.exp(2 * log_root))
    if weigh:
        sag = unit / modulus / measured.softer
    fitted, chi2 = [], []
    for k, j in enumerate(partners):
        if strange[k]:
            fitted.append(measured.shapes[k])
            chi2.append(0.0)
            continue
        gap = np.abs(own / own[j] - 1)
        near = gap < TURNED
        pair = shapes[near]
        weighed, wanted = pair / measured.shape_error[k], measured.weighed[k]
        many = min(1.0, PIECES / measured.seen[k])
        part, kept = _mixed(weighed, wanted, gap[near], many)
        left = wanted - part @ weighed
        fitted.append(part @ pair)
        costs = left @ left * many + kept
        chi2.append(min(costs, STRANGE - pull[k] ** 2) if faint[k] else costs)
        whole += float(chi2[-1])
        if not whole < most:
            return None
    return Hypothesis(
        whole,
        modulus,
        partners,
        chosen * np.sqrt(modulus),
        pitches,
        np.array(fitted),
        pull,
        free,
        shares,
        np.array(chi2),
        sag,
        folded,
        int(strange.sum()),
    )
