"""The web application: routes, errors, and the files of the page."""

from __future__ import annotations

import gzip
import re
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, Response

from motiondb.errors import MotionDBError
from motiondb.page.errors import FULL_DISK, answer_of, error_answer, unknown
from motiondb.page.guard import HEADERS, Guard
from motiondb.page.routes import asking, boards, catalogue, files, grammars, jobs, selections
from motiondb.page.settings import BUNDLE, NO_BUNDLE, VERSION, PageSettings, bundle_file
from motiondb.page.state import Page

_ROUTERS = (
    *(catalogue.router, catalogue.change_router, selections.router),
    *(asking.router, asking.symbols_router, asking.making_router),
    *(files.motion_router, grammars.router, boards.router, boards.scene_router),
    *(files.router, jobs.router),
)
_KINDS = {404: "UnknownError", 405: "MethodError", 413: "TooLargeError", 415: "KindError"}
"""Kind of error by HTTP status."""


def make_application(settings: PageSettings, folder: Path, bundle: Path = BUNDLE) -> FastAPI:
    """Return the application."""
    page = Page(settings, folder)

    @asynccontextmanager
    async def lifespan(_application: FastAPI) -> AsyncIterator[None]:
        page.watch.start()
        yield
        page.close()

    application = FastAPI(
        title="motiondb",
        version=VERSION,
        lifespan=lifespan,
        description="The interface of the page. docs/guide/page.md describes the answers.",
        openapi_url="/api/openapi.json",
        docs_url=None,
        redoc_url=None,
        separate_input_output_schemas=False,  # fields with a default may be absent in answers too
    )
    application.state.page = page
    for router in _ROUTERS:
        # include_router would make all of them again, 0.3 s
        application.router.routes.extend(router(page).routes)
    _error_handlers(application, folder)
    _page_files(application, bundle)
    application.add_middleware(cast("Any", Guard), settings=settings)
    return application


def _error_handlers(application: FastAPI, folder: Path) -> None:
    """Give every error the same form; the private folder is left out of messages."""
    private = re.compile(rf"{re.escape(str(folder))}/(?:[^/\s:]+/)*")
    Handler = Callable[[Request, Exception], Awaitable[Response]]

    async def refused(_request: Request, error: MotionDBError) -> Response:
        return answer_of(error, lambda message: private.sub("", message))

    async def malformed(_request: Request, error: RequestValidationError) -> Response:
        faults = "; ".join(
            f"{'.'.join(str(part) for part in each['loc'])}: {each['msg']}"
            for each in error.errors()[:5]
        )
        return error_answer("RequestError", faults, 422)

    async def failed(_request: Request, error: HTTPException) -> Response:
        kind = _KINDS.get(error.status_code, "RequestError")
        answer = error_answer(kind, f"request: {error.detail}.", error.status_code)
        for name, value in (error.headers or {}).items():
            answer.headers[name] = value
        return answer

    async def full(_request: Request, error: OSError) -> Response:
        if error.errno not in FULL_DISK:
            raise error
        message = (
            f"request: expected room for its files, found none ({error.strerror}). Free some on the"
            " disk of the database and on that of temporary files (TMPDIR)."
        )
        return error_answer("FullError", message, 507)

    async def short(_request: Request, _error: MemoryError) -> Response:
        message = (
            "request: expected enough memory, found that it ran out. Close other programs, or give "
            "the server more (ulimit -v)."
        )
        return error_answer("FullError", message, 507)

    async def broken(_request: Request, error: Exception) -> Response:
        # the guard adds no headers here: this answer is made outside of it
        fault = type(error).__name__
        message = f"request: expected an answer, found a fault of the program ({fault})."
        answer = error_answer("ProgramError", message, 500)
        answer.headers.update(HEADERS)
        return answer

    application.add_exception_handler(Exception, broken)
    application.add_exception_handler(OSError, cast(Handler, full))
    application.add_exception_handler(MemoryError, cast(Handler, short))
    application.add_exception_handler(MotionDBError, cast(Handler, refused))
    application.add_exception_handler(RequestValidationError, cast(Handler, malformed))
    application.add_exception_handler(HTTPException, cast(Handler, failed))


@lru_cache(maxsize=64)
def _compressed(path: Path, _modified: int) -> bytes:
    """Return a file of the page, compressed to a quarter of its size."""
    return gzip.compress(path.read_bytes(), mtime=0)


def _page_files(application: FastAPI, bundle: Path) -> None:
    """Serve the page and the files beside it."""

    @application.get("/", include_in_schema=False)
    def index() -> Response:
        page_file = bundle_file(bundle, "index.html")
        if page_file is None:
            return Response(NO_BUNDLE, 503, media_type="text/plain; charset=utf-8")
        return FileResponse(page_file, headers={"Cache-Control": "no-cache"})

    @application.get("/{name}", include_in_schema=False)
    def file(request: Request, name: str) -> Response:
        page_file = bundle_file(bundle, name)
        if page_file is None:
            raise unknown("file", name)
        headers = {"Cache-Control": "no-cache"}
        media = {".js": "text/javascript", ".css": "text/css"}.get(page_file.suffix)
        if media is None or "gzip" not in request.headers.get("accept-encoding", ""):
            return FileResponse(page_file, headers=headers)
        headers |= {"Content-Encoding": "gzip", "Vary": "Accept-Encoding"}
        data = _compressed(page_file, page_file.stat().st_mtime_ns)
        return Response(data, media_type=media, headers=headers)
