"""The catalogue: captures with their files, motions, tags and captions.

The number and digest of a capture never change after :func:`save_capture`, and a number is never
used again. When a capture is removed, its segments are removed with it. Everything else that
was learned stays; ``learning_is_current`` then returns False.

Poses as they are stored: packed, and the same bit by bit when they are unpacked.

A number of a pose changes slowly from frame to frame. Where all are multiples of ``POSE_STEP``, as
those of captures are, each is that integer; else the 32 bits of each float are read as one. Each
column of integers is replaced by its second differences in time (modulo 2^32). Of multiples, w of a
quaternion is replaced by 2 (|w| - e) + (w < 0), e = sqrt(1 - x^2 - y^2 - z^2) rounded: mostly 0 or
1. All are turned so that small ones, of either sign, have leading zeros. Then the first bytes of
all numbers stand together, then the second ones, and so on, and zlib packs them, looking for runs
only: its search for other repetitions took three times as long and found none. Measured on an hour
of CMU captures: 6.9 MB of multiples (9.1 with w as it is), 15 MB of floats; the floats take 38, and
34 in DuckDB's own compression.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import QueryError, StoreError, suggestion
from motiondb.files.packed_files import Source
from motiondb.files.safe_files import odd_kind
from motiondb.records import POSE_STEP, Caption, CaptureInfo, Float32Array, Motion
from motiondb.store.catalogue.annotations import (
    UNMEASURED,
    add_captions,
    add_tags,
    load_captions,
    load_measured,
    load_tags,
)
from motiondb.store.catalogue.parquet_files import load_part
from motiondb.store.catalogue.runs import OWN_TABLES, put_in_trash
from motiondb.store.catalogue.where import (
    COLUMNS,
    NOTHING,
    Filter,
    asks_captions,
    asks_measured,
    matches,
    parse_where,
    with_columns,
)
from motiondb.store.connection.faults import DamagedMotionError, damage_sentence
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import Connection, columns_of, ragged
from motiondb.store.connection.transactions import read_meta, touch, transaction, write_meta

MARKERS_ONLY = (
    "expected the motion of a body, found markers without one, or series. They are found by words "
    "and tags (motiondb list --where) and exported (.trc, .npz, .csv, .parquet), not searched by "
    "motion."
)
N_JOINTS = 21  # Of the canonical body (:data:`motiondb.body.body.JOINTS`)

_AT_ONCE = 64  # Captures that are saved by one statement, which holds their motions packed
_INFO = f"SELECT {', '.join(COLUMNS)}, notes FROM capture"


@dataclass(frozen=True, eq=False)
class NewCapture:
    """A capture to save, with all that belongs to it."""

    info: CaptureInfo  # Number, digest and sizes are set when it is saved
    motion: Motion
    source: Source
    captions: Sequence[Caption] = ()


def save_capture(
    store: Store,
    info: CaptureInfo,
    motion: Motion,
    source: Source,
    captions: Iterable[Caption] = (),
) -> CaptureInfo:
    """Add one capture with all that belongs to it; number, digest and sizes are set here."""
    return save_captures(store, [NewCapture(info, motion, source, tuple(captions))])[0]


def save_captures(store: Store, captures: Sequence[NewCapture]) -> list[CaptureInfo]:
    """Add captures as :func:`save_capture` does; 0.1 ms for one of 2 s among many."""
    if not captures:
        return []
    with transaction(store) as connection:
        _refuse_repeated(store, captures)
        first = int(read_meta(store, "next_capture_id"))
        write_meta(store, "next_capture_id", str(first + len(captures)))
        infos = [
            replace(
                new.info,
                capture_id=first + number,
                sha256=new.source.sha256,
                motion_frames=new.motion.n_frames,
                leg_length=float(new.motion.leg_length),
            )
            for number, new in enumerate(captures)
        ]
        for start in range(0, len(captures), _AT_ONCE):
            some = slice(start, start + _AT_ONCE)
            _insert(connection, infos[some], captures[some])
        touch(store, motions=True)
    return infos


def _insert(
    connection: Connection, infos: Sequence[CaptureInfo], captures: Sequence[NewCapture]
) -> None:
    """Insert the rows of captures; a statement costs as much as 50 captures of 2 s in it."""
    poses = [_finite_poses(new) for new in captures]
    sources = [new.source for new in captures]
    connection.insert("source", **columns_of(Source, sources))
    columns: dict[str, Any] = {name: [getattr(i, name) for i in infos] for name in COLUMNS}
    columns["notes"] = ragged([list(info.notes) for info in infos])
    columns["motion_notes"] = ragged([list(new.motion.notes) for new in captures])
    connection.insert("capture", **columns)
    numbers = [info.capture_id for info in infos]
    lengths, packed = [len(rows) for rows in poses], [pack_poses(rows) for rows in poses]
    connection.insert("motion", capture_id=numbers, n_frames=lengths, poses=packed)
    add_tags(connection, {info.capture_id: info.tags for info in infos})
    add_captions(connection, dict(zip(numbers, (new.captions for new in captures))))


def _finite_poses(new: NewCapture) -> Float32Array:
    """The poses of a motion: array (frames, 87); StoreError if a number is not finite."""
    poses = flatten_motion(new.motion)
    finite = np.isfinite(poses).all(axis=1)
    if not finite.all():
        raise StoreError(
            f"{new.info.name}: expected finite numbers in the motion, found others in frame "
            f"{int(finite.argmin())}. Nothing was saved; report the file."
        )
    return poses


def remove_captures(store: Store, numbers: Sequence[int]) -> None:
    """Remove captures and everything that belongs to them, in one transaction.

    This includes their files, motions, tags, captions, events, relations, segments and findings;
    all but the segments and findings go into the trash. Players of scenes whose motion they held
    stay, with ``capture_id`` -1.
    """
    if not numbers:
        return
    chosen = "(SELECT unnest($numbers))"
    own = [table for table in OWN_TABLES if table not in ("capture", "scene_player")]
    with transaction(store) as connection:
        put_in_trash(store, numbers)
        for statement in (
            *(
                f"DELETE FROM {table} WHERE capture_id IN {chosen}"
                for table in (*own, "segment", "segment_score", "finding", "capture_quality")
            ),
            f"UPDATE scene_player SET capture_id = -1 WHERE capture_id IN {chosen}",
            f"DELETE FROM relation WHERE capture_id IN {chosen} OR other_id IN {chosen}",
            "DELETE FROM source WHERE sha256 IN "
            f"(SELECT sha256 FROM capture WHERE capture_id IN {chosen})",
            f"DELETE FROM capture WHERE capture_id IN {chosen}",
        ):
            connection.execute(statement, {"numbers": list(numbers)})
        touch(store, motions=True)


def rename_capture(store: Store, capture_id: int, name: str) -> None:
    """Give a capture another name, which is free."""
    with transaction(store) as connection:
        connection.execute("UPDATE capture SET name = ? WHERE capture_id = ?", [name, capture_id])


def load_captures(store: Store, where: str | Sequence[Filter] = "") -> list[CaptureInfo]:
    """Load the captures that satisfy a filter (text or parsed), in order of number."""
    filters = parse_where(where) if isinstance(where, str) else where
    tags = load_tags(store)
    filters = with_columns(filters, {key for of_one in tags.values() for key in of_one})
    rows = store.connection.execute(f"{_INFO} ORDER BY capture_id").fetchall()
    infos = [_to_info(row, tags.get(row[0], {})) for row in rows]
    if not filters:
        return infos
    captions = load_captions(store) if asks_captions(filters) else {}
    texts = {number: [caption.words for caption in said] for number, said in captions.items()}
    measured: Mapping[int, Mapping[str, Sequence[str]]] = {}
    if asks_measured(filters):  # markers without a body have neither a number nor findings
        bodies = load_measured(store, sum(info.has_body for info in infos))
        measured = {info.capture_id: bodies.get(info.capture_id, UNMEASURED) for info in infos}
    return [
        info
        for info in infos
        if matches(
            info, filters, texts.get(info.capture_id, ()), measured.get(info.capture_id, NOTHING)
        )
    ]


@dataclass(frozen=True)
class CaptureTotals:
    """Numbers over all captures, which need none of their rows in memory."""

    captures: int
    generated: int
    seconds: float  # Their durations together
    performers: int
    captures_with_words: int


def load_totals(store: Store) -> CaptureTotals:
    """Count the captures."""
    ((captures, generated, seconds, performers, with_words),) = store.connection.execute(
        "SELECT count(*), count(*) FILTER (kind = 'generated'), coalesce(fsum(duration), 0.0), "
        "(SELECT count(DISTINCT value) FROM capture_tag WHERE key = 'performer'), "
        "(SELECT count(DISTINCT capture_id) FROM caption) FROM capture"
    ).fetchall()
    return CaptureTotals(captures, generated, seconds, performers, with_words)


def load_captured(store: Store) -> dict[int, str]:
    """Load number and name of captured motion of bodies, in order of number."""
    query = (
        "SELECT capture_id, name FROM capture WHERE kind = 'captured' AND leg_length > 0 "
        "ORDER BY capture_id"
    )
    return dict(store.connection.execute(query).fetchall())


def load_capture(store: Store, name: str, *, or_file: bool = False) -> CaptureInfo:
    """Load the capture of this name, or the only one in ``/name``; `or_file`: for the message."""
    return load_named(store, [name], or_file=or_file)[0]


def load_named(store: Store, names: Sequence[str], *, or_file: bool = False) -> list[CaptureInfo]:
    """Load the captures of some names as :func:`load_capture` does, in their order."""
    known = dict.fromkeys(store.connection.column("SELECT name FROM capture ORDER BY capture_id"))
    whole = [_whole_name(store, known, name, or_file) for name in names]
    rows = store.connection.execute(
        f"{_INFO} WHERE name IN (SELECT unnest($names))", {"names": whole}
    ).fetchall()
    tags = load_tags(store, [row[0] for row in rows])
    by_name = {row[1]: _to_info(row, tags.get(row[0], {})) for row in rows}
    return [by_name[name] for name in whole]


def _whole_name(store: Store, names: Mapping[str, None], name: str, or_file: bool) -> str:
    """The name of a capture that is given whole or without its folder."""
    if name in names:
        return name
    matching = [n for n in names if n.endswith(f"/{name}")]
    if len(matching) > 1:
        raise QueryError(
            f"{name!r}: expected one capture, found {len(matching)}: {', '.join(matching[:5])}"
            f"{', ...' if len(matching) > 5 else ''}. Give the whole name."
        )
    if not matching:
        if or_file and (kind := odd_kind(name)):
            raise QueryError(f"{name!r}: expected a file or the name of a capture, found {kind}.")
        near = suggestion(name, names) or suggestion(name, {n.rpartition("/")[2] for n in names})
        raise QueryError(
            f"{name!r}: expected {'a file or ' if or_file else ''}the name of a capture, found "
            f"{'no such file, and ' if or_file else ''}none in {store.path}."
            f"{near or ' motiondb list shows the names.'}"
        )
    return matching[0]


def load_digests(store: Store) -> dict[str, str]:
    """Load the digests of all captures."""
    return dict(store.connection.execute("SELECT sha256, name FROM capture").fetchall())


def load_motion(store: Store, capture_id: int, *, or_markers: bool = False) -> Motion:
    """Load the canonical motion of a capture, at 30 frames a second; 1 ms for 400 frames.

    `or_markers`: Give the standing body that is stored in place of the motion of markers, too.
    """
    row = store.connection.execute(
        "SELECT leg_length, motion_notes, name FROM capture WHERE capture_id = ?", [capture_id]
    ).fetchone()
    if row is None:
        raise QueryError(f"capture {capture_id}: expected a capture in {store.path}, found none.")
    if row[0] == 0.0 and not or_markers:
        raise QueryError(f"{row[2]}: {MARKERS_ONLY}")
    return unflatten_motion(load_poses(store, capture_id), row[0], tuple(row[1]))


_MOTIONS_AT_ONCE = 32  # Motions that are asked for together: one each took six times as long


def readable_motions(store: Store, numbers: Iterable[int]) -> Iterator[tuple[int, Motion]]:
    """Number and motion of the captures of some numbers, without those whose motion is damaged."""
    query = (
        "SELECT leg_length, motion_notes, motion.* FROM motion JOIN capture USING (capture_id) "
        "WHERE capture_id IN (SELECT unnest($1)) AND leg_length > 0"
    )
    left = iter(numbers)
    while some := list(islice(left, _MOTIONS_AT_ONCE)):
        rows = store.connection.execute(query, [some]).fetchall()
        found = {row[2]: row for row in rows}
        for number in some:
            with suppress(DamagedMotionError):
                if number not in found:  # which says why
                    yield number, load_motion(store, number)
                    continue
                leg_length, notes, _number, *stored = found.pop(number)
                poses = _unpacked(store, number, [stored])
                yield number, unflatten_motion(poses, leg_length, tuple(notes))


def has_body(store: Store, capture_id: int) -> bool:
    """Whether a capture is the motion of a body; else it is kept as markers."""
    query = "SELECT leg_length > 0 FROM capture WHERE capture_id = ?"
    return store.connection.column(query, [capture_id]) != [False]


def load_poses(store: Store, capture_id: int) -> Float32Array:
    """The poses of a capture: array (frames, 87); DamagedMotionError without, or with bad ones."""
    query = "SELECT * FROM motion WHERE capture_id = ?"  # a damaged older file has no poses_at
    rows = store.connection.execute(query, [capture_id]).fetchall()
    return _unpacked(store, capture_id, [row[1:] for row in rows])


def _unpacked(store: Store, capture_id: int, rows: Sequence[Sequence[Any]]) -> Float32Array:
    """As :func:`load_poses`, from what the table says of a capture, in one row."""
    try:
        ((n_frames, packed, *at),) = rows
        poses = unpack_poses(load_part(store, at[0]) if any(at) else packed)
        if len(poses) != n_frames:
            raise ValueError(f"{len(poses)} frames")
    except (ValueError, zlib.error) as error:
        query = "SELECT name FROM capture WHERE capture_id = ?"
        (name,) = store.connection.execute(query, [capture_id]).fetchone() or (capture_id,)
        reason = f"a motion (of the capture {name}) that cannot be unpacked ({error})."
        raise DamagedMotionError(damage_sentence(store.path, reason)) from error
    return poses


def flatten_motion(motion: Motion) -> Float32Array:
    """Root position and joints' quaternions of each frame in a row: array (frames, 87), float32."""
    rotations = motion.local_rotations.reshape(motion.n_frames, 4 * N_JOINTS)
    return np.concatenate([motion.root_positions, rotations], axis=1, dtype=np.float32)


def unflatten_motion(
    poses: Float32Array, leg_length: float = 0.8, notes: tuple[str, ...] = ()
) -> Motion:
    """Make a motion from poses (frames, 87), float32; the inverse of :func:`flatten_motion`.

    >>> motion = unflatten_motion(np.zeros((5, 87), dtype=np.float32))
    >>> motion.local_rotations.shape, motion.root_positions.shape
    ((5, 21, 4), (5, 3))
    """
    rotations = poses[:, 3:].reshape(len(poses), N_JOINTS, 4)
    return Motion(rotations, poses[:, :3], leg_length, notes)


def _to_info(row: tuple[Any, ...], tags: dict[str, str]) -> CaptureInfo:
    """A capture of a row of ``_INFO``, whose columns stand in the order of the record's fields."""
    *columns, notes = row
    values: list[Any] = [*columns, tags, tuple(notes)]
    return CaptureInfo(*values)


def _refuse_repeated(store: Store, captures: Sequence[NewCapture]) -> None:
    """Refuse a name or a content that is there already, or twice among the new captures."""
    query = (
        "SELECT name, sha256 FROM capture WHERE name IN (SELECT unnest($names)) "
        "OR sha256 IN (SELECT unnest($digests))"
    )
    names, digests = ([*each] for each in zip(*((c.info.name, c.source.sha256) for c in captures)))
    rows = store.connection.execute(query, {"names": names, "digests": digests}).fetchall()
    named, contents = dict(rows), {sha256: name for name, sha256 in rows}
    for name, sha256 in zip(names, digests):
        if name in named or sha256 in contents:
            is_same = sha256 in contents
            same = "this content under the name" if is_same else "another content under"
            raise StoreError(
                f"{name}: expected a capture that is new to {store.path}, found {same} "
                f"{contents[sha256] if is_same else name}. "
                "Remove that one first, or give this one another name."
            )
        named[name], contents[sha256] = sha256, name


def rename_captures(store: Store, names: Mapping[int, str]) -> None:
    """Rename captures by their numbers; a new name may be the old one of another."""
    for number in names:
        rename_capture(store, number, f"//{number}")
    for number, name in names.items():
        rename_capture(store, number, name)


POSE_SIZE = 87  # Numbers of a pose: root position x y z, then 21 quaternions w x y z
_W = np.arange(3, POSE_SIZE, 4)  # Columns of w
_OTHERS = np.delete(np.arange(POSE_SIZE), _W)
_MULTIPLES, _IMPLIED = b"\1", b"\2"  # First byte where integers are multiples; zlib has others
_ONE = round(1.0 / POSE_STEP)
_FEW = 5  # Level of memory: codes of 2,000 bytes fit these better than 16,000 do, by 2.6 %
_MOST = 2**31 - 1  # Largest integer that is kept


def pack_poses(poses: Float32Array) -> bytes:
    """Pack poses (frames, 87)."""
    columns = np.ascontiguousarray(poses.T, dtype="<f4")
    numbers, first = columns.view("<i4"), b""
    multiples = np.rint(columns.astype(np.float64) / POSE_STEP)
    signs = np.zeros((0, len(poses)), "<i4")
    # no number that is not finite, too
    if (np.abs(multiples) <= _MOST).all() and (np.abs(multiples[3:]) <= 8 * _ONE).all():
        whole = multiples.astype("<i4")
        if np.array_equal(_of_multiples(whole).view("<i4"), numbers):
            numbers, first, w = whole[_OTHERS], _IMPLIED, whole[_W]
            signs = 2 * (np.abs(w) - _implied(numbers)) + (w < 0)
    for _ in range(2):
        numbers = np.diff(numbers, axis=1, prepend=np.zeros((len(numbers), 1), "<i4"))
    numbers = np.concatenate([numbers, signs])
    turned = (numbers << 1) ^ (numbers >> 31)
    planes = turned.reshape(-1).view(np.uint8).reshape(-1, 4).T
    packing = zlib.compressobj(memLevel=_FEW, strategy=zlib.Z_RLE)
    return first + packing.compress(np.ascontiguousarray(planes).tobytes()) + packing.flush()


def _implied(others: NDArray[np.int32]) -> NDArray[np.int32]:
    """|w| of unit quaternions (21, frames) from the other columns (66, frames), in steps."""
    v = others[3:].reshape(len(_W), 3, -1).astype(np.int64)
    left = np.maximum(_ONE**2 - (v * v).sum(axis=1), 0)
    return np.rint(np.sqrt(left.astype(np.float64))).astype("<i4")


def _of_multiples(whole: NDArray[np.int32]) -> NDArray[np.float32]:
    """The numbers that are multiples of the step."""
    return (whole * POSE_STEP).astype("<f4")


def unpack_poses(packed: bytes) -> Float32Array:
    """Unpack poses (frames, 87); ValueError or zlib.error where the bytes are not packed poses.

    >>> poses = np.linspace(-1, 1, 3 * POSE_SIZE, dtype=np.float32).reshape(3, POSE_SIZE)
    >>> bool((unpack_poses(pack_poses(poses)) == poses).all())
    True
    """
    kind = packed[:1] if packed[:1] in (_MULTIPLES, _IMPLIED) else b""
    planes = np.frombuffer(zlib.decompress(packed[len(kind) :]), np.uint8).reshape(4, -1)
    turned = np.ascontiguousarray(planes.T).view("<u4").reshape(POSE_SIZE, -1)
    numbers = ((turned >> 1) ^ -(turned & 1).astype("<i4").view("<u4")).view("<i4")
    n_moving = len(_OTHERS) if kind == _IMPLIED else POSE_SIZE
    numbers, signs = numbers[:n_moving], numbers[n_moving:]
    for _ in range(2):
        numbers = np.cumsum(numbers, axis=1, dtype="<i4")
    if kind == _IMPLIED:
        others, numbers = numbers, np.empty((POSE_SIZE, numbers.shape[1]), "<i4")
        w = (signs >> 1) + _implied(others)
        numbers[_OTHERS], numbers[_W] = others, np.where(signs & 1, -w, w)
    columns = _of_multiples(numbers) if kind else numbers.view("<f4")
    return np.ascontiguousarray(columns.T).astype(np.float32, copy=False)
