"""The methods for annotations of captures: captions, events, synonyms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb import store
from motiondb.database.catalogue import sheets
from motiondb.database.catalogue.parts import outside
from motiondb.database.learn import updating
from motiondb.errors import MotionDBError, QueryError
from motiondb.files.bounded_files import read_bounded_text
from motiondb.language.synonyms import parse_synonyms
from motiondb.records import Caption, CaptureInfo, Event
from motiondb.store import Store

if TYPE_CHECKING:
    from motiondb.database.session import Session


class AnnotationVerbs:
    """Verbs on captions, events and synonyms.

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

    def captions(self, name: str) -> tuple[Caption, ...]:
        """The captions of a capture.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_captions(self.store, number).get(number, ())

    def all_captions(self) -> dict[int, tuple[Caption, ...]]:
        """The captions of all captures, by capture number."""
        with self.session.reading():
            return dict(store.load_captions(self.store))

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
        with store.transaction(self.store):
            info = store.load_capture(self.store, name)
            _check_caption(info, Caption(words, start, end))
            number = info.capture_id
            old = store.load_captions(self.store, number).get(number, ()) if keep else ()
            parameters = {"name": info.name, "words": words}
            with updating.changing(self.store, "words", parameters, [number]) as change:
                store.save_captions(self.store, number, [*old, Caption(words, start, end)])
        return change

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
        new = list(captions)
        with store.transaction(self.store):
            info = store.load_capture(self.store, name)
            for caption in new:
                _check_caption(info, caption)
            parameters = {"name": info.name, "words": "; ".join(c.words for c in new)}
            with updating.changing(self.store, "words", parameters, [info.capture_id]) as change:
                store.save_captions(self.store, info.capture_id, new)
        return change

    def import_words(self, sheet: str | Path) -> sheets.ImportReport:
        """Replace words and tags by those of a sheet; captures without words in it keep theirs.

        Parameters
        ----------
        sheet : str or Path
            TSV or CSV.
        """
        return sheets.import_words(self.store, sheet)

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

    def event_rows(self) -> list[dict[str, Any]]:
        """The kinds of events, each with its number of events and of captures, by name."""
        known = self.all_events().values()
        events = Counter(event.name for of_one in known for event in of_one)
        captures = Counter(name for of_one in known for name in {e.name for e in of_one})
        return [
            {"event": name, "count": count, "captures": captures[name]}
            for name, count in sorted(events.items())
        ]

    def import_events(self, sheet: str | Path) -> sheets.EventReport:
        """Replace the events of the captures that a sheet names.

        Parameters
        ----------
        sheet : str or Path
            TSV or CSV.
        """
        return sheets.import_events(self.store, sheet)

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
            table = parse_synonyms(read_bounded_text(path, "utf-8"), str(path))
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


def _check_caption(info: CaptureInfo, caption: Caption) -> None:
    """Refuse a caption without words, or of an interval outside its capture (QueryError)."""
    first, last = caption.start or 0.0, info.duration if caption.end is None else caption.end
    if not 0.0 <= first < last <= info.duration + 1.0:
        raise QueryError(f"{info.name}: {outside(info.duration, caption.start, caption.end)}")
    if not caption.words.strip():
        raise QueryError(f"{info.name}: expected words, found none. Say what it shows.")
