"""The verbs that ask about captures: the catalogue, motions, captions, facts and pictures."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, store
from motiondb.database.archive import Archive
from motiondb.database.catalogue import browsing
from motiondb.errors import QueryError
from motiondb.records import (
    MOTION_FPS,
    Caption,
    CaptureInfo,
    Clip,
    DuplicateGroup,
    Event,
    Float32Array,
    Match,
    Motion,
    Relation,
)

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from motiondb.database.catalogue import exporting
    from motiondb.database.tables import Tables
    from motiondb.database.values import Example
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.takings import Taking
    from motiondb.store import Provenance

_UNUSUAL = re.compile(r"[^\w.-]+")  # Characters that names of files of matches do not have


class Captures(Archive):
    """The captures of a database; :class:`Archive` says what the arguments are.

    ``example`` is a file, the name of a stored capture, or a motion. ``answer`` is what ``search``
    or ``like`` gives. ``path`` of a picture is the file, which is returned. CaptureError is raised
    where a file cannot be read.
    """

    def captures(self, where: str = "", exact: bool = False, sort: str = "") -> list[CaptureInfo]:
        """The catalogue.

        Parameters
        ----------
        exact : bool
            Whether words of ``where`` that are in no caption and no tag match nothing; otherwise
            such a word may be replaced by a known one (:meth:`taken_in_filter`).
        sort : str
            Column or tag to sort by, such as "duration"; "-duration": the longest first. "": in
            order of number.
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
        """The known words that replace words of a filter that are in no caption and no tag."""
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
        sort : str
            Column to sort by, such as "duration", or "tag.NAME"; "-duration": the longest first.
        offset : int
            Number of the first row, from 0.
        limit : int
            Largest number of rows.
        """
        return browsing.browse(self.session, where, sort, offset, limit)

    def facets(self, where: str = "") -> tuple[browsing.Facet, ...]:
        """How many captures have each value of columns and tags."""
        return browsing.facets(self.session, where)

    def info(self) -> answers.DatabaseInfo:
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
        """Copies, mirror images and cuts; of one capture, or of all."""
        with self.session.reading():
            full = store.load_capture(self.store, name).name if name else None
            return store.load_relations(self.store, full)

    def duplicates(self, where: str = "") -> tuple[DuplicateGroup, ...]:
        """Groups of captures that repeat one another, with at least one that matches."""
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
        """A motion, or a part of it, on the canonical body, at 30 frames a second."""
        from motiondb.body.features import FEATURE_STEP
        from motiondb.body.retarget import to_motion
        from motiondb.database.catalogue.parts import cut_motion
        from motiondb.files.formats import read_capture, split_take
        from motiondb.files.safe_files import is_file

        if isinstance(example, Motion):
            motion = example
        elif isinstance(example, Clip):
            motion = to_motion(example)
        elif is_file(split_take(example)[0]):
            clip = read_capture(example)
            motion = to_motion(clip)
            motion = replace(motion, notes=clip.notes + motion.notes)
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
        whitened : bool
            Whether to rotate and scale them as the database has learned, so that the columns are
            uncorrelated and have variance 1 over all captures.

        Returns
        -------
        array (frames, 130), or (frames, dimensions) if whitened; float32
            15 frames a second.

        Raises
        ------
        NotLearnedError
            When they should be whitened before ``learn``.
        """
        from motiondb.body.features import recognition_features

        with self.session.reading():
            features = recognition_features(self.motion(example, start, end))
            return self.session.learned.feature_space.project(features) if whitened else features

    def clip(self, name: str) -> Clip:
        """A stored capture on its own skeleton and at its own rate, as it was read when added."""
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
    ) -> answers.Exported:
        """Write a capture to a file; in its original format, the bytes are those that were added.

        A part of a capture, and a changed motion, are always written as a new file.

        Parameters
        ----------
        path : str or Path
            The ending says the format: .bvh, .fbx, .glb, .gltf, .usd, .usda or .usdc, or the
            ending of the added file; .npz, .csv and .parquet hold positions, velocities and
            contacts of the feet (see :mod:`motiondb.files.arrays`). With the added AMC, its
            skeleton is written beside it (.asf).
        canonical : bool
            Write the motion on the canonical body at 30 frames a second.
        changes : MotionChanges, optional
            How the motion is changed before.
        """
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
        return answers.Exported(
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
    ) -> list[answers.MatchFile]:
        """Write the intervals of an answer as BVH, each with its origin and licence beside it.

        The folder is made if there is none. ``question`` is what was asked, for the files beside.
        """
        from motiondb.files.own_files import check_overwriting, provenance_path

        folder = Path(folder)
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise QueryError(
                f"{folder}: expected a folder that can be made, found: {error.strerror}. Name "
                "another."
            ) from None
        paths = [folder / f"{_file_name(match)}.bvh" for match in answer.matches]
        for path in paths:  # before any is written
            check_overwriting(path)
            check_overwriting(provenance_path(path))
        with self.session.reading():
            return [self._write_match(*each, question) for each in zip(answer.matches, paths)]

    def _write_match(self, match: Match, path: Path, question: str) -> answers.MatchFile:
        """Write one match and its origin."""
        from motiondb.database.catalogue.parts import write_bytes
        from motiondb.files.own_files import WRITER, digest_of, provenance_path

        info = store.load_capture(self.store, match.capture)
        sources = store.load_provenance(self.store, info.capture_id).sources
        licence = info.tags.get("licence", "unknown")
        self.export(match.capture, path, match.start, match.end)
        origin = {
            "written_by": WRITER,
            "sha256": digest_of(path),
            "question": question,
            "rank": match.rank,
            "capture": match.capture,
            "start": match.start,
            "end": match.end,
            "place": match.place,
            "score": match.score,
            "probability": match.probability,
            "kind": info.kind,
            "licence": licence,
            "performer": info.tags.get("performer", "unknown"),
            "file": info.path,
            "file_sha256": info.sha256,
            "made_of": [vars(source) for source in sources],
        }
        beside = provenance_path(path)
        write_bytes(beside, json.dumps(answers.to_json(origin), indent=1).encode())
        return answers.MatchFile(match.rank, match.capture, path, beside, licence)

    def compare(
        self, first: Example, second: Example, png: str | Path | None = None
    ) -> answers.Comparison:
        """Align two examples by dynamic time warping, and measure how far they are apart.

        Poses are compared on the standard body, relative to the pelvis and the heading. ``png``
        draws the distances of all poses with the alignment into this file.
        """
        from motiondb import pictures
        from motiondb.body.body import JOINTS
        from motiondb.search.alignment import MOST_POSES, align
        from motiondb.search.copies import copy_poses, mirror_poses

        names = [str(e) if isinstance(e, str | Path) else "motion" for e in (first, second)]
        motions = self.motion(first), self.motion(second)
        step = math.ceil(max(motion.n_frames for motion in motions) / MOST_POSES)
        poses, others = (copy_poses(motion)[::step] for motion in motions)
        found, mirrored = align(poses, others), align(mirror_poses(poses), others)
        times = found.path.T * (step / MOTION_FPS)
        if png is not None:
            spans = [(0.0, motion.n_frames / MOTION_FPS) for motion in motions]
            figure = pictures.comparison_figure(
                (names[0], names[1]), found.costs, (times[0], times[1]), (spans[0], spans[1])
            )
            pictures.save_png(figure, png)
        order = np.argsort(-found.joint_distances)
        return answers.Comparison(
            names[0],
            names[1],
            round(float(found.distances.mean()), 4),
            round(float(mirrored.distances.mean()), 4),
            round(motions[0].duration, 3),
            round(motions[1].duration, 3),
            tuple(
                answers.JointDistance(JOINTS[n], round(float(found.joint_distances[n]), 4))
                for n in order
            ),
            tuple((round(float(a), 3), round(float(b), 3)) for a, b in zip(*times)),
            None if png is None else Path(png),
        )

    def draw_matches(
        self,
        answer: WordAnswer | ExampleAnswer,
        path: str | Path,
        title: str = "",
        example: Motion | None = None,
    ) -> Path:
        """Draw the first matches, below an example if given, as rows of stick figures (PNG)."""
        from motiondb.database import searching

        return searching.draw_matches(self.session, answer.matches, path, title, example)

    def draw_reasons(self, answer: WordAnswer, path: str | Path, title: str = "") -> Path:
        """Draw the best match over a timeline of contributions for each word, as PNG.

        QueryError is raised for an answer without reasons, such as one by symbols.
        """
        from motiondb.database import searching

        return searching.draw_reasons(self.session, answer, path, title)

    def captions(self, name: str) -> tuple[Caption, ...]:
        """The captions of a capture."""
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_captions(self.store, [number]).get(number, ())

    def all_captions(self) -> dict[int, tuple[Caption, ...]]:
        """The captions of all captures, by capture number."""
        with self.session.reading():
            return dict(store.load_captions(self.store))

    def events(self, name: str) -> tuple[Event, ...]:
        """Instants of a capture, by frames of its motion (30 a second)."""
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_events(self.store, [number]).get(number, ())

    def all_events(self) -> dict[int, tuple[Event, ...]]:
        """Instants of all captures that have any, by capture number."""
        with self.session.reading():
            return dict(store.load_events(self.store))

    def event_rows(self) -> list[answers.EventRow]:
        """The kinds of events, each with its number of events and of captures, by name."""
        known = self.all_events().values()
        events = Counter(event.name for of_one in known for event in of_one)
        captures = Counter(name for of_one in known for name in {e.name for e in of_one})
        return [
            answers.EventRow(name, count, captures[name]) for name, count in sorted(events.items())
        ]

    def segments(self, name: str) -> list[answers.ShownSegment]:
        """Symbols of a capture with their times (seconds); empty if it is not learned."""
        from motiondb.database import showing

        with self.session.reading():
            return showing.searched_segments(self.session, name)

    def activities(self, name: str) -> list[answers.ShownActivity]:
        """The successive activities of a capture; empty if there is only one."""
        from motiondb.database import showing

        with self.session.reading():
            info = store.load_capture(self.store, name)
            return showing.capture_activities(self.session, info.capture_id)

    def provenance(self, name: str) -> Provenance:
        """Origin of every frame of a generated capture; without sources for a captured one."""
        with self.session.reading():
            info = store.load_capture(self.store, name)
            return store.load_provenance(self.store, info.capture_id)

    def show(self, name: str) -> answers.CaptureFacts:
        """Facts of one capture, for print or JSON; times in seconds."""
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
        """Draw a capture, or a part of it, as an animated GIF of a stick figure in real time."""
        from motiondb import pictures

        with self.session.reading():
            name = store.load_capture(self.store, name).name
            return pictures.draw_animation(self.motion(name, start, end), path)


def _file_name(match: Match) -> str:
    """The name of a file: rank, capture and interval."""
    plain = _UNUSUAL.sub("-", match.capture.replace("/", "-"))[:100]
    return f"{match.rank:03d}_{plain}_{match.start:.2f}-{match.end:.2f}"
