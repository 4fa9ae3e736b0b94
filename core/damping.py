"""How the modes lose energy, where the case does not say, or says it wrongly."""

import numpy as np

from .effects import DAMPING
from .law import TimeFit, replace
from .time_layer import EVIDENCE, Candidate, judge
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
        found = candidate.found
        spare = found.law.modes - 1 if found.law.damping == "common" else 0
        return candidate.evidence / max(least, 1.0) + spare * np.log(max(found.samples, 2))

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
