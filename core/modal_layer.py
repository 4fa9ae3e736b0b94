"""Which change of the body explains the measured pitches and shapes together."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import minimize, minimize_scalar

from .compare import PIECES, Hypothesis, compare
from .effects import MODAL_EFFECTS
from .effects.base import Effect, Family
from .errors import DataError
from .factorization import factorize
from .ground import Ground, converged_sag
from .other_loads import told_by
from .side_by_side import side_by_side

LIMIT = 3.84  # rise of chi2 within which a parameter is not told from the best one, 95 %
NONE = 1e12  # cost of a body in which no mode is the measured one, for a search among numbers
EDGED = 4  # choices, the best ones, from which it is looked for how far they go
HALVINGS = 5  # of the step that looks for it
RIVALS = 4.0  # of what the best choice may cost, at most, that one costs which is kept beside it
ROUNDED = 1e-9  # of the highest eigenvalue: one that is further below nought buckles
ITERATIONS = 3  # of a body's modes towards those of a changed one


@dataclass(frozen=True, eq=False)
class Suspect:
    """An effect of the body, fitted."""

    effect: Effect
    hypothesis: Hypothesis
    theta: np.ndarray
    told: dict  # the contract's parameters
    evidence: float
    cost: float
    near: list  # (cost, report, (K,) Hz at 1 Pa) within the 95 % region
    tried: list  # theta of each refined choice that comes near the best one, that one first

    @property
    def moduli(self) -> tuple[np.ndarray, np.ndarray]:
        """(K,) each, the least and the most modulus, by each mode's pitch, over the best one."""
        own = self.hypothesis.pitches
        span = (own / np.array([own, *(pitches for _, _, pitches in self.near)])) ** 2
        return span.min(axis=0), span.max(axis=0)


def suspects(ground: Ground, names: list[str]) -> list[Suspect]:
    """Every modal effect not in `names`, fitted; best evidence first."""
    first = ground.body.modes.shapes.reshape(-1, ground.body.modes.shapes.shape[2])

    def solve(model, count):
        return improved(model, first[:, :count])

    def fitted(effect):
        try:
            return _fit(effect, effect.families(ground.body, solve), ground)
        except DataError:  # so changed, it could not bear its own weight
            return None

    effects = [effect for effect in MODAL_EFFECTS if effect.name not in names]
    out = side_by_side([partial(fitted, effect) for effect in effects])
    return sorted((s for s in out if s is not None), key=lambda s: -s.evidence)


def improved(model, shapes: np.ndarray) -> np.ndarray:
    """(3P, n) nearly the lowest modes of a model that is a little other than that of `shapes`.

    Inverse iteration of the whole block: what is near a low mode turns into it (Bathe, Finite
    Element Procedures, 11.6). The basis that they go into sorts out the rest.
    """
    free = model.free
    factor = factorize(model.stiffness[free][:, free], _at(model)[free])
    mass, x = model.mass[free][:, free], shapes[free]
    for _ in range(ITERATIONS):
        x, _ = np.linalg.qr(factor.solve(mass @ x))
    out = np.zeros_like(shapes)
    out[free] = x
    return out


def _at(model) -> np.ndarray:
    """(3P, 3) where every unknown is."""
    return np.repeat(model.points, 3, axis=0)


def _fit(effect: Effect, families: Iterable[Family], ground: Ground) -> Suspect | None:
    told = []
    ends = [end for family in families if (end := _closer(effect, family, ground, told))]
    if not ends:
        return None
    best = min(ends, key=lambda one: one.cost)
    level = best.cost + _wide(best.hypothesis, ground)
    return replace(best, near=[one for one in told if one[0] <= level])


def _closer(effect: Effect, family: Family, ground: Ground, told: list) -> Suspect | None:
    """The best of a family: looked for ever closer round each of the places that it chooses, the
    last time round the likeliest of these only. What is near joins `told`.
    """
    found = _best(effect, family, ground)
    if found is None or family.nearer is None:
        told += found.near if found else []
        return found
    told += found.near
    ends = []
    for closer in family.nearer(found.tried):
        there = found
        while closer.nearer and (nearer := _best(effect, closer, ground)):
            there = nearer if there is found else min(there, nearer, key=lambda one: one.cost)
            told += nearer.near
            (closer,) = closer.nearer(nearer.tried)
        ends.append((there, closer))
    best = min((there for there, _ in ends), key=lambda one: one.cost)
    equal = best.cost + _wide(best.hypothesis, ground) / LIMIT
    there, last = min(
        (end for end in ends if end[0].cost <= equal),
        key=lambda end: family.size(end[0].theta) if family.size else end[0].cost,
    )
    end = _closer(effect, last, ground, told)
    return end if end and end.cost <= equal else there


def _wide(found: Hypothesis, ground: Ground) -> float:
    """Rise of chi2 that is no more than chance, what the best fit leaves counted as noise."""
    return LIMIT * max(1.0, found.chi2 / _pieces(ground))


def _pieces(ground: Ground) -> float:
    return len(ground.measured.frequency) * (1 + PIECES) + ground.shifted


def _best(effect: Effect, family: Family, ground: Ground) -> Suspect | None:
    look = _looker(effect, family, ground)
    costs = _costs(look, family, ground)
    if not np.isfinite(costs).any():
        return None
    tried = [_refined(look, family, start) for start in _best_choices(family, costs)]
    tried = sorted(((look(theta)[1], theta) for theta in tried), key=lambda one: one[0])
    wide = _wide(look(tried[0][1])[0], ground)
    if family.size:  # of those that do equally well the least is the likeliest
        equal = sum(c <= tried[0][0] + wide / LIMIT for c, _ in tried)
        least = min(tried[:equal], key=lambda one: family.size(one[1]))
        tried = [least, *(one for one in tried if one is not least)]
    theta = tried[0][1]
    found, cost = look(theta)
    gain = ground.base.chi2 - found.chi2
    evidence = gain - family.unknowns * np.log(_pieces(ground))
    told = family.report(theta, found.modulus)
    level = min(c for c, _ in tried) + wide
    near = [*tried, *zip(costs, family.grid, strict=True)]
    if family.nearer is None:  # how far it goes in one choice depends on the choice
        ends = [t for c, t in tried if c < level][:EDGED]
        near += [(level, edge) for one in ends for edge in _edges(look, family, one, level)]
    near = [
        (c, family.report(t, there.modulus), there.pitches)
        for c, t in near
        if c <= level and (there := look(t)[0]) is not None
    ]
    begins = [t for c, t in tried if c <= RIVALS * level]
    return Suspect(effect, found, theta, told, float(evidence), float(cost), near, begins)


def _costs(look, family: Family, ground: Ground) -> np.ndarray:
    """(n,) what every grid point costs; infinite where that is more than matters.

    Those of the best choices matter, those of the grid's first one, and what comes near the best.
    """
    costs, best = np.full(len(family.grid), np.inf), {}
    most = np.inf
    for i, theta in enumerate(family.grid):
        choice = tuple(theta[: family.frozen])
        first = choice[:1] == tuple(family.grid[0][: family.frozen][:1])
        found, costs[i] = look(theta, np.inf if first else most)
        if found is not None and costs[i] < best.get(choice, (np.inf,))[0]:
            best[choice] = costs[i], _wide(found, ground)
            few = sorted(best.values())[: family.choices]
            near = few[0][0] + few[0][1]
            most = max(few[-1][0], near) if len(few) == family.choices else np.inf
    return costs


def _edges(look, family: Family, theta: np.ndarray, level: float) -> list[np.ndarray]:
    """theta with each of its numbers moved either way to where the cost reaches `level`.

    The step from the best point is doubled until the cost is above the level, then halved back.
    """
    out = []
    for i in range(family.frozen, len(theta)):
        for way in (-1.0, 1.0):
            far = (family.high if way > 0 else family.low)[i] - theta[i]
            span = np.ptp(family.grid[:, i]) or family.high[i] - family.low[i]
            near, step = 0.0, way * span / 200
            while abs(step) < abs(far) and look(_moved(theta, i, step), level)[1] < level:
                near, step = step, 2 * step
            far = step if abs(step) < abs(far) else far
            for _ in range(HALVINGS):
                middle = (near + far) / 2
                if look(_moved(theta, i, middle), level)[1] < level:
                    near = middle
                else:
                    far = middle
            out.append(_moved(theta, i, far))
    return out


def _moved(theta: np.ndarray, i: int, by: float) -> np.ndarray:
    theta = theta.copy()
    theta[i] += by
    return theta


def _best_choices(family: Family, costs: np.ndarray) -> list[np.ndarray]:
    """The best grid points of the few best choices (places, forms), and that of those with the
    grid's first place or form.
    """
    best = {}
    for i in np.argsort(costs):
        best.setdefault(tuple(family.grid[i][: family.frozen]), family.grid[i].astype(float))
    few = list(best)[: family.choices]
    first = next(one for one in best if one[:1] == tuple(family.grid[0][: family.frozen][:1]))
    return [best[one] for one in dict.fromkeys([*few, first])]


def _refined(look, family: Family, theta: np.ndarray) -> np.ndarray:
    """theta with its numbers, not its choices, at their best nearby."""
    n = family.frozen
    if len(theta) == n:
        return theta
    scale = np.ptp(family.grid[:, n:], axis=0) / 20
    scale = np.where(scale > 0, scale, (family.high - family.low)[n:] / 20)

    def whole(y):
        return np.clip(np.r_[theta[:n], y * scale], family.low, family.high)

    if len(theta) == n + 1 or family.rough:
        steps = np.unique(np.r_[family.grid[:, -1], family.low[-1], family.high[-1]])
        below, above = steps[steps < theta[-1]], steps[steps > theta[-1]]
        sides = np.r_[below[-1:], theta[-1], above[:1]][[0, -1]]
        answer = minimize_scalar(
            lambda last: min(look(np.r_[theta[:-1], last])[1], NONE),
            bounds=sides,
            method="bounded",
            options={"xatol": scale[-1] * (0.3 if family.rough else 1e-3), "maxiter": 20},
        )
        return min(theta, np.r_[theta[:-1], answer.x], key=lambda t: look(t)[1])
    answer = minimize(
        lambda y: look(whole(y))[1],
        theta[n:] / scale,
        method="Nelder-Mead",
        options={"maxfev": 40, "xatol": 1e-3, "fatol": 1e-3},
    )
    return whole(answer.x)


def _looker(effect: Effect, family: Family, ground: Ground):
    """(theta, most) -> the hypothesis there and what it costs; None where that is above `most`."""
    body, measured = ground.body, ground.measured
    seen = body.seen(ground.data, family.basis.reshape(len(body.model.points), 3, -1)).T  # (C, r)
    own = None if ground.pull is None else family.basis.T @ ground.pull
    gravity = body.case.takes[0].gravity
    added = [one.within(family.basis) for one in ground.shifts]
    known = {}

    def look(theta, most=np.inf):
        theta = np.asarray(theta, float)
        key = theta.tobytes()
        if key in known:
            return known[key]
        answer = solved(theta, most)
        if answer[0] is not None or most == np.inf:
            known[key] = answer
        return answer

    def solved(theta, most):
        K, M = family.matrices(theta)
        part = family.within(theta) if family.within else np.eye(len(K))
        shrink = ground.shrink[: len(K)]
        # all of them: a few are slower to get, and may not be got where three are equal
        values, x = (part[..., : len(shrink)] for part in eigh(K, M))
        if values[0] < -ROUNDED * values[-1]:
            return None, np.inf
        shapes, unit = (seen @ (part @ x)).T, None
        if own is not None:
            pull = part.T @ own + (family.weight(theta, gravity) if family.weight else 0)
            sag = seen @ (part @ np.linalg.solve(K, pull))
            unit = converged_sag(sag, shapes, x.T @ pull / values, shrink)
        found = compare(measured, values * shrink, shapes, unit, most=most)
        if found is None:
            return None, np.inf
        extra = [part.T @ one @ part for one in added]
        found = told_by(ground.shifts, found, (K, M), extra, (values, x))
        if effect.name == "gravity_preload":  # the modulus that carries the weight is the one found
            return found, found.chi2 + ((np.log(found.modulus) - theta[0]) / 0.02) ** 2
        return found, found.chi2

    return look
