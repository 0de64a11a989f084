"""Captions as people write them, and questions with faults."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.errors import SheetError
from motiondb.language.lemmas import MORE_VERBS, VERBS, lemma
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import hold_to_known, plain_actions
from motiondb.language.vocabulary import (
    STOP_WORDS,
    count_words,
    nearest_words,
    parse_synonyms,
    split_actions,
    words_of,
)


@pytest.mark.parametrize(
    ("text", "actions"),
    [
        ("walk, turn left, sit down", "walk | turn left | sit down"),
        ("A person walks forward then kicks.", "walk forward | kick"),
        ("walk and then sit", "walk | sit"),
        ("walks forward and backwards", "walk forward backward"),
        ("shaking arms and legs", "shake arm leg"),
        ("waving while walking", "wave walk"),
        ("sits down after running", "run | sit down"),
        ("run/jog, 90-degree left turn", "run jog | left turn"),
        ("basketball - forward dribble, shoot", "basketball forward dribble | shoot"),
        ("BreakDanceKickFlip", "break dance kick flip"),
        ("bear (human subject)", "bear"),
        ("climb 3 steps", "climb step"),
        ("He does a lay-up; then he passes!", "layup | pass"),
        ("the performer's hands go up", "hand go up"),
        ("while running, a human picks something up", "run | pick up"),
        ("walk?", "walk"),
        ("", ""),
        ("a person is", ""),
        (", ; .", ""),
        ("\N{ZERO WIDTH SPACE}42", ""),
    ],
)
def test_actions(text, actions):
    expected = [action.split() for action in actions.split(" | ")] if actions else []
    assert split_actions(text) == expected
    assert words_of(text) == [word for action in expected for word in action]


@pytest.mark.parametrize(
    ("form", "word"),
    [
        ("boxing", "box"), ("boxer", "box"), ("dancers", "dance"), ("dribbling", "dribble"),
        ("kicks", "kick"), ("jumping", "jump"), ("jacks", "jack"), ("ran", "run"),
        ("shots", "shoot"), ("sat", "sit"), ("sitting", "sit"), ("standing", "stand"),
        ("swinging", "swing"),
        ("waves", "wave"), ("carries", "carry"), ("feet", "foot"), ("leaves", "leave"),
        ("left", "left"), ("backwards", "backward"), ("upwards", "up"), ("over", "over"),
        ("lower", "lower"), ("number", "number"), ("pirouettes", "pirouette"), ("Bassai", "bassai"),
        ("passes", "pass"), ("pressed", "press"), ("hopped", "hop"), ("gliding", "glide"),
        ("hoping", "hope"), ("dove", "dive"), ("shook", "shake"), ("rose", "rise"),
        ("broken", "break"), ("fell", "fall"), ("bound", "bind"), ("wound", "wind"), ("won", "win"),
        ("crosses", "cross"), ("fixing", "fix"), ("wrestling", "wrestle"), ("serving", "serve"),
        ("saw", "saw"), ("sawing", "saw"), ("freezing", "freeze"), ("froze", "freeze"),
        ("ceiling", "ceiling"), ("evening", "evening"), ("seed", "seed"), ("stairs", "stair"),
    ],
)  # fmt: skip
def test_lemmas(form, word):
    assert lemma(form) == word


def regular_forms(verb):
    """Third person, gerund and past of a verb, as a school book has them."""
    if verb.endswith("ie"):
        return [verb + "s", verb[:-2] + "ying", verb + "d"]
    if verb.endswith("e"):
        keeps = verb.endswith(("ee", "oe", "ye"))
        return [verb + "s", (verb if keeps else verb[:-1]) + "ing", verb + "d"]
    if verb.endswith("y") and verb[-2] not in "aeiou":
        return [verb[:-1] + "ies", verb + "ing", verb[:-1] + "ied"]
    third = verb + ("es" if verb.endswith(("s", "x", "z", "ch", "sh", "o")) else "s")
    short = re.fullmatch("[^aeiou]*(qu)?[aeiouy][^aeiouwxy]", verb)
    stem = verb + verb[-1] if short or verb in ("transfer", "patrol", "unplug") else verb
    return [third, stem + "ing", stem + "ed"]


def test_every_regular_form_of_a_verb_has_its_lemma():
    verbs = sorted(VERBS | MORE_VERBS)
    assert len(verbs) > 300
    assert [verb for verb in verbs if lemma(verb) != verb] == []
    lost = [form for verb in verbs for form in regular_forms(verb) if lemma(form) != verb]
    assert lost == ["doed", "goed"]  # which nobody says


@given(st.text(max_size=60))
def test_any_text_is_read(text):
    for action in split_actions(text):
        assert all(word and word not in STOP_WORDS for word in action)


def ask(text, known, synonyms=None):
    """A question in known words, each in one caption."""
    return hold_to_known(parse(text, synonyms), dict.fromkeys(known, 1))


def test_wildcards_keep_their_place():
    assert split_actions("walk, ?, sit") == [["walk"], [], ["sit"]]
    assert split_actions("walk ? sit") == [["walk"], [], ["sit"]]
    assert split_actions("?, walk") == [[], ["walk"]]


def test_unknown_words_are_named_and_the_rest_works():
    parsed = ask("wlak slowly, moonwalk, sit down", ["walk", "sit", "down", "slowly"])
    assert parsed.words == ("sit", "down")  # slowly is said of an unknown action
    assert plain_actions(parsed.tree)[0] == (("sit", "down"),)
    assert parsed.unknown == {"wlak": ("walk",), "moonwalk": ("walk",)}


def test_nearest_words_do_not_depend_on_order():
    known = ["talk", "walk", "wall", "run"]
    assert nearest_words("walks", known) == nearest_words("walks", known[::-1])
    assert nearest_words("walks", known)[0] == "walk"
    assert nearest_words("xyz", known) == ()
    assert nearest_words("walk", []) == ()


def test_synonyms_meet():
    table = parse_synonyms("# mine\njogging = run\nstroll\twalk\nwalk = go\n\n")
    assert table == {"jog": "run", "stroll": "go", "walk": "go"}
    assert words_of("jogs, strolled", table) == ["run", "go"]
    assert ask("jog", ["run"], table).words == ("run",)


def test_faulty_synonyms_are_named_all_at_once():
    with pytest.raises(SheetError) as error:
        parse_synonyms(
            "jog = run\njog\njog = walk\na cat = dog\nhop = leap\nleap = hop", "mine.txt"
        )
    assert str(error.value).splitlines() == [
        "mine.txt:2: expected 'word = canonical word', found 'jog'. "
        "Write one word on each side of '=' or of a tab.",
        "mine.txt:3: expected one canonical word for 'jog', found 'walk' beside 'run' of line 1. "
        "Leave one out.",
        "mine.txt:4: expected 'word = canonical word', found 'a cat = dog'. "
        "Write one word on each side of '=' or of a tab.",
        "mine.txt:5: expected synonyms that end in a word, found a circle through 'hop'. "
        "Leave one of its lines out.",
        "mine.txt:6: expected synonyms that end in a word, found a circle through 'leap'. "
        "Leave one of its lines out.",
    ]


def test_counts_are_of_captions_not_of_words():
    words, counts = count_words([["walk", "walk"], ["walk", "sit"], []])
    assert words == ("sit", "walk")
    assert counts.tolist() == [1, 2]


def test_usual_questions_do_not_load_the_dictionary():
    program = (
        "import sys; from motiondb.language.question.readings import hold_to_known;"
        "from motiondb.language.question.parse import parse;"
        "asked = parse('a person walks, turns left, then sits down');"
        "hold_to_known(asked, {'walk': 1, 'sit': 1});"
        "print('simplemma' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr


def letters(number: int) -> str:
    """A number as letters: words hold no digits."""
    return "x" + "".join(chr(ord("a") + int(digit)) for digit in str(number))


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_chain_of_ten_thousand_words_is_read(is_reversed: bool) -> None:
    """A walk from each word to the end would take 50 million steps; it took minutes once."""
    lines = [f"{letters(n)} = {letters(n + 1)}" for n in range(10_000)]
    table = parse_synonyms("\n".join(lines[::-1] if is_reversed else lines))
    assert len(table) == 10_000
    assert set(table.values()) == {letters(10_000)}
