"""Save the readable parts of a damaged database into a new one.

Lost parts of a capture are restored from its other parts if possible: a motion by reading the
stored file again, a file by writing the motion as BVH. The learned model is not copied: learn
again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from motiondb import store
from motiondb.body import retarget
from motiondb.database.catalogue.exporting import joint_map_of
from motiondb.database.catalogue.file_reading import read_source, stored_options
from motiondb.errors import MotionDBError, StoreError
from motiondb.files import packed_files
from motiondb.files.bvh_writer import to_bvh
from motiondb.files.safe_files import check_file_name, log_of, output_file, sweep_databases
from motiondb.records import MOTION_FPS, CaptureInfo, Motion, Run


@dataclass(frozen=True)
class RescueReport:
    """The captures that a rescue saved, and those that it could not."""

    output: Path
    captures: tuple[str, ...]  # Names of the captures that were saved, whole or in part
    mended: tuple[str, ...]  # A sentence for every capture of which a part was lost or restored
    lost: tuple[str, ...]  # A sentence for everything that is not in the new database
    was_learned: bool  # Whether the database had learned, or may have. Learned data are not rescued


def rescue(path: str | Path, output: str | Path, *, wait: float = 0.0) -> RescueReport:
    """Save every readable capture of a database into a new file.

    The damaged file is only read. The new one gets its name when it is complete.

    Parameters
    ----------
    path : str or Path
        The damaged database.
    output : str or Path
        The new database; there must be no file of this name.
    wait : float
        Seconds to wait for another process that holds the damaged file.

    Raises
    ------
    StoreError
        Nothing of the file can be read, a Parquet file with motions of it is missing, or the output
        is there already.
    """
    path, output = Path(path), Path(output)
    check_file_name(path)
    check_file_name(output)
    if not output.parent.is_dir():
        raise StoreError(
            f"{output}: expected the folder {output.parent}, found none. Make the folder first."
        )
    if output.exists():
        raise StoreError(
            f"{output}: expected the name of a new file, found a file of that name. "
            "Give another name with -o."
        )
    draft = output
    sweep_databases(output.parent)
    with store.opened_damaged(path, wait=wait) as (damaged, lost):
        store.check_places(damaged)  # else captures that are whole would be called unreadable
        try:
            with output_file(output, StoreError) as draft:
                with store.open_store(draft) as new:
                    report = _save_all(damaged, new, output, lost)
                if log_of(draft).exists():  # not in the file, which would lack it under its name
                    raise StoreError(
                        f"{output}: expected room for a new database, found too little. "
                        "Nothing was written; look at the disk."
                    )
                if output.exists():
                    raise StoreError(
                        f"{output}: expected the name of a new file, found one that was made "
                        "meanwhile. Give another name with -o."
                    )
        except StoreError as error:  # the draft's name would tell nobody anything
            raise StoreError(str(error).replace(str(draft), str(output))) from error
    return report


def _save_all(
    damaged: store.Store, new: store.Store, output: Path, lost: list[str]
) -> RescueReport:
    """Copy capture by capture, then the data that belong to several captures."""
    runs = {run.run_id: run for run in store.salvage_runs(damaged)}
    names: list[str] = []
    mended: list[str] = []
    lost = list(lost)
    with store.transaction(new):
        store.save_runs(new, runs.values())
        run_id = store.start_run(new, "rescue", {"from": str(damaged.path)})
        for salvaged in store.salvage_captures(damaged):
            name = _free_name(salvaged.info.name, names)
            info = replace(
                salvaged.info,
                name=name,
                run_id=salvaged.info.run_id if salvaged.info.run_id in runs else run_id,
            )
            salvaged = replace(salvaged, info=info)
            try:
                note = _save_capture(new, salvaged, runs.get(info.run_id))
            except MotionDBError as error:
                what = ", ".join(salvaged.lost) or "nothing"
                lost.append(f"{name}: could not be read ({what}) or restored: {error}")
                continue
            names.append(name)
            if note:
                mended.append(f"{name}: {note}")
        lost += store.copy_shared(damaged, new, run_id)
        store.finish_run(new, run_id)
    if not names:
        lost.append(f"{damaged.path}: no capture could be read.")
    was_learned = store.was_learned(damaged)
    return RescueReport(output, tuple(names), tuple(mended), tuple(lost), was_learned)


def _save_capture(new: store.Store, salvaged: store.SalvagedCapture, run: Run | None) -> str:
    """Save a capture with its missing parts restored; return what was restored."""
    info, source, motion = salvaged.info, salvaged.source, salvaged.motion
    notes = [f"could not read {', '.join(salvaged.lost)}"] if salvaged.lost else []
    if motion is None and (source is None or not source.data):
        raise StoreError("expected its file or its motion, found neither.")
    if source is None:
        assert motion is not None
        info, packed = _written_anew(info, motion)
        notes.append("its file is now its motion on the canonical body, as BVH")
    elif not source.data and motion is not None:  # it was left out
        packed = source
    else:
        if motion is None:
            info, motion = _read_anew(info, source, run)
            notes.append("its motion was read from its file again")
        packed = packed_files.pack_source(
            source.own_name,
            source.data,
            source.format,
            source.skeleton_name,
            source.skeleton_data,
            source.take,
        )
    duration = max(info.duration, motion.n_frames / MOTION_FPS)
    captions = [c for c in salvaged.captions if c.start is None or c.start < duration]
    events = [event for event in salvaged.events if 0 <= event.frame < motion.n_frames]
    saved = store.save_capture(new, info, motion, packed, captions)
    store.save_events(new, saved.capture_id, events)
    if salvaged.provenance is not None:
        store.save_provenance(new, saved.capture_id, salvaged.provenance)
    return "; ".join(notes)


def _read_anew(
    info: CaptureInfo, source: packed_files.Source, run: Run | None
) -> tuple[CaptureInfo, Motion]:
    """The motion of a stored file, read as it was when it was added."""
    parameters = run.parameters if run else {}
    options = stored_options(info, source, parameters, info.fps if info.n_frames else None)
    clip = read_source(info.name, source, options)
    facts = replace(info, fps=clip.fps, n_frames=clip.n_frames, duration=clip.n_frames / clip.fps)
    return facts, retarget.to_motion(clip, joint_map_of(parameters))


def _written_anew(info: CaptureInfo, motion: Motion) -> tuple[CaptureInfo, packed_files.Source]:
    """A file for a motion whose file was lost."""
    clip = retarget.to_clip(motion)
    file = f"{info.name.replace('/', '_')}.bvh"
    packed = packed_files.pack_source(file, to_bvh(clip, file).encode(), "bvh")
    notes = (*info.notes, "the file was lost; this is the canonical motion, rescued")
    info = replace(info, format="bvh", notes=notes, duration=clip.duration)
    return replace(info, fps=clip.fps, n_frames=clip.n_frames), packed


def _free_name(name: str, taken: list[str]) -> str:
    """The name, with a number behind it where another capture has it."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name} ({number})"
    return free
