"""The number of terminals: the smallest number whose description length is nearly the shortest.

Every number K of terminals that is tried gives a total of bits (``ledger``). The total is smallest
if the terminals are neither too coarse for the motion nor too many for its repetitions. But the
search for terminals is random: with another seed the total differs by more than the totals of
neighbouring numbers do, and the smallest total is often due to chance. The totals are therefore
modelled as the curve

    b_0 + b_1 log K + b_2 K

with random deviations of standard deviation s. (Residuals decrease with K; medoids and rules
increase.) The best number and the next smaller one are tried again, and the better of the two tries
is used. The choice is the smallest number whose total exceeds the least by at most one standard
error of the mean of two tries, s / sqrt(2). Further terminals must therefore save more bits than
chance explains.

Source of the one-standard-error rule: L. Breiman, J. H. Friedman, R. A. Olshen and C. J. Stone,
"Classification and Regression Trees" (1984), section 3.4.3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.selection.ledger import Ledger, ledger_of, performance_noise
from motiondb.grammar.sentences.partition import Sentences, find_sentences
from motiondb.grammar.terminals.likeness import class_levels
from motiondb.grammar.terminals.pose_distance import make_poses
from motiondb.grammar.terminals.terminals import (
    Terminals,
    TerminalSettings,
    find_terminals,
    strings_of,
)
from motiondb.records import Motion

CANDIDATES = (4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 30, 36, 44, 52, 60)
"""Numbers of terminals, each about a fifth above the one before. Every fourth is tried, then those
near the best."""

_STEPS, _FIRST = (4, 2, 1), 2
"""Steps of the search in ``CANDIDATES``, coarse to fine, and the place of the first number that is
tried."""
_TRIES = 2  # How often the best number and the next smaller one are tried
_TRIED = 12  # Usual number of tries, for the progress bar only

_FEWEST_FITTED = 5
"""Fewest numbers to which the curve is fitted. It has three parameters, so that two degrees of
freedom remain for the deviations."""

Learn = Callable[[Terminals, np.random.Generator], Sentences]
"""Learns sentences and grammar from the strings of terminals."""

Progress = Callable[[int, int, str], None]
"""Called with the number of tries done, their expected number, and the name of the next try."""


@dataclass(frozen=True, eq=False)
class Trial:
    """The result of one try with a number of terminals."""

    terminals: Terminals
    sentences: Sentences  # Sentences and grammar learned from their strings
    ledger: Ledger  # Description length of all, in bits


@dataclass(frozen=True, eq=False)
class Choice:
    """The chosen number of terminals, and the better try of every number that was tried."""

    number: int
    trials: dict[int, Trial]  # The better try of each number, by ascending number
    # s, the standard deviation of the totals by chance, in bits; 0 if too few numbers were tried
    noise: float

    @property
    def terminals(self) -> Terminals:
        """Terminals of the chosen number."""
        return self.trials[self.number].terminals

    @property
    def sentences(self) -> Sentences:
        """Sentences and grammar learned with the chosen number."""
        return self.trials[self.number].sentences

    @property
    def ledgers(self) -> dict[int, Ledger]:
        """The ledger of each number that was tried."""
        return {number: trial.ledger for number, trial in self.trials.items()}


def search_noise(bits: Mapping[int, float]) -> float:
    """Return the standard deviation of bits about b_0 + b_1 log K + b_2 K, fitted by least squares.

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
    """Return the standard error of the mean of two tries."""
    return noise / _TRIES**0.5


def choose_number(bits: Mapping[int, float], noise: float) -> int:
    """Return the smallest number within one standard error of the fewest bits.

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
    """Choose the number of terminals by description length, and learn with it.

    `candidates`: Numbers of terminals, all of which are tried. By default about ten of
    ``CANDIDATES`` are tried, coarse to fine. Numbers for which the takes are too short are left
    out.

    `progress`: Called before each try with the number of tries done, their expected number, and a
    text.
    """
    learn = learn or partial(_learn, takes)
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
    """Yield the numbers to try, one by one; read the results so far from ``trials``.

    At the end the best number and the next smaller one are yielded once more.
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
    """Return the numbers to try next; none at the end of the search.

    These are all of the grid. If ``coarse_to_fine``, they are first every fourth number of the
    grid, then those four, two and one places from the best.
    """
    if not coarse_to_fine:
        return [number for number in grid if number not in tried]
    if not tried:
        return list(grid[_FIRST :: _STEPS[0]])
    if not bits:  # the takes are too short for all tried: try a smaller number
        return [number for number in reversed(grid) if number < min(tried)][:1]
    place = grid.index(min(bits, key=lambda number: bits[number]))
    for step in _STEPS:
        around = [p for p in (place - step, place + step) if 0 <= p < len(grid)]
        if new := [grid[p] for p in around if grid[p] not in tried]:
            return new
    return []


def _learn(takes: Sequence[Motion], terminals: Terminals, rng: np.random.Generator) -> Sentences:
    return find_sentences(strings_of(terminals), rng, levels=class_levels(takes, terminals))
