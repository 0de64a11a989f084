"""What a database holds as Arrow tables, which pandas, polars and DuckDB read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import store
from motiondb.database.session import Topic
from motiondb.database.values import Where
from motiondb.errors import MotionDBError, QueryError
from motiondb.files.arrays import NO_PYARROW
from motiondb.records import MOTION_FPS, Caption, Match

if TYPE_CHECKING:
    import pyarrow as pa

    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer


class Tables(Topic):
    """Arrow tables of a database; they need the library pyarrow (``motiondb[arrow]``).

    ``to_pandas()`` of a table gives a data frame, ``polars.from_arrow(table)`` one of polars.
    Without pyarrow a MotionDBError is raised, and a NotLearnedError for what is learned where
    nothing was.
    """

    def sql(self, query: str) -> tuple[list[str], list[tuple[Any, ...]]]:
        """Names of the columns, and rows, of the answer to one SELECT about the tables of the file.

        ``schema/README.md`` describes the tables. Files other than the database are not read.

        Raises
        ------
        QueryError
            When the database was not opened with ``read_only``, or DuckDB refuses the question.
        """
        if not self.store.read_only:
            raise QueryError(
                "sql: expected a database that is opened to read only, found one that may write. "
                "Open it with read_only=True."
            )
        with self.session.reading():
            return self.store.connection.select(query)

    def captures(self, where: Where = "") -> pa.Table:
        """The catalogue: its columns, captions as a list of texts, and a column for every tag.

        Durations are in seconds, leg lengths in metres. The column of a tag is called ``tag.NAME``.

        Parameters
        ----------
        where : str or names
            Filter on the catalogue.
        """
        with self.session.reading():
            infos = store.load_captures(self.store, self.session.filter(where))
            captions = store.load_captions(self.store)
        columns: dict[str, Any] = {c: [getattr(i, c) for i in infos] for c in store.COLUMNS}
        columns["captions"] = [[c.words for c in captions.get(i.capture_id, ())] for i in infos]
        for tag in sorted({tag for info in infos for tag in info.tags}):
            columns[f"tag.{tag}"] = [info.tags.get(tag) for info in infos]
        return _table(columns)

    def captions(self) -> pa.Table:
        """Captions with their captures: capture, words, start and end (seconds, or null)."""
        with self.session.reading():
            names = {i.capture_id: i.name for i in store.load_captures(self.store)}
            captions = store.load_captions(self.store)
        rows = [(names[number], c) for number, spoken in captions.items() for c in spoken]
        return _table(
            {
                "capture": [name for name, _ in rows],
                **{f.name: [getattr(c, f.name) for _, c in rows] for f in fields(Caption)},
            }
        )

    def segments(self) -> pa.Table:
        """Segments of all learned captures: capture, start and end (seconds), symbol.

        ``log_likelihood`` is that of the symbol and ``background`` that of the background model,
        both in nats per frame.
        """
        learned = self.session.learned
        table = learned.segments
        names = {number: info.name for number, info in learned.captures.items()}
        return _table(
            {
                "capture": [names[number] for number in table.capture_ids.tolist()],
                "start": table.starts / MOTION_FPS,
                "end": table.ends / MOTION_FPS,
                "symbol": table.symbols,
                "log_likelihood": table.log_likelihoods,
                "background": table.backgrounds,
            }
        )

    def symbols(self) -> pa.Table:
        """Motion symbols: symbol, cluster, coordinates in the symbol space, number of segments."""
        learned = self.session.learned
        n = learned.symbols.n_symbols
        return _table(
            {
                "symbol": np.arange(n),
                "cluster": learned.space.clusters,
                "coordinates": [row.tolist() for row in learned.space.coordinates],
                "count": np.bincount(learned.segments.symbols, minlength=n),
            }
        )

    def words(self) -> pa.Table:
        """t(word | symbol): word, symbol, probability. Symbol -1 is NULL; zeros are left out."""
        association = self.session.learned.association
        translation = np.asarray(association.translation)
        rows, columns = np.nonzero(translation)
        return _table(
            {
                "word": [association.words[number] for number in columns.tolist()],
                "symbol": rows - 1,
                "probability": translation[rows, columns],
            }
        )

    def matches(self, answer: WordAnswer | ExampleAnswer | Iterable[Match]) -> pa.Table:
        """The matches of an answer of ``search`` or ``like``, a row each; times in seconds.

        Parameters
        ----------
        answer : WordAnswer, ExampleAnswer, or iterable of Match
            The answer, or matches.
        """
        found: Any = answer
        matches: list[Match] = list(getattr(found, "matches", found))
        names = [field.name for field in fields(Match) if field.name != "parts"]
        columns: dict[str, Any] = {name: [getattr(m, name) for m in matches] for name in names}
        columns["words"] = [list(match.words) for match in matches]
        return _table(columns)


def _table(columns: Mapping[str, Any]) -> pa.Table:
    """An Arrow table of columns."""
    try:
        import pyarrow as pa
    except ImportError:
        raise MotionDBError(f"tables: {NO_PYARROW}") from None
    return pa.table(dict(columns))
