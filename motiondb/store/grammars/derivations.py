"""Derivations: how generated captures were derived from grammars, so that they can be edited.

A derivation is removed when its grammar is removed or learned again, because its rule numbers are
valid only in that grammar. The capture stays.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


@dataclass(frozen=True)
class Derivation:
    """The derivation tree of a generated capture, and the clips of its leaves."""

    grammar: str  # Name of the grammar
    rules: tuple[int, ...]  # Numbers of the rules of the tree, in preorder (``derive_by``)
    # For each leaf of the tree, from left to right, the segment of the grammar that plays it
    clips: tuple[int, ...]


def save_derivation(
    store: Store, capture_id: int, grammar_id: int, derivation: Derivation, run_id: int
) -> None:
    """Save the derivation of a generated capture.

    `derivation`: The tree and its clips. Its name of the grammar is not saved; ``grammar_id``
    identifies it.
    """
    with transaction(store) as connection:
        connection.execute(
            "INSERT INTO derivation VALUES (?, ?, ?, ?, ?)",
            [capture_id, grammar_id, list(derivation.rules), list(derivation.clips), run_id],
        )


def load_derivation(store: Store, capture_id: int) -> Derivation | None:
    """Load the derivation of a capture."""
    row = store.connection.execute(
        "SELECT name, rules, clips FROM derivation JOIN grammar USING (grammar_id) "
        "WHERE capture_id = ?",
        [capture_id],
    ).fetchone()
    return None if row is None else Derivation(row[0], tuple(row[1]), tuple(row[2]))
