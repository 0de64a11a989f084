"""Read the readable parts of a damaged database, capture by capture.

DuckDB refuses a block with a wrong checksum, and continues. Every column has its own blocks, and
neighbouring rows share blocks. The tables are therefore read column by column, and the long ones
capture by capture, so that only values in the damaged blocks are lost.

If the catalogue (number, name and digest of captures) cannot be read, only the stored files are
saved, under their file names.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from motiondb.errors import MotionDBError, StoreError
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, Event, Motion, Run
from motiondb.store.catalogue.generated import Provenance, load_provenance
from motiondb.store.catalogue.poses import POSE_SIZE, unflatten_motion
from motiondb.store.catalogue.runs import load_runs
from motiondb.store.catalogue.sources import Source, unpack_source
from motiondb.store.catalogue.where import COLUMNS
from motiondb.store.connection.columns import fetch, from_rows
from motiondb.store.connection.faults import is_damage
from motiondb.store.connection.handle import Store
from motiondb.store.connection.opening import connect

T = TypeVar("T")

_DEFAULTS: dict[str, Any] = {
    "format": "",
    "kind": "captured",
    "fps": MOTION_FPS,
    "n_frames": 0,
    "duration": 0.0,
    "motion_frames": 0,
    "leg_length": 0.8,
    "path": "",
    "run_id": 0,
    "notes": (),
    "motion_notes": (),
}  # Replacement for a column of the table ``capture`` that cannot be read


@dataclass(frozen=True, eq=False)
class SalvagedCapture:
    """A capture as far as it could be read."""

    info: CaptureInfo  # Its row and its tags; defaults where they could not be read
    source: Source | None  # The file as it was added, unpacked; None if it could not be read
    motion: Motion | None  # The canonical motion; None if it could not be read
    captions: tuple[Caption, ...] = ()  # What people wrote about it
    events: tuple[Event, ...] = ()
    provenance: Provenance | None = None  # Origin of the frames of a generated capture
    lost: tuple[str, ...] = ()  # What could not be read: "file", "motion", "words",


@dataclass
class _Losses:
    """The parts that could not be read, in the order in which they were tried."""

    names: list[str] = field(default_factory=list)

    def attempt(self, name: str, read: Callable[[], T]) -> T | None:
        """The answer of ``read``; None, and ``name`` is noted, where it fails."""
        try:
            return read()
        except (MotionDBError, ValueError, TypeError, KeyError, IndexError):
            self.names.append(name)
            return None


def open_damaged(path: str | Path, *, wait: float = 0.0) -> Store:
    """Open a database for reading without checking its contents."""
    path = Path(path)
    return Store(path, lambda _mode, _wait: connect(path, True, wait=wait), read_only=True)


@contextmanager
def opened_damaged(path: str | Path, *, wait: float = 0.0) -> Iterator[tuple[Store, list[str]]]:
    """Open a damaged database, without its log if the log is damaged.

    DuckDB keeps the latest changes in a log beside the file, ``PATH.wal``, and opens the file with
    all of the log or not at all. So the file is copied, and the copy opened without the log.
    """
    path = Path(path)
    if not path.exists():
        raise StoreError(f"{path}: expected a database, found no such file. Name another file.")
    log = path.with_name(f"{path.name}.wal")
    try:
        store = open_damaged(path, wait=wait)
    except StoreError as error:
        cause = error.__cause__
        if cause is None or not is_damage(cause) or not log.exists():
            raise
    else:
        with store:
            yield store, []
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(shutil.copy(path, folder))
        with open_damaged(copy) as store:
            yield store, [f"{log}: could not be read; the latest changes are lost."]


def salvage_captures(store: Store) -> Iterator[SalvagedCapture]:
    """Every capture of which anything can be read, in order of number."""
    rows, lost_columns = _read_catalogue(store)
    if rows is None:
        yield from _files_alone(store)
        return
    for row in rows:
        yield _salvage(store, row, lost_columns)


def salvage_runs(store: Store) -> list[Run]:
    """The runs, none if they cannot be read."""
    return _Losses().attempt("runs", partial(load_runs, store)) or []


def _read_catalogue(store: Store) -> tuple[list[dict[str, Any]] | None, tuple[str, ...]]:
    """Rows of the table ``capture``, and its unreadable columns; None without the vital ones."""
    columns: dict[str, dict[int, Any]] = {}
    losses = _Losses()
    for name in (*COLUMNS, "notes", "motion_notes"):
        values = losses.attempt(name, partial(_read_column, store, name))
        if values is not None:
            columns[name] = dict(values)
    if any(name not in columns for name in ("capture_id", "name", "sha256")):
        return None, ()
    rows = [
        {name: columns.get(name, {}).get(row, default) for name, default in _DEFAULTS.items()}
        | {name: columns[name][row] for name in ("capture_id", "name", "sha256")}
        for row in sorted(columns["capture_id"], key=columns["capture_id"].__getitem__)
    ]
    return rows, tuple(losses.names)


def _read_column(store: Store, name: str) -> list[tuple[int, Any]]:
    return store.connection.execute(f"SELECT rowid, {name} FROM capture").fetchall()


def _salvage(store: Store, row: dict[str, Any], lost_columns: Sequence[str]) -> SalvagedCapture:
    number, losses = row["capture_id"], _Losses()
    source = losses.attempt("file", lambda: _read_source(store, row["sha256"]))
    motion = losses.attempt("motion", lambda: _read_motion(store, row, lost_columns))
    captions = losses.attempt("words", lambda: _read_captions(store, number))
    events = losses.attempt("events", lambda: _read_events(store, number))
    tags = losses.attempt("tags", lambda: _read_tags(store, number))
    provenance = losses.attempt("origin of its frames", lambda: load_provenance(store, number))
    info = CaptureInfo(
        **{name: row[name] for name in COLUMNS}, tags=tags or {}, notes=tuple(row["notes"] or ())
    )
    return SalvagedCapture(
        info,
        source,
        motion,
        captions or (),
        events or (),
        provenance if provenance is not None and provenance.sources else None,
        (*losses.names, *(f"column {name}" for name in lost_columns)),
    )


def _read_source(store: Store, sha256: str) -> Source:
    row = store.connection.execute(
        "SELECT sha256, format, file_name, data, skeleton_name, skeleton_data FROM source "
        "WHERE sha256 = ?",
        [sha256],
    ).fetchone()
    if row is None:
        raise KeyError(sha256)
    return unpack_source(store.path, Source(*row))


def _read_motion(store: Store, row: dict[str, Any], lost_columns: Sequence[str]) -> Motion:
    rows = fetch(
        store.connection,
        "SELECT frame, pose FROM motion_frame WHERE capture_id = ? ORDER BY frame",
        [row["capture_id"]],
    )
    poses = from_rows(rows["pose"], (POSE_SIZE,), np.float32)
    whole = len(poses) if "motion_frames" in lost_columns else row["motion_frames"]
    if len(poses) != whole or rows["frame"].tolist() != list(range(len(poses))) or not len(poses):
        raise ValueError("frames are missing")
    if not np.isfinite(poses).all():
        raise ValueError("poses are not finite")
    return unflatten_motion(poses, row["leg_length"], tuple(row["motion_notes"] or ()))


def _read_captions(store: Store, number: int) -> tuple[Caption, ...]:
    rows = store.connection.execute(
        "SELECT words, start_s, end_s FROM caption WHERE capture_id = ? ORDER BY ordinal", [number]
    ).fetchall()
    return tuple(Caption(*row) for row in rows)


def _read_events(store: Store, number: int) -> tuple[Event, ...]:
    rows = store.connection.execute(
        "SELECT frame, name, joint, other FROM event WHERE capture_id = ? ORDER BY ALL", [number]
    ).fetchall()
    return tuple(Event(*row) for row in rows)


def _read_tags(store: Store, number: int) -> dict[str, str]:
    rows = store.connection.execute(
        "SELECT key, value FROM capture_tag WHERE capture_id = ? ORDER BY key", [number]
    ).fetchall()
    return {str(key): str(value) for key, value in rows}


def _files_alone(store: Store) -> Iterator[SalvagedCapture]:
    """The stored files, where the catalogue cannot be read."""
    losses = _Losses()
    rows = losses.attempt(
        "files", lambda: store.connection.execute("SELECT rowid FROM source").fetchall()
    )
    for (row,) in rows or ():
        source = losses.attempt("file", partial(_read_source_row, store, row))
        if source is None:
            continue
        name = Path(source.file_name).stem
        values = _DEFAULTS | {"format": source.format, "sha256": source.sha256, "name": name}
        info = CaptureInfo(capture_id=row, **{k: values[k] for k in COLUMNS if k != "capture_id"})
        yield SalvagedCapture(
            info, source, None, lost=("motion", "words", "events", "tags", "name")
        )


def _read_source_row(store: Store, row: int) -> Source:
    source = store.connection.execute(
        "SELECT sha256, format, file_name, data, skeleton_name, skeleton_data FROM source "
        "WHERE rowid = ?",
        [row],
    ).fetchone()
    if source is None:
        raise KeyError(row)
    return unpack_source(store.path, Source(*source))
