"""Arguments of public verbs, checked by their annotations before any work.

A verb that is :func:`checked` refuses an argument of a wrong type by its name: ``words: expected a
text, found 3 (int).`` What an annotation cannot say, such as the least number, the verb checks
itself. Numbers of NumPy become those of Python, and iterables tuples. Classes are known by their
names alone, so that none is imported to find out that a value is no instance of it.
"""

from __future__ import annotations

import ast
import math
import operator
import os
import reprlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, wraps
from numbers import Integral, Real
from pathlib import Path
from types import FunctionType
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias, TypeVar

from motiondb.errors import QueryError

if TYPE_CHECKING:
    import numpy as np

    from motiondb.records import Clip, Motion

    Example: TypeAlias = str | Path | Clip | Motion

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C")

_ALIASES = {
    "Example": "str | Path | Clip | Motion",
    "Progress": "Callable",
    "SceneProgress": "Callable",
    "FirstMotion": "Callable",
    "IntArray": "ndarray",
    "FloatArray": "ndarray",
}
_SAID = {"Example": "a file, the name of a capture, a motiondb.Clip or a motiondb.Motion"}
_FILLED_IN = ("Settings", "Limits", "Changes", "ActionPlace", "Caption", "Question")
"""Ends of the names of records that users fill in, whose fields are checked too."""
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60


class _MismatchError(Exception):
    """A value that is not of a kind, with what was expected where the kind's name is too little."""

    def __init__(self, value: object, expected: str = "", where: str = "") -> None:
        super().__init__(expected)
        self.value, self.expected, self.where = value, expected, where


@dataclass(frozen=True)
class Kind:
    """What an annotation allows: how a message calls it, and what gives the value to pass on."""

    said: str
    fit: Callable[[Any], Any]


def checked_verbs(of: type[C]) -> type[C]:
    """Check the arguments of all public verbs of a class."""
    for name, member in list(vars(of).items()):
        if name.startswith("_") and name != "__init__":
            continue
        if isinstance(member, FunctionType):
            setattr(of, name, checked(member))
        elif isinstance(member, classmethod | staticmethod):
            setattr(of, name, type(member)(checked(member.__func__)))
    return of


def checked(verb: Callable[P, R]) -> Callable[P, R]:
    """The verb, with its arguments checked by their annotations when it is called.

    Raises
    ------
    QueryError
        When an argument is of another kind, before the verb begins.
    """

    @wraps(verb)
    def door(*args: P.args, **kwargs: P.kwargs) -> R:
        kinds = kinds_of(verb)
        named = {name: _fitted(name, kinds.get(name), value) for name, value in kwargs.items()}
        placed = [_fitted(*kind, value) for kind, value in zip(kinds.items(), args)]
        return verb(*placed, *args[len(placed) :], **named)  # type: ignore[arg-type]  # as given

    return door


@cache
def kinds_of(verb: Callable[..., object]) -> dict[str, Kind | None]:
    """What each argument of a verb may be, in their order; None: anything."""
    code = verb.__code__
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    return {name: _read(verb.__annotations__.get(name)) for name in names}


def check_least(name: str, value: int, least: int) -> None:
    """Refuse a whole number that is smaller than the least."""
    if value < least:
        raise QueryError(f"{name}: expected a whole number from {least} on, found {said(value)}.")


def seeded(seed: int) -> np.random.Generator:
    """A generator of random numbers from the seed of a user."""
    import numpy as np

    check_least("seed", seed, 0)
    return np.random.default_rng(seed)


def seeds_from(seed: int, number: int) -> range:
    """The seeds of some motions: that of the user, and the following ones."""
    check_least("seed", seed, 0)
    return range(seed, seed + number)


def said(value: object) -> str:
    """A value of a user and its type, short enough for a message."""
    kind = type(value).__name__
    if isinstance(value, Path):
        return f"{_SHORT.repr(str(value))} ({kind})"
    if not isinstance(value, str | bytes | int | float | list | tuple | dict | None):
        return kind
    try:
        return f"{_SHORT.repr(value)} ({kind})"
    except ValueError:  # a number of more digits than Python prints
        return kind


def _fitted(name: str, kind: Kind | None, value: object) -> object:
    """The value to pass on, or an error that names the argument."""
    if kind is None:
        return value
    try:
        return kind.fit(value)
    except _MismatchError as wrong:
        advice = " Put it in a list." if kind.said.startswith("a sequence") else ""
        raise QueryError(
            f"{name}{wrong.where}: expected {wrong.expected or kind.said}, found "
            f"{said(wrong.value)}.{advice if isinstance(value, str) else ''}"
        ) from None


def _read(annotation: str | None) -> Kind | None:
    return None if annotation is None else _kind(ast.parse(annotation, mode="eval").body)


def _kind(tree: ast.expr) -> Kind:
    """What a part of an annotation allows."""
    match tree:
        case ast.BinOp(op=ast.BitOr()):
            return _union(_alternatives(tree))
        case ast.Subscript(value=ast.Name(id="Mapping"), slice=ast.Tuple(elts=[key, value])):
            return _mapping(_kind(key), _kind(value))
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=parts)) if not (
            isinstance(parts[-1], ast.Constant)
        ):
            return _tuple([_kind(part) for part in parts])
        case ast.Subscript(value=ast.Name(id="Callable")):
            return _KINDS["Callable"]
        case ast.Subscript(value=ast.Name(id="Annotated"), slice=ast.Tuple(elts=[of, *_])):
            return _kind(of)
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=[each, _])):
            return _sequence(_kind(each))
        case ast.Subscript(value=ast.Name(id="Sequence" | "Iterable" | "Collection"), slice=each):
            return _sequence(_kind(each))
        case ast.Attribute(attr=name) | ast.Name(id=name) | ast.Constant(value=name):
            return _named(str(name))
    raise TypeError(
        f"expected an annotation that values can be checked by, found {ast.unparse(tree)}"
    )


def _alternatives(tree: ast.expr) -> list[ast.expr]:
    if isinstance(tree, ast.BinOp):
        return [*_alternatives(tree.left), *_alternatives(tree.right)]
    return [tree]


def _named(name: str) -> Kind:
    if name in _ALIASES:
        of = _kind(ast.parse(_ALIASES[name], mode="eval").body)
        return Kind(_SAID.get(name, of.said), of.fit)
    return _KINDS.get(name) or _instance(name)


def _union(alternatives: list[ast.expr]) -> Kind:
    """Any of several kinds; beside a path, a text is a path."""
    names = [ast.unparse(each) for each in alternatives]
    if "Path" in names and "str" in names:
        names = ["a path" if name == "Path" else name for name in names if name != "str"]
    kinds = [_TEXT_PATH if name == "a path" else _read(name) for name in names]
    known = [kind for kind in kinds if kind is not None]

    def fit(value: object) -> object:
        deepest = _MismatchError(value)
        for kind in known:
            try:
                return kind.fit(value)
            except _MismatchError as wrong:
                if wrong.expected or wrong.value is not value:
                    deepest = wrong
        raise deepest

    *first, last = [kind.said for kind in known]
    return Kind(f"{', '.join(first)} or {last}", fit)


def _sequence(each: Kind) -> Kind:
    def fit(value: object) -> object:
        if isinstance(value, str | bytes) or not isinstance(value, Iterable):
            raise _MismatchError(value)
        return tuple(each.fit(one) for one in value)

    return Kind(f"a sequence, each {each.said}", fit)


def _tuple(parts: list[Kind]) -> Kind:
    def fit(value: object) -> object:
        if not isinstance(value, list | tuple) or len(value) != len(parts):
            raise _MismatchError(value)
        return tuple(kind.fit(one) for kind, one in zip(parts, value))

    return Kind(f"{len(parts)} values ({', '.join(kind.said for kind in parts)})", fit)


def _mapping(key: Kind, each: Kind) -> Kind:
    def fit(value: object) -> object:
        if not isinstance(value, Mapping):
            raise _MismatchError(value)
        return {key.fit(name): each.fit(one) for name, one in value.items()}

    return Kind(f"a mapping from {key.said} to {each.said}", fit)


def _instance(name: str) -> Kind:
    """An instance of a class of this name; of a record that users fill in, the fields too."""

    def fit(value: object) -> object:
        if all(each.__name__ != name for each in type(value).__mro__):
            raise _MismatchError(value)
        if name.endswith(_FILLED_IN) and is_dataclass(value):
            for field in fields(value):
                try:
                    _kind_of_field(str(field.type)).fit(getattr(value, field.name))
                except _MismatchError as wrong:
                    expected = wrong.expected or _kind_of_field(str(field.type)).said
                    where = f".{field.name}{wrong.where}"
                    raise _MismatchError(wrong.value, expected, where) from None
        return value

    return Kind(f"a motiondb.{name}", fit)


@cache
def _kind_of_field(annotation: str) -> Kind:
    return _kind(ast.parse(annotation, mode="eval").body)


def _text(value: object) -> object:
    if not isinstance(value, str):
        raise _MismatchError(value)
    try:
        value.encode()
    except UnicodeEncodeError:
        raise _MismatchError(value, "a text that UTF-8 can write") from None
    return value


def _text_path(value: object) -> str | Path:
    """A path, or the text of one; the bytes of a file's name need not be UTF-8."""
    if not isinstance(value, str | Path):
        raise _MismatchError(value)
    try:
        holds_nul = b"\0" in os.fsencode(value)
    except UnicodeEncodeError:
        holds_nul = True
    if holds_nul:
        raise _MismatchError(value, "a path that files can have")
    return value


def _path(value: object) -> object:
    return Path(_text_path(value))


def _whole(value: object) -> object:
    if not isinstance(value, Integral):
        raise _MismatchError(value)
    if not -(2**63) <= (number := operator.index(value)) < 2**63:
        raise _MismatchError(value, "a whole number of at most 64 bits")
    return number


def _number(value: object) -> object:
    if not isinstance(value, Real):
        raise _MismatchError(value)
    try:
        number = float(value)
    except OverflowError:
        number = math.nan
    if math.isnan(number):
        raise _MismatchError(value)
    return value if isinstance(value, int) and abs(value) < 2**53 else number


def _truth(value: object) -> object:
    if type(value).__name__ not in ("bool", "bool_"):  # bool_: NumPy before 2
        raise _MismatchError(value)
    return bool(value)


def _nothing(value: object) -> object:
    if value is not None:
        raise _MismatchError(value)
    return value


def _made(value: object) -> object:
    """What has a motion and the origin of its frames, as the protocol ``Made`` says."""
    if not (hasattr(value, "motion") and hasattr(value, "provenance")):
        raise _MismatchError(value)
    return value


def _called(value: object) -> object:
    if not callable(value):
        raise _MismatchError(value)
    return value


_TEXT_PATH = Kind("a path", _text_path)
_KINDS = {
    "None": Kind("None", _nothing),
    "str": Kind("a text", _text),
    "Path": Kind("a path", _path),
    "int": Kind("a whole number", _whole),
    "float": Kind("a number", _number),
    "bool": Kind("True or False", _truth),
    "Made": Kind("a generated motion", _made),
    "Callable": Kind("a function", _called),
    "object": Kind("anything", lambda value: value),
    "bytes": Kind("bytes", _instance("bytes").fit),
    "ndarray": Kind("an array", _instance("ndarray").fit),
}
