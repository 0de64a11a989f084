"""Questions in words: looked for in every capture, answers decomposed and weighed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.learning.answers.placing import counts_or_lasts
from motiondb.learning.learned import Learned
from motiondb.search import certainty
from motiondb.search.questions import by_question, reasons
from motiondb.search.questions.by_question import QuestionHit
from motiondb.search.questions.by_words import WINDOW_MARGIN
from motiondb.words.question.known import KnownQuestion
from motiondb.words.question.readings import Reading, readings
from motiondb.words.question.tree import AnyOf, Node, NotUsed, walk


@dataclass(frozen=True, eq=False)
class Found:
    """One capture's answer: where, why, and the calibrated probability (None: not known)."""

    capture: int
    hit: QuestionHit
    why: tuple[reasons.WordReason, ...]
    probability: float | None


def find(
    learned: Learned,
    question: KnownQuestion,
    allowed: Sequence[int],
    limit: int,
    written: bool = True,
) -> tuple[list[Found], tuple[Reading, ...], tuple[NotUsed, ...]]:
    """The best answers, best first; the readings of the question, and what a search cannot tell.

    Parameters
    ----------
    allowed : sequence of int
        Captures to look through.
    limit : int
        How many answers at most.
    written : bool
        Whether people's words about the captures count beside the motion.
    """
    read, not_used = readings(question.tree)
    number = learned.word_numbers
    takes = learned.takes if written else learned.seen_takes
    hits = []
    for capture in allowed:
        hit = by_question.search_take(takes[capture], read, number)
        if hit is not None:
            hits.append((capture, hit))
    hits.sort(key=lambda pair: (-pair[1].log_odds, pair[0]))
    found = []
    for capture, hit in hits[:limit]:
        why = explain_hit(learned, capture, hit, written)
        sure = (
            chance(learned, why) if is_calibrated(question.tree, hit, read[hit.reading]) else None
        )
        found.append(Found(capture, hit, why, sure))
    found.sort(key=lambda each: (-reasons.total(each.why), each.capture))
    return found, read, not_used


def is_calibrated(tree: Node, hit: QuestionHit, reading: Reading) -> bool:
    """Whether the probability of an answer to such a question was found to be calibrated.

    It was for actions asked for, in order or at once, and for exclusions alone. It was not for
    alternatives, nor for one action without another: on captures of unseen performers their
    expected calibration errors were .12 and .27 (``docs/quality.md``). For repeats and lengths it
    was never measured.
    """
    if any(isinstance(node, AnyOf) for node in walk(tree)):
        return False
    if counts_or_lasts(reading):
        return False
    return len({statement.exclusion >= 0 for statement in hit.statements}) == 1


def explain_hit(
    learned: Learned, capture: int, hit: QuestionHit, written: bool = True
) -> tuple[reasons.WordReason, ...]:
    """What every word of a question adds to an answer, segment by segment."""
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
                constant, slope, learned.standardised[rows], starts, ends, table.symbols[rows],
                np.zeros(len(starts)) if said is None else said[:, word],
            )  # fmt: skip
            place = reasons.Place(number, share / len(statement.words), statement.exclusion)
            why.append(reasons.explain_look(evidence, word, look, place))
    return tuple(why)


def chance(learned: Learned, why: Sequence[reasons.WordReason]) -> float | None:
    """Calibrated probability of an answer (``certainty.answer_probability``); None: not learned."""
    sure = learned.word_certainty
    if sure is None:
        return None
    excluded = [lowering.actions for lowering in reasons.lowerings(why)]
    return certainty.answer_probability(sure, reasons.by_action(why), excluded)


def strength(learned: Learned, why: Sequence[reasons.WordReason], threshold: float | None) -> float:
    """Nats by which what an answer shows least clearly is likelier than usual.

    An excluded action counts as far below the threshold as it lies above it: something without the
    action matches where the action itself would not.
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
        own = [w for w in why if w.exclusion == lowering.exclusion]
        numbers = sorted({w.action for w in own})
        over = min(
            odds - usually([w for w in own if w.action == number])
            for number, (odds, _) in zip(numbers, lowering.actions)
        )
        clear.append(2.0 * threshold - over)
    return min(clear, default=0.0)
