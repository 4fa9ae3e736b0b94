"""Planted cases through the whole loop: confusion matrix and table of criteria.

    python tests/suite.py [--count N] [--seed S] [--kinds null,two,relaxation,...] [--jobs 2]
                          [--out docs/confusion.md] [--records records.jsonl]

`--count`: cases of each kind; without it the whole suite. A record of every case is kept in
`--records`, and cases found there are not run again.
"""

import argparse
import json
import os
import re
import sys
import tempfile
import time
import tomllib
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # a process a core beats threads on such small matrices

from tests import scoring, seeded_tetwild  # noqa: E402
from tests.truth import KINDS, cases, make  # noqa: E402


def run_case(kind: str, seed: int) -> dict:
    """Make one case in a folder that goes away, calibrate it, and mark the report."""
    import core.pipeline as pipeline
    from core.errors import CoreError
    from core.tetwild import run_tetwild

    seeded_tetwild.use(run_tetwild)
    with tempfile.TemporaryDirectory() as folder:
        truth = make(kind, seed, folder)
        moments = {}

        def progress(fraction, text):
            moments.setdefault(text, time.monotonic())

        options = {"elements": truth["elements"]} if truth["elements"] else {}
        begun = time.monotonic()
        try:
            result = pipeline.calibrate_case(
                Path(folder) / "case.toml", progress=progress, **options
            )
        except CoreError as error:
            return refused(truth, str(error))
        ended = time.monotonic()
        report = result if isinstance(result, dict) else result.report
        meshed = moments.get("Solving the modes", begun)
        record = scoring.mark(truth, report, modulus_without(result, report))
        record |= {"seconds": ended - begun, "diagnosis_seconds": ended - meshed}
        if scoring.needs_refit(record):
            record["refitted"] = refitted(Path(folder) / "case.toml", truth["effects"], options)
    return record


def refitted(case: Path, effects: list, options: dict) -> float | None:
    """Held-out error of the true model: the case with what was planted in it declared."""
    import core.pipeline as pipeline
    from core.errors import CoreError

    text = case.read_text(encoding="utf-8")
    said = tomllib.loads(text).get("model", {}).get("declared", [])
    names = json.dumps(list(dict.fromkeys([*said, *effects])))
    text, count = re.subn(r"declared = \[.*?\]", f"declared = {names}", text, count=1)
    if not count:
        return None
    case.write_text(text, encoding="utf-8")
    try:
        report = pipeline.calibrate_case(case, **options).report
    except CoreError:
        return None
    return report["error"]["before"]


def refused(truth: dict, message: str) -> dict:
    """The record of a case whose input was refused."""
    number = {"value": float("nan"), "ci95": None}
    report = {
        "diagnosis": {"verdict": "refused", "effects": []},
        "youngs_modulus": {"material": number},
        "error": {"before": float("nan"), "after": float("nan"), "floor": float("nan")},
    }
    return scoring.mark(truth, report) | {"message": message}


def modulus_without(result, report: dict) -> float | None:
    """Young's modulus (Pa) that the declared model alone gives: it follows the pitch squared."""
    if isinstance(result, dict):
        return None
    final, declared = result.verdict.final, result.heard.declared
    k = max(range(len(final.frequency)), key=lambda n: abs(final.motions[0][:, n]).max())
    if k >= len(declared.frequency):
        return None
    factor = (declared.frequency[k] / final.frequency[k]) ** 2
    return float(report["youngs_modulus"]["material"]["value"] * factor)


def safely(kind: str, seed: int) -> dict:
    """A crash is a record too."""
    try:
        return run_case(kind, seed)
    except Exception:  # noqa: BLE001  (whatever it is, the other cases go on)
        return {"kind": kind, "seed": seed, "crash": traceback.format_exc()}


def wanted_cases(options) -> list:
    """(kind, seed) to run: --kinds names kinds or whole groups."""
    names = [k for k in options.kinds.split(",") if k]
    kinds = [k for k in KINDS if not names or k in names or scoring.group(k) in names]
    if options.count:
        return [(k, options.seed + n) for k in kinds for n in range(options.count)]
    return cases("whole", options.seed, kinds)


def run_all(wanted: list, jobs: int, path: Path | None) -> list:
    """Records of all wanted cases, those kept in `path` included."""
    kept = {}
    if path and path.exists():
        lines = path.read_text(encoding="utf-8").splitlines()
        kept = {(r["kind"], r["seed"]): r for r in map(json.loads, lines) if "crash" not in r}
    todo = [case for case in wanted if case not in kept]
    if jobs > 1:  # each has one core
        os.environ["RINGDOWN_ALONE"] = "1"
    # each case in a process of its own, as a user has it: what others left behind costs time
    with ProcessPoolExecutor(jobs, get_context("spawn"), max_tasks_per_child=1) as pool:
        waiting = [pool.submit(safely, *case) for case in todo]
        for n, done in enumerate(as_completed(waiting)):
            record = done.result()
            kept[record["kind"], record["seed"]] = record
            if path:
                with path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(record) + "\n")
            print(f"{n + 1}/{len(todo)} {line_of(record)}", flush=True)
    return [kept[case] for case in wanted]


def line_of(record: dict) -> str:
    if "crash" in record:
        last = record["crash"].strip().splitlines()[-1]
        return f"{record['kind']} {record['seed']}: CRASH {last}"
    return (
        f"{record['kind']} {record['seed']} {record['object']}: ratio {record['ratio']:.1f}, "
        f"{scoring.called(record)}, twins {','.join(record['twins']) or '-'}, "
        f"held out {record['before']:.3f} to {record['after']:.3f} over {record['floor']:.3f}, "
        f"E {record['modulus_error']:+.1%}, {record.get('seconds', 0):.0f} s"
    )


def page(records: list, seed: int) -> str:
    """The Markdown page."""
    marks = [r for r in records if "crash" not in r]
    crashes = [line_of(r) for r in records if "crash" in r]
    text = [
        "# What the loop finds in planted cases",
        "",
        f"{len(records)} simulated cases, seeds from {seed}; `python tests/suite.py` prints this.",
        "",
        scoring.table(("criterion", "wanted", "measured"), scoring.criteria(marks)),
        "",
        "What was planted, and what it was called (in brackets: named as a part of what stays",
        "unexplained):",
        "",
        scoring.table(("planted", "cases", "called"), scoring.confusion(marks)),
        "",
        "What is not as planted, or leaves more than a tenth above the noise. Ratio: the declared",
        "model's error over the noise. Refitted: the held-out error of the true model refitted.",
        "",
        scoring.table(scoring.FAILED, scoring.failed(marks)),
        "",
    ]
    return "\n".join(text + ([f"Crashes: {len(crashes)}", "", *crashes, ""] if crashes else []))


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=0, help="cases of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="", help="kinds or groups, with commas between")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--records", type=Path)
    options = parser.parse_args(arguments)
    records = run_all(wanted_cases(options), options.jobs, options.records)
    text = page(records, options.seed)
    print(text)
    if options.out:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        options.out.write_text(text, encoding="utf-8")
    return 1 if any("crash" in r for r in records) else 0


if __name__ == "__main__":
    sys.exit(main())
