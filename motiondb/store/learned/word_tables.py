"""Tables of the words: vocabulary, translation, alignment; and of transitions and parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motiondb.records import Association, FloatArray
from motiondb.store.connection.columns import fetch, from_rows, insert, to_rows
from motiondb.store.connection.statements import Connection

TABLES = ("word", "translation", "alignment", "association_step", "transition_count", "parameter")
PIECE = 65_536  # Numbers in one row of the table ``parameter``


def insert_association(connection: Connection, association: Association, run_id: int) -> None:
    """Write vocabulary, translation (where not 0) and alignment."""
    n_words, steps = len(association.words), len(association.log_likelihoods)
    insert(
        connection,
        "word",
        word_id=np.arange(n_words),
        word=list(association.words),
        count=association.counts,
        run_id=np.full(n_words, run_id),
    )
    rows, words = np.nonzero(association.translation)
    insert(
        connection,
        "translation",
        symbol_id=rows - 1,
        word_id=words,
        probability=association.translation[rows, words],
        run_id=np.full(len(rows), run_id),
    )
    for (length, m), probabilities in association.alignment.items():
        insert(
            connection,
            "alignment",
            l=np.full(m, length),
            m=np.full(m, m),
            j=np.arange(m),
            probabilities=to_rows(probabilities),
            run_id=np.full(m, run_id),
        )
    insert(
        connection,
        "association_step",
        step=np.arange(steps),
        log_likelihood=association.log_likelihoods,
        run_id=np.full(steps, run_id),
    )


def select_association(connection: Connection, n_symbols: int) -> Association:
    """Read the association of words with ``n_symbols`` symbols."""
    words = fetch(connection, "SELECT word, count FROM word ORDER BY word_id")
    cells = fetch(connection, "SELECT symbol_id, word_id, probability FROM translation")
    translation = np.zeros((n_symbols + 1, len(words["word"])))
    translation[cells["symbol_id"] + 1, cells["word_id"]] = cells["probability"]
    steps = fetch(connection, "SELECT log_likelihood FROM association_step ORDER BY step")
    return Association(
        tuple(words["word"].tolist()),
        words["count"],
        translation,
        _select_alignment(connection),
        steps["log_likelihood"],
    )


def insert_transitions(connection: Connection, counts: FloatArray, run_id: int) -> None:
    """Write the transition counts that are not 0."""
    rows, columns = np.nonzero(counts)
    insert(
        connection,
        "transition_count",
        symbol_id=rows - 1,
        next_id=columns - 1,
        count=counts[rows, columns],
        run_id=np.full(len(rows), run_id),
    )


def select_transitions(connection: Connection, n_symbols: int) -> FloatArray:
    """Read the transition counts: array (symbols + 1, symbols + 1)."""
    cells = fetch(connection, "SELECT symbol_id, next_id, count FROM transition_count")
    counts = np.zeros((n_symbols + 1, n_symbols + 1))
    counts[cells["symbol_id"] + 1, cells["next_id"] + 1] = cells["count"]
    return counts


def insert_parameters(
    connection: Connection, parameters: Mapping[str, FloatArray | str], run_id: int
) -> None:
    """Write arrays of any shape, and texts, by name."""
    texts = {name: value for name, value in parameters.items() if isinstance(value, str)}
    insert(
        connection,
        "parameter",
        name=list(texts),
        piece=np.zeros(len(texts), dtype=np.int64),
        text=list(texts.values()),
        run_id=np.full(len(texts), run_id),
    )
    for name, array in parameters.items():
        if isinstance(array, str):
            continue
        flat = np.asarray(array, dtype=np.float64).ravel()
        pieces = [flat[first : first + PIECE] for first in range(0, max(flat.size, 1), PIECE)]
        n, numbers = len(pieces), np.empty(len(pieces), dtype=object)
        for piece, values in enumerate(pieces):
            numbers[piece] = values
        insert(
            connection,
            "parameter",
            name=[name] * n,
            piece=np.arange(n),
            shape=to_rows(np.tile(np.array(np.shape(array), dtype=np.int64), (n, 1))),
            numbers=numbers,
            run_id=np.full(n, run_id),
        )


def select_parameters(
    connection: Connection, names: tuple[str, ...] | None = None
) -> dict[str, FloatArray | str]:
    """Read the values of these names and of all names "NAME. ..." below them, or all values."""
    wanted = "name = ? OR starts_with(name, ? || '.')"
    where = "true" if names is None else " OR ".join([wanted] * len(names)) or "false"
    rows = connection.execute(
        f"SELECT name, shape, numbers, text FROM parameter WHERE {where} ORDER BY name, piece",
        [name for name in names or () for _ in range(2)],
    ).fetchnumpy()
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


def _select_alignment(
    connection: Connection,
) -> dict[tuple[int, int], FloatArray]:
    rows = fetch(connection, "SELECT l, m, probabilities FROM alignment ORDER BY l, m, j")
    keys = np.stack([rows["l"], rows["m"]], axis=1)
    starts = np.flatnonzero(np.any(np.diff(keys, axis=0, prepend=-1) != 0, axis=1))
    return {
        (int(length), int(m)): from_rows(rows["probabilities"][start : start + m], (length + 1,))
        for start, (length, m) in zip(starts, keys[starts])
    }
