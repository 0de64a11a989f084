"""Search by a whole question within a capture: exclusions, alternatives, repeats, lengths."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_takes import WALK_TURN_SIT, all_of, take

from motiondb.language.question.parse import parse
from motiondb.language.question.readings import readings
from motiondb.meaning import by_question, word_evidence
from motiondb.records import FloatArray
from motiondb.search import reasons

NUMBER = {"walk": 0, "turn": 1, "sit": 2}


def search(scores: word_evidence.TakeScores, text: str) -> by_question.QuestionHit:
    hit = by_question.search_take(scores, readings(parse(text).tree)[0], NUMBER)
    assert hit is not None
    return hit


def test_exclusion_lowers_by_hand() -> None:
    plain, without = search(WALK_TURN_SIT, "walk"), search(WALK_TURN_SIT, "walk, not sit")
    assert plain.log_odds == pytest.approx(0.5 * 4 + 0.5 * 2)
    assert without.parts == plain.parts == ((0, 30),)
    sits = 0.5 * -4 + 0.5 * 3  # within the walk, and in the whole capture
    assert without.log_odds == pytest.approx(all_of(3.0, -sits))
    assert [s.log_odds for s in without.statements] == [3.0, sits]


def test_exclusion_moves_the_answer_to_where_it_holds() -> None:
    both = take([[4.0, 4, 0], [4, 4, 0], [3, -4, 0], [3, -4, 0]])
    assert search(both, "walk").parts == ((0, 20),)
    hit = search(both, "walk without turning")
    assert hit.parts == ((20, 40),)
    assert hit.log_odds == pytest.approx(all_of(1.5, 2.0))


def test_what_is_asked_elsewhere_is_excluded_from_its_part_alone() -> None:
    hit = search(WALK_TURN_SIT, "walk without sitting, then sit")
    excluded = next(s for s in hit.statements if s.exclusion == 0)
    assert (excluded.near, excluded.log_odds) == (1.0, -4.0)
    assert hit.parts == ((0, 30), (40, 60))


def test_exclusion_from_all_parts_looks_between_them_too() -> None:
    hit = search(WALK_TURN_SIT, "walk, then sit, not turn")
    excluded = next(s for s in hit.statements if s.exclusion == 0)
    assert excluded.places == ((30, 1.0),)  # the turn between the walk and the sitting
    assert excluded.log_odds == pytest.approx(0.5 * 4 + 0.5 * 1)


def test_an_exclusion_alone_is_found_where_the_action_is_least() -> None:
    hit = search(WALK_TURN_SIT, "not walking")
    assert (hit.start, hit.end) == (30, 60)
    assert hit.log_odds == pytest.approx(-(0.5 * -4 + 0.5 * 2))


def test_several_actions_are_excluded_only_together() -> None:
    hit = search(WALK_TURN_SIT, "walk, not (turn while sit)")
    each = [s.log_odds for s in hit.statements if s.exclusion == 0]
    assert each == [-1.5, -0.5]
    assert hit.log_odds == pytest.approx(all_of(3.0, -all_of(*each)))


def test_the_likeliest_alternative_counts_and_is_named() -> None:
    hit = search(WALK_TURN_SIT, "turn or walk or sit")
    assert (hit.reading, hit.parts) == (2, ((40, 60),))
    assert hit.log_odds == search(WALK_TURN_SIT, "sit").log_odds
    assert search(WALK_TURN_SIT, "walk and turn").parts == ((0, 30), (30, 40))
    at_once = take([[2.0, -4, 0], [3, 3, 0], [-4, -4, 0]])
    assert search(at_once, "walk and turn").parts == ((10, 20),)


def test_actions_at_once_share_an_interval() -> None:
    scores = take([[4.0, -4, 0], [3, 2, 0], [-4, 4, 0]])
    hit = search(scores, "walk while turning")
    assert hit.parts == ((10, 20),)
    assert hit.log_odds == pytest.approx(all_of(1.5, 1.0))


def test_repeats_are_apart_and_as_sure_as_the_weakest() -> None:
    scores = take([[5.0, 0, 0], [4, 0, 0], [-4, 0, 0], [3, 0, 0], [-4, 0, 0]], (1.0, 0, 0))
    hit = search(scores, "walk twice")
    assert hit.parts == ((0, 20), (30, 40))
    assert hit.log_odds == pytest.approx(0.5 * 3 + 0.5 * 1)
    three = readings(parse("walk three times").tree)[0]
    assert by_question.search_take(scores, three, NUMBER) is None
    one = take([[5.0, 0, 0]])
    assert by_question.search_take(one, readings(parse("walk twice").tree)[0], NUMBER) is None


def test_what_lasts_is_judged_over_its_whole_length() -> None:
    scores = take([[5.0, 0, 0], [-2, 0, 0], [2, 0, 0], [2, 0, 0], [2, 0, 0], [-6, 0, 0]])
    assert search(scores, "walk").parts[0][0] == 0
    hit = search(scores, "walk for 1 s")
    assert hit.parts == ((20, 50),)
    assert hit.log_odds == pytest.approx(0.5 * 2.0)
    long = readings(parse("walk for 3 s").tree)[0]
    assert by_question.search_take(scores, long, NUMBER) is None
    assert search(scores, "? for 1 s, walk").parts == ((0, 30), (30, 50))


def plain_order(
    scores: word_evidence.TakeScores, actions: list[list[int]]
) -> tuple[tuple[tuple[int, int], ...], float] | None:
    """Frames and log-odds of actions in order, one segment each: all choices are tried."""
    scores = by_question.split_segments(scores, len(actions))
    silent = np.zeros(len(scores.starts))
    values = np.stack([scores.windows[:, a].mean(axis=1) if a else silent for a in actions])
    picks = combinations(range(len(silent)), len(actions))
    best = max(picks, key=lambda pick: sum(values[k, i] for k, i in enumerate(pick)), default=None)
    if best is None:
        return None
    parts = by_question.place_parts(values, [(i, i + 1) for i in best], [bool(a) for a in actions])
    odds = [
        0.5 * values[k, a:b].max() + 0.5 * scores.whole[actions[k]].mean()
        for k, (a, b) in enumerate(parts)
        if actions[k]
    ]
    frames = tuple((int(scores.starts[a]), int(scores.ends[b - 1])) for a, b in parts)
    return frames, word_evidence.joint_log_odds(odds)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([
    "walk", "walk, turn", "turn, walk, sit", "walk, ?, sit", "?, turn", "turn, ?, ?",
]))  # fmt: skip
def test_plain_orders_are_found_as_by_trying_all(seed: int, text: str) -> None:
    rng = np.random.default_rng(seed)
    scores = take(
        rng.normal(0, 3, (int(rng.integers(1, 9)), 3)).tolist(), tuple(rng.normal(size=3))
    )
    actions = [[NUMBER[w] for w in (piece.split() if piece != "?" else [])]
               for piece in text.split(", ")]  # fmt: skip
    expected = plain_order(scores, actions)
    hit = by_question.search_take(scores, readings(parse(text).tree)[0], NUMBER)
    assert (expected is None) == (hit is None)
    if expected is not None and hit is not None:
        assert hit.parts == expected[0]
        assert hit.log_odds == pytest.approx(expected[1], rel=1e-12)
        assert by_question.search_order(scores, actions) == hit


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([
    "walk, not turn", "walk while turning, not sit", "not walk, not turn", "walk or turn, not sit",
    "walk twice, not sit", "walk for 1 s, then turn", "walk without turning, then turn or sit",
    "walk, not (turn while sit)",
]))  # fmt: skip
def test_statements_make_the_log_odds_and_parts_do_not_overlap(seed: int, text: str) -> None:
    rng = np.random.default_rng(seed)
    scores = take(
        rng.normal(0, 3, (int(rng.integers(3, 12)), 3)).tolist(), tuple(rng.normal(size=3))
    )
    hit = by_question.search_take(scores, readings(parse(text).tree)[0], NUMBER)
    if hit is None:
        return
    asked, excluded = by_question.split_statements(hit.statements)
    assert hit.log_odds == pytest.approx(all_of(*asked, *(-e for e in excluded)), abs=1e-9)
    if asked:
        assert hit.log_odds <= word_evidence.joint_log_odds(asked) + 1e-12
    assert all(a < b for a, b in hit.parts)
    assert all(one[1] <= other[0] for one, other in pairwise(hit.parts))


def every_run(
    values: FloatArray, frames: FloatArray, seconds: FloatArray, apart: list[bool]
) -> float:
    """Largest total by trying all runs that are no longer than they must be."""
    n = values.shape[1]
    spans = []
    for k in range(len(values)):
        runs_of_part = []
        for a, b in combinations(range(n + 1), 2):
            needed = seconds[k] * 30.0
            if (b == a + 1 or frames[a : b - 1].sum() < needed) and frames[a:b].sum() >= needed:
                mean = float(np.average(values[k, a:b], weights=frames[a:b]))
                runs_of_part.append((a, b, mean))
        spans.append(runs_of_part)
    best = -math.inf
    for choice in product(*spans):
        ordered = all(one[1] <= other[0] for one, other in pairwise(choice))
        gapped = all(
            not apart[k] or by_question.gaps(values[k])[choice[k - 1][1] : choice[k][0]].any()
            for k in range(1, len(choice))
        )
        if ordered and gapped:
            best = max(best, sum(mean for _, _, mean in choice))
    return best


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10_000))
def test_runs_are_the_best_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_parts, n = int(rng.integers(1, 4)), int(rng.integers(1, 8))
    values = rng.normal(0, 3, (n_parts, n))
    frames = rng.integers(5, 40, n)
    ends = np.cumsum(frames)
    seconds = rng.choice([0.0, 0.5, 1.5], n_parts)
    apart = [k > 0 and bool(rng.random() < 0.4) for k in range(n_parts)]
    actual = by_question.ordered_runs(values, ends - frames, ends, seconds, apart)
    best = every_run(values, frames.astype(float), seconds, apart)
    if actual is None:
        assert best == -math.inf
        return
    total = sum(float(np.average(values[k, a:b], weights=frames[a:b]))
                for k, (a, b) in enumerate(actual))  # fmt: skip
    assert total == pytest.approx(best)
    assert all(one[1] <= other[0] for one, other in pairwise(actual))


def word_reason(word: int, action: int, parts: list[float], exclusion: int) -> reasons.WordReason:
    shares = tuple(reasons.SymbolShare(0, n, n + 1.0, part) for n, part in enumerate(parts[2:]))
    return reasons.WordReason(word, action, sum(parts), parts[0], parts[1], shares, exclusion)


@given(st.lists(st.lists(st.floats(-3, 3), min_size=2, max_size=5), min_size=1, max_size=4),
       st.integers(0, 3))  # fmt: skip
def test_lowerings_sum_exactly_to_the_total(parts: list[list[float]], n_asked: int) -> None:
    n_asked = min(n_asked, len(parts))
    why = [
        replace(
            word_reason(n, n, [p / n_asked for p in each] if n < n_asked else each,
                        -1 if n < n_asked else n - n_asked),
            log_odds=math.fsum(each),
        )
        for n, each in enumerate(parts)
    ]  # fmt: skip
    lowered = reasons.lowerings(why)
    pieces = [*reasons.asked_parts(why), reasons.together(why), *(one.amount for one in lowered)]
    assert reasons.total(why) == math.fsum(pieces)
    statements = [math.fsum(each) for each in parts[:n_asked]]
    statements += [-math.fsum(each) for each in parts[n_asked:]]
    assert reasons.total(why) == pytest.approx(word_evidence.joint_log_odds(statements), abs=1e-8)
    for one in lowered[0 if n_asked else 1 :]:
        assert one.amount <= 1e-12
