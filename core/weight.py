"""A body that is declared to be stiffened or softened by its own weight: with which modulus.

Law         w^2 = Y k + g, k the elastic and g the weight's stiffness in a mode's shape
Source      Rayleigh, The Theory of Sound, vol. 1, 88: a shape that is a little off is off in the
            second order, so that the modulus converges with the shape
"""

from collections.abc import Callable

import numpy as np

from .body import Body, build_body
from .effects.gravity_preload import EFFECT, weight_stiffness
from .errors import DataError
from .joint import Heard

SAME = 0.003  # relative: a modulus that changes by less is found
ROUNDS = 5
STIFFER = 1.3  # times: a body that would buckle under its weight is at least so much stiffer
TRIES = 30  # a body that does not stand even then has another fault, which its refusal tells


def carries_weight(body: Body) -> bool:
    """Whether the case declares that its weight changes its stiffness, and says where down is."""
    case = body.case
    return EFFECT.name in case.declared and case.takes[0].gravity is not None


def with_weight(body: Body, hear: Callable[[Body], Heard]) -> Heard:
    """What is heard of `body` (without its weight) once its weight is in its stiffness.

    The weight's stress does not depend on Young's modulus and the elastic stiffness does, so how
    much the one counts is known only with the modulus that the recording gives. What is heard of
    the body without its weight where no modulus gives the pitch that was heard.
    """
    weight = weight_stiffness(body.model, body.case.takes[0].gravity)
    plain = heard = hear(body)
    for _ in range(ROUNDS):
        modulus = _modulus(body, weight, heard)
        if modulus is None:
            return plain
        known = heard.body.carried
        if known and abs(np.log(modulus / known)) < SAME:
            break
        heard = hear(_standing(body, modulus, heard.body.seats))
    return heard


def _modulus(body: Body, weight, heard: Heard) -> float | None:
    """Pa with which the mode that was heard first has its pitch, moving as it does now."""
    mode = heard.match.modes[0]
    if mode is None:
        return None
    shape = heard.body.modes.shapes[:, :, mode].ravel()
    elastic, heavy = shape @ (body.model.stiffness @ shape), shape @ (weight @ shape)
    modulus = ((2 * np.pi * heard.free.frequency[0]) ** 2 - heavy) / elastic
    return float(modulus) if modulus > 0 else None


def _standing(body: Body, modulus: float, seats: tuple) -> Body:
    """The body with its weight, with that modulus or the least one with which it stands.

    seats: how its loads sit, and how else they may.

    Raises DataError as `build_body` does, where none is enough.
    """
    for _ in range(TRIES):
        try:
            return build_body(body.case, body.bare, body.case.takes[0], modulus, seats)
        except DataError:
            modulus *= STIFFER
    return build_body(body.case, body.bare, body.case.takes[0], modulus, seats)
