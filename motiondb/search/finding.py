"""The best answers to a question in words, each with its interval, reasons and certainty."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.question.readings import Reading
from motiondb.meaning import by_question
from motiondb.meaning.by_question import QuestionHit
from motiondb.meaning.word_evidence import SLACK, WINDOW_MARGIN, upper_bounds
from motiondb.search import placing, reasons
from motiondb.search.asked_words import AskedWords
from motiondb.search.chances import Chances, chances, question_certainty


@dataclass(frozen=True, eq=False)
class Found:
    """One capture's answer: its interval, its reasons and its certainty."""

    capture: int
    hit: QuestionHit
    why: tuple[reasons.WordReason, ...]
    sure: Chances
    placed: placing.Placed | None = None  # Its places, once they are known


def find(
    asked: AskedWords,
    read: Sequence[Reading],
    allowed: Sequence[int],
    limit: int,
    written: bool,
    verbs: Collection[str],
) -> list[Found]:
    """The best answers to the readings of a question, best first.

    `written`: Whether the captions of the captures count as evidence, in addition to the motion.
    `verbs`: The words of the question that are verbs.
    """
    number = asked.numbers
    certainty = question_certainty(asked, read)
    evidence = asked.evidence
    takes = evidence.takes if written else evidence.seen
    extremes = evidence.extremes if written else evidence.seen_extremes
    bounds = dict(zip(extremes.captures.tolist(), upper_bounds(extremes, read, number).tolist()))
    likeliest = likeliest_takes(
        {capture: bounds[capture] for capture in allowed if capture in takes},
        lambda capture: by_question.search_take(takes[capture], read, number, verbs),
        limit,
    )
    answers = []
    for capture, hit in likeliest:
        why = explain_hit(asked, capture, hit, written)
        sure = chances(certainty, read, hit, why)
        answers.append(Found(capture, hit, why, sure))
    answers.sort(key=lambda each: (-reasons.total(each.why), each.capture))
    return answers


def likeliest_takes(
    bounds: Mapping[int, float],
    search: Callable[[int], QuestionHit | None],
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
        heapq.heappush(best, (hit.log_odds, -capture, hit))
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
    said = asked.evidence.written.get(capture) if written else None
    alike = asked.likeness[learned.places_in_rows[capture]]
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
                learned.segment_rows[rows],
                starts,
                ends,
                table.symbols[rows],
                np.zeros(len(starts)) if said is None else said[:, word],
                float(alike[word]),
            )
            place = reasons.WordPlace(number, share / len(statement.words), statement.exclusion)
            why.append(reasons.explain_look(evidence, word, look, place))
    return tuple(why)
