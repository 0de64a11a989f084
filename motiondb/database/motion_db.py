"""The database as its users know it: one class, one method for each verb."""

from __future__ import annotations

from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from motiondb import store
from motiondb.answers.catalogue import DatabaseInfo
from motiondb.database.ask.fact_verbs import FactVerbs
from motiondb.database.learn import learning, starting
from motiondb.database.session import Session
from motiondb.learn.drift import Drift
from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.start.knowledge import Knowledge
from motiondb.learn.symbol_fitting import LearnSettings, Progress

if TYPE_CHECKING:
    from motiondb.database.grammars.grammar_verbs import Grammars
    from motiondb.database.scenes.scene_verbs import Scenes


class MotionDB(FactVerbs):
    """A motion database: add captures, learn, ask, generate. Use it in a ``with`` statement.

    Threads may share it. Every question is answered from one revision of the database, even if
    other threads or processes save changes meanwhile.

    Units and frames: metres, seconds, radians; right-handed world frame, y up; rotations as unit
    quaternions w, x, y, z; motions on the canonical body at 30 frames a second.

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
        from motiondb.database.grammars.grammar_verbs import Grammars

        return Grammars(self.session)

    @cached_property
    def scenes(self) -> Scenes:
        """The verbs of scenes: make, update, write, keep, load, draw, remove."""
        from motiondb.database.scenes.scene_verbs import Scenes

        return Scenes(self.session)

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self.session.close()

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
    ) -> LearnedModel:
        """Derive symbols, their space and their words from all captures; replaces earlier ones.

        Parameters
        ----------
        settings : LearnSettings, optional
            What decides the result; the same settings and captures give the same result.
        progress : callable, optional
            Called with the step and the share of it that is done.
        start : str, Path or Knowledge, optional
            Knowledge of another database to start from: "cmu" is shipped, a path names a file of
            :meth:`export_knowledge`. Its symbols and words are taken over, and own captions count
            more the more there are. None: the start that the database used before, if any;
            "none": nothing.

        Raises
        ------
        MotionDBError
            When the database holds no captures, or fewer segments than the requested symbols.
        KnowledgeError
            When there is no such knowledge.
        """
        return learning.learn(self.store, settings or LearnSettings(), progress, start)

    def export_knowledge(self, path: str | Path, name: str = "", credit: str = "") -> Knowledge:
        """Write the learned model, without motion and captions, as a start for other databases.

        Parameters
        ----------
        path : str or Path
            The file.
        name : str
            What to call it; the name of the file without its ending if not given.
        credit : str
            The acknowledgement that users are asked to give.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or learned no words.
        KnowledgeError
            When it learned with a start itself, or the file cannot be written.
        """
        with self.session.reading():
            return starting.export(self.store, self.learned, path, name, credit)

    def start_knowledge(self) -> Knowledge:
        """The knowledge that the database started from.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or learned without a start.
        """
        with self.session.reading():
            return starting.start_knowledge(self.learned)

    def start_facts(self) -> dict[str, Any] | None:
        """The origin of the knowledge that the database started from; None if it did not."""
        with self.session.reading():
            return starting.start_facts(self.learned) if self.is_learned() else None

    def drift(self) -> Drift | None:
        """How far captures and words have changed since the database learned.

        None if it has not learned, or an earlier version learned that kept no baseline.
        """
        return learning.measure(self.store)

    def check(self) -> list[str]:
        """Faults of the store, none in a sound one."""
        return store.check_store(self.store, sources=True)

    def info(self) -> DatabaseInfo:
        """What is in the database: numbers of captures, grammars, symbols and words."""
        with self.session.reading():
            captures = self.captures()
            performers = {c.tags["performer"] for c in captures if "performer" in c.tags}
            learned: dict[str, Any] = {"learned": self.is_learned()}
            if learned["learned"]:
                size = store.load_learning_size(self.store)
                learned |= {
                    "symbols": size.n_symbols,
                    "clusters": size.n_clusters,
                    "words": size.n_words,
                    "current": store.learning_is_current(self.store),
                    "not_yet_learned": len(self.unlearned()),
                    "start": self.start_facts(),
                }
            return DatabaseInfo(
                database=str(self.store.path),
                bytes=self.store.path.stat().st_size,
                captures=len(captures),
                generated=sum(c.kind == "generated" for c in captures),
                seconds=round(sum(c.duration for c in captures), 2),
                performers=len(performers),
                captures_with_words=len(self.all_captions()),
                copies=len(self.relations()),
                grammars=len(store.load_grammar_names(self.store)),
                **learned,
            )

    def runs(self) -> list[dict[str, Any]]:
        """All runs that changed the database, oldest first: kind, parameters, seed, version."""
        return [asdict(run) for run in store.load_runs(self.store)]
