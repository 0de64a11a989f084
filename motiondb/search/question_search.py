"""Search for a question in words: the best interval of every capture, reasons, certainty."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.question.known import KnownQuestion
from motiondb.language.question.readings import Reading, readings
from motiondb.language.question.tree import NotUsed
from motiondb.learn.learned import Learned
from motiondb.meaning import by_question
from motiondb.meaning import calibration as certainty
from motiondb.meaning.bounds import SLACK, upper_bounds
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.by_words import WINDOW_MARGIN
from motiondb.search import reasons
from motiondb.search.answer_chances import Chances, chances
from motiondb.search.whole_captions import CaptionShares, caption_shares, with_shares

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
    learned: Learned,
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
    number = learned.word_numbers
    takes = learned.takes if written else learned.seen_takes
    shares = caption_shares(learned, read) if as_caption else CaptionShares((), {})
    extremes = learned.take_extremes if written else learned.seen_extremes
    bounds = dict(zip(extremes.captures.tolist(), upper_bounds(extremes, read, number).tolist()))
    likeliest = likeliest_takes(
        {capture: bounds[capture] + shares.total(capture) for capture in allowed},
        lambda capture: by_question.search_take(takes[capture], read, number),
        shares.total,
        limit,
    )
    answers = []
    for capture, hit in likeliest:
        why = explain_hit(learned, capture, hit, written)
        sure = chances(learned, read, hit, why)
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
    learned: Learned, capture: int, hit: QuestionHit, written: bool = True
) -> tuple[reasons.WordReason, ...]:
    """The contribution of every word of a question to an answer, segment by segment."""
    rows = learned.rows[capture]
    table = learned.segments
    starts, ends = table.starts[rows], table.ends[rows]
    said = learned.written.get(capture) if written else None
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
            slope, constant = learned.word_map.linear(word)
            evidence = reasons.Evidence(
                constant,
                slope,
                learned.standardised[rows],
                starts,
                ends,
                table.symbols[rows],
                np.zeros(len(starts)) if said is None else said[:, word],
            )
            place = reasons.Place(number, share / len(statement.words), statement.exclusion)
            why.append(reasons.explain_look(evidence, word, look, place))
    return tuple(why)


def strength(learned: Learned, why: Sequence[reasons.WordReason], threshold: float | None) -> float:
    """Nats by which the least certain action of an answer is more probable than usual.

    For an excluded action, the distance to the threshold changes its sign: a motion without the
    action matches if the action itself would not.
    """
    usual = certainty.usual(learned.word_map)

    def usually(words: Sequence[reasons.WordReason]) -> float:
        return float(np.mean([usual[w.word] for w in words]))

    asked = [w for w in why if w.exclusion < 0]
    numbers = sorted({w.action for w in asked})
    levels = [usually([w for w in asked if w.action == number]) for number in numbers]
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
