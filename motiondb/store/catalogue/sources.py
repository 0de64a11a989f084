"""Where captures come from: their files, returned bit for bit, or the captures they are made of.

A generated capture has a provenance: the source and the licence of every frame.

Also the files that ``add`` has read, and those that it did not save: unreadable, or of known
content. What is noted of a folder is replaced when the folder is added again. Files that were read
are kept as they were then; what the texts hold is for ``add`` to say.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from motiondb.errors import QueryError, StoreError
from motiondb.files.packed_files import Source, digest
from motiondb.records import FloatArray, IntArray
from motiondb.store.catalogue.parquet_files import load_part
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import columns_of
from motiondb.store.connection.transactions import transaction

_AT_ONCE = 1000  # DuckDB finds so many rows by their index


def load_source(store: Store, capture_id: int) -> Source:
    """Load the file of a capture, uncompressed and equal bit for bit to the file that was added."""
    source = load_packed_source(store, capture_id)
    if not source.data:
        raise QueryError(
            f"{source.file_name}: expected the file as it was added, found that it was left out "
            "(--no-originals). Export the motion on the canonical body (--canonical), or add its "
            "file again."
        )
    return unpack_source(store.path, source)


def load_packed_source(store: Store, capture_id: int) -> Source:
    """Load the file of a capture as it is stored, for another store."""
    query = "sha256 = (SELECT sha256 FROM capture WHERE capture_id = ?)"
    source = find_source(store, query, capture_id)
    if source is None:
        raise QueryError(f"capture {capture_id}: expected a capture in {store.path}, found none.")
    return source


def load_left_out(store: Store, digests: Sequence[str]) -> set[str]:
    """Those of some digests whose files are without their bytes."""
    found = set[str]()
    for first in range(0, len(digests), _AT_ONCE):
        some = digests[first : first + _AT_ONCE]
        query = (
            f"SELECT sha256 FROM source WHERE sha256 IN ({', '.join('?' * len(some))}) "
            "AND octet_length(data) = 0 AND data_at IS NULL"
        )
        found |= set(store.connection.column(query, some))
    return found


def fill_in(store: Store, source: Source) -> None:
    """Keep the bytes of a file that was left out."""
    with transaction(store) as connection:
        connection.execute(
            "UPDATE source SET file_name = ?, skeleton_name = ?, data = ?, skeleton_data = ? "
            "WHERE sha256 = ?",
            [
                source.file_name,
                source.skeleton_name,
                source.data,
                source.skeleton_data,
                source.sha256,
            ],
        )


def find_source(store: Store, condition: str, value: object) -> Source | None:
    """The file whose row satisfies a condition with one parameter, as it is stored, or None."""
    query = f"SELECT * FROM source WHERE {condition}"  # a damaged older file has fewer columns
    row = store.connection.execute(query, [value]).fetchone()
    if row is None:
        return None
    sha256, kind, file_name, skeleton_name, data, skeleton, *rest = row
    data_at, skeleton_at = rest or (None, None)
    return Source(
        sha256,
        kind,
        file_name,
        data if data_at is None else load_part(store, data_at),
        skeleton_name,
        skeleton if skeleton_at is None else load_part(store, skeleton_at),
    )


def unpack_source(path: Path, source: Source) -> Source:
    """Decompress the stored bytes of a file and check their digest."""
    packed = source.skeleton_data
    try:
        data = zlib.decompress(source.data)
        skeleton = None if packed is None else zlib.decompress(packed)
    except zlib.error:
        data, skeleton = b"", None
    if digest(data, skeleton, source.take) != source.sha256:
        raise StoreError(
            f"{path}: expected the bytes of {source.file_name} with digest {source.sha256[:12]}, "
            "found others. The file is damaged: restore a copy, or add the capture again."
        )
    return replace(source, data=data, skeleton_data=skeleton)


@dataclass(frozen=True)
class SourceCapture:
    """A capture that a generated capture was made from, as it was at that time."""

    name: str  # Name of the capture
    sha256: str  # Digest of its file, hexadecimal
    licence: str  # Its tag ``licence``, "" if it has none


@dataclass(frozen=True, eq=False)
class Provenance:
    """The source of every frame of a generated capture."""

    sources: tuple[SourceCapture, ...]  # The captures that frames come from
    # (frames,): index into ``sources``, -1 where the frame was drawn from the model
    source_numbers: IntArray
    # (frames,): frame of the source, at 30 a second, possibly between two frames; 0 if the frame
    # was drawn from the model
    source_frames: FloatArray
    warps: FloatArray  # (frames,): number of source frames that pass for each frame
    # What was changed in each frame, such as "", "blend 0.40" or "foot lock"
    edits: tuple[str, ...]

    @property
    def licences(self) -> tuple[str, ...]:
        """The licence of each frame's source; "" where the frame was drawn from the model."""
        by_number = (*(source.licence for source in self.sources), "")
        return tuple(by_number[number] for number in self.source_numbers)


def to_provenance(
    store: Store,
    capture_ids: IntArray,
    source_frames: FloatArray | IntArray,
    warps: FloatArray | None = None,
    edits: tuple[str, ...] = (),
) -> Provenance:
    """Look up the captures (frames,) that frames come from: names, digests, licences."""
    n = len(capture_ids)
    known = {
        number: SourceCapture(*rest)
        for number, *rest in store.connection.execute(
            "SELECT c.capture_id, name, sha256, coalesce(value, '') FROM capture c LEFT JOIN "
            "capture_tag t ON t.capture_id = c.capture_id AND key = 'licence'"
        ).fetchall()
    }
    used = sorted({int(number) for number in capture_ids} - {-1})
    for number in used:
        if number not in known:
            raise QueryError(f"capture {number}: expected a capture in {store.path}, found none.")
    place = {number: ordinal for ordinal, number in enumerate(used)} | {-1: -1}
    return Provenance(
        tuple(known[number] for number in used),
        np.array([place[int(number)] for number in capture_ids], dtype=np.int64),
        np.asarray(source_frames, dtype=float),
        np.ones(n) if warps is None else np.asarray(warps, dtype=float),
        tuple(edits) or ("",) * n,
    )


def save_provenance(store: Store, capture_id: int, provenance: Provenance) -> None:
    """Save the provenance of a capture, replacing any that it had."""
    sources, n = provenance.sources, len(provenance.source_numbers)
    with transaction(store) as connection:
        for table in ("generated_source", "frame_source"):
            connection.execute(f"DELETE FROM {table} WHERE capture_id = ?", [capture_id])
        connection.insert(
            "generated_source",
            capture_id=capture_id,
            ordinal=list(range(len(sources))),
            source_name=[source.name for source in sources],
            source_sha256=[source.sha256 for source in sources],
            licence=[source.licence for source in sources],
        )
        connection.insert(
            "frame_source",
            capture_id=capture_id,
            frame=np.arange(n),
            source_ordinal=provenance.source_numbers,
            source_frame=provenance.source_frames,
            warp=provenance.warps,
            edit=list(provenance.edits),
        )


def load_provenance(store: Store, capture_id: int) -> Provenance:
    """Load the provenance of a capture."""
    sources = store.connection.execute(
        "SELECT source_name, source_sha256, licence FROM generated_source "
        "WHERE capture_id = ? ORDER BY ordinal",
        [capture_id],
    ).fetchall()
    rows = store.connection.arrays(
        "SELECT source_ordinal, source_frame, warp, edit FROM frame_source "
        "WHERE capture_id = ? ORDER BY frame",
        [capture_id],
    )
    return Provenance(
        tuple(SourceCapture(*source) for source in sources),
        rows["source_ordinal"].astype(np.int64),
        rows["source_frame"],
        rows["warp"],
        tuple(rows["edit"].tolist()),
    )


@dataclass(frozen=True)
class NotSaved:
    """The files of added files and folders that are no captures of their own."""

    folders: Sequence[Path]
    faulty: dict[str, str] = field(default_factory=dict)  # Path -> why it could not be read
    same: dict[str, str] = field(default_factory=dict)  # Path -> name of the capture


def save_not_saved(store: Store, files: NotSaved) -> None:
    """Replace what is noted of the files and folders."""
    faulty, same = _noted(store, files.folders)
    new_faulty, new_same = _absolute(files.faulty), _absolute(files.same)
    numbers = dict(store.connection.execute("SELECT name, capture_id FROM capture").fetchall())
    noted = datetime.now(UTC).isoformat(timespec="seconds")
    with transaction(store) as connection:
        for path, _ in faulty.items() - new_faulty.items():
            connection.execute("DELETE FROM faulty_file WHERE path = ?", [path])
        for path, problem in new_faulty.items() - faulty.items():
            connection.insert_row("faulty_file", path, problem, noted)
        for path, _ in same.items() - new_same.items():
            connection.execute("DELETE FROM same_file WHERE path = ?", [path])
        for path, name in new_same.items() - same.items():
            if name in numbers:
                connection.insert_row("same_file", path, numbers[name])


def is_noted(store: Store, files: NotSaved) -> bool:
    """Whether this is what is noted of the files and folders."""
    return _noted(store, files.folders) == (_absolute(files.faulty), _absolute(files.same))


def load_faulty(store: Store) -> list[tuple[str, str, str]]:
    """Load path, problem and time (ISO 8601, UTC) of the faulty files, by path."""
    query = "SELECT path, problem, noted FROM faulty_file ORDER BY path"
    rows = store.connection.execute(query).fetchall()
    return [(str(path), str(problem), str(noted)) for path, problem, noted in rows]


def load_same_files(store: Store) -> list[tuple[str, str]]:
    """Load the path of files that have the content of a capture, and its name; by path."""
    query = "SELECT f.path, name FROM same_file f JOIN capture USING (capture_id) ORDER BY ALL"
    return [(str(path), str(name)) for path, name in store.connection.execute(query).fetchall()]


def _noted(store: Store, folders: Sequence[Path]) -> tuple[dict[str, str], dict[str, str]]:
    """What is noted of files and folders: faulty files, and those of known content."""
    roots = tuple(os.path.abspath(folder) for folder in folders)  # noqa: PTH100  links stay
    below = tuple(os.path.join(root, "") for root in roots)  # noqa: PTH118  ends in a slash

    def is_among(path: str) -> bool:
        return path in roots or path.startswith(below)

    faulty = {path: problem for path, problem, _ in load_faulty(store) if is_among(path)}
    return faulty, {path: name for path, name in load_same_files(store) if is_among(path)}


def _absolute(files: Mapping[str, str]) -> dict[str, str]:
    return {os.path.abspath(path): told for path, told in files.items()}  # noqa: PTH100


@dataclass(frozen=True)
class KnownFile:
    """A file when it was read."""

    state: str  # Size, time and access of the file and its skeleton file
    options: str  # How it was read
    readings: str  # What was found


def load_known_files(store: Store, paths: Sequence[str]) -> dict[str, KnownFile]:
    """Load those of some files that were read, by their absolute paths."""
    query = "FROM known_file WHERE path IN (SELECT unnest($1))"
    rows = store.connection.execute(query, [list(paths)]).fetchall()
    return {path: KnownFile(*row) for path, *row in rows}


def save_known_files(store: Store, files: Mapping[str, KnownFile]) -> None:
    """Note files that were read, in place of what was noted of them."""
    with transaction(store) as connection:
        columns = columns_of(KnownFile, list(files.values()))
        connection.insert_or_replace("known_file", path=list(files), **columns)
