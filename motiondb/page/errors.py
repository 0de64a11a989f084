"""Errors of the page, and all errors as JSON."""

from __future__ import annotations

import errno
import json
from collections.abc import Callable
from dataclasses import dataclass

from starlette.responses import Response

from motiondb.answers.plain import to_json
from motiondb.errors import HeldError, MotionDBError, NotLearnedError

FULL_DISK = (errno.ENOSPC, errno.EDQUOT)
"""Numbers of the errors that say that nothing more can be written."""


class PageError(MotionDBError):
    """An error that the page raises itself, with the HTTP status of its answer."""

    def __init__(self, message: str, status: int = 400, kind: str = "RequestError") -> None:
        super().__init__(message)
        self.status, self.kind = status, kind


def unknown(what: str, name: str, advice: str = "") -> PageError:
    """Return the error, with status 404, for something that the server does not have."""
    shown = name if len(name) <= 200 else f"{name[:200]}..."
    return PageError(
        f"{what}: expected an existing one, found {shown!r}. {advice}".strip(),
        404,
        "UnknownError",
    )


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
