"""Captures as a data set in the form of another program."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers, store
from motiondb.body.kinematics import clip_positions
from motiondb.database.catalogue.exporting import MotionChanges, changed
from motiondb.database.catalogue.parts import check_new_folder
from motiondb.files import humanml3d
from motiondb.files.rigs import own_rig
from motiondb.files.sheet_writer import write_table
from motiondb.files.whole_folders import whole_folder
from motiondb.generate.onto import onto
from motiondb.records import CaptureInfo, FloatArray

if TYPE_CHECKING:
    from motiondb.database.session import Session

_FEWEST = 3  # Frames of a capture


def write_humanml3d(
    session: Session, infos: Sequence[CaptureInfo], folder: Path
) -> answers.DataSet:
    """Write captures in the form of HumanML3D into a new folder, with a table of what they are."""
    check_new_folder(folder)  # before captures are converted
    rows, left_out = list[tuple[str, ...]](), list[str]()
    with session.reading(), whole_folder(folder, check_new_folder) as draft:
        written = humanml3d.write_set(draft, _converted(session, infos, rows, left_out))
        columns = ("id", "capture", "frames", "captions", "performer", "licence")
        write_table(draft / "captures.csv", columns, rows)
    named = {"folder": folder, "form": "humanml3d", "captures": written.motions}
    return answers.extended(answers.DataSet, written, **named, left_out=tuple(left_out))


def _converted(
    session: Session,
    infos: Sequence[CaptureInfo],
    rows: list[tuple[str, ...]],
    left_out: list[str],
) -> Iterator[tuple[str, FloatArray, str]]:
    """Convert captures, one after the other; `rows` of the table and what is left out grow."""
    rig = own_rig("smpl")
    captions = store.load_captions(session.store, [info.capture_id for info in infos])
    for info in infos:
        if not info.has_body or info.motion_frames < _FEWEST:
            why = "it is too short" if info.has_body else "it has no body"
            left_out.append(f"{info.name} is left out: {why}.")
            continue
        motion = store.load_motion(session.store, info.capture_id)
        clip = changed(onto(motion, rig, {}).clip, MotionChanges(fps=humanml3d.FPS)).clip
        numbers = humanml3d.motion_numbers(clip_positions(clip)[0])
        text = humanml3d.text_lines(captions.get(info.capture_id, ()), info.duration)
        tags = (info.tags.get("performer", ""), info.tags.get("licence", ""))
        counts = str(len(numbers)), str(text.count("\n"))
        rows.append((f"{len(rows):06d}", info.name, *counts, *tags))
        yield rows[-1][0], numbers, text
