"""From a scan of 131,072 triangles to 10 modes at 5,000 tetrahedra: seconds of each step;
and what is left of a plate that crashes the tetrahedralizer.

    python tests/bench/scan.py [ELEMENTS]

CPU seconds are printed beside those of the clock, because a busy machine stretches the latter.
"""

import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from core.data import Material
from core.elasticity import assemble
from core.errors import Cancelled, MeshError
from core.modes import solve_modes
from core.tetrahedralize import tetrahedralize
from core.tetwild import run_tetwild
from tests.core.surfaces import box, scan


def cpu() -> float:
    own, children = (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def timed(name: str, verb):
    wall, work = time.monotonic(), cpu()
    result = verb()
    print(f"{name:34s} {time.monotonic() - wall:7.2f} s  {cpu() - work:7.2f} s CPU", flush=True)
    return result


def cancel_delay(surface, elements: int) -> float:
    """Seconds from the wish to stop, two seconds in, to being stopped."""
    wish = time.monotonic() + 2
    try:
        tetrahedralize(surface, elements, cancelled=lambda: time.monotonic() > wish)
    except Cancelled:
        return time.monotonic() - wish
    return 0.0


def crash() -> str:
    """What is said of a plate a fiftieth as thick as wide, with an epsilon as large as that."""
    try:
        _, tets = run_tetwild(box((1.0, 1.0, 0.02)), 0.05, 0.02)
    except MeshError as error:
        return str(error)
    return f"no crash here, {len(tets)} tetrahedra"


def main() -> None:
    elements = int(sys.argv[1]) if len(sys.argv) > 1 else 5000
    surface = scan(7)
    print(f"{len(surface.faces)} triangles, {elements} tetrahedra wanted")
    mesh, report = timed("tetrahedralize", lambda: tetrahedralize(surface, elements))
    print(
        f"  {report.tets} tetrahedra in {report.trials} runs, volume {report.volume_error:+.2%}, ",
        end="",
    )
    print(f"worst quality {report.worst_quality:.2f}")
    for element in ("p1_smoothed", "p2"):
        model = timed(
            f"assemble {element}", lambda e=element: assemble(mesh, Material(1e3, 0.48), e)
        )
        timed(f"10 modes {element}", lambda m=model: solve_modes(m, 16))
    print(f"cancelled after {cancel_delay(surface, 10 * elements):.2f} s")
    print(f"thin plate: {crash()}")
    mesh, report = tetrahedralize(box((1.0, 1.0, 0.02)), 2000)
    print(f"  and with our choice of epsilon {report.tets} tetrahedra in {report.trials} runs")


if __name__ == "__main__":
    main()
