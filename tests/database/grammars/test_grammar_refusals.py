"""Grammars that cannot be learned, and questions that they cannot answer: told, nothing stored."""

from __future__ import annotations

import pytest
from dances import QUICK, SETTINGS, TAKES

from motiondb import store
from motiondb.database import MotionDB
from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.errors import MotionDBError, NotLearnedError, QueryError
from motiondb.grammar.cfg.parse import ParseError


@pytest.mark.parametrize(
    ("captures", "settings", "sentence"),
    [
        ([], SETTINGS, "captures: expected at least one to learn from, found none."),
        (["ana/long_dance_2"] * 2, SETTINGS, "expected every capture once, found it twice"),
        (["ana/long_dnce_2"], SETTINGS, "Did you mean"),
        (
            ["fatou/dance_1"],
            GrammarSettings(1, search=QUICK),
            "expected at least two different symbols, found 1",
        ),
        (
            ["ana/long_dance_2"],
            GrammarSettings(8, search=QUICK, sentences="all"),
            "expected one of auto",
        ),
        (
            ["fatou/dance_1"],
            GrammarSettings(2, search=QUICK, sentences="captions"),
            "with timed words",
        ),
    ],
)
def test_what_cannot_be_learned_is_told_and_nothing_is_stored(
    dances: MotionDB, captures: list[str], settings: GrammarSettings, sentence: str
) -> None:
    rows = store.count_rows(dances.store)
    with pytest.raises(QueryError, match=sentence):
        dances.grammars.learn(captures, "dance", settings)
    assert store.count_rows(dances.store) == rows


def test_generated_captures_and_untaught_databases_are_refused(dances: MotionDB) -> None:
    dances.grammars.save("new/dance", dances.grammars.generate("dance", 4), 4)
    with pytest.raises(QueryError, match="found a generated one"):
        dances.grammars.learn(["new/dance"])
    with pytest.raises(NotLearnedError):
        dances.grammars.learn(TAKES, "s", GrammarSettings(from_symbols=True))
    with pytest.raises(QueryError, match="expected a name of 1 to 80 letters"):
        dances.grammars.learn(TAKES, " ")


def test_wrong_questions_are_told(dances: MotionDB) -> None:
    for ask in (dances.grammars.show, dances.grammars.generate, dances.grammars.remove):
        with pytest.raises(QueryError, match=r"'danec': .* Did you mean dance\?"):
            ask("danec")
    with pytest.raises(QueryError, match="'zz': expected terminals of the grammar"):
        dances.grammars.suggest("dance", "a zz")
    with pytest.raises(QueryError, match="expected at least 1 terminal, found 0"):
        dances.grammars.generate("dance", 1, 0)
    string = dances.grammars.load("dance").strings[0]
    with pytest.raises(MotionDBError, match="position 99: expected 0 to"):
        dances.grammars.edit("dance", string, 99)
    with pytest.raises(ParseError):
        dances.grammars.edit("dance", (*string, *string, *string), 0)
    with pytest.raises(QueryError, match="expected a capture that a grammar derived"):
        dances.grammars.edit("dance", TAKES[0], 0)
    edited = dances.grammars.edit("dance", string, 0, n=2)
    with pytest.raises(QueryError, match="alternative 9: expected 1 to"):
        dances.grammars.play("dance", edited, 8)
    rows = store.count_rows(dances.store)
    with pytest.raises(QueryError, match="expected a name that is free"):
        dances.grammars.save(TAKES[0], dances.grammars.generate("dance", 1), 1)
    assert store.count_rows(dances.store) == rows


def test_names_that_are_too_long_for_files_are_refused(dances: MotionDB) -> None:
    long = "n" * 300
    with pytest.raises(QueryError, match="expected a name of 1 to 80 letters"):
        dances.grammars.learn(TAKES, long, SETTINGS)
    with pytest.raises(QueryError, match="expected a file or the name of a capture"):
        dances.grammars.parse("dance", long)
    rows = store.count_rows(dances.store)
    with pytest.raises(QueryError, match="expected a name of at most 200 printable letters, found"):
        dances.grammars.save(long, dances.grammars.generate("dance", 1), 1)
    assert store.count_rows(dances.store) == rows
    with pytest.raises(MotionDBError, match="n" * 80):
        dances.grammars.load(long)
