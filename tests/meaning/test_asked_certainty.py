"""How sure answers are: learned from captions, kept with the run, said by search and like."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.learn.learned import Learned
from motiondb.meaning import asked_certainty
from motiondb.meaning.asked_certainty import fit_certainties
from motiondb.meaning.regression import Certainties
from motiondb.meaning.word_map import solve_word_map, word_moments
from motiondb.records import SegmentTable


def made_up(seed: int, n_groups: int = 6, per_group: int = 8) -> asked_certainty.Written:
    """Captures of one segment whose vectors lean towards the action said of them."""
    rng = np.random.default_rng(seed)
    n = n_groups * per_group
    action = np.arange(n) % 4
    vectors = np.eye(4)[action] + rng.normal(0, 0.35, (n, 4))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    numbers, zeros = np.arange(n), np.zeros(n)
    table = SegmentTable(
        numbers, zeros.astype(int), np.full(n, 60), action, zeros, zeros,
        vectors.astype(np.float32), np.zeros((n, 0), np.float32),
    )  # fmt: skip
    return asked_certainty.Written(
        vectors, np.eye(4, dtype=bool)[action], ("kick", "run", "sit", "left"), numbers, zeros,
        np.full(n, 60.0), np.repeat(np.arange(n_groups), per_group), table, vectors, 0.3,
        np.array([4.0, 1.0, 0.0]),
    )  # fmt: skip


@pytest.mark.parametrize(
    "fit", [asked_certainty.words_certainty, asked_certainty.example_certainty]
)
def test_clear_answers_are_likelier_and_a_threshold_lies_between(fit) -> None:
    actual = fit(made_up(1))
    assert actual is not None
    assert actual.weights[0] > 0.0
    assert np.isfinite(actual.threshold)
    again = fit(made_up(1))
    assert again.log_odds(np.ones(len(again.weights))) == actual.log_odds(
        np.ones(len(actual.weights))
    )


@pytest.mark.parametrize("left_out", [1, 6])
def test_left_out_is_as_if_never_written(left_out: int) -> None:
    """Few rows left are solved row by row, many by their sums."""
    written = made_up(2, per_group=2) if left_out == 6 else made_up(2)
    some = written.groups < left_out if left_out == 1 else written.groups > 0
    whole = written.without(some)
    rest = asked_certainty.Written(
        written.vectors[~some], written.presence[~some], written.names, written.captures[~some],
        written.starts[~some], written.ends[~some], written.groups[~some], written.table,
        written.standardised, written.ridge, written.calibration,
    )  # fmt: skip
    alone = rest.without(np.zeros(int((~some).sum()), dtype=bool))
    summed = solve_word_map(word_moments(rest.vectors, rest.presence), rest.ridge, rest.calibration)
    np.testing.assert_allclose(whole.weights, summed.weights, atol=1e-4)
    np.testing.assert_allclose(whole.weights, alone.weights)
    np.testing.assert_allclose(whole.priors, alone.priors)


def two_parts() -> asked_certainty.Written:
    """Two performers; the second one's capture of two segments runs, then kicks."""
    kick, run = [1.0, 0.0], [0.0, 1.0]
    numbers, zeros = np.array([1, 2, 2]), np.zeros(3)
    starts, ends = np.array([0, 0, 60]), np.array([60, 60, 120])
    rows = np.array([kick, run, kick])
    table = SegmentTable(
        numbers, starts, ends, np.array([0, 1, 0]), zeros, zeros, rows.astype(np.float32),
        np.zeros((3, 0), np.float32),
    )  # fmt: skip
    return asked_certainty.Written(
        rows, rows.astype(bool), ("kick", "run"), numbers, starts.astype(float),
        ends.astype(float), np.array([0, 1, 1]), table, rows, 0.3, np.array([4.0, 1.0, 0.0]),
    )  # fmt: skip


def test_a_part_that_shows_the_action_leaves_with_its_capture() -> None:
    written = two_parts()
    others, kicks = written.groups == 1, written.presence[:, 0]
    gallery = asked_certainty.find_windows(written, 0, others, kicks)
    assert gallery.right.tolist() == [True]
    assert gallery.shows.tolist() == [True]  # though one of its parts only runs
    np.testing.assert_allclose(gallery.vectors, [[1.0, 0.0]])
    running = asked_certainty.find_windows(written, 0, others, written.presence[:, 1])
    assert running.right.tolist() == [False]  # the window most alike kicks
    assert running.shows.tolist() == [True]


def test_directions_are_no_actions() -> None:
    assert made_up(0).is_action.tolist() == [True, True, True, False]


def test_one_performer_or_too_few_answers_tell_nothing() -> None:
    assert fit_certainties(made_up(3, n_groups=1)) == Certainties()
    assert asked_certainty.words_certainty(made_up(3, n_groups=2, per_group=4)) is None
    assert asked_certainty.example_certainty(made_up(3, n_groups=2, per_group=2)) is None


def test_answers_say_how_sure_they_are(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        assert db.learned.certainties.words is not None
        assert db.learned.certainties.example is not None
        kicks = db.search("kick")
        assert kicks.matches_anything is True
        chances = [m.probability for m in kicks.matches]
        assert all(p is not None and 0.0 <= p <= 1.0 for p in chances)
        assert chances == sorted(chances, reverse=True)
        nowhere = db.search("kick", where='name="ana/bow_1"')
        assert nowhere.matches_anything is False
        assert [m.capture for m in nowhere.matches] == ["ana/bow_1"]
        assert db.search("kick", where="performer=nobody").matches_anything is False
        assert db.search("kick", by_symbols=True).matches_anything is None


def test_an_action_that_is_nowhere_beside_one_that_is(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        where = 'name="ana/bow_1"'
        assert db.search("bow", where=where).matches_anything is True
        assert db.search("bow, kick", where=where).matches_anything is False


def test_an_example_finds_itself_for_certain_with_and_without_words(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        for meaning in (None, True, False):
            actual = db.like("boris/kick_1", limit=3, meaning=meaning)
            assert actual[0].capture == "boris/kick_1"
            assert actual[0].probability == pytest.approx(1.0, abs=0.01)
            assert actual.matches_anything is True
            assert len(actual) == len(actual[:3]) == 3
        other = db.like("boris/kick_1", where='name="ana/walk_1"')
        assert other.matches_anything is False
        assert other[0].probability < 0.5


def test_without_words_there_is_no_probability(
    learned_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Learned, "has_words", False)
    with motiondb.open(learned_file, read_only=True) as db:
        actual = db.like("boris/kick_1", limit=2)
        assert actual[0].capture == "boris/kick_1"
        assert [m.probability for m in actual] == [None, None]
        assert (actual.matches_anything, actual.strength, actual.threshold) == (None, None, None)
