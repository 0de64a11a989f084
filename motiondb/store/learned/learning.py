"""Everything that ``learn`` derives: replaced in one transaction, loaded whole or in parts.

Arrays come back equal to the last bit (NaN as NaN). A kill leaves the former model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.errors import NotLearnedError
from motiondb.records import (
    Association,
    FloatArray,
    MotionSymbols,
    SegmentTable,
    StoredLearning,
    SymbolSpace,
)
from motiondb.store.catalogue.runs import finish_run
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import content_revision, transaction
from motiondb.store.learned import segment_tables, symbol_tables, word_tables

DERIVED_TABLES = (
    "learning",
    *segment_tables.TABLES,
    *symbol_tables.TABLES,
    *word_tables.TABLES,
)


@dataclass(frozen=True)
class LearningSize:
    """The row of the table ``learning``: run, content that it was learned from, sizes."""

    run_id: int
    content_revision: str
    n_symbols: int
    max_states: int
    n_features: int
    n_coordinates: int
    n_clusters: int
    n_words: int


def save_learning(store: Store, learning: StoredLearning) -> None:
    """Replace everything derived by ``learning`` and finish its run, in one transaction."""
    run_id, symbols, space = learning.run_id, learning.symbols, learning.space
    with transaction(store) as connection:
        for table in DERIVED_TABLES:
            connection.execute(f"DELETE FROM {table}")
        connection.execute(
            "INSERT INTO learning VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            [
                run_id,
                content_revision(store),
                symbols.n_symbols,
                *symbols.means.shape[1:],
                space.coordinates.shape[1],
                len(space.weights),
                len(learning.association.words),
            ],
        )
        symbol_tables.insert_symbols(connection, symbols, space, run_id)
        symbol_tables.insert_space(connection, space, run_id)
        segment_tables.insert_segments(connection, learning.segments, run_id)
        word_tables.insert_association(connection, learning.association, run_id)
        word_tables.insert_transitions(connection, learning.transition_counts, run_id)
        word_tables.insert_parameters(connection, learning.parameters, run_id)
        finish_run(store, run_id)


def load_learning(store: Store, *, segments: bool = True, scores: bool = True) -> StoredLearning:
    """Load everything that was learned."""
    size = load_learning_size(store)
    empty = np.zeros(0, dtype=np.int64), np.zeros(0)
    none = SegmentTable(
        empty[0], empty[0], empty[0], empty[0], empty[1], empty[1], np.zeros((0, 0), np.float32)
    )
    return StoredLearning(
        size.run_id,
        load_symbols(store),
        load_segments(store, scores=scores) if segments else none,
        load_space(store),
        load_association(store),
        load_transition_counts(store),
        load_parameters(store),
    )


def load_learning_size(store: Store) -> LearningSize:
    """Load sizes and run of the learned model."""
    row = store.connection.execute("SELECT * FROM learning").fetchone()
    if row is None:
        raise NotLearnedError(
            f"{store.path}: expected motion symbols, found none. "
            f"Run motiondb learn --db {store.path} first."
        )
    return LearningSize(*row)


def is_learned(store: Store) -> bool:
    """Whether ``learn`` has run."""
    return store.connection.execute("SELECT 1 FROM learning").fetchone() is not None


def learning_is_current(store: Store) -> bool:
    """Whether no capture, word or synonym has changed since ``learn``."""
    return load_learning_size(store).content_revision == content_revision(store)


def load_symbols(store: Store) -> MotionSymbols:
    """Load the motion symbols."""
    size = load_learning_size(store)
    return symbol_tables.select_symbols(store.connection, size.max_states, size.n_features)


def load_segments(store: Store, *, scores: bool = True) -> SegmentTable:
    """Load the segments; without ``scores`` that array has no columns."""
    size = load_learning_size(store)
    return segment_tables.select_segments(store.connection, size.n_symbols, scores)


def load_space(store: Store) -> SymbolSpace:
    """Load the symbol space."""
    size = load_learning_size(store)
    return symbol_tables.select_space(store.connection, size.n_coordinates)


def load_association(store: Store) -> Association:
    """Load the association of symbols and words."""
    size = load_learning_size(store)
    return word_tables.select_association(store.connection, size.n_symbols)


def load_transition_counts(store: Store) -> FloatArray:
    """Load how often symbols follow one another: array (symbols + 1, symbols + 1)."""
    size = load_learning_size(store)
    return word_tables.select_transitions(store.connection, size.n_symbols)


def load_parameters(store: Store, *names: str) -> dict[str, FloatArray | str]:
    """Load further values by name: those of these names and below them ("NAME.x"), or all."""
    load_learning_size(store)
    return word_tables.select_parameters(store.connection, names or None)
