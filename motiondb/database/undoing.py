"""What ``undo`` does: captures, names, tags, captions and events as they were before a run."""

from __future__ import annotations

from motiondb import answers, store
from motiondb.database.learn import updating
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.store import Store


def undo(session: Session, run: int | None) -> answers.Undone:
    """Take back the latest change of captures, or that of a run."""
    opened = session.store
    with store.transaction(opened):
        number = store.find_undoable(opened, run)
        kind = next(r.kind for r in store.load_runs(opened) if r.run_id == number)
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
        with updating.changing(opened, store.UNDO, parameters, there, counts) as change:
            for edit in added:
                store.remove_capture(opened, edit.capture_id)
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
            for edit in removed:
                store.restore_capture(opened, edit.capture_id)
                change.added.append(edit.capture_id)
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
