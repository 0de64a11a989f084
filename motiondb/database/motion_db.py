"""The verbs: a thin class over the store and the modules that compute."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from motiondb import capture, store
from motiondb.capture.event_sheet import read_event_sheet
from motiondb.capture.sheet import read_sheet
from motiondb.database.ask import answering, examples
from motiondb.database.ask.searchable import with_generated
from motiondb.database.catalogue import cataloguing, importing
from motiondb.database.catalogue.parts import cut_clip, cut_motion, outside, write_bytes, write_clip
from motiondb.database.generate import generating
from motiondb.database.generate.keeping import check_name_free, keep_generated
from motiondb.database.learn import caption_suggestions, learning, updating
from motiondb.database.learn import captures_drift as drifting
from motiondb.database.learn import learned as learned_state
from motiondb.errors import MotionDBError, QueryError
from motiondb.pose import retarget
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import (
    Caption,
    CaptureInfo,
    Clip,
    Event,
    Learning,
    Motion,
    Relation,
)
from motiondb.search.duplicates import DuplicateGroup, group_duplicates
from motiondb.words.synonyms import parse_synonyms

if TYPE_CHECKING:
    from motiondb.database.grammars.grammar_verbs import Grammars
    from motiondb.database.scenes.scene_verbs import Scenes


class MotionDB:
    """A motion database: add captures, learn, ask, generate. Use it in a ``with`` statement.

    Parameters
    ----------
    path : the DuckDB file. read_only : only ask; several processes may do so at once.
    create : make the file when it is not there (never when ``read_only``).
    """

    def __init__(self, path: str | Path, *, read_only: bool = False, create: bool = True) -> None:
        self.store = store.open_store(path, read_only=read_only, create=create)
        self._learned: learned_state.Learned | None = None
        self._searchable: tuple[learned_state.Learned, learned_state.Learned] | None = None

    @cached_property
    def grammars(self) -> Grammars:
        """The verbs of grammars: learn, show, parse, suggest, generate, edit, compare, remove."""
        from motiondb.database.grammars.grammar_verbs import Grammars

        return Grammars(self)

    @cached_property
    def scenes(self) -> Scenes:
        """The verbs of scenes: make, update, write, keep, load, draw, remove."""
        from motiondb.database.scenes.scene_verbs import Scenes

        return Scenes(self)

    def forget(self) -> None:
        """Drop what was loaded, so that the next question sees the store as it is now."""
        self._learned = None

    def close(self) -> None:
        """Let go of the file."""
        self.store.close()

    def __enter__(self) -> MotionDB:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def learned(self) -> learned_state.Learned:
        """What questions need, loaded at the first one.

        Raises
        ------
        NotLearnedError : the database has not learned.
        """
        if self._learned is None:
            self._learned = learned_state.load_learned(self.store)
        return self._learned

    @property
    def searchable(self) -> learned_state.Learned:
        """What was learned, with the generated captures to be found (NotLearnedError)."""
        if self._searchable is None or self._searchable[0] is not self.learned:
            self._searchable = (self.learned, with_generated(self.learned))
        return self._searchable[1]

    def add(
        self,
        folder: str | Path,
        words: str | Path | None = None,
        settings: cataloguing.AddSettings | None = None,
        progress: cataloguing.Progress | None = None,
        events: str | Path | None = None,
    ) -> cataloguing.AddReport:
        """Add a capture, or every capture below a folder; sheets are TSV or CSV.

        ``words`` is a sheet of words and tags, ``events`` one of instants. Broken files are left
        out and reported; what is already there by content stays as it is.
        """
        sheets = cataloguing.Sheets(
            read_sheet(words) if words is not None else None,
            read_event_sheet(events) if events is not None else None,
        )
        self._learned = None
        return cataloguing.add_captures(
            self.store, Path(folder), sheets, settings or cataloguing.AddSettings(), progress
        )

    def learn(
        self,
        settings: learning.LearnSettings | None = None,
        progress: learning.Progress | None = None,
    ) -> Learning:
        """Derive symbols, their space and their words from all captures; replaces earlier ones."""
        self._learned = None
        return learning.learn(self.store, settings or learning.LearnSettings(), progress)

    def search(
        self,
        words: str,
        where: str = "",
        limit: int = 10,
        by_symbols: bool = False,
        written: bool = True,
    ) -> answering.WordAnswer:
        """Intervals that show what the words ask for, in their order, best first.

        ``written`` False leaves out what people wrote about the captures: the motion alone speaks.
        """
        return answering.search_words(self.searchable, words, where, limit, by_symbols, written)

    def like(
        self,
        example: str | Path | Motion,
        start: float | None = None,
        end: float | None = None,
        where: str = "",
        limit: int = 10,
        meaning: bool | None = None,
    ) -> examples.ExampleAnswer:
        """Intervals that move like an example: a file, a stored capture, or a motion (seconds).

        ``meaning`` looks for the same action in other styles too, by the words that were learned;
        None: where there are any. False: by motion alone.
        """
        motion = self.motion(example, start, end)
        return examples.search_motion(self.searchable, motion, where, limit, meaning)

    def describe(
        self, example: str | Path | Motion, start: float | None = None, end: float | None = None
    ) -> tuple[answering.Description, ...]:
        """The words of a motion over time, with probabilities."""
        return answering.describe(self.learned, self.motion(example, start, end))

    def generate(self, words: str, seed: int = 0, method: str = "stitched") -> generating.Generated:
        """A motion that shows what a sentence says; the same seed gives the same motion."""
        return generating.generate(self.learned, words, seed, method)

    def save_generated(
        self, name: str, words: str, made: generating.Generated, seed: int
    ) -> CaptureInfo:
        """Keep a generated motion as a capture, with the origin of every frame."""
        with store.transaction(self.store):
            run_id = store.start_run(self.store, "generate", {"words": words}, seed)
            captions = [Caption(words)]
            info = keep_generated(self.store, name, made.motion, made.provenance, captions, run_id)
            store.finish_run(self.store, run_id)
        self._learned = None
        return info

    def unlearned(self) -> list[str]:
        """Names of captured captures that were added since it learned: answers leave them out."""
        if not store.is_learned(self.store):
            return [info.name for info in self.captures() if info.kind == "captured"]
        if self._learned is not None:
            learned = set(self._learned.rows)
        else:
            learned = set(store.load_segments(self.store, scores=False).capture_ids.tolist())
        return [
            info.name
            for info in self.captures()
            if info.kind == "captured" and info.capture_id not in learned
        ]

    def check_name_free(self, name: str) -> None:
        """Refuse a name that a capture has already.

        Raises
        ------
        QueryError : says what to do.
        """
        check_name_free(self.store, name)

    def captures(self, where: str = "") -> list[CaptureInfo]:
        """The catalogue, filtered by columns and tags, such as ``performer=14``."""
        return store.load_captures(self.store, where)

    def captions(self, name: str) -> tuple[Caption, ...]:
        """What people wrote about a capture."""
        number = store.load_capture(self.store, name).capture_id
        return store.load_captions(self.store, number).get(number, ())

    def relations(self, name: str | None = None) -> list[Relation]:
        """Copies, mirror images and cuts, of one capture or of all."""
        full = store.load_capture(self.store, name).name if name else None
        return store.load_relations(self.store, full)

    def duplicates(self) -> tuple[DuplicateGroup, ...]:
        """Groups of captures that repeat one another, the one to keep first in each."""
        durations = {info.name: info.duration for info in self.captures()}
        return group_duplicates(self.relations(), durations)

    def motion(
        self, example: str | Path | Motion, start: float | None = None, end: float | None = None
    ) -> Motion:
        """The canonical motion of a file, of a stored capture, or of a part of either (seconds)."""
        if isinstance(example, Motion):
            motion = example
        elif Path(example).is_file():
            motion = retarget.to_motion(capture.read_capture(example))
        else:
            info = store.load_capture(self.store, str(example), or_file=True)
            motion = store.load_motion(self.store, info.capture_id)
        return cut_motion(motion, start, end, FEATURE_STEP)

    def clip(self, name: str) -> Clip:
        """A stored capture on its own skeleton and at its own rate, as it was read when added."""
        info = store.load_capture(self.store, name)
        source = store.load_source(self.store, info.capture_id)
        run = {r.run_id: r for r in store.load_runs(self.store)}[info.run_id]
        unit = run.parameters.get("unit")
        return capture.read_capture_bytes(
            source.data,
            source.format,
            path=info.name,
            skeleton=source.skeleton_data,
            skeleton_path=source.skeleton_name or "",
            fps=info.fps,
            unit=float(str(unit)) if unit else None,
            skip_bad_frames=bool(run.parameters.get("skip_bad_frames")),
        )

    def export(
        self, name: str, path: str | Path, start: float | None = None, end: float | None = None,
        canonical: bool = False,
    ) -> Path:  # fmt: skip
        """Write a capture as BVH or glTF, or, where the ending is its own, the very bytes added.

        Parameters
        ----------
        start, end : seconds; a part is written anew. canonical : on the canonical body at 30 fps.
        """
        path = Path(path)
        info = store.load_capture(self.store, name)
        whole = start is None and end is None and not canonical
        source = store.load_source(self.store, info.capture_id)
        if whole and path.suffix.lower() == Path(source.file_name).suffix.lower():
            return write_bytes(path, source.data)
        if canonical:
            motion = store.load_motion(self.store, info.capture_id)
            return write_clip(retarget.to_clip(cut_motion(motion, start, end)), path)
        return write_clip(cut_clip(self.clip(name), start, end), path)

    def remove(self, names: Iterable[str]) -> list[str]:
        """Take captures out, all or none; what was learned is as if they had never been counted."""
        infos = [store.load_capture(self.store, name) for name in names]
        numbers = [info.capture_id for info in infos]
        parameters = {"names": [info.name for info in infos]}
        with updating.changing(self.store, "remove", parameters, numbers):
            for number in numbers:
                store.remove_capture(self.store, number)
        self._learned = None
        return [info.name for info in infos]

    def set_words(
        self,
        name: str,
        words: str,
        start: float | None = None,
        end: float | None = None,
        keep: bool = False,
    ) -> updating.Change:
        """Write down what a capture, or a part of it (seconds), shows, and count it.

        ``keep`` adds to the words that are there instead of replacing them. Words that are new to
        the vocabulary are counted at the next ``learn``.
        """
        info = store.load_capture(self.store, name)
        first, last = start or 0.0, info.duration if end is None else end
        if not 0.0 <= first < last <= info.duration + 1.0:
            raise QueryError(f"{info.name}: {outside(info.duration, start, end)}")
        if not words.strip():
            raise QueryError(f"{info.name}: expected words, found none. Say what it shows.")
        old = (
            store.load_captions(self.store, info.capture_id).get(info.capture_id, ())
            if keep
            else ()
        )
        parameters = {"name": info.name, "words": words}
        with updating.changing(self.store, "words", parameters, [info.capture_id]) as change:
            store.save_captions(self.store, info.capture_id, [*old, Caption(words, start, end)])
        self._learned = None
        return change

    def import_words(self, sheet: str | Path) -> importing.ImportReport:
        """Replace words and tags by those of a sheet; tells of rows without a capture.

        Captures for which the sheet has no words keep theirs.
        """
        self._learned = None
        return importing.import_words(self.store, sheet)

    def events(self, name: str) -> tuple[Event, ...]:
        """Instants of a capture, by frames of its motion (30 a second)."""
        number = store.load_capture(self.store, name).capture_id
        return store.load_events(self.store, number).get(number, ())

    def import_events(self, sheet: str | Path) -> importing.EventReport:
        """Replace the events of the captures that a sheet names; tells of what it left out."""
        return importing.import_events(self.store, sheet)

    def set_synonyms(self, path: str | Path) -> Mapping[str, str]:
        """Keep a file of synonyms (lines ``word = canonical``) for words and questions."""
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
        every = [info.capture_id for info in self.captures()]
        with updating.changing(self.store, "words", {"synonyms": str(path)}, every):
            store.save_synonyms(self.store, table)
        self._learned = None
        return table

    def drift(self) -> drifting.Drift | None:
        """How far captures and words have moved from what was learned; None where it cannot say."""
        return drifting.measure(self.store)

    def suggest_captions(self, limit: int = 10) -> list[caption_suggestions.CaptionSuggestion]:
        """Captures without words, the one whose words would tell most about the others first."""
        return caption_suggestions.suggest_captions(self.learned, limit)

    def check(self) -> list[str]:
        """Faults of the store, none in a sound one."""
        return store.check_store(self.store, sources=True)
