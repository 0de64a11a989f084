"""The judge of motion: what it learns, what it leaves out, and what it cannot tell."""

import numpy as np
import pytest

from motiondb.meaning.motion_judge import (
    LEAST_PAIRS,
    MOST_WINDOWS,
    PAIRS_OF_A_WORD,
    RIDGE,
    MotionJudge,
    _draw_pairs,
    fit_judge,
    judge_without,
    judging_table,
    pool_windows,
)

WALK, RUN, ODD = range(3)


def _windows(rng: np.random.Generator, word: int) -> np.ndarray:
    centre = np.zeros(6)
    centre[word] = 3.0
    return centre + rng.normal(scale=0.5, size=(3, 6))


def _captures(seed: int = 0) -> tuple[dict[int, np.ndarray], dict[int, tuple[frozenset[int], int]]]:
    """Twenty captures of walking and twenty of running, and one of another action."""
    rng = np.random.default_rng(seed)
    words = {n: (WALK if n < 20 else RUN) for n in range(40)} | {40: ODD}
    return (
        {n: _windows(rng, word) for n, word in words.items()},
        {n: (frozenset({word}), 1) for n, word in words.items()},
    )


@pytest.fixture(scope="module")
def fitted() -> tuple[MotionJudge, dict[int, tuple[frozenset[int], int]]]:
    windows, said = _captures()
    performers = {n: f"p{n % 4}" for n in windows}
    return fit_judge(windows, said, 3, performers, np.random.default_rng(0)), said


def test_windows_are_three_seconds_with_half_overlap() -> None:
    features = np.arange(90.0, dtype=np.float32)[:, None]
    rows = pool_windows(features)
    assert rows[:, 0].tolist() == [22.0, 44.0, 66.0]
    assert len(pool_windows(features[:10])) == 1


def test_a_new_motion_is_told_by_its_word(fitted) -> None:
    judge, said = fitted
    left = judge_without(judging_table(judge, said, 3), [0])
    assert left is not None
    scores = left.scores(_windows(np.random.default_rng(9), WALK))
    walk, run = left.probability(scores, WALK), left.probability(scores, RUN)
    assert walk is not None
    assert run is not None
    assert walk > 0.8 > 0.2 > run
    assert left.likeliest(scores, 2)[0][0] == WALK


def test_nothing_is_told_of_a_word_without_another_capture(fitted) -> None:
    judge, said = fitted
    left = judge_without(judging_table(judge, said, 3), [40])
    assert left is not None
    scores = left.scores(_windows(np.random.default_rng(9), ODD))
    assert left.probability(scores, ODD) is None
    assert ODD not in [word for word, _ in left.likeliest(scores, 3)]


def test_leaving_captures_out_is_fitting_without_them(fitted) -> None:
    judge, said = fitted
    out = {1, 25, 39}
    table = judging_table(judge, said, 3)
    left = judge_without(table, out)
    assert left is not None
    kept = ~np.isin(judge.captures, list(out))
    targets = np.array([[float(w in said[c][0]) for w in range(3)] for c in judge.captures])
    matrix = judge.likeness(judge.rows) + np.diag(RIDGE / judge.weights)
    slow = np.linalg.solve(matrix[np.ix_(kept, kept)], (targets - table.mean)[kept])
    np.testing.assert_allclose(left.coefficients[kept], slow, atol=1e-8)
    assert not left.coefficients[~kept].any()
    assert left.n_captures.tolist() == [19.0, 18.0, 1.0]


def test_what_is_like_nothing_is_neither_shown_nor_denied(fitted) -> None:
    judge, said = fitted
    left = judge_without(judging_table(judge, said, 3), ())
    assert left is not None
    far = judge.mean + judge.spread * np.array([[3.0, -3.0, 3.0, -3.0, 3.0, -3.0]])
    near = left.scores(_windows(np.random.default_rng(9), WALK))
    assert np.abs(left.scores(far)).max() < 0.1 * np.abs(near).max()


def test_a_judge_of_many_windows_keeps_some_of_every_capture() -> None:
    windows, said = _captures()
    windows = {capture: np.tile(rows, (4, 1)) for capture, rows in windows.items()}
    judge = fit_judge(windows, said, 3, dict.fromkeys(windows, "p"), np.random.default_rng(0))
    assert np.unique(judge.captures, return_counts=True)[1].tolist() == [MOST_WINDOWS] * 41


def test_words_of_the_same_captures_are_related() -> None:
    windows, said = _captures()
    both = {c: (words | {ODD} if WALK in words else words, 1) for c, (words, _) in said.items()}
    judge = fit_judge(windows, both, 3, dict.fromkeys(windows, "p"), np.random.default_rng(0))
    table = judging_table(judge, both, 3)
    assert table.related(WALK) == {WALK, ODD}
    assert table.related(RUN) == {RUN}


def test_too_few_captures_leave_the_judge_without_calibration() -> None:
    windows, said = _captures()
    few = {c: windows[c] for c in (0, 1, 20, 21)}
    judge = fit_judge(
        few, {c: said[c] for c in few}, 3, dict.fromkeys(few, "p"), np.random.default_rng(0)
    )
    assert judge.certainty is None
    left = judge_without(judging_table(judge, {c: said[c] for c in few}, 3), ())
    assert left is not None
    assert left.probability(left.scores(few[0]), WALK) is None


def test_the_calibration_looks_at_captures_of_one_action_where_there_are_enough() -> None:
    windows, said = _captures()
    performers = dict.fromkeys(windows, "p")
    rng = np.random.default_rng(0)
    judge = fit_judge(windows, said, 3, performers, rng)
    mixed = {c: (words, 2 if c % 2 else 1) for c, (words, _) in said.items()}
    pairs = _draw_pairs(judging_table(judge, mixed, 3), performers, np.random.default_rng(0))
    assert {first for _, first, _ in pairs} <= {c for c in mixed if mixed[c][1] == 1}
    everywhere = {c: (words, 2) for c, (words, _) in said.items()}
    pairs = _draw_pairs(judging_table(judge, everywhere, 3), performers, np.random.default_rng(0))
    assert len(pairs) >= LEAST_PAIRS


def test_no_word_has_more_pairs_than_allowed_and_no_pair_is_of_one_word() -> None:
    windows, said = _captures()
    judge = fit_judge(windows, said, 3, dict.fromkeys(windows, "p"), np.random.default_rng(0))
    table = judging_table(judge, said, 3)
    pairs = _draw_pairs(table, dict.fromkeys(windows, "p"), np.random.default_rng(1))
    counts = np.bincount([word for word, _, _ in pairs])
    assert counts.max() == PAIRS_OF_A_WORD  # 20 captures beside 3 others each are 60 pairs
    assert all(w in said[a][0] and w not in said[b][0] for w, a, b in pairs)
