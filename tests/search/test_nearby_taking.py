"""A word that no caption holds: taken, suggested, or unknown."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_nearby_table import table

from motiondb.language.question.readings import KnownQuestion
from motiondb.language.question.tree import Action
from motiondb.meaning.word_map import WordMap
from motiondb.search.asked_words import mixture, with_virtual_words
from motiondb.search.by_words import WordAnswer
from motiondb.search.takings import Sentence, Taking, near_sentence, take_word

SMALL = table(
    {
        "stroll": [("walk", 0.9), ("go", 0.4), ("step", 0.2)],
        "hurl": [("throw", 0.95), ("shoot", 0.4)],
        "tired": [("slow", 0.6)],
    },
    silent=("tax",),
)


def test_a_word_is_taken_as_all_that_is_likely_enough() -> None:
    taking = take_word("stroll", {"walk", "go", "step"}, SMALL)
    assert taking.words == (("walk", 0.9), ("go", 0.4))
    assert taking.is_taken
    assert taking.probability == 0.9
    assert taking.shares == pytest.approx((9 / 13, 4 / 13))
    assert taking.sentence() == (
        "'stroll' is not in the captions; replaced by walk (0.9) or go (0.4), a close match"
    )


def test_an_unlikely_word_is_suggested_and_not_taken() -> None:
    taking = take_word("hurl", {"shoot", "walk"}, SMALL)
    assert not taking.is_taken
    assert taking.sentence() == "'hurl' is not in the captions; left out; perhaps shoot (0.4)"


def test_nothing_is_said_of_an_english_word_without_an_answer() -> None:
    taking = take_word("tax", {"taxi", "walk"}, SMALL)
    assert (taking.words, taking.spelling, taking.is_taken) == ((), (), False)
    assert taking.sentence() == "'tax' is not in the captions; left out"


def test_spelling_is_a_hint_for_what_is_not_english() -> None:
    taking = take_word("wlak", {"walk", "jump"}, SMALL)
    assert taking.spelling == ("walk",)
    assert taking.sentence() == "'wlak' is not in the captions; left out; perhaps walk"


def test_a_form_finds_the_entry_of_its_lemma_or_its_own() -> None:
    assert take_word("Strolling", {"walk"}, SMALL).words == (("walk", 0.9),)
    assert take_word("tired", {"slow"}, SMALL).words == (("slow", 0.6),)


def test_a_known_word_of_the_same_form_is_not_called_unknown() -> None:
    """In "lay down", lay is the past of lie; captions hold another lay, "lays the ball up"."""
    words = table({"lay": [("set", 0.7)], "lie": [("sleep", 0.6)]})
    taking = take_word("lay", {"lay", "set", "sleep"}, words)
    assert taking.sentence() == (
        "'lie' is not in the captions; replaced by sleep (0.6), a close match"
    )


WORD_MAP = WordMap(
    weights=np.array([[1.0, 3.0], [0.0, -2.0]]),
    offsets=np.array([0.5, 0.0]),
    priors=np.array([0.5, 0.2]),
    spreads=np.array([1.0, 2.0]),
    calibration=np.array([2.0, 1.0, -1.0]),
)


def test_a_virtual_word_worked_by_hand() -> None:
    fitted = with_virtual_words(WORD_MAP, np.array([[0.75], [0.25]]))
    slope, constant = fitted.linear(2)
    # go: slope (2, 0), constant 1 - 1 = 0; walk: slope (3, -2), constant log(1/4) - 1
    np.testing.assert_allclose(slope, [0.75 * 2 + 0.25 * 3, 0.25 * -2])
    assert constant == pytest.approx(0.25 * (np.log(0.25) - 1.0))


@given(st.floats(0.0, 1.0), st.integers(0, 1000))
def test_log_odds_of_a_virtual_word_are_the_mean_of_its_words(share: float, seed: int) -> None:
    vectors = np.random.default_rng(seed).normal(size=(5, 2))
    fitted = with_virtual_words(WORD_MAP, np.array([[share], [1.0 - share]]))
    before, after = WORD_MAP.log_odds(vectors), fitted.log_odds(vectors)
    np.testing.assert_allclose(after[:, :2], before, atol=1e-12)
    np.testing.assert_allclose(after[:, 2], before @ [share, 1.0 - share], atol=1e-12)


def test_shares_of_a_mixture_sum_to_one() -> None:
    takings = [take_word(w, {"walk", "go", "slow"}, SMALL) for w in ("stroll", "tired")]
    shares = mixture(takings, ["go", "slow", "walk"])
    np.testing.assert_allclose(shares, [[4 / 13, 0.0], [0.0, 1.0], [9 / 13, 0.0]])


def test_a_taking_without_words_has_no_probability() -> None:
    assert Taking("tax", ()).probability == 0.0


@pytest.mark.parametrize(
    ("listed", "near"),
    [
        ([{0, 1}, {0}, {1}, {2}], "He run, then kicks"),  # "run/jog" and "jog"
        ([{0, 1}, {0}, {0}, {1}], None),  # "jog" is mostly said without "run"
        ([{1}, {2}], None),
    ],
)
def test_a_near_word_is_one_that_captions_say_with_it(
    listed: list[set[int]], near: str | None
) -> None:
    """The table alone would do for a word that no caption says."""
    words = ("jog", "run", "kick")
    learned = SimpleNamespace(
        known_words=words,
        word_numbers={word: number for number, word in enumerate(words)},
        listed_actions={n: [frozenset(action)] for n, action in enumerate(listed)},
        synonyms={},
        lemmas={},
    )
    asked = Sentence(learned, "He jogs, then kicks")
    found = near_sentence(asked, table({"jog": [("run", 0.9)]}))
    assert (found and found.text) == near


def test_the_whole_question_is_what_nothing_shows() -> None:
    """Many captures may show "jog"."""
    question = KnownQuestion("run sideways", Action(("run",)), {}, ())
    answer = WordAnswer((), question, (), near=("jog sideways", "run sideways"))
    assert answer.not_understood == (
        "probably nothing shows 'jog sideways'; these are answers for 'run sideways' in its place"
    )
