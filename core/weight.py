"""A body that is declared to be stiffened or softened by its own weight: with which modulus.

Law         w^2 = Y k + g, k the elastic and g the weight's stiffness in a mode's shape. What a
            pitch or the mesh is off by moves Y the more the less of the stiffness is elastic, so
            all modes tell Y together, each by the square of its elastic share q = Y k / w^2; with
            what modulus the weight is carried, the median of them says, weighted by q
Source      Rayleigh, The Theory of Sound, vol. 1, 88: a shape that is a little off is off in the
            second order, so that the modulus converges with the shape
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .body import Body, build_body
from .camera_layer import true_frequency
from .dac import SURE, blended
from .data import Estimate
from .effects.gravity_preload import EFFECT, weight_stiffness
from .errors import DataError
from .joint import Heard

SAME = 0.003  # relative: a modulus that changes by less is found
ROUNDS = 5
SOFTER, MOST = 0.5, 6  # times, tried where no modulus gives the pitch in a shape; so often at most
LEAST = 0.05  # of a mode's stiffness is elastic, for its pitch to tell a modulus
STIFFER = 1.3  # times: a body that would buckle under its weight is at least so much stiffer
TRIES = 30  # a body that does not stand even then has another fault, which its refusal tells


@dataclass(frozen=True, eq=False)
class Tells:
    """What modes that were heard say of the modulus, each (k,)."""

    share: np.ndarray  # elastic, of the computed stiffness
    over: np.ndarray  # Pa: measured over computed pitch squared, at 1 Pa
    sigma: np.ndarray  # its relative standard deviation
    stiff: np.ndarray  # what the mesh stiffens, relative, and
    stiff_sigma: np.ndarray  # its standard deviation


def carries_weight(body: Body) -> bool:
    """Whether the case declares that its weight changes its stiffness, and says where down is."""
    case = body.case
    return EFFECT.name in case.declared and case.takes[0].gravity is not None


def with_weight(body: Body, hear: Callable[[Body], Heard]) -> Heard:
    """What is heard of `body` (without its weight) once its weight is in its stiffness.

    The weight's stress does not depend on Young's modulus and the elastic stiffness does, so how
    much the one counts is known only with the modulus that the recording gives. What is heard of
    the body without its weight where no modulus gives any of the pitches that were heard, or none
    of its modes is like what was heard first.
    """
    weight = weight_stiffness(body.model, body.case.takes[0].gravity)
    plain, halvings = hear(body), 0
    heard = plain
    for _ in range(ROUNDS + MOST):
        modulus, known = _modulus(body, weight, heard), heard.body.carried
        # a stiffer body's shapes may hold more of the weight's stiffness than the pitches have
        if modulus is None and known is None:
            modulus = _modulus(body, 0 * weight, heard)
        elif modulus is None and halvings < MOST:
            modulus, halvings = SOFTER * known, halvings + 1
        if modulus is None:
            return plain
        if known and abs(np.log(modulus / known)) < SAME:
            break
        heard = hear(_standing(body, modulus, heard.body.seats))
    return heard


def _modulus(body: Body, weight, heard: Heard) -> float | None:
    """Pa with which the modes that were heard have their pitches, moving as they do now: what most
    of them say, for one that something else moves is no guide.
    """
    modes = heard.match.modes
    if None in modes:
        return None
    x = heard.body.modes.shapes.reshape(-1, heard.body.modes.shapes.shape[2])[:, list(modes)]
    elastic, heavy = (
        np.einsum("pk,pk->k", x, matrix @ x) for matrix in (body.model.stiffness, weight)
    )
    square = (2 * np.pi * true_frequency(heard, heard.free)) ** 2
    share, modulus = 1 - heavy / square, (square - heavy) / elastic
    known = share > 0
    if not known.any():
        return None
    order = np.argsort(modulus[known])
    told = np.cumsum(share[known][order])  # the less elastic, the farther off it may be
    return float(modulus[known][order][np.searchsorted(told, told[-1] / 2)])


def elastic_share(body: Body) -> np.ndarray:
    """(m,) of each mode's stiffness, what Young's modulus scales; the rest is the weight's."""
    if body.model.stress is None:
        return np.ones(len(body.modes.frequency))
    x = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    heavy, whole = (
        np.einsum("pm,pm->m", x, matrix @ x) for matrix in (body.model.stress, body.model.stiffness)
    )
    return 1 - heavy / whole


def each_modulus(carried: float, tells: Tells) -> np.ndarray:
    """(2, k) Pa, the apparent and the material modulus that every mode tells by itself; NaN where
    it is hardly elastic. `carried`: with which the body carries its weight.
    """
    own = tells.over - carried * (1 - tells.share)  # `over` is Y share + carried (1 - share)
    with np.errstate(divide="ignore", invalid="ignore"):
        apparent = own / tells.share
        material = apparent * tells.share * (1 + tells.stiff) / _converged(tells)
    known = (tells.share > LEAST) & (own > LEAST * carried) & (_converged(tells) > LEAST)
    return np.where(known, [apparent, material], np.nan)


def _converged(tells: Tells) -> np.ndarray:
    """(k,) elastic share of the converged stiffness: the mesh stiffens nothing of the weight's."""
    return tells.share * (1 + tells.stiff) - tells.stiff


def modulus_of_all(carried: float, tells: Tells) -> tuple[Estimate, Estimate]:
    """Apparent and material modulus of a body that carries its weight with the modulus `carried`.

    From nought up, where no mode is elastic enough to tell one.
    """
    each = each_modulus(carried, tells)
    known = np.isfinite(each[0])
    if not known.any():
        return (Estimate(carried, 0.0, carried / LEAST, "Pa"),) * 2
    share, sigma = tells.share[known], tells.sigma[known] / tells.share[known]
    mesh = (tells.stiff_sigma / (1 + tells.stiff) / _converged(tells))[known]
    weights = share**2 / (share**2).sum()
    out = []
    for logs, error in zip(np.log(each[:, known]), (sigma, np.hypot(sigma, mesh)), strict=True):
        mean = float(weights @ logs)
        common = blended(share**2 @ (logs - mean) ** 2, len(logs) - 1) / np.linalg.norm(share)
        half = SURE * np.hypot(np.linalg.norm(weights * error), common)
        out.append(Estimate(np.exp(mean), np.exp(mean - half), np.exp(mean + half), "Pa"))
    return out[0], out[1]


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
