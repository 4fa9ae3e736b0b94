"""How the modes lose energy, where the case does not say, or says it wrongly."""

import numpy as np

from .effects import DAMPING
from .law import TimeFit, replace
from .residual import EVIDENCE
from .time_layer import Candidate, judge
from .timefit import fit

TELLING = 3  # modes from which on one loss factor and many damping ratios can be told apart


def find_damping(declared: TimeFit, free: TimeFit) -> tuple[Candidate, tuple[str, ...]] | None:
    """The law of damping that the declared fit lacks, and its twins; None where it lacks none.

    `free` is the same fit with every mode's damping ratio free: a good place to start from.
    """
    if declared.law.damping == "free":
        return None
    tried = {}
    for name, law in DAMPING.items():
        if declared.law.damping == law.LAW:
            continue
        found = fit(replace(declared.law, damping=law.LAW), free.parameters, evaluations=40)
        tried[name] = judge((name,), found, declared)
    least = min(c.found.chi2 / c.found.samples for c in tried.values())

    def worth(candidate: Candidate) -> float:
        """Evidence; what no law of damping takes counts as noise. One loss factor asks for less."""
        return candidate.evidence / max(least, 1.0) + _spared(candidate.found)

    ranked = sorted(tried.values(), key=worth, reverse=True)
    if ranked[0].evidence < EVIDENCE:
        return None
    best = ranked[0]
    twins = tuple(
        c.names[0]
        for c in ranked[1:]
        if declared.law.modes < TELLING or worth(c) > worth(best) - EVIDENCE
    )
    return best, twins


def is_needless(found: TimeFit, declared: TimeFit) -> bool:
    """Whether beside the effects of `found`, which has another law of damping, the declared law
    does as well: what an effect did looked like that other law as long as it was not there.
    """
    if declared.law.damping == "none":
        return False
    law = replace(found.law, damping=declared.law.damping)
    plain = fit(law, found.parameters, evaluations=40)
    gain = judge((), found, plain).evidence + _spared(found) - _spared(plain)
    return gain < EVIDENCE


def _spared(found: TimeFit) -> float:
    """What its law of damping saves of the price of a damping ratio for each mode."""
    spare = found.law.modes - 1 if found.law.damping == "common" else 0
    return spare * float(np.log(max(found.samples, 2)))
