"""A grammar with a loop in a database: stored, shown, read, compared, drawn, edited, played."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dances import TAKES
from PIL import Image

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.database.grammars import grammar_sequences
from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.database.grammars.grammar_words import (
    terminal_meanings,
    terminal_shares,
    terminals_for,
)
from motiondb.errors import QueryError
from motiondb.grammar.cfg.context_free import GrammarError, choices_of, derive_by, read_grammar
from motiondb.grammar.cfg.parse import accepts, parse
from motiondb.search.asked_words import learned_words


@pytest.fixture
def looping(dances: MotionDB) -> MotionDB:
    """The database with the grammar "looping": any terminals of "dance", one after another."""
    learned = dances.grammars.load("dance")
    takes = learned.terminals.takes
    edges = [np.flatnonzero(takes == take)[[0, -1]] + [0, 1] for take in (0, 1)]
    strings = [learned.string(int(first), int(end)) for first, end in edges]
    text = f"S -> A S | A\nA -> {' | '.join(learned.grammar.terminals)}"
    grammar = replace(read_grammar(text), terminals=learned.grammar.terminals)
    trees = [parse(grammar, string) for string in strings]
    uses = Counter(rule for tree in trees for rule in choices_of(tree))
    changed = replace(
        learned,
        name="looping",
        grammar=grammar.with_probabilities([float(uses[k]) for k in range(len(grammar.rules))]),
        sentences=np.array(edges),
        parses=tuple(choices_of(tree) for tree in trees),
    )
    with store.transaction(dances.store):
        run_id = store.start_run(dances.store, "grammar", {"name": "looping"})
        store.save_grammar(dances.store, changed.stored, run_id)
        store.finish_run(dances.store, run_id)
    return dances


def test_a_grammar_with_loops_is_stored_shown_read_and_compared(looping: MotionDB) -> None:
    grammars = looping.grammars
    learned = grammars.load("looping")
    assert looping.check() == []
    derived = [derive_by(learned.grammar, rules).leaves() for rules in learned.parses]
    assert tuple(derived) == learned.strings
    facts = grammars.show("looping")
    n = sum(len(string) for string in learned.strings)
    assert facts.text_with_loops.splitlines()[0] == f"S -> A+ [{1 - 2 / n:.4g}]"
    assert facts.derives_new
    parsed = grammars.parse("looping", "fatou/dance_1")
    assert parsed.fault is None
    assert [tree.leaves() for tree in parsed.trees] == [parsed.string]
    assert sum(chance for _, chance in grammars.suggest("looping", "")) == pytest.approx(1.0)
    stored, machine = grammars.compare("looping")
    assert (stored.strings, stored.outside) == (None, 0.0)
    assert (stored.new, machine.outside) == (
        1.0,
        0.0,
    )  # the loop holds whatever the machine derives


def test_sequences_of_a_loop_end_and_are_drawn_as_loops(looping: MotionDB, tmp_path: Path) -> None:
    grammars = looping.grammars
    learned = grammars.load("looping")
    for seed in range(3):
        made = grammars.generate("looping", seed)
        assert accepts(learned.grammar, made.string)
    for length in (1, 5, 30):
        assert len(grammars.generate("looping", 0, length=length).string) == length
    first = learned.strings[0][0]
    made = grammars.generate("looping", 2, like=f"{first} ... ? {first}")
    assert (made.string[0], made.string[-1]) == (first, first)
    assert len(made.string) >= 3
    assert [c.string for c in grammars.complete("looping", f"{first} {first}", 2).sentences] == [
        (first, first)
    ]
    edited = grammars.edit("looping", made, 1, (1, 0))
    parsed = grammars.parse("looping", TAKES[0])
    for name, draw in {
        "trees": lambda path: grammars.draw_trees("looping", path),
        "parse": lambda path: grammars.draw_parse("looping", parsed, path),
        "edit": lambda path: grammars.draw_edit("looping", edited, path),
    }.items():
        assert draw(tmp_path / f"{name}.png").stat().st_size > 1000
    with Image.open(tmp_path / "parse.png") as picture:
        wide, high = picture.size
    assert high < wide / 3  # one node with all rounds: a chain of them would be as high as wide


@pytest.fixture(scope="module")
def fights(learned_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[MotionDB]:
    """The sample data with a grammar of two fights, whose terminals are motion symbols: to ask."""
    path = shutil.copy(learned_file, tmp_path_factory.mktemp("fights") / "motions.duckdb")
    with motiondb.open(path) as db:
        settings = GrammarSettings(None, from_symbols=True, sentences="captures")
        db.grammars.learn(["goran/long_fight_2", "boris/long_fight_1"], "fight", settings)
        yield db


def test_words_that_no_own_caption_has_checked_have_no_probability(fights: MotionDB) -> None:
    learned = fights.grammars.load("fight")
    numbers = grammar_sequences.load_material(fights.store, "fight").numbers
    before = terminal_meanings(fights.learned, learned, numbers)
    partly = replace(fights.learned)
    vars(partly)["checked"] = np.array([w == "kick" for w in partly.association.words])
    after = terminal_meanings(partly, learned, numbers)
    assert any(word == "kick" for one in before for word, _ in one.words)
    assert any(word != "kick" for one in before for word, _ in one.words)
    for one, other in zip(before, after):
        assert other.words == tuple((w, p if w == "kick" else None) for w, p in one.words)
        assert other.text == one.text


def test_words_and_sentences_lead_to_motion_that_obeys_the_grammar(fights: MotionDB) -> None:
    learned = fights.grammars.load("fight")
    material = grammar_sequences.load_material(fights.store, "fight")
    words = learned_words(fights.learned)
    shares = terminal_shares(words, learned, material.numbers)

    def shown(word: str) -> set[str]:
        return {learned.terminals.names[k] for k in terminals_for(words, shares, word)}

    kick, punch = shown("kick"), shown("punch")
    assert kick
    assert punch
    like = "... kick ... ? ... punch ..."
    for seed in range(2):
        made = fights.grammars.generate("fight", seed, like=like)
        assert accepts(learned.grammar, made.string)
        first = next(k for k, name in enumerate(made.string) if name in kick)
        assert any(name in punch for name in made.string[first + 2 :])
    assert fights.grammars.generate("fight", seed, like=like).string == made.string
    said = fights.grammars.generate("fight", 3, like="a person kicks, then punches")
    assert accepts(learned.grammar, said.string)
    first = next(k for k, name in enumerate(said.string) if name in kick)
    assert any(name in punch for name in said.string[first + 1 :])
    best = fights.grammars.complete("fight", "... kick ...", 3)
    assert all(kick & set(one.string) for one in best.sentences)
    with pytest.raises(QueryError, match=r"'kickk': .* Perhaps kick\."):
        fights.grammars.complete("fight", "... kickk ...")
    with pytest.raises(GrammarError, match="expected 'kick' anywhere after"):
        fights.grammars.complete("fight", " ".join(["kick"] * 60))
