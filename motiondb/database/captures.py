"""The verbs that ask about captures: the catalogue, motions, captions, facts and pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.database.archive import Archive
from motiondb.database.arguments import Example, check_example
from motiondb.database.catalogue import browsing
from motiondb.records import (
    Caption,
    CaptureInfo,
    Clip,
    DuplicateGroup,
    Event,
    Float32Array,
    Motion,
    Relation,
)
from motiondb.store import Provenance

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from motiondb.answers.catalogue import (
        CaptureFacts,
        DatabaseInfo,
        EventRow,
        Exported,
        MatchFile,
        ShownActivity,
        ShownSegment,
    )
    from motiondb.answers.questions import Comparison
    from motiondb.database.catalogue import exporting
    from motiondb.database.tables import Tables
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.takings import Taking


class Captures(Archive):
    """The captures of a database."""

    def captures(self, where: str = "", exact: bool = False, sort: str = "") -> list[CaptureInfo]:
        """The catalogue.

        Parameters
        ----------
        where : str
            Filter on columns and tags, such as "performer=14".
        exact : bool
            Whether words in it that are in no caption and no tag match nothing; otherwise such a
            word may be replaced by a known one (``taken_in_filter``).
        sort : str
            Column or tag to sort by, such as "duration"; "-duration": the longest first. "": in
            order of number.

        Raises
        ------
        QueryError
            When the filter cannot be read or names an unknown column, or there is none to sort by.
        """
        with self.session.reading():
            if exact or not where.strip():
                infos = store.load_captures(self.store, where)
            else:
                from motiondb.database.catalogue import filter_words

                filters = filter_words.take_filter_words(self.store, where)[0]
                infos = store.load_captures(self.store, filters)
            return browsing.sort_captures(self.session, infos, sort) if sort else infos

    def taken_in_filter(self, where: str) -> Mapping[str, Taking]:
        """The known words that replace words of a filter that are in no caption and no tag.

        Parameters
        ----------
        where : str
            The filter.
        """
        if not where.strip():
            return {}
        from motiondb.database.catalogue import filter_words

        with self.session.reading():
            return filter_words.take_filter_words(self.store, where)[1]

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

    def info(self) -> DatabaseInfo:
        """What is in the database: numbers of captures, grammars, symbols and words."""
        with self.session.reading():
            return browsing.database_info(self.session)

    def unlearned(self) -> list[str]:
        """Names of captured captures that no question searches: added and not counted."""
        return browsing.unlearned_captures(self.session)

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
        from motiondb.search.copies import group_duplicates

        with self.session.reading():
            durations = {info.name: info.duration for info in self.captures()}
            groups = group_duplicates(self.relations(), durations)
            wanted = {info.name for info in self.captures(where)}
            return tuple(group for group in groups if wanted & set(group.captures))

    def motion(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
    ) -> Motion:
        """A motion on the canonical body, at 30 frames a second.

        Parameters
        ----------
        example : str, Path, Clip or Motion
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
        from motiondb.body.features import FEATURE_STEP
        from motiondb.body.retarget import to_motion
        from motiondb.database.catalogue.parts import cut_motion
        from motiondb.files import read_capture, split_take
        from motiondb.files.safe_files import is_file

        check_example(example)
        if isinstance(example, Motion):
            motion = example
        elif isinstance(example, Clip):
            motion = to_motion(example)
        elif is_file(split_take(example)[0]):
            motion = to_motion(read_capture(example))
        else:
            with self.session.reading():
                info = store.load_capture(self.store, str(example), or_file=True)
                motion = store.load_motion(self.store, info.capture_id)
        return cut_motion(motion, start, end, FEATURE_STEP)

    def features(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
        whitened: bool = False,
    ) -> Float32Array:
        """Recognition features of a motion: what symbols are learned from, and examples found by.

        They do not depend on the performer's size, place and heading (:mod:`motiondb.body.features`
        names the columns). ``whitened`` are what the hidden Markov models of symbols take: for a
        segment of symbol 7 from frame 20 to 52 (half of its frames at 30 a second, rounded up),
        ``db.learned.symbols.to_hmmlearn(7).score(whitened[20:52])`` is its log-likelihood.

        Parameters
        ----------
        example : str, Path, Clip or Motion
            A file, the name of a stored capture, or a motion.
        start : float, optional
            Start of the part of the motion, seconds.
        end : float, optional
            End of the part of the motion, seconds.
        whitened : bool
            Whether to rotate and scale them as the database has learned, so that the columns are
            uncorrelated and have variance 1 over all captures.

        Returns
        -------
        array (frames, 130), or (frames, dimensions) if whitened; float32
            15 frames a second.

        Raises
        ------
        MotionDBError
            As for :meth:`motion`; NotLearnedError when they should be whitened before ``learn``.
        """
        from motiondb.body.features import recognition_features

        with self.session.reading():
            features = recognition_features(self.motion(example, start, end))
            return self.session.learned.feature_space.project(features) if whitened else features

    def clip(self, name: str) -> Clip:
        """A stored capture on its own skeleton and at its own rate, as it was read when added.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database.catalogue.file_reading import read_stored

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
        changes: exporting.MotionChanges | None = None,
    ) -> Exported:
        """Write a capture to a file; in its original format, the bytes are those that were added.

        Parameters
        ----------
        name : str
            Name of the capture.
        path : str or Path
            The ending says the format: .bvh, .fbx, .glb, .gltf, .usd, .usda or .usdc, or the
            ending of the added file; .npz, .csv and .parquet hold positions, velocities and
            contacts of the feet (see :mod:`motiondb.files.arrays`). With the added AMC, its
            skeleton is written beside it (.asf).
        start : float, optional
            Start of the part of the capture, seconds. A part of a capture is always written as a
            new file.
        end : float, optional
            End of the part of the capture, seconds.
        canonical : bool
            Write the motion on the canonical body at 30 frames a second.
        changes : MotionChanges, optional
            How the motion is changed before. A changed motion is always written as a new file.

        Returns
        -------
        Exported
            The names of the files, and what was done.

        Raises
        ------
        MotionDBError
            When there is no such capture, or the file cannot be written.
        """
        from motiondb.answers.catalogue import Exported
        from motiondb.database.catalogue import exporting
        from motiondb.database.catalogue.parts import cut_clip, cut_motion

        path, asked = Path(path), changes or exporting.MotionChanges()
        is_named = asked.of_motion.are_any or path.suffix.lower() in exporting.ARRAY_ENDINGS
        exporting.check_joint_map(asked, is_named and not canonical)
        whole = start is None and end is None and not canonical and not asked.are_any
        with self.session.reading():
            info = store.load_capture(self.store, name)
            if canonical or asked.onto is not None:
                motion = cut_motion(store.load_motion(self.store, info.capture_id), start, end)
            else:
                source = store.load_source(self.store, info.capture_id)
                if whole and path.suffix.lower() == Path(source.own_name).suffix.lower():
                    return exporting.write_added(info, source, path, self.clip(name).unit)
                motion, clip = None, cut_clip(self.clip(name), start, end)
                asked = self._with_joint_map(info, asked)
        owner = exporting.owner_of(info)
        if motion is not None:
            made = exporting.write_motion(motion, path, asked, owner)
        else:
            made = exporting.write_changed(clip, path, asked, owner)
        unit = exporting.unit_in(path, made.clip)
        clip = made.clip
        return Exported(
            info.name, path, clip.fps, clip.n_frames, unit, False, made.said, None, made.fit
        )

    def _with_joint_map(
        self, info: CaptureInfo, asked: exporting.MotionChanges
    ) -> exporting.MotionChanges:
        """Return the changes with the joint map with which a capture was added."""
        runs = {run.run_id: run for run in store.load_runs(self.store)}
        added = runs[info.run_id].parameters.get("joint_map")
        if asked.joint_map or not isinstance(added, dict):
            return asked
        return replace(asked, joint_map={str(k): str(v) for k, v in added.items()})

    @cached_property
    def tables(self) -> Tables:
        """Captures, captions, segments, symbols, words and matches as Arrow tables."""
        from motiondb.database.tables import Tables

        return Tables(self.session)

    def export_matches(
        self, answer: WordAnswer | ExampleAnswer, folder: str | Path, question: str = ""
    ) -> list[MatchFile]:
        """Write the intervals of an answer as BVH, each with its origin and licence beside it.

        Parameters
        ----------
        answer : WordAnswer or ExampleAnswer
            The answer of ``search`` or ``like``.
        folder : str or Path
            The folder, which is made if there is none.
        question : str
            What was asked, for the files beside.

        Raises
        ------
        MotionDBError
            When a file cannot be written.
        """
        from motiondb.database.match_files import write_matches

        with self.session.reading():
            return write_matches(self.store, answer.matches, Path(folder), question, self.export)

    def compare(
        self,
        first: Example,
        second: Example,
        png: str | Path | None = None,
        parts: tuple[tuple[float | None, float | None], ...] = ((None, None), (None, None)),
    ) -> Comparison:
        """Align two motions by dynamic time warping, and measure how far they are apart.

        Poses are compared on the standard body, relative to the pelvis and the heading.

        Parameters
        ----------
        first : str, Path, Clip or Motion
            A file, the name of a stored capture, or a motion.
        second : str, Path or Motion
            The same.
        png : str or Path, optional
            Draw the distances of all poses with the alignment into this file.
        parts : pair of pairs of float or None
            Start and end of the part of either that is compared, seconds.

        Raises
        ------
        QueryError
            When there is no such capture, or a part lies outside it.
        """
        from motiondb.database.comparing import compare

        both = (first, second)
        motions = [self.motion(each, *part) for each, part in zip(both, parts)]
        names = [str(each) if isinstance(each, str | Path) else "motion" for each in both]
        starts = [part[0] or 0.0 for part in parts]
        return compare(
            (names[0], names[1]),
            (motions[0], motions[1]),
            (starts[0], starts[1]),
            None if png is None else Path(png),
        )

    def draw_matches(
        self,
        answer: WordAnswer | ExampleAnswer,
        path: str | Path,
        title: str = "",
        example: Motion | None = None,
    ) -> Path:
        """Draw the first matches of an answer as rows of stick figures, as PNG.

        Parameters
        ----------
        answer : WordAnswer or ExampleAnswer
            The answer of ``search`` or ``like``.
        path : str or Path
            The picture.
        title : str
            Title of the picture.
        example : Motion, optional
            The example, which is drawn above the matches.

        Raises
        ------
        MotionDBError
            When the answer has no matches, or the picture cannot be written.
        """
        from motiondb.database import searching

        return searching.draw_matches(self.session, answer.matches, path, title, example)

    def draw_reasons(self, answer: WordAnswer, path: str | Path, title: str = "") -> Path:
        """Draw the best match over a timeline of contributions for each word, as PNG.

        Parameters
        ----------
        answer : WordAnswer
            The answer of ``search``, but not one by symbols.
        path : str or Path
            The picture.
        title : str
            Title of the picture.

        Raises
        ------
        QueryError
            When the answer has no reasons.
        """
        from motiondb.database import searching

        return searching.draw_reasons(self.session, answer, path, title)

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

    def event_rows(self) -> list[EventRow]:
        """The kinds of events, each with its number of events and of captures, by name."""
        from motiondb.answers.catalogue import EventRow

        known = self.all_events().values()
        events = Counter(event.name for of_one in known for event in of_one)
        captures = Counter(name for of_one in known for name in {e.name for e in of_one})
        return [EventRow(name, count, captures[name]) for name, count in sorted(events.items())]

    def segments(self, name: str) -> list[ShownSegment]:
        """Symbols of a capture with their times (seconds); empty if it is not learned.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database import showing

        with self.session.reading():
            return showing.searched_segments(self.session, name)

    def activities(self, name: str) -> list[ShownActivity]:
        """The successive activities of a capture; empty if there is only one.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database import showing

        with self.session.reading():
            info = store.load_capture(self.store, name)
            return showing.capture_activities(self.session, info.capture_id)

    def provenance(self, name: str) -> Provenance:
        """Origin of every frame of a generated capture; without sources for a captured one.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            info = store.load_capture(self.store, name)
            return store.load_provenance(self.store, info.capture_id)

    def show(self, name: str) -> CaptureFacts:
        """Facts of one capture, for print or JSON; times in seconds.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database import showing

        with self.session.reading():
            return showing.describe_capture(self.session, name)

    def draw(self, name: str, path: str | Path) -> Path:
        """Draw a capture as a strip of stick figures over its timelines, as PNG."""
        from motiondb.database import showing

        with self.session.reading():
            return showing.draw_capture(self.session, name, path)

    def animate(
        self, name: str, path: str | Path, start: float | None = None, end: float | None = None
    ) -> Path:
        """Draw a capture as an animated GIF of a stick figure in real time.

        Parameters
        ----------
        name : str
            Name of the capture.
        path : str or Path
            The GIF.
        start : float, optional
            Start of the part of the capture, seconds.
        end : float, optional
            End of the part of the capture, seconds.
        """
        from motiondb import pictures

        with self.session.reading():
            name = store.load_capture(self.store, name).name
            return pictures.draw_animation(self.motion(name, start, end), path)
