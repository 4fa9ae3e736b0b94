"""What takes with other loads tell of the body: a known mass lowers each of its pitches by what
that is of all that swings there, whatever Young's modulus is.

Law         K x = λ (M + ΔM) x beside K x = λ M x, ΔM the loads of one take less those of the first
Source      Parloo, Verboven, Guillaume, Van Overmeire, Mech. Syst. Signal Process. 16 (2002) 757
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from .body import Body
from .camera_layer import true_frequency
from .compare import Hypothesis
from .effects.base import reduced_basis
from .joint import Heard
from .match import TURNED
from .parameters import inflation
from .seat import on_narrow_feet
from .verdict import Verdict

FLOOR = 0.001  # relative error of a shift of pitch that no fit sees: a warmer room, another hold
UNSURE = 0.05  # of the largest computed shift: the body's own mass, and where the load is
SAME = 0.6  # share of a mode's energy that is left of it under the load


@dataclass(frozen=True, eq=False)
class Shift:
    """How far the pitches of a take with other loads lie from those of the first one."""

    take: int  # its number among the fitted ones
    measured: np.ndarray  # (K,) logarithms of its pitches over the first one's
    error: np.ndarray  # (K,) of the recording
    added: object  # csr (3P, 3P) kg, what its loads add to the first one's

    def within(self, basis: np.ndarray) -> np.ndarray:
        """(r, r) what is added, in a basis (3P, r)."""
        return basis.T @ (self.added @ basis)


def shifts_of(heard: Heard, verdict: Verdict, bias: np.ndarray | float = 0.0) -> tuple[Shift, ...]:
    """The shifts of all fitted takes with other loads than the first one; `bias`: relative, by how
    much a pitch may be off beside its own spread. None where the weight is in the stiffness.
    """
    final, first = verdict.final, heard.body
    law, K = final.law, final.law.modes
    if first.carried is not None:
        return ()
    spread = np.diag(final.covariance) * inflation(final)
    folded = true_frequency(heard, final) != final.pitches(0)
    out, own, seen = [], 2 * K * law.pitch[law.fitted[0]], {law.pitch[law.fitted[0]]}
    for n, i in enumerate(law.fitted):
        there = heard.bodies[heard.condition[i]]
        if law.pitch[i] in seen or heard.condition[i] == heard.condition[law.fitted[0]]:
            continue
        seen.add(law.pitch[i])
        at = 2 * K * law.pitch[i]
        modes = list(heard.match.modes)
        seat = on_narrow_feet(there, heard.takes[i].take.loads)[modes] / 2
        error = np.sqrt(spread[at : at + K] + spread[own : own + K] + FLOOR**2 + bias**2 + seat**2)
        measured = np.log(final.pitches(n) / final.pitches(0))
        known = ~folded & _stays(there, first, modes)
        measured = np.where(known, measured, np.nan)
        out.append(Shift(n, measured, error, there.model.mass - first.model.mass))
    return tuple(out)


def _stays(there: Body, first: Body, modes: list[int]) -> np.ndarray:
    """(K,) bool: whether these modes of the first body are much the same under the load."""
    own, laden = (
        body.modes.shapes.reshape(first.model.mass.shape[0], -1) for body in (first, there)
    )
    heavy = first.model.mass @ laden
    alike = (heavy.T @ own[:, modes]) ** 2 / (laden * heavy).sum(axis=0)[:, None]
    near = _near(there.modes.frequency**2, alike)
    return (alike * near).sum(axis=0) > SAME


def as_declared(heard: Heard, shifts: tuple[Shift, ...]) -> tuple[tuple, list]:
    """What `told_by` asks for of the declared body, in the modes that it has with and without."""
    if not shifts:
        return (), []
    law, model = heard.declared.law, heard.body.model
    laden = [heard.bodies[heard.condition[law.fitted[one.take]]] for one in shifts]
    parts = [body.modes.shapes.reshape(model.mass.shape[0], -1) for body in (heard.body, *laden)]
    basis = reduced_basis(parts, model.mass)
    matrices = basis.T @ (model.stiffness @ basis), basis.T @ (model.mass @ basis)
    return matrices, [one.within(basis) for one in shifts]


def told_by(
    shifts: tuple[Shift, ...],
    found: Hypothesis,
    matrices: tuple,
    added: Iterable[np.ndarray],
    solved: tuple | None = None,
) -> Hypothesis:
    """The hypothesis of a body with these `matrices` (r, r), stiffness and mass, with what is left
    of the shifts under what is `added` (r, r), which costs as pitches do. solved: its eigenvalues
    and modes, where these are known.
    """
    if not shifts:
        return found
    values, x = solved or eigh(*matrices)
    modes = list(found.modes[: len(shifts[0].measured)])
    left, pull = [], []
    for shift, extra in zip(shifts, added, strict=True):
        foretold = _foretold(matrices, extra, values[modes], x[:, modes])
        off = np.nan_to_num(foretold - shift.measured)
        most = np.abs(np.nan_to_num(foretold)).max()
        left.append(off)
        pull.append(off / np.hypot(shift.error, UNSURE * most))
    pulls = np.array(pull)
    chi2 = found.chi2 + float((pulls**2).sum())
    return replace(found, chi2=chi2, shift_left=np.array(left), shift_pull=pulls)


def _foretold(matrices: tuple, added: np.ndarray, values: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(K,) logarithm of the pitches of modes x (r, K) at these eigenvalues with what is added over
    those without.
    """
    K, M = matrices
    laden, turned = eigh(K, M + added)
    heavy = M @ turned
    alike = (heavy.T @ x) ** 2 / (turned * heavy).sum(axis=0)[:, None]
    own = _near(laden, alike) * alike
    pitches = np.log(np.maximum(laden, 1e-300)) / 2
    return (own * pitches[:, None]).sum(axis=0) / own.sum(axis=0) - np.log(values) / 2


def _near(values: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """(r, K) which modes, at eigenvalues (r,), lie so close to the one that is most `alike` (r, K)
    to each that a load turns them into one another.
    """
    pitches = np.log(np.maximum(values, 1e-300)) / 2
    return np.abs(pitches[:, None] - pitches[alike.argmax(axis=0)]) < TURNED
