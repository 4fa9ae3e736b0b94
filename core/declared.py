"""Effects that the case declares: they are fitted as part of the model from the start."""

from .effects import TIME_EFFECTS
from .law import TimeFit
from .time_layer import entries, race, read_off
from .timefit import sharp


def with_declared(start: TimeFit, names: tuple[str, ...]) -> TimeFit:
    """The fit with those of the named effects that act in time, however little they do.

    One that the recording cannot show is left out.
    """
    for name in names:
        known = [*TIME_EFFECTS, *read_off(start)] if name not in _there(start) else []
        able = entries(start, [effect for effect in known if effect.name == name])
        tried = [race(start, effect, begins, promise) for promise, effect, begins in able]
        if tried:
            start = sharp(min(tried, key=lambda found: found.chi2))
    return start


def _there(found: TimeFit) -> list[str]:
    return [effect.name for effect in found.law.effects]
