"""The verbs of captures: ``db.captures()`` lists them; ``show``, ``remove``, ``rename``, ..."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb import answers, pictures, records, store
from motiondb.database.catalogue import browsing
from motiondb.database.catalogue.parts import load_example
from motiondb.database.session import Session, Topic
from motiondb.database.values import ANY, FOLDER, Where, folder_names, listed, names_by_pattern
from motiondb.errors import QueryError
from motiondb.store import CAPTION, COLUMNS
from motiondb.tabled import Listed, Tupled

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from matplotlib.figure import Figure

    from motiondb.database.catalogue import cataloguing, sheets
    from motiondb.database.generated_files import Made
    from motiondb.database.values import Example
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.takings import Taking

_CONDITION = re.compile(r"[=<>~(]|\b(and|or|not)\b", re.IGNORECASE)  # What a filter has, no name
_SHOWN_COLUMNS = ("name", "duration", "fps", "format", "tags")  # Of a list of captures
_SHOWN = 8  # Most matches in a picture: more would be too small on a screen
_LEAST_SHARE = 0.005  # Nats from which on a contribution is drawn: smaller ones round to 0.00


class Captures(Topic):
    """The captures of a database, available as ``db.captures``; :class:`MotionDB` says how to ask.

    ``db.captures("performer=14")`` lists captures. ``answer`` is what ``search`` or ``like`` gives.
    ``path`` of a picture is the file, which is returned.
    """

    def __call__(
        self, where: Where = "", exact: bool = False, sort: str = ""
    ) -> list[records.CaptureInfo]:
        """The catalogue.

        ``exact``: whether words of ``where`` that are in no caption and no tag match nothing;
        otherwise such a word may be replaced by a known one (:meth:`taken_in_filter`). ``sort``:
        column or tag to sort by, such as "duration"; "-duration": the longest first. "": in order
        of number.
        """
        with self.session.reading():
            where = self.session.filter(where)
            if exact or not where.strip():
                infos = store.load_captures(self.store, where)
            else:
                from motiondb.database.catalogue import filter_words

                filters = filter_words.take_filter_words(self.store, where)[0]
                infos = store.load_captures(self.store, filters)
            infos = browsing.sort_captures(self.session, infos, sort) if sort else infos
            return Listed(infos, *_SHOWN_COLUMNS)

    def browse(
        self, where: Where = "", sort: str = "name", offset: int = 0, limit: int = 100
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
        return browsing.browse(self.session, self.session.filter(where), sort, offset, limit)

    def browsed(self, name: str) -> browsing.BrowsedCapture | None:
        """The row of the capture of exactly this name; None if there is none."""
        with self.session.reading():
            return browsing.rows_by_name(self.session).get(name)

    def facets(self, where: Where = "") -> tuple[browsing.Facet, ...]:
        """How many captures have each value of columns and tags."""
        return browsing.facets(self.session, self.session.filter(where))

    def taken_in_filter(self, where: Where) -> Mapping[str, Taking]:
        """The known words that replace words of a filter that are in no caption and no tag."""
        where = self.session.filter(where)
        if not where.strip():
            return {}
        from motiondb.database.catalogue import filter_words

        with self.session.reading():
            return filter_words.take_filter_words(self.store, where)[1]

    def add_sample(self, progress: cataloguing.Progress | None = None) -> answers.AddReport:
        """Add the sample data: 101 synthetic captures, CC0-1.0, with words and events.

        MotionDBError is raised, and nothing added, where the database has captures of others.
        """
        from motiondb.database.catalogue import sample

        return sample.add_sample(self.store, progress)

    def unlearned(self) -> list[str]:
        """Names of captured captures that no question searches: added and not counted."""
        return browsing.unlearned_captures(self.session)

    def relations(self, name: str | None = None) -> list[records.Relation]:
        """Copies, mirror images and cuts; of one capture, or of all."""
        with self.session.reading():
            full = store.load_capture(self.store, name).name if name else None
            return Listed(store.load_relations(self.store, full))

    def duplicates(self, where: Where = "") -> tuple[records.DuplicateGroup, ...]:
        """Groups of captures that repeat one another, with at least one that matches."""
        from motiondb.search.copies import group_duplicates

        with self.session.reading():
            durations = {info.name: info.duration for info in self()}
            groups = group_duplicates(self.relations(), durations)
            wanted = {info.name for info in self(where)}
            return Tupled(group for group in groups if wanted & set(group.captures))

    def faulty_files(self) -> list[answers.FaultyFile]:
        """The files that could not be read when they were added, until they are without fault."""
        with self.session.reading():
            return Listed(answers.FaultyFile(*row) for row in store.load_faulty(self.store))

    def same_files(self) -> list[answers.SameFile]:
        """The files that were added although a capture of another name has their content."""
        with self.session.reading():
            return Listed(answers.SameFile(*row) for row in store.load_same_files(self.store))

    def tag_rows(self) -> list[answers.TagRow]:
        """Every tag with its number of captures and of different values, by name."""
        with self.session.reading():
            values: dict[str, list[str]] = {}
            for info in store.load_captures(self.store):
                for key, value in info.tags.items():
                    values.setdefault(key, []).append(value)
        return Listed(
            answers.TagRow(key, len(of), len(set(of))) for key, of in sorted(values.items())
        )

    def events(self, name: str) -> tuple[records.Event, ...]:
        """Instants of a capture, by frames of its motion (30 a second)."""
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_events(self.store, [number]).get(number, ())

    def all_events(self) -> dict[int, tuple[records.Event, ...]]:
        """Instants of all captures that have any, by capture number."""
        with self.session.reading():
            return dict(store.load_events(self.store))

    def event_rows(self) -> list[answers.EventRow]:
        """The kinds of events, each with its number of events and of captures, by name."""
        known = self.all_events().values()
        events = Counter(event.name for of_one in known for event in of_one)
        captures = Counter(name for of_one in known for name in {e.name for e in of_one})
        return Listed(
            answers.EventRow(name, count, captures[name]) for name, count in sorted(events.items())
        )

    def segments(self, name: str) -> list[answers.ShownSegment]:
        """Symbols of a capture with their times (seconds); empty if it is not learned."""
        from motiondb.database import showing

        with self.session.reading():
            return Listed(showing.searched_segments(self.session, name))

    def activities(self, name: str) -> list[answers.ShownActivity]:
        """The successive activities of a capture; empty if there is only one."""
        from motiondb.database import showing

        with self.session.reading():
            info = store.load_capture(self.store, name)
            return Listed(showing.capture_activities(self.session, info.capture_id))

    def provenance(self, name: str) -> store.Provenance:
        """Origin of every frame of a generated capture; without sources for a captured one."""
        with self.session.reading():
            info = store.load_capture(self.store, name)
            return store.load_provenance(self.store, info.capture_id)

    def show(self, name: str) -> answers.CaptureFacts:
        """Facts of one capture, for print or JSON; times in seconds."""
        from motiondb.database import showing

        with self.session.reading():
            return showing.describe_capture(self.session, name)

    def draw(self, name: str, path: str | Path | None = None) -> Path | Figure:
        """Draw a capture as a strip of stick figures over its timelines, as PNG."""
        from motiondb.database import showing

        with self.session.reading():
            return showing.draw_capture(self.session, name, path)

    def animate(
        self, name: str, path: str | Path, start: float | None = None, end: float | None = None
    ) -> Path:
        """Draw a capture, or a part of it, as an animated GIF of a stick figure in real time."""
        with self.session.reading():
            name = store.load_capture(self.store, name).name
            return pictures.draw_animation(load_example(self.session, name, start, end), path)

    def remove(self, names: Iterable[str] = (), where: Where = "") -> list[str]:
        """Remove captures, all or none, and return their full names.

        Their counts are removed from the learned model. ``MotionDB.undo`` brings them back
        until the file is compacted.
        """
        from motiondb.database.learn import updating

        with store.transaction(self.store):
            infos = chosen(self.session, names, where)
            numbers = [info.capture_id for info in infos]
            parameters = {"names": [info.name for info in infos]}
            if numbers:
                with updating.changing(self.store, "remove", parameters, numbers):
                    store.remove_captures(self.store, numbers)
        return [info.name for info in infos]

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
                chosen = store.load_named(opened, listed("captures", captures))
                renamed = names_by_pattern([info.name for info in chosen], old, new)
            elif old.endswith(FOLDER):
                renamed = folder_names(everyone, old, new)
            elif ANY in old and old not in everyone:
                renamed = names_by_pattern(everyone, old, new)
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
                    store.rename_captures(opened, numbers)
        return changed

    def set_tags(
        self, tags: Mapping[str, str], names: Iterable[str] = (), where: Where = ""
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
            infos = chosen(self.session, names, where)
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
            return store.change_tags(self.store, given, every)

    def save_generated(self, name: str, words: str, made: Made, seed: int) -> records.CaptureInfo:
        """Keep a generated motion as a capture, with the origin of every frame."""
        from motiondb.database.generated_files import keep_generated

        opened, captions = self.store, [records.Caption(words)]
        with (
            store.running(opened, "generate", {"words": words}, seed) as run_id,
            store.noting_edits(opened, run_id),
        ):
            return keep_generated(opened, name, made.motion, made.provenance, captions, run_id)

    def check_name_free(self, name: str) -> None:
        """Refuse a name that is empty, or that a capture has already."""
        from motiondb.database.catalogue.cataloguing import check_name_free

        check_name_free(self.store, name)

    def import_events(self, sheet: str | Path) -> sheets.EventReport:
        """Replace the events of the captures that a sheet (TSV or CSV) names."""
        from motiondb.database.catalogue import sheets

        return sheets.import_events(self.store, sheet)

    def to_movement(self, name: str, start: float | None = None, end: float | None = None) -> Any:  # noqa: ANN401
        """A capture, or a part of it, as an ``xarray.Dataset`` in the form of movement.

        Poses of the capture's own joints at its own rate, metres, in the world of its file; one
        individual, called as its performer. Confidence is NaN. ``to_netcdf`` of the data set
        writes a file that ``add`` reads again. It needs the extra ``movement``.
        """
        from motiondb.database.catalogue import exporting, parts
        from motiondb.files.readers.movement import to_dataset

        with self.session.reading():
            info = store.load_capture(self.store, name)
            clip = parts.cut_clip(exporting.load_clip(self.session, info.name), start, end)
        return to_dataset(clip, info.tags.get("performer", "id_0"), info.path)

    def to_humanml3d(self, where: Where, folder: str | Path) -> answers.DataSet:
        """Write captures in the form of HumanML3D into a new folder.

        263 numbers a frame at 20 a second for SMPL's joints (``new_joint_vecs``), the places that
        these give (``new_joints``), captions (``texts``), ``Mean.npy`` and ``Std.npy``; see
        :mod:`motiondb.files.humanml3d`. ``where``: a filter, the name of a capture, or names.
        """
        from motiondb.database.catalogue import exporting

        return exporting.write_humanml3d(self.session, self._of(where), Path(folder))

    def gait(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
        png: str | Path | None = None,
    ) -> answers.GaitReport:
        """Foot strikes of a motion at its own rate, and what the cycles between them measure.

        ``png`` draws the strikes from above, and the angles of hip, knee and ankle over the cycle.
        """
        from motiondb.database import showing

        return showing.gait_of(self.session, example, start, end, png)

    def features(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
        whitened: bool = False,
    ) -> records.Float32Array:
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
            features = recognition_features(load_example(self.session, example, start, end))
            return self.session.learned.feature_space.project(features) if whitened else features

    def export_matches(
        self, answer: WordAnswer | ExampleAnswer, folder: str | Path, question: str = ""
    ) -> list[answers.MatchFile]:
        """Write the intervals of an answer as BVH, each with its origin and licence beside it.

        The folder is made if there is none. ``question`` is what was asked, for the files beside.
        """
        from motiondb.database.catalogue import exporting

        return exporting.write_matches(self.session, answer.matches, Path(folder), question)

    def along(
        self,
        path: str | Sequence[Sequence[float]],
        words: str = "",
        where: Where = "",
        limit: int = 10,
        exact: bool = False,
    ) -> ExampleAnswer:
        """Find the intervals that travel along a path on the floor, best first.

        `path`: Points ("0,0 0,2 -1.5,2"), m to the right and up as seen from above; place and
        direction are free. `words`: What is done along it, such as "walk".
        """
        from motiondb.database import searching

        with self.session.reading():
            allowed = searching.allowed_captures(self.session, where, exact)
            return searching.answer_path(self.session, path, words, allowed, limit, exact)

    def rhythm(
        self,
        taps: str | Sequence[float],
        words: str = "",
        where: Where = "",
        limit: int = 10,
        exact: bool = False,
    ) -> ExampleAnswer:
        """Find the intervals whose steps fall at tapped times, best first.

        `taps`: Seconds ("0 .5 1 1.5"); the first may be at any moment, and steps .8 to 1.25 times
        as fast. `words`: What is done in this rhythm, such as "walk".
        """
        from motiondb.database import searching

        with self.session.reading():
            allowed = searching.allowed_captures(self.session, where, exact)
            return searching.answer_rhythm(self.session, taps, words, allowed, limit, exact)

    def draw_matches(
        self,
        answer: WordAnswer | ExampleAnswer,
        path: str | Path | None = None,
        title: str = "",
        example: records.Motion | None = None,
    ) -> Path | Figure:
        """Draw the first matches, below an example if given, as rows of stick figures (PNG)."""
        with self.session.reading():
            hits = [(match, self._motion(match.capture)) for match in answer.matches[:_SHOWN]]
        query = None if example is None else ("query", example)
        return pictures.save_png(pictures.hits_figure(hits, title, query), path)

    def _motion(self, name: str) -> records.Motion:
        return store.load_motion(self.store, store.load_capture(self.store, name).capture_id)

    def quality(
        self,
        where: Where = "",
        again: bool = False,
        progress: Callable[[str, float, float], None] | None = None,
    ) -> answers.QualityAnswer:
        """What captures lack: things they need, faults, wrong units and rates.

        Captures are measured once, on their own skeletons, in metres and at their own rates; the
        findings are kept with them.

        ``where``: a filter, the name of a capture, or names. ``again``: measures anew what was
        measured before. ``progress`` is called with what is done, how much, and of how much.
        """
        from motiondb.database.catalogue import assessing

        return assessing.quality_of(self.session, self._of(where), again, progress)

    def findings(self, name: str) -> tuple[records.Finding, ...]:
        """What a capture lacks, as far as it was measured before."""
        number = store.load_capture(self.store, name).capture_id
        known = store.load_quality(self.store, [number])
        return known[number].findings if known else ()

    def ghosts(self, name: str) -> tuple[answers.Ghost, ...]:
        """Boxes for what a capture needs, in the world of its motion on the standard body."""
        from motiondb.database.catalogue import assessing

        with self.session.reading():
            return assessing.ghosts(self.session, name)

    def write_boxes(self, where: Where, path: str | Path) -> Path:
        """Write what captures need as boxes: .json, or .xml (MJCF) of one capture.

        Metres, in the world of the capture's file. Captures are measured where they were not.
        """
        from motiondb.database.catalogue import assessing

        infos = self._of(where)
        self.quality([info.name for info in infos])
        known = store.load_quality(self.store, [info.capture_id for info in infos])
        found = {i.name: known[i.capture_id] for i in infos if i.capture_id in known}
        assessing.write_boxes(self.session, found, Path(path))
        return Path(path)

    def draw_quality(self, name: str, path: str | Path | None = None) -> Path | Figure:
        """Draw a capture at its places, with what it needs as boxes, as PNG."""
        from motiondb.database.catalogue import assessing

        return assessing.draw_quality(self.session, name, path)

    def _of(self, where: Where) -> list[records.CaptureInfo]:
        """The captures of a filter, or of the name that it is."""
        if isinstance(where, str) and where.strip():
            names = self.store.connection.column("SELECT name FROM capture")
            if any(name == where or name.endswith(f"/{where}") for name in names):
                return [store.load_capture(self.store, where)]
        try:
            return self(where)
        except QueryError:
            if isinstance(where, str) and not _CONDITION.search(where):
                store.load_capture(self.store, where)  # says that it is no name
            raise

    def draw_reasons(
        self, answer: WordAnswer, path: str | Path | None = None, title: str = ""
    ) -> Path | Figure:
        """Draw the best match over a timeline of contributions for each word, as PNG.

        QueryError is raised for an answer without reasons, such as one by symbols.
        """
        if not answer.explanations:
            raise QueryError(
                f"{title}: expected an answer with reasons, found one without. Search for words, "
                "not by symbols, that some capture shows."
            )
        best, why = answer.matches[0], answer.explanations[0]
        timelines = []
        for word in (*why.words, *(word for one in why.excluded for word in one.words)):
            spans = [(s.from_, s.to, f"{s.share:+.2f}", s.symbol) for s in word.symbols]
            drawn = [span for span, s in zip(spans, word.symbols) if abs(s.share) > _LEAST_SHARE]
            timelines.append(pictures.Timeline(word.word, drawn))
        span = (best.start, best.end, f"{best.start:.1f}-{best.end:.1f} s", 0)
        timelines.append(pictures.Timeline("found", [span]))
        with self.session.reading():
            motion = self._motion(best.capture)
        figure = pictures.strip_figure(motion, f"{title}: {best.capture}", timelines)
        return pictures.save_png(figure, path)


def chosen(session: Session, names: Iterable[str], where: Where) -> list[records.CaptureInfo]:
    """The captures of some names, and those that match a filter; each once."""
    infos = store.load_named(session.store, listed("names", names))
    where = session.filter(where)
    infos += store.load_captures(session.store, where) if where.strip() else []
    return list({info.capture_id: info for info in infos}.values())
