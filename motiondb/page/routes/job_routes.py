"""Routes of long work: start adding and learning, list, cancel, follow by server-sent events."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as PathParameter
from pydantic import Field
from starlette.responses import StreamingResponse

from motiondb.files import unit_from_name
from motiondb.page.answers import Answer, PageError, to_json
from motiondb.page.files.folders import allowed_path, list_folder
from motiondb.page.long_work.jobs import Job
from motiondb.page.parameters import Body, Seed, Text
from motiondb.page.schemas import shared_schemas
from motiondb.page.session.state import Page

EVERY, EVERY_OF_JOB = 0.1, 0.03
"""Seconds between two checks of all jobs, and of the one job that a client follows. Chosen by
hand: shorter than a user notices."""
KEEP_ALIVE = 15.0
"""Seconds after which a comment is sent on an idle stream, so that the connection is kept."""
_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Server-sent events: job with the facts of a job, progress with its step,"
        " revision with the revision of the database.",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}  # OpenAPI description of the stream of events
JobId = Annotated[str, PathParameter(max_length=40, description="Id of a job.")]


class FolderBody(Body):
    """A folder below one of the allowed folders."""

    root: Annotated[int, Field(ge=0, le=1000)]
    path: Text = ""


class AddBody(Body):
    """The source of captures: an upload, or a folder on the server's computer."""

    upload: Text | None = None
    folder: FolderBody | None = None
    words: Text | None = None
    unit: Annotated[str, Field(max_length=20)] | None = None
    fps: Annotated[float, Field(ge=1.0, le=100_000.0, allow_inf_nan=False)] | None = None
    keep_implausible: bool = False
    skip_bad_frames: bool = False


class LearnBody(Body):
    """The settings of learning."""

    symbols: Annotated[int, Field(ge=1, le=10_000)] | None = None
    seed: Seed = 0


def router(page: Page) -> APIRouter:
    """Return the routes of long work."""
    routes = APIRouter(tags=["jobs"])

    @routes.post("/api/add", response_model=shared_schemas.JobFacts, status_code=202)
    def add(body: AddBody) -> Answer:
        """Add captures, as a job."""
        page.check_writable()
        if body.unit:
            unit_from_name(body.unit)
        folder, words = _places(page, body)
        parameters = {
            "folder": str(folder),
            "words": str(words) if words else None,
            "unit": body.unit,
            "fps": body.fps,
            "keep_implausible": body.keep_implausible,
            "skip_bad_frames": body.skip_bad_frames,
        }
        return Answer(page.jobs.start("add", "add captures", parameters).facts(), 202)

    @routes.post("/api/learn", response_model=shared_schemas.JobFacts, status_code=202)
    def learn(body: LearnBody) -> Answer:
        """Learn symbols and words from all captures, as a job."""
        page.check_writable()
        return Answer(page.jobs.start("learn", "learn", body.model_dump()).facts(), 202)

    @routes.get("/api/folders", response_model=shared_schemas.FolderFacts)
    def folders(root: int = 0, path: str = "") -> Answer:
        """Folders, captures and sheets in one of the folders that the user allowed."""
        return Answer(list_folder(page.settings.folders, root, path))

    @routes.get("/api/jobs", response_model=shared_schemas.JobList)
    def jobs() -> Answer:
        """All jobs, newest first."""
        return Answer({"jobs": [job.facts() for job in page.jobs.all()]})

    @routes.get("/api/jobs/{job_id}", response_model=shared_schemas.JobFacts)
    def job(job_id: JobId) -> Answer:
        """A job."""
        return Answer(page.jobs.get(job_id).facts())

    @routes.delete("/api/jobs/{job_id}", response_model=shared_schemas.JobFacts)
    def cancel(job_id: JobId) -> Answer:
        """Cancel a job; nothing is half saved."""
        return Answer(page.jobs.cancel(job_id).facts())

    @routes.get("/api/jobs/{job_id}/events", response_class=StreamingResponse, responses=_EVENTS)
    async def follow(job_id: JobId) -> StreamingResponse:
        """Progress of a job as server-sent events, until it has ended."""
        return _stream(_job_events(page.jobs.get(job_id)))

    @routes.get("/api/events", response_class=StreamingResponse, responses=_EVENTS)
    async def events() -> StreamingResponse:
        """Changes of the database and of jobs as server-sent events, without end."""
        return _stream(_page_events(page))

    return routes


def _places(page: Page, body: AddBody) -> tuple[Path, Path | None]:
    """Return the folder to add, and its sheet of words."""
    if (body.upload is None) == (body.folder is None):
        raise PageError("add: expected either an upload or a folder, found neither or both.")
    if body.upload is not None:
        upload = page.uploads.get(body.upload)
        return upload.folder, upload.path(body.words) if body.words else None
    assert body.folder is not None
    roots = page.settings.folders
    folder = allowed_path(roots, body.folder.root, body.folder.path)
    return folder, allowed_path(roots, body.folder.root, body.words) if body.words else None


def _stream(events: AsyncIterator[str]) -> StreamingResponse:
    return StreamingResponse(
        events, media_type="text/event-stream", headers={"X-Accel-Buffering": "no"}
    )


def _event(name: str, facts: dict[str, Any]) -> str:
    return f"event: {name}\ndata: {json.dumps(to_json(facts))}\n\n"


async def _job_events(job: Job) -> AsyncIterator[str]:
    version = job.version
    yield _event("job", job.facts())
    silent = 0.0
    while not job.is_over:
        await asyncio.sleep(EVERY_OF_JOB)
        silent += EVERY_OF_JOB
        if job.version != version and not job.is_over:
            version, silent = job.version, 0.0
            yield _event("progress", job.step())
        elif silent > KEEP_ALIVE:
            silent = 0.0
            yield ": still here\n\n"
    if job.version != version:
        yield _event("job", job.facts())


async def _page_events(page: Page) -> AsyncIterator[str]:
    revision, seen = page.watch.revision, dict[str, int]()
    yield _event("revision", {"revision": revision})
    silent = 0.0
    while not page.closing.is_set():
        for job in reversed(page.jobs.all()):
            if seen.get(job.job_id) != job.version:
                seen[job.job_id], silent = job.version, 0.0
                yield _event("job", job.facts(curve=False))
        if page.watch.revision != revision:
            revision, silent = page.watch.revision, 0.0
            yield _event("revision", {"revision": revision})
        if silent > KEEP_ALIVE:
            silent = 0.0
            yield ": still here\n\n"
        await asyncio.sleep(EVERY)
        silent += EVERY
