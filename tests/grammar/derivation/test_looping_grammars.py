"""Learned grammars with loops in use: everything ends, stays in the language, and adds up."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from motiondb.grammar.cfg.compiled import compile_grammar
from motiondb.grammar.cfg.context_free import Grammar, choices_of, derive_by, read_grammar
from motiondb.grammar.cfg.lengths import mean_length
from motiondb.grammar.cfg.loops import format_loops
from motiondb.grammar.cfg.parse import accepts, log_probability, parse
from motiondb.grammar.cfg.prefix import prefix_log_probability, suggest
from motiondb.grammar.derivation.complete import complete, sample_completion
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.derivation.edit import alternatives, region_at, replace_region
from motiondb.grammar.derivation.pattern import read_pattern
from motiondb.grammar.derivation.plan import plan
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.induction.rule_compaction import Effort
from motiondb.grammar.languages import (
    coverage,
    derived_strings,
    finite_language,
)
from motiondb.grammar.rules.description_length import description_length

TRUTHS = {
    "steps": "S -> stand A rest\nA -> left right A [0.6] | left right [0.4]",
    "nest": "S -> a S b [0.65] | a b [0.35]",
}
LITTLE = Effort(begun=12, repeated=16, tries=4000)


@cache
def learned(name: str) -> tuple[Grammar, tuple[tuple[str, ...], ...]]:
    truth, rng = read_grammar(TRUTHS[name]), np.random.default_rng(5)
    sentences = tuple(derive(truth, rng).leaves() for _ in range(20))
    return induce(sentences, effort=LITTLE), sentences


def test_steps_are_printed_as_a_repetition() -> None:
    grammar, sentences = learned("steps")
    n = sum(len(s) // 2 - 1 for s in sentences)  # rounds of "left right"
    lines = format_loops(grammar).splitlines()
    assert lines == ["S -> stand A rest", f"A -> (left right)+ [{1 - 20 / n:.4g}]"]


@pytest.mark.parametrize("name", TRUTHS)
def test_derivations_end_and_are_as_long_as_the_sentences_on_average(name: str) -> None:
    grammar, sentences = learned(name)
    rng = np.random.default_rng(1)
    strings = [derive(grammar, rng).leaves() for _ in range(2000)]
    assert all(accepts(grammar, string) for string in set(strings))
    # the probabilities of the rules are their shares of the uses: relative frequency keeps means
    told = float(np.mean([len(s) for s in sentences]))
    compiled = compile_grammar(grammar)
    assert mean_length(compiled, compiled.probabilities) == pytest.approx(told)
    spread = np.std([len(s) for s in strings]) / len(strings) ** 0.5
    assert np.mean([len(s) for s in strings]) == pytest.approx(told, abs=5 * spread)
    for length in (4, 10, 40, 200):
        assert len(derive(grammar, rng, length=length).leaves()) == length


@pytest.mark.parametrize("name", TRUTHS)
def test_endless_languages_are_counted_and_compared_as_endless(name: str) -> None:
    grammar, sentences = learned(name)
    assert finite_language(grammar, 10_000) is None
    truth = read_grammar(TRUTHS[name])
    strings = derived_strings(grammar, np.random.default_rng(0), 200)
    assert coverage(truth, strings) == 1.0
    assert any(string not in sentences for string in strings)
    assert description_length(grammar, sentences).total == pytest.approx(
        description_length(truth, sentences).total
    )


@pytest.mark.parametrize("name", TRUTHS)
def test_long_sentences_are_parsed_and_walks_along_suggestions_add_up(name: str) -> None:
    grammar, _ = learned(name)
    string = derive(grammar, np.random.default_rng(0), length=120).leaves()
    assert parse(grammar, string).leaves() == string
    assert derive_by(grammar, choices_of(parse(grammar, string))).leaves() == string
    log_chance = 0.0
    for k in range(len(string) + 1):
        told = dict(suggest(grammar, string[:k]))
        assert sum(told.values()) == pytest.approx(1.0)
        log_chance += np.log(told[string[k] if k < len(string) else None])
    assert log_chance == pytest.approx(log_probability(grammar, string))
    first = prefix_log_probability(grammar, string[:1])
    assert first == pytest.approx(0.0)  # all begin alike


def test_a_loop_is_edited_to_other_numbers_of_rounds() -> None:
    grammar, _ = learned("steps")
    tree = parse(grammar, ("stand", *("left", "right") * 3, "rest"))
    region = region_at(tree, 3)  # the second "left": what is left of the loop from there on
    others = alternatives(grammar, tree, region, 4, np.random.default_rng(0))
    assert [len(one.string) for one in others] == sorted(len(one.string) for one in others)
    for one in others:
        edited = replace_region(tree, region, one.tree)
        assert accepts(grammar, edited.leaves())
        assert edited.leaves()[: region.start] == tree.leaves()[: region.start]
    assert len({one.string for one in others}) == 4


def test_a_goal_and_a_pattern_are_reached_through_a_loop() -> None:
    grammar, _ = learned("nest")
    assert plan(grammar, ["a", "a", "a"], goal="b").to_goal == ("b",)
    pattern = read_pattern(["a", "a", "a", "...", "b"])
    completions = complete(grammar, pattern, 3)
    assert [len(c.string) for c in completions.sentences] == [6, 8, 10]
    assert completions.probability == pytest.approx(
        np.exp(prefix_log_probability(grammar, ["a", "a", "a"]))
    )
    rng = np.random.default_rng(0)
    for _ in range(20):
        string = sample_completion(grammar, pattern, rng).leaves()
        assert accepts(grammar, string)
        assert string[:3] == ("a", "a", "a")
