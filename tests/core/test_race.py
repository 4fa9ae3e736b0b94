"""From where a search for one effect begins."""

from types import SimpleNamespace

import numpy as np

from core import race, time_layer
from core.race import APART

STRENGTHS, PLACES = (1.0, 2.0), 12


def rub(**more):
    """A search for a force of two strengths at twelve places, the last of which promises most."""
    begins = [(size, float(place)) for size in STRENGTHS for place in range(PLACES)]
    setting = SimpleNamespace(places=np.arange(PLACES, dtype=float)[:, None])
    law = SimpleNamespace(setting=setting, damping="free")
    effect = SimpleNamespace(low=(0.0,), force=True, damps=True, places=48, marched=True)
    return SimpleNamespace(
        start=SimpleNamespace(law=law), law=law, effect=effect, begins=begins, outset=None,
        promise=np.array([place for _, place in begins]), runners=100, every=False, horizons=(1.0,),
        **more,
    )  # fmt: skip


def begun_at(one, monkeypatch):
    monkeypatch.setattr(race, "begin", lambda start, effect, begins: begins)
    monkeypatch.setattr(race, "outsets", lambda start, law, some: np.array(some[0]))
    return {tuple(place) for place in race._places(one)}


def test_a_search_begins_at_the_likeliest_places_of_each_strength(monkeypatch):
    best, near = PLACES - 1.0, APART - 1.0
    expected = {(size, place) for size in STRENGTHS for place in (best, near)}
    assert begun_at(rub(), monkeypatch) == expected


def test_a_search_from_everywhere_begins_on_a_few_periods_of_a_short_record():
    """One that began on more of it would slip past what bends a pitch far."""

    def shares(periods, most, every=True):
        setting = SimpleNamespace(omega=np.array([2 * np.pi * periods]), duration=1.0)
        start = SimpleNamespace(law=SimpleNamespace(setting=setting))
        one = SimpleNamespace(start=start, horizons=race.HORIZONS, every=every)
        return race._shares(one, most)

    assert shares(100.0, 1.0) == list(race.HORIZONS)
    assert shares(10.0, race.HALF) == [race.PERIODS / 10, *race.HORIZONS[1:3]]
    assert shares(10.0, race.HALF, every=False) == list(race.HORIZONS[1:3])
    assert shares(3.0, race.HALF) == []
    assert shares(3.0, 1.0) == list(race.HORIZONS[3:])  # one share holds hardly more than another
    assert shares(2.2, 1.0) == shares(1.0, 1.0) == [1.0]


def test_the_best_one_is_sought_anew_and_what_leaves_least_where_it_was_fitted():
    def one(chi2, outdone=False):
        fit = SimpleNamespace(chi2=chi2)
        return time_layer.Candidate(("rub",), fit, 0.0, 0.0, 0.0, outdone)

    best, nearest, plainer, other = one(10.0), one(5.0), one(1.0, outdone=True), one(20.0)
    assert time_layer._nearest([[best, nearest, plainer]]) == [(0, best), (0, nearest)]
    assert time_layer._nearest([[other, nearest], [best], []]) == [(1, best), (0, nearest)]
    assert time_layer._nearest([[nearest, best]]) == [(0, nearest)]
    assert time_layer._nearest([[]]) == []


def test_what_is_sought_anew_begins_everywhere_with_less_damping(monkeypatch):
    lighter = object()
    monkeypatch.setattr(time_layer, "lighter", lambda start: lighter)
    monkeypatch.setattr(
        time_layer, "replace", lambda one, **new: SimpleNamespace(**vars(one) | new)
    )
    _, everywhere = time_layer._anew(rub())
    assert everywhere.outset is lighter and everywhere.runners == time_layer.MANY
    monkeypatch.setattr(everywhere, "outset", None)
    assert begun_at(everywhere, monkeypatch) == set(rub().begins)
