"""Where answers to words are, how sure that is, and when the place is told as unknown."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.learn.learned import Learned
from motiondb.learn.learned_model import from_stored, to_stored
from motiondb.meaning.regression import Certainty
from motiondb.records import Match
from motiondb.search.asking import understand_learned
from motiondb.search.by_words import search_words

QUESTIONS = ("walk", "turn left", "walk, turn left, sit down", "kick or punch", "walk but not turn")


@pytest.fixture(scope="module")
def learned(learned_file: Path) -> Learned:
    with motiondb.open(learned_file, read_only=True) as db:
        return db.learned


def with_place(learned: Learned, log_odds: float) -> Learned:
    """The same, every place as likely right as given."""
    sure = Certainty(np.zeros(8), log_odds, float("nan"))
    single = Certainty(np.zeros(6), -50.0, float("nan"))
    return replace(learned, certainties=replace(learned.certainties, place=sure, single=single))


def is_whole(learned: Learned, match: Match) -> bool:
    """Whether the one part of an answer is the whole capture."""
    (frames,) = (i.motion_frames for i in learned.captures.values() if i.name == match.capture)
    return len(match.parts) == 1 and match.start == 0.0 and match.end * 30.0 > frames - 2.5


@pytest.mark.parametrize("question", QUESTIONS)
def test_places_change_neither_ranking_nor_reasons(learned: Learned, question: str) -> None:
    allowed = list(learned.rows)
    with_places = search_words(understand_learned(learned, question), allowed, 20)
    without = search_words(understand_learned(replace(learned, places=None), question), allowed, 20)
    assert learned.places is not None
    assert with_places.reasons == without.reasons
    for one, other in zip(with_places.matches, without.matches):
        assert (one.capture, one.score, one.probability) == (
            other.capture, other.score, other.probability,
        )  # fmt: skip
        whole = is_whole(learned, other)
        assert other.interval_probability == (other.probability if whole else None)
        assert other.place == "known"


@pytest.mark.parametrize("question", QUESTIONS)
def test_parts_are_in_order_apart_and_each_has_its_probability(
    learned: Learned, question: str
) -> None:
    answer = search_words(understand_learned(learned, question), list(learned.rows), 20)
    for match in answer.matches:
        known = [part for part in match.parts if part.place == "known"]
        assert all(one.end <= other.start + 1e-9 for one, other in pairwise(known))
        assert all(0.0 <= p.interval_probability <= p.probability <= 1.0 for p in known)
        if match.place == "unknown" or match.probability is None or len(match.parts) > 1:
            assert match.interval_probability is None
        else:
            assert match.interval_probability <= match.probability


def test_of_one_action_the_interval_is_the_capture_times_the_place(learned: Learned) -> None:
    sure = with_place(learned, np.log(3.0))  # right with probability 3/4
    for match in search_words(understand_learned(sure, "walk"), list(learned.rows), 10).matches:
        right = 1.0 if is_whole(learned, match) else 0.75
        assert match.interval_probability == pytest.approx(right * match.probability)
    for match in search_words(
        understand_learned(sure, "walk, kick"), list(learned.rows), 10
    ).matches:
        assert match.interval_probability is None  # never measured for several actions
        assert match.parts[0].interval_probability == pytest.approx(
            0.75 * match.parts[0].probability
        )


def test_a_place_that_only_a_caption_speaks_for_is_unknown(learned: Learned) -> None:
    capture = next(c for c, info in learned.captures.items() if info.name == "ana/bow_1")
    captions = {**learned.captions, capture: (replace(learned.captions[capture][0], words="kick"),)}
    unsure = replace(with_place(learned, -5.0), captions=captions)
    (match,) = search_words(understand_learned(unsure, "kick"), [capture]).matches
    assert match.place == match.parts[0].place == "unknown"
    assert (match.start, match.end) == (0.0, learned.captures[capture].duration)
    assert match.interval_probability is match.parts[0].interval_probability is None
    assert match.probability is not None
    assert match.reason == f"kick somewhere in 0-{match.end:.1f} s, as written"
    (heard,) = search_words(understand_learned(unsure, "bow"), [capture]).matches  # by motion
    assert heard.place == "known"
    (alone,) = search_words(understand_learned(unsure, "kick"), [capture], written=False).matches
    assert alone.place == "known"
    surer = replace(unsure, certainties=with_place(learned, 5.0).certainties)
    assert search_words(understand_learned(surer, "kick"), [capture]).matches[0].place == "known"


def test_what_was_found_is_stored(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        model = from_stored(store.load_learning(db.store))
    assert model.places is not None
    inferred, y = {7: (2, 5)}, np.array([[0.5, 0.0], [0.25, 1.0]])
    model = replace(model, places=replace(model.places, inferred=inferred, inferred_shown={7: y}))
    again = from_stored(to_stored(model))
    assert model.places is not None
    assert again.places is not None
    assert dict(again.places.words) == dict(model.places.words)
    assert all((again.places.shown[c] == y).all() for c, y in model.places.shown.items())
    assert again.places.inferred == inferred
    assert (again.places.inferred_shown[7] == y).all()
    assert again.certainties.place is not None
    assert model.certainties.place is not None
    assert (again.certainties.place.weights == model.certainties.place.weights).all()


def test_a_caption_of_an_interval_places_its_words_at_once(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        db.words.set("ana/long_1", "kick", 10.9, 13.9, keep=True)
        (match,) = db.search("kick", where='name="ana/long_1"').matches
        assert match.place == "known"
        assert match.start == pytest.approx(10.9, abs=1.5)
        assert match.end == pytest.approx(13.9, abs=1.5)


def test_a_removed_capture_leaves_no_place(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        number = next(i.capture_id for i in db.captures() if i.name == "ana/long_1")
        before = db.learned.places
        assert before is not None
        assert number in before.words
        db.captures.remove(["ana/long_1"])
        after = db.learned.places
        assert after is not None
        assert set(after.words) == set(before.words) - {number}
        assert db.search("walk").matches
