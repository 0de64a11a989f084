"""Keeping generated motion as a capture: marked, with the origin of every frame."""

from __future__ import annotations

from collections.abc import Iterable

from motiondb import files as capture
from motiondb import store
from motiondb.body import retarget
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, Motion


def keep_generated(
    opened: store.Store,
    name: str,
    motion: Motion,
    provenance: store.Provenance,
    captions: Iterable[Caption],
    run_id: int,
) -> CaptureInfo:
    """Save a generated motion as a BVH capture; its licence names those of all sources."""
    store.check_new_name(name, "capture")
    clip = retarget.to_clip(motion)
    file = f"{name.replace('/', '_')}.bvh"
    source = store.pack_source(file, capture.to_bvh(clip, file).encode(), "bvh")
    licences = "; ".join(sorted({s.licence for s in provenance.sources if s.licence}))
    info = CaptureInfo(
        0,
        name,
        "",
        "bvh",
        "generated",
        MOTION_FPS,
        clip.n_frames,
        clip.duration,
        0,
        0.0,
        "",
        run_id,
        {"licence": licences} if licences else {},
    )
    with store.transaction(opened):
        info = store.save_capture(opened, info, motion, source, captions)
        store.save_provenance(opened, info.capture_id, provenance)
    return info
