"""A learned grammar with its terminals, and the record that the store keeps of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from motiondb.answers.plain import extended
from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.records import IntArray
from motiondb.store import GrammarSource, Store, StoredGrammar, load_grammar

if TYPE_CHECKING:
    from motiondb.grammar.terminals.terminals import Terminals


@dataclass(frozen=True, eq=False)
class LearnedGrammar:
    """The result of ``grammar learn``."""

    name: str
    """Name of the grammar."""
    sources: tuple[GrammarSource, ...]
    """The takes, numbered as in ``terminals.takes``."""
    terminals: Terminals
    """Segments of the takes and their terminals."""
    symbols: IntArray
    """The motion symbol from which each terminal was made, -1 where it was made from none."""
    grammar: Grammar
    """The rules, with their probabilities."""
    sentences: IntArray
    """Segments [first, end) of each sentence. The sentences tile the segments, and no sentence
    spans two takes."""
    parses: tuple[tuple[int, ...], ...]
    """For each sentence the numbers of the rules of its tree, in preorder (``derive_by``)."""
    bits: Mapping[str, float] = field(default_factory=dict)
    """Name of each part of the description -> its length, bits."""
    run_id: int = 0
    """The run that learned the grammar; set when it is saved."""
    grammar_id: int = 0
    """Number of the grammar in the store; set when it is saved."""

    def string(self, first: int, end: int) -> tuple[str, ...]:
        """Return the names of the terminals of segments [first, end)."""
        return tuple(self.terminals.names[k] for k in self.terminals.labels[first:end])

    @property
    def strings(self) -> tuple[tuple[str, ...], ...]:
        """The sentences as strings of terminals."""
        return tuple(self.string(int(a), int(b)) for a, b in self.sentences)

    @property
    def tints(self) -> dict[str, int]:
        """The tint number of each terminal, which is the same in all pictures of a grammar."""
        return {name: k for k, name in enumerate(self.terminals.names)}

    @property
    def stored(self) -> StoredGrammar:
        """The same as plain data, as the store keeps it."""
        parts = self.terminals
        return extended(
            StoredGrammar,
            self,
            terminals=parts.names,
            takes=parts.takes,
            starts=parts.starts,
            ends=parts.ends,
            labels=parts.labels,
            medoids=parts.medoids,
            objective=parts.objective,
            start=self.grammar.start,
            rules=tuple((rule.left, rule.right, rule.probability) for rule in self.grammar.rules),
        )


def load_learned_grammar(store: Store, name: str) -> LearnedGrammar:
    """Load the grammar of this name, with its rules and terminals."""
    from motiondb.grammar.terminals.terminals import Terminals  # 0.1 s, in no other question

    stored = load_grammar(store, name)
    rules = tuple(Rule(*rule) for rule in stored.rules)
    return extended(
        LearnedGrammar,
        stored,
        terminals=extended(Terminals, stored, names=stored.terminals),
        grammar=Grammar(stored.start, rules, stored.terminals),
    )
