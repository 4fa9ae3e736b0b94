"""report.json and ringdown.json: their form, checked to the letter before a byte is written."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .case_schema import EFFECT_NAMES
from .data import Estimate
from .files import written_whole

DIGITS = 12  # significant ones in the file
VERDICTS = ("adequate", "explained", "unexplained", "refused")
WHOLE = 1e-6  # how far a budget's sum may be from 1


def estimate(value, low, high, unit: str | None = None) -> dict:
    """{"value", "ci95": [low, high]} and, unless it is None, "unit". Each a number or a list."""
    fields = {"value": _plain(value), "ci95": [_plain(low), _plain(high)]}
    return fields if unit is None else fields | {"unit": unit}


def estimate_of(noun: Estimate, *, unit: bool = True) -> dict:
    """The same of an Estimate, with or without its unit."""
    return estimate(noun.value, noun.low, noun.high, noun.unit if unit else None)


def write_report(report: dict, path: str | Path) -> None:
    """Check and write report.json, whole or not at all.

    Raises ValueError where the report is not as the contract says, CaseError where the file
    cannot be written.
    """
    check_report(report)
    write_json(report, path)


def write_ringdown(report: dict, path: str | Path) -> None:
    """Check and write ringdown.json, whole or not at all. Raises as `write_report`."""
    check_ringdown(report)
    write_json(report, path)


def write_json(content: dict, path: str | Path) -> None:
    """Write any JSON, whole or not at all.

    Floats are rounded to 12 significant digits. Raises ValueError for NaN and infinity, CaseError
    where the file cannot be written.
    """
    text = json.dumps(_plain(content), indent=1, allow_nan=False, ensure_ascii=False)
    with written_whole(path) as draft:
        draft.write_text(text + "\n", encoding="utf-8")


def check_report(report: dict) -> None:
    """Raises ValueError, naming the field, where `report` is not what the contract describes."""
    several = "takes" in report.get("error", ())
    error_form = REPORT["error"] | (TAKES if several else {})
    _check(report, REPORT | {"error": error_form}, "report")
    diagnosis, error = report["diagnosis"], report["error"]
    for k, one in enumerate(error.get("takes", ())):
        if one["held_out"] is None and one["fit"] is None:
            raise ValueError(f"report.error.takes[{k}]: held_out and fit are both null.")
    for name in ("floor", "before", "after"):
        if error[name] is None and diagnosis["verdict"] != "refused":
            raise ValueError(f"report.error.{name} is null, though the verdict is not refused.")
    if error["chain"] and error["chain"][0]["added"] is not None:
        raise ValueError(
            "report.error.chain[0].added: the first row is the declared model's, null."
        )
    budget = diagnosis["budget"]
    if budget and abs(sum(budget.values()) - 1) > WHOLE:
        raise ValueError(f"report.diagnosis.budget sums to {sum(budget.values())}, not to 1.")
    if diagnosis["verdict"] == "explained" and not diagnosis["effects"]:
        raise ValueError('report.diagnosis.verdict is "explained" and effects is empty.')
    for k, mode in enumerate(report["modes"]):
        if (mode["model_frequency_hz"] is None) != (mode["mac"] is None):
            raise ValueError(f"report.modes[{k}]: model_frequency_hz and mac are null together.")


def check_ringdown(report: dict) -> None:
    """The same for ringdown.json. A video without scale has `amplitude_px`, not `amplitude_m`."""
    _check(report, {"modes": _any_list, "warnings": [_text]}, "ringdown")
    for k, mode in enumerate(report["modes"]):
        unit = "amplitude_px" if "amplitude_px" in mode else "amplitude_m"
        axis = {unit: _interval(), "phase_rad": _interval()}
        fields = BARE_MODE | {unit: _at_least_zero, "aliases_hz": [_above_zero]}
        fields |= {"deflection": [{"pixel": [_real()], "u": axis, "v": axis}]}
        _check(mode, fields, f"ringdown.modes[{k}]")


# --- the form: a dict has exactly these keys, [form] is a list of it, a function checks a leaf ----


def _check(value, form, where: str) -> None:
    if isinstance(form, dict):
        _check_keys(value, form, where)
        for name, inner in form.items():
            _check(value[name], inner, f"{where}.{name}")
    elif isinstance(form, list):
        _any_list(value, where)
        for k, one in enumerate(value):
            _check(one, form[0], f"{where}[{k}]")
    else:
        form(value, where)


def _check_keys(value, form: dict, where: str) -> None:
    if not isinstance(value, dict):
        raise ValueError(f"{where} is {value!r}; an object is needed.")
    for name in form.keys() - value.keys():
        raise ValueError(f"{where}.{name} is missing.")
    for name in value.keys() - form.keys():
        raise ValueError(f"{where}.{name} is not in the contract.")


def _any_list(value, where: str) -> None:
    if not isinstance(value, list | tuple):
        raise ValueError(f"{where} is {value!r}; a list is needed.")


def _text(value, where: str) -> None:
    if not isinstance(value, str):
        raise ValueError(f"{where} is {value!r}; a string is needed.")


def _count(value, where: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise ValueError(f"{where} is {value!r}; a whole number above 0 is needed.")


def _real(low: float = -np.inf, high: float = np.inf, strict: bool = False) -> Callable:
    def check(value, where):
        number = isinstance(value, int | float | np.integer | np.floating)
        if isinstance(value, bool) or not number or not np.isfinite(value):
            raise ValueError(f"{where} is {value!r}; a finite number is needed.")
        if not low <= value <= high or (strict and value == low):
            raise ValueError(f"{where} is {value!r}; it must be from {low} to {high}.")

    return check


def _or_null(form: Callable) -> Callable:
    return lambda value, where: None if value is None else form(value, where)


def _one_of(allowed: tuple[str, ...]) -> Callable:
    def check(value, where):
        if value not in allowed:
            raise ValueError(f"{where} is {value!r}; one of {', '.join(allowed)} is needed.")

    return check


def _interval(*keys: str) -> Callable:
    """{"value", "ci95": [low, high]} and `keys`; low <= value <= high, number by number."""

    def check(value, where):
        _check_keys(value, dict.fromkeys(("value", "ci95", *keys)), where)
        for key in keys:
            _text(value[key], f"{where}.{key}")
        if _is_names(value["value"]):
            if value["ci95"] is not None:
                raise ValueError(f"{where}.ci95: names have no interval; null is needed.")
            return
        _any_list(value["ci95"], f"{where}.ci95")
        low, high = (np.asarray(one, float) for one in value["ci95"])
        middle = np.asarray(value["value"], float)
        if not (low.shape == middle.shape == high.shape and np.isfinite([low, middle, high]).all()):
            raise ValueError(f"{where} is {value!r}; finite numbers of one shape are needed.")
        if not ((low <= middle) & (middle <= high)).all():
            raise ValueError(f"{where} is {value!r}; its value is outside its own interval.")

    return check


def _is_names(value) -> bool:
    return isinstance(value, list | tuple) and all(isinstance(one, str) for one in value)


def _parameters(value, where: str) -> None:
    _check_keys(value, dict.fromkeys(value), where)
    for name, one in value.items():
        _interval("unit")(one, f"{where}.{name}")


def _shares(value, where: str) -> None:
    _check_keys(value, dict.fromkeys(value), where)
    for name, one in value.items():
        _share(one, f"{where}.{name}")


_share = _real(0, 1)
_at_least_zero = _real(0)
_above_zero = _real(0, strict=True)
_effect = _one_of(EFFECT_NAMES)

BARE_MODE = {"natural_frequency_hz": _interval(), "damping_ratio": _interval()}
MODE = BARE_MODE | {
    "amplitude_m": _at_least_zero,
    "model_frequency_hz": _or_null(_above_zero),
    "mac": _or_null(_share),
}
TAKES = {  # of the report's error, where there are several
    "takes": [
        {"take": _text, "held_out": _or_null(_at_least_zero), "fit": _or_null(_at_least_zero)}
    ]
}
EFFECT = {"name": _effect, "parameters": _parameters, "probability": _share, "twins": [_effect]}
REPORT = {
    "case": _text,
    "version": _text,
    "seconds": _at_least_zero,
    "mesh": {"nodes": _count, "tets": _count, "element": _text, "stiffening": _real()},
    "youngs_modulus": {"apparent": _interval("unit"), "material": _interval("unit")},
    "modes": [MODE],
    "error": {
        "floor": _or_null(_at_least_zero),
        "before": _or_null(_at_least_zero),
        "after": _or_null(_at_least_zero),
        "chain": [{"added": _or_null(_text), "held_out": _at_least_zero, "fit": _at_least_zero}],
    },
    "diagnosis": {
        "verdict": _one_of(VERDICTS),
        "effects": [EFFECT],
        "ranking": [{"name": _effect, "held_out": _at_least_zero, "probability": _share}],
        "budget": _shares,
        "advice": [_text],
        "minor": [{"name": _effect, "share": _share}],
    },
    "warnings": [_text],
}


def _plain(value):
    """The same in JSON's own types, floats rounded."""
    if isinstance(value, dict):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}")
    return value.item() if isinstance(value, np.generic) else value
