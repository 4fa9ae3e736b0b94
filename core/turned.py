"""What takes of an object turned over say of its weight: hanging it is stiffer, standing softer,
and it sags the other way.

Source      Bathe, Finite Element Procedures (1996), 6.2: the initial stress is linear in the load
"""

import numpy as np

from .body import build_body
from .data import Take
from .errors import DataError
from .joint import Heard
from .law import TimeFit
from .parameters import inflation

FLOOR = 0.001  # relative error of a shift of pitch that no fit sees: a warmer room, another hold
UNSURE = 0.1  # of a computed shift
ALIKE = 0.005  # of a pitch, and so nearly of a sag, up to which the weight changes no stiffness


def weighs(heard: Heard, found: TimeFit, modulus: float) -> float:
    """Gain in chi2 of the body whose weight is in its stiffness, at that Young's modulus (Pa), over
    one that rings alike whichever way up it is; 0 where no take shows it another way up.
    """
    law, takes, gain = found.law, heard.body.case.takes, 0.0
    for i in turned(heard, found).values():
        shift, error = shift_of(found, law.fitted.index(i))
        foretold = _foretold(heard, takes[law.fitted[0]], takes[i], modulus)
        if foretold is None:
            continue
        error = error + (UNSURE * foretold) ** 2
        gain += float(((shift**2 - (shift - foretold) ** 2) / error).sum())
    return gain


def shift_of(found: TimeFit, take: int) -> tuple[np.ndarray, np.ndarray]:
    """(K,) logarithm of the pitches in the fitted take of that number over those in the first one,
    and (K,) its variance, with what no fit sees.
    """
    law, K = found.law, found.law.modes
    own, other = (2 * K * law.pitch[law.fitted[n]] + np.arange(K) for n in (0, take))
    spread = np.maximum(np.diag(found.covariance), 0.0) * inflation(found)
    shift = found.parameters[other] - found.parameters[own]
    return shift, spread[other] + spread[own] + FLOOR**2


def turned(heard: Heard, found: TimeFit) -> dict[int, int]:
    """Of the fitted takes that show the object another way up than the first does, the first one
    of each set of pitches: its number, by that of the set.
    """
    law, takes, first = found.law, heard.body.case.takes, found.law.fitted[0]
    seen = {}
    for i in law.fitted:
        if law.pitch[i] != law.pitch[first] and _is_turned(takes[i], takes[first]):
            seen.setdefault(law.pitch[i], i)
    return seen


def all_turned(heard: Heard, found: TimeFit) -> list[int]:
    """Numbers of all takes with one of these sets of pitches."""
    law, seen = found.law, turned(heard, found)
    return [i for i in law.fitted if law.pitch[i] in seen]


def sag_between(found: TimeFit) -> np.ndarray | None:
    """(C,) how far the weight moves the channels, as half of what lies between their places in the
    first fitted take and in one of the object turned right over, where no shape that was drawn and
    no marker's place counts; None where there is none, or where it rings otherwise: there its
    weight stiffens it one way and softens it the other, and it sags less and more.
    """
    law = found.law
    takes = [law.takes[i].take for i in law.fitted]
    for n, other in enumerate(takes):
        over = _is_turned(other, takes[0]) and np.allclose(other.gravity, -takes[0].gravity)
        if over and abs(np.log(found.pitches(n) / found.pitches(0))[found.loudest]) < ALIKE:
            return (found.rest() - found.rest(n)) / 2
    return None


def _is_turned(one: Take, other: Take) -> bool:
    if one.gravity is None or other.gravity is None or len(one.loads) or len(other.loads):
        return False
    return not np.allclose(one.gravity, other.gravity)


def _foretold(heard: Heard, one: Take, other: Take, modulus: float) -> np.ndarray | None:
    """(K,) logarithm of each matched mode's pitch in the other take over that in the one; None
    where so soft a body would not stand, or a mode is not matched.
    """
    body = heard.body
    if None in heard.match.modes:
        return None
    try:
        upright, over = (build_body(body.case, body.bare, take, modulus) for take in (one, other))
    except DataError:
        return None
    plain = body.modes.shapes[:, :, list(heard.match.modes)].reshape(-1, len(heard.match.modes))
    moved = body.bare.mass @ plain
    pitches = []
    for turned in (upright, over):  # which mode it has become
        alike = np.abs(turned.modes.shapes.reshape(len(plain), -1).T @ moved)
        pitches.append(turned.modes.frequency[alike.argmax(axis=0)])
    return np.log(pitches[1] / pitches[0])
