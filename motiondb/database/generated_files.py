"""Motion made of captures, with the origin of every frame: joined, written, kept as a capture."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from motiondb import answers, pictures, store
from motiondb.body.retarget import to_clip
from motiondb.database.catalogue import exporting
from motiondb.database.catalogue.parts import outside
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.files import packed_files
from motiondb.files.bvh_writer import to_bvh
from motiondb.files.own_files import WRITER, check_overwriting, digest_of, provenance_path
from motiondb.files.safe_files import write_bytes
from motiondb.generate.material import SequenceMotion
from motiondb.records import MOTION_FPS, BoolArray, Caption, CaptureInfo, Motion
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motiondb.generate.joining import Seam


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
    changes: exporting.MotionChanges | None = None,
    said: Sequence[str] = (),
) -> dict[str, Any]:
    """Write a motion, and beside it ``FILE.provenance.json``; the names of both files.

    `said`: How the motion was changed already.
    """
    asked = changes or exporting.MotionChanges()
    exporting.check_joint_map(asked, uses_names=False)
    exporting.check_changes(asked, path)
    told = answers.to_json(facts).items()
    kept = {k: v for k, v in told if k != "question" and (k != "words_from" or v)}
    beside = provenance_path(path)
    check_overwriting(beside)
    owner = "; ".join(
        f"{source.name}, licence {source.licence or 'not known'}"
        for source in made.provenance.sources
    )
    done = exporting.write_motion(made.motion, path, asked, owner)
    said = (*said, *done.said)
    written: dict[str, object] = {"written_by": WRITER, "sha256": digest_of(path)}
    if said or asked.are_any:
        unit = exporting.unit_in(path, done.clip)
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
    steps = np.array([_step(edit) for edit in provenance.edits])
    same = np.diff(provenance.source_numbers) == 0
    same &= np.array([a == b for a, b in pairwise(provenance.edits)], dtype=bool)
    same &= np.abs(np.diff(provenance.source_frames) - steps[:-1]) < 1e-6
    share = MOTION_FPS / fps  # Frames of the motion from one frame of the file to the next
    told, count = [], max(1, round(len(steps) / share))
    for a, b in runs_between(~same):
        first, behind = math.ceil(a / share - 1e-9), min(math.ceil(b / share - 1e-9), count)
        if first >= behind:  # a frame that a file of a lower rate leaves out
            continue
        number = int(provenance.source_numbers[a])
        step = float(steps[a])
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


_PART = re.compile(r"(.+):(\d*\.?\d*)-(\d*\.?\d*)")


@dataclass(frozen=True, eq=False, repr=False)
class Joined(Tabled):
    """A motion of parts of captures."""

    motion: Motion
    """On the canonical body, at 30 frames a second."""
    provenance: store.Provenance
    """Origin and licence of every frame."""
    parts: tuple[answers.JoinedPart, ...]
    """The parts, in order, as far as they are in the motion."""
    seams: tuple[Seam, ...]
    """How far the parts were apart where they meet, as far as they meet in the motion."""
    changed: tuple[str, ...] = ()
    """How the motion was changed after the parts were joined."""

    def _rows(self) -> tuple[str, list[dict[str, object]]]:
        return f"{self.motion.duration:.2f} s of {len(self.parts)} parts", [
            vars(part) for part in self.parts
        ]

    def facts(self) -> answers.JoinedAnswer:
        """The parts, the seams and the sources, for JSON; times in seconds."""
        seconds = round(self.motion.n_frames / MOTION_FPS, 3)
        sources = sources_of(self.provenance)
        return answers.extended(answers.JoinedAnswer, self, seconds=seconds, sources=sources)

    def write(
        self, path: str | Path, changes: exporting.MotionChanges | None = None
    ) -> answers.WrittenJoin:
        """Write the motion, and beside it ``FILE.provenance.json`` with the origin of its frames.

        Parameters
        ----------
        path : str or Path
            The ending says the format, such as .bvh or .glb.
        changes : MotionChanges, optional
            How the file differs: its unit, frame rate and rig.
        """
        facts = self.facts()
        written = write_with_provenance(self, facts, Path(path), changes, self.changed)
        return answers.extended(answers.WrittenJoin, facts, **written)

    def draw(self, path: str | Path | None = None) -> Path | Figure:
        """Draw a strip of stick figures over the sources of the frames, as PNG."""
        return draw_generated(self, " + ".join(part.capture for part in self.parts), path)


def read_part(text: str) -> tuple[str, float | None, float | None]:
    """Read ``CAPTURE:FROM-TO`` (seconds); either time may be missing, and so may both.

    >>> read_part("16/16_15:0.5-2"), read_part("walk:1-"), read_part("walk")
    (('16/16_15', 0.5, 2.0), ('walk', 1.0, None), ('walk', None, None))
    """
    found = _PART.fullmatch(text.strip())
    if found is None:
        return text.strip(), None, None
    name, *times = found.groups()
    try:
        start, end = (float(time) if time else None for time in times)
    except ValueError:
        raise QueryError(
            f"{text!r}: expected CAPTURE:FROM-TO in seconds, such as walk:0.5-2, found other text."
        ) from None
    return name, start, end


def join_parts(
    session: Session, texts: Sequence[str], changes: exporting.MotionChanges | None = None
) -> Joined:
    """Join parts of captures, each ``CAPTURE:FROM-TO``."""
    from motiondb.generate.joining import join
    from motiondb.generate.stitching import Piece

    if not texts:
        raise QueryError("join: expected at least 1 part such as walk:0.5-2, found none.")
    with session.reading():
        numbers: dict[int, int] = {}
        motions: list[Motion] = []
        pieces, parts, rates = [], [], set[float]()
        for text in texts:
            name, start, end = _known(session, text)
            info = store.load_capture(session.store, name)
            place = numbers.setdefault(info.capture_id, len(numbers))
            rates.add(info.fps)
            if place == len(motions):
                motions.append(store.load_motion(session.store, info.capture_id))
            count = motions[place].n_frames
            first = round((start or 0.0) * MOTION_FPS)
            behind = count if end is None else min(round(end * MOTION_FPS), count)
            if not 0 <= first < behind:
                raise QueryError(f"{info.name}: {outside(count / MOTION_FPS, start, end)}")
            pieces.append(Piece(place, first, behind))
            parts.append(answers.JoinedPart(info.name, first / MOTION_FPS, behind / MOTION_FPS))
        joined = join(motions, pieces)
        ids = np.array(list(numbers))
        made, seams, said = joined.made, list(joined.seams), _say_rates(rates)
        if changes is not None and changes.of_motion.are_any:
            done = exporting.change_sequence(made, changes)
            parts, seams = _within(parts, joined.seams, done.first, done.made)
            made, said = done.made, (*said, *done.said)
        provenance = store.to_provenance(
            session.store, ids[made.captures], made.frames, edits=made.edits
        )
    return Joined(made.motion, provenance, tuple(parts), tuple(seams), said)


def _say_rates(rates: set[float]) -> tuple[str, ...]:
    """That captures of other rates were joined at that of motions.

    >>> _say_rates({30.0}), _say_rates({120.0, 60.0})
    ((), ('joined at 30 frames a second, of captures at 60 and 120',))
    """
    others = " and ".join(f"{rate:g}" for rate in sorted(rates))
    if rates <= {MOTION_FPS}:
        return ()
    return (f"joined at {MOTION_FPS:g} frames a second, of captures at {others}",)


def _within(
    parts: Sequence[answers.JoinedPart], seams: Sequence[Seam], first: int, made: SequenceMotion
) -> tuple[list[answers.JoinedPart], list[Seam]]:
    """Return the parts and seams that a motion still has which begins at a frame of the whole."""
    kept: list[answers.JoinedPart] = []
    behind = 0  # Frame of the whole at which a part ends
    for part, count in zip(parts, made.lengths, strict=True):
        start, end = round(part.start * MOTION_FPS), round(part.end * MOTION_FPS)
        if count:
            begin = start + max(first - behind, 0)
            kept.append(
                answers.JoinedPart(part.capture, begin / MOTION_FPS, (begin + count) / MOTION_FPS)
            )
        behind += end - start
    places = [round(seam.seconds * MOTION_FPS) - first for seam in seams]
    return kept, [
        replace(seam, seconds=round(place / MOTION_FPS, 3))
        for seam, place in zip(seams, places)
        if 0 < place < made.motion.n_frames
    ]


def _known(session: Session, text: str) -> tuple[str, float | None, float | None]:
    """Read a part; the whole text may also be the name of a capture."""
    name, start, end = read_part(text)
    names = {info.name for info in store.load_captures(session.store)}
    if text in names:
        return text, None, None
    if ":" in text and start is None and end is None and name not in names:
        raise QueryError(
            f"{text!r}: expected CAPTURE:FROM-TO in seconds, such as walk:0.5-2, found other text."
        )
    return name, start, end
