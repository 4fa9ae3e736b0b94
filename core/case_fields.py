"""What a table of case.toml may hold: each field's check, and refusals that name the field."""

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .errors import CaseError

HUGE = 1e150  # a number whose square is still one
HUGE_INDEX = 2**31


@dataclass(frozen=True)
class Field:
    """One key of a table. `check(value, where)` gives the value or raises CaseError."""

    check: Callable
    required: bool = False
    default: object = None


def read_table(table, fields: Mapping[str, Field], where: str) -> dict:
    """Every field of `fields`, checked, by name; `where` begins each message.

    Raises CaseError for a field that is unknown (with a suggestion), missing, or not as checked.
    """
    head = where.rstrip(":")
    if not isinstance(table, dict):
        raise CaseError(f"{head} is {shown(table)}; a table of fields is needed. Write it as one.")
    for name in table:
        if name not in fields:
            raise CaseError(f"{head} has the unknown field {name}. {suggestion(name, fields)}")
    values = {}
    for name, field in fields.items():
        if name in table:
            values[name] = field.check(table[name], f"{where} {name}")
        elif field.required:
            raise CaseError(f"{head} lacks the field {name}. Add it.")
        else:
            values[name] = field.default
    return values


def suggestion(name: str, known) -> str:
    """A closing sentence: the nearest of the `known` names, or the first of them."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    if near:
        return f"Did you mean {near[0]}?"
    if not known:
        return "Add it."
    listed = sorted(known)
    return f"Known here: {', '.join(listed[:12])}{', ...' if len(listed) > 12 else ''}."


def shown(value) -> str:
    """The value as a person would write it into the file, cut at 40 characters."""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    text = f'"{value}"' if isinstance(value, str) else text
    return text if len(text) <= 40 else text[:37] + "..."


# --- checks: each returns a function (value, where) -> value ------------------------------------


def text() -> Callable:
    """A string on one line that is not blank."""

    def check(value, where):
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise CaseError(
                f"{where} = {shown(value)}; a text in quotes, on one line, is needed. Correct it."
            )
        return value

    return check


def choice(*allowed: str) -> Callable:
    """One of the `allowed` strings."""

    def check(value, where):
        if value not in allowed:
            *most, last = (f'"{one}"' for one in allowed)
            wanted = f"{', '.join(most)} or {last}"
            raise CaseError(f"{where} = {shown(value)}; {wanted} is needed. Choose one of them.")
        return value

    return check


def flag() -> Callable:
    """true or false."""

    def check(value, where):
        if not isinstance(value, bool):
            raise CaseError(f"{where} = {shown(value)}; true or false is needed. Correct it.")
        return value

    return check


def number(
    *,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    below: float | None = None,
    unit: str = "",
    hint: str = "Correct it.",
) -> Callable:
    """A finite number with low <= x <= high and above < x < below, in `unit`."""
    wanted = _range_text(low, high, above, below)

    def check(value, where):
        x = _finite(value, where, f"a number{f' in {unit}' if unit else ''}")
        inside = (
            (low is None or x >= low)
            and (high is None or x <= high)
            and (above is None or x > above)
            and (below is None or x < below)
        )
        if not inside:
            what = f"{wanted} {unit}".strip()
            raise CaseError(f"{where} = {shown(value)}; {what} is needed. {hint}")
        return x

    return check


def vector(size: int, *, high: float | None = None, unit: str = "") -> Callable:
    """`size` finite numbers, none larger in size than `high`: an array (size,) in `unit`."""
    what = f"a list of {size} numbers{f' in {unit}' if unit else ''}"

    def check(value, where):
        if not isinstance(value, list) or len(value) != size:
            raise CaseError(f"{where} = {shown(value)}; {what} is needed. Correct it.")
        x = np.array([_finite(one, where, what) for one in value])
        if high is not None and np.abs(x).max() > high:
            raise CaseError(
                f"{where} = {shown(value)}; no more than {high:g} {unit} on an axis is needed. "
                "Give it in SI units."
            )
        return x

    return check


def integers(*, size: int | None = None, low: int = 0) -> Callable:
    """A list of whole numbers >= `low`, of length `size` or at least one: an int array."""
    what = "one or more whole numbers" if size is None else f"{size} whole numbers"

    def check(value, where):
        good = isinstance(value, list) and (len(value) == size if size else len(value) > 0)
        if not good or not all(type(one) is int and low <= one < HUGE_INDEX for one in value):
            raise CaseError(
                f"{where} = {shown(value)}; a list of {what}, none below {low}, is needed. "
                "Correct it."
            )
        return np.array(value, int)

    return check


def texts(known: tuple[str, ...]) -> Callable:
    """A list of names out of `known`, none twice: a tuple."""

    def check(value, where):
        if not isinstance(value, list):
            raise CaseError(
                f"{where} = {shown(value)}; a list of names is needed. Use [] for none."
            )
        for name in value:
            if name not in known:
                raise CaseError(
                    f"{where}: {shown(name)} is not a known name. {suggestion(str(name), known)}"
                )
        if len(set(value)) < len(value):
            raise CaseError(f"{where} = {shown(value)}: a name stands there twice. Remove one.")
        return tuple(value)

    return check


def table(fields: Mapping[str, Field]) -> Callable:
    """A table of `fields`: a dict."""
    return lambda value, where: read_table(value, fields, _headed(where, "[{}]"))


def tables(fields: Mapping[str, Field], *, fewest: int = 0) -> Callable:
    """A list of `fewest` or more tables of `fields`: a list of dicts. Messages number them."""

    def check(value, where):
        head = _headed(where, "[[{}]]")
        if not isinstance(value, list) or len(value) < fewest:
            raise CaseError(
                f"{head} is {shown(value)}; {fewest} or more such tables are needed. "
                "Mind the double brackets."
            )
        return [read_table(one, fields, f"{head} {k + 1}") for k, one in enumerate(value)]

    return check


def _headed(where: str, form: str) -> str:
    """The last word as a header, as it stands in the file, unless it is within a table."""
    start, _, name = where.rpartition(" ")
    return where if "]" in start else f"{start} {form.format(name)}"


def _finite(value, where: str, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise CaseError(f"{where} = {shown(value)}; {what} is needed. Correct it.")
    if not abs(value) < HUGE:
        raise CaseError(f"{where} = {shown(value)}; {what}, finite, is needed. Correct it.")
    return float(value)


def _range_text(low, high, above, below) -> str:
    left = f"{low:g} <= " if low is not None else f"{above:g} < " if above is not None else ""
    right = f" <= {high:g}" if high is not None else f" < {below:g}" if below is not None else ""
    if left and not right:
        return f"{low:g} or more" if low is not None else f"more than {above:g}"
    return f"{left}x{right}"
