"""Whether anything in a database matches a question in words.

Every action of a question has a *strength*: nats by which it is more probable than usual for its
words. Below a threshold, which was learned from questions without a right answer
(:mod:`motiondb.meaning.regression`), nothing matches. Above it, but with a probability below one
half by each of the first answers, as a whole or for some part, it is doubtful whether anything
does.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from motiondb.meaning.word_map import usual
from motiondb.records import Match
from motiondb.search import placing, reasons
from motiondb.search.asked_words import AskedWords
from motiondb.search.chances import Chances

if TYPE_CHECKING:
    from motiondb.search.finding import Found


NOTHING = "nothing in this database matches"


def reaches(
    matches: Sequence[Match], strength: float | None, threshold: float | None
) -> bool | None:
    """Whether a best match is good enough; None if no threshold was learned."""
    if not matches:
        return False
    return None if strength is None or threshold is None else strength >= threshold


def best_strength(
    asked: AskedWords, found: Sequence[Found], threshold: float | None
) -> float | None:
    """Nats by which the least certain part of a question is more probable than usual.

    Of every part, the answer counts that shows it best: an order of which every part is shown, but
    by different captures, is not called absent. With exclusions, the best answer as a whole counts.
    None if there are no answers.
    """
    best: dict[int, dict[int, float]] = {}
    for each in found:
        parts = [statement.part for statement in each.hit.statements]
        of_reading = best.setdefault(each.hit.reading, {})
        whole = any(statement.exclusion >= 0 for statement in each.hit.statements)
        for part in [-1] if whole else dict.fromkeys(parts):
            actions = [n for n, of in enumerate(parts) if whole or of == part]
            clear = strength(asked, each.why, threshold, actions)
            of_reading[part] = max(clear, of_reading.get(part, clear))
    return max((min(parts.values()) for parts in best.values() if parts), default=None)


def is_doubtful(found: Sequence[Chances]) -> bool:
    """Whether each answer is more likely wrong than right, or some part not shown by any."""
    wholes = [chances.whole for chances in found if chances.whole is not None]
    if wholes and max(wholes) < placing.LIKELY:
        return True
    known = [[p and p.probability for p in chances.parts] for chances in found]
    same = [parts for parts in known if len(parts) == len(known[0])]
    best = [max((p for p in of if p is not None), default=1.0) for of in zip(*same)]
    return any(p < placing.LIKELY for p in best)


def strength(
    asked: AskedWords,
    why: Sequence[reasons.WordReason],
    threshold: float | None,
    actions: Collection[int],
) -> float:
    """Nats by which the least certain of some actions of an answer is more probable than usual.

    For an excluded action, the distance to the threshold changes its sign: a motion without the
    action matches if the action itself would not.
    """
    usual_odds = usual(asked.word_map)

    def usually(words: Sequence[reasons.WordReason]) -> float:
        return float(np.mean([usual_odds[w.word] for w in words]))

    requested = [w for w in why if w.exclusion < 0]
    numbers = sorted({w.action for w in requested})
    clear = [
        odds - usually([w for w in requested if w.action == number])
        for number, (odds, _) in zip(numbers, reasons.by_action(why))
        if number in actions
    ]
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
