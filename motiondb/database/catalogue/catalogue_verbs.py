"""The verbs of the catalogue: captures and their words in, out, and listed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from motiondb import files as capture
from motiondb import store
from motiondb.body import retarget
from motiondb.body.features import FEATURE_STEP
from motiondb.database.catalogue import browsing, cataloguing, filter_words, sheets
from motiondb.database.catalogue.annotation_verbs import AnnotationVerbs
from motiondb.database.catalogue.cataloguing import check_name_free
from motiondb.database.catalogue.file_reading import read_stored
from motiondb.database.catalogue.parts import cut_clip, cut_motion, write_bytes, write_clip
from motiondb.database.learn import updating
from motiondb.files.event_sheet import read_event_sheet
from motiondb.files.file_names import is_file
from motiondb.files.sheet import read_sheet
from motiondb.records import CaptureInfo, Clip, Motion, Relation
from motiondb.search.duplicates import DuplicateGroup, group_duplicates


class CatalogueVerbs(AnnotationVerbs):
    """Methods for captures; those for annotations are inherited."""

    def add(
        self,
        folder: str | Path,
        words: str | Path | None = None,
        settings: cataloguing.AddSettings | None = None,
        progress: cataloguing.Progress | None = None,
        events: str | Path | None = None,
    ) -> cataloguing.AddReport:
        """Add a capture, or every capture below a folder.

        Broken files are left out and reported; a file whose content is there already changes
        nothing.

        Parameters
        ----------
        folder : str or Path
            A file or a folder.
        words : str or Path, optional
            Sheet of words and tags, TSV or CSV.
        settings : AddSettings, optional
            How files are read.
        progress : callable, optional
            Called with the name of the step, the number done, and the total number.
        events : str or Path, optional
            Sheet of events, TSV or CSV.

        Raises
        ------
        MotionDBError
            When there are no captures to add, or a sheet cannot be read.
        """
        given = sheets.Sheets(
            read_sheet(words) if words is not None else None,
            read_event_sheet(events) if events is not None else None,
        )
        return cataloguing.add_captures(
            self.store, Path(folder), given, settings or cataloguing.AddSettings(), progress
        )

    def check_name_free(self, name: str) -> None:
        """Refuse a name that a capture has already.

        Raises
        ------
        QueryError
            When the name is empty or taken.
        """
        check_name_free(self.store, name)

    def captures(self, where: str = "", exact: bool = False) -> list[CaptureInfo]:
        """The catalogue.

        Parameters
        ----------
        where : str
            Filter on columns and tags, such as "performer=14".
        exact : bool
            Whether words in it that are in no caption and no tag match nothing; otherwise such a
            word may be replaced by a known one (``taken_in_filter``).

        Raises
        ------
        QueryError
            When the filter cannot be read or names an unknown column.
        """
        with self.session.reading():
            if exact or not where.strip():
                return store.load_captures(self.store, where)
            filters = filter_words.take_filter_words(self.store, where)[0]
            return store.load_captures(self.store, filters)

    def browse(
        self, where: str = "", sort: str = "name", offset: int = 0, limit: int = 100
    ) -> browsing.BrowsedPage:
        """Some rows of the catalogue, with captions, for a program that shows it page by page.

        Parameters
        ----------
        where : str
            Filter on columns and tags, such as "performer=14".
        sort : str
            Column to sort by, such as "duration", or "tag.NAME"; "-duration": the longest first.
        offset : int
            Number of the first row, from 0.
        limit : int
            Largest number of rows.

        Raises
        ------
        QueryError
            When the filter cannot be read, or there is no such column to sort by.
        """
        return browsing.browse(self.session, where, sort, offset, limit)

    def facets(self, where: str = "") -> tuple[browsing.Facet, ...]:
        """How many captures have each value of columns and tags.

        Parameters
        ----------
        where : str
            Filter on columns and tags.

        Raises
        ------
        QueryError
            When the filter cannot be read.
        """
        return browsing.facets(self.session, where)

    def browsed(self, name: str) -> browsing.BrowsedCapture | None:
        """The row of the capture of exactly this name; None if there is none."""
        with self.session.reading():
            return browsing.rows_by_name(self.session).get(name)

    def relations(self, name: str | None = None) -> list[Relation]:
        """Copies, mirror images and cuts.

        Parameters
        ----------
        name : str, optional
            One capture; None: all.
        """
        with self.session.reading():
            full = store.load_capture(self.store, name).name if name else None
            return store.load_relations(self.store, full)

    def duplicates(self, where: str = "") -> tuple[DuplicateGroup, ...]:
        """Groups of captures that repeat one another, in each the one to keep first.

        Parameters
        ----------
        where : str
            Filter on the catalogue; groups with at least one such capture are returned.
        """
        with self.session.reading():
            durations = {info.name: info.duration for info in self.captures()}
            groups = group_duplicates(self.relations(), durations)
            wanted = {info.name for info in self.captures(where)}
            return tuple(group for group in groups if wanted & set(group.captures))

    def motion(
        self, example: str | Path | Motion, start: float | None = None, end: float | None = None
    ) -> Motion:
        """A motion on the canonical body, at 30 frames a second.

        Parameters
        ----------
        example : str, Path or Motion
            A file, the name of a stored capture, or a motion.
        start : float, optional
            Start of the part of the motion, seconds.
        end : float, optional
            End of the part of the motion, seconds.

        Raises
        ------
        QueryError
            When there is no such capture, or the part lies outside it.
        CaptureError
            When a file cannot be read.
        """
        if isinstance(example, Motion):
            motion = example
        elif is_file(example):
            motion = retarget.to_motion(capture.read_capture(example))
        else:
            with self.session.reading():
                info = store.load_capture(self.store, str(example), or_file=True)
                motion = store.load_motion(self.store, info.capture_id)
        return cut_motion(motion, start, end, FEATURE_STEP)

    def clip(self, name: str) -> Clip:
        """A stored capture on its own skeleton and at its own rate, as it was read when added.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            info = store.load_capture(self.store, name)
            source = store.load_source(self.store, info.capture_id)
            run = {r.run_id: r for r in store.load_runs(self.store)}[info.run_id]
        return read_stored(info, source, run.parameters, info.fps)

    def export(
        self,
        name: str,
        path: str | Path,
        start: float | None = None,
        end: float | None = None,
        canonical: bool = False,
    ) -> Path:
        """Write a capture to a file; in its original format, the bytes are those that were added.

        Parameters
        ----------
        name : str
            Name of the capture.
        path : str or Path
            The ending says the format: .bvh, .glb or .gltf, or the ending of the added file.
        start : float, optional
            Start of the part of the capture, seconds. A part of a capture is always written as a
            new file.
        end : float, optional
            End of the part of the capture, seconds.
        canonical : bool
            Write the motion on the canonical body at 30 frames a second.

        Raises
        ------
        MotionDBError
            When there is no such capture, or the file cannot be written.
        """
        path = Path(path)
        whole = start is None and end is None and not canonical
        with self.session.reading():
            info = store.load_capture(self.store, name)
            source = store.load_source(self.store, info.capture_id)
            if whole and path.suffix.lower() == Path(source.file_name).suffix.lower():
                return write_bytes(path, source.data)
            if canonical:
                motion = store.load_motion(self.store, info.capture_id)
                return write_clip(retarget.to_clip(cut_motion(motion, start, end)), path)
            return write_clip(cut_clip(self.clip(name), start, end), path)

    def remove(self, names: Iterable[str]) -> list[str]:
        """Remove captures, all or none; their counts are removed from the learned model.

        Parameters
        ----------
        names : iterable of str
            Names of captures.

        Returns
        -------
        list of str
            Full names of the captures removed.

        Raises
        ------
        QueryError
            When there is no capture of one of the names.
        """
        with store.transaction(self.store):
            infos = [store.load_capture(self.store, name) for name in names]
            numbers = [info.capture_id for info in infos]
            parameters = {"names": [info.name for info in infos]}
            with updating.changing(self.store, "remove", parameters, numbers):
                for number in numbers:
                    store.remove_capture(self.store, number)
        return [info.name for info in infos]
