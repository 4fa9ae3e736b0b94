"""What takes with other loads tell of the body: a known mass lowers its strongest mode's pitch by
what that is of all that swings there, whatever Young's modulus is.

Law         K x = λ (M + ΔM) x beside K x = λ M x, ΔM the loads of one take less those of the first
Source      Parloo, Verboven, Guillaume, Van Overmeire, Mech. Syst. Signal Process. 16 (2002) 757
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import g
from scipy.linalg import eigh

from .body import Body
from .camera_layer import true_frequency
from .compare import Hypothesis, ShiftsLeft
from .effects.base import reduced_basis
from .joint import Heard
from .match import PAIR, TURNED
from .seat import on_narrow_feet
from .turned import shift_of
from .verdict import Verdict

WHOLE = 0.05  # of every computed shift at once: the body's own mass
PLACED = 0.02  # of a take's largest one: where its load is
SAME = 0.6  # share of a mode's energy that is left of it under the load
ALIKE = 0.1  # of gravity, that two takes' may differ by


@dataclass(frozen=True, eq=False)
class Shift:
    """How far the pitches of a take with other loads lie from those of the first one."""

    take: int  # its number among the fitted ones
    measured: np.ndarray  # (K,) logarithms of its pitches over the first one's; NaN: not known
    error: np.ndarray  # (K,) beside what is computed
    added: object  # csr (3P, 3P) kg, what its loads add to the first one's

    def within(self, basis: np.ndarray) -> np.ndarray:
        """(r, r) what is added, in a basis (3P, r)."""
        return basis.T @ (self.added @ basis)


@dataclass(frozen=True, eq=False)
class Reduced:
    """The declared body in the modes that it has with the loads of all takes."""

    matrices: tuple[np.ndarray, np.ndarray]  # (r, r) stiffness at 1 Pa, mass in kg
    added: tuple[np.ndarray, ...]  # (r, r) kg per shift


def shifts_of(
    heard: Heard, verdict: Verdict, found: Hypothesis, bias: np.ndarray | float = 0.0
) -> tuple[Shift, ...]:
    """The shifts of all fitted takes with other loads than the first one, of the strongest mode:
    which of the others is which under another load is less sure. None where the weight is in the
    stiffness, or another way up.

    found: of the declared body; bias: relative, by how much a pitch may be off beside its own
    spread.
    """
    final, first = verdict.final, heard.body
    law, K = final.law, final.law.modes
    start = law.fitted[0]
    if first.carried is not None or None in heard.match.modes:
        return ()
    modes, true = list(heard.match.modes), true_frequency(heard, final)
    one, other = first.modes.frequency[[modes[0], found.modes[0]]]
    same = abs(np.log(one / other)) < PAIR
    out, seen = [], {law.pitch[start]}
    for n, i in enumerate(law.fitted):
        there, take = heard.bodies[heard.condition[i]], heard.takes[i].take
        added = there.model.mass - first.model.mass
        if (
            law.pitch[i] in seen
            or not abs(added).max()
            or _is_turned(take, heard.takes[start].take)
        ):
            continue
        seen.add(law.pitch[i])
        seat = [
            on_narrow_feet(body, one.take)[modes] / 2
            for body, one in ((first, heard.takes[start]), (there, heard.takes[i]))
        ]
        measured, error = shift_of(final, n)
        error = error + bias**2 + np.square(seat).sum(axis=0)
        error = error + _borne(first, added, modes, true) ** 2
        most = true * np.maximum(1, there.modes.frequency / first.modes.frequency)[modes]
        folds = (true != final.pitches(0)) | (most > 0.5 / heard.takes[i].frame)
        known = ~folds & _stays(there, first, modes) & (np.arange(K) == 0) & same
        out.append(Shift(n, np.where(known, measured, np.nan), np.sqrt(error), added))
    return tuple(out)


def _is_turned(one, other) -> bool:
    """Whether the object is known to be another way up in one of two takes."""
    if one.gravity is None or other.gravity is None:
        return False
    return bool(np.linalg.norm(one.gravity - other.gravity) > ALIKE * g)


def _borne(body: Body, added, modes: list[int], pitch: np.ndarray) -> np.ndarray:
    """(K,) relative, how much the weight that is added may stiffen or soften modes of these pitches
    (Hz): as a pendulum's of the body's length, hanging or standing.
    """
    shapes = body.modes.shapes.reshape(added.shape[0], -1)[:, modes]
    share = np.abs((shapes * (added @ shapes)).sum(axis=0))  # of what swings
    length = np.ptp(body.model.points, axis=0).max()
    return share * g / length / (2 * np.pi * pitch) ** 2


def _stays(there: Body, first: Body, modes: list[int]) -> np.ndarray:
    """(K,) bool: whether these modes of the first body are much the same under the load, where
    they have the same numbers.
    """
    size = first.model.mass.shape[0]
    own, laden = (body.modes.shapes.reshape(size, -1) for body in (first, there))
    heavy = first.model.mass @ laden
    alike = (heavy.T @ own[:, modes]) ** 2 / (laden * heavy).sum(axis=0)[:, None]
    near = _near(there.modes.frequency**2, alike)
    matched = near[modes, range(len(modes))]
    return matched & ((alike * near).sum(axis=0) > SAME)


def reduced(heard: Heard, shifts: tuple[Shift, ...]) -> Reduced | None:
    """The declared body as `told_by` asks for it; None where no take has other loads."""
    if not shifts:
        return None
    law, model = heard.declared.law, heard.body.model
    laden = [heard.bodies[heard.condition[law.fitted[one.take]]] for one in shifts]
    parts = [body.modes.shapes.reshape(model.mass.shape[0], -1) for body in (heard.body, *laden)]
    basis = reduced_basis(parts, model.mass)
    matrices = basis.T @ (model.stiffness @ basis), basis.T @ (model.mass @ basis)
    return Reduced(matrices, tuple(one.within(basis) for one in shifts))


def as_declared(shifts: tuple[Shift, ...], found: Hypothesis, body: Reduced | None) -> Hypothesis:
    """The hypothesis of the declared body with what is left of the shifts."""
    return told_by(shifts, found, body.matrices, body.added) if body else found


def told_by(
    shifts: tuple[Shift, ...],
    found: Hypothesis,
    matrices: tuple[np.ndarray, np.ndarray],
    added: Iterable[np.ndarray],
    solved: tuple[np.ndarray, np.ndarray] | None = None,
) -> Hypothesis:
    """The hypothesis of a body with these `matrices` (r, r), stiffness and mass, with what is left
    of the shifts under what is `added` (r, r), which costs as pitches do. solved: its eigenvalues
    (r,) and modes (r, r), where these are known.
    """
    if not shifts:
        return found
    values, x = solved or eigh(*matrices)
    modes = list(found.modes[: len(shifts[0].measured)])
    some = [_foretold(matrices, extra, values[modes], x[:, modes]) for extra in added]
    foretold, parted = (np.array(part) for part in zip(*some, strict=True))
    measured = np.array([one.measured for one in shifts])
    known = np.isfinite(measured)
    off = np.where(known, foretold - np.where(known, measured, 0.0), 0.0)
    way = np.where(known, WHOLE * foretold, 0.0)
    most = np.abs(np.where(known, foretold, 0.0)).max(axis=1, keepdims=True)
    own = np.array([one.error for one in shifts])
    error = np.sqrt(own**2 + (PLACED * most) ** 2 + parted**2)
    common = float((way * off / error**2).sum() / (1 + (way**2 / error**2).sum()))
    left = ShiftsLeft((off - common * way) / error, error, common, way)
    return replace(found, chi2=found.chi2 + left.chi2, shifts=left)


def _foretold(matrices: tuple, added: np.ndarray, values: np.ndarray, x: np.ndarray) -> tuple:
    """(K,) logarithm of the pitches of modes x (r, K) at these eigenvalues with what is added over
    those without, and (K,) by how much the modes lie apart that a load makes of one.
    """
    K, M = matrices
    laden, turned = eigh(K, M + added)
    heavy = M @ turned
    alike = (heavy.T @ x) ** 2 / (turned * heavy).sum(axis=0)[:, None]
    own = _near(laden, alike) * alike
    own = own / own.sum(axis=0)
    pitches = _logarithm(laden)[:, None] - _logarithm(values)
    mean = (own * pitches).sum(axis=0)
    return mean, np.sqrt((own * (pitches - mean) ** 2).sum(axis=0))


def _near(values: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """(r, K) which modes, at eigenvalues (r,), lie so close to the one that is most `alike` (r, K)
    to each that a load turns them into one another.
    """
    pitches = _logarithm(values)
    return np.abs(pitches[:, None] - pitches[alike.argmax(axis=0)]) < TURNED


def _logarithm(values: np.ndarray) -> np.ndarray:
    """Of the pitches at these eigenvalues."""
    return np.log(np.maximum(values, 1e-300)) / 2
