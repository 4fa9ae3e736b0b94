"""Marks for a report against the truth, and the tables that tell them."""

from collections import Counter

import numpy as np

MOST = 1.1  # held-out error over that of the true model refitted, at most
SHOWN = 1.5  # declared-model error over the floor from which an effect counts as shown
FAILED = (
    "planted", "seed", "object", "ratio", "found", "twins named",
    "held-out error before, after, noise", "refitted", "E off by",
)  # fmt: skip


def mark(truth: dict, report: dict, before: float | None = None) -> dict:
    """One flat record of a case.

    truth: as `tests.truth.make` returns it. report: as the contract says. before: Young's modulus
    (Pa) of the declared model, without the effects that were found.
    """
    effects = report["diagnosis"]["effects"]
    named = [e["name"] for e in effects]
    twins = sorted({t for e in effects for t in e["twins"]})
    modulus = report["youngs_modulus"]["material"]["value"]
    covered = coverage(truth, effects)
    return {
        "kind": truth["kind"],
        "group": group(truth["kind"]),
        "seed": truth["seed"],
        "object": truth["object"],
        "ratio": truth["ratio"],
        "ratios": truth["ratios"],
        "planted": truth["effects"],
        "right": truth["acceptable"],
        "wanted": truth["verdict"],
        "verdict": report["diagnosis"]["verdict"],
        "named": named,
        "twins": twins,
        "floor": truth["floor_tail"],
        "before": report["error"]["before"],
        "after": report["error"]["after"],
        "own_floor": report["error"]["floor"],
        "inside": covered[0],
        "parameters": covered[1],
        "modulus_error": modulus / truth["youngs_modulus"] - 1,
        "modulus_before": None if before is None else before / truth["youngs_modulus"] - 1,
        "modulus_counts": truth["modulus_identifiable"],
    }


def group(kind: str) -> str:
    head = kind.split(":")[0]
    return head if head in ("null", "two", "absent", "twin", "trap") else "single"


def coverage(truth: dict, effects: list) -> tuple[int, int]:
    """How many planted numbers lie in the report's intervals, of how many that it gives."""
    inside = total = 0
    for effect in effects:
        planted = truth["parameters"].get(effect["name"], {})
        for key, found in effect["parameters"].items():
            true = np.atleast_1d(planted.get(key))
            if true.dtype.kind not in "if" or "ci95" not in found:
                continue
            if np.ndim(found["value"]) or found["ci95"] is None:
                continue
            low, high = found["ci95"]
            total += 1
            inside += bool(((low <= true) & (true <= high)).any())
    return inside, total


def first_is_right(m: dict) -> bool:
    return bool(m["named"]) and m["named"][0] in m["right"]


def in_the_set(m: dict) -> bool:
    return bool(set(m["named"] + m["twins"]) & set(m["right"]))


def needs_refit(m: dict) -> bool:
    """Whether what a rightly named effect leaves is more than a tenth above the noise, so that the
    true model's own error must be known.
    """
    shown = m["group"] == "single" and m["ratio"] >= SHOWN
    return shown and first_is_right(m) and m["after"] > MOST * m["floor"]


def is_as_good(m: dict) -> bool:
    """Whether what is left is at most a tenth more than what the true model, refitted, leaves."""
    own = m.get("refitted") or 0.0
    return m["after"] <= MOST * max(m["floor"], own if own < m["before"] else 0.0)


def false_extra(m: dict) -> bool:
    """An effect is named beside the planted ones, or one for nothing."""
    return bool(set(m["named"]) - set(m["right"]))


def share(part, whole) -> str:
    whole = list(whole)
    hit = sum(map(bool, map(part, whole)))
    return f"{hit} of {len(whole)}" + (f" ({hit / len(whole):.1%})" if whole else "")


def median(values) -> str:
    values = [v for v in values if v is not None]
    return f"{np.median(values):.2%} ({len(values)})" if values else "-"


def criteria(marks: list) -> list:
    """Rows (what, wanted, measured) of the table of criteria."""
    of = {g: [m for m in marks if m["group"] == g] for g in {m["group"] for m in marks}}
    single = [m for m in of.get("single", []) if m["ratio"] >= SHOWN]
    both = of.get("two", [])
    shown = [m for m in both if min(m["ratios"].values()) >= SHOWN]
    right = [m for m in single if first_is_right(m)]
    known = [m for m in right if m["modulus_counts"]]
    timed = sorted(m["diagnosis_seconds"] for m in marks if "diagnosis_seconds" in m)
    inside, total = (sum(m[k] for m in right) for k in ("inside", "parameters"))
    return [
        ("1 one effect: named first", "90 %", share(first_is_right, single)),
        ("- the same, with nothing left unexplained", "-",
         share(lambda m: first_is_right(m) and m["verdict"] == "explained", single)),
        ("1 one effect: in the named set with twins", "97 %", share(in_the_set, single)),
        ("2 nothing there: adequate", "98 %", share(is_adequate, of.get("null", []))),
        ("2 absorbed by Young's modulus or damping: adequate", "98 %",
         share(is_adequate, of.get("trap", []))),
        ("3 not in the library: unexplained", "90 %",
         share(lambda m: m["verdict"] == "unexplained", of.get("absent", []))),
        ("4 two effects: at least one named", "95 %",
         share(lambda m: set(m["named"]) & set(m["right"]), both)),
        ("4 two effects: both named", "60 %",
         share(lambda m: set(m["right"]) <= set(m["named"]), both)),
        ("4 two effects, each shown alone: both named", "-",
         share(lambda m: set(m["right"]) <= set(m["named"]), shown)),
        ("4 two effects: a false extra", "at most 20 %", share(false_extra, both)),
        ("- honest twins: one of them first", "-", share(first_is_right, of.get("twin", []))),
        ("5 held-out error after, over that of the true model refitted: at most 1.1", "90 %",
         share(is_as_good, right)),
        ("- the same over the noise alone", "-",
         share(lambda m: m["after"] <= MOST * m["floor"], right)),
        ("5 parameters whose interval holds the truth", "90 %",
         f"{inside} of {total}" + (f" ({inside / total:.1%})" if total else "")),
        ("6 Young's modulus, median error with the effect", "3 %",
         median(abs(m["modulus_error"]) for m in known)),
        ("6 the same without", "-",
         median(abs(m["modulus_before"]) for m in known if m["modulus_before"] is not None)),
        ("7 diagnosis, 90th percentile", "10 s",
         f"{np.quantile(timed, 0.9):.1f} s (median {np.median(timed):.1f} s)" if timed else "-"),
    ]  # fmt: skip


def is_adequate(m: dict) -> bool:
    return m["verdict"] == "adequate"


def called(m: dict) -> str:
    """What the report calls a case: the first name, or else the verdict."""
    if m["verdict"] in ("explained", "unexplained") and m["named"]:
        name = " + ".join(m["named"]) if m["group"] == "two" else m["named"][0]
        return name if m["verdict"] == "explained" else f"({name})"
    return m["verdict"]


def confusion(marks: list) -> list:
    """Rows (planted, number, what it was called and how often), as `called` says."""
    rows = []
    for kind in dict.fromkeys(m["kind"] for m in marks):
        own = [m for m in marks if m["kind"] == kind]
        calls = Counter(called(m) for m in own).most_common()
        rows.append((kind, len(own), ", ".join(f"{name} {n}" for name, n in calls)))
    return rows


def is_as_planted(m: dict) -> bool:
    """Whether a case gets its verdict and, first, its name, or both of two; where it is explained,
    with no more than a tenth above the noise left.
    """
    if m["group"] == "single" and m["ratio"] < SHOWN:  # does not show
        return True
    if m["group"] == "absent":
        return m["verdict"] == "unexplained"
    if m["group"] in ("null", "trap"):
        return is_adequate(m)
    names = set(m["right"]) == set(m["named"]) if m["group"] == "two" else first_is_right(m)
    return names and m["verdict"] == m["wanted"] and m["after"] <= MOST * m["floor"]


def failed(marks: list) -> list:
    """Rows, headed by `FAILED`, of the cases that are not as planted."""
    return [_row(m) for m in marks if not is_as_planted(m)]


def _row(m: dict) -> tuple:
    names = " + ".join(m["named"]) or m["verdict"]
    found = f"({names})" if m["named"] and m["verdict"] == "unexplained" else names
    errors = ", ".join(f"{m[key]:.3f}" for key in ("before", "after", "floor"))
    refitted = "-" if m.get("refitted") is None else f"{m['refitted']:.3f}"
    return (
        m["kind"], m["seed"], m["object"], f"{m['ratio']:.1f}", found, ", ".join(m["twins"]) or "-",
        errors, refitted, f"{m['modulus_error']:+.1%}",
    )  # fmt: skip


def table(head: tuple, rows: list) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    cells = [[str(cell).replace("|", " or ") for cell in line] for line in lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in cells)
