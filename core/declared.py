"""Effects that the case declares: they are fitted as part of the model from the start."""

from functools import partial

from .branches import with_branch
from .effects import TIME_EFFECTS
from .law import TimeFit
from .race import race
from .read_off import read_off
from .rub import in_plane
from .side_by_side import in_step_by_parts
from .time_layer import entries, judge
from .timefit import sharp

READ_OFF = {"base_motion", "tracker_drift", "lost_frames"}
IN_TIME = READ_OFF | {effect.name for effect in TIME_EFFECTS}


def with_declared(start: TimeFit, names: tuple[str, ...]) -> TimeFit:
    """The fit with those of the named effects that act in time, however little they do.

    One that the recording cannot show is left out.
    """
    there = {effect.name for effect in start.law.effects}
    for name in [name for name in names if name in IN_TIME - there]:
        known = read_off(start) if name in READ_OFF else TIME_EFFECTS
        begun = entries(start, [effect for effect in known if effect.name == name])
        tried = in_step_by_parts([partial(race, one) for one in begun])
        if tried:
            best = max(tried, key=lambda found: judge((name,), found, start).evidence)
            start = in_plane(with_branch(sharp(best), 1), 1)
    return start
