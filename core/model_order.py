"""How many modes are in a ring-down: what the data force upon us, and no more.

The pencil's poles at every order are compared by what they earn (Schwarz's criterion, made
stricter); the best set is refined, pruned of what chance could have made, and grown by what the
residual still holds, until nothing changes.
"""

import numpy as np

from .pencil import evenly, shift_poles, signal_space, thinned
from .significance import (
    CHANCE,
    CLEARED,
    CYCLES,
    FADED,
    MATERIAL,
    Model,
    Record,
    believable,
    makeshift,
    needed,
    threshold,
)
from .varpro import ITERATIONS, Poles, fit

DEGREE = 3  # of the steepest trend
SLOWEST = 0.7  # creep in nepers over the record; slower ones are polynomials
TRIAL = 10  # iterations that show whether a step is worth taking
FOLD = np.pi - 1e-3  # rad a frame; nearer half the frame rate a swing has no phase, nor a size
PATIENCE = 8  # orders of the pencil without gain before the scan ends


def prepare(
    time: np.ndarray, signals: np.ndarray, floor: np.ndarray, noise=None, faintest=MATERIAL
) -> Record:
    """A record whose noise is about `floor` (C,)."""
    dt, even = evenly(time, signals)
    scale = np.where(floor > 0, floor, 1.0)
    return Record(time - time[0], signals, dt, even / scale, floor, noise, faintest)


def polynomial(t: np.ndarray, degree: int) -> np.ndarray:
    """(T, degree + 1) Chebyshev polynomials over the record; the first is the constant."""
    return np.polynomial.chebyshev.chebvander(2 * t / t[-1] - 1, degree)


def model_of(record: Record, poles: Poles, degree: int, iterations: int = ITERATIONS) -> Model:
    """The most likely model near `poles`."""
    x = polynomial(record.t, degree)
    found = fit(record.t, record.y, x, poles, noise=record.noise, iterations=iterations)
    return Model(found, degree)


def select(record: Record, most: int) -> Model:
    """The model with as many modes, up to `most`, and as much trend as the data ask for."""
    start = _start(record, most)
    best = _pruned(record, start)
    if not best.modes and _swings(record, start):
        best = _loudest(record, start)
    for _ in range(most + DEGREE + 2):
        grown = _grown(record, best, most)
        if grown is None:
            break
        grown = _pruned(record, grown)
        if _score(record, grown) >= _score(record, best):
            break
        best = grown
    return model_of(record, best.fit.poles, best.degree)


def _swings(record: Record, model: Model) -> bool:
    """Whether the model's modes are nearly all that moves.

    What stops a swing short, or bends its pitch, is no sum of a few that die away, so that none of
    them may be needed beside what it leaves; but of noise no sum tells nearly all.
    """
    motion = np.nansum((record.y - np.nanmean(record.y, axis=0)) ** 2)
    return bool(model.modes and np.nansum(model.fit.residual**2) < (1 - CLEARED) * motion)


def _loudest(record: Record, model: Model) -> Model:
    """The one mode, near one of the model's, that takes most by itself."""
    p, none = model.fit.poles, np.zeros(0)
    each = [Poles(p.decay[[k]], p.omega[[k]], none) for k in range(model.modes)]
    return min((model_of(record, one, 0, TRIAL) for one in each), key=lambda m: m.fit.cost)


# --- where to start -------------------------------------------------------------------------


def _poles_of(complex_poles: np.ndarray, record: Record) -> tuple[Poles, int]:
    """Oscillating and real poles out of a pencil's set; those that hardly move make a degree."""
    swinging = complex_poles[complex_poles.imag > 1e-6 / record.dt]
    swinging = swinging[swinging.imag < FOLD / record.dt]
    poles = Poles(np.maximum(-swinging.real, 0), swinging.imag, np.zeros(0))
    fine = believable(poles, record)
    real = complex_poles[np.abs(complex_poles.imag) <= 1e-6 / record.dt].real
    creep = -real[(real < -SLOWEST / record.t[-1]) & (real > -FADED / record.dt)]
    still = np.abs(complex_poles) * record.t[-1] < 2 * np.pi * CYCLES
    degree = min(DEGREE, max(0, int(still.sum()) - len(creep)))
    return Poles(poles.decay[fine], poles.omega[fine], creep), degree


def _penalty(record: Record, poles: Poles, degree: int) -> float:
    """Twice the log likelihood that the poles must earn: Schwarz's, plus the search for places."""
    channels = len(record.size)
    logs = float(np.log(record.size).sum())
    search = 2 * np.log(len(record.t) / CHANCE)
    mode = min(2 * logs, threshold(record, 2 * channels + 2)) + search
    creep = min(logs, threshold(record, channels + 1))
    return len(poles.omega) * mode + (len(poles.creep) + degree) * creep


def _start(record: Record, most: int) -> Model:
    """The pencil's set that pays best for its poles, refined; the constant alone if none does."""
    none = Poles(np.zeros(0), np.zeros(0), np.zeros(0))
    tried = [(_score(record, model_of(record, none, 0)), 0, none, 0)]
    for factor in sorted({1, max(1, len(record.even) // 300)}):
        tried += _scan(record, factor, most)
    tried.sort(key=lambda row: row[:2])
    fits = [model_of(record, *row[2:], TRIAL) for row in tried[:2]]
    return min(fits, key=lambda model: _score(record, model))


def _scan(record: Record, factor: int, most: int) -> list[tuple]:
    """(score, order, poles, degree) of the pencil's sets at one frame in `factor`."""
    space = signal_space(thinned(record.even, factor))
    room = int(record.size.min()) - 4 - DEGREE
    rows, best = [], (np.inf, 0)
    for order in range(1, min(2 * most + 6, space.shape[0] - 2, space.shape[1]) + 1):
        poles, degree = _poles_of(shift_poles(space, order, factor * record.dt), record)
        if len(poles.omega) > most or 4 * len(poles.omega) + 2 * len(poles.creep) > room:
            continue
        score = _score(record, model_of(record, poles, degree, iterations=0))
        rows.append((score, order, poles, degree))
        best = min(best, (score, order))
        if order > best[1] + PATIENCE:
            break
    return rows


def _score(record: Record, model: Model) -> float:
    """Less is better."""
    return 2 * model.fit.cost + _penalty(record, model.fit.poles, model.degree)


# --- growing and pruning --------------------------------------------------------------------


def _without(poles: Poles, k: int) -> Poles:
    """Poles less the k-th, counted over modes and then creeps."""
    m = len(poles.omega)
    keep = np.arange(m) != k
    return Poles(
        poles.decay[keep], poles.omega[keep], poles.creep[np.arange(len(poles.creep)) != k - m]
    )


def _pruned(record: Record, model: Model) -> Model:
    """Without makeshifts, and without the weakest poles whose loss is no more than chance."""
    model = _reasonable(record, model)
    while True:
        poles = model.fit.poles
        total = len(poles.decay) + len(poles.creep)
        rest = [model_of(record, _without(poles, k), model.degree, 0) for k in range(total)]
        order = sorted(range(total), key=lambda k: rest[k].fit.cost)
        # what it would cost most to lose bends no other
        honest = _less_a_makeshift(record, model, [k for k in order[:-1] if k < model.modes])
        if honest:
            model = _reasonable(record, honest)
            continue
        for k in order[:2]:
            smaller = model_of(record, _without(poles, k), model.degree, 2 * TRIAL)
            if not needed(record, smaller, model, k):
                break
        else:
            if not model.degree:
                return model
            smaller = model_of(record, poles, model.degree - 1)
            if needed(record, smaller, model, None):
                return model
        model = _reasonable(record, smaller)


def _less_a_makeshift(record: Record, model: Model, among: list[int]) -> Model | None:
    """The model without the first of these modes that is a makeshift; None where none is."""
    for k in among:
        if makeshift(record, model, k):
            poles = _without(model.fit.poles, k)
            smaller = model_of(record, poles, model.degree, 2 * TRIAL)
            if makeshift(record, model, k, smaller):
                return smaller
    return None


def _reasonable(record: Record, model: Model) -> Model:
    """Refitted without oscillations that have wandered off to where nothing swings."""
    for _ in range(8):
        poles = model.fit.poles
        fine = believable(poles, record) & (poles.omega * record.dt < FOLD)
        slow = (poles.creep * record.t[-1] > SLOWEST) & (poles.creep * record.dt < FADED)
        if fine.all() and slow.all():
            return model
        poles = Poles(poles.decay[fine], poles.omega[fine], poles.creep[slow])
        model = model_of(record, poles, model.degree, TRIAL)
    return model


def _grown(record: Record, model: Model, most: int) -> Model | None:
    """The model with the mode or trend that it misses most, None if it misses nothing."""
    p = model.fit.poles
    steeper = range(model.degree + 1, DEGREE + 1)
    steps = [(model_of(record, p, d, TRIAL), None) for d in steeper]
    if not len(p.creep):
        tries = [Poles(p.decay, p.omega, np.array([c / record.t[-1]])) for c in (1.0, 4.0)]
        steps += [(model_of(record, poles, 0, TRIAL), model.modes) for poles in tries]
    if model.modes < most:
        steps += [(larger, model.modes) for larger in _one_more(record, model)]
    for larger, k in sorted(steps, key=lambda step: _score(record, step[0])):
        if _reasonable(record, larger) is larger and needed(record, model, larger, k):
            return model_of(record, larger.fit.poles, larger.degree)
    return None


def _one_more(record: Record, model: Model) -> list[Model]:
    """Models with one more oscillation: from the residual's own poles, or by splitting one."""
    poles = model.fit.poles
    if 4 * (model.modes + 1) + 2 > record.size.min() - 4:
        return []
    _, left = evenly(record.t, model.fit.residual / np.where(record.floor > 0, record.floor, 1))
    space = signal_space(left)
    tried = [_poles_of(shift_poles(space, n, record.dt), record)[0] for n in (2, 4, 6)]
    places = {(s, w) for p in tried for s, w in zip(p.decay, p.omega, strict=True)}
    for s, w in zip(poles.decay, poles.omega, strict=True):
        apart = max(s, 2 * np.pi / record.t[-1]) / 2
        places |= {(s, w + apart), (s, max(w - apart, w / 2))}
    starts = [
        Poles(np.append(poles.decay, s), np.append(poles.omega, w), poles.creep)
        for s, w in sorted(places)
    ]
    quick = [(model_of(record, p, model.degree, 0).fit.cost, n) for n, p in enumerate(starts)]
    chosen = [starts[n] for _, n in sorted(quick)[:2]]
    return [model_of(record, p, model.degree, TRIAL) for p in chosen]
