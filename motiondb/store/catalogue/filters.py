"""Nodes of a parsed filter on the catalogue, and the test whether a capture satisfies them.

:mod:`motiondb.store.catalogue.where` parses the text of a filter into these nodes.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from motiondb.errors import QueryError, suggestion
from motiondb.records import CaptureInfo

COLUMNS = (
    "capture_id",
    "name",
    "sha256",
    "format",
    "kind",
    "fps",
    "n_frames",
    "duration",
    "motion_frames",
    "leg_length",
    "path",
    "run_id",
)  # Columns of the catalogue that a filter can name. They override tags of the same name
CAPTION = "caption"
"""Name that stands for the captions in a filter. It overrides a tag of the same name."""

_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@dataclass(frozen=True)
class Condition:
    """One comparison of a filter: ``name operator value``."""

    name: str  # Name of a column or tag, or ``CAPTION``
    operator: str  # One of ``=``, ``!=``, ``<``, ``<=``, ``>``, ``>=``, ``~`` (contains) and ``!~``
    value: str  # The value to compare with


@dataclass(frozen=True)
class OneOf:
    """A disjunction: at least one alternative must hold."""

    # The filters of each alternative; these must all hold
    alternatives: tuple[tuple[Filter, ...], ...]


@dataclass(frozen=True)
class NoneOf:
    """A negation: the filters must not all hold."""

    filters: tuple[Filter, ...]


Filter: TypeAlias = Condition | OneOf | NoneOf


def conditions_of(filters: Iterable[Filter]) -> Iterator[Condition]:
    """Yield every comparison of some filters, from left to right."""
    for each in filters:
        if isinstance(each, Condition):
            yield each
        elif isinstance(each, NoneOf):
            yield from conditions_of(each.filters)
        else:
            yield from conditions_of(f for alternative in each.alternatives for f in alternative)


def check_names(filters: Iterable[Filter], tags: Iterable[str]) -> None:
    """Check that filters name only columns, ``CAPTION`` and tags in use."""
    named = (*COLUMNS, CAPTION)
    known = (*named, *sorted(set(tags) - set(named)))
    for condition in conditions_of(filters):
        if condition.name not in known:
            raise QueryError(
                f"filter on {condition.name!r}: expected one of {', '.join(known)}, found no such "
                f"column or tag.{suggestion(condition.name, known)}"
            )


def asks_captions(filters: Iterable[Filter]) -> bool:
    """Whether any of the filters tests captions."""
    return any(condition.name == CAPTION for condition in conditions_of(filters))


def matches(info: CaptureInfo, filters: Sequence[Filter], captions: Sequence[str] = ()) -> bool:
    """Whether a capture satisfies all filters."""
    return all(_fulfils(info, each, captions) for each in filters)


def _fulfils(info: CaptureInfo, each: Filter, captions: Sequence[str]) -> bool:
    if isinstance(each, Condition):
        return _holds(_values(info, each.name, captions), each)
    if isinstance(each, NoneOf):
        return not matches(info, each.filters, captions)
    return any(matches(info, alternative, captions) for alternative in each.alternatives)


def _values(info: CaptureInfo, name: str, captions: Sequence[str]) -> Sequence[str]:
    if name in COLUMNS:
        return (str(getattr(info, name)),)
    if name == CAPTION:
        return captions
    return (info.tags[name],) if name in info.tags else ()


def _holds(values: Sequence[str], condition: Condition) -> bool:
    if condition.operator.startswith("!"):
        opposite = Condition(
            condition.name, {"!=": "=", "!~": "~"}[condition.operator], condition.value
        )
        return not _holds(values, opposite)
    return any(_compare(value, condition) for value in values)


def _compare(value: str, condition: Condition) -> bool:
    if condition.operator == "~":
        return condition.value.casefold() in value.casefold()
    compare = _COMPARE[condition.operator]
    left, right = _number(value), _number(condition.value)
    if left is not None and right is not None:
        return compare(left, right)
    return compare(value.casefold(), condition.value.casefold())


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
