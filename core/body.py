"""The body of a case on its mesh: held, loaded, rung, and read at the markers."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .channels import Channels
from .data import Case, ElasticModel, Modes, Take, TetMesh
from .effects.gravity_preload import change_model
from .elasticity import (
    PLAIN,
    UNKNOWN,
    Seat,
    add_loads,
    assemble,
    gravity_force,
    hold,
    point_operator,
    static,
)
from .modes import solve_modes
from .symmetry import is_even, unevenness

COUNT = 16  # computed modes: more than any recording of a soft body shows


@dataclass(frozen=True, eq=False)
class Body:
    """One object with one set of loads; everything at Young's modulus 1 Pa."""

    case: Case
    bare: ElasticModel  # held, no loads
    model: ElasticModel  # held, with loads
    modes: Modes  # frequencies in Hz at 1 Pa
    markers: object  # csr (3n, 3P): displacement of the markers
    carried: float | None = None  # Pa: Young's modulus at which its weight is in its stiffness
    seats: tuple[Seat, ...] = UNKNOWN  # how its loads sit, and how else they may

    def seen(self, data: Channels, shapes: np.ndarray | None = None) -> np.ndarray:
        """Shapes (m, C) as the channels see them, of `shapes` (P, 3, m) or of the modes."""
        shapes = self.modes.shapes if shapes is None else shapes
        moved = (self.markers @ shapes.reshape(-1, shapes.shape[2])).reshape(-1, 3, shapes.shape[2])
        seen = np.einsum("ci,cim->mc", data.directions, moved[data.marker])
        return np.where(data.support, 0.0, seen)

    def sag(self, data: Channels) -> np.ndarray:
        """(C,) how far the channels' places yield to the take's gravity at 1 Pa, in their unit."""
        return self.seen(data, (self.yielding @ data.take.gravity)[:, :, None])[0]

    @cached_property
    def yielding(self) -> np.ndarray:
        """(P, 3, 3) m at 1 Pa under 1 m/s2 along each axis."""
        pull = np.transpose([gravity_force(self.model, axis) for axis in np.eye(3)])
        return static(self.model, pull, 1.0)

    @cached_property
    def pairs(self) -> bool:
        """Whether two near modes of it are a pair by its symmetry, or nearly."""
        return is_even(self.bare)

    @cached_property
    def parts(self) -> float:
        """How far apart, relatively, the pitches of a pair of its modes are at most: without a load
        no further than it is uneven, a pitch going with the root of a moment.
        """
        return unevenness(self.bare) / 2 if self.model is self.bare else np.inf


def bare_model(case: Case, mesh: TetMesh, element: str) -> ElasticModel:
    """The case's body on `mesh`, held by its pins, without loads."""
    free = assemble(mesh, case.material, element)
    return hold(free, case.surface, case.pinned, case.pin_regions)


def laden(
    model: ElasticModel, take: Take, carried: float | None = None, seat: Seat = PLAIN
) -> ElasticModel:
    """The bare model with the loads of a take and, carried with that modulus (Pa), its weight."""
    model = add_loads(model, take.loads, seat, take.gravity) if take.loads else model
    return model if carried is None else change_model(model, (*take.gravity, carried))


def build_body(
    case: Case,
    bare: ElasticModel,
    take: Take,
    carried: float | None = None,
    seats: tuple[Seat, ...] = UNKNOWN,
) -> Body:
    """Loads of a take added, lowest modes solved, markers attached.

    carried: Young's modulus (Pa) at which the body's weight counts in its stiffness; None: nowhere.
    """
    model = laden(bare, take, carried, seats[0])
    count = min(COUNT, model.free.size - 1)
    places = np.array([m.position for m in case.takes[0].recording.markers])
    modes = solve_modes(model, count)
    return Body(case, bare, model, modes, point_operator(model, places), carried, seats)
