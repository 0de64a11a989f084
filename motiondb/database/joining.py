"""``join``: parts of captures that a user chose, one after the other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, store
from motiondb.database.catalogue.exporting import MotionChanges, change_sequence
from motiondb.database.catalogue.parts import outside
from motiondb.database.generated_files import draw_generated, sources_of, write_with_provenance
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.generate.joining import Seam, join
from motiondb.generate.material import SequenceMotion
from motiondb.generate.stitching import Piece
from motiondb.records import MOTION_FPS, Motion
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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

    def write(self, path: str | Path, changes: MotionChanges | None = None) -> answers.WrittenJoin:
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
    session: Session, texts: Sequence[str], changes: MotionChanges | None = None
) -> Joined:
    """Join parts of captures, each ``CAPTURE:FROM-TO``."""
    if not texts:
        raise QueryError("join: expected at least 1 part such as walk:0.5-2, found none.")
    with session.reading():
        numbers: dict[int, int] = {}
        motions: list[Motion] = []
        pieces, parts = [], []
        for text in texts:
            name, start, end = _known(session, text)
            info = store.load_capture(session.store, name)
            place = numbers.setdefault(info.capture_id, len(numbers))
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
        made, seams, said = joined.made, list(joined.seams), tuple[str, ...]()
        if changes is not None and changes.of_motion.are_any:
            done = change_sequence(made, changes)
            parts, seams = _within(parts, joined.seams, done.first, done.made)
            made, said = done.made, done.said
        provenance = store.to_provenance(
            session.store, ids[made.captures], made.frames, edits=made.edits
        )
    return Joined(made.motion, provenance, tuple(parts), tuple(seams), said)


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
