"""The captures that answer a question in words, best first, with reasons and certainty.

A question in quotation marks (``"a person walks, then sits down"``) is also compared with the
caption that the motion of a capture suggests (:mod:`motiondb.meaning.word_map`). The
likeness is a sum over the question's words. It is taken relative to its mean over all captures of
the database, times ``CAPTION_WEIGHT``, and added word by word to the log-odds that rank the
answers. It does not use order and place, and is not part of the probability of an answer.

Other questions are not compared in this way: "walk" asks for all captures that show walking, not
for a capture whose whole caption is "walk". Questions with alternatives, exclusions, counts or
durations are not captions and are not compared either.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.language.question.known import KnownQuestion
from motiondb.language.question.readings import Reading, readings
from motiondb.language.question.tree import NotUsed
from motiondb.meaning import by_question
from motiondb.meaning.bounds import SLACK, upper_bounds
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.by_words import WINDOW_MARGIN
from motiondb.meaning.word_map import usual
from motiondb.records import FloatArray
from motiondb.search import reasons
from motiondb.search.asked_words import AskedWords
from motiondb.search.chances import Chances, chances, counts_or_lasts
from motiondb.search.reasons import WordReason

CAPTION_WEIGHT = 10.0
"""Nats for a likeness of 1. Chosen among 10, 20 and 40 by leaving performers out of the CMU
training parts (``docs/measured/quality.md``, "Whole captions to motion")."""
NOT_A_CAPTION = NotUsed(
    "quotation marks",
    "alternatives, exclusions, counts and durations are not compared as a caption",
)  # The note for a question in quotation marks that cannot be compared as a caption


@dataclass(frozen=True, eq=False)
class Found:
    """One capture's answer: its interval, its reasons and its certainty."""

    capture: int
    hit: QuestionHit
    why: tuple[reasons.WordReason, ...]
    sure: Chances


def find(
    asked: AskedWords,
    question: KnownQuestion,
    allowed: Sequence[int],
    limit: int,
    written: bool = True,
    as_caption: bool = False,
) -> tuple[list[Found], tuple[Reading, ...], tuple[NotUsed, ...]]:
    """The best answers, best first; the readings of the question, and its unused parts.

    `written`: Whether the captions of the captures count as evidence, in addition to the motion.
    """
    read, not_used = readings(question.tree)
    number = asked.numbers
    takes = asked.takes if written else asked.seen_takes
    shares = caption_shares(asked, read) if as_caption else CaptionShares((), {})
    extremes = asked.extremes(written)
    bounds = dict(zip(extremes.captures.tolist(), upper_bounds(extremes, read, number).tolist()))
    likeliest = likeliest_takes(
        {capture: bounds[capture] + shares.total(capture) for capture in allowed},
        lambda capture: by_question.search_take(takes[capture], read, number),
        shares.total,
        limit,
    )
    answers = []
    for capture, hit in likeliest:
        why = explain_hit(asked, capture, hit, written)
        sure = chances(asked, read, hit, why)
        answers.append(Found(capture, hit, with_shares(why, shares, capture), sure))
    answers.sort(key=lambda each: (-reasons.total(each.why), each.capture))
    if as_caption and not shares.words:
        not_used = (*not_used, NOT_A_CAPTION)
    return answers, read, not_used


def likeliest_takes(
    bounds: Mapping[int, float],
    search: Callable[[int], QuestionHit | None],
    added: Callable[[int], float],
    limit: int,
) -> list[tuple[int, QuestionHit]]:
    """The captures with the largest log-odds, best first; of equal ones, the lowest numbers."""
    best: list[tuple[float, int, QuestionHit]] = []  # a heap, the worst first
    for capture in sorted(bounds, key=lambda capture: -bounds[capture]):
        if len(best) >= limit and (not best or bounds[capture] + SLACK < best[0][0]):
            break
        hit = search(capture)
        if hit is None:
            continue
        heapq.heappush(best, (hit.log_odds + added(capture), -capture, hit))
        if len(best) > limit:
            heapq.heappop(best)
    return [(-number, hit) for _, number, hit in sorted(best, key=lambda b: (-b[0], -b[1]))]


def explain_hit(
    asked: AskedWords, capture: int, hit: QuestionHit, written: bool = True
) -> tuple[reasons.WordReason, ...]:
    """The contribution of every word of a question to an answer, segment by segment."""
    learned = asked.learned
    rows, table = learned.rows[capture], learned.segments
    starts, ends = table.starts[rows], table.ends[rows]
    said = asked.written(capture) if written else None
    n_asked = sum(statement.exclusion < 0 for statement in hit.statements)
    why = []
    for number, statement in enumerate(hit.statements):
        frames = [frame for frame, _ in statement.places]
        peaks = np.searchsorted(starts, frames, side="right") - 1
        look = reasons.Look(
            tuple((int(starts[p]) - WINDOW_MARGIN, int(ends[p]) + WINDOW_MARGIN) for p in peaks),
            tuple(int(p) for p in peaks),
            tuple(weight for _, weight in statement.places),
            statement.near,
        )
        share = 1.0 if statement.exclusion >= 0 else 1.0 / n_asked
        for word in statement.words:
            slope, constant = asked.word_map.linear(word)
            evidence = reasons.Evidence(
                constant,
                slope,
                learned.standardised[rows],
                starts,
                ends,
                table.symbols[rows],
                np.zeros(len(starts)) if said is None else said[:, word],
            )
            place = reasons.WordPlace(number, share / len(statement.words), statement.exclusion)
            why.append(reasons.explain_look(evidence, word, look, place))
    return tuple(why)


def strength(
    asked: AskedWords, why: Sequence[reasons.WordReason], threshold: float | None
) -> float:
    """Nats by which the least certain action of an answer is more probable than usual.

    For an excluded action, the distance to the threshold changes its sign: a motion without the
    action matches if the action itself would not.
    """
    usual_odds = usual(asked.word_map)

    def usually(words: Sequence[reasons.WordReason]) -> float:
        return float(np.mean([usual_odds[w.word] for w in words]))

    requested = [w for w in why if w.exclusion < 0]
    numbers = sorted({w.action for w in requested})
    levels = [usually([w for w in requested if w.action == number]) for number in numbers]
    clear = [odds - level for (odds, _), level in zip(reasons.by_action(why), levels)]
    if threshold is None:
        return min(clear, default=0.0)
    for lowering in reasons.lowerings(why):
        same_exclusion = [w for w in why if w.exclusion == lowering.exclusion]
        numbers = sorted({w.action for w in same_exclusion})
        over = min(
            odds - usually([w for w in same_exclusion if w.action == number])
            for number, (odds, _) in zip(numbers, lowering.actions)
        )
        clear.append(2.0 * threshold - over)
    return min(clear, default=0.0)


@dataclass(frozen=True, eq=False)
class CaptionShares:
    """The contribution of each word of a question to each capture."""

    words: tuple[int, ...]  # Numbers of the words
    amounts: Mapping[int, FloatArray]  # Capture number -> array (words,), nats

    def total(self, capture: int) -> float:
        """The contribution of the question to a capture."""
        return float(self.amounts[capture].sum()) if self.words else 0.0


def caption_shares(asked: AskedWords, readings: Sequence[Reading]) -> CaptionShares:
    """The contributions of a question as a whole caption; no words if it is not one."""
    words, learned = _caption_words(asked, readings), asked.learned
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


def _caption_words(asked: AskedWords, readings: Sequence[Reading]) -> tuple[int, ...]:
    """Numbers of the different words of the only reading; empty if the question is not a caption.

    Words that were not learned have numbers after the learned ones and are left out.
    """
    if len(readings) != 1 or readings[0].exclusions or counts_or_lasts(readings[0]):
        return ()
    said = [word for part in readings[0].parts for action in part.actions for word in action]
    captions = asked.learned.caption_map
    n_words = 0 if captions is None else len(captions.rarity)
    numbers = dict.fromkeys(asked.numbers[word] for word in said)
    return tuple(number for number in numbers if number < n_words)
