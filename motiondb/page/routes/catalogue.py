"""Routes of the catalogue: captures, their words, changes, undo; the state of the database."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import Field

from motiondb import answers
from motiondb.database import MotionDB
from motiondb.database.catalogue.browsing import Facet
from motiondb.database.catalogue.exporting import formats_here
from motiondb.database.learn.start import shipped_starts
from motiondb.errors import QueryError
from motiondb.files.folder import CAPTURE_ENDINGS
from motiondb.learn.drift import Drift
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.replies import CaptureDetails, CaptureRow, capture_details, capture_row
from motiondb.page.routes.parameters import LONGEST_TEXT, Body, Name, Seconds, Text, Where
from motiondb.page.settings import SHEET_ENDINGS, SKELETON_ENDINGS, VERSION
from motiondb.page.state import Edit, Page, find_row, info_and_drift
from motiondb.page.uploads import without_surrogates
from motiondb.records import Caption, DuplicateGroup
from motiondb.store import transaction
from motiondb.store.catalogue.where import condition_text

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


def change_router(page: Page) -> APIRouter:
    """Return the routes of changes of several captures."""
    routes = APIRouter(tags=["catalogue"], responses=ERRORS)

    @routes.post("/api/captures/tags")
    def set_tags(body: CaptureTagsBody) -> CapturesChanged:
        """Set tags, such as performer and licence, of several captures."""
        with page.changing() as db:
            names = _known(db, body.captures)
            return noted(page, db, "tags", lambda: db.captures.set_tags(body.tags, names))

    @routes.post("/api/captures/words")
    def add_words(body: CaptureWordsBody) -> CapturesChanged:
        """Add a caption to each of several captures."""
        with page.changing() as db:
            names = _known(db, body.captures)
            return noted(page, db, "words", lambda: db.words.add(body.words, names))

    @routes.post("/api/captures/rename")
    def rename(body: RenameBody) -> CapturesChanged:
        """Rename a capture, or all below a folder, or several by a pattern."""
        with page.changing() as db:
            names = None if body.captures is None else _known(db, body.captures)
            return noted(page, db, "name", lambda: db.captures.rename(body.old, body.new, names))

    @routes.post("/api/captures/remove")
    def remove(body: CapturesBody) -> CapturesChanged:
        """Remove several captures; undo brings them back."""
        with page.changing() as db:
            return remove_captures(page, db, body.captures)

    return routes


def remove_captures(page: Page, db: MotionDB, captures: Sequence[str]) -> CapturesChanged:
    """Remove captures, to be undone; the caller holds ``page.editing``."""
    names = _known(db, captures)
    return noted(page, db, "removal", lambda: db.captures.remove(names))


def undo_last(page: Page, db: MotionDB) -> Edit:
    """Take back the latest edit that the page made; the caller holds ``page.editing``."""
    if not page.edits:
        raise PageError("undo: expected an edit, found none.", "ConflictError")
    last = page.edits[-1]
    try:
        db.undo(last.run)
    except QueryError as error:
        page.edits.pop()
        raise PageError(
            f"{last.captures[0]}: this change of {last.what} was not taken back. {error}",
            "ConflictError",
        ) from error
    page.edits.pop()  # only now: a full disk leaves the edit to be undone later
    return last


def _known(db: MotionDB, names: Sequence[str]) -> list[str]:
    """Return the names, each once; refused where there is no such capture."""
    return [find_row(db, name).info.name for name in dict.fromkeys(names)]


def noted(
    page: Page, db: MotionDB, what: str, change: Callable[[], Iterable[str]]
) -> CapturesChanged:
    """Make a change, and remember the run that made it, to be undone."""
    with transaction(db.store):  # no other request can start a run meanwhile
        changed = tuple(change())
        newest = max((int(run["run_id"]) for run in db.runs()), default=0)
    if changed:
        page.edits.append(Edit(changed, newest, what))
    return CapturesChanged(changed, len(page.edits))


MOST_SHOWN = 50  # Largest number of values of a facet that are sent; longer lists are searched


class CaptionBody(Body):
    """A caption; without times it is about the whole capture."""

    words: Text
    start: Seconds | None = None
    end: Seconds | None = None


class WordsBody(CaptionBody):
    """Words for a capture or a part of it."""

    capture: Text
    keep: bool | None = None


class CaptionsBody(Body):
    """All captions of a capture."""

    capture: Text
    words: list[CaptionBody]
    before: list[CaptionBody] | None = None  # Those that were edited: others are not overwritten


@dataclass(frozen=True)
class Accepted:
    """What may be uploaded."""

    captures: tuple[str, ...]
    skeletons: tuple[str, ...]
    sheets: tuple[str, ...]
    max_file_bytes: int
    max_request_bytes: int
    max_files: int


@dataclass(frozen=True)
class AllowedFolder:
    """A folder that the user allowed."""

    root: int
    name: str


@dataclass(frozen=True)
class ShippedStart:
    """Knowledge that is shipped with motiondb, from which learning can start."""

    name: str
    words: int
    captions: int
    credit: str


@dataclass(frozen=True, kw_only=True)
class Status(answers.DatabaseInfo):
    """The contents of the database, and what the page may do."""

    version: str
    read_only: bool
    revision: int
    drift: Drift | None
    accepts: Accepted
    writes: tuple[str, ...]  # Formats of downloads: FBX, USD and Parquet need more than motiondb
    folders: list[AllowedFolder]
    starts: tuple[ShippedStart, ...]
    running_jobs: int


@dataclass(frozen=True)
class CapturePage:
    """Rows of the catalogue."""

    total: int
    offset: int
    revision: int
    captures: list[CaptureRow]
    found: int | None = None  # Number, from 0, of the row that was asked for by name


@dataclass(frozen=True)
class FacetValue:
    """A value of a column, with the filter that selects its captures."""

    value: str
    count: int
    where: str


@dataclass(frozen=True)
class FacetRow:
    """The values of a column or tag."""

    column: str
    values: list[FacetValue]
    more: int
    missing: int


@dataclass(frozen=True)
class FacetsReply:
    """The facets of the captures that a filter selects."""

    total: int
    facets: list[FacetRow]


@dataclass(frozen=True)
class DuplicatesReply:
    """All groups of captures that repeat one another."""

    groups: tuple[DuplicateGroup, ...]


@dataclass(frozen=True)
class VocabularyReply:
    """The learned words, most frequent first."""

    words: list[answers.WordRow]


@dataclass(frozen=True)
class WordsEdited:
    """The words of a capture after an edit."""

    capture: str
    words: tuple[Caption, ...]
    counted: bool
    new_words: tuple[str, ...]
    undo: int  # Edits that can be undone


@dataclass(frozen=True)
class UndoState:
    """The number of edits that can be undone, and the capture of the next one."""

    left: int
    capture: str | None


@dataclass(frozen=True)
class WordsUndone:
    """The words of the first capture after an edit was undone."""

    capture: str
    words: tuple[Caption, ...]
    left: int
    what: str  # What the edit changed: "words", "tags", "selection", "name" or "removal"
    captures: int  # Number of captures that it changed


def router(page: Page) -> APIRouter:
    """Return the routes of the catalogue."""
    routes = APIRouter(tags=["catalogue"], responses=ERRORS)

    @routes.get("/api/status")
    def status() -> Status:
        """The contents of the database, and what this page may do."""
        with page.held.use() as db:
            return _status(page, db)

    @routes.get("/api/captures")
    def captures(
        where: Where = "",
        sort: Annotated[str, Query(max_length=200)] = "name",
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        limit: Annotated[int, Query(ge=1, le=1000)] = 100,
        find: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    ) -> CapturePage:
        """Rows of the catalogue: filtered, sorted, and one page at a time; `find`: a name."""
        with page.reading() as db:
            browsed = db.captures.browse(where, sort, offset, limit)
            rows = [capture_row(row) for row in browsed.rows]
            every = db.captures.browse(where, sort, limit=browsed.total).rows if find else ()
            names = [row.info.name for row in every]
            found = names.index(find) if find in names else None
            return CapturePage(browsed.total, offset, db.revision(), rows, found)

    @routes.get("/api/facets")
    def facets(where: Where = "") -> FacetsReply:
        """The number of captures for each value of columns and tags."""
        with page.held.use() as db:
            total = db.captures.browse(where, limit=1).total
            return FacetsReply(total, [_facet_row(facet) for facet in db.captures.facets(where)])

    @routes.get("/api/capture")
    def capture(name: Name, described: bool = True) -> CaptureDetails:
        """Everything about one capture; without `described`, no activities and no likely words."""
        with page.reading() as db:
            return capture_details(db, find_row(db, name), described)

    @routes.delete("/api/capture", response_model_exclude_none=True)
    def remove(name: Name) -> answers.Removed:
        """Remove a capture from the database."""
        with page.changing() as db:
            return answers.Removed(list(remove_captures(page, db, [name]).changed))

    @routes.get("/api/duplicates")
    def duplicates() -> DuplicatesReply:
        """Groups of captures that repeat one another."""
        with page.held.use() as db:
            return DuplicatesReply(db.captures.duplicates())

    @routes.get("/api/vocabulary")
    def vocabulary() -> VocabularyReply:
        """The words that were learned, with their symbols."""
        with page.held.use() as db:
            return VocabularyReply(db.words.rows())

    _word_routes(routes, page)
    return routes


def _word_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes that change words, and undo."""

    @routes.post("/api/words")
    def set_words(body: WordsBody) -> WordsEdited:
        """Write the caption of a capture, or of a part of it."""
        timed = body.start is not None or body.end is not None
        keep = timed if body.keep is None else body.keep
        new = Caption(body.words, body.start, body.end)
        with page.changing() as db:
            before = db.words.captions(find_row(db, body.capture).info.name)
            return _change(page, db, body.capture, (*before, new) if keep else (new,))

    @routes.put("/api/captions")
    def set_captions(body: CaptionsBody) -> WordsEdited:
        """Replace all captions of a capture; an empty list removes them."""
        captions = _captions(body.words)
        with page.changing() as db:
            find_row(db, body.capture)
            if body.before is not None:
                _check_same(db, body.capture, _captions(body.before))
            return _change(page, db, body.capture, captions)

    @routes.get("/api/undo")
    def undoable() -> UndoState:
        """The number of edits that can be undone, and the capture of the next one."""
        last = page.edits[-1].captures[0] if page.edits else None
        return UndoState(len(page.edits), last)

    @routes.post("/api/undo")
    def undo() -> WordsUndone:
        """Undo the latest edit that this page made."""
        with page.changing() as db:
            last = undo_last(page, db)
            first, left = last.captures[0], len(page.edits)
            return WordsUndone(first, db.words.captions(first), left, last.what, len(last.captures))


def _captions(bodies: Sequence[CaptionBody]) -> tuple[Caption, ...]:
    return tuple(Caption(each.words, each.start, each.end) for each in bodies)


def _check_same(db: MotionDB, capture: str, before: Sequence[Caption]) -> None:
    """Refuse an edit of words that were changed since they were read."""
    now = db.words.captions(capture)
    if set(now) != set(before):
        said = "; ".join(caption.words for caption in now) or "none"
        raise PageError(
            f"{capture}: expected the words that were edited, found others: {said}. They were"
            " changed meanwhile; nothing is saved.",
            "ConflictError",
        )


def _change(page: Page, db: MotionDB, capture: str, captions: tuple[Caption, ...]) -> WordsEdited:
    """Replace the captions of a capture, and remember how to undo it."""
    before = db.words.captions(capture)
    change = db.words.set_captions(capture, captions)
    after = db.words.captions(capture)
    if after != before:
        page.edits.append(Edit((capture,), change.run_id, "words"))
    return WordsEdited(capture, after, bool(change.counted), change.new_words, len(page.edits))


def _facet_row(facet: Facet) -> FacetRow:
    """Return the number of captures for each value, and the filter that selects them."""
    shown, more = facet.values[:MOST_SHOWN], max(len(facet.values) - MOST_SHOWN, 0)
    values = [FacetValue(each, n, condition_text(facet.column, each)) for each, n in shown]
    return FacetRow(facet.column, values, more, facet.missing)


@cache
def _starts() -> tuple[ShippedStart, ...]:
    """Return the knowledge that is shipped with motiondb."""
    names = [field.name for field in fields(ShippedStart)]
    return tuple(ShippedStart(*(each[name] for name in names)) for each in shipped_starts())


def _status(page: Page, db: MotionDB) -> Status:
    info, drift = info_and_drift(db)
    limits, folders = page.settings.limits, page.settings.folders
    sizes = limits.file_bytes, limits.request_bytes, limits.files
    return answers.extended(
        Status,
        info,
        database=without_surrogates(page.settings.database.name),
        version=VERSION,
        read_only=page.settings.read_only,
        revision=db.revision(),
        drift=drift,
        accepts=Accepted(CAPTURE_ENDINGS, SKELETON_ENDINGS, SHEET_ENDINGS, *sizes),
        writes=formats_here(),
        folders=[
            AllowedFolder(n, without_surrogates(folder.name or str(folder)))
            for n, folder in enumerate(folders)
        ],
        starts=_starts(),
        running_jobs=sum(not job.is_over for job in page.jobs.all()),
    )
