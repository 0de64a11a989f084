"""Provenance of generated captures: the source and the licence of every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.errors import QueryError
from motiondb.records import FloatArray, IntArray
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


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
