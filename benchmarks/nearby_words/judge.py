"""How good the answers of a method are by the key."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.search.takings import SUGGESTED, TAKEN
from nearby_words.methods import Method
from nearby_words.pairs import base

DRAWS = 2000
"""Bootstrap samples of an interval. Chosen by hand; not tuned."""


@dataclass(frozen=True)
class Answer:
    """The answer of a method to a word of the key: its first answer (None: no answer) with its
    probability, whether it is right, and whether the vocabulary has a right answer."""

    word: str
    first: str | None
    chance: float
    right: bool
    has_answer: bool


def ask_all(
    method: Method, key: Mapping[str, frozenset[str]], known: frozenset[str]
) -> list[Answer]:
    """Ask for every word of the key that the vocabulary lacks."""
    answers = []
    for word, right in key.items():
        if word in known or base(word) in known:
            continue
        told = method(word, known)
        first, chance = told[0] if told else (None, 0.0)
        answers.append(Answer(word, first, chance, first in right, bool(right & known)))
    return answers


Share = Callable[[Sequence[Answer]], tuple[int, int]]
MEASURES: dict[str, Share] = {
    "first is right": lambda a: (sum(x.right for x in a if x.has_answer), _number(a, True)),
    "right when taken": lambda a: (
        sum(x.right for x in a if x.chance >= TAKEN), sum(x.chance >= TAKEN for x in a)
    ),
    "taken and right": lambda a: (
        sum(x.right and x.chance >= TAKEN for x in a if x.has_answer), _number(a, True)
    ),
    "right when taken or suggested": lambda a: (
        sum(x.right for x in a if x.chance >= SUGGESTED), sum(x.chance >= SUGGESTED for x in a)
    ),
    "not taken where nothing fits": lambda a: (
        sum(x.chance < TAKEN for x in a if not x.has_answer), _number(a, False)
    ),
    "nothing said where nothing fits": lambda a: (
        sum(x.chance < SUGGESTED for x in a if not x.has_answer), _number(a, False)
    ),
}  # fmt: skip
"""From answers to (how many, of how many)."""


def interval(answers: Sequence[Answer], share: Share, seed: int) -> tuple[float, float]:
    """95 % bootstrap interval of a share, words drawn with replacement."""
    rng = np.random.default_rng(seed)
    shares = []
    for _ in range(DRAWS):
        drawn = [answers[n] for n in rng.integers(0, len(answers), len(answers))]
        many, of = share(drawn)
        shares.append(many / of if of else np.nan)
    low, high = np.nanpercentile(shares, [2.5, 97.5])
    return float(low), float(high)


def reliability(answers: Sequence[Answer]) -> list[tuple[float, float, float, float, int]]:
    """By tenths of probability: from, to, mean probability, share right, how many."""
    rows = []
    for low, high in ((0.1, 0.3), (0.3, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 1.01)):
        there = [a for a in answers if low <= a.chance < high]
        if there:
            mean = float(np.mean([a.chance for a in there]))
            rows.append((low, min(high, 1.0), mean, sum(a.right for a in there) / len(there),
                         len(there)))  # fmt: skip
    return rows


def _number(answers: Sequence[Answer], has_answer: bool) -> int:
    return sum(a.has_answer == has_answer for a in answers)
