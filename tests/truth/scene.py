"""One filming session, drawn by seed: how the body is let go, who watches, for how long."""

from dataclasses import dataclass, field

import numpy as np

from . import bodies, forces, reduced

MODES = 12
STEPS = 220  # integration steps in a period of the lowest mode


@dataclass(eq=False)
class Scene:
    """What is the same with and without the planted effect."""

    body: bodies.Body
    ratio: np.ndarray  # (MODES,) damping ratios
    release: str  # "pull" | "knock" | "gravity"
    node: int  # where it is pulled or knocked
    direction: np.ndarray  # (3,) unit
    amplitude: float  # m, of that node
    markers: list  # nodes of the markers on the object, the one that moves most first
    support: list  # nodes of the markers on the support
    fps: float
    frames: int
    before: int = 0  # frames at rest before the release
    start: float | None = 0.0  # s, as the case gives it; None = left out
    camera: object = None  # camera.Camera; None = 3-D tracks
    gravity: np.ndarray | None = None  # (3,) m/s2, given in the case
    hold: float = 5.0  # s, how long it was held before the release
    touched: list = field(default_factory=list)  # nodes that forces act on
    said: dict = field(default_factory=dict)  # what the case states otherwise than it is
    declared: tuple = ("viscous_damping",)
    loads: list = field(default_factory=list)  # (node, kg) known to the case
    weighed: np.ndarray | None = None  # (3,) gravity in the case of a mesh in equilibrium
    limit: float = 0.0  # Hz: modes above are left in peace by the release
    margin: float = 1.0  # how much longer to simulate than to film
    plain: tuple | None = None  # the system with no planted change of the body, once it is known
    without: dict = field(default_factory=dict)  # what a linear fit leaves when nothing is planted
    needs: dict = field(default_factory=dict)  # what the planted effects asked for
    plane: bool = False  # what rubs does so sideways too, a support goes two ways
    pinhole: bool = False  # the case declares a pinhole camera

    @property
    def duration(self) -> float:
        return self.frames / self.fps

    @property
    def period(self) -> float:
        return 1 / bodies.modes(self.body, 1)[0][0]


def nodal(body, node: int, direction) -> np.ndarray:
    """(3N,) unit force at a node."""
    out = np.zeros(3 * len(body.nodes))
    out[3 * node : 3 * node + 3] = direction
    return out


def grip(body, node: int) -> np.ndarray:
    """(N,) weights: the patch of surface around `node` that a finger or spoon holds."""
    skin = places(body)
    radius = 0.22 * np.ptp(body.nodes, axis=0).min()
    near = skin[np.linalg.norm(body.nodes[skin] - body.nodes[node], axis=1) <= radius]
    share = np.zeros(len(body.nodes))
    share[near] = 1 / len(near)
    return share


def system_of(scene: Scene, body, ground=None) -> reduced.System:
    """The damped reduced system with static responses at every touched node."""
    push = [np.outer(grip(body, scene.node), scene.direction).ravel()]
    push += [nodal(body, n, scene.direction) for n in dict.fromkeys(scene.touched)]
    if scene.release == "gravity":
        push.append(body.mass @ np.tile(scene.gravity, len(body.nodes)))
    plain = reduced.reduce(body, MODES, np.array(push).T, ground)
    ratio = np.full(plain.size, 0.4)
    ratio[:MODES] = scene.ratio
    return reduced.damped(plain, ratio)


def start_of(scene: Scene, system, acting=()) -> tuple[np.ndarray, np.ndarray]:
    """State at the release and the rest position (r,) that `q` is counted from.

    Hands and threads let go in some milliseconds: what lies above the frame rate stays quiet.
    """
    soft = 1 / (1 + (system.frequency / (0.66 * scene.limit)) ** 4)
    soft[system.frequency > scene.limit] = 0
    r = system.size
    q, v, rest = np.zeros(r), np.zeros(r), np.zeros(r)
    if scene.release == "gravity":
        load = system.basis.T @ (scene.body.mass @ np.tile(scene.gravity, len(scene.body.nodes)))
        rest = np.linalg.solve(system.K, load)
        q = -rest
    row = np.outer(grip(scene.body, scene.node), scene.direction).ravel() @ system.basis
    if scene.release == "pull":
        q = settle(system, row * scene.amplitude / (row @ np.linalg.solve(system.K, row)), acting)
    if scene.release == "knock":
        v = np.linalg.solve(system.M, row) * soft
        first = system.frequency[0] * 2 * np.pi
        v *= scene.amplitude * first / max(abs(row @ v), 1e-30)
    q = q * soft if scene.release == "pull" else q
    parts = [q, v]
    if system.branch is not None:
        parts.append(q * (1 - np.exp(-scene.hold / system.branch[1])))
    return np.concatenate(parts), rest


def settle(system, load: np.ndarray, acting) -> np.ndarray:
    """Static (r,) under `load` and the elastic forces among `acting`, by damped Newton steps."""
    q = np.linalg.solve(system.K, load)
    springs = [one for one in acting if isinstance(one, forces.Spring)]
    for _ in range(40 if springs else 0):
        x = [s.row @ q for s in springs]
        dx = 1e-7 * max(map(abs, x)) + 1e-12
        tangent, residual = system.K.copy(), load - system.K @ q
        for s, place in zip(springs, x, strict=True):
            slope = (s.law(place + dx) - s.law(place - dx)) / (2 * dx)
            tangent = tangent + slope * np.outer(s.row, s.row)
            residual = residual - s.row * s.law(place)
        q = q + 0.7 * np.linalg.solve(tangent, residual)
    return q


def places(body) -> np.ndarray:
    """Free surface nodes."""
    skin = np.unique(body.faces)
    return skin[~body.pinned[skin]]


def pick(rng, body, low: float, high: float, off_centre: bool = False) -> int:
    """A free surface node between two heights (0 held, 1 free end)."""
    skin = places(body)
    inside = skin[(body.height[skin] >= low) & (body.height[skin] <= high)]
    if off_centre:
        away = np.linalg.norm(np.cross(body.nodes[inside], body.axis), axis=1)
        inside = inside[away > 0.8 * away.max()]
    return int(rng.choice(inside))


def spread(rng, body, count: int, cluster=False) -> list:
    """`count` markers over the free surface, the first at the free end; in a cluster, all there."""
    skin = places(body)
    chosen = [int(rng.choice(skin[body.height[skin] > 0.93]))]
    heights = np.linspace(0.95 if cluster else 0.25, 1, max(count - 1, 1))[: count - 1]
    for h in heights:
        near = skin[abs(body.height[skin] - h) < 0.13]
        pool = np.setdiff1d(near, chosen)
        gap = np.min(
            np.linalg.norm(body.nodes[pool][:, None] - body.nodes[chosen][None], axis=2), axis=1
        )
        chosen.append(int(rng.choice(pool[gap >= np.quantile(gap, 0.5)])))
    return chosen


def rate(rng, body, wish) -> tuple[float, float]:
    """Frames a second, and the highest frequency (Hz) that the release excites."""
    f, shapes = bodies.modes(body, 12)
    usual = np.array([60.0, 100, 120, 200, 240])
    if wish == "alias":
        along = np.linalg.norm(
            np.einsum("nim,i->nm", shapes.reshape(-1, 3, 12), body.swing), axis=0
        )
        along = along / np.linalg.norm(shapes, axis=0)
        second = f[(f > 3 * f[0]) & (along > 0.6)][0]
        slow = np.array([24.0, 25, 30, 50, 60, 100])
        slow = slow[(second > 0.54 * slow) & (second < 0.93 * slow) & (slow > 2.6 * f[0])]
        fps = float(rng.choice(slow)) if len(slow) else second / 0.7
        return fps, 1.3 * second
    if wish == "fast":
        usual = usual[-2:]
    if wish == "slow":
        usual = usual[:1]
    enough = usual[usual >= min(12 * f[0], usual[-1])]
    fps = float(rng.choice(enough))
    soft = (3, 4.5) if body.name == "pudding" else (7, 12)  # fingers are soft and slow
    return fps, min(0.45 * fps, rng.uniform(*soft) * f[0])


def falling(rng, body):
    """A body stiff enough to be let fall from its unloaded shape, and gravity in its axes."""
    gravity = -9.81 * body.swing + rng.normal(0, 0.3, 3)
    sag = respond_to(body, gravity)
    return bodies.tuned(
        body,
        bodies.modes(body, 1)[0][0] * np.sqrt(max(1.0, sag / (body.size * rng.uniform(0.05, 0.1)))),
    ), gravity


def respond_to(body, gravity) -> float:
    """Largest static motion (m) under gravity."""
    load = body.mass @ np.tile(gravity, len(body.nodes))
    u = bodies.respond(body, load[:, None]).reshape(-1, 3)
    return float(np.linalg.norm(u, axis=1).max())


def in_pairs(body, ratio: np.ndarray) -> np.ndarray:
    """(MODES,) damping ratios with those alike of modes that are one by the body's symmetry.

    Its damping has the symmetry that its stiffness has, so it cannot tell the two apart either.
    """
    pitch, ratio = bodies.modes(body, len(ratio))[0], ratio.copy()
    for k in np.flatnonzero(np.diff(pitch) < 1e-3 * pitch[1:]):
        ratio[k + 1] = ratio[k]
    return ratio


def aim(rng, body, needs) -> np.ndarray:
    """(3,) unit direction of the pull or knock."""
    side = np.cross(body.axis, body.swing)
    turn = rng.uniform(*needs["turn"]) if "turn" in needs else np.radians(rng.normal(0, 14))
    return np.cos(turn) * body.swing + np.sin(turn) * side


def held_markers(rng, body, needs) -> list:
    """Nodes of 0 to 2 markers on the support."""
    chance = needs.get("support")
    count = rng.choice([0, 1, 2]) if chance is None else (2 if rng.random() < chance else 0)
    held = np.flatnonzero(body.pinned)
    return [int(n) for n in rng.choice(held, int(count), replace=False)]


def draw(rng, body, needs: dict) -> Scene:
    """A session on `body`; `needs` are what the planted effect cannot do without."""
    release = needs.get("release") or ["pull"] * 4 + ["knock"] * 3 + ["gravity"]
    release = release if isinstance(release, str) else str(rng.choice(release))
    gravity, far = None, body.size * rng.uniform(*needs.get("amplitude", (0.04, 0.12)))
    if release == "gravity":
        body, gravity = falling(rng, body)
        far = respond_to(body, gravity)
    low, high = needs.get("damping", (0.01, 0.06))
    z = np.exp(rng.uniform(np.log(low), np.log(high)))
    ratio = z * np.concatenate([[1], np.sort(rng.uniform(0.8, 2.2, MODES - 1))])
    ratio = in_pairs(body, ratio)
    fps, limit = rate(rng, body, needs.get("fps"))
    cycles = np.clip(rng.uniform(1.8, 3.2) / (2 * np.pi * z), 8, 60)
    frames = int(np.clip(cycles / bodies.modes(body, 1)[0][0] * fps, 100, 600))
    reach = needs.get("reach") or ((0.85, 1.0) if release != "knock" else (0.4, 1.0))
    node = pick(rng, body, *reach, off_centre=needs.get("off_centre", False))
    before = 0
    if release != "gravity" and not needs.get("bare") and rng.random() < 0.4:
        before = int(rng.uniform(0.15, 0.5) * fps)
    start = before / fps if rng.random() < (0.75 if before else 0.5) else None
    return Scene(
        body, ratio, release, node, aim(rng, body, needs), far,
        spread(rng, body, int(rng.integers(*needs.get("markers", (3, 13)))), needs.get("cluster")),
        held_markers(rng, body, needs), fps, frames, before, start, gravity=gravity, limit=limit,
        needs=needs,
    )  # fmt: skip
