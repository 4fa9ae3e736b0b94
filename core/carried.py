"""What goes on beside the ring-down, and is felt by the forces too.

A rub, a drag or a stiffening acts on all of the motion: beside a strong steady line a rub stops the
body no longer, and a drag damps it as a dashpot does; a stiffening about a place to which the body
still creeps is another one on either side. What an effect makes the body do is linear, with shapes
of its own; what that makes a force do more is marched with the ring-down.
"""

from dataclasses import replace

from .effects.base import Carried
from .law import TimeFit
from .timefit import fit

LOOKS = 10  # of a fit with forces, from where it stood when they felt less
HORIZONS = (0.15, 0.3, 0.6, 1.0)  # shares of the fitted part, where on all of it a phase slips


def carrying(found: TimeFit) -> TimeFit:
    """The fit whose forces, and those to come, feel what its effects make the modes do; as it was,
    where that leaves more.
    """
    law = found.law
    some = [(i, effect) for i, effect in enumerate(law.effects) if effect.carries]
    if not some:
        return found
    carried = tuple(
        Carried([effect.carries(found, i, take) for i, effect in some])
        for take in range(len(law.fitted))
    )
    law = replace(law, setting=replace(law.setting, carried=carried))
    if not any(e.marched for e in law.effects):
        return replace(found, law=law)
    felt = fit(law, found.parameters, evaluations=LOOKS)
    if felt.chi2 > found.chi2:
        felt = fit(law, found.parameters, HORIZONS, LOOKS)
    return min(found, felt, key=lambda one: one.chi2)
