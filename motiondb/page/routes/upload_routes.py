"""Routes of files: uploads in, downloads out."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Request
from fastapi.concurrency import run_in_threadpool
from pydantic import Field
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartException
from starlette.responses import Response

from motiondb.page.answers import Answer, PageError
from motiondb.page.delivery.downloads import Download, download
from motiondb.page.parameters import Body, End, Part, RefText, Start
from motiondb.page.schemas import shared_schemas
from motiondb.page.session.state import Page

MOST_ITEMS = 500  # Largest number of captures of one download
Format = Literal["bvh", "glb", "source"]
_UPLOAD = {
    "requestBody": {
        "required": True,
        "content": {
            "multipart/form-data": {
                "schema": {
                    "type": "object",
                    "required": ["files"],
                    "properties": {
                        "files": {
                            "type": "array",
                            "minItems": 1,
                            "items": {"type": "string", "format": "binary"},
                        }
                    },
                }
            }
        },
    }
}  # OpenAPI description of an upload
_BINARY = {"schema": {"type": "string", "format": "binary"}}
_FILE: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "A file to be saved: a motion, or a zip of several.",
        "content": {
            "application/octet-stream": _BINARY,
            "application/zip": _BINARY,
            "model/gltf-binary": _BINARY,
        },
    }
}  # OpenAPI description of a download


class DownloadBody(Body):
    """What to download, and in which format."""

    items: Annotated[list[Part], Field(min_length=1, max_length=MOST_ITEMS)]
    format: Format = "bvh"
    canonical: bool = False


def router(page: Page) -> APIRouter:
    """Return the routes of files."""
    routes = APIRouter(tags=["files"])

    @routes.post("/api/uploads", response_model=shared_schemas.UploadFacts, openapi_extra=_UPLOAD)
    async def upload(request: Request) -> Answer:
        """Receive captures and sheets of words, without adding them to the database."""
        limits = page.settings.limits
        try:
            form = await request.form(max_files=limits.files, max_fields=10)
        except (HTTPException, MultiPartException) as error:
            said = getattr(error, "detail", None) or str(error)
            raise PageError(f"upload: expected files as a form has them, found: {said}") from None
        try:
            files = [item for _, item in form.multi_items() if isinstance(item, UploadFile)]
            facts = await run_in_threadpool(_take, page, files)
        finally:
            await form.close()
        return Answer(facts)

    @routes.get("/api/download", response_class=Response, responses=_FILE)
    def download_one(
        ref: RefText,
        start: Start = None,
        end: End = None,
        format: Format = "bvh",
        canonical: bool = False,
    ) -> Response:
        """One motion as a file; a scene as a zip."""
        parts = [Part(ref=ref, start=start, end=end)]
        return _answer(download(page, parts, format, canonical))

    @routes.post("/api/download", response_class=Response, responses=_FILE)
    def download_many(body: DownloadBody) -> Response:
        """Motions as files; several as a zip archive, with the provenance of generated motions."""
        return _answer(download(page, body.items, body.format, body.canonical))

    return routes


def _take(page: Page, files: list[UploadFile]) -> dict[str, Any]:
    received = page.uploads.begin()
    for file in files:
        received.take(file.filename or "", file.file)
    kept = page.uploads.keep(received)
    return {
        "upload": kept.upload_id,
        "files": [
            {
                "name": file.name,
                "ref": f"upload:{kept.upload_id}/{file.name}",
                "bytes": file.n_bytes,
                "kind": file.kind,
            }
            for file in kept.files
        ],
        "refused": [{"name": name, "message": why} for name, why in received.refused],
    }


def _answer(file: Download) -> Response:
    headers = {"Content-Disposition": f'attachment; filename="{file.name}"'}
    return Response(file.data, media_type=file.media_type, headers=headers)
