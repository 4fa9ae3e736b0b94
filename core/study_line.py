"""The wave equation on a line, cut into n: what differences and elements do to its eigenvalues.

u_tt = c² u_xx on (0, L), u = 0 at both ends, h = L/n, x = iπh/L. Exact: (iπc/L)².
- differences       2c²/h² (1 - cos x), from below
- linear elements   6c²/h² (1 - cos x) / (2 + cos x), from above: put u_j = sin(jx) into a row of
                    K u = λ M u, K = c²/h (-1, 2, -1), M = h/6 (1, 4, 1)
- averaged mass     12c²/h² (1 - cos x) / (5 + cos x), M = h/12 (1, 10, 1), below by x⁴/240
- the conjecture    2c²/h² (cosh x - 1), which agrees with the elements' up to a share of x⁶/3024

Source      Strang & Fix, An Analysis of the Finite Element Method, 1973, ch. 6
"""

import numpy as np
from scipy import sparse
from scipy.linalg import eigh

from .elements.linear import laplacian, scalar_mass
from .elements.mass import averaged


def exact(length: float, c: float, n: int) -> np.ndarray:
    """(n-1,) 1/s2, the first eigenvalues of the line itself."""
    return (np.arange(1, n) * np.pi * c / length) ** 2


def phase(n: int) -> np.ndarray:
    """(n-1,) x = iπh/L."""
    return np.arange(1, n) * np.pi / n


def differences_closed(length: float, c: float, n: int) -> np.ndarray:
    """(n-1,) 1/s2, central differences."""
    return 2 * (c * n / length) ** 2 * (1 - np.cos(phase(n)))


def elements_closed(length: float, c: float, n: int) -> np.ndarray:
    """(n-1,) 1/s2, linear elements with consistent mass."""
    x = phase(n)
    return 6 * (c * n / length) ** 2 * (1 - np.cos(x)) / (2 + np.cos(x))


def averaged_closed(length: float, c: float, n: int) -> np.ndarray:
    """(n-1,) 1/s2, linear elements with half consistent, half lumped mass."""
    x = phase(n)
    return 12 * (c * n / length) ** 2 * (1 - np.cos(x)) / (5 + np.cos(x))


def conjecture(length: float, c: float, n: int) -> np.ndarray:
    """(n-1,) 1/s2, what the founding report guessed for linear elements."""
    return 2 * (c * n / length) ** 2 * (np.cosh(phase(n)) - 1)


def differences(length: float, c: float, n: int) -> np.ndarray:
    """(n-1,) 1/s2, computed from the matrix of central differences."""
    ones = np.ones(n - 1)
    A = sparse.diags([-ones[1:], 2 * ones, -ones[1:]], [-1, 0, 1]).toarray()
    return eigh((c * n / length) ** 2 * A, eigvals_only=True)


def elements(length: float, c: float, n: int, mass=lambda M: M) -> np.ndarray:
    """(n-1,) 1/s2, computed from the product's linear elements; `mass` may change M."""
    nodes = np.linspace(0, length, n + 1)[:, None]
    cells = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    K, M = c**2 * laplacian(nodes, cells), mass(scalar_mass(nodes, cells))
    return eigh(K.toarray()[1:-1, 1:-1], M.toarray()[1:-1, 1:-1], eigvals_only=True)


def report_mass_limit() -> float:
    """Limit of λ L²/c² over π² with the report's mass matrix (6), h/6 tridiag(2, 4, 2): 3/4.

    Its neighbours have 2 where assembly gives 1, so a row sums to 8h/6 rather than h.
    """
    n = 400
    ones = np.ones(n - 1)
    K = sparse.diags([-ones[1:], 2 * ones, -ones[1:]], [-1, 0, 1]) * n
    M = sparse.diags([2 * ones[1:], 4 * ones, 2 * ones[1:]], [-1, 0, 1]) / (6 * n)
    lowest = eigh(K.toarray(), M.toarray(), eigvals_only=True, subset_by_index=[0, 0])[0]
    return float(lowest / np.pi**2)


def study_line() -> dict:
    """Everything of the line, L = c = 1, as plain numbers."""
    return {
        "eigenvalues": {str(n): _eigenvalues(n) for n in (2, 4, 8, 16)},
        "dac_on_the_first": {str(n): _dac(n) for n in (4, 8, 16)},
        "averaged_mass": {
            "n": 8,
            "averaged_percent": _percent(elements(1, 1, 8, averaged), 8),
            "consistent_percent": _percent(elements(1, 1, 8), 8),
        },
        "report": {
            "mass_matrix_6_limit_over_pi2": report_mass_limit(),
            "formula_4_at_length_2_over_true": float(
                4 * differences_closed(2, 1, 64)[0] / exact(2, 1, 64)[0]
            ),
            "note": "formulas (4) and (7) carry a factor L², the matrices a factor L and a sign: "
            "they hold for L = 1 only; matrix (6) has 2 where assembly gives 1",
        },
    }


def _eigenvalues(n: int) -> dict:
    pairs = (
        (differences(1, 1, n), differences_closed(1, 1, n)),
        (elements(1, 1, n), elements_closed(1, 1, n)),
        (elements(1, 1, n, averaged), averaged_closed(1, 1, n)),
    )
    return {
        "exact": exact(1, 1, n).tolist(),
        "differences": pairs[0][0].tolist(),
        "elements": pairs[1][0].tolist(),
        "averaged_mass": pairs[2][0].tolist(),
        "conjecture": conjecture(1, 1, n).tolist(),
        "closed_form_error": max(float(np.abs(a / b - 1).max()) for a, b in pairs),
    }


def _dac(n: int) -> dict:
    """The factor on K that makes the first mode right; how far frequencies are then off."""
    found, true = elements(1, 1, n), exact(1, 1, n)
    factor = true[0] / found[0]
    return {"factor": float(factor), "frequency_percent": _percent(factor * found, n)}


def _percent(values: np.ndarray, n: int) -> list[float]:
    """Of the first three frequencies, which go as the root of the eigenvalue."""
    return (100 * (np.sqrt(values / exact(1, 1, n)) - 1))[:3].tolist()
