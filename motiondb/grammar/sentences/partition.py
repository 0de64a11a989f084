"""Cut strings into sentences: search for the partition of shortest description length.

The description length of a partition is the bits of the rules learned from its sentences, and of
the sentences given the rules. Learning rules in full takes seconds, so partitions compete:

1. *Candidates.* The paper's candidates do not divide a chosen repeat (``cutting``). But in strings
   of ten and more sentences, repeats cover about nine true borders in ten by chance. So others are
   cut without regard to repeats, or at all borders of one kind or of several (``borders``).
2. *Race.* Rules are annealed for each candidate. The third with the fewest bits is annealed three
   times as often, and so on, until a few finalists are left.
3. *Improvement.* Each finalist is changed many times: its strings are cut again by the present
   rules (``reparsing``), or cuts of one kind are changed (``borders``), then rules annealed.
   A change that costs bits is accepted with a probability that decreases with cost and time.
4. *Loops.* The best one is changed further, with rules that may loop.
5. *Classes.* If partitions of the terminals into classes are given (``classes``), the best of them
   in a short race is searched in the same way, with classes in the place of terminals.
6. *Result.* The grammar of the partition of fewest bits is learned in full.

Ends of strings are always cuts. A sentence is shorter than the shortest only if it is a whole
string, and longer than the longest only if no other cut is allowed.

Sources: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.2, for the description length of partitions and the
cover of repeats; O. Maron and A. W. Moore, "The Racing Algorithm", Artificial Intelligence Review
11 (1997), for races.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import Grammar, GrammarError
from motiondb.grammar.induction.induction import Induction
from motiondb.grammar.rules.description_length import DescriptionLength, Sentence
from motiondb.grammar.rules.rule_set import RuleSet
from motiondb.grammar.sentences.borders import (
    Cuts,
    recurring_splits,
    too_long,
    united_splits,
)
from motiondb.grammar.sentences.classes import (
    by_class,
    induce_in_classes,
    present,
    spelled_out,
)
from motiondb.grammar.sentences.cutting import (
    LONGEST,
    SHORTEST,
    Progress,
    Room,
    cutting_room,
    search_cuts,
)
from motiondb.grammar.sentences.improvement import FINALISTS, Judged, improve, race
from motiondb.grammar.terminals.likeness import Classes

EVALUATIONS = 4000
"""Default number of evaluations. The numbers of evaluations, annealings and changes in this
module were chosen by hand on strings of known grammars (docs/grammar.md)."""
_SEARCHES = 3
"""Searches for candidates: one that respects repeats, and two that do not."""
_FULLY_SEARCHED = 200
"""Number of symbols of all strings up to which all evaluations are made; for more symbols fewer,
to limit the time."""
_STEPS = 7
"""Steps Chosen by hand."""
_CHANGES_A_SYMBOL, _EVALUATIONS_A_CHANGE = 2, 20
"""Largest number of changes of a round per symbol of the strings, and the number of evaluations
that a change counts as."""
_WITH_LOOPS = 0.5
"""Changes with loops allowed, as a share of those of a round. Chosen by hand, to bound the time."""


@dataclass(frozen=True)
class Sentences:
    """A partition of strings, and the grammar learned from it.

    Attributes
    ----------
    cuts : tuple of tuples of int
        Places of the inner cuts of each string, ascending.
    sentences : tuple of tuples of str
        All sentences, string by string.
    induction : Induction
        The grammar, how it was found, and the description length.
    """

    cuts: tuple[tuple[int, ...], ...]
    sentences: tuple[Sentence, ...]
    induction: Induction

    @property
    def grammar(self) -> Grammar:
        """The grammar learned from the sentences."""
        return self.induction.grammar

    @property
    def bits(self) -> DescriptionLength:
        """Bits of the rules, and of the sentences given the rules."""
        return self.induction.bits


def find_sentences(
    strings: Sequence[Sentence],
    rng: np.random.Generator,
    *,
    lengths: tuple[int, int] = (SHORTEST, LONGEST),
    evaluations: int = EVALUATIONS,
    levels: Sequence[Classes] = (),
    progress: Progress | None = None,
) -> Sentences:
    """Cut strings of terminals into sentences and learn their grammar.

    Parameters
    ----------
    strings : sequence of sequences of str
        Strings of terminals.
    rng : numpy.random.Generator
        Draws candidates, changes and annealings.
    lengths : tuple of int, optional
        Shortest and longest sentence, in symbols.
    evaluations : int, optional
        Effort: evaluations of candidates, and changes in proportion; fewer for long strings.
    levels : sequence of Classes, optional
        Partitions of the terminals into classes of like motion. They are used where they save bits.
    progress : callable, optional
        Called with the number of steps done and the number of all steps.

    Raises
    ------
    GrammarError
        See :func:`motiondb.grammar.sentences.cutting.cutting_room`.
    """
    tell = progress or (lambda _done, _of: None)
    steps = _STEPS * (2 if levels else 1)
    effort = _Effort(lengths, evaluations, rng)
    plain = _search(strings, effort, lambda done: tell(done, steps))
    best = plain.cuts, plain.rules
    if classes := _best_classes(strings, levels, effort):
        counts = Counter(name for string in strings for name in string)
        written = by_class(strings, classes)
        other = _search(written, effort, lambda done: tell(_STEPS - 1 + done, steps))
        rules = spelled_out(other.rules, classes, counts)
        if rules.bits() < plain.bits:
            best = other.cuts, rules
    sentences = _learned(strings, best[0], [best[1]], levels)
    tell(steps, steps)
    return sentences


@dataclass(frozen=True, eq=False)
class _Effort:
    """Shortest and longest sentence, the wanted number of evaluations, and random numbers."""

    lengths: tuple[int, int]
    evaluations: int
    rng: np.random.Generator


def _search(strings: Sequence[Sentence], effort: _Effort, tell: Callable[[int], None]) -> Judged:
    """Search a partition of strings: candidates, race, improvement, loops."""
    lengths, rng = effort.lengths, effort.rng
    total = sum(map(len, strings))
    room = cutting_room(strings, *lengths)
    evaluations = max(1, round(effort.evaluations * min(1.0, _FULLY_SEARCHED / total) ** 2))
    candidates = [*_searched(strings, room, lengths, rng, evaluations), *_split(strings, lengths)]
    candidates = [cuts for cuts in candidates if not too_long(strings, cuts, lengths)] or candidates
    tell(1)
    improved = race(strings, candidates, rng)
    tell(2)
    changes = min(evaluations // _EVALUATIONS_A_CHANGE, _CHANGES_A_SYMBOL * total)
    for heat, number in enumerate((FINALISTS, FINALISTS // 2, 1), start=3):
        spent = changes // number
        improved = [improve(strings, one, lengths, rng, spent) for one in improved[:number]]
        improved.sort(key=lambda judged: judged.bits)
        tell(heat)
    spent = math.ceil(_WITH_LOOPS * changes)
    looping = improve(strings, improved[0], lengths, rng, spent, loops=True)
    tell(_STEPS - 1)
    return looping


def _split(strings: Sequence[Sentence], lengths: tuple[int, int]) -> list[Cuts]:
    return [*recurring_splits(strings, *lengths), *united_splits(strings, *lengths)]


def _best_classes(
    strings: Sequence[Sentence], levels: Sequence[Classes], effort: _Effort
) -> Classes | None:
    """Return the classes with which a race of regular partitions finds the fewest bits."""
    counts = Counter(name for string in strings for name in string)
    best, least = None, math.inf
    for level in levels:
        classes = present(level, strings)
        if classes is None:
            continue
        written = by_class(strings, classes)
        split = [
            c for c in _split(written, effort.lengths) if not too_long(written, c, effort.lengths)
        ]
        if not split:
            continue
        raced = race(written, split, effort.rng)[0]
        bits = spelled_out(raced.rules, classes, counts).bits()
        if bits < least:
            best, least = classes, bits
    return best


def _searched(
    strings: Sequence[Sentence],
    room: Room,
    lengths: tuple[int, int],
    rng: np.random.Generator,
    evaluations: int,
) -> Iterator[Cuts]:
    """Yield the best partition of each search: one in the covered room, two in the free room."""
    free = cutting_room(strings, *lengths, free=True)
    for searched in (room, free, free):
        cuts, _ = search_cuts(searched, rng, max(1, evaluations // _SEARCHES))
        yield _by_string(cuts, room)


def _by_string(cuts: Sequence[int], room: Room) -> Cuts:
    bounds = pairwise(room.bounds)
    return tuple(tuple(c - low for c in cuts if low < c < high) for low, high in bounds)


def sentences_between(
    strings: Sequence[Sentence],
    cuts: Sequence[Sequence[int]],
    levels: Sequence[Classes] = (),
) -> Sentences:
    """Learn the grammar of a given partition.

    Parameters
    ----------
    strings : sequence of sequences of str
        Strings of terminals.
    cuts : sequence of sequences of int
        Inner cuts of each string: the place of the symbol that begins a sentence, from 0 on.
    levels : sequence of Classes, optional
        Partitions of the terminals into classes of like motion. They are used where they save bits.

    Raises
    ------
    GrammarError
        The cuts of a string are not ascending places inside it, or a string is empty.
    """
    for number, (string, inner) in enumerate(zip(strings, cuts, strict=True), start=1):
        edges = [0, *inner, len(string)]
        if any(low >= high for low, high in pairwise(edges)):
            raise GrammarError(
                f"string {number}: expected rising cuts between 1 and {len(string) - 1}, found"
                f" {', '.join(map(str, inner)) or 'none in an empty string'}."
                " Give each cut as the number of the symbol that begins a sentence."
            )
    return _learned(strings, tuple(tuple(int(cut) for cut in inner) for inner in cuts), (), levels)


def _learned(
    strings: Sequence[Sentence],
    cuts: Cuts,
    known: Sequence[RuleSet],
    levels: Sequence[Classes],
) -> Sentences:
    sentences = tuple(
        tuple(string[a:b])
        for string, inner in zip(strings, cuts, strict=True)
        for a, b in pairwise((0, *inner, len(string)))
    )
    return Sentences(cuts, sentences, induce_in_classes(sentences, levels, known))
