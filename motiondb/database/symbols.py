"""The verbs of what was learned: ``db.symbols.rows``, ``segments``, ``draw``, ``drift``, ..."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers, store
from motiondb.database.session import Topic
from motiondb.tabled import Listed

if TYPE_CHECKING:  # loaded by the verbs that need them, so that a question starts faster
    from matplotlib.figure import Figure

    from motiondb.learn.drift import Drift
    from motiondb.learn.knowledge import Knowledge


class Symbols(Topic):
    """The motion symbols that a database has learned, available as ``db.symbols``."""

    def rows(self, n_words: int = 3) -> list[answers.SymbolRow]:
        """Every symbol: cluster, segments, captures, mean length (seconds), most probable words."""
        from motiondb.database import showing

        return Listed(showing.symbol_rows(self.session.learned, n_words))

    def segments(self, symbol: int) -> list[answers.SymbolSegment]:
        """Segments of a symbol, those that it fits best first; times in seconds.

        QueryError is raised where there is no such symbol.
        """
        from motiondb.database import showing

        return Listed(showing.symbol_segments(self.session.learned, symbol))

    def draw(self, path: str | Path | None = None) -> Path | Figure:
        """Draw the symbol space with its clusters, every symbol with its word, as PNG."""
        from motiondb.database import showing

        return showing.draw_symbols(self.session.learned, path)

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
            return start.export(self.store, self.session.learned, path, name, credit)

    def start_knowledge(self) -> Knowledge:
        """The knowledge that the database started from; NotLearnedError if it did not."""
        from motiondb.database.learn import start

        with self.session.reading():
            return start.start_knowledge(self.session.learned)

    def start_facts(self) -> answers.StartAnswer | None:
        """The origin of the knowledge that the database started from; None if it did not."""
        from motiondb.database.learn import start

        with self.session.reading():
            return start.start_facts(self.session)
