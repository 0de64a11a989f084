"""The database as its users know it; other verbs stand in ``db.captures``, ``db.words``, ..."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb import answers, store
from motiondb.database.library import Library
from motiondb.database.session import Session
from motiondb.database.values import FORMER, Where, check_least, check_text, listed, seeds_from
from motiondb.errors import MotionDBError
from motiondb.workers import HERE

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from motiondb.database.captures import Captures
    from motiondb.database.catalogue import cataloguing, exporting
    from motiondb.database.catalogue.exporting import MotionChanges
    from motiondb.database.cluster import Cluster
    from motiondb.database.generated_files import Joined
    from motiondb.database.generating import ActionPlace, Generated
    from motiondb.database.grammars.grammars import Grammars
    from motiondb.database.questions import Question
    from motiondb.database.scenes.scenes import Scenes
    from motiondb.database.tables import Tables
    from motiondb.database.values import Example
    from motiondb.database.words import Symbols, Words
    from motiondb.learn.knowledge import Knowledge
    from motiondb.learn.learned import Learned
    from motiondb.learn.learned_model import LearnedModel
    from motiondb.learn.recognition import LearnSettings, Progress
    from motiondb.records import Clip, Motion
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.described import Description


class MotionDB(Library):
    """A motion database: add captures, learn, ask, generate. Use it in a ``with`` statement.

    Threads may share it. Every question is answered from one revision of the database, even if
    other threads or processes save changes meanwhile.

    Units and frames: metres, seconds, radians; right-handed world frame, y up; rotations as unit
    quaternions w, x, y, z; motions on the canonical body at 30 frames a second.

    ``name`` is the name of a capture, and ``names`` several. ``where`` is a filter on columns and
    tags of the catalogue, such as "performer=14", or a list of names; a verb with both takes the
    captures of either. ``example`` is a file, the name of a stored capture, or a motion; ``start``
    and ``end`` are the part of it, in seconds. ``progress`` is called with the name of the step,
    the number done, and the total number; of learning, with the step and the share that is done.
    QueryError is raised where there is no such capture, a filter cannot be read, or a part lies
    outside its capture, and another MotionDBError where a file cannot be read or written; nothing
    is changed then. ``exact`` leaves out words that no caption holds; otherwise a word that may be
    taken as a known one is replaced. NotLearnedError is raised where the database has not learned,
    or learned no words and the question needs them.

    Parameters
    ----------
    path : str or Path
        The DuckDB file.
    read_only : bool
        Only ask; several processes may do so at once.
    create : bool
        Make the file if there is none (never when ``read_only``).
    wait : float
        Seconds to wait for another process that holds the file.

    Raises
    ------
    StoreError
        When another process holds the file, or it is not a database of motiondb, or was written by
        a newer motiondb.
    """

    def __init__(
        self, path: str | Path, *, read_only: bool = False, create: bool = True, wait: float = 0.0
    ) -> None:
        self.session = Session(path, read_only=read_only, create=create, wait=wait)

    @cached_property
    def captures(self) -> Captures:
        """The verbs of captures: list (``db.captures()``), show, remove, rename, set_tags, ..."""
        from motiondb.database.captures import Captures

        return Captures(self.session)

    @cached_property
    def words(self) -> Words:
        """The verbs of captions and words: set, add, history, export, rows, ..."""
        from motiondb.database.words import Words

        return Words(self.session)

    @cached_property
    def symbols(self) -> Symbols:
        """The verbs of what was learned: rows, segments, draw, drift, export_knowledge, ..."""
        from motiondb.database.words import Symbols

        return Symbols(self.session)

    @cached_property
    def grammars(self) -> Grammars:
        """The verbs of grammars: learn, show, parse, suggest, generate, edit, compare, remove."""
        from motiondb.database.grammars.grammars import Grammars

        return Grammars(self.session)

    @cached_property
    def scenes(self) -> Scenes:
        """The verbs of scenes: make, update, write, keep, load, draw, remove."""
        from motiondb.database.scenes.scenes import Scenes

        return Scenes(self.session)

    @cached_property
    def tables(self) -> Tables:
        """Captures, captions, segments, symbols, words and matches as Arrow tables."""
        from motiondb.database.tables import Tables

        return Tables(self.session)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """A verb by its former name."""
            if name not in FORMER:
                raise AttributeError(f"MotionDB has no attribute {name!r}")
            return attrgetter(FORMER[name])(self)

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self.session.close()

    def release(self) -> None:
        """Close the file until the next use, so that other processes can write.

        Loaded data stay in memory until the database changes. The next question opens the file for
        reading, the next change for writing; each waits for other processes as long as ``wait``.
        """
        self.store.lend()

    def revision(self) -> int:
        """The number that every saved change raises, of this or another process."""
        with self.session.reading():
            return store.revision(self.store)

    def __enter__(self) -> MotionDB:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

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
            A capture is named by its path below its folder.
        words : str or Path, optional
            Sheet of words and tags, TSV or CSV.
        settings : AddSettings, optional
            How files are read and named, and whether they replace captures.
        events : str or Path, optional
            Sheet of events, TSV or CSV.
        workers : Cluster, optional
            Who reads and compares; the files' bytes are sent to it. None: ``settings.jobs``.

        Raises
        ------
        MotionDBError
            When there are no captures to add, or a sheet cannot be read.
        """
        from motiondb.database.catalogue import cataloguing, sheets

        given = sheets.Sheets.read(words, events)
        paths = [Path(each) for each in ([folder] if isinstance(folder, str | Path) else folder)]
        asked = settings or cataloguing.AddSettings()
        return cataloguing.add_captures(self.store, paths, given, asked, progress, workers)

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

        return updating.undo(self.session, run)

    def runs(self) -> list[dict[str, Any]]:
        """All runs that changed the database, oldest first: kind, parameters, seed, version."""
        return [asdict(run) for run in store.load_runs(self.store)]

    def check(self) -> list[str]:
        """Faults of the store, none in a sound one."""
        from motiondb.database.checking import check

        return check(self.store)

    def backup(self, path: str | Path) -> Path:
        """Copy one state of the database into a new file, and check the copy.

        Others may use the database meanwhile. The copy has no unused space. StoreError is raised if
        there is such a file, it cannot be written, or the copy has faults.
        """
        from motiondb.database.checking import check_file

        store.backup(self.store, Path(path), check_file)
        return Path(path)

    def info(self) -> answers.DatabaseInfo:
        """What is in the database: numbers of captures, grammars, symbols and words."""
        from motiondb.database.catalogue import browsing

        with self.session.reading():
            return browsing.database_info(self.session)

    def motion(
        self, example: Example, start: float | None = None, end: float | None = None
    ) -> Motion:
        """A motion, or a part of it, on the canonical body, at 30 frames a second."""
        from motiondb.database.catalogue.parts import load_example

        return load_example(self.session, example, start, end)

    def clip(self, name: str, start: float | None = None, end: float | None = None) -> Clip:
        """A stored capture, or a part, on its own skeleton and at its own rate, as it was read."""
        from motiondb.database.catalogue import exporting, parts

        return parts.cut_clip(exporting.load_clip(self.session, name), start, end)

    def export(
        self,
        name: str,
        path: str | Path,
        start: float | None = None,
        end: float | None = None,
        canonical: bool = False,
        changes: exporting.MotionChanges | None = None,
    ) -> answers.Exported:
        """Write a capture to a file: whole in its own format the bytes that were added.

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

        return exporting.export(self.session, name, path, start, end, canonical, changes)

    def learn(
        self,
        settings: LearnSettings | None = None,
        progress: Progress | None = None,
        start: str | Path | Knowledge | None = None,
        where: Where = "",
        workers: Cluster | None = None,
    ) -> LearnedModel:
        """Derive symbols, their space and their words from all captures; replaces earlier ones.

        Parameters
        ----------
        settings : LearnSettings, optional
            What decides the result; the same settings and captures give the same result.
        start : str, Path or Knowledge, optional
            Knowledge of another database to start from: "cmu" is shipped, a path names a file of
            ``db.symbols.export_knowledge``. Its symbols and words are taken over, and own captions
            count more the more there are. None: the start that the database used before, if any;
            "none": nothing.
        where : str or names
            Learn from these captures alone. The others are not searched; :meth:`evaluate` measures
            the answers about them.
        workers : Cluster, optional
            Who computes features, symbols and scores; the result is the same. None: threads of
            this process.

        Raises
        ------
        MotionDBError
            When no captures match, or they have fewer segments than the requested symbols;
            KnowledgeError when there is no such knowledge.
        """
        from motiondb.database.learn import learn_run
        from motiondb.learn.recognition import LearnSettings

        asked, how = self.session.filter(where), settings or LearnSettings()
        return learn_run.learn(self.store, how, progress, start, asked, workers or HERE)

    def evaluate(
        self, where: Where = "", progress: Progress | None = None, workers: Cluster | None = None
    ) -> answers.Evaluation:
        """Measure the answers about captures that the database has not learned from.

        Their captions judge, and are no evidence. Words, captions and examples are asked for among
        these captures, where an example may find takes of its own performer; intervals of timed
        captions are found in their captures. Learn from the others before (:meth:`learn`). The
        scores are the same whoever answers: ``workers``, or this process.

        Raises
        ------
        QueryError
            When it has learned from one of the captures, or fewer than two have captions.
        """
        from motiondb.database.evaluating import evaluate

        asked, tell = self.session.filter(where), progress or (lambda _what, _share: None)
        return evaluate(self.session, asked, tell, workers or HERE)

    def is_learned(self) -> bool:
        """Whether the database has learned."""
        return store.is_learned(self.store)

    @property
    def learned(self) -> Learned:
        """The learned model, with the catalogue of the same revision."""
        return self.session.learned

    @property
    def searchable(self) -> Learned:
        """The learned model, with the generated captures in addition to those learned from."""
        return self.session.searchable

    def search(
        self,
        words: str,
        where: Where = "",
        limit: int = 10,
        by_symbols: bool = False,
        written: bool = True,
        exact: bool = False,
    ) -> WordAnswer:
        """Find the intervals that show the actions of a question, best first.

        Parameters
        ----------
        words : str
            The question, such as "walk, turn left".
        limit : int
            Largest number of matches.
        by_symbols : bool
            Decode the words to symbols and align these with the captures, as in paper A.
        written : bool
            Whether captions count as evidence, in addition to the motion.

        Raises
        ------
        QueryError
            Also when no word is known or taken as a known one.
        """
        from motiondb.database import searching

        check_text("words", words)
        check_least("limit", limit, 1)
        with self.session.reading():
            allowed = searching.allowed_captures(self.session, where, exact)
            searching.check_any(self.searchable)
            return searching.answer_words(
                self.session, words, allowed, limit, exact, written, by_symbols
            )

    def like(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
        where: Where = "",
        limit: int = 10,
        meaning: bool | None = None,
        exact: bool = False,
    ) -> ExampleAnswer:
        """Find the intervals that move like an example, best first.

        Parameters
        ----------
        limit : int
            Largest number of matches.
        meaning : bool, optional
            Whether learned words take part in the resemblance, so that the same action in other
            styles counts as alike; None: if there are words.
        exact : bool
            Whether unknown words of the filter match nothing; otherwise known ones replace them.
        """
        from motiondb.database import searching
        from motiondb.search.by_example import search_motion

        check_least("limit", limit, 1)
        with self.session.reading():
            motion = self.motion(example, start, end)
            allowed = searching.allowed_captures(self.session, where, exact)
            return search_motion(
                self.searchable, self.session.frames, motion, allowed, limit, meaning
            )

    def ask_many(
        self, questions: Iterable[Question | str], workers: Cluster | None = None
    ) -> Iterator[WordAnswer | ExampleAnswer | MotionDBError]:
        """Answer many questions, in their order.

        A question that cannot be answered gives its error in place of an answer. With workers, all
        questions are of one state of the database; otherwise each is of its state at that moment.

        Parameters
        ----------
        questions : iterable of Question or str
            Words ("walk"), or questions, such as ``Question(like="ana/kick_1", limit=3)``.
        workers : Cluster, optional
            Workers that answer some of the questions each; the answers are the same. They open this
            database themselves: it has to be opened to read only, in a folder that all of them see
            under the same path. None: this process, one question after the other.

        Raises
        ------
        ClusterError
            When a worker cannot open the database.
        """
        from motiondb.database import questions as asked

        return asked.ask_many(self.session, questions, workers)

    def describe(
        self, example: Example, start: float | None = None, end: float | None = None
    ) -> tuple[Description, ...]:
        """The words of a motion over time, with probabilities."""
        from motiondb.search.described import describe

        with self.session.reading():
            return describe(self.learned, self.motion(example, start, end))

    def compare(
        self, first: Example, second: Example, png: str | Path | None = None
    ) -> answers.Comparison:
        """Align two examples by dynamic time warping, and measure how far they are apart.

        Poses are compared on the standard body, relative to the pelvis and the heading. ``png``
        draws the distances of all poses with the alignment into this file.
        """
        from motiondb.database import searching

        return searching.compare(self.session, first, second, png)

    def generate(
        self,
        words: str,
        seed: int = 0,
        method: str = "stitched",
        exact: bool = False,
        anyway: bool = False,
        places: Sequence[ActionPlace] = (),
    ) -> Generated:
        """Generate a motion from a sentence.

        ``shown`` of the result says for every action whether the motion shows it.

        Parameters
        ----------
        words : str
            The sentence, such as "a person walks slowly, then kicks twice".
        seed : int
            The same seed gives the same motion, another seed another one if there is a choice.
        method : str
            "stitched" (excerpts of captures) or "trajectory" (most probable smooth trajectory).
        anyway : bool
            Whether to generate the nearest motion if nothing in the database shows an action.
        places : sequence of ActionPlace
            Where each action is taken from, in the order of the sentence; none leaves the choice
            free. Stitched motion only.

        Raises
        ------
        QueryError
            For an unknown method, no known word, an action that nothing in the database shows, or
            places that are not one for each action, or lie outside their captures.
        """
        from motiondb.database import generating

        check_text("words", words)
        return generating.generate(
            self.session, words, seeds_from(seed, 1), method, exact, anyway, places=places
        )[0]

    def generate_variants(
        self,
        words: str,
        number: int,
        seed: int = 0,
        method: str = "stitched",
        exact: bool = False,
        anyway: bool = False,
        changes: MotionChanges | None = None,
    ) -> list[Generated]:
        """Make several motions from one sentence: those of the seed and of the following seeds.

        Stitched motions that are made from the same places of captures as an earlier one are left
        out. If there are fewer different ones than asked for, fewer are returned. The other
        arguments are as for :meth:`generate`.

        Parameters
        ----------
        number : int
            Most motions; "trajectory" has one only.
        changes : MotionChanges, optional
            Whether the motions are looped, put in place or mirrored before they are judged. The
            other changes are those of files (:meth:`Generated.write`).
        """
        from motiondb.database import generating

        seeds = seeds_from(seed, number)
        return generating.generate(self.session, words, seeds, method, exact, anyway, changes)

    def judge(
        self,
        example: Example,
        sentence: str,
        start: float | None = None,
        end: float | None = None,
        exact: bool = False,
    ) -> answers.Judgement:
        """Say whether a motion of any origin shows a sentence: its actions, order and counts."""
        from motiondb.database import judging

        motion = self.motion(example, start, end)
        return judging.judge(self.session, example, motion, sentence, exact)

    def join(self, parts: Sequence[str], changes: MotionChanges | None = None) -> Joined:
        """Join parts of captures, with the blending of generated motion.

        Parameters
        ----------
        parts : sequence of str
            Each ``CAPTURE:FROM-TO`` in seconds, such as "walk:0.5-2", or the name of a capture.
        changes : MotionChanges, optional
            Whether the motion is looped, put in place or mirrored.
        """
        from motiondb.database import generated_files

        return generated_files.join_parts(self.session, listed("parts", parts), changes)
