"""The body of a case on its mesh: held, loaded, rung, and read at the markers."""

from dataclasses import dataclass

import numpy as np

from .channels import Channels
from .data import Case, ElasticModel, Load, Modes, TetMesh
from .elasticity import add_loads, assemble, hold, point_operator, surface_quadrature
from .modes import solve_modes

COUNT = 16  # computed modes: more than any recording of a soft body shows


@dataclass(frozen=True, eq=False)
class Body:
    """One object with one set of loads; everything at Young's modulus 1 Pa."""

    case: Case
    bare: ElasticModel  # held, no loads
    model: ElasticModel  # held, with loads
    modes: Modes  # frequencies in Hz at 1 Pa
    markers: object  # csr (3n, 3P): displacement of the markers

    def seen(self, data: Channels, shapes: np.ndarray | None = None) -> np.ndarray:
        """Shapes (m, C) as the channels see them, of `shapes` (P, 3, m) or of the modes."""
        shapes = self.modes.shapes if shapes is None else shapes
        moved = (self.markers @ shapes.reshape(-1, shapes.shape[2])).reshape(-1, 3, shapes.shape[2])
        seen = np.einsum("ci,cim->mc", data.directions, moved[data.marker])
        return np.where(data.support, 0.0, seen)


def bare_model(case: Case, mesh: TetMesh, element: str) -> ElasticModel:
    """The case's body on `mesh`, held by its pins, without loads."""
    free = assemble(mesh, case.material, element)
    return hold(free, case.surface, case.pinned, case.pin_regions)


def build_body(case: Case, bare: ElasticModel, loads: tuple[Load, ...]) -> Body:
    """Loads added, lowest modes solved, markers attached."""
    model = add_loads(bare, loads) if loads else bare
    count = min(COUNT, model.free.size - 1)
    places = np.array([m.position for m in case.takes[0].recording.markers])
    return Body(case, bare, model, solve_modes(model, count), point_operator(model, places))


def drag_area(body: Body, mode: int) -> float:
    """Integral over the surface seen from the motion of |S|^3 dA, m2.

    S is the mode's shape, one in metres at the marker that moves most; the traction c |v| v on it
    does the work c |u'| u'^2 times this.
    """
    operator, normals, areas = surface_quadrature(body.model)
    shape = body.modes.shapes[:, :, mode]
    moved = (operator @ shape.ravel()).reshape(-1, 3)
    size = np.linalg.norm(moved, axis=1)
    facing = np.maximum(np.einsum("qi,qi->q", normals, moved), 0) / np.maximum(size, 1e-300)
    return float((size**3 * facing * areas).sum() / reach(body, mode) ** 3)


def reach(body: Body, mode: int) -> float:
    """kg^-1/2, the largest motion of a marker on the object in the mass-normalized mode."""
    shape = body.modes.shapes[:, :, mode]
    moved = np.linalg.norm((body.markers @ shape.ravel()).reshape(-1, 3), axis=1)
    on = [m.on == "object" for m in body.case.takes[0].recording.markers]
    return float(moved[np.array(on)].max())
