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


def system_of(scene: Scene, body, ground=None) -> reduced.System:
    """The damped reduced system with static responses at every touched node."""
    nodes = dict.fromkeys([scene.node, *scene.touched])
    push = [nodal(body, n, scene.direction) for n in nodes]
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
    soft = 1 / (1 + (system.frequency / (0.3 * scene.fps)) ** 4)
    soft[system.frequency > 0.45 * scene.fps] = 0
    r = system.size
    q, v, rest = np.zeros(r), np.zeros(r), np.zeros(r)
    if scene.release == "gravity":
        load = system.basis.T @ (scene.body.mass @ np.tile(scene.gravity, len(scene.body.nodes)))
        rest = np.linalg.solve(system.K, load)
        q = -rest
    row = scene.direction @ system.at(scene.node)
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


def pick(rng, body, low: float, high: float) -> int:
    """A free surface node between two heights (0 held, 1 free end)."""
    skin = places(body)
    inside = skin[(body.height[skin] >= low) & (body.height[skin] <= high)]
    return int(rng.choice(inside))


def spread(rng, body, count: int) -> list:
    """`count` markers over the free surface, the first at the free end."""
    skin = places(body)
    chosen = [int(rng.choice(skin[body.height[skin] > 0.93]))]
    heights = np.linspace(0.25, 1, max(count - 1, 1))[: count - 1]
    for h in heights:
        near = skin[abs(body.height[skin] - h) < 0.13]
        pool = np.setdiff1d(near, chosen)
        gap = np.min(
            np.linalg.norm(body.nodes[pool][:, None] - body.nodes[chosen][None], axis=2), axis=1
        )
        chosen.append(int(rng.choice(pool[gap >= np.quantile(gap, 0.5)])))
    return chosen


def draw(rng, body, needs: dict) -> Scene:
    """A session on `body`; `needs` are what the planted effect cannot do without."""
    first = bodies.modes(body, 1)[0][0]
    low, high = needs.get("damping", (0.01, 0.06))
    z = np.exp(rng.uniform(np.log(low), np.log(high)))
    ratio = z * np.concatenate([[1], np.sort(rng.uniform(0.8, 2.2, MODES - 1))])
    cycles = np.clip(rng.uniform(1.8, 3.2) / (2 * np.pi * z), 8, 60)
    choices = np.array([60.0, 100, 120, 200, 240])
    fps = needs.get("fps") or float(rng.choice(choices[choices >= min(12 * first, 120)]))
    frames = int(np.clip(cycles / first * fps, 100, 600))
    release = needs.get("release") or rng.choice(["pull", "pull", "knock"])
    side = np.cross(body.axis, body.swing)
    turn = np.radians(rng.normal(0, 14)) if "turn" not in needs else needs["turn"]
    direction = np.cos(turn) * body.swing + np.sin(turn) * side
    reach = needs.get("reach") or ((0.85, 1.0) if release == "pull" else (0.4, 1.0))
    markers = spread(rng, body, int(rng.integers(*needs.get("markers", (3, 13)))))
    held = np.flatnonzero(body.pinned)
    support = list(rng.choice(held, int(rng.choice([0, 1, 2])), replace=False))
    if needs.get("support"):
        support = list(rng.choice(held, 2, replace=False))
    before = 0
    if release != "gravity" and not needs.get("bare") and rng.random() < 0.4:
        before = int(rng.uniform(0.15, 0.5) * fps)
    start = before / fps if rng.random() < (0.75 if before else 0.5) else None
    return Scene(
        body, ratio, release, pick(rng, body, *reach), direction,
        body.size * rng.uniform(0.04, 0.12), markers, [int(n) for n in support],
        fps, frames, before, start,
    )  # fmt: skip
