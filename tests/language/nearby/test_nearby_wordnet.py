"""WordNet's files as records, on a WordNet of five synsets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nearby_words.opposites import vetoes
from nearby_words.pairs import CHANNELS, evidence, make_lexicon
from nearby_words.wordnet import WordNet, gloss_words, read_wordnet

DATA = {
    "verb": [
        "00000001 38 v 01 walk 0 001 ~ 00000002 v 0000 01 + 02 00 | use one's feet to advance  ",
        "00000002 38 v 02 stroll 0 saunter 0 001 @ 00000001 v 0000 01 + 02 00 | walk leisurely "
        'and with no apparent aim; "we strolled"  ',
        "00000003 31 v 01 stroll 1 000 01 + 02 00 | think slowly  ",
    ],
    "adj": [
        "00000004 00 a 01 fast 0 001 ! 00000005 a 0101 | acting quickly  ",
        "00000005 00 a 01 slow(p) 0 001 ! 00000004 a 0101 | not moving quickly  ",
    ],
    "noun": ["00000006 18 n 01 Strauss 0 000 | a composer  "],
    "adv": [],
}
INDEX = {
    "verb": [
        "walk v 1 1 ~ 1 1 00000001  ",
        "stroll v 2 1 @ 2 1 00000002 00000003  ",
        "saunter v 1 1 @ 1 0 00000002  ",
    ],
    "adj": ["fast a 1 1 ! 1 0 00000004  ", "slow a 1 1 ! 1 0 00000005  "],
    "noun": ["strauss n 1 0 1 0 00000006  "],
    "adv": [],
}


@pytest.fixture
def wordnet(tmp_path: Path) -> WordNet:
    for part, lines in DATA.items():
        text = "\n".join(["  1 This is the licence.", *lines])
        (tmp_path / f"data.{part}").write_text(text)
        (tmp_path / f"index.{part}").write_text("\n".join(INDEX[part]))
    (tmp_path / "cntlist.rev").write_text("stroll%2:38:00:: 1 4\nwalk%2:38:00:: 1 7\n")
    return read_wordnet(tmp_path)


def test_a_synset_is_read(wordnet: WordNet) -> None:
    stroll = wordnet.synsets["verb00000002"]
    assert (stroll.words, stroll.field) == (("stroll", "saunter"), 38)
    assert stroll.pointers == (("@", "verb00000001", 0, 0),)
    assert stroll.definition == "walk leisurely and with no apparent aim"
    assert wordnet.synsets["adj00000005"].words == ("slow",)


def test_senses_are_counted_and_those_of_motion_likelier(wordnet: WordNet) -> None:
    # (4 + 1/2) of weight 4 for verb.motion, (0 + 0.6/2) of weight 0.3 for verb.cognition
    motion, cognition = 4.5 * 4.0, 0.3 * 0.3
    assert wordnet.senses["stroll"] == (
        ("verb00000002", pytest.approx(motion / (motion + cognition))),
        ("verb00000003", pytest.approx(cognition / (motion + cognition))),
    )
    assert (wordnet.counts["stroll"], wordnet.counts["saunter"]) == (4, 0)


def test_names_are_known(wordnet: WordNet) -> None:
    assert wordnet.names == {"strauss"}


@pytest.mark.parametrize(
    ("definition", "part", "heads"),
    [
        ("a leisurely walk (usually in some public place)", "noun", ["walk"]),
        ("walk or tramp about", "verb", ["walk", "tramp"]),
        ("(of animals) run away", "verb", ["run"]),
        ("in a swift manner", "adv", []),
        ("", "noun", []),
    ],
)
def test_the_head_of_a_gloss(definition: str, part: str, heads: list[str]) -> None:
    assert gloss_words(definition, part)[0] == heads


def test_evidence_worked_by_hand(wordnet: WordNet) -> None:
    evidence_of = evidence("saunter", make_lexicon(wordnet))
    channel = dict(zip(CHANNELS, evidence_of["walk"]))
    assert channel["above"] == pytest.approx(1.0)  # its only sense, and walk's
    assert channel["head"] > 0.0
    stroll = dict(zip(CHANNELS, evidence_of["stroll"]))
    assert stroll["same"] == pytest.approx(np.sqrt(wordnet.senses["stroll"][0][1]))
    assert "saunter" not in evidence_of


def test_antonyms_hold_both_ways_and_more_can_be_named(wordnet: WordNet) -> None:
    never = vetoes(wordnet, [("sitting", "standing")])
    assert never == {("fast", "slow"), ("slow", "fast"), ("sit", "stand"), ("stand", "sit")}
