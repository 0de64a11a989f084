"""Named selections of captures and of parts of them, as the tag ``selection`` of each capture.

The value of the tag says in which selections a capture is, and with which parts, in seconds::

    fight day 2; warm up [1.2-3.4 5-6.125]; both [whole 0.5-2]

So selections are taken back, removed and restored with their captures, merged, and written into
sheets as other tags are; a column ``selection`` of a sheet makes some. One that holds nothing does
not exist.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

SELECTION = "selection"
"""The tag that holds them."""
Span = tuple[float, float] | None
"""A part of a capture, seconds; None: all of it."""
MARKS = ";[]"
"""Characters that the name of a selection cannot have."""
_PARTS = re.compile(r"(.*?)\s*\[([^][]*)\]")
_SPAN = re.compile(r"(\d+(?:\.\d+)?)-(\d+(?:\.\d+)?)")
_WHOLE = "whole"


def read_selections(value: str) -> dict[str, frozenset[Span]]:
    """The selections that the value of a tag names, each with the parts of the capture.

    >>> read_selections("fight day 2; warm up [1.2-3.4]")
    {'fight day 2': frozenset({None}), 'warm up': frozenset({(1.2, 3.4)})}
    """
    found = dict[str, frozenset[Span]]()
    for each in filter(None, map(str.strip, value.split(";"))):
        matched = _PARTS.fullmatch(each)
        name, parts = matched.groups() if matched else ("", "")
        spans = _spans(parts.split())
        if not name or not spans:  # a name alone, or what nobody wrote as above
            name, spans = each, {None}
        found[name] = found.get(name, frozenset()) | spans
    return found


def _spans(texts: Iterable[str]) -> set[Span]:
    """The parts as they are written; none where one of them is no part."""
    spans = set[Span]()
    for text in texts:
        matched = _SPAN.fullmatch(text)
        span = (float(matched[1]), float(matched[2])) if matched else None
        if text != _WHOLE if span is None else span[0] >= span[1]:
            return set()
        spans.add(span)
    return spans


def write_selections(selections: Mapping[str, Iterable[Span]]) -> str:
    """The value of the tag of a capture; "" where it is in no selection.

    >>> write_selections({"warm up": [(5.0, 6.125), None, (1.2, 3.4)], "fight": [None], "none": []})
    'warm up [whole 1.2-3.4 5-6.125]; fight'
    """
    written = []
    for name, parts in selections.items():
        spans = sorted(span for span in parts if span is not None)
        texts = [_WHOLE] * (None in parts) + [f"{_text(a)}-{_text(b)}" for a, b in spans]
        if texts:
            written.append(name if texts == [_WHOLE] else f"{name} [{' '.join(texts)}]")
    return "; ".join(written)


def join_selections(first: str, second: str) -> str:
    """The value of the tag of a capture that is in all selections of two values.

    >>> join_selections("fight; warm up [0-1]", "warm up [2-3]")
    'fight; warm up [0-1 2-3]'
    """
    held, more = read_selections(first), read_selections(second)
    names = dict.fromkeys((*held, *more))
    nothing = frozenset[Span]()
    return write_selections({n: held.get(n, nothing) | more.get(n, nothing) for n in names})


def _text(seconds: float) -> str:
    return f"{seconds:.3f}".rstrip("0").rstrip(".")
