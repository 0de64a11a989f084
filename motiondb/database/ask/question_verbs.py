"""The methods for questions: search, like, describe."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb import store
from motiondb.database.catalogue.catalogue_verbs import CatalogueVerbs
from motiondb.database.catalogue.filter_words import take_filter_words
from motiondb.database.nearby_words import nearby_table
from motiondb.learn.learned import Learned
from motiondb.records import Motion
from motiondb.search import (
    described_motion,
    example_answers,
    word_answers,
)
from motiondb.search.taken_words import (
    add_written,
    leave_unknown,
    replace_unknown,
    take_unknown,
)
from motiondb.search.taking import Taking
from motiondb.search.word_sources import WordSource, why_unchecked, word_sources
from motiondb.search.written_words import LearnedWithWritten, WrittenWord, written_words

if TYPE_CHECKING:
    from motiondb.answers.catalogue import SymbolRow, WordRow


class QuestionVerbs(CatalogueVerbs):
    """Methods that answer questions; each answer uses one revision of the store."""

    @property
    def learned(self) -> Learned:
        """The learned model, with the catalogue of the same revision.

        Raises
        ------
        NotLearnedError
            When the database has not learned.
        """
        return self.session.learned

    @property
    def searchable(self) -> Learned:
        """The learned model, with the generated captures in addition to those learned from.

        Raises
        ------
        NotLearnedError
            When the database has not learned.
        """
        return self.session.searchable

    def is_learned(self) -> bool:
        """Whether the database has learned."""
        return store.is_learned(self.store)

    def search(
        self,
        words: str,
        where: str = "",
        limit: int = 10,
        by_symbols: bool = False,
        written: bool = True,
        exact: bool = False,
    ) -> word_answers.WordAnswer:
        """Find the intervals that show the actions of a question, best first.

        Parameters
        ----------
        words : str
            The question, such as "walk, turn left".
        where : str
            Filter on the catalogue, such as "performer=14".
        limit : int
            Largest number of matches.
        by_symbols : bool
            Decode the words to symbols and align these with the captures, as in paper A.
        written : bool
            Whether captions count as evidence, in addition to the motion.
        exact : bool
            Whether words that no caption holds are left out rather than taken as known ones.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or learned no words.
        QueryError
            When no word is known or taken as a known one, or the filter cannot be read.
        """
        with self.session.reading():
            allowed, learned = self._numbers(where, exact), self.searchable
            if not by_symbols:  # what is written says nothing of symbols
                learned = add_written(
                    learned, words, self._written_words, None if exact else nearby_table()
                )
            take = replace_unknown if by_symbols else take_unknown
            seen, takings = (leave_unknown if exact else take)(learned, words, nearby_table())
            answer = word_answers.search_words(
                seen,
                words,
                allowed,
                limit,
                by_symbols,
                written,
                lambda capture: self.session.features.of_capture(capture),
            )
            answer = word_answers.with_takings(answer, takings)
            behind = [word for taking in answer.taken.values() for word, _ in taking.words]
            return replace(
                answer,
                sources=(*answer.sources, *word_sources(learned, behind)),
                written=learned.added_words if isinstance(learned, LearnedWithWritten) else (),
            )

    def like(
        self,
        example: str | Path | Motion,
        start: float | None = None,
        end: float | None = None,
        where: str = "",
        limit: int = 10,
        meaning: bool | None = None,
        exact: bool = False,
    ) -> example_answers.ExampleAnswer:
        """Find the intervals that move like an example, best first.

        Parameters
        ----------
        example : str, Path or Motion
            A file, the name of a stored capture, or a motion.
        start : float, optional
            Start of the part of the example, seconds.
        end : float, optional
            End of the part of the example, seconds.
        where : str
            Filter on the catalogue.
        limit : int
            Largest number of matches.
        meaning : bool, optional
            Whether learned words take part in the resemblance, so that the same action in other
            styles counts as alike; None: if there are words.
        exact : bool
            Whether unknown words of the filter match nothing, instead of being replaced by known
            words.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or ``meaning`` is True and it learned no words.
        QueryError
            When there is no such capture, or the filter cannot be read.
        """
        with self.session.reading():
            motion, allowed = self.motion(example, start, end), self._numbers(where, exact)
            return example_answers.search_motion(
                self.searchable, self.session.features, motion, allowed, limit, meaning
            )

    def describe(
        self, example: str | Path | Motion, start: float | None = None, end: float | None = None
    ) -> tuple[described_motion.Description, ...]:
        """The words of a motion over time, with probabilities.

        Parameters
        ----------
        example : str, Path or Motion
            A file, the name of a stored capture, or a motion.
        start : float, optional
            Start of the part of the example, seconds.
        end : float, optional
            End of the part of the example, seconds.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or learned no words.
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            return described_motion.describe(self.learned, self.motion(example, start, end))

    def unlearned(self) -> list[str]:
        """Names of captured captures that no question searches: added and not counted."""

        def load() -> list[str]:
            captured = [info for info in self.captures() if info.kind == "captured"]
            if not self.is_learned():
                return [info.name for info in captured]
            table = store.load_segments(self.store, scores=False)
            learned = set(table.capture_ids.tolist())
            return [info.name for info in captured if info.capture_id not in learned]

        return list(self.session.kept("unlearned", load))

    def word_sources(self, words: Iterable[str]) -> tuple[WordSource, ...]:
        """The captions from which some words were learned; empty without a start.

        Parameters
        ----------
        words : iterable of str
            Learned words; others are left out.
        """
        return word_sources(self.learned, words)

    def why_unchecked(self, words: Iterable[str]) -> str:
        """The reason why answers about some words carry no probabilities; "" where they do.

        Only a database that learned with a start has such words: those of the start that own
        captions do not hold, or all of them before there are enough own captions.

        Parameters
        ----------
        words : iterable of str
            Words that were learned; others are left out.
        """
        asked = list(words)
        return why_unchecked(self.learned, asked) if asked else ""

    def taken_in_filter(self, where: str) -> Mapping[str, Taking]:
        """The known words that replace words of a filter that are in no caption and no tag.

        Parameters
        ----------
        where : str
            The filter.
        """
        if not where.strip():
            return {}
        with self.session.reading():
            return take_filter_words(self.store, where)[1]

    def vocabulary(self) -> tuple[str, ...]:
        """The words that were learned; word numbers count from 0 in this order."""
        return self.learned.association.words

    def word_rows(self) -> list[WordRow]:
        """Every word with its captions and its most probable symbols, commonest word first."""
        from motiondb.database.ask import showing

        return showing.word_rows(self.learned)

    def symbol_rows(self, n_words: int = 3) -> list[SymbolRow]:
        """Every symbol: cluster, segments, captures, mean length (seconds), most probable words.

        Parameters
        ----------
        n_words : int
            Words per symbol.
        """
        from motiondb.database.ask import showing

        return showing.symbol_rows(self.learned, n_words)

    def draw_symbols(self, path: str | Path) -> Path:
        """Draw the symbol space with its clusters, every symbol with its word, as PNG."""
        from motiondb.database.ask import showing

        return showing.draw_symbols(self.learned, path)

    def show(self, name: str) -> dict[str, Any]:
        """Facts of one capture, for print or JSON; times in seconds.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database.ask import showing

        with self.session.reading():
            return showing.describe_capture(self, name)

    def draw(self, name: str, path: str | Path) -> Path:
        """Draw a capture as a strip of stick figures over its timelines, as PNG."""
        from motiondb.database.ask import showing

        with self.session.reading():
            return showing.draw_capture(self, name, path)

    def draw_matches(
        self,
        answer: word_answers.WordAnswer | example_answers.ExampleAnswer,
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
        from motiondb.database.ask import answer_pictures

        return answer_pictures.draw_matches(self, answer.matches, path, title, example)

    def draw_reasons(
        self, answer: word_answers.WordAnswer, path: str | Path, title: str = ""
    ) -> Path:
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
        from motiondb.database.ask import answer_pictures

        return answer_pictures.draw_reasons(self, answer, path, title)

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
        from motiondb.database.ask import showing

        return showing.animate_capture(self, name, path, start, end)

    def _written_words(self) -> Mapping[str, WrittenWord]:
        """Words that are written but were not learned; kept for the revision."""
        return self.session.kept("written_words", lambda: written_words(self.searchable))

    def _numbers(self, where: str, exact: bool) -> Sequence[int]:
        """Numbers of the captures that a filter lets through."""
        if not where.strip():
            return list(self.searchable.captures)
        return [info.capture_id for info in self.captures(where, exact)]
