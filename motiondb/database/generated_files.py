"""Generated motion with the origin of every frame: written to files, kept as a capture."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from motiondb import answers, pictures, store
from motiondb.body.retarget import to_clip
from motiondb.database.catalogue.exporting import (
    MotionChanges,
    check_changes,
    check_joint_map,
    unit_in,
    write_motion,
)
from motiondb.database.catalogue.parts import write_bytes
from motiondb.files import packed_files
from motiondb.files.bvh_writer import to_bvh
from motiondb.files.own_files import WRITER, check_overwriting, digest_of, provenance_path
from motiondb.records import MOTION_FPS, BoolArray, Caption, CaptureInfo, Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Made(Protocol):
    """Any generated motion with the origin of its frames."""

    @property
    def motion(self) -> Motion:
        """The motion."""

    @property
    def provenance(self) -> store.Provenance:
        """The origin of every frame."""


def write_with_provenance(
    made: Made,
    facts: object,
    path: Path,
    changes: MotionChanges | None = None,
    said: Sequence[str] = (),
) -> dict[str, Any]:
    """Write a motion, and beside it ``FILE.provenance.json``; the names of both files.

    `said`: How the motion was changed already.
    """
    asked = changes or MotionChanges()
    check_joint_map(asked, uses_names=False)
    check_changes(asked, path)
    told = answers.to_json(facts).items()
    kept = {k: v for k, v in told if k != "question" and (k != "words_from" or v)}
    beside = provenance_path(path)
    check_overwriting(beside)
    done = write_motion(made.motion, path, asked)
    said = (*said, *done.said)
    written: dict[str, object] = {"written_by": WRITER, "sha256": digest_of(path)}
    if said or asked.are_any:
        unit = unit_in(path, done.clip)
        written |= {"changes": said, "fps": done.clip.fps, "unit": unit}
    runs = {"frames": frame_runs(made, done.clip.fps / asked.speed)}
    write_bytes(beside, json.dumps({**written, **kept, **runs}, indent=1).encode())
    return {"output": str(path), "provenance": str(beside), "changes": said, "fit": done.fit}


def draw_generated(made: Made, title: str, path: str | Path | None = None) -> Path | Figure:
    """Draw a strip of stick figures over the sources of the frames, as PNG."""
    timeline = pictures.Timeline("sources", source_spans(made))
    return pictures.save_png(pictures.strip_figure(made.motion, title, [timeline]), path)


def sources_of(provenance: store.Provenance) -> tuple[answers.Source, ...]:
    """The captures that frames come from, with licence, digest and number of frames."""
    return tuple(
        answers.Source(
            s.name, s.licence or "unknown", s.sha256, int((provenance.source_numbers == n).sum())
        )
        for n, s in enumerate(provenance.sources)
    )


def frame_runs(made: Made, fps: float = MOTION_FPS) -> list[dict[str, Any]]:
    """Runs of frames of a file that follow one another in one source.

    Each has its frames [start, end) at the rate of the file, the first frame in the source at 30 a
    second, the step from frame to frame there (1 as recorded, 2 at twice the tempo, where the file
    has 30 a second, too), and what was done.
    """
    provenance = made.provenance
    steps = np.diff(provenance.source_frames)
    same = np.diff(provenance.source_numbers) == 0
    same &= np.array(
        [a == b for a, b in zip(provenance.edits[:-1], provenance.edits[1:])], dtype=bool
    )
    runs: list[tuple[int, int, float]] = []
    start, n_frames = 0, len(provenance.source_frames)
    while start < n_frames:
        step = _step(provenance.edits[start])
        end = start + 1
        while end < n_frames and same[end - 1] and abs(steps[end - 1] - step) < 1e-6:
            end += 1
        runs.append((start, end, step))
        start = end
    share = MOTION_FPS / fps  # Frames of the motion from one frame of the file to the next
    told, count = [], max(1, round(n_frames / share))
    for a, b, step in runs:
        first, behind = math.ceil(a / share - 1e-9), min(math.ceil(b / share - 1e-9), count)
        if first >= behind:  # a frame that a file of a lower rate leaves out
            continue
        number = int(provenance.source_numbers[a])
        source = float(provenance.source_frames[a]) + step * (first * share - a)
        told.append(
            {
                "start": first,
                "end": behind,
                "capture": provenance.sources[number].name if number >= 0 else None,
                "source_start": round(source, 6),
                "source_step": round(step * share, 6),
                "edit": provenance.edits[a],
            }
        )
    return told


def _step(edit: str) -> float:
    """Frames of the source from one frame to the next, from what was done.

    >>> _step("speed 1.250, foot lock"), _step("foot lock")
    (1.25, 1.0)
    """
    rates = [part for part in edit.split(", ") if part.startswith("speed ")]
    return float(rates[0].removeprefix("speed ")) if rates else 1.0


def source_spans(made: Made) -> list[tuple[float, float, str, str]]:
    """Spans (seconds) of the sources, for a timeline."""
    numbers = made.provenance.source_numbers
    names = [s.name for s in made.provenance.sources]
    spans = []
    for a, b in runs_between(np.diff(numbers) != 0):
        name = names[numbers[a]] if numbers[a] >= 0 else "model"
        spans.append((a / MOTION_FPS, b / MOTION_FPS, name, name))
    return spans


def runs_between(breaks: BoolArray) -> list[tuple[int, int]]:
    """Runs [start, end) of frames; `breaks` (frames - 1,) says where another one begins."""
    return list(pairwise([0, *(np.flatnonzero(breaks) + 1).tolist(), len(breaks) + 1]))


def leaves_out(provenance: store.Provenance) -> BoolArray:
    """Whether a capture ends or frames of it are left out between two frames: (frames - 1,)."""
    changed = np.diff(provenance.source_numbers) != 0
    return np.asarray(changed | (np.abs(np.diff(provenance.source_frames)) > _LEFT_OUT))


def edits_in(provenance: store.Provenance, start: int, end: int) -> list[str]:
    """What was done to frames [start, end), each once."""
    said = (part for edit in provenance.edits[start:end] for part in edit.split(", "))
    return sorted({"blend" if part.startswith("blend") else part for part in said if part})


_LEFT_OUT = 2.0
"""Frames of a capture between two frames of a motion, above which some were left out."""


@dataclass(frozen=True)
class Stretch:
    """Frames of a motion that follow one another in one capture."""

    start: float  # Seconds of the motion
    end: float  # Seconds of the motion
    capture: str  # Name of the capture; "" where the frames were drawn from the model
    source_start: float  # Seconds of the capture
    licence: str  # Licence of the capture, "unknown" where none is given
    edits: tuple[str, ...]  # What was done to the frames


def stretches(provenance: store.Provenance) -> tuple[Stretch, ...]:
    """Return the stretches of a motion, from the origin of its frames."""
    numbers, frames = provenance.source_numbers, provenance.source_frames
    if not len(numbers):
        return ()
    runs = []
    for start, end in runs_between(leaves_out(provenance)):
        source = provenance.sources[number] if (number := int(numbers[start])) >= 0 else None
        runs.append(
            Stretch(
                round(start / MOTION_FPS, 3),
                round(end / MOTION_FPS, 3),
                source.name if source else "",
                round(float(frames[start]) / MOTION_FPS, 3) if source else 0.0,
                (source.licence if source else "") or "unknown",
                tuple(edits_in(provenance, start, end)),
            )
        )
    return tuple(runs)


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
    clip = to_clip(motion)
    file = f"{name.replace('/', '_')}.bvh"
    source = packed_files.pack_source(file, to_bvh(clip, file).encode(), "bvh")
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
