"""Errors of the page, and all errors as JSON."""

from __future__ import annotations

import errno
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from starlette.responses import Response

from motiondb.answers.plain import to_json
from motiondb.errors import HeldError, MotionDBError, NotLearnedError

FULL_DISK = (errno.ENOSPC, errno.EDQUOT)
"""Numbers of the errors that say that nothing more can be written."""


STATUS_OF = {
    "TokenError": 401,
    **dict.fromkeys(("HostError", "OriginError", "ReadOnlyError", "FolderError"), 403),
    **{"UnknownError": 404, "MethodError": 405, "ConflictError": 409},
    **{"TooLargeError": 413, "KindError": 415},
}
"""Status of the answer for kinds of errors; of others it is 400."""


class PageError(MotionDBError):
    """An error that the page raises itself, with the HTTP status of its answer."""

    def __init__(self, message: str, kind: str = "RequestError", status: int = 0) -> None:
        super().__init__(message)
        self.kind, self.status = kind, status or STATUS_OF.get(kind, 400)


def unknown(what: str, name: str, advice: str = "") -> PageError:
    """Return the error, with status 404, for something that the server does not have."""
    shown = name if len(name) <= 200 else f"{name[:200]}..."
    message = f"{what}: expected an existing one, found {shown!r}. {advice}".strip()
    return PageError(message, "UnknownError")


@dataclass(frozen=True)
class ErrorFacts:
    """What went wrong; `status` is that of the answer."""

    kind: str
    message: str
    status: int


@dataclass(frozen=True)
class ErrorReply:
    """The form that all errors of the page have."""

    error: ErrorFacts


def error_answer(kind: str, message: str, status: int) -> Response:
    """Return an error in the form that all errors of the page have."""
    headers = {"Retry-After": "1"} if status == 503 else None
    reply = ErrorReply(ErrorFacts(kind, message, status))
    text = json.dumps(to_json(reply), ensure_ascii=False)
    data = text.encode("utf-8", "replace")  # file names may hold lone surrogates
    return Response(data, status, headers, media_type="application/json")


def answer_of(error: MotionDBError, shown: Callable[[str], str] = str) -> Response:
    """Return the answer for an error of :class:`motiondb.MotionDB`."""
    kind, message = type(error).__name__, shown(str(error))
    if isinstance(error, PageError):
        return error_answer(error.kind, message, error.status)
    if isinstance(error, HeldError) or kind == "OtherModeError":
        return error_answer("HeldError", message, 503)
    return error_answer(kind, message, 409 if isinstance(error, NotLearnedError) else 400)


def _described(code: int) -> dict[str, Any]:
    """Return what the description tells of a status: one has the model, the others name it.

    FastAPI makes a validator of each model of each route: 750 for all statuses, 1 s at the start.
    """
    if code == min(_STATUSES):
        return {"description": _STATUSES[code], "model": ErrorReply}
    schema = {"$ref": f"#/components/schemas/{ErrorReply.__name__}"}
    return {"description": _STATUSES[code], "content": {"application/json": {"schema": schema}}}


_STATUSES = {
    400: "The database refuses the request; the message says why.",
    401: "The token is missing or wrong.",
    403: "The request does not come from this page, or the page is read-only.",
    404: "There is no such thing.",
    409: "The database has not learned, or something changed meanwhile.",
    413: "Too large.",
    415: "The content has another type than expected.",
    422: "A parameter is missing or of another type.",
    500: "A fault of the program.",
    503: "Another process holds the database.",
    507: "There is no room on a disk, or in memory.",
}  # Description of each HTTP status of errors, for OpenAPI
ERRORS: dict[int | str, dict[str, Any]] = {code: _described(code) for code in _STATUSES}
"""The errors of every route, for its router."""
