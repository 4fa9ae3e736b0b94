"""What the search for what is missing found, and what comes near it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .effects import DAMPING
from .law import TimeFit
from .time_layer import NEARLY, Candidate

if TYPE_CHECKING:
    from .joint import Heard


@dataclass(frozen=True, eq=False)
class Whole:
    """The motion with modes of the body that nobody heard."""

    heard: "Heard"  # with these in its match and its turns
    found: TimeFit


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the time layer found. `chain[0]` is the declared fit; the last is the final one."""

    verdict: str
    chain: tuple[tuple[str | None, TimeFit], ...]
    effects: tuple[Candidate, ...]  # one a found effect, in the order of the chain
    twins: tuple[tuple[str, ...], ...]  # of each found effect
    ranked: tuple[Candidate, ...]
    minor: tuple[tuple[str, float], ...]
    why: str = ""  # a refusal's reason, and what to film instead
    # the final fit without modes that were not heard, where it foretells what these do
    bare: TimeFit | None = None
    # where the final fit tells of the heard modes, and foretells what all of them do
    whole: Whole | None = None
    # two effects that explain what the one owes, where no other reason of that is found
    rather: "Verdict | None" = None

    @property
    def final(self) -> TimeFit:
        return self.chain[-1][1]

    @property
    def complete(self) -> TimeFit:
        """The final fit, of all modes that it counts."""
        return self.whole.found if self.whole else self.final

    @property
    def names(self) -> tuple[str, ...]:
        """Of the found effects."""
        return tuple(c.names[-1] for c in self.effects)

    @property
    def by_law(self) -> tuple[str, ...]:
        """Of those that are told by a law, and not read off the record."""
        free = {effect.name for effect in self.final.law.effects if effect.free}
        return tuple(name for name in self.names if name not in free)

    @property
    def laws(self) -> int:
        """Laws of damping that were found; they come first in the chain."""
        return sum(name in DAMPING for name, _ in self.chain)

    @property
    def damped(self) -> TimeFit:
        """The declared fit, with the law of damping that was found."""
        return self.chain[self.laws][1]


def partly(chain, best: Candidate, strong: list[Candidate], ranked) -> Verdict:
    """Not explained, but `best` takes its part."""
    chain += ((best.names[0], best.found),)
    return Verdict("unexplained", chain, (best,), (twins_of(best, strong),), ranked, ())


def twins_of(candidate: Candidate, others) -> tuple[str, ...]:
    """Names of single effects whose evidence comes near the candidate's."""
    name = candidate.names[-1]
    return tuple(
        c.names[-1]
        for c in others
        if c.names[-1] != name
        and c.evidence >= NEARLY * candidate.evidence
        and not c.held_share < NEARLY * min(candidate.held_share, 1.0)
    )


def probabilities(ranked, declared: TimeFit) -> list[float]:
    """Of each candidate, that it is the one effect."""
    return list(_shares([c.found for c in ranked], declared))


def probability(verdict: Verdict, name: str) -> float:
    """That a found effect is there: the final fit against all that were made without it; a law of
    damping by the fit that it came with, for all that was raced later has it.
    """
    place = _place(verdict, name)
    before = [found for _, found in verdict.chain[:place]] or [verdict.chain[0][1]]
    if name in DAMPING:
        return float(_shares([verdict.chain[place][1], *before], verdict.chain[0][1])[0])
    before += [c.found for c in verdict.ranked if name not in c.names]
    return float(_shares([verdict.bare or verdict.final, *before], verdict.chain[0][1])[0])


def _place(verdict: Verdict, name: str) -> int:
    """Of an effect in the chain; where it is none of its rows, of the last."""
    rows = [row for row, _ in verdict.chain]
    return rows.index(name) if name in rows else len(rows) - 1


def _shares(fits: list[TimeFit], declared: TimeFit) -> np.ndarray:
    """(n,) of each fit, tempered: a misfit's independent pieces are its cycles, not its samples.

    The likelihood of a fit whose own error is unknown falls as its misfit to the power -n/2, with
    n the cycles of the first mode in the fitted part.
    """
    if not fits:
        return np.empty(0)
    cycles = declared.law.setting.omega[0] / (2 * np.pi) * declared.law.setting.duration
    misfits = np.array([found.chi2 for found in fits])
    weight = (misfits / misfits.min()) ** (-max(cycles, 4) / 2)
    return weight / weight.sum()
