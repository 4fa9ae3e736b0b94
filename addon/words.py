"""The report in words for the panel. Pure text, kept per report."""

import json
import math
from functools import lru_cache

from .effect_words import NUMBERS, SAYS

UNITS = ((1.0, "m"), (0.01, "cm"), (0.001, "mm"))
VERDICTS = {
    "adequate": ("CHECKMARK", "Nothing is missing: what is left is noise"),
    "explained": ("INFO", "Something was missing, and is found"),
    "unexplained": ("QUESTION", "Something is missing that is not known"),
    "refused": ("ERROR", "The recording cannot decide"),
}


@lru_cache(maxsize=8)
def report(text: str) -> dict:
    """The parsed report; each is parsed once, however often it is drawn."""
    return json.loads(text)


def number(estimate: dict, scale: float = 1.0, digits: int = 3) -> str:
    """A value with half of its 95 % interval."""
    value = estimate["value"] * scale
    low, high = (x * scale for x in estimate.get("ci95") or (0, 0))
    half = (high - low) / 2
    if not half > 5e-4 * abs(value):  # so sure that its digits would fill the line
        return f"{value:.{digits + 1 if half else digits}g}"
    places = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{places}f} ± {half:.{places}f}"


def share(part: float) -> str:
    """A fraction in per cent, three digits at most."""
    return f"{100 * part:.{0 if part >= 0.0995 else 1}f} %"


def sentence(text: str) -> str:
    """A line of the report with the effects' names as words."""
    text = name(text)
    return text[:1].upper() + text[1:]


def modulus(estimate: dict) -> str:
    """kPa or MPa, whichever reads better."""
    if estimate["value"] >= 1e6:
        return f"{number(estimate, 1e-6)} MPa"
    return f"{number(estimate, 1e-3)} kPa"


def size(metres: list[float], system: str) -> str:
    """Three lengths with their unit said once."""
    largest = max(metres)
    if system == "IMPERIAL":
        unit, name = (0.3048, "ft") if largest >= 0.3048 else (0.0254, "in")
    else:
        unit, name = next(u for u in UNITS if largest >= u[0] or u == UNITS[-1])
    places = max(0, 2 - math.floor(math.log10(max(largest / unit, 1e-9))))
    return " × ".join(f"{x / unit:.{min(places, 3)}f}" for x in metres) + f" {name}"


def name(effect: str) -> str:
    return effect.replace("_", " ")


def effect(found: dict) -> str:
    """One line: what was found, and what that is."""
    kind = found["name"]
    return name(kind).capitalize() + (f". {SAYS[kind]}" if kind in SAYS else "")


def numbers(found: dict) -> list[tuple[str, str]]:
    """(label, value) of each of the effect's numbers; lists of them stay in the report."""
    rows = []
    for key, value in found["parameters"].items():
        if not isinstance(value.get("value"), int | float):
            continue
        plain = (name(key).title(), 1, value.get("unit", "").removeprefix("1"))
        label, scale, unit = NUMBERS.get((found["name"], key), plain)
        rows.append((label, f"{number(value, scale)} {unit}".strip()))
    return rows


def wrapped(text: str, width: float, measure=len) -> list[str]:
    """Lines of at most `width`, in characters or as measured, broken between words."""
    lines, line = [], ""
    for word in text.split():
        if line and measure(f"{line} {word}") > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    return [*lines, line] if line else lines
