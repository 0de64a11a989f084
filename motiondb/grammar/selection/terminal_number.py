"""How many terminals there should be: the fewest whose description is the shortest, but for chance.

Every number K that is tried gives a sum of bits (``ledger``), least where terminals are neither too
coarse for the motion nor too many for what recurs. But terminals are searched for at random: with
another seed the sum comes out otherwise, by more than neighbouring numbers differ, and the least
sum is often a lucky one. So the sums are taken for drawn around

    b_0 + b_1 log K + b_2 K

(left-overs shrink with K; medoids and rules grow), with the standard deviation s about that curve.
The best number and the next smaller one are tried once more, the better try counts; and of the
numbers whose sum is above the least by no more than one standard error of two tries, s / sqrt(2),
the smallest is chosen: a terminal more must earn more than chance gives.

Source of the rule of one standard error: L. Breiman, J. H. Friedman, R. A. Olshen and C. J. Stone,
"Classification and Regression Trees" (1984), section 3.4.3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.selection.ledger import Ledger, ledger_of, performance_noise
from motiondb.grammar.sentences.partition import Sentences, find_sentences
from motiondb.grammar.terminals.pose_distance import make_poses
from motiondb.grammar.terminals.terminals import (
    Terminals,
    TerminalSettings,
    find_terminals,
    strings_of,
)
from motiondb.records import Motion

CANDIDATES = (4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 30, 36, 44, 52, 60)
"""Numbers of terminals, about a fifth apart: every fourth is tried, then those between around the
best."""

_STEPS, _FIRST = (4, 2, 1), 2
_TRIES = 2
"""How often the best number and the next smaller are tried."""
_TRIED = 12
"""How many tries there are, about, for the progress bar."""

_FEWEST_FITTED = 5
"""Numbers that tell the noise of their sums: three are spent on the curve."""

Learn = Callable[[Terminals, np.random.Generator], Sentences]
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Trial:
    """What was learned with a number of terminals, and its bits."""

    terminals: Terminals
    sentences: Sentences
    ledger: Ledger


@dataclass(frozen=True, eq=False)
class Choice:
    """The number of terminals, and the better try of every number that was tried.

    noise : s, bits, by which sums differ by chance.
    """

    number: int
    trials: dict[int, Trial]
    noise: float

    @property
    def terminals(self) -> Terminals:
        """Those of the chosen number."""
        return self.trials[self.number].terminals

    @property
    def sentences(self) -> Sentences:
        """What was learned from them."""
        return self.trials[self.number].sentences

    @property
    def ledgers(self) -> dict[int, Ledger]:
        """Of each number."""
        return {number: trial.ledger for number, trial in self.trials.items()}


def search_noise(bits: Mapping[int, float]) -> float:
    """Return the standard deviation of bits about b_0 + b_1 log K + b_2 K, fitted by least squares.

    bits : number of terminals -> the sum that was found for it. 0 for fewer than five numbers.

    >>> curve = {k: 900.0 - 200.0 * float(np.log(k)) + 30.0 * k for k in (4, 6, 8, 12, 24)}
    >>> round(search_noise(curve), 6)
    0.0
    """
    if len(bits) < _FEWEST_FITTED:
        return 0.0
    numbers, sums = np.array(list(bits), dtype=np.float64), np.array(list(bits.values()))
    basis = np.stack([np.ones(len(numbers)), np.log(numbers), numbers], axis=1)
    left = sums - basis @ np.linalg.lstsq(basis, sums, rcond=None)[0]
    return float(np.sqrt((left**2).sum() / (len(sums) - basis.shape[1])))


def standard_error(noise: float) -> float:
    """Of the mean of two tries, bits; noise : s, of a single try."""
    return noise / _TRIES**0.5


def choose_number(bits: Mapping[int, float], noise: float) -> int:
    """Return the smallest number within one standard error of the fewest bits.

    bits : number of terminals -> the least sum of its tries. noise : s, of a single try.

    >>> choose_number({6: 520.0, 8: 503.0, 12: 500.0}, 10.0)
    8
    """
    most = min(bits.values()) + standard_error(noise)
    return min(number for number, total in bits.items() if total <= most)


def choose_terminals(
    takes: Sequence[Motion],
    rng: np.random.Generator,
    *,
    candidates: Sequence[int] | None = None,
    settings: TerminalSettings | None = None,
    learn: Learn | None = None,
    progress: Progress | None = None,
) -> Choice:
    """Terminals, sentences and rules for the number of terminals that bits ask for.

    Parameters
    ----------
    candidates : numbers that are all tried. Unless given, some of ``CANDIDATES`` are, from coarse
        to fine: about ten. Numbers for which the takes are too short are left out.
    learn : makes the sentences of terminals; :func:`partition.find_sentences` unless given.
    progress : told how many tries there were, of how many at most.

    Raises
    ------
    GrammarError where no candidate is given, or the takes are too short for each.
    """
    learn = learn or _learn
    poses = make_poses(takes)
    precision = performance_noise(poses.values, poses.bounds)
    trials: dict[int, Trial] = {}
    fault: GrammarError | None = None
    grid = CANDIDATES if candidates is None else sorted(set(candidates))
    for done, number in enumerate(_numbers(grid, trials, candidates is None)):
        if progress is not None:
            progress(done, max(_TRIED, done + 1), f"try {number} terminals")
        try:
            terminals = find_terminals(takes, number, rng, settings=settings)
        except GrammarError as error:
            fault = fault or error
            continue
        sentences = learn(terminals, rng)
        ledger = ledger_of(poses, terminals, sentences, precision)
        if number not in trials or ledger.total < trials[number].ledger.total:
            trials[number] = Trial(terminals, sentences, ledger)
    if not trials:
        raise fault or GrammarError(
            "terminals: expected numbers to choose from, found none. Give some, such as 12 20 40."
        )
    bits = _bits(trials)
    noise = search_noise(bits)
    return Choice(choose_number(bits, noise), dict(sorted(trials.items())), noise)


def _bits(trials: Mapping[int, Trial]) -> dict[int, float]:
    return {number: trial.ledger.total for number, trial in trials.items()}


def _numbers(
    grid: Sequence[int], trials: Mapping[int, Trial], coarse_to_fine: bool
) -> Iterator[int]:
    """Return what is tried, one after another, while ``trials`` fill.

    Then the best two once more.
    """
    tried: set[int] = set()
    while waiting := _next_numbers(grid, tried, _bits(trials), coarse_to_fine):
        for number in waiting:
            tried.add(number)
            yield number
    bits = _bits(trials)
    if len(bits) >= _FEWEST_FITTED:
        best = min(bits, key=lambda number: bits[number])
        yield from sorted(number for number in bits if number <= best)[-2:]


def _next_numbers(
    grid: Sequence[int], tried: Set[int], bits: Mapping[int, float], coarse_to_fine: bool
) -> list[int]:
    """Return what is to be tried next.

    All, or every fourth, then what is two and one from the best.
    """
    if not coarse_to_fine:
        return [number for number in grid if number not in tried]
    if not tried:
        return list(grid[_FIRST :: _STEPS[0]])
    if not bits:  # too many for these takes: fewer, if there are
        return [number for number in reversed(grid) if number < min(tried)][:1]
    place = grid.index(min(bits, key=lambda number: bits[number]))
    for step in _STEPS:
        around = [p for p in (place - step, place + step) if 0 <= p < len(grid)]
        if new := [grid[p] for p in around if grid[p] not in tried]:
            return new
    return []


def _learn(terminals: Terminals, rng: np.random.Generator) -> Sentences:
    return find_sentences(strings_of(terminals), rng)
