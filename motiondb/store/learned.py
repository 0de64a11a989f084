"""Everything that ``learn`` derives: replaced in one transaction, loaded whole or in parts.

Arrays come back equal to the last bit (NaN as NaN). A kill leaves the former model.
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import NotLearnedError
from motiondb.records import (
    Association,
    Float32Array,
    FloatArray,
    MotionSymbols,
    SegmentTable,
    StoredLearning,
    SymbolSpace,
)
from motiondb.store.catalogue.parquet_files import SCORES, forget_unused, load_part
from motiondb.store.catalogue.runs import finish_run
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import Connection, from_rows, ragged, to_rows
from motiondb.store.connection.transactions import content_revision, transaction

TABLES = (
    "learning",
    "symbol",
    "symbol_state",
    "symbol_distance",
    "space_stress",
    "cluster",
    "word",
    "translation",
    "alignment",
    "association_step",
    "transition_count",
    "parameter",
)
_OF_SYMBOLS = ("symbol", "symbol_state", "symbol_distance", "space_stress", "cluster")
SEGMENT_TABLES = ("segment", "segment_score")
"""Those of captures: the segments of a capture stay while others are added or removed."""
_PIECE = 65_536  # Numbers in one row of the table ``parameter``


@dataclass(frozen=True)
class LearningSize:
    """The row of the table ``learning``: run, content that it was learned from, sizes."""

    run_id: int
    content_revision: str
    n_symbols: int
    max_states: int
    n_features: int
    n_coordinates: int
    n_clusters: int
    n_words: int


def save_learning(
    store: Store,
    learning: StoredLearning,
    kept: Collection[int] = (),
    former: StoredLearning | None = None,
) -> None:
    """Replace everything derived by ``learning`` and finish its run, in one transaction.

    `kept`: Captures whose segments stay as they are; ``learning`` has those of all others.
    `former`: What is stored, with the same symbols and space. Rows that are the same stay, too, and
    get the new run.
    """
    run_id, symbols, space = learning.run_id, learning.symbols, learning.space
    parameters = learning.parameters
    with transaction(store) as connection:
        for table in TABLES:
            if former is not None and table in _OF_SYMBOLS:
                connection.execute(f"UPDATE {table} SET run_id = ?", [run_id])
            elif former is not None and table == "parameter":
                same = _same_values(parameters, former.parameters)
                given = [list(same)]
                connection.execute(
                    "DELETE FROM parameter WHERE name NOT IN (SELECT unnest($1))", given
                )
                connection.execute("UPDATE parameter SET run_id = ?", [run_id])
                parameters = {n: v for n, v in parameters.items() if n not in same}
            else:
                connection.execute(f"DELETE FROM {table}")
        _delete_segments(connection, kept)
        forget_unused(store, SCORES)
        connection.insert_row(
            "learning",
            run_id,
            content_revision(store),
            symbols.n_symbols,
            *symbols.means.shape[1:],
            space.coordinates.shape[1],
            len(space.weights),
            len(learning.association.words),
        )
        if former is None:
            _insert_symbols(connection, symbols, space, run_id)
            _insert_space(connection, space, run_id)
        _insert_segments(connection, learning.segments, run_id)
        store.local.changed.add("segment_revision")
        _insert_association(connection, learning.association, run_id)
        _insert_transitions(connection, learning.transition_counts, run_id)
        _insert_parameters(connection, parameters, run_id)
        finish_run(store, run_id)


def _same_values(
    values: Mapping[str, FloatArray | str], former: Mapping[str, FloatArray | str]
) -> set[str]:
    """Names of the values that are equal to the last bit."""
    return {
        name
        for name, value in values.items()
        if (old := former.get(name)) is not None and _as_bytes(value) == _as_bytes(old)
    }


def _as_bytes(value: FloatArray | str) -> object:
    if isinstance(value, str):
        return value
    array = np.asarray(value, dtype=np.float64)
    return array.shape, array.tobytes()


def load_learning(store: Store, *, scores: bool = True) -> StoredLearning:
    """Load everything that was learned; without ``scores`` those of segments have no columns."""
    return StoredLearning(
        load_learning_size(store).run_id,
        load_symbols(store),
        load_segments(store, scores=scores),
        load_space(store),
        load_association(store),
        load_transition_counts(store),
        load_parameters(store),
    )


def load_learning_size(store: Store) -> LearningSize:
    """Load sizes and run of the learned model."""
    row = store.connection.execute("SELECT * FROM learning").fetchone()
    if row is None:
        raise NotLearnedError(
            f"{store.path}: expected motion symbols, found none. "
            f"Run motiondb learn --db {store.path} first."
        )
    return LearningSize(*row)


def learning_mark(store: Store) -> str:
    """A text that is another one when what was learned, or what it is asked with, has changed."""
    size = load_learning_size(store)
    query = "SELECT started, version, parameters FROM run WHERE run_id = ?"
    run = store.connection.execute(query, [size.run_id]).fetchone()
    names = (  # which may tell the performer
        "SELECT run_id, started, parameters FROM run WHERE kind IN ('rename', 'undo') "
        "ORDER BY run_id DESC LIMIT 1"
    )
    named = store.connection.execute(names).fetchone()
    return repr((vars(size), run, content_revision(store), named))


def is_learned(store: Store) -> bool:
    """Whether ``learn`` has run."""
    return store.connection.value("SELECT 1 FROM learning") is not None


def learning_is_current(store: Store) -> bool:
    """Whether no capture, word or synonym has changed since ``learn``."""
    return load_learning_size(store).content_revision == content_revision(store)


def load_symbols(store: Store) -> MotionSymbols:
    """Load the motion symbols."""
    size, connection = load_learning_size(store), store.connection
    n_states = connection.arrays("SELECT n_states FROM symbol ORDER BY symbol_id")["n_states"]
    rows = connection.arrays("SELECT symbol_id, state, self_loop, means, covars FROM symbol_state")
    place = (rows["symbol_id"], rows["state"])
    self_loops = np.zeros((len(n_states), size.max_states))
    means = np.zeros((len(n_states), size.max_states, size.n_features))
    covars = np.ones_like(means)
    self_loops[place] = rows["self_loop"]
    means[place] = from_rows(rows["means"], (size.n_features,))
    covars[place] = from_rows(rows["covars"], (size.n_features,))
    return MotionSymbols(n_states, self_loops, means, covars)


def load_segments(store: Store, *, scores: bool = True) -> SegmentTable:
    """Load the segments; without ``scores`` that array has no columns."""
    n_symbols = load_learning_size(store).n_symbols
    rows = store.connection.arrays(
        "SELECT capture_id, start_frame, end_frame, symbol_id, log_likelihood, background "
        "FROM segment ORDER BY capture_id, start_frame",
    )
    n = len(rows["capture_id"])
    table = np.zeros((n, 0), dtype=np.float32)
    if scores:
        table = np.concatenate([np.zeros((0, n_symbols), np.float32), *load_scores(store).values()])
    return SegmentTable(
        rows["capture_id"],
        rows["start_frame"],
        rows["end_frame"],
        rows["symbol_id"],
        rows["log_likelihood"],
        rows["background"],
        table,
    )


def load_scores(store: Store, captures: Collection[int] | None = None) -> dict[int, Float32Array]:
    """Load the scores of segments by capture, of some captures or all: (segments, symbols)."""
    n_symbols = load_learning_size(store).n_symbols
    some = "" if captures is None else "WHERE capture_id IN (SELECT unnest($1))"
    given = [] if captures is None else [list(captures)]
    query = f"SELECT capture_id, scores, scores_at FROM segment_score {some} ORDER BY capture_id"
    rows = store.connection.arrays(query, given)
    parts = (
        np.ma.filled(numbers, np.nan) if at is np.ma.masked else unpack_scores(load_part(store, at))
        for numbers, at in zip(rows["scores"], rows["scores_at"])
    )
    return {
        capture: part.astype(np.float32, copy=False).reshape(-1, n_symbols)
        for capture, part in zip(rows["capture_id"].tolist(), parts)
    }


def pack_scores(numbers: NDArray[np.float32]) -> bytes:
    """Scores as they stand in a Parquet file: little-endian float32."""
    # zlib would take off a tenth
    return np.ma.filled(numbers, np.nan).astype("<f4").tobytes()


def unpack_scores(data: bytes) -> Float32Array:
    """Scores that :func:`pack_scores` packed, in one row."""
    return np.frombuffer(data, dtype="<f4").astype(np.float32)


def load_learned_captures(store: Store) -> set[int]:
    """Numbers of the captures that have segments: those that questions search."""
    rows = store.connection.arrays("SELECT DISTINCT capture_id FROM segment")
    return set(rows["capture_id"].tolist())


def load_space(store: Store) -> SymbolSpace:
    """Load the symbol space."""
    size, connection = load_learning_size(store), store.connection
    places = connection.arrays("SELECT cluster_id, coordinates FROM symbol ORDER BY symbol_id")
    pairs = connection.arrays(
        "SELECT distance, variance FROM symbol_distance ORDER BY symbol_id, other_id"
    )
    clusters = connection.arrays("SELECT weight, mean, covar FROM cluster ORDER BY cluster_id")
    n = len(places["cluster_id"])
    return SymbolSpace(
        distances=pairs["distance"].reshape(n, n),
        variances=pairs["variance"].reshape(n, n),
        coordinates=from_rows(places["coordinates"], (size.n_coordinates,)),
        stress=connection.arrays("SELECT stress FROM space_stress ORDER BY dimensions")["stress"],
        clusters=places["cluster_id"],
        weights=clusters["weight"],
        means=from_rows(clusters["mean"], (size.n_coordinates,)),
        covars=from_rows(clusters["covar"], (size.n_coordinates, size.n_coordinates)),
    )


def load_unlearned(store: Store) -> list[str]:
    """Names of the captures that were not generated and have no segments, in order of number."""
    return store.connection.column(
        "SELECT name FROM capture ANTI JOIN segment USING (capture_id) WHERE kind = 'captured' "
        "AND leg_length > 0 ORDER BY capture_id"
    )


def load_words(store: Store) -> tuple[str, ...]:
    """Load the words of the vocabulary, in order of number."""
    return tuple(store.connection.column("SELECT word FROM word ORDER BY word_id"))


def load_association(store: Store) -> Association:
    """Load the association of symbols and words."""
    size, connection = load_learning_size(store), store.connection
    words = connection.arrays("SELECT word, count FROM word ORDER BY word_id")
    cells = connection.arrays("SELECT symbol_id, word_id, probability FROM translation")
    translation = np.zeros((size.n_symbols + 1, len(words["word"])))
    translation[cells["symbol_id"] + 1, cells["word_id"]] = cells["probability"]
    steps = connection.arrays("SELECT log_likelihood FROM association_step ORDER BY step")
    return Association(
        tuple(words["word"].tolist()),
        words["count"],
        translation,
        _load_alignment(store),
        steps["log_likelihood"],
    )


def load_transition_counts(store: Store) -> FloatArray:
    """Load how often symbols follow one another: array (symbols + 1, symbols + 1)."""
    size, connection = load_learning_size(store), store.connection
    cells = connection.arrays("SELECT symbol_id, next_id, count FROM transition_count")
    counts = np.zeros((size.n_symbols + 1, size.n_symbols + 1))
    counts[cells["symbol_id"] + 1, cells["next_id"] + 1] = cells["count"]
    return counts


def has_parameter(store: Store, name: str) -> bool:
    """Whether there are further values of a name, or below it."""
    query = "SELECT 1 FROM parameter WHERE name = $1 OR starts_with(name, $1 || '.') LIMIT 1"
    return store.connection.value(query, [name]) is not None


def load_parameters(store: Store, *names: str) -> dict[str, FloatArray | str]:
    """Load further values by name: those of these names and below them ("NAME.x"), or all."""
    load_learning_size(store)
    wanted = " OR ".join(["name = ? OR starts_with(name, ? || '.')"] * len(names)) or "true"
    rows = store.connection.arrays(
        f"SELECT name, shape, numbers, text FROM parameter WHERE {wanted} ORDER BY name, piece",
        [name for name in names for _ in range(2)],
    )
    pieces: dict[str, list[FloatArray]] = {}
    shapes: dict[str, list[int]] = {}
    values: dict[str, FloatArray | str] = {}
    is_array = np.ma.getmaskarray(rows["text"])
    for array, name, shape, numbers, text in zip(is_array, *rows.values()):
        if not array:
            values[name] = text
        else:
            pieces.setdefault(name, []).append(np.ma.filled(numbers, np.nan))
            shapes[name] = [int(size) for size in shape]
    for name, of_one in pieces.items():
        joined = np.concatenate(of_one).astype(np.float64, copy=False)
        values[name] = joined.reshape(shapes[name])
    return values


def _delete_segments(connection: Connection, kept: Collection[int]) -> None:
    """Delete the segments of all captures but some."""
    for table in SEGMENT_TABLES:
        if kept:
            query = f"DELETE FROM {table} WHERE capture_id NOT IN (SELECT unnest($1))"
            connection.execute(query, [sorted(kept)])
        else:
            connection.execute(f"DELETE FROM {table}")


def _insert_segments(connection: Connection, segments: SegmentTable, run_id: int) -> None:
    """Write the segments in their order."""
    connection.insert(
        "segment",
        capture_id=segments.capture_ids,
        start_frame=segments.starts,
        end_frame=segments.ends,
        symbol_id=segments.symbols,
        log_likelihood=segments.log_likelihoods,
        background=segments.backgrounds,
        run_id=run_id,
    )
    captures, firsts = np.unique(segments.capture_ids, return_index=True)
    ends = [*firsts[1:], len(segments.scores)]
    scores = ragged([segments.scores[a:b].ravel() for a, b in zip(firsts, ends)])
    connection.insert("segment_score", capture_id=captures, scores=scores, run_id=run_id)


def _insert_symbols(
    connection: Connection, symbols: MotionSymbols, space: SymbolSpace, run_id: int
) -> None:
    """Write the symbols with their places; padding is left out."""
    numbers = np.arange(symbols.n_symbols)
    connection.insert(
        "symbol",
        symbol_id=numbers,
        n_states=symbols.n_states,
        cluster_id=space.clusters,
        coordinates=to_rows(space.coordinates),
        run_id=run_id,
    )
    ids, states = np.nonzero(np.arange(symbols.means.shape[1]) < symbols.n_states[:, None])
    connection.insert(
        "symbol_state",
        symbol_id=ids,
        state=states,
        self_loop=symbols.self_loops[ids, states],
        means=to_rows(symbols.means[ids, states]),
        covars=to_rows(symbols.covars[ids, states]),
        run_id=run_id,
    )


def _insert_space(connection: Connection, space: SymbolSpace, run_id: int) -> None:
    """Write distances, stress and clusters (coordinates are in the table ``symbol``)."""
    n = len(space.distances)
    ids, others = np.divmod(np.arange(n * n), max(n, 1))
    connection.insert(
        "symbol_distance",
        symbol_id=ids,
        other_id=others,
        distance=space.distances.ravel(),
        variance=space.variances.ravel(),
        run_id=run_id,
    )
    connection.insert(
        "space_stress",
        dimensions=np.arange(1, len(space.stress) + 1),
        stress=space.stress,
        run_id=run_id,
    )
    connection.insert(
        "cluster",
        cluster_id=np.arange(len(space.weights)),
        weight=space.weights,
        mean=to_rows(space.means),
        covar=to_rows(space.covars),
        run_id=run_id,
    )


def _insert_association(connection: Connection, association: Association, run_id: int) -> None:
    """Write vocabulary, translation (where not 0) and alignment."""
    n_words, steps = len(association.words), len(association.log_likelihoods)
    connection.insert(
        "word",
        word_id=np.arange(n_words),
        word=list(association.words),
        count=association.counts,
        run_id=run_id,
    )
    rows, words = np.nonzero(association.translation)
    connection.insert(
        "translation",
        symbol_id=rows - 1,
        word_id=words,
        probability=association.translation[rows, words],
        run_id=run_id,
    )
    lengths = [(length, m) for length, m in association.alignment for _ in range(m)]
    connection.insert(
        "alignment",
        l=np.array([length for length, _ in lengths], dtype=np.int64),
        m=np.array([m for _, m in lengths], dtype=np.int64),
        j=np.concatenate([np.arange(m) for _, m in association.alignment] or [np.arange(0)]),
        probabilities=ragged([row for rows in association.alignment.values() for row in rows]),
        run_id=run_id,
    )
    connection.insert(
        "association_step",
        step=np.arange(steps),
        log_likelihood=association.log_likelihoods,
        run_id=run_id,
    )


def _insert_transitions(connection: Connection, counts: FloatArray, run_id: int) -> None:
    """Write the transition counts that are not 0."""
    rows, columns = np.nonzero(counts)
    connection.insert(
        "transition_count",
        symbol_id=rows - 1,
        next_id=columns - 1,
        count=counts[rows, columns],
        run_id=run_id,
    )


def _insert_parameters(
    connection: Connection, parameters: Mapping[str, FloatArray | str], run_id: int
) -> None:
    """Write arrays of any shape, and texts, by name."""
    texts = {name: value for name, value in parameters.items() if isinstance(value, str)}
    values = list(texts.values())
    connection.insert("parameter", name=list(texts), piece=0, text=values, run_id=run_id)
    rows: list[tuple[str, int, NDArray[Any], FloatArray]] = []
    for name, array in parameters.items():
        if not isinstance(array, str):
            shape = np.array(np.shape(array), dtype=np.int64)
            flat = np.asarray(array, dtype=np.float64).ravel()
            for piece, first in enumerate(range(0, max(flat.size, 1), _PIECE)):
                rows.append((name, piece, shape, flat[first : first + _PIECE]))
    starts = np.cumsum([0, *(len(numbers) for *_, numbers in rows)]) // _PIECE
    for _, together in itertools.groupby(zip(starts, rows), key=operator.itemgetter(0)):
        names, pieces, shapes, numbers = zip(*(row for _, row in together))
        connection.insert(
            "parameter",
            name=names,
            piece=pieces,
            shape=ragged(shapes),
            numbers=ragged(numbers),
            run_id=run_id,
        )


def _load_alignment(store: Store) -> dict[tuple[int, int], FloatArray]:
    """Load a(i | j, l, m) by (l, m): arrays (m, l + 1)."""
    rows = store.connection.arrays("SELECT l, m, probabilities FROM alignment ORDER BY l, m, j")
    keys = np.stack([rows["l"], rows["m"]], axis=1)
    starts = np.flatnonzero(np.any(np.diff(keys, axis=0, prepend=-1) != 0, axis=1))
    return {
        (int(length), int(m)): from_rows(rows["probabilities"][start : start + m], (length + 1,))
        for start, (length, m) in zip(starts, keys[starts])
    }
