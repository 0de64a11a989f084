"""Frozen records as values by name, and back: one walk over their fields and types.

The database keeps what was learned, and a file keeps knowledge, as arrays and texts by name. The
name of a value is its path: ``taught.moments.gram``. By the type of a field,

=============================  =====================================================================
an array                       is itself, of a symmetric matrix the upper triangle, row by row
a number                       is an array without axes
a mapping from integers or     is one array, a row (*key, number) for each; if to arrays or
tuples of them to a number     tuples, three: ``.keys``, ``.sizes`` (shapes) and ``.values`` (all
                               numbers, end to end)
a record                       is its fields
anything else                  is a text in JSON
=============================  =====================================================================

A field that is None has no values. Axes and ranges are declared beside the types
(``motiondb.records``).
"""

from __future__ import annotations

import json
import types
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from itertools import pairwise
from math import isqrt
from typing import Annotated, Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from motiondb.records import Axes, FloatArray, MayBeUnknown, Sizes, Within

Value = FloatArray | str
Values = Mapping[str, Value]
_R = TypeVar("_R")
_Any = Any  # A value, or a type, of which nothing is known but at run time


@dataclass(frozen=True)
class Hint:
    """The type of a field, taken apart."""

    kind: Any  # The type without None and declarations
    declared: tuple[object, ...]  # Declarations beside the type
    is_optional: bool  # Whether the field may be None

    @property
    def is_record(self) -> bool:
        """Whether the field is a record itself."""
        return is_dataclass(self.kind)

    @property
    def numbers(self) -> tuple[Any, Any] | None:
        """Types of the keys and values of a mapping from integers or tuples of them, else None."""
        origin, arguments = get_origin(self.kind), get_args(self.kind)
        if origin is Counter:
            arguments = (*arguments, int)
        if len(arguments) != 2 or not issubclass(origin, Mapping) or arguments[0] is str:
            return None
        return arguments

    @property
    def is_symmetric(self) -> bool:
        """Whether the field is a matrix of which one half is stored."""
        return any(isinstance(one, Axes) and one.symmetric for one in self.declared)


def to_values(
    record: object, kind: _Any = None, name: str = "", without: Collection[str] = ()
) -> dict[str, Value]:
    """Values of a record by name, but not those of the fields ``without``."""
    return dict(_values(record, _hint(kind or type(record)), name, without))


def from_values(
    kind: type[_R], values: Values, name: str = "", given: Mapping[str, Any] | None = None
) -> _R:
    """The record of a type from its values, and from fields that are given by their names."""
    return cast(_R, _record(_hint(kind), values, name, given or {}))


def triangle(matrix: FloatArray) -> FloatArray:
    """The upper triangle of a square matrix, row by row; :func:`square` is the inverse."""
    return np.asarray(matrix[np.triu_indices(len(matrix))])


def square(half: FloatArray) -> FloatArray:
    """The symmetric matrix with an upper triangle."""
    n = (isqrt(8 * len(half) + 1) - 1) // 2
    matrix = np.zeros((n, n))
    matrix[np.triu_indices(n)] = half
    return matrix + np.triu(matrix, 1).T


@dataclass(frozen=True)
class DeclaredArray:
    """What is known of an array of a type of records before there is one."""

    name: str
    shape: tuple[int | str | None, ...]  # Sizes, or names of sizes; None stands for any
    is_symmetric: bool = False
    sizes: Mapping[str, int] | None = None  # Sizes by name that hold for this array alone
    within: Within | None = None
    may_be_unknown: bool = False
    optional: str = ""  # Name of the record above it that may be None


def declared_arrays(kind: _Any, without: Collection[str] = ()) -> list[DeclaredArray]:
    """The arrays that a record of a type may have."""
    return list(_declared(_hint(kind), "", without, "", None))


def _values(
    value: _Any, hint: Hint, name: str, without: Collection[str]
) -> Iterator[tuple[str, Value]]:
    if value is None or name in without:
        return
    if hint.is_record:
        for field, inner in _fields(hint.kind):
            yield from _values(getattr(value, field), inner, _below(name, field), without)
    elif get_origin(hint.kind) is np.ndarray or hint.kind in (int, float):
        array = np.asarray(value, dtype=np.float64)
        yield name, triangle(array) if hint.is_symmetric else array
    elif hint.numbers is None:
        yield name, json.dumps(value if isinstance(value, (str, tuple)) else dict(value))
    elif hint.numbers[1] is int:
        rows = [(*_as_tuple(key), number) for key, number in sorted(value.items())]
        yield name, np.array(rows, dtype=float).reshape(len(rows), _width(hint.numbers[0]) + 1)
    else:
        arrays = {_as_tuple(key): np.asarray(one, float) for key, one in sorted(value.items())}
        n, flat = len(arrays), [np.zeros(0), *(one.ravel() for one in arrays.values())]
        sizes = [one.shape for one in arrays.values()]
        yield f"{name}.keys", np.array(list(arrays), dtype=float).reshape(n, -1 if n else 0)
        yield f"{name}.sizes", np.array(sizes, dtype=float).reshape(n, -1 if n else 0)
        yield f"{name}.values", np.concatenate(flat)


def _record(hint: Hint, values: Values, name: str, given: Mapping[str, Any]) -> _Any:
    if name in given:
        return given[name]
    if hint.is_optional and not any(one == name or one.startswith(name + ".") for one in values):
        return None
    if hint.is_record:
        parts = {
            field: _record(inner, values, _below(name, field), given)
            for field, inner in _fields(hint.kind)
        }
        return hint.kind(**parts)
    if get_origin(hint.kind) is np.ndarray:
        array = np.asarray(values[name])
        dtype = get_args(get_args(hint.kind)[1])[0]
        return (square(array) if hint.is_symmetric else array).astype(dtype, copy=False)
    if hint.kind in (int, float):
        return hint.kind(values[name])
    if hint.numbers is None:
        read = json.loads(str(values[name]))
        return tuple(read) if isinstance(read, list) else read
    return _mapping(hint, values, name)


def _mapping(hint: Hint, values: Values, name: str) -> Mapping[Any, Any]:
    assert hint.numbers is not None
    of_keys, of_values = hint.numbers
    made = Counter if get_origin(hint.kind) is Counter else dict
    if of_values is int:
        rows = np.asarray(values[name]).astype(np.int64).tolist()
        return made({_as_key(key, of_keys): number for *key, number in rows})
    keys = [_as_key(key, of_keys) for key in np.asarray(values[f"{name}.keys"], int).tolist()]
    if not keys:
        return {}
    shapes = np.asarray(values[f"{name}.sizes"], int)
    flat = np.asarray(values[f"{name}.values"])
    bounds = pairwise([0, *np.cumsum(shapes.prod(axis=1)).tolist()])
    if get_origin(of_values) is tuple:
        numbers = flat.astype(np.int64).tolist()
        return {key: tuple(numbers[a:b]) for key, (a, b) in zip(keys, bounds)}
    return {
        key: flat[a:b].reshape(shape) for key, (a, b), shape in zip(keys, bounds, shapes.tolist())
    }


def _declared(
    hint: Hint,
    name: str,
    without: Collection[str],
    optional: str,
    sizes: Mapping[str, int] | None,
) -> Iterator[DeclaredArray]:
    if name in without:
        return
    above = name if hint.is_optional else optional
    bound = next((one.by_name for one in hint.declared if isinstance(one, Sizes)), sizes)
    if hint.is_record:
        for field, inner in _fields(hint.kind):
            yield from _declared(inner, _below(name, field), without, above, bound)
    elif get_origin(hint.kind) is np.ndarray or hint.kind in (int, float):
        axes = next((one for one in hint.declared if isinstance(one, Axes)), Axes())
        within = next((one for one in hint.declared if isinstance(one, Within)), None)
        unknown = any(one is MayBeUnknown for one in hint.declared)
        yield DeclaredArray(name, axes.sizes, axes.symmetric, bound, within, unknown, above)
    elif hint.numbers is not None and hint.numbers[1] is int:
        yield DeclaredArray(name, (None, _width(hint.numbers[0]) + 1), optional=above)
    elif hint.numbers is not None:
        yield DeclaredArray(f"{name}.keys", (None, None), optional=above)
        yield DeclaredArray(f"{name}.sizes", (None, None), optional=above)
        yield DeclaredArray(f"{name}.values", (None,), optional=above)


@cache
def _fields(kind: _Any) -> tuple[tuple[str, Hint], ...]:
    hints = get_type_hints(kind, include_extras=True)
    return tuple((field.name, _hint(hints[field.name])) for field in fields(kind))


def _hint(kind: _Any) -> Hint:
    declared: tuple[object, ...] = ()
    is_optional = False
    while True:
        if get_origin(kind) is Annotated:
            kind, *more = get_args(kind)
            declared = (*declared, *more)
        elif get_origin(kind) in (Union, types.UnionType):
            (kind,) = (one for one in get_args(kind) if one is not types.NoneType)
            is_optional = True
        else:
            return Hint(kind, declared, is_optional)


def _below(name: str, field: str) -> str:
    return f"{name}.{field}" if name else field


def _as_tuple(key: int | tuple[int, ...]) -> tuple[int, ...]:
    return key if isinstance(key, tuple) else (key,)


def _as_key(numbers: list[int], kind: _Any) -> int | tuple[int, ...]:
    return tuple(numbers) if get_origin(kind) is tuple else numbers[0]


def _width(kind: _Any) -> int:
    return len(get_args(kind)) or 1
