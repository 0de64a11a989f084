"""Changes of captures, words and synonyms: noted to be undone, and counted in the learned model.

One context manager surrounds every change.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from motiondb import answers, store
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.store import Store


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


def undo(session: Session, run: int | None) -> answers.Undone:
    """Take back the latest change of captures, or that of a run."""
    opened = session.store
    with store.transaction(opened):
        number = store.find_undoable(opened, run)
        kind = store.load_run(opened, number).kind
        edits = store.load_edits(opened, number)
        added, changed, removed = (
            [e for e in edits if e.kind == kind] for kind in ("added", "changed", "removed")
        )
        names = {info.capture_id: info.name for info in store.load_captures(opened)}
        there = [e.capture_id for e in (*added, *changed)]
        if store.SYNONYMS in there:  # they change the words of every capture
            names[store.SYNONYMS] = "synonyms"
            there = [*names]
        parameters = {"run": number, "kind": kind}
        counts = bool(added or removed or store.SYNONYMS in there)
        counts |= any(e.captions is not None for e in changed)
        with changing(opened, store.UNDO, parameters, there, counts) as change:
            store.remove_captures(opened, [edit.capture_id for edit in added])
            renamed = [e for e in changed if names[e.capture_id] != e.name]
            moving = {e.capture_id for e in (*renamed, *added)}
            held = {name for capture, name in names.items() if capture not in moving}
            for edit in renamed:
                if edit.name in held:
                    raise QueryError(
                        f"{edit.name}: expected the name to be free, found another capture. "
                        "Rename or remove that one first."
                    )
            store.rename_captures(opened, {edit.capture_id: edit.name for edit in renamed})
            restored = [edit.capture_id for edit in removed]
            store.restore_captures(opened, restored)
            change.added.extend(restored)
            for edit in changed:
                _restore_parts(opened, edit)
    return answers.Undone(
        change.run_id,
        number,
        kind,
        tuple(e.name for e in removed),
        tuple(names[e.capture_id] for e in added),
        tuple(e.name for e in changed),
    )


def _restore_parts(opened: Store, edit: store.Edit) -> None:
    """Save tags, captions and events as they were before an edit."""
    if edit.capture_id == store.SYNONYMS:
        store.save_synonyms(opened, edit.tags or {})
    elif edit.tags is not None:
        store.save_tags(opened, edit.capture_id, edit.tags)
    if edit.captions is not None:
        store.save_captions(opened, edit.capture_id, edit.captions)
    if edit.events is not None:
        store.save_events(opened, edit.capture_id, edit.events)
