"""The verbs of the catalogue: captures and their words in, out, and listed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import capture, store
from motiondb.capture.sheets.event_sheet import read_event_sheet
from motiondb.capture.sheets.sheet import read_sheet
from motiondb.database.catalogue import added_sheets, cataloguing, importing
from motiondb.database.catalogue.cataloguing import check_name_free
from motiondb.database.catalogue.file_reading import read_stored
from motiondb.database.catalogue.parts import cut_clip, cut_motion, outside, write_bytes, write_clip
from motiondb.database.learn import updating
from motiondb.errors import MotionDBError, QueryError
from motiondb.file_names import is_file
from motiondb.pose import retarget
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import Caption, CaptureInfo, Clip, Event, Motion, Relation
from motiondb.search.duplicates import DuplicateGroup, group_duplicates
from motiondb.store import Store
from motiondb.words.lexicon.synonyms import parse_synonyms

if TYPE_CHECKING:
    from motiondb.database.session import Session


class CatalogueVerbs:
    """Verbs on captures, what people wrote about them, and their events.

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
            Called with what is being done, how many are done, and how many there are.
        events : str or Path, optional
            Sheet of events, TSV or CSV.

        Raises
        ------
        MotionDBError
            When there is nothing to add, or a sheet cannot be read.
        """
        sheets = added_sheets.Sheets(
            read_sheet(words) if words is not None else None,
            read_event_sheet(events) if events is not None else None,
        )
        return cataloguing.add_captures(
            self.store, Path(folder), sheets, settings or cataloguing.AddSettings(), progress
        )

    def check_name_free(self, name: str) -> None:
        """Refuse a name that a capture has already.

        Raises
        ------
        QueryError
            When the name is empty or taken.
        """
        check_name_free(self.store, name)

    def captures(self, where: str = "") -> list[CaptureInfo]:
        """The catalogue.

        Parameters
        ----------
        where : str
            Filter on columns and tags, such as "performer=14".

        Raises
        ------
        QueryError
            When the filter cannot be read or names an unknown column.
        """
        with self.session.reading():
            return store.load_captures(self.store, where)

    def captions(self, name: str) -> tuple[Caption, ...]:
        """What people wrote about a capture.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_captions(self.store, number).get(number, ())

    def all_captions(self) -> dict[int, tuple[Caption, ...]]:
        """What people wrote about all captures, by capture number."""
        with self.session.reading():
            return dict(store.load_captions(self.store))

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

    def duplicates(self) -> tuple[DuplicateGroup, ...]:
        """Groups of captures that repeat one another, in each the one to keep first."""
        with self.session.reading():
            durations = {info.name: info.duration for info in self.captures()}
            return group_duplicates(self.relations(), durations)

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
        """Write a capture to a file; its own format gives back the very bytes that were added.

        Parameters
        ----------
        name : str
            Name of the capture.
        path : str or Path
            The ending says the format: .bvh, .glb or .gltf, or the ending of the added file.
        start : float, optional
            Start of the part of the capture, seconds. A part is written anew.
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
        """Remove captures, all or none; what was learned is as if they had never been counted.

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
            When one of the names is no capture's.
        """
        with store.transaction(self.store):
            infos = [store.load_capture(self.store, name) for name in names]
            numbers = [info.capture_id for info in infos]
            parameters = {"names": [info.name for info in infos]}
            with updating.changing(self.store, "remove", parameters, numbers):
                for number in numbers:
                    store.remove_capture(self.store, number)
        return [info.name for info in infos]

    def set_words(
        self,
        name: str,
        words: str,
        start: float | None = None,
        end: float | None = None,
        keep: bool = False,
    ) -> updating.Change:
        """Write down what a capture, or a part of it, shows, and count it.

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
        with store.transaction(self.store):
            info = store.load_capture(self.store, name)
            first, last = start or 0.0, info.duration if end is None else end
            if not 0.0 <= first < last <= info.duration + 1.0:
                raise QueryError(f"{info.name}: {outside(info.duration, start, end)}")
            if not words.strip():
                raise QueryError(f"{info.name}: expected words, found none. Say what it shows.")
            number = info.capture_id
            old = store.load_captions(self.store, number).get(number, ()) if keep else ()
            parameters = {"name": info.name, "words": words}
            with updating.changing(self.store, "words", parameters, [number]) as change:
                store.save_captions(self.store, number, [*old, Caption(words, start, end)])
        return change

    def import_words(self, sheet: str | Path) -> importing.ImportReport:
        """Replace words and tags by those of a sheet; captures without words in it keep theirs.

        Parameters
        ----------
        sheet : str or Path
            TSV or CSV.
        """
        return importing.import_words(self.store, sheet)

    def events(self, name: str) -> tuple[Event, ...]:
        """Instants of a capture, by frames of its motion (30 a second).

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_events(self.store, number).get(number, ())

    def all_events(self) -> dict[int, tuple[Event, ...]]:
        """Instants of all captures that have any, by capture number."""
        with self.session.reading():
            return dict(store.load_events(self.store))

    def import_events(self, sheet: str | Path) -> importing.EventReport:
        """Replace the events of the captures that a sheet names.

        Parameters
        ----------
        sheet : str or Path
            TSV or CSV.
        """
        return importing.import_events(self.store, sheet)

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
        path = Path(path)
        try:
            table = parse_synonyms(path.read_text(encoding="utf-8"), str(path))
        except OSError as error:
            raise MotionDBError(
                f"{path}: expected a readable file of synonyms, found: {error.strerror}."
            ) from None
        except UnicodeDecodeError:
            raise MotionDBError(
                f"{path}: expected text in UTF-8, found another encoding. Save it as UTF-8."
            ) from None
        with store.transaction(self.store):
            every = [info.capture_id for info in store.load_captures(self.store)]
            with updating.changing(self.store, "words", {"synonyms": str(path)}, every):
                store.save_synonyms(self.store, table)
        return table
