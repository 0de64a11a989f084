"""Find rows that break a rule, and rows that refer to missing rows.

A rule is a sentence and a query that gives the names of the offenders (one text column). A
reference names the table that rows should belong to, and the condition under which a row does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motiondb.store.connection.handle import Store

Rules = Sequence[tuple[str, str]]

FINISHED_RUN = {
    "a finished run": "run_id NOT IN (SELECT run_id FROM run WHERE finished IS NOT NULL)"
}  # The reference of every derived row


def broken_rules(store: Store, rules: Rules, kind: str = "") -> list[str]:
    """Say which rows break rules."""
    return [
        f"{kind}{name}: {rule}, found others."
        for rule, query in rules
        for (name,) in store.connection.execute(query).fetchall()
    ]


def foreign_rows(store: Store, table: str, references: Mapping[str, str]) -> list[str]:
    """Say how many rows of a table belong to something that is not there.

    `references`: What rows should belong to -> the SQL condition of a row that does not.
    """
    faults = []
    for wanted, condition in references.items():
        row = store.connection.execute(f"SELECT count(*) FROM {table} WHERE {condition}").fetchone()
        if row and row[0]:
            faults.append(f"{table}: expected rows of {wanted}, found {row[0]} others.")
    return faults
