"""Young's modulus that a recording tells: of this mesh (apparent) and of the stuff (material)."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from .camera_layer import true_frequency
from .compare import PITCH_FLOOR
from .dac import apparent, material, scattered
from .data import Estimate, replace
from .effects import split_modes
from .findings import Findings
from .joint import Heard
from .law import TimeFit
from .match import likeness
from .parameters import inflation
from .twins import bent, handed_on, twins_span
from .verdict import Verdict
from .weight import Tells, each_modulus, elastic_share, modulus_of_all

CLEARLY = 0.8  # MAC from which a shape is clearly a computed one's


@dataclass(frozen=True)
class Told:
    """Young's modulus of the body as it was found to be."""

    apparent: Estimate
    material: Estimate
    without: float  # Pa, material, with none of the found effects
    pitches: np.ndarray  # (m,) Hz of the computed modes with that apparent modulus, or NaN


def find_modulus(heard: Heard, verdict: Verdict, findings: Findings, mesh: tuple) -> Told:
    """By the loudest mode, or one that an uneven stiffness bends less; where the body carries its
    weight, by all that are clearly the body's.

    mesh: two of (m,), as `stiffening` gives them.
    """
    final, first = verdict.final, verdict.chain[0][1]
    clear = _clear(heard, final)
    k = _least_bent(final, true_frequency(heard, final), clear, mesh[1])
    j = heard.match.modes[k] if heard.match.modes[k] is not None else 0
    clear = [(k, j), *((n, i) for n, i in clear if n != k)]
    carried, own = heard.body.carried or 0.0, heard.body.modes.frequency
    changed = np.array([findings.mesh_frequency(f, i) for i, f in enumerate(own)])
    tells = _tells(heard, final, changed * np.sqrt(findings.stiffer), clear, mesh)
    plain = _tells(heard, first, own, clear, mesh)
    span = np.array(twins_span(verdict, k, partial(true_frequency, heard)))
    span *= findings.modulus_span(j)
    span *= findings.stiffer / np.array([findings.stiffest, findings.least_stiff])
    if heard.body.carried:
        found, real = modulus_of_all(carried, tells)
        span **= tells.share.sum() / (tells.share**2).sum()  # a pitch's moves the modulus more
        bare = modulus_of_all(carried, plain)[1].value
    else:
        form = scattered(each_modulus(carried, tells)[1], tells.sigma, 0)
        found, real = (_of_first(tells, part) for part in (None, form))
        bare = each_modulus(carried, plain)[1, 0]
    found, real = (replace(e, low=e.low * span[0], high=e.high * span[1]) for e in (found, real))
    if findings.doubtful:  # any mode's own may be as right
        at_first = replace(tells, over=_tells(heard, final, own, clear, mesh).over)
        alone = each_modulus(carried, at_first)
        found, real = (
            replace(e, low=np.nanmin([e.low, *each]), high=np.nanmax([e.high, *each]))
            for e, each in zip((found, real), alone, strict=True)
        )
    share = elastic_share(heard.body)
    square = findings.stiffer * (share * found.value + carried * (1 - share))
    pitches = changed * np.sqrt(np.where(square > 0, square, np.nan))
    return Told(found, real, float(bare), pitches)


def _least_bent(final: TimeFit, true: np.ndarray, clear: list, doubt: np.ndarray) -> int:
    """The loudest mode, or, where an uneven stiffness bends its pitch more than it is off anyhow,
    the one of the `clear` modes whose pitch is the surest.

    true: (K,) Hz. doubt: (m,) of the mesh's eigenvalues, relative.
    """
    loudest, bend = final.loudest, bent(final) * handed_on(true)
    other = np.hypot(PITCH_FLOOR, _spread(final))
    for k, j in clear:
        other[k] = np.hypot(other[k], doubt[j] / 2)
    if bend[loudest] <= other[loudest]:
        return loudest
    error = np.hypot(bend, other)
    return min([loudest, *(k for k, _ in clear)], key=lambda k: error[k])


def _spread(found: TimeFit) -> np.ndarray:
    """(K,) relative standard deviation of every pitch as it was seen."""
    pair, variance = found.law.setting.pair, np.diag(found.covariance)[: len(found.frequency)]
    spread = np.sqrt(np.maximum(variance, 0) * inflation(found))
    spread[pair] = np.hypot(spread[pair], split_modes.doubt(found))
    return spread


def _of_first(tells: Tells, form: float | None) -> Estimate:
    """The modulus that the first of the modes tells: apparent, or material with the error `form`
    of the body's shape.
    """
    found = apparent(np.sqrt(tells.over[0]), np.sqrt(tells.over[0]) * tells.sigma[0] / 2, 1.0)
    if form is None:
        return found
    stiff = tells.stiff[0]
    return material(found, stiff, np.hypot(tells.stiff_sigma[0], (1 + stiff) * form))


def _clear(heard: Heard, found: TimeFit) -> list[tuple[int, int]]:
    """Modes, and the computed ones whose shape they clearly have."""
    body = heard.body
    seen = body.seen(found.law.takes[found.law.fitted[0]])
    return [
        (k, j)
        for k, j in enumerate(heard.match.modes)
        if j is not None and likeness(found.shapes[k], seen, body.modes.frequency, j) > CLEARLY
    ]


def _tells(heard: Heard, found: TimeFit, computed: np.ndarray, clear: list, mesh: tuple) -> Tells:
    """What the measured modes say beside the `computed` ones (m,), Hz at 1 Pa, that `clear` pairs
    with them; of a pair that is split, its middle.
    """
    ks, js = np.transpose(clear)
    true, pair = true_frequency(heard, found), found.law.setting.pair
    spread = _spread(found) * found.frequency / true  # a fold leaves it as it is in Hz
    true[pair] *= split_modes.middle(found)
    over = (true[ks] / computed[js]) ** 2
    return Tells(elastic_share(heard.body)[js], over, 2 * spread[ks], *(one[js] for one in mesh))
