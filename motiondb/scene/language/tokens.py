"""Tokens of the text files of scenes: names, numbers, quoted text and signs, with line and column.

A motion grammar and a tactics diagram are read from the same kinds of token. ``#`` begins a
comment. A statement is one line; it continues where the line ends with ``,``, ``:`` or ``|``, or
where the next line begins with ``|``. :class:`Cursor` moves over the tokens of one statement. Its
errors name the place, the expected symbol, and the actual one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import NoReturn

from motiondb.errors import SceneError, suggestion

_TOKEN = re.compile(
    r"""(?P<blank>[ \t\f\v\r]+|\#.*)
    |(?P<name>[^\W\d]\w*'?(?:-\w+)*)
    |(?P<number>[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?)
    |(?P<text>"[^"]*")
    |(?P<sign>->|:=|<=|>=|\.\.|[<>:=|&()\[\]*+?,.])""",
    re.VERBOSE,
)

UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01},
    "angle": {"deg": math.pi / 180.0, "rad": 1.0},
    "time": {"s": 1.0, "frames": 1.0 / 30.0, "ms": 0.001},
}  # Units of every quantity, as multiples of metres, radians and seconds


@dataclass(frozen=True)
class Token:
    """A piece of text."""

    kind: str  # "name", "number", "text", "sign", or "end" after the last token of a statement
    text: str  # The characters; quoted text without its quotes
    line: int
    column: int

    def __str__(self) -> str:
        """Return the token as messages show it."""
        return "the end of the line" if self.kind == "end" else repr(self.text)


def tokens_of(text: str, where: str) -> list[Token]:
    """Return all tokens of a text; quoted text comes without its quotes.

    >>> [token.text for token in tokens_of("A -> run | walk  # moves", "x.grammar")]
    ['A', '->', 'run', '|', 'walk']
    """
    tokens = []
    for number, line in enumerate(text.split("\n"), start=1):
        at = 0
        while at < len(line):
            match = _TOKEN.match(line, at)
            if match is None:
                what = "a closing quote" if line[at] == '"' else "a name, a number or a sign"
                refuse(f"{where}:{number}:{at + 1}", what, repr(line[at:].strip()), "Correct it.")
            kind = str(match.lastgroup)
            if kind != "blank":
                tokens.append(Token(kind, match.group().strip('"'), number, at + 1))
            at = match.end()
    return tokens


def statements(text: str, where: str) -> Iterator[Cursor]:
    """Return the statements of a text, each as a cursor at its first token."""
    lines: list[list[Token]] = []
    for token in tokens_of(text, where):
        if lines:
            last = lines[-1][-1]
            if token.line == last.line or token.text == "|" or last.text in (",", "|", ":"):
                lines[-1].append(token)
                continue
        lines.append([token])
    return (Cursor(line, where) for line in lines)


def refuse(place: str, expected: str, actual: str, advice: str) -> NoReturn:
    """Raise a SceneError with the place, the expected and the actual text, and advice."""
    raise SceneError(f"{place}: expected {expected}, found {actual}. {advice}")


class Cursor:
    """A position in the tokens of one statement; it only moves forward."""

    def __init__(self, tokens: list[Token], where: str) -> None:
        last = tokens[-1]
        end = Token("end", "", last.line, last.column + len(last.text) + 2 * (last.kind == "text"))
        self._tokens, self._where, self._at = [*tokens, end], where, 0

    @property
    def here(self) -> Token:
        """The next token; its kind is "end" after the last one."""
        return self._tokens[self._at]

    @property
    def after(self) -> Token:
        """The token after the next one."""
        return self._tokens[min(self._at + 1, len(self._tokens) - 1)]

    def fail(self, expected: str, advice: str, token: Token | None = None) -> NoReturn:
        """Refuse the next token, or the given one."""
        token = token or self.here
        refuse(f"{self._where}:{token.line}:{token.column}", expected, str(token), advice)

    def take(self) -> Token:
        """Return the next token, and move on."""
        token = self.here
        if token.kind != "end":
            self._at += 1
        return token

    def meets(self, *texts: str) -> bool:
        """Move over the next token if it is one of these words or signs (not quoted text)."""
        if self.here.kind in ("name", "sign") and self.here.text in texts:
            self._at += 1
            return True
        return False

    def expect(self, text: str, advice: str) -> Token:
        """Take this word or sign, or refuse."""
        if self.here.text != text or self.here.kind == "text":
            self.fail(repr(text), advice)
        return self.take()

    def name(self, what: str, advice: str, known: Collection[str] = ()) -> str:
        """Take a name; if ``known`` names are given, it must be one of them."""
        token = self.here
        if token.kind != "name":
            self.fail(what, advice)
        if known and token.text not in known:
            near = suggestion(token.text, known).strip()
            self.fail(f"{what} ({', '.join(known)})", near or advice)
        return self.take().text

    def number(self, what: str, advice: str) -> float:
        """Take a number without a unit; refuse one that is too large for a float."""
        token = self.here
        if token.kind != "number":
            self.fail(what, advice)
        if math.isinf(float(token.text)):
            self.fail(f"{what}: a finite number", advice)
        return float(self.take().text)

    def once(self, said: dict[str, int], key: str, what: str, token: Token | None = None) -> None:
        """Refuse a token (the next one by default) if an earlier line stated the same thing."""
        token = token or self.here
        line = said.setdefault(key, token.line)
        if line != token.line:
            self.fail(what, f"Line {line} says it already: leave one of them out.", token)

    def quantity(self, kind: str, what: str) -> float:
        """Take a number and its unit, and return it in metres, radians or seconds."""
        units = UNITS[kind]
        advice = f"Write a number and one of the units {', '.join(units)}."
        value = self.number(what, advice)
        unit = self.name(f"a unit of {kind}", advice, tuple(units))
        return value * units[unit]

    def done(self, advice: str) -> None:
        """Refuse tokens that are left over."""
        if self.here.kind != "end":
            self.fail("the end of the line", advice)
