"""Parts of motions and clips, and files that are written as a whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import store
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.gltf_writer import write_gltf
from motiondb.files.safe_files import check_output, is_file
from motiondb.records import MOTION_FPS, Clip, Motion

if TYPE_CHECKING:
    from motiondb.database.values import Example


def cut_motion(motion: Motion, start: float | None, end: float | None, step: int = 1) -> Motion:
    """The part of a motion from start to end (seconds), from the nearest ``step``-th frame on.

    An example begins at a frame that features are taken of (``FEATURE_STEP``), as the same part of
    a stored capture does, so that it finds itself.
    """
    if start is None and end is None:
        return motion
    _check_finite(motion.n_frames / MOTION_FPS, start, end)
    low = round((start or 0.0) * MOTION_FPS / step) * step
    high = motion.n_frames if end is None else min(round(end * MOTION_FPS), motion.n_frames)
    if not 0 <= low < high:
        raise QueryError(outside(motion.n_frames / MOTION_FPS, start, end))
    return motion[low:high]


def cut_clip(clip: Clip, start: float | None, end: float | None) -> Clip:
    """The part of a clip from start to end, seconds; the end may be half a second behind its."""
    _check_finite(clip.duration, start, end)
    low = round((start or 0.0) * clip.fps)
    high = clip.n_frames if end is None else min(round(end * clip.fps), clip.n_frames)
    if not 0 <= low < high or (end or 0.0) > clip.duration + 0.5:
        raise QueryError(outside(clip.duration, start, end))
    return clip[low:high]


def _check_finite(duration: float, start: float | None, end: float | None) -> None:
    if not np.isfinite([start or 0.0, end or 0.0]).all():
        raise QueryError(outside(duration, start, end))


def outside(duration: float, start: float | None, end: float | None) -> str:
    """The sentence for an interval (seconds) that does not lie within 0 to ``duration``."""
    until = "the end" if end is None else f"{end:g}"
    is_reversed = end is not None and end <= (start or 0.0)
    return (
        f"expected an interval within 0 to {duration:.2f} s, found {start or 0:g} to {until}. "
        f"Times are seconds{', and the end comes after the start' if is_reversed else ''}."
    )


ENDINGS = (".bvh", ".fbx", ".glb", ".gltf", ".usd", ".usda", ".usdc")
"""Endings of files that motion is written to."""


def check_motion_file(path: Path, others: Sequence[str] = ()) -> None:
    """Check that motion can be written to a file of this name, before it is made.

    Parameters
    ----------
    path : Path
        The file; its ending says the format.
    others : sequence of str
        Further endings that are written, which a message names.

    Raises
    ------
    QueryError
        When the ending is another one.
    CaptureError
        When the format needs Blender or a package that is not installed.
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        *most, last = (*ENDINGS, *others)
        raise QueryError(
            f"{path}: expected an ending {', '.join(most)} or {last}, found {ending or 'none'!r}."
        )
    if ending == ".fbx":
        from motiondb.files.fbx_writer import check_blender

        check_blender(path)
    elif ending.startswith(".usd"):
        from motiondb.files.usd_writer import check_usd

        check_usd(path)


def write_clip(
    clip: Clip, path: Path, owner: str = "", reduce_keys: float = 0.0
) -> tuple[str, ...]:
    """Write a clip in the format that the ending says; return what the file has otherwise.

    `owner`: written where the format has a place for it.
    """
    check_motion_file(path)
    ending = path.suffix.lower()
    if ending == ".bvh":
        write_bvh(clip, path)
    elif ending == ".fbx":
        from motiondb.files.fbx_writer import write_fbx

        return write_fbx(clip, path)
    elif ending.startswith(".usd"):
        from motiondb.files.usd_writer import write_usd

        write_usd(clip, path)
    else:
        return write_gltf(clip, path, owner, reduce_keys)
    return ()


def load_example(
    session: Session, example: Example, start: float | None = None, end: float | None = None
) -> Motion:
    """A file, a stored capture or a motion, or a part of it, on the canonical body."""
    from motiondb.body.features import FEATURE_STEP
    from motiondb.body.retarget import to_motion
    from motiondb.files.formats import read_capture, split_take

    if isinstance(example, Motion):
        motion = example
    elif isinstance(example, Clip):
        motion = to_motion(example)
    elif is_file(split_take(example)[0]):
        clip = read_capture(example)
        motion = to_motion(clip)
        motion = replace(motion, notes=clip.notes + motion.notes)
    else:
        with session.reading():
            info = store.load_capture(session.store, str(example), or_file=True)
            motion = store.load_motion(session.store, info.capture_id)
    return cut_motion(motion, start, end, FEATURE_STEP)


def check_new_folder(folder: Path) -> None:
    """Refuse a folder that holds something, or cannot be made."""
    try:
        check_output(folder, is_folder=True)
        held = sum(1 for _ in folder.iterdir()) if folder.exists() else 0
        if held:
            raise QueryError(f"{folder}: expected a new or an empty folder, found {held} in it.")
        if not folder.absolute().parent.is_dir():
            raise QueryError(f"{folder}: expected a folder in one that exists, found none there.")
    except OSError as error:
        raise QueryError(f"{folder}: expected a folder, found: {error.strerror}.") from None
