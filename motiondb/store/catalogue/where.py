"""Parser of filters on the catalogue.

An example is ``performer in (14, 16) and not (duration<2.5 or caption~walk)``. The syntax is::

    filter      all {"or" all}
    all         single {"and" single}
    single      "not" single | "(" filter ")" | condition
    condition   name operator value | name ["not"] "in" "(" value {"," value} ")" | "needs"
    operator    = != < <= > >= ~ !~         ~ means that the text contains the value
    value       text up to the next "and", "or" or closing parenthesis, or anything in quotes
                (in which a quote is written twice)

A name is a column of the catalogue, ``caption`` (the texts that people wrote about the capture), a
tag (in quotes where it is like a word of the syntax: ``"in"=yes``), or a head of the catalogue's
table where no tag has this name (``HEADS``). So are ``quality``, the mean of the numbers of a
capture's seconds, and ``finding``, the kinds and families of what it lacks; ``needs`` alone is
``finding=needs``. ``selection`` stands for the names of all selections that hold something of the
capture. Two values are compared as numbers if both are
numbers, and otherwise as text without regard to case; ``~`` always compares text.

A condition on captions holds if it holds for at least one caption of the capture. With ``!=``,
``!~`` or ``not in`` it holds if no caption equals (or contains) the value. If a capture lacks the
tag, or has no captions, only conditions with ``!=``, ``!~`` or ``not in`` hold for it.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

from motiondb.errors import QueryError, suggestion
from motiondb.records import CaptureInfo
from motiondb.store.catalogue.selections import SELECTION, read_selections

COLUMNS = tuple(each.name for each in fields(CaptureInfo) if each.name not in ("tags", "notes"))
"""Columns of the catalogue that a filter can name. They override tags of the same name."""
CAPTION = "caption"
"""Name that stands for the captions in a filter. It overrides a tag of the same name."""
HEADS = {"capture": "name", "length": "duration", "words": CAPTION, "frames": "n_frames"}
"""Heads that the table of captures has over its columns, with the names of the columns. A tag of
the same name goes before them."""

FINDING = "finding"
MEASURED = {"quality": "//quality", FINDING: "//finding"}
"""Names for what ``quality`` found, with those that conditions have where no tag is called so."""
NOTHING: Mapping[str, Sequence[str]] = {}  # Of a capture of which nothing was asked
_ALONE = ("needs",)  # Values of ``finding`` that are conditions by themselves

_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


MOST_CHARACTERS = 100_000  # Of a filter; a list of a thousand captures has about 20,000
MOST_DEPTH = 50  # Most parentheses and negations within one another

_TOKEN = re.compile(
    r"""(?P<quoted>"(?:[^"]|"")*"|'(?:[^']|'')*')|(?P<operator>!=|!~|<=|>=|==|=|<|>|~)
        |(?P<sign>[(),])|(?P<word>[^\s=!<>~"'(),]+)|(?P<other>[!"'])""",
    re.VERBOSE,
)


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


def parse_where(text: str) -> tuple[Filter, ...]:
    """Parse the text of a filter.

    >>> parse_where("performer=14 and words ~ 'walk and turn'")[1].value
    'walk and turn'
    >>> parse_where("not performer in (14, 16)")[0].filters[0].alternatives[1]
    (Condition(name='performer', operator='=', value='16'),)
    """
    if len(text) > MOST_CHARACTERS:
        raise QueryError(
            f"filter: expected at most {MOST_CHARACTERS:,} characters, found {len(text):,}. "
            "Ask for less at a time."
        )
    reader = _Reader(text)
    if not reader.tokens:
        if text.strip():
            raise reader.refusal(0)
        return ()
    filters = reader.one_of(0)
    if reader.place < len(reader.tokens):
        raise QueryError(
            f"filter {_short(text)!r}: expected '(' before ')', found none. Leave out ')', or put "
            "the value into quotes."
        )
    return filters


def _short(text: str) -> str:
    return text if len(text) <= 200 else f"{text[:197]}..."


class _Reader:
    """Recursive-descent parser over the tokens of a filter.

    It keeps the index of the next token, ``place``. There is one method for each rule of the
    syntax (see the module).
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = list(_TOKEN.finditer(text))
        self.place = 0

    def next(self, offset: int = 0) -> str:
        """Return the token at an offset from the next one, "" after the end."""
        place = self.place + offset
        return self.tokens[place].group() if place < len(self.tokens) else ""

    def kind(self, offset: int = 0) -> str:
        """Return the kind of that token, "end" after the end."""
        place = self.place + offset
        return str(self.tokens[place].lastgroup) if place < len(self.tokens) else "end"

    def says(self, *words: str, offset: int = 0) -> bool:
        """Whether that token is one of ``words``, in any case and without quotes."""
        return self.kind(offset) == "word" and self.next(offset).lower() in words

    def refusal(self, place: int) -> QueryError:
        """Return the error that no condition could be read from the token at ``place``."""
        rest = self.text[self.tokens[place].start() :] if place < len(self.tokens) else ""
        return QueryError(
            f"filter {_short(self.text)!r}: expected NAME OPERATOR VALUE with one of "
            f"= != < <= > >= ~, found {_short(rest.strip() or 'nothing')!r}. "
            "Write for example: performer=14 and duration>2.5."
        )

    def one_of(self, depth: int) -> tuple[Filter, ...]:
        """Parse ``filter``: filters that must all hold, or one ``OneOf`` if there is an "or"."""
        if depth > MOST_DEPTH:
            raise QueryError(
                f"filter {_short(self.text)!r}: expected at most {MOST_DEPTH} parentheses and "
                "negations within one another, found more. Ask for less at a time."
            )
        alternatives = [self.all_of(depth)]
        while self.says("or"):
            self.place += 1
            alternatives.append(self.all_of(depth))
        return alternatives[0] if len(alternatives) == 1 else (OneOf(tuple(alternatives)),)

    def all_of(self, depth: int) -> tuple[Filter, ...]:
        """Parse ``all``: filters joined by "and"."""
        filters = list(self.single(depth))
        while self.says("and"):
            self.place += 1
            filters.extend(self.single(depth))
        return tuple(filters)

    def single(self, depth: int) -> tuple[Filter, ...]:
        """Parse ``single``: a negation, a group in parentheses, or a condition."""
        if self.says("not") and (self.kind(1) in ("word", "quoted") or self.next(1) == "("):
            self.place += 1
            if depth >= MOST_DEPTH:
                return self.one_of(depth + 1)  # raises QueryError
            return (NoneOf(self.single(depth + 1)),)
        if self.next() != "(":
            return (self.condition(),)
        self.place += 1
        filters = self.one_of(depth + 1)
        if self.next() != ")":
            raise QueryError(
                f"filter {_short(self.text)!r}: expected ')' for every '(', found "
                f"{_short(self.next()) or 'the end'!r}. Close the parentheses."
            )
        self.place += 1
        return filters

    def condition(self) -> Filter:
        """Parse ``condition``: a comparison, or a name and the list of its values."""
        start = self.place
        is_quoted = self.kind() == "quoted"
        if self.says(*_ALONE) and (
            self.kind(1) == "end" or self.says("and", "or", offset=1) or self.next(1) == ")"
        ):
            self.place += 1
            return Condition(FINDING, "=", self.next(-1).lower())
        self.place += is_quoted
        while (
            not is_quoted
            and self.kind() == "word"
            and not self.says("and", "or")
            and not self._begins_list()
        ):
            self.place += 1
        if self.place == start:
            raise self.refusal(start)
        name = self.text[self.tokens[start].start() : self.tokens[self.place - 1].end()]
        name = _unquoted(name) if is_quoted else name
        if self._begins_list():
            return self._list(name, start)
        if self.kind() != "operator":
            raise self.refusal(start)
        sign = self.next().replace("==", "=")
        self.place += 1
        value = self._value(start, ())
        if not (self.kind() == "end" or self.says("and", "or") or self.next() == ")"):
            raise self.refusal(start)
        return Condition(name, sign, value)

    def _begins_list(self) -> bool:
        offset = 1 if self.says("not") else 0
        return self.says("in", offset=offset) and self.next(offset + 1) == "("

    def _list(self, name: str, start: int) -> Filter:
        """Parse ``in (value, value)`` or ``not in (value, value)`` after a name."""
        negated = self.says("not")
        self.place += 3 if negated else 2
        values = [self._value(start, (",",))]
        while self.next() == ",":
            self.place += 1
            values.append(self._value(start, (",",)))
        if self.next() != ")":
            raise self.refusal(start)
        self.place += 1
        listed = OneOf(tuple((Condition(name, "=", value),) for value in values))
        return NoneOf((listed,)) if negated else listed

    def _value(self, start: int, stops: tuple[str, ...]) -> str:
        """Parse a value: a quoted text, or text up to its end."""
        first = self.place
        if self.kind() == "quoted":
            self.place += 1
            return _unquoted(self.tokens[first].group())
        opened = 0
        while self.kind() in ("word", "sign") and not (
            opened == 0 and (self.next() in stops or (not stops and self.says("and", "or")))
        ):
            if self.next() == ")" and opened == 0:
                break
            opened += {"(": 1, ")": -1}.get(self.next(), 0)
            self.place += 1
        if self.place == first or opened:
            raise self.refusal(start)
        return self.text[self.tokens[first].start() : self.tokens[self.place - 1].end()]


def condition_text(name: str, value: str) -> str:
    """Return the filter that a column or tag has a value.

    >>> condition_text("performer", 'a "b" and c'), condition_text("take no.", "3")
    ('performer="a ""b"" and c"', '"take no."="3"')
    """
    quoted, value = ('"' + text.replace('"', '""') + '"' for text in (name, value))
    is_plain = re.fullmatch(r"[^\W\d]\w*", name) and name.casefold() not in _SYNTAX
    return f"{name if is_plain else quoted}={value}"


_SYNTAX = frozenset(("and", "or", "not", "in", "needs"))  # Words that are no names without quotes


def _unquoted(text: str) -> str:
    """Return what stands between quotes; a quote in it is written twice."""
    return text[1:-1].replace(text[0] * 2, text[0])


def conditions_of(filters: Iterable[Filter]) -> Iterator[Condition]:
    """Yield every comparison of some filters, from left to right."""
    for each in filters:
        if isinstance(each, Condition):
            yield each
        elif isinstance(each, NoneOf):
            yield from conditions_of(each.filters)
        else:
            yield from conditions_of(f for alternative in each.alternatives for f in alternative)


def with_columns(filters: Iterable[Filter], tags: Iterable[str]) -> tuple[Filter, ...]:
    """Return filters that name only columns, ``CAPTION`` and tags in use; heads are replaced.

    >>> with_columns(parse_where("length>10"), ["performer"])
    (Condition(name='duration', operator='>', value='10'),)
    """
    named = (*COLUMNS, CAPTION, SELECTION)
    known = (*named, *sorted(set(tags) - set(named)))
    return tuple(_with_columns(each, known) for each in filters)


def _with_columns(each: Filter, known: Sequence[str]) -> Filter:
    if isinstance(each, OneOf):
        return OneOf(tuple(tuple(_with_columns(f, known) for f in a) for a in each.alternatives))
    if isinstance(each, NoneOf):
        return NoneOf(tuple(_with_columns(f, known) for f in each.filters))
    if each.name in known:
        return each
    if name := {**MEASURED, **HEADS}.get(each.name.casefold()):
        return replace(each, name=name)
    raise QueryError(
        f"filter on {each.name!r}: expected one of {', '.join(known)}, found no such "
        f"column or tag.{suggestion(each.name, (*known, *HEADS, *MEASURED))}"
    )


def asks_captions(filters: Iterable[Filter]) -> bool:
    """Whether any of the filters tests captions."""
    return any(condition.name == CAPTION for condition in conditions_of(filters))


def asks_measured(filters: Iterable[Filter]) -> bool:
    """Whether any of the filters, as ``with_columns`` gives them, tests what ``quality`` found."""
    return any(condition.name in MEASURED.values() for condition in conditions_of(filters))


def matches(
    info: CaptureInfo,
    filters: Sequence[Filter],
    captions: Sequence[str] = (),
    measured: Mapping[str, Sequence[str]] = NOTHING,
) -> bool:
    """Whether a capture satisfies all filters; `measured`: the values of ``MEASURED``."""
    return all(_fulfils(info, each, captions, measured) for each in filters)


def _fulfils(
    info: CaptureInfo,
    each: Filter,
    captions: Sequence[str],
    measured: Mapping[str, Sequence[str]],
) -> bool:
    if isinstance(each, Condition):
        if each.name in measured:
            return _holds(measured[each.name], each)
        return _holds(_values(info, each.name, captions), each)
    if isinstance(each, NoneOf):
        return not matches(info, each.filters, captions, measured)
    return any(matches(info, one, captions, measured) for one in each.alternatives)


def _values(info: CaptureInfo, name: str, captions: Sequence[str]) -> Sequence[str]:
    if name in COLUMNS:
        return (str(getattr(info, name)),)
    if name == CAPTION:
        return captions
    if name == SELECTION:
        return tuple(read_selections(info.tags.get(name, "")))
    return (info.tags[name],) if name in info.tags else ()


def _holds(values: Sequence[str], condition: Condition) -> bool:
    if condition.operator.startswith("!"):
        return not _holds(values, replace(condition, operator=condition.operator[1:]))
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
