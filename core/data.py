"""Every noun. SI inside, frequencies in Hz; frozen, checked once, trusted afterwards."""

from dataclasses import dataclass, field, replace  # noqa: F401  (replace is re-exported)

import numpy as np
from scipy import sparse

from .errors import DataError


def seal(noun, name: str, dtype, shape: tuple, finite: bool = True) -> None:
    """Copy the array field `name`, check its shape (None = any) and make it read-only.

    Raises DataError when the shape differs, a number is not finite, or it is not numeric.
    """
    where = f"{type(noun).__name__}.{name}"
    try:
        array = np.array(getattr(noun, name), dtype=dtype)
    except (TypeError, ValueError) as error:
        raise DataError(f"{where}: not an array of {dtype.__name__} ({error}).") from error
    if len(array.shape) != len(shape) or any(
        want is not None and have != want for have, want in zip(array.shape, shape, strict=True)
    ):
        wanted = tuple("any" if want is None else want for want in shape)
        raise DataError(f"{where}: its shape is {array.shape}, {wanted} is needed.")
    if finite and array.dtype.kind in "fc" and not np.isfinite(array).all():
        raise DataError(f"{where}: {np.sum(~np.isfinite(array))} entries are not finite numbers.")
    array.setflags(write=False)
    object.__setattr__(noun, name, array)


def tet_volumes(nodes: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Signed volumes (T,) m3 of linear tetrahedra."""
    a, b, c, d = (nodes[tets[:, i]] for i in range(4))
    return np.einsum("ti,ti->t", np.cross(b - a, c - a), d - a) / 6


# --- the body -------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangulated surface as the artist gave it: open, dirty or closed."""

    vertices: np.ndarray  # (V, 3) m
    faces: np.ndarray  # (F, 3) rows of `vertices`

    def __post_init__(self):
        seal(self, "vertices", float, (None, 3))
        seal(self, "faces", int, (None, 3))
        if self.faces.size and not (0 <= self.faces.min() <= self.faces.max() < len(self.vertices)):
            raise DataError("Surface.faces: they name vertices that do not exist.")


@dataclass(frozen=True, eq=False)
class TetMesh:
    """A solid body cut into linear tetrahedra."""

    nodes: np.ndarray  # (N, 3) m
    tets: np.ndarray  # (T, 4) rows of `nodes`, positive volume

    def __post_init__(self):
        seal(self, "nodes", float, (None, 3))
        seal(self, "tets", int, (None, 4))
        volume = tet_volumes(self.nodes, self.tets)
        if not len(volume):
            raise DataError("TetMesh: it has no tetrahedra. Tetrahedralize again.")
        if not (volume > 0).all():
            raise DataError(
                f"TetMesh: {np.sum(volume <= 0)} of {volume.size} tetrahedra are flat or "
                "inverted. Swap two corners of each, or tetrahedralize again."
            )

    @property
    def volume(self) -> float:
        """m3"""
        return float(tet_volumes(self.nodes, self.tets).sum())


@dataclass(frozen=True)
class Material:
    """What is known of the stuff, apart from its stiffness."""

    density: float  # kg/m3
    poisson_ratio: float = 0.48  # 1, 0 <= nu < 0.5

    def __post_init__(self):
        if not (np.isfinite(self.density) and self.density > 0):
            raise DataError(f"Material.density: {self.density} kg/m3; more than 0 is needed.")
        if not 0 <= self.poisson_ratio < 0.5:
            raise DataError(
                f"Material.poisson_ratio: {self.poisson_ratio}; 0 <= nu < 0.5 is needed. "
                "For an incompressible body give 0.499."
            )


@dataclass(frozen=True, eq=False)
class Load:
    """A known lumped mass fixed to the body."""

    mass: float  # kg
    position: np.ndarray  # (3,) m, rest position

    def __post_init__(self):
        seal(self, "position", float, (3,))


@dataclass(frozen=True, eq=False)
class ElasticModel:
    """Matrices of one body on one mesh at Young's modulus 1 Pa; multiply `stiffness` by Y.

    The nodal points carry three displacements each, ordered x0 y0 z0 x1 ...; `points` begins with
    the mesh's own nodes. `stiffness` = mu G + kappa B with mu = 1/(2(1+nu)), kappa = 1/(3(1-2nu)).
    """

    mesh: TetMesh
    material: Material
    element: str  # a key of core.elements.ELEMENTS
    points: np.ndarray  # (P, 3) m
    shear: sparse.csr_matrix  # (3P, 3P) G: stiffness of the deviatoric part at mu = 1 Pa
    bulk: sparse.csr_matrix  # (3P, 3P) B: stiffness of the volumetric part at kappa = 1 Pa
    mass: sparse.csr_matrix  # (3P, 3P) kg
    pinned: np.ndarray  # (P,) bool: held points
    stress: sparse.csr_matrix | None = None  # (3P, 3P) N/m at Y = 1 Pa of what it carries at rest

    def __post_init__(self):
        seal(self, "points", float, (None, 3))
        seal(self, "pinned", bool, (len(self.points),))

    @property
    def stiffness(self) -> sparse.csr_matrix:
        """(3P, 3P) N/m at Y = 1 Pa and the material's Poisson ratio."""
        nu = self.material.poisson_ratio
        elastic = self.shear / (2 * (1 + nu)) + self.bulk / (3 * (1 - 2 * nu))
        return elastic if self.stress is None else elastic + self.stress

    @property
    def free(self) -> np.ndarray:
        """Indices of the dofs that are not held."""
        return np.flatnonzero(np.repeat(~self.pinned, 3))


@dataclass(frozen=True, eq=False)
class Modes:
    """Lowest modes of K x = lambda M x, x^T M x = 1, at the modulus that they were solved for."""

    frequency: np.ndarray  # (m,) Hz, natural (undamped), ascending
    shapes: np.ndarray  # (P, 3, m) kg^-1/2, zero at held points

    def __post_init__(self):
        seal(self, "frequency", float, (None,))
        seal(self, "shapes", float, (None, 3, len(self.frequency)))


# --- the recording --------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Marker:
    """A point that is followed."""

    name: str
    position: np.ndarray  # (3,) m in the mesh's shape
    on: str = "object"  # "object" | "support"
    pixel: tuple[float, float] | None = None  # px, video only

    def __post_init__(self):
        seal(self, "position", float, (3,))
        if self.on not in ("object", "support"):
            raise DataError(f'Marker.on: "{self.on}"; "object" or "support" is needed.')


@dataclass(frozen=True, eq=False)
class Camera:
    """Orthographic: px = principal + rows . x / metres_per_pixel. Pinhole: the usual projection."""

    kind: str  # "orthographic" | "pinhole"
    rows: np.ndarray  # (3, 3) unit rows: image right, image down, view direction; object axes
    position: np.ndarray  # (3,) m; the origin for an orthographic camera
    scale: float  # px per metre (orthographic) or focal length in px (pinhole)
    principal_point: np.ndarray  # (2,) px
    image_size: tuple[int, int] = (0, 0)  # px
    readout: float | None = None  # s, first to last row; None = not known

    def __post_init__(self):
        seal(self, "rows", float, (3, 3))
        seal(self, "position", float, (3,))
        seal(self, "principal_point", float, (2,))
        if self.kind not in ("orthographic", "pinhole"):
            raise DataError(f'Camera.kind: "{self.kind}"; "orthographic" or "pinhole" is needed.')

    def project(self, x: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) u right, v down, of the places `x` (..., 3) m in object axes."""
        seen = (np.asarray(x) - self.position) @ self.rows.T
        flat = seen[..., :2]
        if self.kind == "pinhole":
            flat = flat / seen[..., 2:]
        return self.principal_point + self.scale * flat

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """d(pixel)/d(place) (..., 2, 3) px/m at the places `x` (..., 3) m."""
        x = np.asarray(x, float)
        top = np.broadcast_to(self.rows[:2], (*x.shape[:-1], 2, 3))
        if self.kind == "orthographic":
            return self.scale * top
        seen = (x - self.position) @ self.rows.T
        depth = seen[..., 2, None, None]
        return self.scale * (top / depth - seen[..., :2, None] * self.rows[2] / depth**2)


@dataclass(frozen=True, eq=False)
class Recording:
    """Tracks of all markers over time: metres in object axes, or pixels of a camera."""

    time: np.ndarray  # (T,) s, ascending
    values: np.ndarray  # (T, n, d) m (d = 3) or px (d = 2); NaN = missing sample
    markers: tuple[Marker, ...]  # n
    camera: Camera | None = None  # needed where d = 2
    sigma: np.ndarray | None = None  # (T, n) per-sample standard deviation, where it is known
    start: float | None = None  # s, the release; None = detect
    stop: float | None = None  # s; None = the end
    capture_fps: float | None = None  # frames per second of real time
    warnings: tuple[str, ...] = ()

    def __post_init__(self):
        seal(self, "time", float, (None,))
        n = len(self.markers)
        seal(self, "values", float, (len(self.time), n, None), finite=False)
        if self.values.shape[2] not in (2, 3):
            raise DataError(f"Recording.values: {self.values.shape[2]} axes; 2 or 3 are needed.")
        if self.values.shape[2] == 2 and self.camera is None:
            raise DataError("Recording: 2-D tracks need a camera. Add [camera] to the case.")
        if (np.diff(self.time) <= 0).any():
            raise DataError("Recording.time: it goes back or stands still. Sort the rows.")
        if self.sigma is not None:
            seal(self, "sigma", float, (len(self.time), n), finite=False)


@dataclass(frozen=True, eq=False)
class Take:
    """One recording with what was fixed to the object and which way it hung."""

    recording: Recording
    loads: tuple[Load, ...] = ()
    gravity: np.ndarray | None = None  # (3,) m/s2, object axes; None = not modelled
    held_out: bool = False
    name: str = ""

    def __post_init__(self):
        if self.gravity is not None:
            seal(self, "gravity", float, (3,))


@dataclass(frozen=True, eq=False)
class Case:
    """Everything that a calibration starts from."""

    name: str
    surface: Surface  # m, object axes
    material: Material
    pinned: np.ndarray  # (V,) bool: vertices of `surface` that are held
    takes: tuple[Take, ...]  # the first is [recording]
    declared: tuple[str, ...] = ()
    claimed_youngs_modulus: float | None = None  # Pa, to compare with only
    shape: str = "equilibrium"  # | "unloaded"
    pin_regions: tuple = ()  # core.case.Region, tested against mesh nodes too
    folder: str = ""

    def __post_init__(self):
        seal(self, "pinned", bool, (len(self.surface.vertices),))


# --- what was measured ----------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class RingDown:
    """Sum of damped modes: y_c(t) = offset_c + sum_k Re(a_kc exp(p_k (t - t0))), strongest first.

    p = 2 pi f (-z + i sqrt(1 - z^2)), f natural frequency, z damping ratio. Beside them the
    channels' means may wander by a polynomial of time and by decays, which only `slow` tells.
    """

    frequency: np.ndarray  # (m,) Hz, natural
    damping_ratio: np.ndarray  # (m,)
    amplitude: np.ndarray  # (m, C) complex, in the channels' unit, at t0
    offset: np.ndarray  # (C,) in the channels' unit; the mean where nothing wanders
    noise: np.ndarray  # (C,) rms of what is left
    covariance: np.ndarray  # (2m, 2m) of (f_1.. f_m, z_1.. z_m)
    t0: float = 0.0  # s
    warnings: tuple[str, ...] = ()
    degree: int = 0  # of the polynomial
    creep: np.ndarray = ()  # (j,) 1/s, of the decays

    def __post_init__(self):
        seal(self, "frequency", float, (None,))
        seal(self, "creep", float, (None,))
        m = len(self.frequency)
        seal(self, "damping_ratio", float, (m,))
        seal(self, "amplitude", complex, (m, None))
        channels = self.amplitude.shape[1]
        seal(self, "offset", float, (channels,))
        seal(self, "noise", float, (channels,))
        seal(self, "covariance", float, (2 * m, 2 * m))

    @property
    def frequency_sigma(self) -> np.ndarray:
        """(m,) Hz, one standard deviation."""
        return np.sqrt(np.diag(self.covariance)[: len(self.frequency)])

    @property
    def damping_sigma(self) -> np.ndarray:
        """(m,) one standard deviation of the damping ratio."""
        return np.sqrt(np.diag(self.covariance)[len(self.frequency) :])

    def predict(self, time: np.ndarray) -> np.ndarray:
        """(T, C) at the instants `time` (T,) s."""
        pole = poles(self.frequency, self.damping_ratio)
        phase = np.exp(np.outer(np.asarray(time) - self.t0, pole))
        return self.offset + (phase @ self.amplitude).real

    def slow(self, time: np.ndarray) -> np.ndarray:
        """(T, 1 + degree + j) what the means may wander by over the instants `time` (T,) s, a
        constant first.
        """
        if not len(time):
            return np.zeros((0, 1 + self.degree + len(self.creep)))
        after = np.asarray(time) - np.min(time)
        span = max(after.max(), 1e-300)
        whole = np.polynomial.chebyshev.chebvander(2 * after / span - 1, self.degree)
        return np.hstack([whole, np.exp(-np.outer(after, self.creep))])


def poles(frequency: np.ndarray, damping_ratio: np.ndarray) -> np.ndarray:
    """Complex poles (m,) 1/s of natural frequencies (Hz) and damping ratios below 1."""
    z = np.asarray(damping_ratio)
    return 2 * np.pi * np.asarray(frequency) * (-z + 1j * np.sqrt(1 - z**2))


# --- what was inferred ----------------------------------------------------------------------


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Motion:
    """What a bake plays: the body's shapes and how much of each at every instant.

    displacement(x, t) = sum_k shapes[:, :, k] weights[t, k]; metres, object axes, about the mesh
    as given. Shapes are at the surface's vertices.
    """

    names: tuple[str, ...]  # k, one shape key each
    shapes: np.ndarray  # (V, 3, k) m per unit weight
    time: np.ndarray  # (T,) s from the release, finely sampled (>= 32 samples a period)
    weights: np.ndarray  # (T, k)

    def __post_init__(self):
        k = len(self.names)
        seal(self, "shapes", float, (None, 3, k))
        seal(self, "time", float, (None,))
        seal(self, "weights", float, (len(self.time), k))
