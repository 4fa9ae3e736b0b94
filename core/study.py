"""The founding report made anew, and corrected: how a mesh makes a body ring too high.

In one, two and three dimensions, with the product's own elements and eigenvalue solver.
"""

import json
import time
from collections.abc import Callable
from pathlib import Path

from .errors import CaseError
from .files import written_whole
from .study_figures import draw_line, draw_locking, draw_polygon, draw_triangle
from .study_line import study_line
from .study_plane import study_polygon, study_triangle
from .study_solid import study_locking


def study(out: Path | str, progress: Callable[[float, str], None] | None = None) -> dict:
    """Write study.json and four pictures into the folder `out`; return what study.json holds.

    Keys: "line" (eigenvalues 1/s2, L = c = 1), "polygon" (eigenvalues), "triangle" (forces per
    unit of depth and of Y), "locking" (errors in per cent), "seconds". Raises CaseError where
    `out` cannot be written to.
    """
    out = Path(out)
    say = progress or (lambda share, text: None)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CaseError(
            f"{out}: no folder can be made there ({error.strerror}). Give --out another name."
        ) from error
    start = time.monotonic()
    say(0.0, "the line")
    line = study_line()
    say(0.1, "the polygon")
    polygon, modes = study_polygon()
    say(0.5, "the triangle")
    triangle, bent = study_triangle()
    locking = study_locking(lambda share, text: say(0.55 + 0.3 * share, text))
    found = {"line": line, "polygon": polygon, "triangle": triangle, "locking": locking}
    say(0.9, "pictures")
    draw_line(line, out / "line.png")
    draw_polygon(polygon, modes, out / "polygon.png")
    draw_triangle(triangle, bent, out / "triangle.png")
    draw_locking(locking, out / "locking.png")
    found["seconds"] = time.monotonic() - start
    with written_whole(out / "study.json") as draft:
        draft.write_text(json.dumps(found, indent=1) + "\n")
    say(1.0, f"study: {out / 'study.json'}")
    return found
