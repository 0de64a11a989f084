"""Sentences that look like errors: a slow twin over all single edits, and true errors."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.grammar.cfg.context_free import choices_of, read_grammar
from motiondb.grammar.cfg.parse import accepts, log_probability, parse
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce_quickly
from motiondb.grammar.sentences.doubtful import Doubtful, find_doubtful, nearest_sentence

TOY = read_grammar("S -> up A down [0.7] | up B\nA -> l r A [0.4] | l r [0.6]\nB -> k [0.8] | l l")


def doubtful(sentences: list[tuple[str, ...]]) -> list[Doubtful]:
    """Those that look like errors by rules that are learned from them."""
    grammar = induce_quickly(sentences)
    return find_doubtful(grammar, sentences, [choices_of(parse(grammar, s)) for s in sentences])


def edits(string: tuple[str, ...]) -> set[tuple[str, ...]]:
    """All strings that one exchange, gap or addition makes of a string."""
    made = {string[:n] + string[n + 1 :] for n in range(len(string))}
    for other in TOY.terminals:
        made |= {(*string[:n], other, *string[n + 1 :]) for n in range(len(string))}
        made |= {(*string[:n], other, *string[n:]) for n in range(len(string) + 1)}
    return made - {string}


@pytest.mark.parametrize("seed", range(25))
def test_the_nearest_sentence_is_the_most_probable_of_all_single_edits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    string = derive(TOY, rng).leaves()
    wrong = sorted(s for s in edits(string) if not accepts(TOY, s))
    chosen = wrong[int(rng.integers(len(wrong)))]
    chances = {s: log_probability(TOY, s) for s in edits(chosen) if accepts(TOY, s)}
    found = nearest_sentence(TOY, chosen)
    assert found is not None
    assert chances[found] == pytest.approx(max(chances.values()))
    assert nearest_sentence(TOY, ("k",) * 9) is None


def test_a_symbol_that_the_others_do_not_know_can_be_an_error() -> None:
    sentences = [tuple("abcd")] * 12 + [tuple("abxd"), tuple("abd")]
    first, second = doubtful(sentences)
    assert (first.sentence, first.position, first.found, first.expected) == (12, 2, "x", "c")
    assert (second.sentence, second.found, second.expected) == (13, "", "c")
    assert first.instead == second.instead == tuple("abcd")


def test_few_sentences_and_true_alternatives_are_not_called_errors() -> None:
    few = [tuple("abc")] * 4 + [tuple("axc")]
    assert doubtful(few) == []
    free = [(a, b, c) for a in "abc" for b in "xyz" for c in "uvw"]
    assert doubtful(free) == []
