"""The verbs of words and of motion symbols: ``db.words.set``, ``add``, ...; ``db.symbols.rows``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, pictures, store
from motiondb.database.captures import chosen
from motiondb.database.session import Topic
from motiondb.database.values import Where
from motiondb.errors import NotLearnedError, QueryError
from motiondb.records import MOTION_FPS, Caption, CaptureInfo
from motiondb.tabled import Listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motiondb.database.catalogue import sheets
    from motiondb.database.learn import updating
    from motiondb.learn.drift import Drift
    from motiondb.learn.knowledge import Knowledge
    from motiondb.search.chances import WordSource


LEAST_SHOWN = 0.01  # Smallest t(word | symbol) for which a symbol is listed with a word


class Words(Topic):
    """The captions of a database and the words that were learned, available as ``db.words``.

    :class:`MotionDB` says what the arguments are.
    """

    def set(
        self,
        name: str,
        words: str,
        start: float | None = None,
        end: float | None = None,
        keep: bool = False,
    ) -> updating.Change:
        """Set the caption of a capture, or of a part of it, and count it.

        ``keep`` keeps the captions that are there. Words that are new to the vocabulary are counted
        at the next ``learn``.
        """
        return self.set_captions(name, [Caption(words, start, end)], keep)

    def set_captions(
        self, name: str, captions: Iterable[Caption], keep: bool = False
    ) -> updating.Change:
        """Replace all captions of a capture, and count them; none removes those that are there."""
        from motiondb.database.learn import updating

        new = list(captions)
        with store.transaction(self.store):
            info = store.load_capture(self.store, name)
            for caption in new:
                _check_caption(info, caption)
            number = info.capture_id
            old = store.load_captions(self.store, [number]).get(number, ()) if keep else ()
            parameters = {"name": info.name, "words": "; ".join(c.words for c in new)}
            with updating.changing(self.store, "words", parameters, [number]) as change:
                store.save_captions(self.store, number, [*old, *new])
        return change

    def add(self, words: str, names: Iterable[str] = (), where: Where = "") -> list[str]:
        """Add a caption of the whole capture, and count it.

        Returns the names of the captures that did not have it.
        """
        from motiondb.database.learn import updating

        caption = Caption(words)
        with store.transaction(self.store):
            infos = chosen(self.session, names, where)
            for info in infos:
                _check_caption(info, caption)
            captions = store.load_captions(self.store)
            lacking = [info for info in infos if caption not in captions.get(info.capture_id, ())]
            if lacking:
                numbers = [info.capture_id for info in lacking]
                parameters = {"words": caption.words, "captures": len(numbers)}
                with updating.changing(self.store, "words", parameters, numbers):
                    for number in numbers:
                        rows = [*captions.get(number, ()), caption]
                        store.save_captions(self.store, number, rows)
        return [info.name for info in lacking]

    def captions(self, name: str) -> tuple[Caption, ...]:
        """The captions of a capture."""
        with self.session.reading():
            number = store.load_capture(self.store, name).capture_id
            return store.load_captions(self.store, [number]).get(number, ())

    def all_captions(self) -> dict[int, tuple[Caption, ...]]:
        """The captions of all captures, by capture number."""
        with self.session.reading():
            return dict(store.load_captions(self.store))

    def history(self, name: str) -> list[answers.CaptionVersion]:
        """The captions that a capture has had, oldest first, with the runs that set them."""
        with self.session.reading():
            info = store.load_capture(self.store, name)
            runs = {run.run_id: run for run in store.load_runs(self.store)}
            now = store.load_captions(self.store, [info.capture_id]).get(info.capture_id, ())
            edits = store.load_edits(self.store)
        return [
            answers.CaptionVersion(number, runs[number].kind, runs[number].started, words)
            for number, words in _versions(edits, info.capture_id, info.run_id, now)
        ]

    def export(self, path: str | Path, where: Where = "", form: str = "") -> answers.SheetWritten:
        """Write captions and tags as a sheet that ``import_sheet`` reads again without loss.

        It is CSV for the ending .csv, else TSV. ``form``: "boris" (aggregated events) or "elan"
        (tab-delimited text) for a sheet that these programs read, with words and events.
        """
        from motiondb.database.catalogue import sheets

        with self.session.reading():
            return sheets.export_words(self.store, path, self.session.filter(where), form)

    def import_sheet(self, sheet: str | Path) -> sheets.ImportReport:
        """Replace words and tags by those of a sheet; captures without words in it keep theirs."""
        from motiondb.database.catalogue import sheets

        return sheets.import_words(self.store, sheet)

    def set_synonyms(self, path: str | Path) -> Mapping[str, str]:
        """Replace the synonyms for captions and questions: a file of ``word = canonical``."""
        from motiondb.database.learn import updating
        from motiondb.files.safe_files import read_user_text
        from motiondb.language.vocabulary import parse_synonyms

        text = read_user_text(Path(path), "a file of synonyms")
        table = parse_synonyms(text, str(path))
        with store.transaction(self.store):
            every = [info.capture_id for info in store.load_captures(self.store)]
            touched = [store.SYNONYMS, *every]
            with updating.changing(self.store, "words", {"synonyms": str(path)}, touched):
                store.save_synonyms(self.store, table)
        return table

    def vocabulary(self) -> tuple[str, ...]:
        """The words that were learned; word numbers count from 0 in this order."""
        return self.session.learned.association.words

    def rows(self) -> list[answers.WordRow]:
        """Every word with its captions and its most probable symbols, commonest word first."""
        from motiondb.language.vocabulary import as_said

        association = self.session.learned.association
        t = association.translation[1:]
        rows = []
        for number in sorted(range(len(association.words)), key=lambda w: -association.counts[w]):
            column = t[:, number]
            best = [int(s) for s in (-column).argsort(kind="stable")[:4] if column[s] > LEAST_SHOWN]
            rows.append(
                answers.WordRow(
                    as_said(association.words[number]),
                    int(association.counts[number]),
                    tuple(answers.SymbolProbability(s, float(column[s])) for s in best),
                )
            )
        return Listed(rows)

    def sources(self, words: Iterable[str]) -> tuple[WordSource, ...]:
        """The captions from which some learned words were learned; empty without a start."""
        from motiondb.search.chances import word_sources

        return word_sources(self.session.learned, words)

    def why_unchecked(self, words: Iterable[str]) -> str:
        """The reason why answers about some words carry no probabilities; "" where they do.

        Only a database that learned with a start has such words: those of the start that own
        captions do not hold, or all of them before there are enough own captions.
        """
        from motiondb.search.asked_words import learned_words
        from motiondb.search.chances import why_unchecked

        asked = list(words)
        return why_unchecked(learned_words(self.session.learned), asked) if asked else ""


def _check_caption(info: CaptureInfo, caption: Caption) -> None:
    """Refuse a caption without words, or of an interval outside its capture (QueryError)."""
    from motiondb.database.catalogue.parts import outside

    first, last = caption.start or 0.0, info.duration if caption.end is None else caption.end
    if not 0.0 <= first < last <= info.duration + 1.0:
        raise QueryError(f"{info.name}: {outside(info.duration, caption.start, caption.end)}")
    if not caption.words.strip():
        raise QueryError(f"{info.name}: expected words, found none. Say what it shows.")


def _versions(
    edits: list[store.Edit], capture: int, added: int, last: tuple[Caption, ...]
) -> list[tuple[int, tuple[Caption, ...]]]:
    """The runs that set the captions of a capture, with these; first those of what it replaced."""
    own = [e for e in edits if e.capture_id == capture]
    changes = [
        e for e in own if e.captions is not None and e.kind == "changed" and e.run_id > added
    ]
    words = [*(edit.captions or () for edit in changes), last]
    versions = list(zip([added, *(edit.run_id for edit in changes)], words))
    names = {e.name for e in own if e.kind == "added" and e.run_id == added}
    replaced = [e for e in edits if e.kind == "removed" and e.run_id == added and e.name in names]
    for old in replaced:
        since = [e.run_id for e in edits if e.capture_id == old.capture_id and e.kind == "added"]
        begun = max((run for run in since if run < added), default=0)
        if begun:
            versions = _versions(edits, old.capture_id, begun, old.captions or ()) + versions
    return versions


class Symbols(Topic):
    """The motion symbols that a database has learned, available as ``db.symbols``."""

    def rows(self, n_words: int = 3) -> list[answers.SymbolRow]:
        """Every symbol: cluster, segments, captures, mean length (seconds), most probable words."""
        learned = self.session.learned
        table, association = learned.segments, learned.association
        rows = []
        for s in range(learned.symbols.n_symbols):
            mine = table.symbols == s
            lengths = (table.ends - table.starts)[mine] / MOTION_FPS
            t = association.translation[s + 1]
            order = [w for w in np.argsort(-t, kind="stable")[:n_words] if t[w] > 0]
            rows.append(
                answers.SymbolRow(
                    s,
                    int(learned.clusters[s]),
                    int(mine.sum()),
                    len(np.unique(table.capture_ids[mine])),
                    round(float(lengths.mean()), 2) if mine.any() else 0.0,
                    tuple(
                        answers.WordProbability(association.words[w], float(t[w])) for w in order
                    ),
                )
            )
        return Listed(rows)

    def segments(self, symbol: int) -> list[answers.SymbolSegment]:
        """Segments of a symbol, those that it fits best first; times in seconds.

        QueryError is raised where there is no such symbol.
        """
        from motiondb.database.showing import shown_segment

        learned = self.session.learned
        if not 0 <= symbol < learned.symbols.n_symbols:
            raise QueryError(
                f"symbol {symbol}: expected 0 to {learned.symbols.n_symbols - 1}, found another "
                "number."
            )
        table = learned.segments
        rows = np.flatnonzero(table.symbols == symbol)
        best = rows[np.argsort(-table.log_likelihoods[rows], kind="stable")]
        return [
            answers.SymbolSegment(
                **vars(shown_segment(table, int(row))),
                capture=learned.captures[int(table.capture_ids[row])].name,
            )
            for row in best
        ]

    def draw(self, path: str | Path | None = None) -> Path | Figure:
        """Draw the symbol space with its clusters, every symbol with its word, as PNG."""
        labels = [row.words[0].word if row.words else "" for row in self.rows(1)]
        return pictures.save_png(pictures.space_figure(self.session.learned.space, labels), path)

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
        learned = self.session.learned
        if learned.started is None:
            raise NotLearnedError(
                f"{learned.source}: expected a database that learned with a start, found one that "
                f"learned from its own captures only. Name a file, or cmu."
            )
        return learned.started.knowledge

    def start_facts(self) -> answers.StartAnswer | None:
        """The origin of the knowledge that the database started from; None if it did not."""
        from motiondb.database.learn import start

        with self.session.reading():
            return start.start_facts(self.session)
