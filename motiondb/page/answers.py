"""Answers and errors as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
from starlette.responses import Response

from motiondb.errors import HeldError, MotionDBError, NotLearnedError

Json: TypeAlias = Any  # A value of a type that JSON has


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


def to_json(value: object) -> Json:
    """Convert a value to types that JSON has; numbers that are not finite become null.

    >>> to_json({"a": np.float32(0.5), "b": (1, float("nan"))})
    {'a': 0.5, 'b': [1, None]}
    """
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return to_json(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): to_json(item) for key, item in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return to_json(asdict(value))
    if isinstance(value, Path):
        return str(value)
    return [to_json(item) for item in cast("Iterable[object]", value)]


class Answer(Response):
    """A response whose body is a value as JSON."""

    media_type = "application/json"

    def render(self, content: object) -> bytes:
        """Return a value as JSON in UTF-8."""
        text = json.dumps(to_json(content), ensure_ascii=False, allow_nan=False)
        return text.encode("utf-8", "replace")  # names may hold lone surrogates


def error_answer(kind: str, message: str, status: int) -> Answer:
    """Return an error in the form that all errors of the page have."""
    headers = {"Retry-After": "1"} if status == 503 else None
    facts = {"error": {"kind": kind, "message": message, "status": status}}
    return Answer(facts, status, headers)


def answer_of(error: MotionDBError, shown: Callable[[str], str] = str) -> Answer:
    """Return the answer for an error of :class:`motiondb.MotionDB`."""
    kind, message = type(error).__name__, shown(str(error))
    if isinstance(error, PageError):
        return error_answer(error.kind, message, error.status)
    if isinstance(error, HeldError) or kind == "OtherModeError":
        return error_answer("HeldError", message, 503)
    return error_answer(kind, message, 409 if isinstance(error, NotLearnedError) else 400)
