"""The story, read top to bottom: a case in, a calibrated body, its motion and a report out."""

import os
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from . import __version__
from .aliases import FOLDED
from .body import Body, bare_model, build_body, laden
from .camera_layer import true_frequency, unfold
from .case import read_case
from .data import Case, ElasticModel, Motion, TetMesh, replace
from .diagnosis import diagnose, with_both
from .dragged import with_drag
from .effects import added_mass, air_drag, mesh_stiffening
from .elasticity import HUNG, UNKNOWN, held_part
from .examine import examine
from .findings import Findings
from .joint import Heard, hear, laid_bare
from .law import TimeFit
from .lost import without_lost
from .modulus import find_modulus
from .near_camera import as_seen_nearby
from .on_all_modes import with_all_modes
from .overtones import with_overtones
from .play import motion
from .rehear import second_hearing
from .residual import noise_share
from .rim import along_rim
from .ringdown import find_release
from .seat import on_narrow_feet
from .side_by_side import meanwhile
from .signatures import budget
from .stiffening import converged_eigenvalues, moved, stiffening
from .stirred import with_stirred
from .tell import (
    told_bounds,
    told_claim,
    told_diagnosis,
    told_error,
    told_modes,
    told_modulus,
    told_sizes,
    told_without,
)
from .tets import kept_or_cut, key, save_tets
from .verdict import Verdict, Whole
from .weight import carries_weight, with_weight

ELEMENTS = 1500  # tetrahedra, where none are asked for
ELEMENT = "p2"
LATE = 4  # frames after the release from which a take begins late: three may have been held still


@dataclass(frozen=True, eq=False)
class Result:
    """All that a calibration gives."""

    case: Case
    report: dict  # as the contract says
    motion: Motion  # for the bake
    time: np.ndarray  # (T,) s since the release, of the first take
    measured: np.ndarray  # (T, n, d)
    predicted: np.ndarray  # (T, n, d)
    heard: Heard
    verdict: Verdict
    findings: Findings
    budget_after: dict  # where the final fit's misfit sits
    left_after: float  # its energy over that of the declared fit


# numpy may have been loaded with more threads, whose sums differ from run to run in the last digits
@threadpool_limits.wrap(limits=int(os.environ["OMP_NUM_THREADS"].split(",")[0]), user_api="blas")
def calibrate_case(
    path: str | Path,
    *,
    elements: int | None = None,
    element: str = ELEMENT,
    tets: str | Path | None = None,
    progress=None,
) -> Result:
    """Calibrate the case at `path` with about `elements` tetrahedra.

    `tets`: an .npz where the tetrahedra are kept and found again. progress(fraction, text) is
    called as the work goes on and may raise Cancelled. Raises CoreError, one readable line.
    """
    begun = time.monotonic()
    say = progress or (lambda fraction, text: None)
    say(0.0, "Reading the case")
    case = read_case(path, progress=lambda f, text: say(0.15 * f, text))
    case = without_lost(case, find_release)
    say(0.15, "Cutting the body into tetrahedra")
    cut, warnings = kept_or_cut(
        case.surface, elements or ELEMENTS, tets, lambda f, text: say(0.15 + 0.25 * f, text)
    )
    mesh = along_rim(cut, held_part(case.surface, case.pinned, case.pin_regions))
    say(0.4, "Solving the modes")
    body = build_body(case, bare_model(case, mesh, element), case.takes[0])

    def listened(one: Body) -> Heard:
        say(0.42, "Listening")
        return hear(one, find_release)

    early = None  # where the body is not known before it was heard
    if carries_weight(body):
        early = with_weight(body, listened)
    elif case.takes[0].loads:
        early = listened(body)
    body = early.body if early else body
    with meanwhile(partial(_stiffening, mesh, body)) as converged:
        heard = early or listened(body)
        far, near = heard, as_seen_nearby(heard, listened)
        heard = near or heard
        say(0.5, "Looking for what the model lacks")
        heard, verdict = second_hearing(heard, _diagnosed(heard), _diagnosed)
        heard, verdict = with_overtones(heard, verdict, _diagnosed)
        verdict = with_stirred(heard, verdict) or verdict
        verdict = with_drag(heard, verdict, beside=True) or verdict
        verdict = with_all_modes(heard, verdict) or verdict
        verdict = with_both(verdict) or verdict
        heard = replace(heard, far=far if near else None)
        say(0.8, "Comparing pitches and shapes")
        stiff, sigma = converged()
    if heard.body.seats != body.seats:  # told once the lens was known
        stiff, sigma = _stiffening(mesh, heard.body)
    findings = examine(heard, verdict, stiff, sigma)
    say(0.95, "Writing")
    report = _report(case, mesh, heard, verdict, findings, (stiff, sigma, element))
    report["seconds"] = time.monotonic() - begun
    report["warnings"] = [*warnings, *_heard_warnings(case, heard), *report["warnings"]]
    final = verdict.final
    data = final.law.takes[final.law.fitted[0]]
    d = data.take.recording.values.shape[2]
    if tets is not None:  # not before: what is refused leaves nothing behind
        save_tets(tets, cut, key(case.surface, elements or ELEMENTS), warnings)
    modulus = report["youngs_modulus"]["apparent"]["value"]
    played = verdict.whole or Whole(heard, final)
    say(1.0, "Done")
    return Result(
        case=case,
        report=report,
        motion=motion(played.heard, unfold(played.heard, played.found), modulus, final.law.modes),
        time=data.time,
        measured=data.values.reshape(len(data.time), -1, d),
        predicted=final.predicted[final.law.fitted[0]].reshape(len(data.time), -1, d),
        heard=heard,
        verdict=verdict,
        findings=findings,
        budget_after=budget(final),
        left_after=final.chi2 / max((heard.far or heard).declared.chi2, 1e-300),
    )


def _diagnosed(heard: Heard, start: TimeFit | None = None) -> Verdict:
    return diagnose(
        heard.declared,
        heard.free,
        widen=partial(laid_bare, heard),
        start=start,
        bodily=partial(_in_low_modes, heard),
    )


def _in_low_modes(heard: Heard, verdict: Verdict) -> Verdict | None:
    """What the one effect of the verdict explains with the body's modes that nobody heard."""
    drags = verdict.names[verdict.laws :] == (air_drag.EFFECT.name,)
    return with_drag(heard, verdict) if drags else with_stirred(heard, verdict)


def _stiffening(mesh: TetMesh, body: Body) -> tuple[np.ndarray, np.ndarray]:
    """How far each eigenvalue lies above the mesh-converged one, and that number's own error.

    How lumped masses sit is not known, so what another way of it changes is part of the error.
    """
    take, modes = body.case.takes[0], body.modes
    seat, *doubted = body.seats

    def build(other: TetMesh, element: str) -> ElasticModel:
        return laden(bare_model(body.case, other, element), take, body.carried, seat)

    limit = converged_eigenvalues(build, mesh, len(modes.frequency))
    stiff, sigma = stiffening(body.model, modes, limit)
    if not take.loads:
        return stiff, sigma
    others = [laden(body.bare, take, body.carried, other) for other in doubted]
    doubts = [moved(body.model, modes, other) for other in others]
    if body.seats in (UNKNOWN, HUNG):
        doubts.append(on_narrow_feet(body, take))
    doubt = np.max(doubts, axis=0)
    return stiff, np.hypot(sigma, doubt)


def _report(case, mesh, heard: Heard, verdict: Verdict, findings, solved) -> dict:
    final = verdict.final
    stiff, sigma, element = solved
    true = true_frequency(heard, final)
    young = find_modulus(heard, verdict, findings, (stiff, sigma))
    first, loudest = verdict.chain[0][1], final.loudest
    told = told_diagnosis(
        heard,
        verdict,
        {
            "verdict": findings.verdict,
            "effects": findings.effects,
            "instead": findings.instead,
            "ranking": findings.ranking,
            "advice": findings.advice,
            "minor": findings.minor,
            "budget": findings.budget(budget((heard.far or heard).declared)),
        },
    )
    doubts = told_sizes(final), told_bounds(final, first)
    without = told_without(
        [effect["name"] for effect in told["effects"]],
        (young.without, young.material.value),
        (first.damping_ratio[loudest], final.damping_ratio[loudest]),
    )
    return {
        "case": case.name,
        "version": __version__,
        "seconds": 0.0,
        "mesh": {
            "nodes": len(mesh.nodes),
            "tets": len(mesh.tets),
            "element": element,
            "stiffening": float(stiff[0]),
        },
        "youngs_modulus": told_modulus(young.apparent, young.material),
        "modes": told_modes(heard, final, young.pitches, true),
        "error": told_error(
            verdict,
            findings.before,
            findings.rows,
            findings.instead,
            heard.far and heard.far.declared,
        ),
        "diagnosis": told,
        "warnings": [
            *findings.warnings,
            *_foretold_elsewhere(final),
            *filter(None, doubts if findings.verdict == "unexplained" else ()),
            *filter(None, [without, told_claim(case.claimed_youngs_modulus, young.material)]),
            *filter(None, [added_mass.told(told["effects"], heard.body.bare.mass.sum() / 3)]),
            *filter(None, [mesh_stiffening.told(stiff, heard.match.modes, true)]),
        ],
    }


def _foretold_elsewhere(final: TimeFit) -> list[str]:
    """A line for each take that the body alone foretells."""
    out = []
    for data in final.law.takes:
        if data.doubt is not None:
            forgiven = noise_share((data,), True, doubted=True)
            out.append(
                f"{data.take.name}: no fitted take has its loads and gravity. The body foretells "
                f"it, and the verdict forgives an error of {forgiven:.2g}."
            )
    return out


def _heard_warnings(case: Case, heard: Heard) -> list[str]:
    takes = [*case.takes, *heard.body.case.takes]  # of which some may have been left out
    out = [w for take in takes for w in take.recording.warnings]
    out += [w for ring in heard.rings for w in ring.warnings]
    for data in heard.takes:
        if data.time[0] > LATE * data.frame:
            out.append(
                f"{data.take.name}: the first {data.time[0]:.2g} s after the release ring more "
                "fast modes than can be told apart, and were left out. What acts only then is not "
                "named."
            )
        if data.arcs:
            out.append(
                f"{data.take.name}: the markers go on arcs, as those of the computed body do: "
                f"{data.arcs:.1%} of the motion, which was taken off before all else and is baked. "
                "The errors are told without it."
            )
        rate, f = 1 / data.frame, float(heard.free.frequency[0])
        if f * data.frame > FOLDED:
            out.append(
                f"{data.take.name}: {f:.4g} Hz is seen with {rate:.4g} frames/s: a true pitch of "
                f"{rate - f:.4g} or {rate + f:.4g} Hz would look the same. Film faster to be sure."
            )
    if any(body.seats[0].hangs for body in heard.bodies):
        out.append(
            "[[load]]: by the pitches it goes along with gravity's direction only, as one that "
            "hangs on a thread does, and counts so. Fix it to the object to have it swing along."
        )
    if carries_weight(heard.body) and heard.body.carried is None:
        out.append(
            "gravity_preload is declared, but with no Young's modulus would the body, its weight "
            "counted in, have the measured pitch: it is left out. Check gravity and density."
        )
    if None in heard.match.modes:
        out.append(
            "No computed mode moves as the measured one does: Young's modulus was fitted to the "
            "first mode all the same. Check pins, marker positions and the camera."
        )
    return list(dict.fromkeys(out))
