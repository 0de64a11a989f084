"""Derivations: how generated captures were derived from grammars, so that they can be edited.

A derivation is removed with its grammar, also when that is learned anew, because numbers of rules
mean nothing in another grammar. The capture stays.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


@dataclass(frozen=True)
class Derivation:
    """The rules of a generated capture's tree, in preorder, and the clip of every leaf."""

    grammar: str
    rules: tuple[int, ...]
    clips: tuple[int, ...]


def save_derivation(
    store: Store, capture_id: int, grammar_id: int, derivation: Derivation, run_id: int
) -> None:
    """Save how a generated capture was derived."""
    with transaction(store) as connection:
        connection.execute(
            "INSERT INTO derivation VALUES (?, ?, ?, ?, ?)",
            [capture_id, grammar_id, list(derivation.rules), list(derivation.clips), run_id],
        )


def load_derivation(store: Store, capture_id: int) -> Derivation | None:
    """Load how a capture was derived; None where no grammar made it."""
    row = store.connection.execute(
        "SELECT name, rules, clips FROM derivation JOIN grammar USING (grammar_id) "
        "WHERE capture_id = ?",
        [capture_id],
    ).fetchone()
    return None if row is None else Derivation(row[0], tuple(row[1]), tuple(row[2]))
