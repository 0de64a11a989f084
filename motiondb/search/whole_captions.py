"""The contribution of a question in quotation marks to an answer as a whole caption.

A question in quotation marks (``"a person walks, then sits down"``) is also compared with the
caption that the motion of a capture suggests (:mod:`motiondb.meaning.caption_map`). The
likeness
is a sum over the question's words. It is taken relative to its mean over all captures of the
database, times ``CAPTION_WEIGHT``, and added word by word to the log-odds that rank the answers. It
does not use order and place, and is not part of the probability of an answer.

Other questions are not compared in this way: "walk" asks for all captures that show walking, not
for a capture whose whole caption is "walk". Questions with alternatives, exclusions, counts or
durations are not captions and are not compared either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from motiondb.language.question.readings import Reading
from motiondb.learn.learned import Learned
from motiondb.records import FloatArray
from motiondb.search.answer_chances import counts_or_lasts
from motiondb.search.reasons import WordReason

CAPTION_WEIGHT = 10.0
"""Nats for a likeness of 1. Chosen among 10, 20 and 40 by leaving performers out of the CMU
training parts (``docs/quality.md``, "Whole captions to motion")."""
QUOTES = (('"', '"'), ("\u201c", "\u201d"), ("\u201e", "\u201c"))
"""Pairs of quotation marks around a caption."""


@dataclass(frozen=True, eq=False)
class CaptionShares:
    """The contribution of each word of a question to each capture."""

    words: tuple[int, ...]  # Numbers of the words
    amounts: Mapping[int, FloatArray]  # Capture number -> array (words,), nats

    def total(self, capture: int) -> float:
        """The contribution of the question to a capture."""
        return float(self.amounts[capture].sum()) if self.words else 0.0


def unquote(text: str) -> tuple[str, bool]:
    """A question without quotation marks around it, and whether it had them.

    >>> unquote('"walk, sit"'), unquote('walk')
    (('walk, sit', True), ('walk', False))
    """
    bare = text.strip()
    for opening, closing in QUOTES:
        if len(bare) > 1 and bare.startswith(opening) and bare.endswith(closing):
            return bare[1:-1], True
    return text, False


def caption_shares(learned: Learned, readings: Sequence[Reading]) -> CaptionShares:
    """The contributions of a question as a whole caption; no words if it is not one."""
    words = _asked_words(learned, readings)
    if not words or learned.caption_map is None:
        return CaptionShares((), {})
    rows = learned.suggested_captions[:, list(words)] * learned.caption_map.question(words)
    amounts = CAPTION_WEIGHT * (rows - rows.mean(axis=0))
    return CaptionShares(words, dict(zip(learned.rows, amounts)))


def with_shares(
    why: Sequence[WordReason], shares: CaptionShares, capture: int
) -> tuple[WordReason, ...]:
    """Reasons with contribution of each word to the whole caption at the word's first reason."""
    if not shares.words:
        return tuple(why)
    left = dict(zip(shares.words, shares.amounts[capture].tolist()))
    return tuple(replace(reason, as_caption=left.pop(reason.word, 0.0)) for reason in why)


def _asked_words(learned: Learned, readings: Sequence[Reading]) -> tuple[int, ...]:
    """Numbers of the different words of the only reading; empty if the question is not a caption.

    Words that are replaced by known ones have numbers after the vocabulary and are left out.
    """
    if len(readings) != 1 or readings[0].exclusions or counts_or_lasts(readings[0]):
        return ()
    said = [word for part in readings[0].parts for action in part.actions for word in action]
    n_words = 0 if learned.caption_map is None else len(learned.caption_map.rarity)
    numbers = dict.fromkeys(learned.word_numbers[word] for word in said)
    return tuple(number for number in numbers if number < n_words)
