"""Names and tags of captures, the history of their captions, and taking changes back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from motiondb import store
from motiondb.answers.catalogue import CaptionVersion, Undone
from motiondb.database.learn import updating
from motiondb.errors import QueryError, suggestion
from motiondb.files.sheets import tag_fault
from motiondb.records import Caption, CaptureInfo
from motiondb.store import CAPTION, COLUMNS

FOLDER = "/"  # How the name of a folder of captures ends
ANY = "*"  # In a pattern of names: any letters


def rename(
    opened: store.Store, old: str, new: str, among: Iterable[str] | None = None
) -> dict[str, str]:
    """Give captures another name; return old names with new ones.

    `old`: A name, a folder, or a pattern with one ``*``. `among`: None means all captures.
    """
    with store.transaction(opened):
        everyone = {info.name: info for info in store.load_captures(opened)}
        if among is not None:
            chosen = [store.load_capture(opened, name).name for name in among]
            renamed = _names_by_pattern(chosen, old, new)
        elif old.endswith(FOLDER):
            renamed = _folder_names(everyone, old, new)
        elif ANY in old and old not in everyone:
            renamed = _names_by_pattern(everyone, old, new)
        else:
            renamed = {store.load_capture(opened, old).name: new}
        for name in renamed.values():
            store.check_new_name(name, "capture")
            if ANY in name:
                raise QueryError(
                    f"{name!r}: expected a name without {ANY!r}, found one. Nothing was renamed. "
                    f"For a pattern, put one {ANY!r} into the old name too."
                )
            if name in everyone and name not in renamed:
                raise QueryError(
                    f"{name}: expected a name that is free, found a capture of that name. Nothing "
                    f"was renamed. Give another name, or rename that one first."
                )
        changed = {before: after for before, after in renamed.items() if before != after}
        if changed:
            numbers = [everyone[name].capture_id for name in changed]
            with updating.changing(opened, "rename", {"old": old, "new": new}, numbers):
                for number in numbers:  # a new name may be the old one of another
                    store.rename_capture(opened, number, f"//{number}")
                for number, name in zip(numbers, changed.values()):
                    store.rename_capture(opened, number, name)
    return changed


def _folder_names(everyone: Mapping[str, CaptureInfo], old: str, new: str) -> dict[str, str]:
    """The captures of a folder with their names in another one."""
    if new and not new.endswith(FOLDER):
        raise QueryError(
            f"{new!r}: expected a folder, as {old!r} is one, found no {FOLDER!r} at its end. "
            f"Give {new + FOLDER!r}."
        )
    names = [name for name in everyone if name.startswith(old)]
    if not names:
        folders = {n[: n.rindex(FOLDER) + 1] for n in everyone if FOLDER in n}
        raise QueryError(
            f"{old!r}: expected a folder of captures, found none whose name begins so."
            f"{suggestion(old, folders)}"
        )
    return {name: new + name.removeprefix(old) for name in names}


def _names_by_pattern(names: Iterable[str], old: str, new: str) -> dict[str, str]:
    """The names that fit a pattern, with what the other pattern makes of them."""
    for pattern in (old, new):
        if pattern.count(ANY) != 1:
            raise QueryError(
                f"{pattern!r}: expected a pattern with one {ANY!r}, which stands for any letters,"
                f" found {pattern.count(ANY)}. Nothing was renamed."
            )
    (before, after), (head, tail) = old.split(ANY), new.split(ANY)
    least = len(before) + len(after)
    fitting = [
        name
        for name in names
        if name.startswith(before) and name.endswith(after) and len(name) >= least
    ]
    if not fitting:
        raise QueryError(f"{old!r}: expected a pattern of names, found no capture that fits.")
    return {name: head + name[len(before) : len(name) - len(after)] + tail for name in fitting}


def set_tags(
    opened: store.Store, infos: Sequence[CaptureInfo], tags: Mapping[str, str]
) -> list[str]:
    """Set tags of captures, inside a transaction; names of those that have changed."""
    for key in tags:
        fault = tag_fault(key)
        if key in (*COLUMNS, CAPTION):
            fault = "the name of a column of the catalogue"
        if fault:
            raise QueryError(
                f"{key!r}: expected the name of a tag, found {fault}. Choose another name."
            )
    given = {key: value.strip() for key, value in tags.items()}
    for key, value in given.items():
        if not value.isprintable():
            raise QueryError(
                f"{key}: expected a value of characters that can be printed, found {value[:60]!r}."
            )
    changed = []
    for info in infos:
        merged = {k: v for k, v in {**info.tags, **given}.items() if v}
        if merged != info.tags:
            changed.append((info, merged))
    if changed:
        parameters = {"tags": dict(given), "captures": len(changed)}
        run_id = store.start_run(opened, "tags", parameters)
        with store.noting_edits(opened, run_id, [info.capture_id for info, _ in changed]):
            for info, merged in changed:
                store.save_tags(opened, info.capture_id, merged)
        store.finish_run(opened, run_id)
    return [info.name for info, _ in changed]


def add_words(opened: store.Store, infos: Sequence[CaptureInfo], caption: Caption) -> list[str]:
    """Add a caption to captures, inside a transaction; names of those that lacked it."""
    captions = store.load_captions(opened)
    lacking = [info for info in infos if caption not in captions.get(info.capture_id, ())]
    if lacking:
        numbers = [info.capture_id for info in lacking]
        parameters = {"words": caption.words, "captures": len(numbers)}
        with updating.changing(opened, "words", parameters, numbers):
            for number in numbers:
                store.save_captions(opened, number, [*captions.get(number, ()), caption])
    return [info.name for info in lacking]


def undo(opened: store.Store, run: int | None) -> Undone:
    """Take back the latest change of captures, or that of a run, by a run of its own."""
    with store.transaction(opened):
        number = store.find_undoable(opened, run)
        kind = next(r.kind for r in store.load_runs(opened) if r.run_id == number)
        edits = {
            k: [e for e in store.load_edits(opened, number) if e.kind == k]
            for k in ("added", "changed", "removed")
        }
        names = {info.capture_id: info.name for info in store.load_captures(opened)}
        there = [e.capture_id for e in (*edits["added"], *edits["changed"])]
        if store.SYNONYMS in there:  # they change the words of every capture
            names[store.SYNONYMS] = "synonyms"
            there = [*names]
        parameters = {"run": number, "kind": kind}
        with updating.changing(opened, store.UNDO, parameters, there) as change:
            for edit in edits["added"]:
                store.remove_capture(opened, edit.capture_id)
            renamed = [e for e in edits["changed"] if names[e.capture_id] != e.name]
            moving = {e.capture_id for e in (*renamed, *edits["added"])}
            held = {name for capture, name in names.items() if capture not in moving}
            for edit in renamed:
                if edit.name in held:
                    raise QueryError(
                        f"{edit.name}: expected the name to be free, found another capture. "
                        "Rename or remove that one first."
                    )
            for edit in renamed:
                store.rename_capture(opened, edit.capture_id, f"//{edit.capture_id}")
            for edit in renamed:
                store.rename_capture(opened, edit.capture_id, edit.name)
            for edit in edits["removed"]:
                store.restore_capture(opened, edit.capture_id)
                change.added.append(edit.capture_id)
            for edit in edits["changed"]:
                _restore_parts(opened, edit)
    return Undone(
        change.run_id,
        number,
        kind,
        tuple(e.name for e in edits["removed"]),
        tuple(names[e.capture_id] for e in edits["added"]),
        tuple(e.name for e in edits["changed"]),
    )


def _restore_parts(opened: store.Store, edit: store.Edit) -> None:
    """Save tags, captions and events as they were before an edit."""
    if edit.capture_id == store.SYNONYMS:
        store.save_synonyms(opened, edit.tags or {})
    elif edit.tags is not None:
        store.save_tags(opened, edit.capture_id, edit.tags)
    if edit.captions is not None:
        store.save_captions(opened, edit.capture_id, edit.captions)
    if edit.events is not None:
        store.save_events(opened, edit.capture_id, edit.events)


def caption_history(opened: store.Store, name: str) -> list[CaptionVersion]:
    """The captions that a capture has had, oldest first, each with the run that set them."""
    info = store.load_capture(opened, name)
    runs = {run.run_id: run for run in store.load_runs(opened)}
    now = store.load_captions(opened, info.capture_id).get(info.capture_id, ())
    versions = _versions(store.load_edits(opened), info.capture_id, info.run_id, now)
    return [
        CaptionVersion(number, runs[number].kind, runs[number].started, words)
        for number, words in versions
    ]


def _versions(
    edits: list[store.Edit], capture: int, added: int, last: tuple[Caption, ...]
) -> list[tuple[int, tuple[Caption, ...]]]:
    """The runs that set the captions of a capture, with these; first those of what it replaced."""
    own = [e for e in edits if e.capture_id == capture]
    changes = [
        e for e in own if e.captions is not None and e.kind == "changed" and e.run_id > added
    ]
    words = [*(edit.captions or () for edit in changes), last]
    versions = list(zip([added, *(edit.run_id for edit in changes)], words))
    names = {e.name for e in own if e.kind == "added" and e.run_id == added}
    replaced = [e for e in edits if e.kind == "removed" and e.run_id == added and e.name in names]
    for old in replaced:
        since = [e.run_id for e in edits if e.capture_id == old.capture_id and e.kind == "added"]
        begun = max((run for run in since if run < added), default=0)
        if begun:
            versions = _versions(edits, old.capture_id, begun, old.captions or ()) + versions
    return versions
