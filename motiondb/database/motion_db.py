"""The database as its users know it: one method for each verb, on captures in its base class."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from motiondb import answers, store
from motiondb.database.captures import Captures
from motiondb.database.session import Session
from motiondb.database.values import check_least, check_text, listed, seeds_from
from motiondb.workers import HERE

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from motiondb.database.catalogue.exporting import MotionChanges
    from motiondb.database.cluster import Cluster
    from motiondb.database.generating import ActionPlace, Generated
    from motiondb.database.grammars.grammars import Grammars
    from motiondb.database.joining import Joined
    from motiondb.database.questions import Question
    from motiondb.database.scenes.scenes import Scenes
    from motiondb.database.values import Example
    from motiondb.errors import MotionDBError
    from motiondb.learn.drift import Drift
    from motiondb.learn.knowledge import Knowledge
    from motiondb.learn.learned import Learned
    from motiondb.learn.learned_model import LearnedModel
    from motiondb.learn.recognition import LearnSettings, Progress
    from motiondb.records import Motion
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.chances import WordSource
    from motiondb.search.described import Description


class MotionDB(Captures):
    """A motion database: add captures, learn, ask, generate. Use it in a ``with`` statement.

    Threads may share it. Every question is answered from one revision of the database, even if
    other threads or processes save changes meanwhile.

    Units and frames: metres, seconds, radians; right-handed world frame, y up; rotations as unit
    quaternions w, x, y, z; motions on the canonical body at 30 frames a second.

    :class:`Archive` and :class:`Captures` say what ``where``, ``start``, ``end``, ``example`` and
    ``path`` are. ``progress`` of learning is called with the step and the share of it that is done.
    ``exact`` leaves out words that no caption holds; otherwise a word that may be taken as a known
    one is replaced. NotLearnedError is raised where the database has not learned, or learned no
    words and the question needs them.

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
        super().__init__(Session(path, read_only=read_only, create=create, wait=wait))

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

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self.session.close()

    @property
    def log_note(self) -> str:
        """What to know of the log beside the file, else "": while open, that the file came without.

        After closing: that the log stays, and holds the latest changes. This happens where a
        program was ended by force and no other has written since.
        """
        return self.session.store.log_note

    @property
    def file_notes(self) -> tuple[str, ...]:
        """What was done to the files of the database, or met there, beside what was asked."""
        return tuple(self.store.notes)

    def release(self) -> None:
        """Close the file until the next use, so that other processes can write.

        Loaded data stay in memory until the database changes. The next question
        opens the file for reading, and the next change for writing; each waits for other processes
        up to the time limit of this object.
        """
        self.store.lend()

    def revision(self) -> int:
        """The number that every saved change raises, of this or another process."""
        with self.session.reading():
            return store.revision(self.store)

    def __enter__(self) -> MotionDB:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def learn(
        self,
        settings: LearnSettings | None = None,
        progress: Progress | None = None,
        start: str | Path | Knowledge | None = None,
        where: str = "",
        workers: Cluster | None = None,
    ) -> LearnedModel:
        """Derive symbols, their space and their words from all captures; replaces earlier ones.

        Parameters
        ----------
        settings : LearnSettings, optional
            What decides the result; the same settings and captures give the same result.
        start : str, Path or Knowledge, optional
            Knowledge of another database to start from: "cmu" is shipped, a path names a file of
            :meth:`export_knowledge`. Its symbols and words are taken over, and own captions count
            more the more there are. None: the start that the database used before, if any;
            "none": nothing.
        where : str
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

        return learn_run.learn(
            self.store, settings or LearnSettings(), progress, start, where, workers or HERE
        )

    def evaluate(
        self,
        where: str = "",
        progress: Progress | None = None,
        workers: Cluster | None = None,
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

        return evaluate(self.session, where, progress or (lambda _what, _share: None), workers)

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

    def drift(self) -> Drift | None:
        """How far captures and words have changed since the database learned.

        None if it has not learned.
        """
        opened = self.store
        with self.session.reading():
            if not store.is_learned(opened):
                return None
            from motiondb.learn import drift
            from motiondb.learn.codec import from_values

            values = store.load_parameters(opened, "drift_baseline", "lemmas")
            baseline = from_values(drift.DriftBaseline, values, "drift_baseline")
            lemmas = from_values(dict[str, str], values, "lemmas")
            texts, synonyms = store.load_texts(opened), store.load_synonyms(opened)
            words = drift.count_word_use(texts, store.load_words(opened), synonyms, lemmas)
            return drift.measure_drift(store.load_segments(opened, scores=False), baseline, words)

    def export_knowledge(self, path: str | Path, name: str = "", credit: str = "") -> Knowledge:
        """Write the learned model, without motion and captions, as a start for other databases.

        Parameters
        ----------
        name : str
            What to call it; the name of the file without its ending if not given.
        credit : str
            The acknowledgement that users are asked to give.

        Raises
        ------
        KnowledgeError
            When it learned with a start itself, or the file cannot be written.
        """
        from motiondb.database.learn import start

        with self.session.reading():
            return start.export(self.store, self.learned, path, name, credit)

    def start_knowledge(self) -> Knowledge:
        """The knowledge that the database started from; NotLearnedError if it did not."""
        from motiondb.database.learn import start

        with self.session.reading():
            return start.start_knowledge(self.learned)

    def start_facts(self) -> answers.StartAnswer | None:
        """The origin of the knowledge that the database started from; None if it did not."""
        from motiondb.database.learn import start

        with self.session.reading():
            return start.start_facts(self.session)

    def search(
        self,
        words: str,
        where: str = "",
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

        return searching.search(self.session, words, where, limit, by_symbols, written, exact)

    def like(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
        where: str = "",
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
            Whether unknown words of the filter match nothing, instead of being replaced by known
            words.
        """
        from motiondb.database import searching
        from motiondb.search.by_example import search_motion

        check_least("limit", limit, 1)
        with self.session.reading():
            motion = self.motion(example, start, end)
            allowed = searching.allowed_captures(self.session, where, exact)
            return search_motion(
                self.searchable, self.session.features, motion, allowed, limit, meaning
            )

    def ask_many(
        self, questions: Iterable[Question], workers: Cluster | None = None
    ) -> Iterator[WordAnswer | ExampleAnswer | MotionDBError]:
        """Answer many questions, in their order.

        A question that cannot be answered gives its error in place of an answer. With workers, all
        questions are of one state of the database; otherwise each is of its state at that moment.

        Parameters
        ----------
        questions : iterable of Question
            Words or examples, each with its filter and limit: ``Question("walk")``,
            ``Question(like="ana/kick_1", start=0.5, limit=3)``.
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

        def motion_of(question: Question) -> Motion:
            return self.motion(question.like, question.start, question.end)

        return asked.ask_many(self.session, motion_of, questions, workers)

    def describe(
        self,
        example: Example,
        start: float | None = None,
        end: float | None = None,
    ) -> tuple[Description, ...]:
        """The words of a motion over time, with probabilities."""
        from motiondb.search.described import describe

        with self.session.reading():
            return describe(self.learned, self.motion(example, start, end))

    def word_sources(self, words: Iterable[str]) -> tuple[WordSource, ...]:
        """The captions from which some learned words were learned; empty without a start."""
        from motiondb.search.chances import word_sources

        return word_sources(self.learned, words)

    def why_unchecked(self, words: Iterable[str]) -> str:
        """The reason why answers about some words carry no probabilities; "" where they do.

        Only a database that learned with a start has such words: those of the start that own
        captions do not hold, or all of them before there are enough own captions.
        """
        from motiondb.search.asked_words import learned_words
        from motiondb.search.chances import why_unchecked

        asked = list(words)
        return why_unchecked(learned_words(self.learned), asked) if asked else ""

    def vocabulary(self) -> tuple[str, ...]:
        """The words that were learned; word numbers count from 0 in this order."""
        return self.learned.association.words

    def word_rows(self) -> list[answers.WordRow]:
        """Every word with its captions and its most probable symbols, commonest word first."""
        from motiondb.database import showing

        return showing.word_rows(self.learned)

    def symbol_rows(self, n_words: int = 3) -> list[answers.SymbolRow]:
        """Every symbol: cluster, segments, captures, mean length (seconds), most probable words."""
        from motiondb.database import showing

        return showing.symbol_rows(self.learned, n_words)

    def symbol_segments(self, symbol: int) -> list[answers.SymbolSegment]:
        """Segments of a symbol, those that it fits best first; times in seconds.

        QueryError is raised where there is no such symbol.
        """
        from motiondb.database import showing

        return showing.symbol_segments(self.learned, symbol)

    def draw_symbols(self, path: str | Path) -> Path:
        """Draw the symbol space with its clusters, every symbol with its word, as PNG."""
        from motiondb.database import showing

        return showing.draw_symbols(self.learned, path)

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

    def join(self, parts: Sequence[str], changes: MotionChanges | None = None) -> Joined:
        """Join parts of captures, with the blending of generated motion.

        Parameters
        ----------
        parts : sequence of str
            Each ``CAPTURE:FROM-TO`` in seconds, such as "walk:0.5-2", or the name of a capture.
        changes : MotionChanges, optional
            Whether the motion is looped, put in place or mirrored.
        """
        from motiondb.database import joining

        return joining.join_parts(self.session, listed("parts", parts), changes)

    def check(self) -> list[str]:
        """Faults of the store, none in a sound one."""
        from motiondb.database.checking import check

        return check(self.store)

    def backup(self, path: str | Path) -> Path:
        """Copy one state of the database into a new file, and check the copy.

        Others may use the database meanwhile. The copy has no unused space. StoreError is raised if
        there is such a file, it cannot be written, or the copy has faults.
        """
        from motiondb.database.check_process import check_file

        store.backup(self.store, Path(path), check_file)
        return Path(path)

    def runs(self) -> list[dict[str, Any]]:
        """All runs that changed the database, oldest first: kind, parameters, seed, version."""
        return [asdict(run) for run in store.load_runs(self.store)]
