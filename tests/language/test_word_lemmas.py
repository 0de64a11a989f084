"""What the dictionary said of words is kept, and then it is not loaded."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from motiondb.language import lemmas, vocabulary
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import hold_to_known
from motiondb.meaning.counting import dictionary_lemmas
from motiondb.records import Caption

ASKED = """
import sys, motiondb
with motiondb.open(sys.argv[1], read_only=True) as db:
    assert db.search("wave, walk").matches
    print("simplemma" in sys.modules)
    db.search("walk, marionettes")
    print("simplemma" in sys.modules)
"""


def test_forms_have_their_lemmas() -> None:
    captions = {1: (Caption("two cartwheels, then a lay-up"), Caption("Stairs; KickBalls"))}
    assert dictionary_lemmas(captions) == {
        "a": "a", "balls": "ball", "cartwheels": "cartwheel", "layup": "layup", "stairs": "stair",
        "then": "then", "two": "two",
    }  # fmt: skip
    assert dictionary_lemmas({}) == {}


def test_known_lemmas_are_the_answer_of_the_call_they_are_given_to() -> None:
    known = {"frobs": "frob", "walks": "other"}
    assert vocabulary.words_of("three frobs and walks", lemmas=known) == ["frob", "walk"]
    assert lemmas.lemma("stairs", {"stairs": "step"}) == "step"
    assert lemmas.lemma("stairs") == "stair"
    assert hold_to_known(parse("frobs", lemmas=known), {"frob": 1}).words == ("frob",)


@pytest.mark.slow  # learns the sample data
def test_words_that_were_learned_need_no_dictionary(learned_file: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", ASKED, str(learned_file)], capture_output=True, text=True, check=True
    )
    assert ended.stdout.split() == ["False", "True"]
