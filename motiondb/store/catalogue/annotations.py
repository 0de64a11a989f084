"""Tags and captions of captures, and the user's synonyms.

People write these. Each function that saves them replaces the whole set.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from motiondb.records import Caption
from motiondb.store.connection.columns import insert
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import touch, transaction


def save_tags(store: Store, capture_id: int, tags: Mapping[str, str]) -> None:
    """Replace all tags of a capture."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM capture_tag WHERE capture_id = ?", [capture_id])
        insert(
            connection,
            "capture_tag",
            capture_id=[capture_id] * len(tags),
            key=list(tags),
            value=[str(value) for value in tags.values()],
        )


def save_captions(store: Store, capture_id: int, captions: Iterable[Caption]) -> None:
    """Replace all captions of a capture.

    The learned model is then no longer current (``learning_is_current``).
    """
    rows = list(captions)
    with transaction(store) as connection:
        connection.execute("DELETE FROM caption WHERE capture_id = ?", [capture_id])
        insert(
            connection,
            "caption",
            capture_id=[capture_id] * len(rows),
            ordinal=list(range(len(rows))),
            start_s=np.array([row.start for row in rows], dtype=float),  # None becomes NaN: NULL
            end_s=np.array([row.end for row in rows], dtype=float),
            words=[row.words for row in rows],
        )
        touch(store)


def load_captions(store: Store, capture_id: int | None = None) -> dict[int, tuple[Caption, ...]]:
    """Load the captions of one capture or of all captures."""
    some = "" if capture_id is None else "WHERE capture_id = ?"
    rows = store.connection.execute(
        "SELECT capture_id, words, start_s, end_s FROM caption "
        f"{some} ORDER BY capture_id, ordinal",
        [] if capture_id is None else [capture_id],
    ).fetchall()
    captions: dict[int, list[Caption]] = {}
    for number, words, start, end in rows:
        captions.setdefault(number, []).append(Caption(words, start, end))
    return {number: tuple(of_one) for number, of_one in captions.items()}


def save_synonyms(store: Store, synonyms: Mapping[str, str]) -> None:
    """Replace the user's synonyms.

    The learned model is then no longer current (``learning_is_current``).
    """
    with transaction(store) as connection:
        connection.execute("DELETE FROM synonym")
        insert(connection, "synonym", word=list(synonyms), canonical=list(synonyms.values()))
        touch(store)


def load_synonyms(store: Store) -> dict[str, str]:
    """Load the user's synonyms."""
    rows = store.connection.execute("SELECT word, canonical FROM synonym ORDER BY word").fetchall()
    return dict(rows)
