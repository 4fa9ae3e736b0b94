"""case.toml -> nouns. case_schema.py checks each field alone, this what they say together."""

import tomllib
from pathlib import Path

import numpy as np

from .case_fields import read_table
from .case_schema import CASE_FIELDS
from .data import Case, Load, Marker, Material, Surface, Take, replace
from .errors import CaseError
from .looked_at import read_camera, with_camera
from .pins import HAIR, Box, Region, Sphere, held_vertices, vertices_region
from .surface import (
    METRES,
    bounding_box,
    closest_point,
    diagonal,
    enclosed_volume,
    is_closed,
    read_surface,
)
from .takes import Scene, beside, read_recording

HEAVY = 1000.0  # times the body's own mass: a load beyond it is a mistake of units
FEWEST = 3  # markers that tell a mistake of units
ON = 0.005  # of the object's diagonal: what is nearer its surface lies on it
NEARER = 0.2  # of how far off it is in the unit that is said
SPREAD = 0.2  # of the diagonal, that markers on an object cover
FAR = 0.5  # of the object's diagonal: a place further off the surface is a mistake of units


def read_case(path: str | Path, *, progress=None) -> Case:
    """The case of a case.toml (or of the folder that holds one), everything in SI.

    Files that it names are sought beside it. `progress(fraction, text)` is called while a video is
    tracked. Raises CaseError for what the file says, MeshError and RecordingError for what the
    files that it names hold; each message names the field, what it is and what is needed.
    """
    path = Path(path)
    path = path / "case.toml" if path.is_dir() else path
    table = _parse(path)
    try:
        fields = read_table(table, CASE_FIELDS, f"{path.name}:")
        return _make_case(fields, path.parent, progress)
    except CaseError as error:
        prefix = f"{path.name}: " if str(error).startswith("[") else ""
        one_line = " ".join(str(error).split())  # whatever the files hold
        raise CaseError(prefix + one_line) from error


def _parse(path: Path) -> dict:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise CaseError(f"{path}: there is no such file. Give the path of a case.toml.") from error
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(f"{path}: cannot be read ({error}). Save it as UTF-8 text.") from error
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path.name}: not TOML, {error}. Mend that line.") from error


def _make_case(fields: dict, folder: Path, progress) -> Case:
    body = fields["object"]
    surface = read_surface(beside(folder, body["mesh"], "[object] mesh"), body["length_unit"])
    regions = _regions(fields["pin"], surface)
    pinned = held_vertices(surface, regions)
    markers = _markers(fields["marker"])
    on_object = {f"[[marker]] {m.name}": m.position for m in markers if m.on == "object"}
    _check_near(surface, on_object)
    _check_unit(surface, body["length_unit"], np.array(list(on_object.values())))
    table = fields["camera"]
    reading = read_camera(table, "[camera]", markers) if table else None
    scene = Scene(folder, markers, reading and reading.camera, diagonal(surface))
    own = {"load": fields["load"], "gravity": body["gravity"]}
    tables = {"[recording]": fields["recording"] | own}
    tables |= {f"[[take]] {k + 1}": _overlaid(own, take) for k, take in enumerate(fields["take"])}
    material = Material(body["density"], body["poisson_ratio"])
    _check_loads(tables, surface, material)
    takes = tuple(_take(one, where, surface, scene, progress) for where, one in tables.items())
    if reading:
        takes = with_camera(takes, reading, table["look"], "[camera]")
    if body["shape"] == "unloaded":
        takes = _warned_of_no_sag(takes)
    return Case(
        name=fields["name"],
        surface=surface,
        material=material,
        pinned=pinned,
        takes=takes,
        declared=fields["model"]["declared"] if fields["model"] else (),
        claimed_youngs_modulus=body["youngs_modulus"],
        shape=body["shape"],
        pin_regions=regions,
        folder=str(folder),
    )


def _overlaid(own: dict, take: dict) -> dict:
    """The take's own loads and gravity where it gives them, else the case's."""
    return take | {name: x if take[name] is None else take[name] for name, x in own.items()}


def _take(fields: dict, where: str, surface: Surface, scene: Scene, progress) -> Take:
    loads = tuple(Load(one["mass"], one["position"]) for one in fields["load"])
    _check_near(surface, {f"{where} load {k + 1}": x.position for k, x in enumerate(loads)})
    return Take(
        read_recording(fields, where, scene, progress),
        loads,
        fields["gravity"],
        fields.get("held_out", False),
        fields["tracks"] or fields["video"],
    )


def _regions(pins: list[dict], surface: Surface) -> tuple[Region, ...]:
    regions, hair = [], HAIR * diagonal(surface)
    for k, pin in enumerate(pins):
        where = f"[[pin]] {k + 1}"
        given = [kind for kind, value in pin.items() if value is not None]
        if len(given) != 1:
            has = " and ".join(given) or "nothing"
            raise CaseError(f"{where} has {has}; one of box, sphere, vertices is needed. Name one.")
        if given == ["box"]:
            low, high = pin["box"]["min"], pin["box"]["max"]
            if not (low < high).all():
                raise CaseError(
                    f"{where} box: min = {low.tolist()} and max = {high.tolist()}; min below max "
                    "on every axis is needed. Swap them."
                )
            regions.append(Box(low, high, hair))
        elif given == ["sphere"]:
            regions.append(Sphere(**pin["sphere"], hair=hair))
        else:
            regions.append(vertices_region(surface, pin["vertices"], where))
    return tuple(regions)


def _markers(tables: list[dict]) -> tuple[Marker, ...]:
    names = [one["name"] for one in tables]
    for name in names:
        if names.count(name) > 1:
            raise CaseError(f'[[marker]]: the name "{name}" stands there twice. Rename one.')
    if all(one["on"] == "support" for one in tables):
        raise CaseError(
            '[[marker]]: all are on = "support"; at least one on the object is needed. Add one.'
        )
    pixels = [None if one["pixel"] is None else tuple(one["pixel"].tolist()) for one in tables]
    return tuple(
        Marker(one["name"], one["position"], one["on"], pixel)
        for one, pixel in zip(tables, pixels, strict=True)
    )


def _check_near(surface: Surface, places: dict[str, np.ndarray]) -> None:
    """Raises CaseError for a place (3,) m, by its name, that is far off the surface."""
    size = diagonal(surface)
    for name, place in places.items():
        away = closest_point(surface, place)[2][0]
        if away > FAR * size:
            raise CaseError(
                f"{name}: position = {place.tolist()} is {away:.3g} m off the object's surface, "
                f"whose diagonal is {size:.3g} m; at most {FAR * size:.3g} m is needed. Give it in "
                "metres and object axes, and check [object] length_unit."
            )


def _check_loads(tables: dict[str, dict], surface: Surface, material: Material) -> None:
    """Raises CaseError for a load beyond HEAVY times the body's mass (if open: that of its box)."""
    low, high = bounding_box(surface)
    volume = enclosed_volume(surface) if is_closed(surface) else float(np.prod(high - low))
    mass = material.density * volume
    for where, table in tables.items():
        for k, one in enumerate(table["load"]):
            if one["mass"] > HEAVY * mass:
                raise CaseError(
                    f"{where} load {k + 1} mass = {one['mass']:g} kg; at most {HEAVY:g} times the "
                    f"body's {mass:.3g} kg is needed. Give it in kg, and check length_unit."
                )


def _warned_of_no_sag(takes: tuple[Take, ...]) -> tuple[Take, ...]:
    """The takes, the first without gravity saying that an unloaded shape then does not sag."""
    for k, take in enumerate(takes):
        if take.gravity is None:
            text = (
                '[object] shape = "unloaded" without gravity: no sag is computed, the shape is '
                "taken as the one it hangs in. Give gravity to have the sag in the model."
            )
            told = replace(take.recording, warnings=(*take.recording.warnings, text))
            return (*takes[:k], replace(take, recording=told), *takes[k + 1 :])
    return takes


def _check_unit(surface: Surface, unit: str, positions: np.ndarray) -> None:
    """Raises CaseError where markers (n, 3) m lie off the mesh, and on it in another unit."""
    if len(positions) < FEWEST:
        return
    off, covered = _off(surface, positions), np.linalg.norm(np.ptp(positions, axis=0))
    huddled = covered < SPREAD / 10 * diagonal(surface)  # at one place of a mesh too large
    if off < ON and not huddled:
        return
    for other in METRES:
        scaled = positions * (METRES[unit] / METRES[other])
        spread = covered * METRES[unit] / METRES[other] / diagonal(surface)
        if other == unit or spread < SPREAD:
            continue
        nearer = _off(surface, scaled)
        if nearer < ON and (huddled or nearer < NEARER * off):
            raise CaseError(
                f'[object] length_unit = "{unit}": the object would be {diagonal(surface):.3g} m '
                f"across, and the markers are spread over {covered:.3g} m; they lie on its "
                f'surface where the mesh is in {other}. Say length_unit = "{other}", or give '
                "positions on the object in m."
            )


def _off(surface: Surface, places: np.ndarray) -> float:
    """How far the places (n, 3) m are from the surface, over its diagonal; the median."""
    return float(np.median(closest_point(surface, places)[2])) / diagonal(surface)
