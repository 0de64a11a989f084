"""Grammars with their terminals, sentences and parses.

A grammar is saved, replaced (by its name) and removed as a whole, in one transaction. It keeps the
names and digests of the captures that it was learned from, not their numbers. So the grammar stays
when one of them is removed. When the same content is added again, its digest identifies it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import QueryError
from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.records import MOTION_FPS, IntArray
from motiondb.store.catalogue.names import unknown_name
from motiondb.store.connection.columns import fetch, insert
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction

if TYPE_CHECKING:
    from motiondb.grammar.terminals.terminals import Terminals

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
class LearnedGrammar:
    """The result of ``grammar learn``.

    Attributes
    ----------
    name : str
        Name of the grammar.
    sources : tuple of GrammarSource
        The takes, numbered as in ``terminals.takes``.
    terminals : Terminals
        Segments of the takes and their terminals.
    symbols : array (terminals,)
        The motion symbol from which each terminal was made, -1 where it was made from none.
    grammar : Grammar
        The rules, with their probabilities.
    sentences : array (sentences, 2)
        Segments [first, end) of each sentence. The sentences tile the segments, and no sentence
        spans two takes.
    parses : tuple of tuple of int
        For each sentence the numbers of the rules of its tree, in preorder (``derive_by``).
    bits : mapping of str to float
        Name of each part of the description -> its length, bits.
    run_id : int
        The run that learned the grammar; set when it is saved.
    grammar_id : int
        Number of the grammar in the store; set when it is saved.
    """

    name: str
    sources: tuple[GrammarSource, ...]
    terminals: Terminals
    symbols: IntArray
    grammar: Grammar
    sentences: IntArray
    parses: tuple[tuple[int, ...], ...]
    bits: Mapping[str, float] = field(default_factory=dict)
    run_id: int = 0
    grammar_id: int = 0

    def string(self, first: int, end: int) -> tuple[str, ...]:
        """Return the names of the terminals of segments [first, end)."""
        return tuple(self.terminals.names[k] for k in self.terminals.labels[first:end])

    @property
    def strings(self) -> tuple[tuple[str, ...], ...]:
        """The sentences as strings of terminals."""
        return tuple(self.string(int(a), int(b)) for a, b in self.sentences)


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


def save_grammar(store: Store, learned: LearnedGrammar, run_id: int) -> list[str]:
    """Save a grammar, replacing any grammar of the same name."""
    with transaction(store) as connection:
        lost = _remove(store, learned.name)
        row = connection.execute("SELECT coalesce(max(grammar_id), 0) + 1 FROM grammar").fetchone()
        number = int(row[0]) if row else 1
        connection.execute(
            "INSERT INTO grammar VALUES (?, ?, ?, ?, ?)",
            [
                number,
                learned.name,
                learned.grammar.start,
                None if np.isnan(learned.terminals.objective) else learned.terminals.objective,
                run_id,
            ],
        )
        _insert_terminals(store, learned, number, run_id)
        _insert_rules(store, learned, number, run_id)
    return lost


def _insert_terminals(store: Store, learned: LearnedGrammar, number: int, run_id: int) -> None:
    terminals, connection = learned.terminals, store.connection
    n = len(learned.sources)
    insert(
        connection,
        "grammar_source",
        **_numbered(n, number, run_id, "take"),
        source_name=[source.name for source in learned.sources],
        source_sha256=[source.sha256 for source in learned.sources],
        n_frames=[source.n_frames for source in learned.sources],
    )
    insert(
        connection,
        "terminal",
        **_numbered(len(terminals.names), number, run_id),
        name=list(terminals.names),
        symbol_id=learned.symbols,
    )
    n = len(terminals.takes)
    insert(
        connection,
        "terminal_segment",
        **_numbered(n, number, run_id),
        take=terminals.takes,
        start_frame=terminals.starts,
        end_frame=terminals.ends,
        terminal=terminals.labels,
        is_medoid=np.isin(np.arange(n), terminals.medoids),
    )


def _insert_rules(store: Store, learned: LearnedGrammar, number: int, run_id: int) -> None:
    connection, rules = store.connection, learned.grammar.rules
    for ordinal, rule in enumerate(rules):
        connection.execute(
            "INSERT INTO grammar_rule VALUES (?, ?, ?, ?, ?, ?)",
            [number, ordinal, rule.left, list(rule.right), rule.probability, run_id],
        )
    insert(
        connection,
        "sentence",
        **_numbered(len(learned.sentences), number, run_id),
        first_segment=learned.sentences[:, 0],
        end_segment=learned.sentences[:, 1],
        rules=_lists(learned.parses),
    )
    insert(
        connection,
        "grammar_bits",
        **_numbered(len(learned.bits), number, run_id),
        part=list(learned.bits),
        bits=list(learned.bits.values()),
    )


def _numbered(n: int, grammar_id: int, run_id: int, name: str = "ordinal") -> dict[str, IntArray]:
    return {"grammar_id": np.full(n, grammar_id), name: np.arange(n), "run_id": np.full(n, run_id)}


def _lists(rows: Sequence[Sequence[int]]) -> NDArray[np.object_]:
    column = np.empty(len(rows), dtype=object)
    for number, row in enumerate(rows):
        column[number] = np.asarray(row, dtype=np.int64)
    return column


def load_grammar(store: Store, name: str) -> LearnedGrammar:
    """Load the grammar of this name."""
    row = store.connection.execute(
        "SELECT grammar_id, start_symbol, objective, run_id FROM grammar WHERE name = ?", [name]
    ).fetchone()
    if row is None:
        raise QueryError(_unknown(store, name))
    number, start, objective, run_id = row
    run = store.connection.execute
    sources = run(
        "SELECT source_name, source_sha256, n_frames FROM grammar_source WHERE grammar_id = ? "
        "ORDER BY take",
        [number],
    ).fetchall()
    names = run(
        "SELECT name, symbol_id FROM terminal WHERE grammar_id = ? ORDER BY ordinal", [number]
    ).fetchall()
    rules = run(
        "SELECT left_symbol, right_symbols, probability FROM grammar_rule WHERE grammar_id = ? "
        "ORDER BY ordinal",
        [number],
    ).fetchall()
    sentences = run(
        "SELECT first_segment, end_segment, rules FROM sentence WHERE grammar_id = ? "
        "ORDER BY ordinal",
        [number],
    ).fetchall()
    bits = run(
        "SELECT part, bits FROM grammar_bits WHERE grammar_id = ? ORDER BY ordinal", [number]
    ).fetchall()
    terminals = tuple(name for name, _ in names)
    return LearnedGrammar(
        name,
        tuple(GrammarSource(*source) for source in sources),
        _load_terminals(store, number, terminals, objective),
        np.array([symbol for _, symbol in names], dtype=np.int64),
        Grammar(start, tuple(Rule(left, tuple(right), p) for left, right, p in rules), terminals),
        np.array([row[:2] for row in sentences], dtype=np.int64).reshape(-1, 2),
        tuple(tuple(row[2]) for row in sentences),
        dict(bits),
        run_id,
        number,
    )


def _load_terminals(
    store: Store, number: int, names: tuple[str, ...], objective: float | None
) -> Terminals:
    from motiondb.grammar.terminals.terminals import Terminals

    rows = fetch(
        store.connection,
        "SELECT take, start_frame, end_frame, terminal, is_medoid FROM terminal_segment "
        "WHERE grammar_id = ? ORDER BY ordinal",
        [number],
    )
    medoids = np.full(len(names), -1, dtype=np.int64)
    which = np.flatnonzero(rows["is_medoid"].astype(bool))
    medoids[rows["terminal"][which]] = which
    return Terminals(
        names,
        rows["take"],
        rows["start_frame"],
        rows["end_frame"],
        rows["terminal"],
        medoids,
        np.nan if objective is None else objective,
    )


def load_grammar_names(store: Store) -> list[str]:
    """Load the names of all grammars, in alphabetical order."""
    rows = store.connection.execute("SELECT name FROM grammar ORDER BY name").fetchall()
    return [row[0] for row in rows]


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
        row = connection.execute("SELECT grammar_id FROM grammar WHERE name = ?", [name]).fetchone()
        if row is None:
            return []
        lost = connection.execute(
            "SELECT name FROM derivation JOIN capture USING (capture_id) WHERE grammar_id = ? "
            "ORDER BY name",
            [row[0]],
        ).fetchall()
        for table in TABLES:
            connection.execute(f"DELETE FROM {table} WHERE grammar_id = ?", [row[0]])
    return [capture for (capture,) in lost]


def _unknown(store: Store, name: str) -> str:
    remedy = "Learn one: motiondb grammar learn CAPTURE..."
    return unknown_name(store, name, "grammar", load_grammar_names(store), remedy)


def load_source_numbers(store: Store, learned: LearnedGrammar) -> dict[int, int]:
    """Load the numbers of the captures that a grammar was learned from."""
    known = {
        sha256: (number, n_frames)
        for number, sha256, n_frames in store.connection.execute(
            "SELECT capture_id, sha256, motion_frames FROM capture"
        ).fetchall()
    }
    captures = {take: known.get(source.sha256) for take, source in enumerate(learned.sources)}
    return {
        take: capture[0]
        for take, capture in captures.items()
        if capture is not None and capture[1] == learned.sources[take].n_frames
    }
