"""What every check of a group of tables asks: rows that break a rule, and rows of something else.

A rule is a sentence and a query for the offenders' names (one text column). A reference is what
rows should belong to, and the condition under which one does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motiondb.store.connection.handle import Store

Rules = Sequence[tuple[str, str]]

FINISHED_RUN = {
    "a finished run": "run_id NOT IN (SELECT run_id FROM run WHERE finished IS NOT NULL)"
}
"""The reference that every derived row has."""


def broken_rules(store: Store, rules: Rules, kind: str = "") -> list[str]:
    """A sentence for every offender, ``kind``, such as "grammar ", before its name."""
    return [
        f"{kind}{name}: {rule}, found others."
        for rule, query in rules
        for (name,) in store.connection.execute(query).fetchall()
    ]


def foreign_rows(store: Store, table: str, references: Mapping[str, str]) -> list[str]:
    """A sentence for every reference that rows of ``table`` do not keep."""
    faults = []
    for wanted, condition in references.items():
        row = store.connection.execute(f"SELECT count(*) FROM {table} WHERE {condition}").fetchone()
        if row and row[0]:
            faults.append(f"{table}: expected rows of {wanted}, found {row[0]} others.")
    return faults
