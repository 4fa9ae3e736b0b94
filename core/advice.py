"""Plain words for the artist: what to film, weigh or measure next."""

from .effects import BY_NAME

OUTSIDE = (
    "Young's modulus takes up any error of density, size and capture rate alike: weigh the object, "
    "measure its length, and film a running clock once."
)
ONE_MODE = (
    "Only one mode was seen: knock the object elsewhere or pull it another way, and put markers "
    "along its length, so that supports, added masses and gradients can be told apart."
)


def advise(found: list[str], twins: list[str], seen_modes: int, verdict: str) -> list[str]:
    """What would settle the findings, most useful first, each line once."""
    lines = []
    for name in [*found, *twins]:
        effect = BY_NAME.get(name)
        if effect is not None and (effect.twins or name in twins):
            lines.append(f"{name}: {effect.settle}.")
    if verdict == "unexplained":
        lines.append(
            "Something acts that is not in the list of effects: film the same release once at half "
            "and once at twice the amplitude, and look closely at the supports and at loose parts."
        )
    if seen_modes < 2:
        lines.append(ONE_MODE)
    lines.append(OUTSIDE)
    return list(dict.fromkeys(lines))
