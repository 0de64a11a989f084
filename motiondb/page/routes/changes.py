"""Routes that change several captures at once, and undo."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter
from pydantic import Field

from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.refs import find_row
from motiondb.page.routes.parameters import Body, Text
from motiondb.page.state import Edit, Page
from motiondb.store import transaction

MOST_CHANGED = 10_000  # Largest number of captures of one change
Names = Annotated[list[Text], Field(min_length=1, max_length=MOST_CHANGED)]


class CapturesBody(Body):
    """Several captures."""

    captures: Names


class CaptureTagsBody(CapturesBody):
    """Tags for several captures; an empty value removes the tag."""

    tags: dict[Text, Text]


class CaptureWordsBody(CapturesBody):
    """A caption that is added to each of several captures."""

    words: Annotated[str, Field(min_length=1, max_length=2000)]


class RenameBody(Body):
    """A capture, a folder ending in "/", or a pattern with "*", and the new one.

    `captures`: Those among which a pattern looks; by default all.
    """

    old: Text
    new: Annotated[str, Field(min_length=1, max_length=500)]
    captures: Names | None = None


@dataclass(frozen=True)
class CapturesChanged:
    """Captures that were changed, and the number of edits that can be undone."""

    changed: tuple[str, ...]
    undo: int


def router(page: Page) -> APIRouter:
    """Return the routes of changes of several captures."""
    routes = APIRouter(tags=["catalogue"], responses=ERRORS)

    @routes.post("/api/captures/tags")
    def set_tags(body: CaptureTagsBody) -> CapturesChanged:
        """Set tags, such as performer and licence, of several captures."""
        with page.changing() as db:
            names = _known(db, body.captures)
            return _noted(page, db, "tags", lambda: db.captures.set_tags(body.tags, names))

    @routes.post("/api/captures/words")
    def add_words(body: CaptureWordsBody) -> CapturesChanged:
        """Add a caption to each of several captures."""
        with page.changing() as db:
            names = _known(db, body.captures)
            return _noted(page, db, "words", lambda: db.words.add(body.words, names))

    @routes.post("/api/captures/rename")
    def rename(body: RenameBody) -> CapturesChanged:
        """Rename a capture, or all below a folder, or several by a pattern."""
        with page.changing() as db:
            names = None if body.captures is None else _known(db, body.captures)
            return _noted(page, db, "name", lambda: db.captures.rename(body.old, body.new, names))

    @routes.post("/api/captures/remove")
    def remove(body: CapturesBody) -> CapturesChanged:
        """Remove several captures; undo brings them back."""
        with page.changing() as db:
            return remove_captures(page, db, body.captures)

    return routes


def remove_captures(page: Page, db: MotionDB, captures: Sequence[str]) -> CapturesChanged:
    """Remove captures, to be undone; the caller holds ``page.editing``."""
    names = _known(db, captures)
    return _noted(page, db, "removal", lambda: db.captures.remove(names))


def undo_last(page: Page, db: MotionDB) -> Edit:
    """Take back the latest edit that the page made; the caller holds ``page.editing``."""
    if not page.edits:
        raise PageError("undo: expected an edit, found none.", 409, "ConflictError")
    last = page.edits[-1]
    try:
        db.undo(last.run)
    except QueryError as error:
        page.edits.pop()
        raise PageError(
            f"{last.captures[0]}: this change of {last.what} was not taken back. {error}",
            409,
            "ConflictError",
        ) from error
    page.edits.pop()  # only now: a full disk leaves the edit to be undone later
    return last


def _known(db: MotionDB, names: Sequence[str]) -> list[str]:
    """Return the names, each once; refused where there is no such capture."""
    return [find_row(db, name).info.name for name in dict.fromkeys(names)]


def _noted(
    page: Page, db: MotionDB, what: str, change: Callable[[], Iterable[str]]
) -> CapturesChanged:
    """Make a change, and remember the run that made it, to be undone."""
    with transaction(db.store):  # no other request can start a run meanwhile
        changed = tuple(change())
        newest = max((int(run["run_id"]) for run in db.runs()), default=0)
    if changed:
        page.edits.append(Edit(changed, newest, what))
    return CapturesChanged(changed, len(page.edits))
