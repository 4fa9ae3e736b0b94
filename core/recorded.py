"""The takes of a case that can be heard, each with the body that it shows."""

from functools import partial

from .body import Body, build_body
from .channels import Channels
from .data import RingDown, replace
from .errors import RecordingError
from .listen import listen
from .settle import Recorded
from .side_by_side import side_by_side

HELD_PERIODS = 2.0  # of the first mode, from which the start of a held-out take is fitted


def recorded(body: Body, find_release) -> Recorded:
    """The takes that can be heard, every one's ring-down, and the bodies that they need.

    Raises RecordingError as `listen` does of the first take.
    """
    body, pairs = _usable(body, find_release)
    case = body.case
    rings = tuple(ring for _, ring in pairs)
    takes = tuple(first_periods(d, r) if d.take.held_out else d for d, r in pairs)
    keys = [_key(take) for take in case.takes]
    fitted = [key for key, data in zip(keys, takes, strict=True) if not data.take.held_out]
    order = list(dict.fromkeys([*fitted, *keys]))
    condition = tuple(order.index(key) for key in keys)
    others = [case.takes[keys.index(key)] for key in order[1:]]
    bodies = (
        body,
        *(build_body(case, body.bare, take, body.carried, body.seats) for take in others),
    )
    return Recorded(takes, condition, bodies, rings)


def _usable(body: Body, find_release) -> tuple[Body, list]:
    """The body with the takes that can be heard, and what `listen` says of each; what the others
    are refused for is among the first one's warnings.

    Raises what that one is refused for.
    """
    takes = body.case.takes
    pairs = side_by_side([partial(_heard_or_why, take, find_release) for take in takes])
    refused = [n for n, pair in enumerate(pairs) if isinstance(pair, RecordingError)]
    if not refused:
        return body, pairs
    if 0 in refused:  # whose loads the body bears
        raise pairs[0]
    first, *later = (take for n, take in enumerate(takes) if n not in refused)
    instead = "The other takes were used without it."
    if any(takes[n].held_out for n in refused) and not any(take.held_out for take in later):
        instead += " Held out is the last third of each of them."
    recording, told = first.recording, [f"{pairs[n]} {instead}" for n in refused]
    first = replace(first, recording=replace(recording, warnings=(*recording.warnings, *told)))
    (data, ring), *others = (pair for n, pair in enumerate(pairs) if n not in refused)
    case = replace(body.case, takes=(first, *later))
    return replace(body, case=case), [(replace(data, take=first), ring), *others]


def _heard_or_why(take, find_release):
    """What `listen` returns, or what it raises."""
    try:
        return listen(take, find_release)
    except RecordingError as why:
        return why


def _key(take):
    loads = tuple((load.mass, *load.position) for load in take.loads)
    return loads, None if take.gravity is None else tuple(take.gravity)


def first_periods(data: Channels, ring: RingDown) -> Channels:
    """A held-out take of which only so much is fitted that its start is known."""
    return replace(data, fit=data.time <= data.time[0] + HELD_PERIODS / ring.frequency[0])
