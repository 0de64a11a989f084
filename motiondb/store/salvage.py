"""Read the readable parts of a damaged database: captures one by one, and what they share.

DuckDB refuses a block with a wrong checksum, and continues. Every column has its own blocks, and
neighbouring rows share blocks. The catalogue is therefore read column by column, and the long
tables capture by capture, so that only values in the damaged blocks are lost.

If the catalogue (number, name and digest of captures) cannot be read, only the stored files are
saved, under their file names.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from motiondb.errors import MotionDBError, StoreError
from motiondb.files.packed_files import Source
from motiondb.files.safe_files import link_target, log_of
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, Event, Motion, Run
from motiondb.store.catalogue.annotations import (
    load_captions,
    load_events,
    load_relations,
    load_synonyms,
    save_relations,
    save_synonyms,
)
from motiondb.store.catalogue.captures import load_poses, unflatten_motion
from motiondb.store.catalogue.parquet_files import MOTIONS, advice, load_parquet_files
from motiondb.store.catalogue.places import PlaceError, find_file, told
from motiondb.store.catalogue.runs import load_runs
from motiondb.store.catalogue.sources import Provenance, find_source, load_provenance, unpack_source
from motiondb.store.catalogue.where import COLUMNS
from motiondb.store.connection.faults import is_damage
from motiondb.store.connection.handle import Store
from motiondb.store.connection.opening import checked, connect
from motiondb.store.connection.transactions import transaction
from motiondb.store.grammars import (
    load_derivation,
    load_grammar,
    load_grammar_names,
    save_derivation,
    save_grammar,
)
from motiondb.store.scenes import load_scene, load_scene_names, save_scene

T = TypeVar("T")

_VITAL = ("capture_id", "name", "sha256")
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
    lost: tuple[str, ...] = ()  # What could not be read: "file", "motion", "words", ...


@contextmanager
def opened_damaged(path: str | Path, *, wait: float = 0.0) -> Iterator[tuple[Store, list[str]]]:
    """Open a damaged database for reading; without its log, a copy, if that is damaged."""

    def connected(path: str | Path) -> Store:
        path = Path(path)
        return checked(
            Store(path, lambda _mode, _wait: connect(path, True, wait=wait), read_only=True)
        )

    path = link_target(Path(path))
    if not path.exists():
        raise StoreError(f"{path}: expected a database, found no such file. Name another file.")
    log = log_of(path)
    try:
        store = connected(path)
    except StoreError as error:
        cause = error.__cause__
        if cause is None or not is_damage(cause) or not log.exists():
            raise
    else:
        with store:
            yield store, [store.loss_note] if store.loss_note else []
        return
    with tempfile.TemporaryDirectory() as folder, connected(shutil.copy(path, folder)) as store:
        yield store, [f"{log}: could not be read; the latest changes are lost."]


def salvage_runs(store: Store) -> list[Run]:
    """The runs, none if they cannot be read."""
    return _attempt([], "", lambda: load_runs(store)) or []


def check_places(store: Store) -> None:
    """PlaceError if a Parquet file of motions is missing or cannot be reached."""
    for file in _attempt([], "", lambda: load_parquet_files(store)) or ():
        lost = "If it is lost for good, put an empty file of this name there."
        if file.kind == MOTIONS:  # scores are not saved
            with told(file.path, f"{advice(store, file)} {lost}"):
                find_file(file.place, file.name)


def salvage_captures(store: Store) -> Iterator[SalvagedCapture]:
    """Every capture of which anything can be read, in order of number."""
    columns: dict[str, dict[int, Any]] = {}
    lost_columns: list[str] = []
    for name in (*COLUMNS, "notes", "motion_notes"):
        query = f"SELECT rowid, {name} FROM capture"
        values = _attempt(lost_columns, name, partial(_rows, store, query))
        if values is not None:
            columns[name] = dict(values)
    if any(name not in columns for name in _VITAL):
        yield from _files_alone(store)
        return
    for at in sorted(columns["capture_id"], key=columns["capture_id"].__getitem__):
        row = {name: columns.get(name, {}).get(at, default) for name, default in _DEFAULTS.items()}
        row |= {name: columns[name][at] for name in _VITAL}
        yield _salvage(store, row, lost_columns)


def _attempt(lost: list[str], what: str, read: Callable[[], T]) -> T | None:
    """The answer of ``read``; None, and ``what`` is noted as lost, where it fails."""
    try:
        return read()
    except PlaceError:  # nothing is known of what lies there
        raise
    except (MotionDBError, ValueError, TypeError, KeyError, IndexError):
        lost.append(what)
        return None


def _rows(store: Store, query: str, *parameters: object) -> list[tuple[Any, ...]]:
    return store.connection.execute(query, parameters).fetchall()


def _salvage(store: Store, row: dict[str, Any], lost_columns: Sequence[str]) -> SalvagedCapture:
    number, lost = row["capture_id"], list[str]()
    source = _attempt(lost, "file", lambda: _read_source(store, "sha256", row["sha256"]))
    motion = _attempt(lost, "motion", lambda: _read_motion(store, row, lost_columns))
    captions = _attempt(lost, "words", lambda: load_captions(store, [number]))
    events = _attempt(lost, "events", lambda: load_events(store, [number]))
    query = "SELECT key, value FROM capture_tag WHERE capture_id = ? ORDER BY key"
    tags = _attempt(lost, "tags", lambda: _rows(store, query, number))
    provenance = _attempt(lost, "origin of its frames", lambda: load_provenance(store, number))
    info = CaptureInfo(
        **{name: row[name] for name in COLUMNS},
        tags=dict(tags or ()),
        notes=tuple(row["notes"] or ()),
    )
    return SalvagedCapture(
        info,
        source,
        motion,
        (captions or {}).get(number, ()),
        (events or {}).get(number, ()),
        provenance if provenance is not None and provenance.sources else None,
        (*lost, *(f"column {name}" for name in lost_columns)),
    )


def _read_source(store: Store, key: str, value: object) -> Source:
    source = find_source(store, f"{key} = ?", value)
    if source is None:
        raise KeyError(value)
    if not source.data:  # it was left out
        return source
    return unpack_source(store.path, source)


def _read_motion(store: Store, row: dict[str, Any], lost_columns: Sequence[str]) -> Motion:
    poses = load_poses(store, row["capture_id"])
    whole = len(poses) if "motion_frames" in lost_columns else row["motion_frames"]
    if len(poses) != whole or not len(poses):
        raise ValueError("frames are missing")
    if not np.isfinite(poses).all():
        raise ValueError("poses are not finite")
    return unflatten_motion(poses, row["leg_length"], tuple(row["motion_notes"] or ()))


def _files_alone(store: Store) -> Iterator[SalvagedCapture]:
    """The stored files, where the catalogue cannot be read."""
    rows = _attempt([], "", lambda: _rows(store, "SELECT rowid FROM source"))
    for (row,) in rows or ():
        source = _attempt([], "", partial(_read_source, store, "rowid", row))
        if source is None or not source.data:
            continue
        name = Path(source.own_name).stem + (f"#{source.take}" if source.take else "")
        values = _DEFAULTS | {"format": source.format, "sha256": source.sha256, "name": name}
        info = CaptureInfo(capture_id=row, **{k: values[k] for k in COLUMNS if k != "capture_id"})
        lost = ("motion", "words", "events", "tags", "name")
        yield SalvagedCapture(info, source, None, lost=lost)


def copy_shared(damaged: Store, new: Store, run_id: int) -> list[str]:
    """Copy synonyms, copies, grammars, scenes; a sentence for all that could not be read."""
    lost: list[str] = []
    numbers = _new_numbers(damaged, new)

    def copy(what: str, save: Callable[[], object]) -> None:
        _attempt(lost, f"{what}: could not be read.", save)

    def copy_each(
        kind: str, names: Callable[[Store], Iterable[str]], save: Callable[[str], object]
    ) -> None:
        missing = f"every {kind}: the table {kind} could not be read."
        for name in _attempt(lost, missing, lambda: list(names(damaged))) or ():
            copy(f"{kind} {name}", partial(save, name))

    def save_a_scene(name: str) -> None:
        scene = load_scene(damaged, name)
        players = (replace(p, capture_id=numbers.get(p.capture_id, -1)) for p in scene.players)
        save_scene(new, replace(scene, players=tuple(players)), run_id)

    copy("synonyms", lambda: save_synonyms(new, load_synonyms(damaged)))
    copy("the list of copies", lambda: _copy_relations(damaged, new))
    copy_each(
        "grammar",
        load_grammar_names,
        lambda name: save_grammar(new, load_grammar(damaged, name), run_id),
    )
    copy("derivations", lambda: _copy_derivations(damaged, new, numbers, run_id))
    copy_each("scene", load_scene_names, save_a_scene)
    return lost


def _new_numbers(damaged: Store, new: Store) -> dict[int, int]:
    """Number of a capture in the damaged store -> in the new one, by digest."""
    query = "SELECT sha256, capture_id FROM capture"
    after = dict(_rows(new, query))
    before = _attempt([], "", lambda: _rows(damaged, query)) or ()
    return {number: after[sha256] for sha256, number in before if sha256 in after}


def _copy_relations(damaged: Store, new: Store) -> None:
    names = set(new.connection.column("SELECT name FROM capture"))
    kept = [r for r in load_relations(damaged) if r.capture in names and r.other in names]
    save_relations(new, kept)


def _copy_derivations(damaged: Store, new: Store, numbers: Mapping[int, int], run_id: int) -> None:
    grammars = dict(_rows(new, "SELECT name, grammar_id FROM grammar"))
    with transaction(new):
        for before, after in numbers.items():
            derivation = load_derivation(damaged, before)
            if derivation is not None and derivation.grammar in grammars:
                save_derivation(new, after, grammars[derivation.grammar], derivation, run_id)


def was_learned(damaged: Store) -> bool:
    """Whether a damaged database had learned; True where that cannot be read."""
    try:
        return bool(damaged.connection.value("SELECT count(*) FROM learning"))
    except MotionDBError:
        return True
