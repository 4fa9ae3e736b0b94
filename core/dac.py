"""Dynamics-aware coarsening: the Young's modulus with which this mesh rings as measured.

Y = Y0 w^2 / lambda (Chen, Levin, Kaufman, Pai 2017, Dynamics-Aware Numerical Coarsening for
Fabrication Design, section 3): w the natural, undamped angular frequency, lambda the eigenvalue
of the mesh at Y0. It is `apparent`: another mesh of the same object needs another one. The
`material` modulus has the mesh's own stiffening lambda / lambda_converged taken out.
"""

import numpy as np

from .data import Estimate

SURE = 1.959964  # standard deviations of a 95 % interval
# What a squared pitch is off by, relatively, in a body whose surface is flat faces, whose pins are
# whole vertices and whose size was measured; and of how many modes' scatter that is worth.
FORM, KNOWN = 0.005, 2
MEDIAN = 1.4826 / np.sqrt(2)  # standard deviation over the median of differences


def youngs_modulus(natural_frequency: float, mesh_frequency: float) -> float:
    """Pa; `mesh_frequency` is the mesh's own in Hz at 1 Pa."""
    return (natural_frequency / mesh_frequency) ** 2


def apparent(frequency: float, sigma: float, mesh_frequency: float) -> Estimate:
    """Apparent modulus, Pa, from a natural frequency and its standard deviation, Hz."""
    half = SURE * sigma
    return Estimate(
        youngs_modulus(frequency, mesh_frequency),
        youngs_modulus(max(frequency - half, 0.0), mesh_frequency),
        youngs_modulus(frequency + half, mesh_frequency),
        "Pa",
    )


def material(found: Estimate, stiffening: float, sigma: float) -> Estimate:
    """Material modulus: `found` times 1 + stiffening, the relative error `sigma` added in."""
    value = found.value * (1 + stiffening)
    below = np.hypot(1 - found.low / found.value, SURE * sigma / (1 + stiffening))
    above = np.hypot(found.high / found.value - 1, SURE * sigma / (1 + stiffening))
    return Estimate(value, value * (1 - min(below, 1.0)), value * (1 + above), "Pa")


def blended(squares: float, count: int) -> float:
    """Relative error of a computed squared pitch, from a sum of `count` modes' squared errors."""
    return float(np.sqrt((KNOWN * FORM**2 + squares) / (KNOWN + count)))


def scattered(moduli: np.ndarray, sigma: np.ndarray, of: int) -> float:
    """Relative error of the modulus that mode `of` of some (k,) tells, from how much farther the
    others' are from it than their own `sigma` (k,), relative: by the median, for among several a
    mode that is matched wrongly is no measure.
    """
    others, noise = np.delete(np.log(moduli / moduli[of]), of), np.delete(sigma, of)
    if not len(others):
        return blended(0.0, 0)
    middle = (MEDIAN * np.median(np.abs(others))) ** 2
    own = (np.median(noise) ** 2 + sigma[of] ** 2) / 2
    return blended(len(others) * max(middle - own, 0.0), len(others))
