"""A body that is declared to be stiffened or softened by its own weight: with which modulus.

The weight's stress does not depend on Young's modulus, the elastic stiffness does, so how much
the one counts beside the other is known only with the modulus that the recording gives.
"""

from collections.abc import Callable

import numpy as np

from .body import Body, build_body
from .effects.gravity_preload import EFFECT, weight_stiffness
from .joint import Heard

SAME = 0.005  # relative: a modulus that changes by less is found
ROUNDS = 3
SCAN = np.geomspace(1e2, 1e10, 241)  # Pa


def carries_weight(body: Body) -> bool:
    """Whether the case declares that its weight changes its stiffness, and says where down is."""
    case = body.case
    return EFFECT.name in case.declared and case.takes[0].gravity is not None


def with_weight(body: Body, hear: Callable[[Body], Heard]) -> Heard:
    """What is heard of `body` (without its weight) once its weight is in its stiffness.

    Which computed mode is heard, and the modulus, follow from each other; itself where no modulus
    gives the pitch that was heard.
    """
    heard = hear(body)
    for _ in range(ROUNDS):
        modulus = _modulus(body, heard)
        known = heard.body.carried
        if modulus is None or (known and abs(np.log(modulus / known)) < SAME):
            break
        heard = hear(build_body(body.case, body.bare, body.case.takes[0], modulus))
    return heard


def _modulus(body: Body, heard: Heard) -> float | None:
    """Pa with which the mode that was heard first has its pitch, the weight counted in.

    In the modes of the body without its weight.
    """
    mode = heard.match.modes[0]
    if mode is None:
        return None
    basis = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    K = np.diag((2 * np.pi * body.modes.frequency) ** 2)
    G = basis.T @ (weight_stiffness(body.model, body.case.takes[0].gravity) @ basis)
    wanted = basis.T @ (body.model.mass @ heard.body.modes.shapes[:, :, mode].ravel())

    def beyond(modulus: float) -> float:
        values, vectors = np.linalg.eigh(modulus * K + G)
        alike = (vectors.T @ wanted) ** 2
        return values[np.argmax(alike)] - (2 * np.pi * heard.free.frequency[0]) ** 2

    signs = np.sign([beyond(modulus) for modulus in SCAN])
    crossings = np.flatnonzero((signs[:-1] < 0) & (signs[1:] > 0))
    if not len(crossings):
        return None
    low, high = np.log(SCAN[crossings[-1]]), np.log(SCAN[crossings[-1] + 1])
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (low, middle) if beyond(np.exp(middle)) > 0 else (middle, high)
    return float(np.exp((low + high) / 2))
