"""The order of answers to a question in words, and whether any of them is likely right.

Answers are found by their log-odds. Where a question asks for an order, or for what is measured in
the motion, the first of them are ordered anew: those that are more likely right than wrong come
first, what the motion clearly shows before what it leaves open, and what it contradicts last. Order
and motion can only speak against an answer. So an answer is looked at only when its turn comes by
what is known without, and most never are.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from motiondb.search.chances import LIKELY, Found, is_unlikely, lacking_actions
from motiondb.search.placing import Placed

Rank = tuple[bool, int, bool, float, float]


@dataclass(frozen=True, eq=False)
class Judged:
    """The answers by which it is told whether anything matches, the largest log-odds first."""

    answers: Sequence[Found]
    place: Callable[[Found], Placed]  # Where a capture shows an answer; kept once it was asked for
    is_checked: bool  # Whether order or motion are looked at, and can speak against an answer
    # Whether a capture contradicts the question wherever it shows it, which needs no place
    contradicts: Callable[[Found], bool] = lambda _: False
    # The best answer to one action alone, by the numbers of its words
    alone: Callable[[tuple[int, ...]], Found | None] = lambda _: None
    sign: float = 0.0  # 1: the more of what was measured, the better; -1: the less; 0: neither

    def first(self, limit: int) -> list[Found]:
        """The first answers; as few are placed as settle which they are."""
        if not self.is_checked:
            return list(self.answers[:limit])
        # in a heap; answers of one rank stay in their order
        looks = (self._first_rank, self._seen_rank, self._placed_rank)
        waiting = [(*looks[0](each), n, 0) for n, each in enumerate(self.answers)]
        heapq.heapify(waiting)
        first = dict[int, Found]()  # By capture
        while waiting and len(first) < limit:
            *_, n, look = heapq.heappop(waiting)
            answer = self.answers[n]
            if answer.capture in first:
                continue  # of the readings of a question, the one that it shows best
            if look == 2:
                first[answer.capture] = answer
            else:  # by as little as tells it from the others
                heapq.heappush(waiting, (*looks[look + 1](answer), n, look + 1))
        return list(first.values())

    def _first_rank(self, answer: Found) -> Rank:
        """The first rank that an answer can have."""
        return False, False, False, -np.inf if self.sign else 0.0, -answer.hit.log_odds

    def _seen_rank(self, answer: Found) -> Rank:
        """The first rank that an answer can have, by its certainty and its whole take."""
        is_against = self.contradicts(answer)
        return is_against, is_against or _is_weak(answer), *self._first_rank(answer)[2:]

    def _placed_rank(self, answer: Found) -> Rank:
        """Contradicted answers last, improbable ones before them; then clear ones and the degree.

        Who jumps five times, not twice, comes before who does not jump at all.
        """
        placed = self.place(answer)
        is_more = placed.is_miscounted and not _is_weak(answer)  # more often than asked for
        weak = 2 if _is_weak(answer) else int(_is_against(placed))  # a probable one comes first
        amount = 0.0 if placed.amount is None else -self.sign * placed.amount
        is_unclear = placed.is_unclear or bool(np.isnan(amount))
        amount = 0.0 if np.isnan(amount) else amount
        is_other = bool(placed.contradicted) and not is_more
        return is_other, weak, is_unclear, amount, -answer.hit.log_odds

    def looked_at(self, answer: Found) -> Found:
        """An answer, without its probability unless order and motion agree with it.

        How often another answer is right was not measured.
        """
        if not self.is_checked:
            return answer
        if self._is_against(answer) or self.place(answer).is_unclear:
            unsure = replace(answer.sure, whole=None)
            return replace(answer, certain=lambda *_: unsure)
        return answer

    def _is_against(self, answer: Found) -> bool:
        """Whether the motion contradicts the question, or the frames show another order."""
        return self.contradicts(answer) or _is_against(self.place(answer))

    def _is_shown(self, action: int) -> bool:
        """Whether any capture shows an action of the question, by itself."""
        hit = next(each.hit for each in self.answers if len(each.sure.actions) > action)
        requested = [stated.words for stated in hit.statements if stated.exclusion < 0]
        found = self.alone(requested[action])
        return found is not None and (found.sure.whole or 0.0) >= LIKELY

    def is_unlikely(self, first: Sequence[Found], is_known: bool, replaced: float) -> bool:
        """Whether each answer is more likely wrong than right.

        `first`: The first answers, which are looked at before the others. `is_known`: Whether own
        captions have checked the words. `replaced`: As in ``chances.is_unlikely``.
        """

        def whole_of(answer: Found) -> float | None:
            whole = answer.sure.whole
            if whole is None:  # it is at most that of each of its actions
                least = min(answer.sure.actions, default=None)
                is_open = least is None or least < LIKELY or not self._is_against(answer)
                return least if is_open else None
            if is_known and whole < LIKELY:
                return whole  # what speaks against it changes nothing
            if self.is_checked and not self._is_against(answer):
                return whole  # also where the motion leaves it open
            return self.looked_at(answer).sure.whole

        return is_unlikely(map(whole_of, chain(first, self.answers)), replaced)

    def is_doubtful(self, first: Sequence[Found], is_known: bool, replaced: float) -> bool:
        """Whether probably nothing matches; parameters as in ``is_unlikely``.

        So it is if some action is shown by no answer, or each answer is wrong; if every action is
        shown by some, no answer may yet show all of them.
        """
        n_actions = (len(each.sure.actions) for each in self.answers)
        has_one = next(filter(None, n_actions), 0) < 2
        lacking = lacking_actions(each.sure.actions for each in self.answers)
        if lacking and (has_one or not all(map(self._is_shown, lacking))):
            return True
        if has_one and self.is_unlikely(first, is_known, replaced):
            return True

        def is_wrong(answer: Found) -> bool:
            if not is_known:
                return self.contradicts(answer) or bool(self.place(answer).contradicted)
            is_placed = self.is_checked or answer in first
            is_weak = has_one and _is_weak(answer)
            return is_weak or (is_placed and self._is_against(answer))

        return (is_known or self.is_checked) and all(map(is_wrong, chain(first, self.answers)))


def _is_weak(answer: Found) -> bool:
    """Whether an answer is more likely wrong than right, before its motion is looked at."""
    whole = answer.sure.whole
    return answer.hit.log_odds < 0.0 if whole is None else whole < LIKELY


def _is_against(placed: Placed) -> bool:
    """Whether the frames show another order, or contradict the question as measured."""
    return placed.in_order is False or bool(placed.contradicted)
