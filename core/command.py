"""The command line, for the shell, for Blender in the background and for Blender's own command."""

import json
import sys
import time
from pathlib import Path

from .bake import save_motion
from .errors import CoreError
from .options import (
    Parser,
    above_zero,
    case_files,
    check_outputs,
    check_picture,
    count,
    kept_beside,
    pair,
)
from .report import write_report
from .stiffening_study import add_arguments, stiffening_main

WAIT = 1.0  # s of work before progress is shown


def main(arguments: list[str] | None = None) -> int:
    """Run one command. 0: done; 2: refused with one line on standard error; 130: stopped."""
    try:
        options = _parser().parse_args(arguments)
        options.run(options)
    except CoreError as error:
        print(f"ringdown: {error}".replace("\n", " "), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nringdown: stopped; nothing was written.", file=sys.stderr)
        return 130
    return 0


def _parser() -> Parser:
    parser = Parser(prog="ringdown", description="Film, calibrate, bake.")
    commands = parser.add_subparsers(required=True, metavar="command")
    one = commands.add_parser("calibrate", help="a case in, a report out")
    one.add_argument("case", type=Path)
    one.add_argument("--out", type=Path, required=True, help="report.json")
    one.add_argument("--plot", type=Path, help="picture: .png, .svg, .pdf, ...")
    one.add_argument("--elements", type=count, help="about how many tetrahedra")
    one.add_argument("--element", choices=("p1", "p1_smoothed", "p2"), default="p2")
    one.add_argument("--motion", type=Path, help="motion for a bake, .npz")
    one.add_argument("--progress-json", action="store_true", help="progress as lines of JSON")
    one.set_defaults(run=_calibrate)
    two = commands.add_parser("ringdown", help="the modes of a video alone")
    two.add_argument("video", type=Path)
    two.add_argument("--capture-fps", type=above_zero, required=True, help="of real time")
    two.add_argument(
        "--point",
        action="append",
        type=pair,
        default=[],
        metavar="U,V",
        help="px, a point to follow; else they are picked",
    )
    two.add_argument(
        "--static",
        action="append",
        type=pair,
        default=[],
        metavar="U,V",
        help="px, a point that stands still: the camera's shake is taken out",
    )
    two.add_argument("--readout", type=above_zero, help="s, rolling shutter, first to last row")
    two.add_argument("--metres-per-pixel", type=above_zero, help="for amplitudes in metres")
    two.add_argument("--out", type=Path, help="ringdown.json")
    two.add_argument("--plot", type=Path, help="picture: .png, .svg, .pdf, ...")
    two.add_argument("--magnify", type=Path, help="the first mode made visible, .mp4")
    two.set_defaults(run=_ringdown)
    three = commands.add_parser("stiffening", help="how much too stiff each resolution is")
    add_arguments(three)
    three.set_defaults(run=lambda o: print(stiffening_main(o, _progress(False))))
    four = commands.add_parser("study", help="mesh-dependent stiffness, from first principles")
    four.add_argument("--out", type=Path, required=True, help="folder for figures and study.json")
    four.set_defaults(run=_study)
    return parser


def _calibrate(options) -> None:
    kept = kept_beside(options.out)
    outputs = {"--out": options.out, "--plot": options.plot, "--motion": options.motion}
    beside = {"the tetrahedra kept beside --out": kept}
    check_outputs(outputs | beside, case_files(options.case))
    check_picture(options.plot)
    from .pipeline import calibrate_case
    from .plot import plot_calibration

    result = calibrate_case(
        options.case,
        elements=options.elements,
        element=options.element,
        tets=kept,
        progress=_progress(options.progress_json),
    )
    if options.plot:
        plot_calibration(result, options.plot)
    if options.motion:
        save_motion(
            options.motion, result.motion, clock=result.time, measured=result.measured,
            predicted=result.predicted,
        )  # fmt: skip
    write_report(result.report, options.out)
    if not options.progress_json:
        print(_table(result.report))


def _table(report: dict) -> str:
    """What was added, the held-out error, and how far that is from the noise."""
    error, diagnosis = report["error"], report["diagnosis"]
    lines = [f"{'model':34}{'held-out error':>15}{'over noise':>12}"]
    for row in error["chain"]:
        name = "as declared" if row["added"] is None else f"+ {row['added']}"
        ratio = row["held_out"] / max(error["floor"], 1e-12)
        lines.append(f"{name:34}{row['held_out']:15.4g}{ratio:12.3g}")
    for one in error.get("takes", ()):
        held, fitted = (
            "-" if one[name] is None else f"{one[name]:.4g}" for name in ("held_out", "fit")
        )
        lines.append(f"  {one['take']}: {held} held out, {fitted} fitted")
    young = report["youngs_modulus"]["material"]
    first = report["modes"][0]
    lines.append(f"verdict: {diagnosis['verdict']}")
    lines += [
        f"  {e['name']}" + (f", or {', '.join(e['twins'])}" if e["twins"] else "")
        for e in diagnosis["effects"]
    ]
    f, z = first["natural_frequency_hz"]["value"], first["damping_ratio"]["value"]
    lines.append(f"first pitch {f:.4g} Hz, damping ratio {z:.3g}, E {young['value']:.4g} Pa")
    lines += [f"note: {line}" for line in report["warnings"]]
    lines += [f"next: {line}" for line in diagnosis["advice"][:3]]
    return "\n".join(lines)


def _progress(as_json: bool):
    begun, shown = time.monotonic(), [""]

    def say(fraction: float, text: str) -> None:
        if as_json:
            print(json.dumps({"progress": round(fraction, 3), "text": text}), flush=True)
        elif time.monotonic() - begun > WAIT and text != shown[0] and text != "Done":
            print(f"[{100 * fraction:3.0f} %] {text}", file=sys.stderr, flush=True)
            shown[0] = text

    return say


def _study(options) -> None:
    from .study import study

    study(options.out, _progress(False))
    print(f"{options.out}: study.json and four pictures")


def _ringdown(options) -> None:
    outputs = {"--out": options.out, "--plot": options.plot, "--magnify": options.magnify}
    check_outputs(outputs, (options.video,))
    check_picture(options.plot)
    from .ringdown_command import ringdown_command, table  # OpenCV takes its time to import

    told = ringdown_command(
        options.video,
        capture_fps=options.capture_fps,
        points=options.point,
        static=options.static,
        readout=options.readout or 0.0,
        metres_per_pixel=options.metres_per_pixel,
        out=options.out,
        plot=options.plot,
        magnify=options.magnify,
        progress=_progress(False),
    )
    for_a_program = options.out is None and not sys.stdout.isatty()
    print(json.dumps(told, indent=1, ensure_ascii=False) if for_a_program else table(told))
