"""Physical forces at nodes, in reduced coordinates. Each is -(something) against the motion.

`row` (r,) is the motion of a node in one direction: its displacement is row . q, and a
force F there does the generalized work row * F. `steepest(reach)` is the most, N/m, by which a
force at a node grows within `reach` m of its rest: what a step of the integrator must resolve;
so is `fastest(light)`, a rate.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass(eq=False)
class Spring:
    """Any elastic law F(x) at a node: cubic, sinh, quadratic, bilinear, a stop."""

    row: np.ndarray
    law: object  # callable x (m) -> N, positive pushes back

    def force(self, q, v, t):
        return -self.row * self.law(self.row @ q)

    def steepest(self, reach):
        x = max(reach, 1e-9) * np.linspace(-1, 1, 401)
        return float(np.abs(np.gradient([self.law(place) for place in x], x)).max())


@dataclass(eq=False)
class Rub:
    """Coulomb friction through a stiff bristle: f = clip(f0 + k (x - x0), -F, F).

    Jenkins' element (elastic presliding, then slip at constant force). `limit(speed)` may vary.
    """

    row: np.ndarray
    limit: object  # callable speed (m/s) -> N
    bristle: float  # N/m
    held: float = 0.0  # N at the last commit
    place: float = 0.0  # m at the last commit

    def pull(self, q, v):
        top = self.limit(abs(self.row @ v))
        return min(max(self.held + self.bristle * (self.row @ q - self.place), -top), top)

    def force(self, q, v, t):
        return -self.row * self.pull(q, v)

    def commit(self, q, v, t):
        self.held, self.place = self.pull(q, v), self.row @ q

    def steepest(self, reach):
        return self.bristle


@dataclass(eq=False)
class PlaneRub:
    """Coulomb friction of a place that slides any way in a plane: the bristle is drawn along."""

    row: np.ndarray  # (2, r)
    limit: float  # N
    bristle: float  # N/m
    held: np.ndarray = field(default_factory=lambda: np.zeros(2))  # N at the last commit
    place: np.ndarray = field(default_factory=lambda: np.zeros(2))  # m at the last commit

    def pull(self, q):
        tried = self.held + self.bristle * (self.row @ q - self.place)
        return tried * min(1.0, self.limit / max(float(np.linalg.norm(tried)), 1e-300))

    def force(self, q, v, t):
        return -self.pull(q) @ self.row

    def commit(self, q, v, t):
        self.held, self.place = self.pull(q), self.row @ q

    def steepest(self, reach):
        return self.bristle


@dataclass(eq=False)
class Drag:
    """-c |v| v per unit of surface seen from the motion: dF = -c v (n . v), where n . v > 0."""

    motion: np.ndarray  # (3 S, r) of the surface nodes
    area: np.ndarray  # (S, 3) m2 outward
    coefficient: float  # kg/m3

    def force(self, q, v, t):
        u = (self.motion @ v).reshape(-1, 3)
        seen = np.maximum(np.einsum("si,si->s", self.area, u), 0)
        return -self.coefficient * (((seen[:, None] * u).ravel()) @ self.motion)


@dataclass(eq=False)
class Fading:
    """The stiffness follows time: -(share(t)) K1 q, K1 the part that changes."""

    K: np.ndarray  # (r, r)
    share: object  # callable t (s) -> 1

    def force(self, q, v, t):
        return -self.share(t) * (self.K @ q)


@dataclass(eq=False)
class Shaken:
    """The support moves by s(t): inertia -V^T M d s''(t), in coordinates that ride on it."""

    inertia: np.ndarray  # (r,) V^T M d; (r, n) of n ways d that it goes
    acceleration: object  # callable t (s) -> m/s2; (n,)

    def force(self, q, v, t):
        return -np.dot(self.inertia, self.acceleration(t))


@dataclass(eq=False)
class Brake:
    """A dashpot at a node that is felt only while the node is near its rest place."""

    row: np.ndarray
    damping: float  # N s/m
    reach: float  # m

    def force(self, q, v, t):
        near = np.exp(-((self.row @ q / self.reach) ** 2))
        return -self.row * (self.damping * near * (self.row @ v))

    def fastest(self, light):
        """1/s at which it stops a node of that mobility, 1/kg."""
        return self.damping * light


@dataclass(eq=False)
class Touch:
    """A pad that is on during some spells only: a spring and a dashpot at a node."""

    row: np.ndarray
    stiffness: float  # N/m
    damping: float  # N s/m
    spells: list = field(default_factory=list)  # (from, to) s

    def force(self, q, v, t):
        if any(a <= t < b for a, b in self.spells):
            return -self.row * (self.stiffness * (self.row @ q) + self.damping * (self.row @ v))
        return 0 * self.row

    def steepest(self, reach):
        return self.stiffness
