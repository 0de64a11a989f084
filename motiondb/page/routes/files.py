"""Routes of files: uploads in, downloads out."""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Request
from fastapi.concurrency import run_in_threadpool
from pydantic import Field
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartException
from starlette.responses import Response

from motiondb.body import retarget
from motiondb.database import MotionDB
from motiondb.database.catalogue.parts import write_clip
from motiondb.page.errors import PageError
from motiondb.page.refs import Ref, find_capture, find_kept, load_motion, load_scene, read_ref
from motiondb.page.routes.parameters import Body, End, Part, RefText, Start
from motiondb.page.state import Page
from motiondb.page.uploads import UploadReply

_PLAIN = re.compile(r"[^A-Za-z0-9._-]+")
_TYPES = {".zip": "application/zip", ".glb": "model/gltf-binary"}
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

    @routes.post("/api/uploads", openapi_extra=_UPLOAD)
    async def upload(request: Request) -> UploadReply:
        """Receive captures and sheets of words, without adding them to the database."""
        limits = page.settings.limits
        try:
            form = await request.form(max_files=limits.files, max_fields=10)
        except (HTTPException, MultiPartException) as error:
            said = getattr(error, "detail", None) or str(error)
            raise PageError(f"upload: expected files as a form has them, found: {said}") from None
        try:
            items = [item for _, item in form.multi_items() if isinstance(item, UploadFile)]
            files = [(item.filename or "", item.file) for item in items]
            return await run_in_threadpool(page.uploads.receive, files)
        finally:
            await form.close()

    @routes.get("/api/download", response_class=Response, responses=_FILE)
    def download_one(
        ref: RefText,
        start: Start = None,
        end: End = None,
        format: Format = "bvh",
        canonical: bool = False,
    ) -> Response:
        """One motion as a file; a scene as a zip."""
        return download(page, [Part(ref=ref, start=start, end=end)], format, canonical)

    @routes.post("/api/download", response_class=Response, responses=_FILE)
    def download_many(body: DownloadBody) -> Response:
        """Motions as files; several as a zip archive, with the provenance of generated motions."""
        return download(page, body.items, body.format, body.canonical)

    return routes


def download(page: Page, parts: Sequence[Part], ending: str, canonical: bool) -> Response:
    """Return the file for some parts: one motion as it is, anything else as a zip."""
    with tempfile.TemporaryDirectory(dir=page.folder) as place:
        folder = Path(place)
        targets = [(part, read_ref(part.ref), folder / f"{n:04d}") for n, part in enumerate(parts)]
        for _, ref, target in targets:
            target.mkdir()
            if ref.kind == "scene" and ending != "source":  # by a process that may need the file
                made = page.scene_folder(ref.name)
                output = str(target / "scene")
                asked = {"scene": ref.name, "folder": str(made), "output": output}
                page.jobs.ask_scene_worker("scene-files", "write the scene", asked)
        with page.held.use() as db, db.session.reading():
            for part, ref, target in targets:
                if not any(target.iterdir()):
                    _write(page, db, part, ref, ending, canonical, target)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        if len(files) == 1:
            name, data = files[0].name, files[0].read_bytes()
        else:
            name, data = "motiondb.zip", _zip(files)
    return Response(
        data,
        media_type=_TYPES.get(Path(name).suffix, "application/octet-stream"),
        headers={"Content-Disposition": f'attachment; filename="{name}"'},  # plain ASCII
    )


def _zip(files: Sequence[Path]) -> bytes:
    """Return a zip archive of files; files of the same name are numbered."""
    stream, used = io.BytesIO(), dict[str, int]()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files:
            count = used[path.name] = used.get(path.name, 0) + 1
            name = path.name if count == 1 else f"{path.stem}-{count}{path.suffix}"
            archive.write(path, name)
    return stream.getvalue()


def _write(
    page: Page, db: MotionDB, part: Part, ref: Ref, ending: str, canonical: bool, folder: Path
) -> None:
    """Write one part into a folder."""
    stem = _stem(ref, part)
    if ending == "source":
        _write_source(db, ref, part, folder)
        return
    path = folder / f"{stem}.{ending}"
    if ref.kind == "capture":
        db.export(find_capture(db, ref.name), path, part.start, part.end, canonical)
    elif ref.kind == "made" and part.start is None and part.end is None:
        page.made.get(ref.name).generated.write(path)
    elif ref.kind == "sequence" and part.start is None and part.end is None:
        kept = page.sequences.get(ref.name)
        db.grammars.write(kept.sequence, path, kept.seed)
    elif ref.kind == "kept":
        record = find_kept(db, ref.name)
        load_scene(page, db, ref, None, None, 30.0)  # raises if a capture of the scene was removed
        for player in record.players:
            name = f"{ref.name}/{player.name}"
            db.export(name, folder / f"{_plain(player.name)}.{ending}", canonical=True)
    else:
        write_clip(retarget.to_clip(load_motion(page, db, ref, part.start, part.end)), path)


def _write_source(db: MotionDB, ref: Ref, part: Part, folder: Path) -> None:
    if ref.kind != "capture" or part.start is not None or part.end is not None:
        raise PageError(
            f"{ref}: expected a whole stored capture for its source file, found something else."
            " Choose BVH or glTF."
        )
    row = db.browsed(find_capture(db, ref.name))
    assert row is not None
    ending = Path(row.info.path).suffix.lower() or f".{row.info.format}"
    db.export(ref.name, folder / f"{_plain(ref.name)}.{_plain(ending)}")


def _stem(ref: Ref, part: Part) -> str:
    stem = _plain(ref.name)
    if part.start is None and part.end is None:
        return stem
    return f"{stem}_{part.start or 0.0:.2f}-{'end' if part.end is None else f'{part.end:.2f}'}"


def _plain(name: str) -> str:
    """Return a name with only characters that every file system and HTTP header allows.

    >>> _plain('ana/läuft "schnell"')
    'ana_l_uft_schnell_'
    """
    return _PLAIN.sub("_", name).lstrip(".")[:150] or "motion"
