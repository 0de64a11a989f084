"""Routes of long work: start adding and learning, list, cancel, follow by server-sent events."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as PathParameter
from pydantic import Field
from starlette.responses import StreamingResponse

from motiondb.answers.plain import to_json
from motiondb.database.learn.start import NONE, shipped_names
from motiondb.files.limits import check_up
from motiondb.files.units import unit_from_name
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.jobs import Job, JobReply
from motiondb.page.routes.parameters import Body, Seed, Text
from motiondb.page.state import Page
from motiondb.page.uploads import FolderReply, allowed_path, list_folder

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


@dataclass(frozen=True)
class JobsReply:
    """All jobs, newest first."""

    jobs: list[JobReply]


class FolderBody(Body):
    """A folder below one of the allowed folders."""

    root: Annotated[int, Field(ge=0, le=1000)]
    path: Text = ""


class AddBody(Body):
    """The source of captures: an upload, or a folder on the server's computer.

    `sample`: The sample captures, which are also learned from; nothing else counts then.
    """

    sample: bool = False
    upload: Text | None = None
    folder: FolderBody | None = None
    words: Text | None = None
    unit: Annotated[str, Field(max_length=20)] | None = None
    fps: Annotated[float, Field(ge=1.0, le=100_000.0, allow_inf_nan=False)] | None = None
    up: Annotated[str, Field(max_length=2)] = ""
    mirror_world: bool = False
    swap_sides: bool = False
    keep_implausible: bool = False
    skip_bad_frames: bool = False


class LearningBody(Body):
    """The settings of learning."""

    symbols: Annotated[int, Field(ge=1, le=10_000)] | None = None
    seed: Seed = 0
    start: Text | None = None  # Shipped knowledge or "none"; absent: what was used before


def router(page: Page) -> APIRouter:
    """Return the routes of long work."""
    routes = APIRouter(tags=["jobs"], responses=ERRORS)

    @routes.post("/api/add", status_code=202)
    def add(body: AddBody) -> JobReply:
        """Add captures, as a job."""
        return _begin_adding(page, body)

    @routes.post("/api/learn", status_code=202)
    def learn(body: LearningBody) -> JobReply:
        """Learn symbols and words from all captures, as a job."""
        page.check_writable()
        _check_start(body.start)
        return page.jobs.start("learn", "learn", body.model_dump()).reply()

    @routes.get("/api/folders")
    def folders(root: int = 0, path: str = "") -> FolderReply:
        """Folders, captures and sheets in one of the folders that the user allowed."""
        return list_folder(page.settings.folders, root, path)

    @routes.get("/api/jobs")
    def jobs() -> JobsReply:
        """All jobs, newest first."""
        return JobsReply([job.reply() for job in page.jobs.all()])

    @routes.get("/api/jobs/{job_id}")
    def job(job_id: JobId) -> JobReply:
        """A job."""
        return page.jobs.get(job_id).reply()

    @routes.delete("/api/jobs/{job_id}")
    def cancel(job_id: JobId) -> JobReply:
        """Cancel a job; nothing is half saved."""
        return page.jobs.cancel(job_id).reply()

    @routes.get("/api/jobs/{job_id}/events", response_class=StreamingResponse, responses=_EVENTS)
    async def follow(job_id: JobId) -> StreamingResponse:
        """Progress of a job as server-sent events, until it has ended."""
        return _stream(_job_events(page.jobs.get(job_id)))

    @routes.get("/api/events", response_class=StreamingResponse, responses=_EVENTS)
    async def events() -> StreamingResponse:
        """Changes of the database and of jobs as server-sent events, without end."""
        return _stream(_page_events(page))

    return routes


def _begin_adding(page: Page, body: AddBody) -> JobReply:
    """Start the job that adds what a request names."""
    page.check_writable()
    if body.sample:
        return page.jobs.start("sample", "try the sample captures", {}).reply()
    if body.unit:
        unit_from_name(body.unit)
    check_up(body.up, "up")
    folder, words, within = _places(page, body)
    places = {"folder": folder, "words": words, "within": within}
    parameters = body.model_dump(exclude={"sample", "upload", "folder", "words"})
    parameters |= {name: str(place) if place else None for name, place in places.items()}
    return page.jobs.start("add", "add captures", parameters).reply()


def _check_start(start: str | None) -> None:
    """Refuse a start that is not shipped with motiondb: no request names a file."""
    starts = [*shipped_names(), NONE]
    if start is not None and start not in starts:
        raise PageError(
            f"learn: expected a start of {', '.join(starts)}, found {start[:100]!r}."
            " Use motiondb learn --start FILE for other knowledge."
        )


def _places(page: Page, body: AddBody) -> tuple[Path, Path | None, Path | None]:
    """Return the folder to add, its sheet of words, and the folder that links must stay in."""
    if (body.upload is None) == (body.folder is None):
        raise PageError("add: expected either an upload or a folder, found neither or both.")
    if body.upload is not None:
        words = page.uploads.path(body.upload, body.words) if body.words else None
        return page.uploads.path(body.upload), words, None
    assert body.folder is not None
    roots = page.settings.folders
    root = body.folder.root
    folder = allowed_path(roots, root, body.folder.path)
    words = allowed_path(roots, root, body.words) if body.words else None
    return folder, words, roots[root].resolve()


def _stream(events: AsyncIterator[str]) -> StreamingResponse:
    return StreamingResponse(
        events, media_type="text/event-stream", headers={"X-Accel-Buffering": "no"}
    )


def _event(name: str, facts: object) -> str:
    return f"event: {name}\ndata: {json.dumps(to_json(facts))}\n\n"


async def _job_events(job: Job) -> AsyncIterator[str]:
    version = job.version
    yield _event("job", job.reply())
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
        yield _event("job", job.reply())


async def _page_events(page: Page) -> AsyncIterator[str]:
    revision, seen = page.watch.revision, dict[str, int]()
    yield _event("revision", {"revision": revision})
    silent = 0.0
    while not page.closing.is_set():
        for job in reversed(page.jobs.all()):
            if seen.get(job.job_id) != job.version:
                seen[job.job_id], silent = job.version, 0.0
                yield _event("job", replace(job.reply(), curve=[]))
        if page.watch.revision != revision:
            revision, silent = page.watch.revision, 0.0
            yield _event("revision", {"revision": revision})
        if silent > KEEP_ALIVE:
            silent = 0.0
            yield ": still here\n\n"
        await asyncio.sleep(EVERY)
        silent += EVERY
