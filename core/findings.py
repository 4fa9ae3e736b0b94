"""What the body's pitches and shapes add to the report."""

from dataclasses import dataclass

from .residual import Error


@dataclass(frozen=True, eq=False)
class Findings:
    """What the modal layer adds to the report."""

    verdict: str
    effects: list
    ranking: list
    advice: list
    warnings: list
    before: Error | None = None  # of the declared body
    rows: tuple = ()  # (name, Error): further rows of the chain
    misfit: tuple[float, float] = (0.0, 0.0)  # of pitches and of shapes, declared body
    # effects in time that the found change of the body makes needless
    instead: tuple[str, ...] = ()
    mesh_pitch: dict | None = None  # computed mode -> Hz at 1 Pa with the effect
    # computed mode -> least and most Young's modulus over the best, by how far the effect is known
    # and by the sag
    moduli: dict | None = None
    doubtful: bool = False  # whether the body is another one, and what it is no more than a guess
    stiffer: float = 1.0  # dynamic over static stiffness of the first mode
    stiffest: float = 1.0  # the same at most, where that is in doubt
    least_stiff: float = 1.0  # and at least
    minor: tuple = ()  # (name, share of the motion) of the camera's effects that are too small

    def mesh_frequency(self, own: float, j: int) -> float:
        """Hz at 1 Pa of computed mode j with the found effect of the body in it."""
        return own if not self.mesh_pitch else self.mesh_pitch.get(j, own)

    def modulus_span(self, j: int) -> tuple[float, float]:
        """The least and the most Young's modulus over the best one, by computed mode j's pitch."""
        return (1.0, 1.0) if not self.moduli else self.moduli.get(j, (1.0, 1.0))

    def budget(self, shares: dict[str, float]) -> dict[str, float]:
        """The time layer's budget with the energy that the declared body's own error adds."""
        if self.before is None:
            return shares
        pitch, shape = self.misfit
        whole = 0.5 * (pitch + shape) + 1e-300
        body = {"frequency ratios": 0.5 * pitch / whole * 0.5, "shapes": 0.5 * shape / whole * 0.5}
        rest = 1 - sum(body.values())
        return {name: share * rest for name, share in shares.items()} | body
