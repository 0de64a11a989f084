"""Grammars come back as they were saved, are replaced whole, and outlive their captures."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from motiondb import store
from motiondb.errors import QueryError, StoreError
from motiondb.store.grammars import TABLES


@pytest.fixture
def filled(database: store.Store, samples: ModuleType) -> store.Store:
    for name in ("a", "bb"):
        samples.add(database, name)
    samples.add(database, "dddd", n_frames=5, kind="generated")
    return database


def save(database: store.Store, samples: ModuleType, name: str = "dance", **kwargs: int) -> int:
    with store.transaction(database):
        run_id = store.start_run(database, "grammar", {"name": name}, 3)
        infos = [i for i in store.load_captures(database) if i.kind == "captured"]
        store.save_grammar(database, samples.grammar(name, infos, **kwargs), run_id)
        store.finish_run(database, run_id)
    return run_id


def derive(database: store.Store, name: str = "dance") -> store.Derivation:
    number = store.load_grammar(database, name).grammar_id
    derivation = store.Derivation(name, (0, 1), (3, 1, 2))
    run_id = store.start_run(database, "generate")
    store.save_derivation(database, 3, number, derivation, run_id)
    store.finish_run(database, run_id)
    return derivation


def test_a_grammar_comes_back_as_it_was_saved(filled: store.Store, samples: ModuleType) -> None:
    run_id = save(filled, samples)
    infos = store.load_captures(filled)[:2]
    grammar = store.load_grammar(filled, "dance")
    expected = samples.grammar("dance", infos, run_id=run_id, grammar_id=1)
    samples.assert_equal(grammar, expected)
    assert store.load_grammar_names(filled) == ["dance"]
    assert store.load_source_numbers(filled, grammar.sources) == {0: 1, 1: 2}
    for table in TABLES[:-1]:
        query = f"SELECT DISTINCT run_id FROM {table}"
        assert filled.connection.execute(query).fetchall() == [(run_id,)], table


def test_a_grammar_of_the_same_name_is_replaced_with_its_derivations(
    filled: store.Store, samples: ModuleType
) -> None:
    save(filled, samples)
    save(filled, samples, "other")
    assert derive(filled) == store.load_derivation(filled, 3)
    assert store.check_store(filled) == []
    rows = store.count_rows(filled)
    run_id = store.start_run(filled, "grammar")
    infos = store.load_captures(filled)[:2]
    assert store.save_grammar(filled, samples.grammar("dance", infos), run_id) == ["dddd"]
    store.finish_run(filled, run_id)
    assert store.load_derivation(filled, 3) is None
    assert store.load_grammar(filled, "dance").run_id == run_id
    assert store.count_rows(filled) == rows | {"derivation": 0, "run": rows["run"] + 1}
    assert store.check_store(filled) == []


def test_removing_leaves_nothing_but_the_captures(filled: store.Store, samples: ModuleType) -> None:
    save(filled, samples)
    derive(filled)
    assert store.remove_grammar(filled, "dance") == ["dddd"]
    rows = store.count_rows(filled)
    assert {rows[table] for table in TABLES} == {0}
    assert rows["capture"] == 3
    assert store.check_store(filled) == []


def test_an_unknown_grammar_is_told_with_the_nearest(
    filled: store.Store, samples: ModuleType
) -> None:
    with pytest.raises(QueryError, match=r"Learn one: motiondb grammar learn CAPTURE\.\.\."):
        store.load_grammar(filled, "dance")
    save(filled, samples)
    sentence = f"'danec': expected the name of a grammar, found none in {filled.path}."
    with pytest.raises(QueryError) as error:
        store.remove_grammar(filled, "danec")
    assert str(error.value) == f"{sentence} Did you mean dance?"
    with pytest.raises(QueryError, match=r"There are: dance\."):
        store.load_grammar(filled, "zzz")


def test_a_grammar_outlives_its_captures_and_finds_them_again(
    filled: store.Store, samples: ModuleType
) -> None:
    save(filled, samples)
    derive(filled)
    store.remove_captures(filled, [2])
    learned = store.load_grammar(filled, "dance")
    assert [source.name for source in learned.sources] == ["a", "bb"]
    assert store.load_source_numbers(filled, learned.sources) == {0: 1}
    assert store.check_store(filled) == []
    samples.add(filled, "bb")
    assert store.load_source_numbers(filled, learned.sources) == {0: 1, 1: 4}
    store.remove_captures(filled, [3])
    assert store.count_rows(filled)["derivation"] == 0
    assert store.check_store(filled) == []


def test_a_source_of_another_length_is_not_the_source(
    filled: store.Store, samples: ModuleType
) -> None:
    save(filled, samples)
    store.remove_captures(filled, [1])
    samples.add(filled, "a", n_frames=9)  # the same file, read in another way
    assert store.load_source_numbers(filled, store.load_grammar(filled, "dance").sources) == {1: 2}


def test_a_failing_save_keeps_the_grammar_before(filled: store.Store, samples: ModuleType) -> None:
    save(filled, samples)
    before = store.count_rows(filled)
    infos = store.load_captures(filled)[:2]
    broken = samples.grammar("dance", infos, probability=2.0)
    with pytest.raises(StoreError, match="Nothing was changed"):
        store.save_grammar(filled, broken, 1)
    assert store.count_rows(filled) == before
    assert store.check_store(filled) == []


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (
            "UPDATE terminal_segment SET end_frame = 11 WHERE end_frame = 12 AND take = 1",
            "grammar dance: expected segments that tile its takes, found others.",
        ),
        (
            "DELETE FROM terminal_segment WHERE take = 1",
            "grammar dance: expected segments that tile its takes, found others.",
        ),
        (
            "UPDATE terminal_segment SET is_medoid = false WHERE ordinal = 1",
            "grammar dance: expected one medoid for every terminal, found others.",
        ),
        (
            "UPDATE grammar_rule SET probability = 0.9 WHERE ordinal = 1",
            "grammar dance: expected the probabilities of a symbol's rules to sum to 1, "
            "found others.",
        ),
        (
            "UPDATE sentence SET first_segment = 0 WHERE ordinal = 1",
            "grammar dance: expected sentences of segments, one after the other, found others.",
        ),
        (
            "UPDATE terminal SET run_id = 1",
            "terminal: expected rows of a grammar and of its run, found 3 others.",
        ),
        (
            "UPDATE sentence SET grammar_id = 9",
            "sentence: expected rows of a grammar and of its run, found 2 others.",
        ),
        (
            "UPDATE derivation SET capture_id = 1",
            "derivation: expected rows of a grammar and of a generated capture, found 1 others.",
        ),
        (
            "UPDATE run SET finished = NULL WHERE kind = 'grammar'",
            "grammar: expected rows of a finished run, found 1 others.",
        ),
    ],
)
def test_damage_is_told(
    filled: store.Store, samples: ModuleType, damage: str, sentence: str
) -> None:
    save(filled, samples)
    derive(filled)
    assert store.check_store(filled) == []
    filled.connection.execute(damage)
    assert sentence in store.check_store(filled)


def test_a_grammar_of_motion_symbols_has_no_objective(
    filled: store.Store, samples: ModuleType
) -> None:
    run_id = store.start_run(filled, "grammar")
    infos = store.load_captures(filled)[:2]
    store.save_grammar(filled, samples.grammar("s", infos, objective=np.nan), run_id)
    assert np.isnan(store.load_grammar(filled, "s").objective)
