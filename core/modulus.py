"""Young's modulus that a recording tells: of this mesh (apparent) and of the stuff (material)."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from .camera_layer import true_frequency
from .dac import apparent, material, scattered
from .data import Estimate, replace
from .effects import split_modes
from .findings import Findings
from .joint import Heard
from .law import TimeFit
from .match import likeness
from .parameters import inflation
from .twins import twins_span
from .verdict import Verdict
from .weight import elastic_share, moduli

CLEARLY = 0.8  # MAC from which a shape is clearly a computed one's


@dataclass(frozen=True)
class Told:
    """Young's modulus of the body as it was found to be."""

    apparent: Estimate
    material: Estimate
    without: float  # Pa, material, with none of the found effects
    pitches: np.ndarray  # (m,) Hz of the computed modes with that apparent modulus


def young(
    heard: Heard, verdict: Verdict, findings: Findings, stiff: np.ndarray, sigma: np.ndarray
) -> Told:
    """By the pitch of the loudest mode; where the body carries its weight, by those of all.

    stiff, sigma (m,): as `stiffening` gives them.
    """
    final, first = verdict.final, verdict.chain[0][1]
    k = int(np.argmax(final.swings))
    j = heard.match.modes[k] if heard.match.modes[k] is not None else 0
    clear = [(k, j), *((n, m) for n, m in _clear(heard, final) if n != k)]
    share, own = elastic_share(heard.body), heard.body.modes.frequency
    mesh = np.array([findings.mesh_frequency(f, m) for m, f in enumerate(own)])
    pitch = true_frequency(heard, final) / np.sqrt(findings.stiffer)
    pair = final.law.setting.pair
    pitch[pair] *= split_modes.middle(final)
    if heard.body.carried:
        found, real = _of_all(heard, final, pitch, mesh, clear, (share, stiff, sigma))
        plain = true_frequency(heard, first)
        bare = _of_all(heard, first, plain, own, clear, (share, stiff, sigma))[1]
    else:
        spread = np.sqrt(final.covariance[k, k] * inflation(final))
        spread = np.hypot(spread, split_modes.doubt(final)) if k == pair else spread
        found, real = apparent(pitch[k], pitch[k] * spread, mesh[j]), None
        bare = apparent(true_frequency(heard, first)[k], 0.0, own[j])
        bare = material(bare, stiff[j], sigma[j])
    less, more = findings.modulus_span(j) * np.array(
        twins_span(verdict, k, partial(true_frequency, heard))
    )
    less *= findings.stiffer / findings.stiffest
    found = replace(found, low=found.low * less, high=found.high * more)
    if findings.doubtful:  # any mode's own may be as right
        alone = [(pitch[n] / own[m]) ** 2 for n, m in _clear(heard, final)]
        found = replace(found, low=min([found.low, *alone]), high=max([found.high, *alone]))
    if real is None:
        ks, js = np.transpose(clear)
        form = scattered((pitch[ks] / mesh[js]) ** 2 * (1 + stiff[js]), 0)
        real = material(found, stiff[j], np.hypot(sigma[j], (1 + stiff[j]) * form))
    else:
        real = replace(real, low=real.low * less, high=real.high * more)
    heavy = (heard.body.carried or 0.0) * (1 - share)  # no modulus changes it
    pitches = mesh * np.sqrt(findings.stiffer * (share * found.value + heavy))
    return Told(found, real, bare.value, pitches)


def _clear(heard: Heard, found: TimeFit) -> list[tuple[int, int]]:
    """Modes, and the computed ones whose shape they clearly have."""
    body = heard.body
    seen = body.seen(found.law.takes[found.law.fitted[0]])
    return [
        (k, j)
        for k, j in enumerate(heard.match.modes)
        if j is not None and likeness(found.shapes[k], seen, body.modes.frequency, j) > CLEARLY
    ]


def _of_all(heard, found, pitch, mesh, clear, each) -> tuple[Estimate, Estimate]:
    """As `moduli`, of the modes and computed ones of `clear`.

    pitch (K,) Hz, mesh (m,) Hz at 1 Pa; each: (m,) elastic shares, and what the mesh stiffens.
    """
    ks, js = np.transpose(clear)
    spread = 2 * np.sqrt(np.maximum(np.diag(found.covariance)[ks], 0) * inflation(found))
    share, *stiff = (one[js] for one in each)
    return moduli(heard.body.carried, share, (pitch[ks] / mesh[js]) ** 2, spread, *stiff)
