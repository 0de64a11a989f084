"""Tables of the segments and of their scores under every symbol."""

from __future__ import annotations

import numpy as np

from motiondb.records import SegmentTable
from motiondb.store.connection.columns import fetch, from_rows, insert, to_rows
from motiondb.store.connection.statements import Connection

TABLES = ("segment", "segment_score", "segment_movement")


def insert_segments(connection: Connection, segments: SegmentTable, run_id: int) -> None:
    """Write the segments in their order."""
    ordinals = np.arange(len(segments.starts))
    runs = np.full(len(ordinals), run_id)
    insert(
        connection,
        "segment",
        capture_id=segments.capture_ids,
        ordinal=ordinals,
        start_frame=segments.starts,
        end_frame=segments.ends,
        symbol_id=segments.symbols,
        log_likelihood=segments.log_likelihoods,
        background=segments.backgrounds,
        run_id=runs,
    )
    scores = to_rows(segments.scores)
    insert(connection, "segment_score", ordinal=ordinals, scores=scores, run_id=runs)
    if segments.movement.shape[1]:
        rows = to_rows(segments.movement)
        insert(connection, "segment_movement", ordinal=ordinals, movement=rows, run_id=runs)


def select_segments(connection: Connection, n_symbols: int, scores: bool = True) -> SegmentTable:
    """Read the segments; without ``scores`` their array has no columns."""
    rows = fetch(
        connection,
        "SELECT capture_id, start_frame, end_frame, symbol_id, log_likelihood, background "
        "FROM segment ORDER BY ordinal",
    )
    n = len(rows["capture_id"])
    table, movement = np.zeros((2, n, 0), dtype=np.float32)
    if scores:
        column = fetch(connection, "SELECT scores FROM segment_score ORDER BY ordinal")["scores"]
        table = from_rows(column, (n_symbols,), np.float32)
        moving = fetch(connection, "SELECT movement FROM segment_movement ORDER BY ordinal")
        if len(moving["movement"]):
            width = len(moving["movement"][0])
            movement = from_rows(moving["movement"], (width,), np.float32)
    return SegmentTable(
        rows["capture_id"],
        rows["start_frame"],
        rows["end_frame"],
        rows["symbol_id"],
        rows["log_likelihood"],
        rows["background"],
        table,
        movement,
    )
