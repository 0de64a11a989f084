"""What the dictionary said of words is kept, and then it is not loaded."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from motiondb.database.learn.counting import pack_forms, unpack_forms
from motiondb.records import Caption
from motiondb.words import lemmas, vocabulary

ASKED = """
import sys, motiondb
with motiondb.open(sys.argv[1], read_only=True) as db:
    assert db.search("wave, walk").matches
    print("simplemma" in sys.modules)
    db.search("walk, marionettes")
    print("simplemma" in sys.modules)
"""


def test_forms_come_back_with_their_lemmas() -> None:
    captions = {1: (Caption("two cartwheels, then a lay-up"), Caption("Stairs; KickBalls"))}
    forms = unpack_forms(pack_forms(captions))
    assert forms == {
        "a": "a", "balls": "ball", "cartwheels": "cartwheel", "layup": "layup", "stairs": "stair",
        "then": "then", "two": "two",
    }  # fmt: skip
    assert unpack_forms(pack_forms({})) == {}


def test_what_is_recalled_is_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lemmas, "_recalled", {})
    lemmas.lemma.cache_clear()
    lemmas.recall({"frobs": "frob"})
    assert vocabulary.words_of("three frobs and walks") == ["frob", "walk"]
    lemmas.lemma.cache_clear()


def test_words_that_were_learned_need_no_dictionary(learned_file: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", ASKED, str(learned_file)], capture_output=True, text=True, check=True
    )
    assert ended.stdout.split() == ["False", "True"]
