"""How a declared load sits: a case says where it is, and never how wide or how far over an edge,
nor whether it hangs there.

Law         M + Σ m NᵀN, N the mean motion of a patch; the patch is what is chosen
            one that hangs on a thread goes along with gravity's direction only: M + Σ m Nᵀd dᵀN
Looks like  pitches of the loaded body whose ratios no modulus mends: under a load at a rim the body
            gives way the more the narrower the load sits, and a pair is parted the more
Twins       a load of another mass, where few pitches are heard: then it sits as it was assumed to
Source      Johnson, Contact Mechanics, ch. 3; Craig and Kurdila, Fundamentals of Structural
            Dynamics, ch. 17 (residual attachment modes)
"""

import numpy as np
from scipy.linalg import block_diag, eigh
from scipy.optimize import linear_sum_assignment

from .body import Body, build_body
from .data import Modes, Take, replace
from .elasticity import HUNG, PLAIN, UNKNOWN, Seat, buried, load_operator, lump_radius
from .errors import DataError
from .factorization import factorize
from .match import match_modes, true_pitches
from .pursuit import pursue
from .settle import Recorded

SEATS = (
    PLAIN,
    *(Seat(width, True) for width in (0.5, 1.5, 2.0, 3.0)),
    *(Seat(width, False) for width in (1.0, 1.25, 1.5, 2.0)),
)
PITCHES = 4  # heard under loads, at least: nine seats and a modulus mend any three
LOUD = 0.02  # of the motion, that a pole takes whose pitch is asked
MOST = 0.1  # that a pitch counts as off, where none computed is near
OFF = 0.001  # that pitches are off in the mean, less than which asks for no other seat
TOLD = 0.005  # the same, more than which no seat is told: something else is the matter
BETTER = 0.5  # of how far off they were, at most, that they are with another seat
NARROW = 0.2  # of the radius of a ball of that mass: the narrowest foot that a load may have
ACROSS = 0.15  # that a pitch is off under loads that are fixed, from which they may hang: no other
# seat does so much
MENDED = 0.25  # of that, at most, that pitches are off under loads that hang
GIVES = 16 / (3 * np.pi**2)  # mean displacement under an even load on a disc, over F/(E r)


def seated(ground: Recorded, rings: tuple) -> Recorded:
    """The same takes of bodies on which loads sit as the pitches ask for, where these tell.

    What sits nearly as well is kept beside it, for the error of what is computed.
    """
    asked = {ground.condition[i]: i for i in reversed(ground.fitted)}
    laden = [c for c, i in asked.items() if ground.takes[i].take.loads]
    if not laden or any(b.seats != UNKNOWN for b in ground.bodies):
        return ground
    takes = {c: data.take for c, data in zip(ground.condition, ground.takes, strict=True)}
    try:
        off = _heard_pitches(ground, rings, asked)
        hung = off.pop(HUNG[0])
        may_hang = all(_is_pulled(take) for take in takes.values() if take.loads)
        hanging = may_hang and hang(off[PLAIN], hung, laden)
        seats = HUNG if hanging else told_by_pitches(off, laden)
        if seats is None:
            return ground
        bodies = [
            build_body(body.case, body.bare, takes[c], body.carried, seats)
            if takes[c].loads
            else body
            for c, body in enumerate(ground.bodies)
        ]
    except DataError:  # on another seat it would not bear its own weight
        return ground
    return replace(ground, bodies=tuple(bodies))


def told_by_pitches(off: dict[Seat, dict], laden: list[int]) -> tuple[Seat, ...] | None:
    """The seat with which the pitches are right, and those that do nearly as well; None where the
    assumed one does, or none does.

    off: per seat and pole, by its condition and its place in the ring-down, how much of the motion
    the pole takes and the logarithm of its pitch over the computed one, whatever the modulus; a
    pole that no computed mode is like is not there. laden: the conditions with loads.
    """
    gains = {p: gain for told in off.values() for p, (gain, _) in told.items() if gain > LOUD}
    if sum(c in laden for c, _ in gains) < PITCHES:
        return None
    wrong = {seat: _astray(gains, told) for seat, told in off.items()}
    order = sorted(wrong, key=wrong.get)
    least = wrong[order[0]]
    if least > TOLD or wrong[PLAIN] < max(OFF, least / BETTER):
        return None
    return tuple(s for k, s in enumerate(order) if k < 2 or wrong[s] < least + OFF)


def hang(fixed: dict, hung: dict, laden: list[int]) -> bool:
    """Whether loads hang: under fixed ones some loud pitch is far off beside the loudest one, and
    under loads that hang none is by more than a part of that.

    fixed, hung: what `told_by_pitches` has of one seat; laden: the conditions with loads.
    """
    known = [pole for pole, (gain, _) in fixed.items() if gain > LOUD and pole[0] in laden]
    if not known or any(pole not in hung for pole in known):
        return False
    loudest = max(known, key=lambda pole: hung[pole][0])
    far, near = (
        max(abs(told[pole][1] - told[loudest][1]) for pole in known) for told in (fixed, hung)
    )
    return far > ACROSS and near < MENDED * far


def _is_pulled(take: Take) -> bool:
    """Whether something hangs a known way there."""
    return take.gravity is not None and bool(np.any(take.gravity))


def on_narrow_feet(body: Body, take: Take) -> np.ndarray:
    """|λ'/λ - 1| (m,) of the body's modes where each load of the take stands on a foot too narrow
    for a mesh.

    Under it the body gives way more, as a spring would: (1 + ν)(1 - ν/2) F/(E r) sideways, less
    along the normal (Johnson, 3.4 and 3.6, the mean over a disc). How it rocks there is left out,
    and what lies deep inside stands on no foot.
    """
    shapes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    square = (2 * np.pi * body.modes.frequency) ** 2
    count, nu = len(square), body.case.material.poisson_ratio
    K, M, own = np.diag(square), np.eye(count), np.eye(count)
    for load in take.loads:
        radius = lump_radius(load.mass)
        if buried(body.model, load.position[None], radius)[0]:
            continue
        give = GIVES * (1 + nu) * (1 - nu / 2) * (1 / (NARROW * radius) - 1 / radius)  # m/N at 1 Pa
        moved = load_operator(body.model, load, body.seats[0], take.gravity) @ shapes  # (n, m)
        M[:count, :count] -= load.mass * moved.T @ moved
        ways = np.eye(len(moved))
        stretch = np.hstack([moved, np.zeros((len(moved), len(K) - count)), -ways])
        K = block_diag(K, 0 * ways) + stretch.T @ stretch / give
        M = block_diag(M, load.mass * ways)
        own = np.vstack([own, moved])
    found, turn = eigh(K, M)
    modes, others = linear_sum_assignment(-((own.T @ M @ turn) ** 2))
    return np.abs(found[others] / square[modes] - 1)


def _astray(gains: dict, told: dict) -> float:
    """How far the pitches are off in the mean, with the modulus that mends most of them."""
    known = sorted((told[p][1], gain) for p, gain in gains.items() if p in told)
    if not known:
        return MOST
    log, weight = np.array(known).T
    middle = log[np.searchsorted(np.cumsum(weight), weight.sum() / 2)]
    lost = sum(gains.values()) - weight.sum()
    off = (weight * np.minimum(np.abs(log - middle), MOST)).sum() + lost * MOST
    return float(off / sum(gains.values()))


def _heard_pitches(ground: Recorded, rings: tuple, asked: dict[int, int]) -> dict[Seat, dict]:
    """What `told_by_pitches` and `hang` ask for."""
    out = {seat: {} for seat in (*SEATS, HUNG[0])}
    for c, i in asked.items():
        data, ring, body = ground.takes[i], rings[i], ground.bodies[c]
        fitted = data.fit
        chase = pursue(ring, data.time[fitted], data.values[fitted], data.sigma, late=data.late)
        gain = dict(zip(chase[0], chase[2], strict=True))
        modes = on_seats(body, data.take) if data.take.loads else {}
        for seat, told in out.items():
            own = modes.get(seat, body.modes)
            seen = body.seen(data, own.shapes)
            match = match_modes(ring, chase, own.frequency, seen, 1 / data.frame, pairs=body.pairs)
            heard = ring.frequency[list(match.poles)]
            true = true_pitches(heard, match.modes, own.frequency, 1 / data.frame)
            told |= {
                (c, p): (gain[p], float(np.log(f / own.frequency[j])))
                for p, j, f in zip(match.poles, match.modes, true, strict=True)
                if j is not None
            }
    return out


def on_seats(body: Body, take: Take) -> dict[Seat, Modes]:
    """The body's lowest modes with the loads of a take on each seat, and where gravity is known
    hanging: its own ones and what gives under the loads span them all.
    """
    model, free, loads = body.model, body.model.free, take.loads
    operators = {
        seat: [load_operator(model, load, seat, take.gravity)[:, free] for load in loads]
        for seat in (*SEATS, *HUNG[: _is_pulled(take)])
    }
    points = np.repeat(model.points, 3, axis=0)[free]
    K = model.stiffness[free][:, free]
    pushes = np.hstack([N.toarray().T for seat in operators.values() for N in seat])
    own = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])[free]
    span, _ = np.linalg.qr(np.hstack([own, factorize(K, points).solve(pushes)]))
    stiff, heavy = span.T @ (K @ span), span.T @ (body.bare.mass[free][:, free] @ span)
    out, count = {}, own.shape[1]
    for seat, each in operators.items():
        pressed = [(load.mass, N @ span) for load, N in zip(loads, each, strict=True)]
        mass = heavy + sum(m * N.T @ N for m, N in pressed)
        squares, turn = (part[..., :count] for part in eigh(stiff, mass))
        shapes = np.zeros((3 * len(model.points), count))
        shapes[free] = span @ turn
        out[seat] = Modes(
            np.sqrt(np.clip(squares, 0, None)) / (2 * np.pi), shapes.reshape(-1, 3, count)
        )
    return out
