"""JSON from outside: bounded, finite, in UTF-8, and of the shape that its type declares.

``json`` reads more than the standard allows, and more than a program can carry: NaN and Infinity,
lone surrogates (letters that no encoding has, so that the text cannot be written again), lists
within lists until the stack ends. :func:`parse_json` refuses all of these. :func:`to_record` makes
the records of :mod:`dataclasses` of what was read, and refuses other fields and other types.
"""

from __future__ import annotations

import json
import math
import types
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from itertools import chain
from typing import Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from motiondb.files.safe_files import MOST_TEXT
from motiondb.files.text import quoted
from motiondb.records import FloatArray

MOST_DEPTH = 50
"""Lists and objects within one another. What motiondb writes has 6 at most."""
_T = TypeVar("_T")
_Any = Any  # A value, or a type, of which nothing is known but at run time
_NAMES = {
    type(None): "null",
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "a text",
    list: "a list",
    dict: "an object",
}


class JSONError(ValueError):
    """Why a text is not the JSON that was expected: ``expected X, found Y``, without the place."""

    def __init__(self, expected: str, actual: str, line: int | None = None) -> None:
        super().__init__(f"expected {expected}, found {actual}")
        self.line = line


def parse_json(
    text: str | bytes, most: int = MOST_TEXT, number: Callable[[str], float] | None = None
) -> _Any:
    """The value of a JSON text of at most `most` bytes; `number` makes every number of its text."""
    if len(text) > most:
        raise JSONError(f"at most {most / 1e6:g} MB of JSON", f"{len(text) / 1e6:.4g} MB")
    hooks: dict[str, Any] = {"parse_constant": _refuse_constant}
    if number is not None:
        hooks = {"parse_int": number, "parse_float": number}
    try:
        value = json.loads(text.decode("utf-8-sig") if isinstance(text, bytes) else text, **hooks)
    except UnicodeDecodeError:
        raise JSONError("JSON in UTF-8", "other bytes") from None
    except json.JSONDecodeError as error:
        raise JSONError("JSON", f"a fault: {error.msg}", error.lineno) from None
    except RecursionError:
        raise _too_deep() from None
    except JSONError:
        raise
    except ValueError:  # a whole number of thousands of digits
        raise JSONError("numbers of a usual length", "one that is too long") from None
    _check_values(value, is_finite_asked=number is None)
    return value


def _refuse_constant(name: str) -> float:
    raise JSONError("finite numbers", name)


def _too_deep() -> JSONError:
    return JSONError(f"at most {MOST_DEPTH} lists and objects within one another", "more")


def _check_values(value: object, is_finite_asked: bool) -> None:
    """Refuse deep nesting, lone surrogates and numbers beyond the largest, without recursion."""
    left: list[tuple[Iterable[object], int]] = [([value], 0)]
    while left:
        items, depth = left.pop()
        if depth > MOST_DEPTH:
            raise _too_deep()
        for item in items:
            if isinstance(item, float):
                if is_finite_asked and not math.isfinite(item):
                    raise JSONError("finite numbers", "one beyond the largest")
            elif isinstance(item, str):
                if not item.isascii() and any("\ud800" <= letter <= "\udfff" for letter in item):
                    raise JSONError("text that UTF-8 can hold", "half of a surrogate pair")
            elif isinstance(item, list):
                left.append((item, depth + 1))
            elif isinstance(item, dict):
                left.append((chain(item, item.values()), depth + 1))


def to_record(kind: type[_T], value: object, name: str = "") -> _T:
    """Return a value of JSON as a dataclass, whose fields and types it must have.

    Fields with a default may be missing. A list becomes a tuple, a whole number a float, where the
    type asks for one; ``Any`` takes every value.
    """
    return cast(_T, _of_kind(kind, value, name))


def _of_kind(kind: _Any, value: _Any, name: str) -> _Any:
    origin, arguments = get_origin(kind), get_args(kind)
    if kind in (Any, object):
        return value
    if origin in (Union, types.UnionType):
        (rest,) = (one for one in arguments if one is not types.NoneType)
        return None if value is None else _of_kind(rest, value, name)
    if origin is np.ndarray:
        return _to_array(value, name)
    if is_dataclass(kind):
        return _to_dataclass(kind, value, name)
    if origin is tuple:
        return _to_tuple(arguments, value, name)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        if not isinstance(value, dict):
            raise _fault(name, dict, value)
        return {key: _of_kind(arguments[1], v, _below(name, key)) for key, v in value.items()}
    if kind is float and type(value) is int:
        return _to_float(value, name)
    if type(value) is not kind:
        raise _fault(name, kind, value)
    return value


def _to_tuple(kinds: tuple[Any, ...], value: object, name: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise _fault(name, list, value)
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(value) != len(kinds):
        raise JSONError(f"{len(kinds)} values{_at(name)}", str(len(value)))
    return tuple(
        _of_kind(kind, one, f"{name}[{n}]") for n, (kind, one) in enumerate(zip(kinds, value))
    )


def _to_float(value: int, name: str) -> float:
    try:
        return float(value)
    except OverflowError:
        raise JSONError(f"a number{_at(name)}", "one that is too large") from None


def _to_array(value: object, name: str) -> FloatArray:
    try:
        return np.array(value, dtype=float)
    except (ValueError, TypeError, OverflowError):
        raise JSONError(f"a table of numbers{_at(name)}", "something else") from None


def _to_dataclass(kind: _Any, value: object, name: str) -> _Any:
    if not isinstance(value, dict):
        raise _fault(name, dict, value)
    declared = {field.name: field for field in fields(kind)}
    unknown = next((key for key in value if key not in declared), None)
    if unknown is not None:
        raise JSONError(f"the fields {', '.join(declared)}{_at(name)}", quoted(unknown))
    missing = next(
        (
            key
            for key, field in declared.items()
            if key not in value and field.default is MISSING and field.default_factory is MISSING
        ),
        None,
    )
    if missing is not None:
        raise JSONError(f"a field {missing!r}{_at(name)}", "none")
    hints = _hints(kind)
    return kind(**{key: _of_kind(hints[key], v, _below(name, key)) for key, v in value.items()})


@cache
def _hints(kind: _Any) -> Mapping[str, Any]:
    return get_type_hints(kind)


def _fault(name: str, kind: _Any, value: object) -> JSONError:
    return JSONError(f"{_NAMES[kind]}{_at(name)}", _NAMES[type(value)])


def _at(name: str) -> str:
    return f" for {name}" if name else ""


def _below(name: str, key: str) -> str:
    return f"{name}.{key}" if name else key
