"""The verbs that change captures: in and out, their names, tags and words, and back again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.errors import QueryError
from motiondb.records import Caption, CaptureInfo
from motiondb.store import Store

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from motiondb.answers.catalogue import (
        AddReport,
        CaptionVersion,
        FaultyFile,
        MergeReport,
        SameFile,
        SheetWritten,
        TagRow,
        Undone,
    )
    from motiondb.database.catalogue import cataloguing, sheets
    from motiondb.database.cluster import Cluster
    from motiondb.database.generated_files import Made
    from motiondb.database.learn import updating
    from motiondb.database.session import Session


class Archive:
    """What changes the captures of a database.

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

    def add(
        self,
        folder: str | Path | Sequence[str | Path],
        words: str | Path | None = None,
        settings: cataloguing.AddSettings | None = None,
        progress: cataloguing.Progress | None = None,
        events: str | Path | None = None,
        workers: Cluster | None = None,
    ) -> AddReport:
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
        progress : callable, optional
            Called with the name of the step, the number done, and the total number.
        events : str or Path, optional
            Sheet of events, TSV or CSV.
        workers : Workers, optional
            Who reads and compares: a :class:`motiondb.Cluster`, to which the files' bytes are
            sent. None: processes of this machine (``settings.jobs``).

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
        """Keep a generated motion as a capture, with the origin of every frame.

        Parameters
        ----------
        name : str
            Name of the new capture.
        words : str
            Its caption.
        made : Generated
            The motion.
        seed : int
            Seed that the run names.
        """
        from motiondb.database.generated_files import keep_generated

        with store.transaction(self.store):
            run_id = store.start_run(self.store, "generate", {"words": words}, seed)
            captions = [Caption(words)]
            with store.noting_edits(self.store, run_id):
                info = keep_generated(
                    self.store, name, made.motion, made.provenance, captions, run_id
                )
            store.finish_run(self.store, run_id)
        return info

    def check_name_free(self, name: str) -> None:
        """Refuse a name that a capture has already.

        Raises
        ------
        QueryError
            When the name is empty or taken.
        """
        from motiondb.database.catalogue.cataloguing import check_name_free

        check_name_free(self.store, name)

    def remove(self, names: Iterable[str] = (), where: str = "") -> list[str]:
        """Remove captures, all or none; their counts are removed from the learned model.

        :meth:`undo` brings them back until the file is compacted.

        Parameters
        ----------
        names : iterable of str
            Names of captures.
        where : str
            Filter on the catalogue: also remove these.

        Returns
        -------
        list of str
            Full names of the captures removed.

        Raises
        ------
        QueryError
            When there is no capture of one of the names, or the filter cannot be read.
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
    ) -> MergeReport:
        """Take over the captures of another database with their words, tags and provenance.

        A capture of the same content gets the words, tags and events that it lacks here. What is
        not taken over is named in the notes of the result.

        Parameters
        ----------
        other : str or Path
            The other database, which is only read.
        prefix : str
            Put before the name of every new capture, such as "studio2/".
        wait : float
            Seconds to wait for another process that holds the other database.
        progress : callable, optional
            Called with the name of the step, the number done, and the total number.

        Raises
        ------
        MotionDBError
            When the other database cannot be opened, or is this one.
        """
        from motiondb.database.catalogue import merging

        return merging.merge(self.store, Path(other), prefix, wait, progress)

    @staticmethod
    def check_merge(other: str | Path, prefix: str = "", wait: float = 0.0) -> None:
        """Refuse what :meth:`merge` would refuse, before a database is made for it.

        Parameters
        ----------
        other : str or Path
            The other database.
        prefix : str
            Put before the name of every new capture.
        wait : float
            Seconds to wait for another process that holds the other database.

        Raises
        ------
        MotionDBError
            When the other database cannot be opened, or no name can begin so.
        """
        from motiondb.database.catalogue import merging

        merging.check(Path(other), prefix, wait)

    def rename(self, old: str, new: str, captures: Iterable[str] | None = None) -> dict[str, str]:
        """Give a capture another name, or several captures that fit a pattern.

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

        Returns
        -------
        dict of str to str
            Old name -> new name of every capture that was renamed.

        Raises
        ------
        QueryError
            When there is no such capture, or a new name is not free or cannot be one.
        """
        from motiondb.database.catalogue import editing

        return editing.rename(self.store, old, new, captures)

    def undo(self, run: int | None = None) -> Undone:
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
        from motiondb.database.catalogue import editing

        return editing.undo(self.store, run)

    def set_tags(
        self, tags: Mapping[str, str], names: Iterable[str] = (), where: str = ""
    ) -> list[str]:
        """Set tags of captures, such as the performer and the licence; others stay.

        Parameters
        ----------
        tags : mapping of str to str
            Tag -> value; "" removes the tag.
        names : iterable of str
            Names of captures.
        where : str
            Filter on the catalogue: also these.

        Returns
        -------
        list of str
            Names of the captures whose tags have changed.

        Raises
        ------
        QueryError
            When there is no capture of one of the names, the filter cannot be read, or a tag has a
            name that a column of sheets or of the catalogue has.
        """
        from motiondb.database.catalogue import editing

        with store.transaction(self.store):
            infos = self._chosen(names, where)
            return editing.set_tags(self.store, infos, tags)

    def add_words(self, words: str, names: Iterable[str] = (), where: str = "") -> list[str]:
        """Add a caption to several captures by one run, and count it; others stay.

        Parameters
        ----------
        words : str
            What each of the captures shows as a whole.
        names : iterable of str
            Names of captures.
        where : str
            Filter on the catalogue: also these.

        Returns
        -------
        list of str
            Names of the captures that did not have the caption.

        Raises
        ------
        QueryError
            When there is no capture of one of the names, the filter cannot be read, or there is no
            word.
        """
        from motiondb.database.catalogue import editing

        caption = Caption(words)
        with store.transaction(self.store):
            infos = self._chosen(names, where)
            for info in infos:
                _check_caption(info, caption)
            return editing.add_words(self.store, infos, caption)

    def tag_rows(self) -> list[TagRow]:
        """Every tag with its number of captures and of different values, by name."""
        from motiondb.answers.catalogue import TagRow

        with self.session.reading():
            values: dict[str, list[str]] = {}
            for info in store.load_captures(self.store):
                for key, value in info.tags.items():
                    values.setdefault(key, []).append(value)
        return [TagRow(key, len(of), len(set(of))) for key, of in sorted(values.items())]

    def faulty_files(self) -> list[FaultyFile]:
        """The files that could not be read when they were added, until they are without fault."""
        from motiondb.answers.catalogue import FaultyFile

        with self.session.reading():
            return [FaultyFile(*row) for row in store.load_faulty(self.store)]

    def same_files(self) -> list[SameFile]:
        """The files that were added although a capture of another name has their content."""
        from motiondb.answers.catalogue import SameFile

        with self.session.reading():
            return [SameFile(*row) for row in store.load_same_files(self.store)]

    def caption_history(self, name: str) -> list[CaptionVersion]:
        """The captions that a capture has had, oldest first, with the runs that set them.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database.catalogue import editing

        with self.session.reading():
            return editing.caption_history(self.store, name)

    def export_words(self, path: str | Path, where: str = "") -> SheetWritten:
        """Write captions and tags as a sheet that ``import_words`` reads again without loss.

        Parameters
        ----------
        path : str or Path
            The sheet: CSV for the ending .csv, else TSV.
        where : str
            Filter on the catalogue.

        Raises
        ------
        MotionDBError
            When the filter cannot be read, or the file cannot be written.
        """
        from motiondb.database.catalogue import sheets

        with self.session.reading():
            return sheets.export_words(self.store, path, where)

    def import_words(self, sheet: str | Path) -> sheets.ImportReport:
        """Replace words and tags by those of a sheet; captures without words in it keep theirs.

        Parameters
        ----------
        sheet : str or Path
            TSV or CSV.
        """
        from motiondb.database.catalogue import sheets

        return sheets.import_words(self.store, sheet)

    def import_events(self, sheet: str | Path) -> sheets.EventReport:
        """Replace the events of the captures that a sheet names.

        Parameters
        ----------
        sheet : str or Path
            TSV or CSV.
        """
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

        Words that are new to the vocabulary are counted at the next ``learn``.

        Parameters
        ----------
        name : str
            Name of the capture.
        words : str
            What it shows.
        start : float, optional
            Start of the part of the capture, seconds.
        end : float, optional
            End of the part of the capture, seconds.
        keep : bool
            Add to the captions that are there instead of replacing them.

        Raises
        ------
        QueryError
            When there is no such capture, no word, or the part lies outside the capture.
        """
        return self._save_captions(name, [Caption(words, start, end)], keep)

    def set_captions(self, name: str, captions: Iterable[Caption]) -> updating.Change:
        """Replace all captions of a capture, and count them.

        Parameters
        ----------
        name : str
            Name of the capture.
        captions : iterable of Caption
            Its captions; none removes those that are there.

        Raises
        ------
        QueryError
            When there is no such capture, a caption has no word, or its interval lies outside the
            capture.
        """
        return self._save_captions(name, list(captions), keep=False)

    def _save_captions(self, name: str, new: list[Caption], keep: bool) -> updating.Change:
        """Save captions of a capture, in place of those there, or after them (``keep``)."""
        from motiondb.database.learn import updating

        with store.transaction(self.store):
            info = store.load_capture(self.store, name)
            for caption in new:
                _check_caption(info, caption)
            number = info.capture_id
            old = store.load_captions(self.store, number).get(number, ()) if keep else ()
            parameters = {"name": info.name, "words": "; ".join(c.words for c in new)}
            with updating.changing(self.store, "words", parameters, [number]) as change:
                store.save_captions(self.store, number, [*old, *new])
        return change

    def set_synonyms(self, path: str | Path) -> Mapping[str, str]:
        """Replace the synonyms for captions and questions by those of a file.

        Parameters
        ----------
        path : str or Path
            Lines ``word = canonical``.

        Raises
        ------
        MotionDBError
            When the file cannot be read.
        """
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
