"""Routes of the catalogue: captures, their words, duplicates; the state of the database."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from motiondb.database import MotionDB
from motiondb.database.catalogue.browsing import BrowsedCapture
from motiondb.files.folder import CAPTURE_ENDINGS
from motiondb.page.answers import Answer, PageError, unknown
from motiondb.page.facts.capture_facts import (
    caption_facts,
    capture_facts,
    facet_facts,
    relation_facts,
    row_facts,
)
from motiondb.page.parameters import Body, Name, Seconds, Text, Where
from motiondb.page.schemas import catalogue_schemas
from motiondb.page.session.held import database_facts
from motiondb.page.session.state import Page, WordEdit
from motiondb.page.settings import SHEET_ENDINGS, SKELETON_ENDINGS, VERSION
from motiondb.records import Caption


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


def router(page: Page) -> APIRouter:
    """Return the routes of the catalogue."""
    routes = APIRouter(tags=["catalogue"])

    @routes.get("/api/status", response_model=catalogue_schemas.StatusFacts)
    def status() -> Answer:
        """The contents of the database, and what this page may do."""
        with page.held.use() as db:
            return Answer(_status(page, db))

    @routes.get("/api/captures", response_model=catalogue_schemas.CaptureRows)
    def captures(
        where: Where = "",
        sort: Annotated[str, Query(max_length=200)] = "name",
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    ) -> Answer:
        """Rows of the catalogue: filtered, sorted, and one page at a time."""
        with page.held.use() as db, db.session.reading():
            browsed = db.browse(where, sort, offset, limit)
            rows = [row_facts(row) for row in browsed.rows]
            facts = {"total": browsed.total, "offset": offset, "revision": db.revision()}
        return Answer(facts | {"captures": rows})

    @routes.get("/api/facets", response_model=catalogue_schemas.FacetList)
    def facets(where: Where = "") -> Answer:
        """The number of captures for each value of columns and tags."""
        with page.held.use() as db:
            total = db.browse(where, limit=1).total
            facts = [facet_facts(facet) for facet in db.facets(where)]
        return Answer({"total": total, "facets": facts})

    @routes.get("/api/capture", response_model=catalogue_schemas.CaptureFacts)
    def capture(name: Name) -> Answer:
        """Everything about one capture."""
        with page.held.use() as db, db.session.reading():
            return Answer(capture_facts(db, find_row(db, name)))

    @routes.delete("/api/capture", response_model=catalogue_schemas.Removed)
    def remove(name: Name) -> Answer:
        """Remove a capture from the database."""
        page.check_writable()
        with page.held.use() as db:
            find_row(db, name)
            return Answer({"removed": db.remove([name])})

    @routes.get("/api/duplicates", response_model=catalogue_schemas.DuplicateGroups)
    def duplicates() -> Answer:
        """Groups of captures that repeat one another."""
        with page.held.use() as db:
            groups = db.duplicates()
        return Answer(
            {
                "groups": [
                    {
                        "keep": group.captures[0],
                        "captures": group.captures,
                        "relations": [relation_facts(r) for r in group.relations],
                    }
                    for group in groups
                ]
            }
        )

    @routes.get("/api/vocabulary", response_model=catalogue_schemas.Vocabulary)
    def vocabulary() -> Answer:
        """The words that were learned, with their symbols."""
        with page.held.use() as db:
            return Answer({"words": db.word_rows()})

    _word_routes(routes, page)
    return routes


def _word_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes that change words, and undo."""

    @routes.post("/api/words", response_model=catalogue_schemas.WordsChanged)
    def set_words(body: WordsBody) -> Answer:
        """Write the caption of a capture, or of a part of it."""
        page.check_writable()
        timed = body.start is not None or body.end is not None
        keep = timed if body.keep is None else body.keep
        new = Caption(body.words, body.start, body.end)
        with page.held.use() as db, page.editing:
            before = db.captions(find_row(db, body.capture).info.name)
            return Answer(_change(page, db, body.capture, (*before, new) if keep else (new,)))

    @routes.put("/api/captions", response_model=catalogue_schemas.WordsChanged)
    def set_captions(body: CaptionsBody) -> Answer:
        """Replace all captions of a capture; an empty list removes them."""
        page.check_writable()
        captions = tuple(Caption(c.words, c.start, c.end) for c in body.words)
        with page.held.use() as db, page.editing:
            find_row(db, body.capture)
            return Answer(_change(page, db, body.capture, captions))

    @routes.get("/api/undo", response_model=catalogue_schemas.Undoable)
    def undoable() -> Answer:
        """The number of edits that can be undone, and the capture of the next one."""
        last = page.edits[-1].capture if page.edits else None
        return Answer({"left": len(page.edits), "capture": last})

    @routes.post("/api/undo", response_model=catalogue_schemas.Undone)
    def undo() -> Answer:
        """Undo the latest edit of words that this page made."""
        page.check_writable()
        with page.held.use() as db, page.editing:
            if not page.edits:
                raise PageError("undo: expected an edit, found none.", 409, "ConflictError")
            last = page.edits.pop()
            row = db.browsed(last.capture)
            if row is None or row.captions != last.after:
                raise PageError(
                    f"{last.capture}: expected the words of this edit, found others."
                    " They were changed since, and stay as they are.",
                    409,
                    "ConflictError",
                )
            db.set_captions(last.capture, last.before)
            words = caption_facts(db.captions(last.capture))
        return Answer({"capture": last.capture, "words": words, "left": len(page.edits)})


def find_row(db: MotionDB, name: str) -> BrowsedCapture:
    """Return the row of a capture."""
    row = db.browsed(name)
    if row is None:
        raise unknown("capture", name, "It may have been removed.")
    return row


def _change(
    page: Page, db: MotionDB, capture: str, captions: tuple[Caption, ...]
) -> dict[str, Any]:
    """Replace the captions of a capture, remember how to undo it, and return the facts."""
    before = db.captions(capture)
    change = db.set_captions(capture, captions)
    after = db.captions(capture)
    page.edits.append(WordEdit(capture, before, after))
    return {
        "capture": capture,
        "words": caption_facts(after),
        "counted": bool(change.counted),
        "new_words": list(change.new_words),
        "undo": len(page.edits),
    }


_LEARNED = ("symbols", "clusters", "words", "current", "not_yet_learned")


def _status(page: Page, db: MotionDB) -> dict[str, Any]:
    facts, drift = database_facts(db)
    limits = page.settings.limits
    return {
        **dict.fromkeys(_LEARNED),
        **facts,
        "version": VERSION,
        "database": page.settings.database.name,
        "read_only": page.settings.read_only,
        "revision": db.revision(),
        "drift": drift
        and {"relearn": drift.relearn, "reasons": drift.reasons, "words": drift.words},
        "accepts": {
            "captures": CAPTURE_ENDINGS,
            "skeletons": SKELETON_ENDINGS,
            "sheets": SHEET_ENDINGS,
            "max_file_bytes": limits.file_bytes,
            "max_request_bytes": limits.request_bytes,
            "max_files": limits.files,
        },
        "folders": [
            {"root": number, "name": folder.name or str(folder)}
            for number, folder in enumerate(page.settings.folders)
        ],
        "running_jobs": sum(not job.is_over for job in page.jobs.all()),
    }
