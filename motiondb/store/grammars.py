"""Grammars with their terminals, sentences and parses, as plain data; derivations of captures.

A grammar is saved, replaced (by its name) and removed as a whole, in one transaction. It keeps the
names and digests of the captures that it was learned from, not their numbers. So the grammar stays
when one of them is removed. When the same content is added again, its digest identifies it.

A derivation says how a generated capture was derived from a grammar, so that it can be edited. It
is removed when its grammar is removed or learned again, because its rule numbers are valid only in
that grammar. The capture stays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from motiondb.errors import QueryError
from motiondb.records import MOTION_FPS, IntArray
from motiondb.store.catalogue.names import unknown_name
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import ragged
from motiondb.store.connection.transactions import transaction

GRAMMAR_TABLES = (
    "grammar",
    "grammar_source",
    "terminal",
    "terminal_segment",
    "grammar_rule",
    "sentence",
    "grammar_bits",
)
TABLES = (*GRAMMAR_TABLES, "derivation")


@dataclass(frozen=True)
class GrammarSource:
    """A capture that a grammar was learned from, as it was then; frames at 30 a second."""

    name: str
    sha256: str
    n_frames: int


@dataclass(frozen=True, eq=False)
class StoredGrammar:
    """A grammar as it is stored; ``LearnedGrammar`` computes with it."""

    name: str
    sources: tuple[GrammarSource, ...]  # The takes, by number
    terminals: tuple[str, ...]  # Names of the K terminals
    symbols: IntArray  # (K,): the motion symbol from which each terminal was made, -1: none
    takes: IntArray  # (segments,): number of the take of each segment
    starts: IntArray  # (segments,): first frame of each segment; those of a take tile it
    ends: IntArray  # (segments,): frame after the last of each segment
    labels: IntArray  # (segments,): number of the terminal
    medoids: IntArray  # (K,): the segment that stands for each terminal
    objective: float  # F of the terminals, NaN where these are motion symbols
    start: str  # The start symbol
    rules: tuple[tuple[str, tuple[str, ...], float], ...]  # Left side, right side, probability
    # (sentences, 2): segments [first, end) of each sentence, one after the other; no sentence spans
    # two takes
    sentences: IntArray
    parses: tuple[tuple[int, ...], ...]  # For each sentence the rules of its tree, in preorder
    bits: Mapping[str, float] = field(default_factory=dict)  # Part of the description -> its length
    run_id: int = 0  # The run that learned the grammar; set when it is saved
    grammar_id: int = 0  # Number of the grammar in the store; set when it is saved


@dataclass(frozen=True)
class Derivation:
    """The derivation tree of a generated capture, and the clips of its leaves."""

    grammar: str  # Name of the grammar
    rules: tuple[int, ...]  # Numbers of the rules of the tree, in preorder (``derive_by``)
    # For each leaf of the tree, from left to right, the segment of the grammar that plays it
    clips: tuple[int, ...]


@dataclass(frozen=True)
class GrammarSize:
    """Counts of a grammar; frames at 30 a second, description lengths of its parts in bits."""

    name: str
    run_id: int
    captures: int
    frames: int
    terminals: int
    segments: int
    sentences: int
    nonterminals: int
    rules: int
    bits: dict[str, float]

    @property
    def seconds(self) -> float:
        """Duration of all captures, seconds."""
        return self.frames / MOTION_FPS


def save_grammar(store: Store, grammar: StoredGrammar, run_id: int) -> list[str]:
    """Save a grammar, replacing any grammar of the same name."""
    with transaction(store) as connection:
        lost = _remove(store, grammar.name)
        number = connection.value("SELECT coalesce(max(grammar_id), 0) + 1 FROM grammar")
        connection.insert_row(
            "grammar",
            number,
            grammar.name,
            grammar.start,
            None if np.isnan(grammar.objective) else grammar.objective,
            run_id,
        )
        _insert_terminals(store, grammar, number, run_id)
        _insert_rules(store, grammar, number, run_id)
    return lost


def _insert_terminals(store: Store, grammar: StoredGrammar, number: int, run_id: int) -> None:
    connection = store.connection
    connection.insert(
        "grammar_source",
        grammar_id=number,
        take=np.arange(len(grammar.sources)),
        source_name=[source.name for source in grammar.sources],
        source_sha256=[source.sha256 for source in grammar.sources],
        n_frames=[source.n_frames for source in grammar.sources],
        run_id=run_id,
    )
    connection.insert(
        "terminal",
        grammar_id=number,
        ordinal=np.arange(len(grammar.terminals)),
        name=list(grammar.terminals),
        symbol_id=grammar.symbols,
        run_id=run_id,
    )
    ordinals = np.arange(len(grammar.takes))
    connection.insert(
        "terminal_segment",
        grammar_id=number,
        ordinal=ordinals,
        take=grammar.takes,
        start_frame=grammar.starts,
        end_frame=grammar.ends,
        terminal=grammar.labels,
        is_medoid=np.isin(ordinals, grammar.medoids),
        run_id=run_id,
    )


def _insert_rules(store: Store, grammar: StoredGrammar, number: int, run_id: int) -> None:
    connection = store.connection
    for ordinal, (left, right, probability) in enumerate(grammar.rules):
        connection.insert_row(
            "grammar_rule", number, ordinal, left, list(right), probability, run_id
        )
    connection.insert(
        "sentence",
        grammar_id=number,
        ordinal=np.arange(len(grammar.sentences)),
        first_segment=grammar.sentences[:, 0],
        end_segment=grammar.sentences[:, 1],
        rules=ragged([np.asarray(rules, dtype=np.int64) for rules in grammar.parses]),
        run_id=run_id,
    )
    connection.insert(
        "grammar_bits",
        grammar_id=number,
        ordinal=np.arange(len(grammar.bits)),
        part=list(grammar.bits),
        bits=list(grammar.bits.values()),
        run_id=run_id,
    )


def load_grammar(store: Store, name: str) -> StoredGrammar:
    """Load the grammar of this name."""
    connection = store.connection
    row = connection.execute(
        "SELECT grammar_id, start_symbol, objective, run_id FROM grammar WHERE name = ?", [name]
    ).fetchone()
    if row is None:
        raise QueryError(_unknown(store, name))
    number, start, objective, run_id = row

    def rows(columns: str, table: str, order: str = "ordinal") -> list[tuple[Any, ...]]:
        query = f"SELECT {columns} FROM {table} WHERE grammar_id = ? ORDER BY {order}"
        return connection.execute(query, [number]).fetchall()

    segments = connection.arrays(
        "SELECT take, start_frame, end_frame, terminal, is_medoid FROM terminal_segment "
        "WHERE grammar_id = ? ORDER BY ordinal",
        [number],
    )
    terminals = rows("name, symbol_id", "terminal")
    medoids = np.full(len(terminals), -1, dtype=np.int64)
    which = np.flatnonzero(segments["is_medoid"].astype(bool))
    medoids[segments["terminal"][which]] = which
    sources = rows("source_name, source_sha256, n_frames", "grammar_source", "take")
    rules = rows("left_symbol, right_symbols, probability", "grammar_rule")
    sentences = rows("first_segment, end_segment, rules", "sentence")
    return StoredGrammar(
        name,
        tuple(GrammarSource(*source) for source in sources),
        tuple(terminal for terminal, _ in terminals),
        np.array([symbol for _, symbol in terminals], dtype=np.int64),
        segments["take"],
        segments["start_frame"],
        segments["end_frame"],
        segments["terminal"],
        medoids,
        np.nan if objective is None else objective,
        start,
        tuple((left, tuple(right), probability) for left, right, probability in rules),
        np.array([row[:2] for row in sentences], dtype=np.int64).reshape(-1, 2),
        tuple(tuple(row[2]) for row in sentences),
        dict(rows("part, bits", "grammar_bits")),
        run_id,
        number,
    )


def load_grammar_names(store: Store) -> list[str]:
    """Load the names of all grammars, in alphabetical order."""
    return store.connection.column("SELECT name FROM grammar ORDER BY name")


def load_grammar_sizes(store: Store) -> list[GrammarSize]:
    """Count what each grammar holds, in order of name, without loading the grammars."""
    rows = store.connection.execute(
        """SELECT name, run_id,
           (SELECT count(*) FROM grammar_source s WHERE s.grammar_id = g.grammar_id),
           (SELECT sum(n_frames)::BIGINT FROM grammar_source s WHERE s.grammar_id = g.grammar_id),
           (SELECT count(*) FROM terminal t WHERE t.grammar_id = g.grammar_id),
           (SELECT count(*) FROM terminal_segment t WHERE t.grammar_id = g.grammar_id),
           (SELECT count(*) FROM sentence t WHERE t.grammar_id = g.grammar_id),
           (SELECT count(DISTINCT left_symbol) FROM grammar_rule r
            WHERE r.grammar_id = g.grammar_id),
           (SELECT count(*) FROM grammar_rule r WHERE r.grammar_id = g.grammar_id),
           (SELECT map(list(part ORDER BY ordinal), list(bits ORDER BY ordinal))
            FROM grammar_bits b WHERE b.grammar_id = g.grammar_id)
           FROM grammar g ORDER BY name"""
    ).fetchall()
    return [GrammarSize(*row) for row in rows]


def remove_grammar(store: Store, name: str) -> list[str]:
    """Remove a grammar and its derivations; the derived captures stay, with their provenance."""
    if name not in load_grammar_names(store):
        raise QueryError(_unknown(store, name))
    return _remove(store, name)


def _remove(store: Store, name: str) -> list[str]:
    with transaction(store) as connection:
        number = connection.value("SELECT grammar_id FROM grammar WHERE name = ?", [name])
        query = "SELECT name FROM derivation JOIN capture USING (capture_id) WHERE grammar_id = ?"
        lost = connection.column(f"{query} ORDER BY name", [number])
        for table in TABLES:
            connection.execute(f"DELETE FROM {table} WHERE grammar_id = ?", [number])
    return lost


def _unknown(store: Store, name: str) -> str:
    remedy = "Learn one: motiondb grammar learn CAPTURE..."
    return unknown_name(store, name, "grammar", load_grammar_names(store), remedy)


def load_source_numbers(store: Store, sources: Sequence[GrammarSource]) -> dict[int, int]:
    """Load the numbers of the captures that a grammar was learned from, by number of the take."""
    known = {
        (sha256, n_frames): number
        for number, sha256, n_frames in store.connection.execute(
            "SELECT capture_id, sha256, motion_frames FROM capture"
        ).fetchall()
    }
    numbers = {take: known.get((s.sha256, s.n_frames)) for take, s in enumerate(sources)}
    return {take: number for take, number in numbers.items() if number is not None}


def save_derivation(
    store: Store, capture_id: int, grammar_id: int, derivation: Derivation, run_id: int
) -> None:
    """Save the derivation of a generated capture from the grammar of this number."""
    with transaction(store) as connection:
        connection.insert_row(
            "derivation",
            capture_id,
            grammar_id,
            list(derivation.rules),
            list(derivation.clips),
            run_id,
        )


def load_derivation(store: Store, capture_id: int) -> Derivation | None:
    """Load the derivation of a capture; None where it was derived from no grammar."""
    row = store.connection.execute(
        "SELECT name, rules, clips FROM derivation JOIN grammar USING (grammar_id) "
        "WHERE capture_id = ?",
        [capture_id],
    ).fetchone()
    return None if row is None else Derivation(row[0], tuple(row[1]), tuple(row[2]))


def load_derivations(store: Store, grammar_id: int) -> dict[str, Derivation]:
    """Load the derivations of a grammar by the names of their captures, in order of name."""
    rows = store.connection.execute(
        "SELECT c.name, g.name, rules, clips FROM derivation JOIN capture c USING (capture_id) "
        "JOIN grammar g USING (grammar_id) WHERE grammar_id = ? ORDER BY c.name",
        [grammar_id],
    ).fetchall()
    return {
        name: Derivation(grammar, tuple(rules), tuple(clips))
        for name, grammar, rules, clips in rows
    }
