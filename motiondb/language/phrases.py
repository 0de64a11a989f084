r"""Phrases of captions and questions that are read as other words, from two tables.

Those of ``caption_phrases.txt`` name a motion ("shakes hands"), those of ``request_phrases.txt``
are how people ask ("starts with", "hands on hips"). A line of a table is a pattern and its
replacement, ``seated => sitting``, or a pattern with a name, ``SPEED = {speed|pace}``. Patterns are
regular expressions written for reading: a space is any white space, ``{a|b}`` a group that is not
remembered, ``{SPEED}`` a named pattern.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

_PIECES = re.compile(r"\\.|\[(?:\\.|[^\]])*\]|\{[A-Z_]+\}|\{\d*,?\d*\}|[{} ]")
_LINE = re.compile(r'([A-Z_]+) = (.+)|(.+?) ?=> ?(?:"(.*)"|(.*))')


@dataclass(frozen=True)
class Phrases:
    """The patterns that have a name, and those that are replaced, with what replaces them."""

    expressions: Mapping[str, str]
    rules: tuple[tuple[re.Pattern[str], str], ...]

    def named(self, name: str) -> re.Pattern[str]:
        """The pattern of a name; those that only stand within others are never compiled."""
        return re.compile(self.expressions[name], re.IGNORECASE)

    def replaced(self, text: str) -> str:
        r"""A text in which every phrase is replaced.

        >>> table = "SPEED = {speed|pace}\nat full {SPEED} => fast"
        >>> read_phrases(table).replaced("run at full pace")
        'run fast'
        """
        for pattern, words in self.rules:
            text = pattern.sub(words, text)
        return text


@cache
def phrases(of: str) -> Phrases:
    """Those of a table, "caption" or "request"."""
    table = resources.files("motiondb.language").joinpath(f"{of}_phrases.txt")
    return read_phrases(table.read_text(encoding="utf-8"))


def read_phrases(text: str) -> Phrases:
    """The phrases of a table."""
    named, rules = dict[str, str](), list[tuple[re.Pattern[str], str]]()
    for line in re.sub(r"\n +(?=\S)", "", text).split("\n"):
        if line.strip() and not line.startswith("#"):
            found = _LINE.fullmatch(line)
            assert found is not None, f"phrases: expected PATTERN => WORDS, found {line!r}"
            name, pattern, rule, quoted, plain = found.groups()
            if name:
                named[name] = _expression(pattern, named)
            else:
                whole = re.compile(rf"\b(?:{_expression(rule, named)})\b", re.IGNORECASE)
                rules.append((whole, plain if quoted is None else quoted))
    return Phrases(named, tuple(rules))


def _expression(pattern: str, named: Mapping[str, str]) -> str:
    r"""A pattern as a regular expression.

    >>> _expression("at {a }?{SPEED}", {"SPEED": "(?:speed|pace)"})
    'at\\s+(?:a\\s+)?(?:speed|pace)'
    """

    def written(found: re.Match[str]) -> str:
        piece = found[0]
        plain = {"{": "(?:", "}": ")", " ": r"\s+"}.get(piece, piece)
        return named[piece[1:-1]] if piece[1:2].isupper() else plain

    return _PIECES.sub(written, pattern)
