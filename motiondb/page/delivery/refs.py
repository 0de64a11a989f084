"""Refs: names by which the browser requests anything that can be played.

``capture:NAME`` is a stored capture, ``upload:ID/FILE`` an uploaded file, ``made:ID`` a motion
generated from a sentence, ``sequence:ID`` one from a grammar, ``scene:ID`` a scene that was made,
``kept:NAME`` a scene in the database. ``first:ID`` is the first motion of a scene that is being
updated.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.database.catalogue.parts import cut_motion
from motiondb.page.answers import PageError, unknown
from motiondb.page.session.state import Page
from motiondb.records import Motion

KINDS = ("capture", "upload", "made", "sequence", "scene", "first", "kept")


@dataclass(frozen=True)
class Ref:
    """A ref in its parts."""

    kind: str
    name: str

    def __str__(self) -> str:
        """Return the ref as text."""
        return f"{self.kind}:{self.name}"


def read_ref(text: str) -> Ref:
    """Return the parts of a ref."""
    kind, colon, name = text.partition(":")
    if not colon or kind not in KINDS or not name:
        raise PageError(
            f"ref: expected one of {', '.join(f'{k}:NAME' for k in KINDS)}, found {text[:100]!r}."
        )
    return Ref(kind, name)


def find_capture(db: MotionDB, name: str) -> str:
    """Return the name of a stored capture."""
    if db.browsed(name) is None:
        raise unknown("capture", name, "It may have been removed or renamed.")
    return name


def load_motion(
    page: Page, db: MotionDB, ref: Ref, start: float | None = None, end: float | None = None
) -> Motion:
    """Return the motion of a ref, or the part of it from start to end (seconds)."""
    if ref.kind == "capture":
        return db.motion(find_capture(db, ref.name), start, end)
    if ref.kind == "upload":
        upload_id, _, file = ref.name.partition("/")
        return db.motion(page.uploads.get(upload_id).path(file), start, end)
    if ref.kind == "made":
        return cut_motion(page.made.get(ref.name).generated.motion, start, end, FEATURE_STEP)
    if ref.kind == "sequence":
        return cut_motion(page.sequences.get(ref.name).sequence.motion, start, end, FEATURE_STEP)
    raise PageError(f"{ref}: expected one motion, found a scene with several. Name a capture.")
