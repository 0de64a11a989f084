"""Changes of captures, words and synonyms: noted to be undone, and counted in the learned model.

One context manager surrounds every change.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from motiondb import store


@dataclass
class Change:
    """The result of counting a change of captures or words."""

    run_id: int  # The run that makes the change; ``undo`` takes it back
    # Numbers of the captures that the body of :func:`counted` adds; filled by the body
    added: list[int] = field(default_factory=list)
    counted: tuple[int, ...] = ()  # Numbers of the captures that were counted after the change
    # Words in their captions that the vocabulary lacks; the next ``learn`` counts them
    new_words: tuple[str, ...] = ()


@contextmanager
def changing(
    opened: store.Store,
    kind: str,
    parameters: Mapping[str, object],
    touched: Iterable[int] = (),
    counts: bool = True,
) -> Iterator[Change]:
    """A transaction with a separate run around :func:`counted`."""
    with (
        store.running(opened, kind, parameters) as run_id,
        counted(opened, run_id, touched, counts) as change,
    ):
        yield change


@contextmanager
def counted(
    opened: store.Store, run_id: int, touched: Iterable[int] = (), counts: bool = True
) -> Iterator[Change]:
    """Surround a change of captures or words, inside a transaction, so that counts stay true.

    What was changed is noted, so that it can be undone. Nothing is counted if the database has not
    learned, or if names and tags alone change (``counts`` is False).
    """
    change, wanted = Change(run_id), set(touched)
    with store.noting_edits(opened, run_id, wanted):
        if not (counts and store.is_learned(opened)):
            yield change
            return
        from motiondb.database.learn.recounting import recounted  # loads much of learning

        with recounted(opened, change, wanted):
            yield change
