"""Filters on the catalogue: ``performer=14 and duration>2.5``.

    filter      condition {"and" condition}
    condition   name operator value
    operator    = != < <= > >= ~            ~ asks whether the value stands within
    value       text up to the next "and", or anything in quotes

A name is a column of the catalogue or a tag. Two values are compared as numbers when both are
numbers, otherwise as text without regard to case. A capture without the tag answers only to !=.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

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
)
"""The columns of the catalogue that a filter can name; they win over tags of the same name."""

_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_CONDITION = re.compile(
    r"""\s*(?P<name>[^=!<>~"']+?)\s*(?P<operator>!=|<=|>=|==|=|<|>|~)\s*
        (?P<value>"[^"]*"|'[^']*'|[^=!<>~"']+?)\s*(?P<end>\band\b|$)""",
    re.VERBOSE | re.IGNORECASE,
)


@dataclass(frozen=True)
class Condition:
    """One comparison of a filter: ``name operator value``."""

    name: str
    operator: str
    value: str


def parse_where(text: str) -> tuple[Condition, ...]:
    """The conditions of a filter, all of which must hold; none for an empty text.

    >>> parse_where("performer=14 and words ~ 'walk and turn'")[1].value
    'walk and turn'

    Raises
    ------
    QueryError : shows how a filter looks.
    """
    conditions: list[Condition] = []
    place = 0
    ended = not text.strip()
    while not ended:
        match = _CONDITION.match(text, place)
        if match is None:
            raise QueryError(
                f"filter {text!r}: expected NAME OPERATOR VALUE with one of = != < <= > >= ~, "
                f"found {text[place:].strip() or 'nothing'!r}. "
                "Write for example: performer=14 and duration>2.5."
            )
        value = match["value"]
        value = value[1:-1] if value[0] in "\"'" else value
        sign = "=" if match["operator"] == "==" else match["operator"]
        conditions.append(Condition(match["name"], sign, value))
        place, ended = match.end(), not match["end"]
    return tuple(conditions)


def check_names(conditions: Iterable[Condition], tags: Iterable[str]) -> None:
    """Refuse a filter that names neither a column nor one of the ``tags`` in use.

    Raises
    ------
    QueryError : suggests the nearest names.
    """
    known = (*COLUMNS, *sorted(set(tags) - set(COLUMNS)))
    for condition in conditions:
        if condition.name not in known:
            raise QueryError(
                f"filter on {condition.name!r}: expected one of {', '.join(known)}, found no such "
                f"column or tag.{suggestion(condition.name, known)}"
            )


def matches(info: CaptureInfo, conditions: Sequence[Condition]) -> bool:
    """Whether a capture fulfils all conditions."""
    return all(_holds(_value(info, condition.name), condition) for condition in conditions)


def _value(info: CaptureInfo, name: str) -> str | None:
    return str(getattr(info, name)) if name in COLUMNS else info.tags.get(name)


def _holds(found: str | None, condition: Condition) -> bool:
    if found is None:
        return condition.operator == "!="
    if condition.operator == "~":
        return condition.value.casefold() in found.casefold()
    compare = _COMPARE[condition.operator]
    left, right = _number(found), _number(condition.value)
    if left is not None and right is not None:
        return compare(left, right)
    return compare(found.casefold(), condition.value.casefold())


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
