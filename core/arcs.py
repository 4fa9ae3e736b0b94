"""Markers on arcs: what swings far turns, so that it also goes aside, by the square of the swing.

Law         x = sum phi_j u_j + sum theta_jk u_j u_k, K theta_jk = -f2(phi_j, phi_k), where f2 is
            what the force of the nonlinear body has of second degree, twice that where j < k; no
            number of it is fitted, and Young's modulus drops out
Tells       twice the pitch and a shifted mean, across the swing: a bar's tip comes nearer its root
Looks like  asymmetric_stiffness, whose forces move the markers as the modes do
Source      Idelsohn and Cardona, Comp. Meth. Appl. Mech. Eng. 49 (1985) 253 (static derivatives of
            modes); Barbic and James, ACM Trans. Graph. 24 (2005) 982
"""

from dataclasses import dataclass
from functools import partial
from itertools import combinations_with_replacement

import numpy as np

from .baseline import px_per_metre
from .body import Body
from .channels import Channels
from .data import ElasticModel, replace
from .elasticity import static
from .law import TimeFit
from .listen import listen_from
from .nonlinear import internal_force, is_nonlinear, strain_points
from .residual import EVIDENCE, QUIET
from .settle import Recorded
from .side_by_side import side_by_side

MOST = 3  # computed modes whose products count
FAINT = 0.05  # of the strongest one's motion, rms: what moves less makes no arc
ALIKE = 0.05  # of the clearest shape: what the channels hardly see apart is not told apart
ROUNDS = 3  # in which what goes aside no longer counts as swing
BEND = 1e-3  # of the body's length, by which it is bent for the second degree of its force
STIFF = 3.0  # times the mean pitch of the two that swing, below which a mode follows late
SEEN = 0.1  # of the noise, that a swing squared over the body's length is, from which arcs show
NEARLY = 0.4  # relative, that arcs may be larger or smaller than computed
SHARE = 0.025  # of what is left beyond noise, below which what else acts may look so by chance


@dataclass(frozen=True, eq=False)
class Arcs:
    """How the swings of some of a body's modes, and the products of these, move its points."""

    body: Body
    shapes: np.ndarray  # (P, 3, n) per unit of a mode
    pairs: tuple[tuple[int, int], ...]  # q of these modes
    aside: np.ndarray  # (P, 3, q) per unit of their product

    def of(self, data: Channels, rest: np.ndarray) -> np.ndarray:
        """(T, C) how far the channels of a take that come to `rest` (C,) go aside, by what they do
        in each frame.
        """
        seen, aside = (self.body.seen(data, one) for one in (self.shapes, self.aside))
        away = data.values - rest
        swings, out = _read(seen, data), np.zeros_like(away)
        for _ in range(ROUNDS):
            u = swings(away - out)
            out = np.stack([u[:, j] * u[:, k] for j, k in self.pairs], axis=1) @ aside
        return out


def _read(seen: np.ndarray, data: Channels):
    """((T, C) -> (T, n)) modes seen as (n, C), read off the channels that each frame has."""
    on = data.known & ~data.support
    patterns, of = np.unique(on, axis=0, return_inverse=True)
    inverses = [np.linalg.pinv(seen * row, rcond=ALIKE) for row in patterns]
    of = of.reshape(-1)

    def swings(away: np.ndarray) -> np.ndarray:
        out = np.empty((len(away), len(seen)))
        for n, inverse in enumerate(inverses):
            out[of == n] = np.where(patterns[n], away[of == n], 0.0) @ inverse
        return out

    return swings


def off_arcs(ground: Recorded, takes: tuple, free: TimeFit, turn: np.ndarray | None) -> Recorded:
    """The takes, heard anew, as they would be seen if all markers went straight; as they were where
    those that are fitted do not go on arcs as large as those of the body that is computed.

    takes: the same as they were fitted, `free`. turn (m, K): computed modes turned to measured.
    """
    body = ground.bodies[ground.condition[ground.fitted[0]]]
    if turn is None or free.chi2 < QUIET * free.samples:
        return ground
    rests = [np.nanmean(data.values, axis=0) for data in takes]
    for n, index in enumerate(ground.fitted):
        rests[index] = free.rest(n)
    fitted = [(takes[i], rests[i]) for i in ground.fitted]
    if not is_nonlinear(body.model) or not any(_may_show(body, *one) for one in fitted):
        return ground
    arcs = _arcs(body, fitted, turn)
    aside = [arcs.of(*one) for one in zip(takes, rests, strict=True)]
    if not _shows([aside[i] for i in ground.fitted], free):
        return ground
    plain = [_less(*one) for one in zip(ground.takes, aside, strict=True)]
    pairs = side_by_side([
        partial(listen_from, data, ring, data.time[0])
        for data, ring in zip(plain, ground.rings, strict=True)
    ])  # fmt: skip
    return replace(
        ground, takes=tuple(data for data, _ in pairs), rings=tuple(ring for _, ring in pairs)
    )


def _less(data: Channels, aside: np.ndarray) -> Channels:
    moves = [np.nansum(np.nanvar(one[:, ~data.support], axis=0)) for one in (aside, data.values)]
    share = np.sqrt(moves[0] / max(moves[1], 1e-300))
    return replace(data, values=data.values - aside, arcs=float(share))


def _may_show(body: Body, data: Channels, rest: np.ndarray) -> bool:
    on = ~data.support
    far = np.nanmax(np.abs(data.values - rest)[:, on])
    length = np.ptp(body.model.points, axis=0).max() * px_per_metre(data, on)
    return bool(far**2 / length > SEEN * np.median(data.sigma[on]))


def _arcs(body: Body, takes: list, turn: np.ndarray) -> Arcs:
    """Of the computed modes that were heard, the loudest in any of the takes (data, rest)."""
    modes = body.modes
    heard = np.flatnonzero(np.abs(turn).max(axis=1) > 0)
    moves = 0.0
    for data, rest in takes:
        seen = body.seen(data, modes.shapes[:, :, heard])
        u = _read(seen, data)(data.values - rest)
        moves = np.maximum(moves, u.std(axis=0) * np.linalg.norm(seen, axis=1))
    which = heard[loudest(moves)]
    shapes = modes.shapes[:, :, which]
    return Arcs(body, shapes, *aside_of(body, shapes, modes.frequency[which]))


def loudest(moves: np.ndarray) -> np.ndarray:
    """Which of the modes that move so much (n,) make arcs, the loudest first."""
    order = np.argsort(-moves, kind="stable")[:MOST]
    return order[moves[order] > FAINT * moves.max()]


def aside_of(body: Body, shapes: np.ndarray, pitch: np.ndarray) -> tuple[tuple, np.ndarray]:
    """Which two of a body's modes (P, 3, n), of pitches (n,) Hz at 1 Pa, q times, by their places
    among these; and how far the products of their swings move the points (P, 3, q).

    Modes that lie not far above the two follow a force of twice their pitch, or of none, otherwise
    than at once: what these do is left out. Raises DataError for an element without a nonlinear
    form.
    """
    frequency = body.modes.frequency
    pairs, force = _second_degree(body.model, shapes)
    each = body.modes.shapes.reshape(len(force), -1)
    late = (each.T @ force) / ((2 * np.pi * frequency) ** 2)[:, None]
    mean = np.array([(pitch[j] + pitch[k]) / 2 for j, k in pairs])
    late[frequency[:, None] > STIFF * mean] = 0.0
    aside = static(body.model, -force, 1.0) + (each @ late).reshape(len(shapes), 3, -1)
    return pairs, aside


def _second_degree(model: ElasticModel, shapes: np.ndarray) -> tuple[tuple, np.ndarray]:
    """Which two of the modes (P, 3, n); and (3P, q) N at 1 Pa, what goes with the product of each
    two in the body's inner force.
    """
    parts, nu = strain_points(model), model.material.poisson_ratio
    moduli = 1 / (2 * (1 + nu)), 1 / (3 * (1 - 2 * nu))
    length = np.ptp(model.points, axis=0).max()
    each = shapes.reshape(-1, shapes.shape[2])

    def even(u):
        size = BEND * length / np.abs(u).max()
        both = (internal_force(parts, moduli, way * size * u) for way in (1, -1))
        return sum(both) / (2 * size**2)

    pairs = tuple(combinations_with_replacement(range(each.shape[1]), 2))
    own = [even(u) for u in each.T]
    force = [
        own[j] if j == k else even(each[:, j] + each[:, k]) - own[j] - own[k] for j, k in pairs
    ]
    return pairs, np.stack(force, axis=1)


def _shows(arcs: list, free: TimeFit) -> bool:
    """Whether what a fit leaves across its modes' shapes is much less without the `arcs` of its
    takes, and these are nearly as large as what is left says. Along those shapes everything moves
    that acts on the body.
    """
    size = told = left = count = 0.0
    for n, aside in enumerate(arcs):
        data = free.law.takes[free.law.fitted[n]]
        on, known = ~data.support, data.known & data.fit[:, None]
        q, _ = np.linalg.qr((free.shapes_of(n)[:, on] / data.sigma[on]).T)
        across = []
        for one in (aside, free.missed(n)):
            one = np.where(known, one, np.nan)[:, on] / data.sigma[on]
            one = np.nan_to_num(one - np.nanmean(one, axis=0))
            across.append(one - (one @ q) @ q.T)
        size += (across[0] ** 2).sum()
        told += (across[0] * across[1]).sum()
        left += (across[1] ** 2).sum()
        count += known[:, on].sum() * (1 - q.shape[1] / on.sum())
    gain = 2 * told - size
    noise = max((left - gain) / max(count, 1.0), 1.0)
    large = gain > max(EVIDENCE * noise, SHARE * (left - count))
    return bool(large and abs(told / max(size, 1e-300) - 1) < NEARLY)
