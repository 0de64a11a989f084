"""Words of terminals, with probabilities where own captions have checked them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import motiondb
from motiondb.database.grammars import grammar_sequences
from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.database.grammars.grammar_words import terminal_meanings


def test_words_that_no_own_caption_has_checked_have_no_probability(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        settings = GrammarSettings(None, from_symbols=True, sentences="captures")
        takes = ["goran/long_fight_2", "boris/long_fight_1"]
        grammar, _ = db.grammars.learn(takes, "fight", settings)
        numbers = grammar_sequences.load_material(db.store, "fight").numbers
        before = terminal_meanings(db.learned, grammar, numbers)
        partly = replace(db.learned)
        vars(partly)["checked"] = np.array([w == "kick" for w in partly.association.words])
        after = terminal_meanings(partly, grammar, numbers)
    assert any(word == "kick" for one in before for word, _ in one.words)
    assert any(word != "kick" for one in before for word, _ in one.words)
    for one, other in zip(before, after):
        assert other.words == tuple((w, p if w == "kick" else None) for w, p in one.words)
        assert other.text == one.text
