"""The verbs that change captures: in and out, their names, tags and words, and back again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers, store
from motiondb.database.arguments import checked_verbs
from motiondb.errors import QueryError, suggestion
from motiondb.records import Caption, CaptureInfo
from motiondb.store import CAPTION, COLUMNS, Store

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from motiondb.database.catalogue import cataloguing, sheets
    from motiondb.database.cluster import Cluster
    from motiondb.database.generated_files import Made
    from motiondb.database.learn import updating
    from motiondb.database.session import Session

FOLDER = "/"  # How the name of a folder of captures ends
ANY = "*"  # In a pattern of names: any letters


@checked_verbs
class Archive:
    """What changes the captures of a database.

    ``name`` is the name of a capture, and ``names`` several. ``where`` is a filter on columns and
    tags of the catalogue, such as "performer=14"; a method with both takes the captures of either.
    ``start`` and ``end`` are the part of a capture, in seconds. ``progress`` is called with the
    name of the step, the number done, and the total number. QueryError is raised where there is no
    such capture, a filter cannot be read, or a part lies outside its capture, and another
    MotionDBError where a file cannot be read or written; nothing is changed then.

    Parameters
    ----------
    session : Session
        The open database.
    """

    def __init__(self, session: Session) -> None:
        self.session = session

    @property
    def store(self) -> Store:
        """The open store."""
        return self.session.store

    @property
    def damage_note(self) -> str:
        """Which captures the answers so far left out, as their motions cannot be read; else ""."""
        return self.session.damage_note

    def add(
        self,
        folder: str | Path | Sequence[str | Path],
        words: str | Path | None = None,
        settings: cataloguing.AddSettings | None = None,
        progress: cataloguing.Progress | None = None,
        events: str | Path | None = None,
        workers: Cluster | None = None,
    ) -> answers.AddReport:
        """Add captures: files, and all captures below folders.

        Broken files are left out and reported; a file whose content is there already changes
        nothing.

        Parameters
        ----------
        folder : str, Path, or sequence of these
            Files and folders. A capture is named by its path below its folder.
        words : str or Path, optional
            Sheet of words and tags, TSV or CSV.
        settings : AddSettings, optional
            How files are read and named, and whether they replace captures.
        events : str or Path, optional
            Sheet of events, TSV or CSV.
        workers : Cluster, optional
            Who reads and compares; the files' bytes are sent to it. None: processes of this machine
            (``settings.jobs``).

        Raises
        ------
        MotionDBError
            When there are no captures to add, or a sheet cannot be read.
        """
        from motiondb.database.catalogue import cataloguing, sheets
        from motiondb.files.sheets import read_event_sheet, read_sheet

        given = sheets.Sheets(
            read_sheet(words) if words is not None else None,
            read_event_sheet(events) if events is not None else None,
        )
        folders = [folder] if isinstance(folder, str | Path) else folder
        return cataloguing.add_captures(
            self.store,
            [Path(each) for each in folders],
            given,
            settings or cataloguing.AddSettings(),
            progress,
            workers,
        )

    def save_generated(self, name: str, words: str, made: Made, seed: int) -> CaptureInfo:
        """Keep a generated motion as a capture, with the origin of every frame."""
        from motiondb.database.generated_files import keep_generated

        opened, captions = self.store, [Caption(words)]
        with (
            store.running(opened, "generate", {"words": words}, seed) as run_id,
            store.noting_edits(opened, run_id),
        ):
            return keep_generated(opened, name, made.motion, made.provenance, captions, run_id)

    def check_name_free(self, name: str) -> None:
        """Refuse a name that is empty, or that a capture has already."""
        from motiondb.database.catalogue.cataloguing import check_name_free

        check_name_free(self.store, name)

    def remove(self, names: Iterable[str] = (), where: str = "") -> list[str]:
        """Remove captures, all or none, and return their full names.

        Their counts are removed from the learned model. :meth:`undo` brings them back until the
        file is compacted.
        """
        from motiondb.database.learn import updating

        with store.transaction(self.store):
            infos = self._chosen(names, where)
            numbers = [info.capture_id for info in infos]
            parameters = {"names": [info.name for info in infos]}
            if numbers:
                with updating.changing(self.store, "remove", parameters, numbers):
                    for number in numbers:
                        store.remove_capture(self.store, number)
        return [info.name for info in infos]

    def _chosen(self, names: Iterable[str], where: str) -> list[CaptureInfo]:
        """The captures of some names, and those that match a filter; each once."""
        infos = [store.load_capture(self.store, name) for name in names]
        infos += store.load_captures(self.store, where) if where.strip() else []
        return list({info.capture_id: info for info in infos}.values())

    def merge(
        self,
        other: str | Path,
        prefix: str = "",
        wait: float = 0.0,
        progress: cataloguing.Progress | None = None,
    ) -> answers.MergeReport:
        """Take over the captures of another database with their words, tags and provenance.

        The other one is only read. A capture of the same content gets the words, tags and events
        that it lacks here. What is not taken over is named in the notes of the result.

        Parameters
        ----------
        prefix : str
            Put before the name of every new capture, such as "studio2/".
        wait : float
            Seconds to wait for another process that holds the other database.
        """
        from motiondb.database.catalogue import merging

        return merging.merge(self.store, Path(other), prefix, wait, progress)

    @staticmethod
    def check_merge(other: str | Path, prefix: str = "", wait: float = 0.0) -> None:
        """Refuse what :meth:`merge` would refuse, before a database is made for it."""
        from motiondb.database.catalogue import merging

        merging.check(Path(other), prefix, wait)

    def rename(self, old: str, new: str, captures: Iterable[str] | None = None) -> dict[str, str]:
        """Give a capture another name, or several that fit a pattern; return old and new names.

        ``rename("walk_*", "ana/walk_*")`` puts a folder before all names that begin with "walk_".

        Parameters
        ----------
        old : str
            Name of a capture; ending in ``/``: of a folder, such as ``studio1/``; or a pattern
            with one ``*``, which stands for any letters.
        new : str
            The new name; of a folder if ``old`` is one. "" for a folder: none. For a pattern:
            another one, whose ``*`` is what stood there before.
        captures : iterable of str, optional
            Names of the captures among which the pattern looks. None means all captures.

        Raises
        ------
        QueryError
            Also when a new name is not free or cannot be one.
        """
        from motiondb.database.learn import updating

        opened = self.store
        with store.transaction(opened):
            everyone = {info.name: info for info in store.load_captures(opened)}
            if captures is not None:
                chosen = [store.load_capture(opened, name).name for name in captures]
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
                        f"{name!r}: expected a name without {ANY!r}, found one. Nothing was "
                        f"renamed. For a pattern, put one {ANY!r} into the old name too."
                    )
                if name in everyone and name not in renamed:
                    raise QueryError(
                        f"{name}: expected a name that is free, found a capture of that name. "
                        f"Nothing was renamed. Give another name, or rename that one first."
                    )
            changed = {before: after for before, after in renamed.items() if before != after}
            if changed:
                numbers = {everyone[name].capture_id: new for name, new in changed.items()}
                with updating.changing(opened, "rename", {"old": old, "new": new}, numbers, False):
                    _rename(opened, numbers)
        return changed

    def undo(self, run: int | None = None) -> answers.Undone:
        """Take back the latest change of captures that was not taken back, or that of a run.

        What can be undone: ``add``, ``remove``, ``rename``, ``merge``, changes of words, tags and
        events, kept generated motion, and an ``undo``. Compacting the file makes removals final.
        If the database has learned, captures that come back are cut and counted as new ones are.

        Parameters
        ----------
        run : int, optional
            Number of the run, as :meth:`runs` lists them.

        Raises
        ------
        QueryError
            When there is nothing to undo, the run cannot be undone, a later one has changed the
            same captures, or the trash was emptied.
        """
        from motiondb.database.learn import updating

        opened = self.store
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
                _rename(opened, {edit.capture_id: edit.name for edit in renamed})
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

    def set_tags(
        self, tags: Mapping[str, str], names: Iterable[str] = (), where: str = ""
    ) -> list[str]:
        """Set tags, such as the performer and the licence; return the captures that have changed.

        Parameters
        ----------
        tags : mapping of str to str
            Tag -> value; "" removes the tag. Others stay.

        Raises
        ------
        QueryError
            Also when a tag has a name that a column of sheets or of the catalogue has.
        """
        from motiondb.files.sheets import tag_fault

        with store.transaction(self.store):
            infos = self._chosen(names, where)
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
                        f"{key}: expected a value of characters that can be printed, found "
                        f"{value[:60]!r}."
                    )
            every = [(i, {k: v for k, v in {**i.tags, **given}.items() if v}) for i in infos]
            changed = [(info, merged) for info, merged in every if merged != info.tags]
            if changed:
                parameters = {"tags": dict(given), "captures": len(changed)}
                numbers = [info.capture_id for info, _ in changed]
                with (
                    store.running(self.store, "tags", parameters) as run_id,
                    store.noting_edits(self.store, run_id, numbers),
                ):
                    for info, merged in changed:
                        store.save_tags(self.store, info.capture_id, merged)
        return [info.name for info, _ in changed]

    def add_words(self, words: str, names: Iterable[str] = (), where: str = "") -> list[str]:
        """Add a caption of the whole capture, and count it.

        Returns the names of the captures that did not have it.
        """
        from motiondb.database.learn import updating

        caption = Caption(words)
        with store.transaction(self.store):
            infos = self._chosen(names, where)
            for info in infos:
                _check_caption(info, caption)
            captions = store.load_captions(self.store)
            lacking = [info for info in infos if caption not in captions.get(info.capture_id, ())]
            if lacking:
                numbers = [info.capture_id for info in lacking]
                parameters = {"words": caption.words, "captures": len(numbers)}
                with updating.changing(self.store, "words", parameters, numbers):
                    for number in numbers:
                        rows = [*captions.get(number, ()), caption]
                        store.save_captions(self.store, number, rows)
        return [info.name for info in lacking]

    def tag_rows(self) -> list[answers.TagRow]:
        """Every tag with its number of captures and of different values, by name."""
        with self.session.reading():
            values: dict[str, list[str]] = {}
            for info in store.load_captures(self.store):
                for key, value in info.tags.items():
                    values.setdefault(key, []).append(value)
        return [answers.TagRow(key, len(of), len(set(of))) for key, of in sorted(values.items())]

    def faulty_files(self) -> list[answers.FaultyFile]:
        """The files that could not be read when they were added, until they are without fault."""
        with self.session.reading():
            return [answers.FaultyFile(*row) for row in store.load_faulty(self.store)]

    def same_files(self) -> list[answers.SameFile]:
        """The files that were added although a capture of another name has their content."""
        with self.session.reading():
            return [answers.SameFile(*row) for row in store.load_same_files(self.store)]

    def caption_history(self, name: str) -> list[answers.CaptionVersion]:
        """The captions that a capture has had, oldest first, with the runs that set them."""
        with self.session.reading():
            info = store.load_capture(self.store, name)
            runs = {run.run_id: run for run in store.load_runs(self.store)}
            now = store.load_captions(self.store, [info.capture_id]).get(info.capture_id, ())
            edits = store.load_edits(self.store)
        return [
            answers.CaptionVersion(number, runs[number].kind, runs[number].started, words)
            for number, words in _versions(edits, info.capture_id, info.run_id, now)
        ]

    def export_words(self, path: str | Path, where: str = "") -> answers.SheetWritten:
        """Write captions and tags as a sheet that ``import_words`` reads again without loss.

        It is CSV for the ending .csv, else TSV.
        """
        from motiondb.database.catalogue import sheets

        with self.session.reading():
            return sheets.export_words(self.store, path, where)

    def import_words(self, sheet: str | Path) -> sheets.ImportReport:
        """Replace words and tags by those of a sheet; captures without words in it keep theirs."""
        from motiondb.database.catalogue import sheets

        return sheets.import_words(self.store, sheet)

    def import_events(self, sheet: str | Path) -> sheets.EventReport:
        """Replace the events of the captures that a sheet (TSV or CSV) names."""
        from motiondb.database.catalogue import sheets

        return sheets.import_events(self.store, sheet)

    def set_words(
        self,
        name: str,
        words: str,
        start: float | None = None,
        end: float | None = None,
        keep: bool = False,
    ) -> updating.Change:
        """Set the caption of a capture, or of a part of it, and count it.

        ``keep`` keeps the captions that are there. Words that are new to the vocabulary are counted
        at the next ``learn``.
        """
        return self._save_captions(name, [Caption(words, start, end)], keep)

    def set_captions(self, name: str, captions: Iterable[Caption]) -> updating.Change:
        """Replace all captions of a capture, and count them; none removes those that are there."""
        return self._save_captions(name, list(captions), keep=False)

    def _save_captions(self, name: str, new: list[Caption], keep: bool) -> updating.Change:
        """Save captions of a capture, in place of those there, or after them (``keep``)."""
        from motiondb.database.learn import updating

        with store.transaction(self.store):
            info = store.load_capture(self.store, name)
            for caption in new:
                _check_caption(info, caption)
            number = info.capture_id
            old = store.load_captions(self.store, [number]).get(number, ()) if keep else ()
            parameters = {"name": info.name, "words": "; ".join(c.words for c in new)}
            with updating.changing(self.store, "words", parameters, [number]) as change:
                store.save_captions(self.store, number, [*old, *new])
        return change

    def set_synonyms(self, path: str | Path) -> Mapping[str, str]:
        """Replace the synonyms for captions and questions: a file of ``word = canonical``."""
        from motiondb.database.learn import updating
        from motiondb.files.safe_files import read_user_text
        from motiondb.language.vocabulary import parse_synonyms

        text = read_user_text(Path(path), "a file of synonyms")
        table = parse_synonyms(text, str(path))
        with store.transaction(self.store):
            every = [info.capture_id for info in store.load_captures(self.store)]
            touched = [store.SYNONYMS, *every]
            with updating.changing(self.store, "words", {"synonyms": str(path)}, touched):
                store.save_synonyms(self.store, table)
        return table


def _check_caption(info: CaptureInfo, caption: Caption) -> None:
    """Refuse a caption without words, or of an interval outside its capture (QueryError)."""
    from motiondb.database.catalogue.parts import outside

    first, last = caption.start or 0.0, info.duration if caption.end is None else caption.end
    if not 0.0 <= first < last <= info.duration + 1.0:
        raise QueryError(f"{info.name}: {outside(info.duration, caption.start, caption.end)}")
    if not caption.words.strip():
        raise QueryError(f"{info.name}: expected words, found none. Say what it shows.")


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


def _rename(opened: Store, names: Mapping[int, str]) -> None:
    """Rename captures by their numbers; a new name may be the old one of another."""
    for number in names:
        store.rename_capture(opened, number, f"//{number}")
    for number, name in names.items():
        store.rename_capture(opened, number, name)


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
