"""Keeping generated motion as a capture: marked, with the origin of every frame."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from motiondb import capture, store
from motiondb.errors import QueryError
from motiondb.pose import retarget
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, Motion


def keep_generated(
    database: store.Store,
    name: str,
    motion: Motion,
    provenance: store.Provenance,
    captions: Iterable[Caption],
    run_id: int,
) -> CaptureInfo:
    """Save a generated motion as a BVH capture; its licence names those of all sources."""
    clip = retarget.to_clip(motion)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{name.replace('/', '_')}.bvh"
        capture.write_bvh(clip, file)
        source = store.pack_source(file.name, file.read_bytes(), "bvh")
    licences = "; ".join(sorted({s.licence for s in provenance.sources if s.licence}))
    info = CaptureInfo(
        0, name, "", "bvh", "generated", MOTION_FPS, clip.n_frames, clip.duration, 0, 0.0, "",
        run_id, {"licence": licences} if licences else {},
    )  # fmt: skip
    with store.transaction(database):
        info = store.save_capture(database, info, motion, source, captions)
        store.save_provenance(database, info.capture_id, provenance)
    return info


def check_name_free(database: store.Store, name: str) -> None:
    """Refuse no name, or one that a capture has already (QueryError, says what to do)."""
    if not name.strip():
        raise QueryError("name: expected a name for the capture, found nothing. Give one.")
    if any(info.name == name for info in store.load_captures(database)):
        raise QueryError(
            f"{name}: expected a name that is free, found a capture of that name. Remove that "
            f"one first (motiondb remove {name}), or give another name."
        )
