"""Values of Python as values that JSON has."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

Answer = TypeVar("Answer")
OPTIONAL = {"json": "optional"}  # Metadata of a field that is no key where it is None
_MISSING = object()
SPREAD = {"json": "spread"}  # Of a field with a mapping whose keys stand among the answer's


def extended(kind: type[Answer], base: object, /, **more: object) -> Answer:
    """Return a record of a kind: ``more``, and all else that another one has of the same name."""
    names = {field.name for field in fields(cast(Any, kind))} - more.keys()
    given = {name: getattr(base, name, _MISSING) for name in names}
    return kind(**{name: value for name, value in given.items() if value is not _MISSING} | more)


def to_json(value: object) -> Any:  # noqa: ANN401  a value of any type that JSON has
    """Convert a value to types that JSON has; numbers that are not finite become null.

    Parameters
    ----------
    value : object
        A dataclass, a mapping, an array, a path, a number, a text, or a sequence of these. The
        names of a dataclass's fields are the keys, without the underscore of ``from_``; see also
        :data:`OPTIONAL` and :data:`SPREAD`.

    Examples
    --------
    >>> import numpy as np
    >>> to_json({"a": np.float32(0.5), "b": (1, float("nan"))})
    {'a': 0.5, 'b': [1, None]}
    """
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return to_json(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): to_json(item) for key, item in value.items()}
    if is_dataclass(value):
        facts: dict[str, Any] = {}
        for f in fields(value):
            item = to_json(getattr(value, f.name))
            if f.metadata == SPREAD:
                facts |= item
            elif item is not None or f.metadata != OPTIONAL:
                facts[f.name.rstrip("_")] = item
        return facts
    if isinstance(value, Path):
        return str(value)
    return [to_json(item) for item in cast("Iterable[object]", value)]
