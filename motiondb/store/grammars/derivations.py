"""How generated captures were derived from grammars, so that they can be edited.

A derivation goes with its grammar: one that is learned anew or removed takes it along, for numbers
of rules mean nothing in another grammar. The capture stays.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


@dataclass(frozen=True)
class Derivation:
    """How a generated capture came about: its tree's rules in preorder, and per leaf the clip."""

    grammar: str
    rules: tuple[int, ...]
    clips: tuple[int, ...]


def save_derivation(
    store: Store, capture_id: int, grammar_id: int, derivation: Derivation, run_id: int
) -> None:
    """Write down how a generated capture was derived."""
    with transaction(store) as connection:
        connection.execute(
            "INSERT INTO derivation VALUES (?, ?, ?, ?, ?)",
            [capture_id, grammar_id, list(derivation.rules), list(derivation.clips), run_id],
        )


def load_derivation(store: Store, capture_id: int) -> Derivation | None:
    """How a capture was derived; None where no grammar made it."""
    row = store.connection.execute(
        "SELECT name, rules, clips FROM derivation JOIN grammar USING (grammar_id) "
        "WHERE capture_id = ?",
        [capture_id],
    ).fetchone()
    return None if row is None else Derivation(row[0], tuple(row[1]), tuple(row[2]))
