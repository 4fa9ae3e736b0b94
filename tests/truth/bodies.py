"""The five filmed objects, sized by seed, and one built to order for closed forms."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh, splu

from . import solid


@dataclass(frozen=True, eq=False)
class Body:
    """A held soft body as it really is."""

    name: str
    nodes: np.ndarray  # (N, 3) m
    cells: np.ndarray  # (H, 27)
    faces: np.ndarray  # (F, 9)
    pinned: np.ndarray  # (N,) bool
    pin_box: tuple  # (3,), (3,) m: the region that the case declares
    vertices: np.ndarray  # (V, 3) m: the surface that the case gives
    triangles: np.ndarray  # (T, 3)
    path: np.ndarray  # (N,) way along the body, 0 at the held end, 1 at the free one
    axis: np.ndarray  # (3,) unit, from the held end to the free one
    swing: np.ndarray  # (3,) unit, the direction of the softest bending
    density: float  # kg/m3
    poisson: float
    young: float  # Pa
    stiffness: sparse.csr_matrix  # (3N, 3N) N/m, all nodes free
    mass: sparse.csr_matrix  # (3N, 3N) kg

    @property
    def free(self) -> np.ndarray:
        return np.flatnonzero(np.repeat(~self.pinned, 3))

    @property
    def height(self) -> np.ndarray:
        """(N,) place along the body, 0 at the held end, 1 at the free one."""
        return self.path

    @property
    def weight(self) -> float:
        """kg, the whole body."""
        return float(self.mass[::3, ::3].sum())

    @property
    def size(self) -> float:
        """m, along the axis."""
        return float(np.ptp(self.nodes @ self.axis))


def build(name, maps, counts, **given) -> Body:
    """Mesh and matrices: `maps` takes unit coordinates (N, 3) to metres; `keep` cuts cells out."""
    keep = given.pop("keep", None)
    shown = given.pop("shown", maps)
    finer = given.pop("surface_counts", counts)
    net = solid.lattice(counts, keep)
    nodes = maps(crowd(net.nodes, given.pop("crowded", (1, 1, 1))))
    skin = solid.lattice(finer, keep)
    used, faces = np.unique(skin.faces, return_inverse=True)
    axis = np.asarray(given["axis"], float)
    s = nodes @ axis
    low, size = s.min(), np.ptp(s)
    margin = 0.004 * size
    pin_low, pin_high = nodes.min(0) - 0.02 * size, nodes.max(0) + 0.02 * size
    side = int(np.argmax(abs(axis)))
    held = sorted([axis[side] * (low - 0.02 * size), axis[side] * (low + margin)])
    pin_low[side], pin_high[side] = held
    K, M = solid.matrices(nodes, net.cells, given["poisson"])
    way = s if "path" not in given else nodes @ np.asarray(given["path"], float)
    return Body(
        name=name,
        nodes=nodes,
        cells=net.cells,
        faces=net.faces,
        pinned=s < low + margin,
        pin_box=(pin_low, pin_high),
        vertices=shown(skin.nodes[used]),
        triangles=solid.triangles(faces.reshape(-1, 9)),
        path=(way - way.min()) / np.ptp(way),
        axis=axis,
        swing=np.asarray(given["swing"], float),
        density=given["density"],
        poisson=given["poisson"],
        young=1.0,
        stiffness=K,
        mass=given["density"] * M,
    )


def crowd(u: np.ndarray, power: tuple) -> np.ndarray:
    """Unit coordinates drawn towards a held end: 0 for a power above 1, 1 for one below -1."""
    power = np.asarray(power, float)
    return np.where(power > 0, u ** abs(power), 1 - (1 - u) ** abs(power))


def tuned(body: Body, first: float) -> Body:
    """The same body with the modulus that puts its first frequency at `first` Hz."""
    young = (first / modes(body, 1)[0][0]) ** 2
    return replace(body, young=young * body.young, stiffness=young * body.stiffness)


def modes(body: Body, count: int, ground=None) -> tuple[np.ndarray, np.ndarray]:
    """Natural frequencies (m,) Hz and mass-normalised shapes (3N, m) of the held body.

    With `ground` (3N, 3N) N/m nothing is held but by these springs.
    """
    if ground is None:
        f, shapes = held_modes(body, max(count, 12))
        return f[:count], shapes[:, :count]
    return lowest(body.stiffness + ground, body.mass, np.arange(len(body.nodes) * 3), count)


@lru_cache(maxsize=32)
def held_modes(body: Body, count: int) -> tuple[np.ndarray, np.ndarray]:
    return lowest(body.stiffness, body.mass, body.free, count)


def lowest(K, M, free, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,) Hz and shapes (3N, m) over the free rows."""
    start = np.random.default_rng(0).standard_normal(free.size)
    inside = K[free][:, free].tocsc(), M[free][:, free].tocsc()
    omega2, x = eigsh(inside[0], k=count + 1, M=inside[1], sigma=0, v0=start)
    order = np.argsort(omega2)
    shapes = np.zeros((K.shape[0], count))
    shapes[free] = directed(omega2[order], x[:, order], start)[:, :count]
    # a body that buckles under its weight has no pitch: 0
    return np.sqrt(np.clip(omega2[order[:count]], 0, None)) / (2 * np.pi), shapes


def directed(omega2: np.ndarray, shapes: np.ndarray, some: np.ndarray) -> np.ndarray:
    """(n, m) the shapes, those of one frequency turned as no machine's rounding decides: to where
    they weigh most in `some` (n,) weights, and all to where these see them move forwards.
    """
    out = shapes.copy()
    ends = np.flatnonzero(np.diff(omega2) > 1e-6 * abs(omega2[1:])) + 1
    for group in np.split(np.arange(len(omega2)), ends):
        part = shapes[:, group]
        out[:, group] = part @ np.linalg.eigh(part.T @ (some[:, None] * part))[1]
    return out * np.where(some @ out < 0, -1.0, 1.0)


def respond(body: Body, force: np.ndarray, ground=None) -> np.ndarray:
    """Static displacement (3N, k) m under the nodal forces (3N, k) N."""
    K = body.stiffness if ground is None else body.stiffness + ground
    free = body.free if ground is None else np.arange(K.shape[0])
    out = np.zeros(force.shape)
    out[free] = splu(K[free][:, free].tocsc()).solve(np.ascontiguousarray(force[free]))
    return out


# --- the objects ------------------------------------------------------------------------------


def stuff(rng) -> dict:
    """Density and Poisson ratio of a jelly or a rubber."""
    return {"density": rng.uniform(900, 1200), "poisson": rng.choice([0.42, 0.45, 0.47, 0.48])}


def disc(u: np.ndarray) -> np.ndarray:
    """The square -1..1 (N, 2) mapped on the unit disc."""
    return u * np.sqrt(1 - u[:, ::-1] ** 2 / 2)


def bar(rng, symmetric: bool = False, fine: int = 1) -> Body:
    """A bar clamped at x = 0, flatter in z than in y unless it is to be square."""
    length, side = rng.uniform(0.08, 0.18), rng.uniform(0.1, 0.16)
    flat = rng.uniform(1.12, 1.3)
    size = length * np.array([1, side * (1 if symmetric else flat), side])
    body = build(
        "bar", lambda u: size * (u - [0, 0.5, 0.5]), (13 * fine, 3 * fine, 3 * fine),
        crowded=(1.3, 1, 1), axis=[1, 0, 0], swing=[0, 0, 1],
        surface_counts=(16, 2, 2), **stuff(rng),
    )  # fmt: skip
    return tuned(body, rng.uniform(2.5, 9))


def pudding(rng, symmetric: bool = False, fine: int = 1) -> Body:
    """A truncated cone on a plate."""
    base, taper = rng.uniform(0.035, 0.06), rng.uniform(0.6, 0.85)
    height = base * rng.uniform(1.1, 1.7)

    def maps(u):
        radius = base * (1 - (1 - taper) * u[:, 2:])
        return np.hstack([radius * disc(2 * u[:, :2] - 1), height * u[:, 2:]])

    body = build(
        "pudding", maps, (4 * fine, 4 * fine, 5 * fine), crowded=(1, 1, 1.35), axis=[0, 0, 1],
        swing=[1, 0, 0], surface_counts=(9, 9, 7), **stuff(rng),
    )  # fmt: skip
    return tuned(body, rng.uniform(3, 9))


def strip(rng, symmetric: bool = False, fine: int = 1) -> Body:
    """A strip that hangs from its upper end at z = 0."""
    length, wide = rng.uniform(0.15, 0.25), rng.uniform(0.15, 0.22)
    thick = wide if symmetric else wide * rng.uniform(0.35, 0.5)
    size = length * np.array([thick, wide, 1])
    body = build(
        "strip", lambda u: size * (u - [0.5, 0.5, 1]), (2 * fine, 3 * fine, 15 * fine),
        crowded=(1, 1, -1.3), axis=[0, 0, -1], swing=[1, 0, 0],
        surface_counts=(2, 4, 22), **stuff(rng),
    )  # fmt: skip
    return tuned(body, rng.uniform(2, 6))


def bracket(rng, symmetric: bool = False, fine: int = 1) -> Body:
    """An L of square section: a leg that stands, an arm along x at its top."""
    thick, arm, leg = rng.uniform(0.012, 0.022), int(rng.integers(3, 6)), int(rng.integers(4, 8))
    counts = 2 * fine * np.array([arm, 1, leg])
    size = thick * np.array([arm, 1, leg])

    def keep(centre):
        return (centre[:, 0] < 1 / arm) | (centre[:, 2] > 1 - 1 / leg)

    body = build(
        "bracket", lambda u: size * (u - [0, 0.5, 0]), tuple(counts), axis=[0, 0, 1],
        swing=[0, 1, 0] if rng.random() < 0.5 else [1, 0, 0], path=[1, 0, 1], keep=keep,
        **stuff(rng),
    )  # fmt: skip
    return tuned(body, rng.uniform(2, 7))


def jelly(rng, symmetric: bool = False, fine: int = 1) -> Body:
    """A tall jelly of elliptic section that narrows upwards."""
    radius, flat = rng.uniform(0.018, 0.03), rng.uniform(1.12, 1.35)
    height, taper = radius * rng.uniform(3.2, 4.6), rng.uniform(0.1, 0.35)
    section = radius * np.array([1, 1 if symmetric else flat])

    def maps(u):
        narrow = 1 - taper * u[:, 2:] ** 2
        return np.hstack([narrow * section * disc(2 * u[:, :2] - 1), height * u[:, 2:]])

    body = build(
        "jelly", maps, (4 * fine, 4 * fine, 8 * fine), crowded=(1, 1, 1.3), axis=[0, 0, 1],
        swing=[1, 0, 0], surface_counts=(8, 8, 13), **stuff(rng),
    )  # fmt: skip
    return tuned(body, rng.uniform(2.5, 8))


OBJECTS = {"bar": bar, "pudding": pudding, "strip": strip, "bracket": bracket, "jelly": jelly}
