"""Texts of a grammar that lark reads: their names, numbers and statements, and their errors.

A ``.lark`` file beside this module says what a text is. A statement is one line; it continues where
the line ends with ``,``, ``:`` or ``|``, or where the next line begins with ``|``; ``#`` begins a
comment. A terminal of the file that has no pattern is a name: what it is called says what is named.
lark is imported when the first text is read.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Hashable, Mapping
from difflib import get_close_matches
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

from motiondb.errors import Fault, SceneError, suggestion
from motiondb.scene.language.semantic_rules import Spot

if TYPE_CHECKING:
    from lark import Lark, Token, Tree, UnexpectedInput

Quantity = tuple[float, "Token"]
"""Metres, radians or seconds, and where they are written."""

UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01},
    "angle": {"deg": math.pi / 180.0, "rad": 1.0},
    "time": {"s": 1.0, "frames": 1.0 / 30.0, "ms": 0.001},
}  # Units of every quantity, as multiples of metres, radians and seconds

HOW_FAR = "Write <= 2.5 m, >= 1.5 m, or 0.5 m .. 2 m."  # What to do about bounds of a distance
SMALLEST, LARGEST = 2.0, 100.0
"""Limits of the size of the ground, m. Outside, the file is likely to use another unit."""

_NAME, _BEHIND = r"[^\W\d]\w*'?(?:-\w+)*", r"(?![\w'-])"
_NUMBER = r"/[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?/"
_END = "\x1e"  # Marks the end of a statement
_PATTERNS = rf"""
_NL: "{_END}"
_ARROW: "->"
_IS: ":="
_RANGE: ".."
OPEN: "("
NUMBER: {_NUMBER}
STEP: {_NUMBER}
X: {_NUMBER}
Z: {_NUMBER}
TEXT: /"[^"\n]*"/
REPEAT: /[*+?]/
BOUND: /[<>]=?/
AGAIN.2: /\*|once{_BEHIND}/
WHEN.2: /when{_BEHIND}/
FLIGHT.2: /flight{_BEHIND}/
MOVING.2: /moving{_BEHIND}/
FOLLOWING.2: /(?:guards|follows){_BEHIND}/
LENGTH.2: /(?:{"|".join(UNITS["length"])}){_BEHIND}/
ANGLE.2: /(?:{"|".join(UNITS["angle"])}){_BEHIND}/
TIME.2: /(?:{"|".join(UNITS["time"])}){_BEHIND}/
%ignore /[ \t\f\v\r\n]+/
%ignore /#[^\n{_END}]*/
"""
_WORD = re.compile(r'"([^\W\d]\w*)"')
_QUOTED = re.compile(rf'"[^"\n]*"|#[^\n]*|({_NAME})')
_LINE = re.compile(r'(?:"[^"]*"|[^"#])*')
_DEEPEST = 50  # Most brackets inside one another: far from Python's limit of nested calls


@cache
def _parser(file: str) -> Lark:
    from lark import Lark

    text = resources.files(__package__).joinpath(f"{file}.lark").read_text("utf-8")
    words = {word: f"_{'BIG_' * word.isupper()}{word.upper()}" for word in _WORD.findall(text)}
    given = set(re.findall("^[A-Z]+", _PATTERNS, re.MULTILINE))
    names = set(re.findall(r"\b[A-Z]+\b", _WORD.sub("", text))) - given
    text = _WORD.sub(lambda match: words[match[1]], text) + _PATTERNS
    terminals = [f"{name}.2: /{word}{_BEHIND}/" for word, name in words.items()]
    terminals += [f"{name}: /{_NAME}/" for name in sorted(names)]
    return Lark("\n".join([text, *terminals]), parser="lalr", maybe_placeholders=True)


@cache
def _keywords(file: str) -> tuple[str, ...]:
    """Return the words of a file of lark that are no names."""
    of = [re.findall("[a-z]{2,}", t.pattern.value) for t in _parser(file).terminals if t.priority]
    return tuple(dict.fromkeys(word for words in of for word in words))


def _marked(text: str) -> str:
    """Return a text with a mark where a statement ends."""
    lines, last, before = text.split("\n"), 0, ","
    for number, line in enumerate(lines):
        match = _LINE.match(line)
        bare = match[0].strip() if match else ""
        if bare:
            if not (bare.startswith("|") or before.endswith((",", ":", "|"))):
                lines[last] += _END
            last, before = number, bare
    lines[last] += _END
    return "\n".join(lines)


def read_statements(file: str, text: str, reading: Reading) -> None:
    """Call a method of ``reading`` for every rule of a text, the inner ones first."""
    from lark import UnexpectedInput

    marked = _marked(text)
    try:
        tree = _parser(file).parse(marked)
    except UnexpectedInput as error:
        _refuse_misspelt(error, file, marked, reading)
        _refuse_input(error, _parser(file), text, reading)
    _made(tree, reading, 0)


def _made(tree: Tree[Token], reading: Reading, depth: int) -> Any:  # noqa: ANN401
    from lark import Token, Tree

    depth += tree.data in ("either", "ordered")
    if depth > _DEEPEST:
        advice = "Give the inner ones a name."
        first = next(one for one in tree.children if isinstance(one, Token))
        reading.fail(first, f"at most {_DEEPEST} brackets in one another", advice)
    children = [_made(c, reading, depth) if isinstance(c, Tree) else c for c in tree.children]
    reading.tokens += [c for c in tree.children if isinstance(c, Token)]
    return getattr(reading, f"_{tree.data}", _together)(*children)


def _together(*parts: object) -> tuple[object, ...]:
    return parts


def _refuse_misspelt(error: UnexpectedInput, file: str, marked: str, reading: Reading) -> None:
    """Refuse a word if the statement can be read further with a keyword that is spelt alike."""
    from lark import Token

    at, keywords = error.pos_in_stream or 0, _keywords(file)
    begin, end = marked.rfind(_END, 0, at) + 1, marked.find(_END, at) + 1
    statement, furthest = marked[begin:end], at - begin
    found: tuple[int, str, str] | None = None
    for match in _QUOTED.finditer(statement):
        word = match[1] or "" if match.start() <= at - begin else ""
        near = [] if word in ("", *keywords) else get_close_matches(word, keywords, n=3, cutoff=0.6)
        for keyword in near:
            changed = f"{statement[: match.start()]}{keyword}{statement[match.end() :]}"
            reached = _reached(file, changed) + len(word) - len(keyword)
            if reached > furthest:
                furthest, found = reached, (begin + match.start(), word, keyword)
    if found:
        place, word, keyword = found
        line, column = marked.count("\n", 0, place) + 1, place - marked.rfind("\n", 0, place)
        token = Token("WORD", word, place, line, column)
        reading.fail(token, repr(keyword), f"Did you mean {keyword}?")


def _reached(file: str, statement: str) -> int:
    """Return up to where a statement can be read; more than its length for all of it."""
    from lark import UnexpectedInput

    try:
        _parser(file).parse(statement)
    except UnexpectedInput as error:
        return error.pos_in_stream or 0
    return len(statement) + 100


def slip(word: str, keywords: Collection[str]) -> str:
    """Return the keyword of which a word has one letter more, less, other or exchanged, or "".

    >>> slip("tehn", ["then"]), slip("wth", ["with"]), slip("then", ["then"]), slip("on", ["to"])
    ('then', 'with', '', '')
    """
    longer = [known for known in keywords if len(known) > 2]
    for known in longer if len(word) > 2 and word not in keywords else ():
        same = next((k for k, (a, b) in enumerate(zip(word, known)) if a != b), len(known))
        one, other = word[same:], known[same:]
        if one[1:] in (other, other[1:]) or one == other[1:] or one[1::-1] + one[2:] == other:
            return known
    return ""


def _refuse_input(error: UnexpectedInput, lark: Lark, text: str, reading: Reading) -> NoReturn:
    from lark import Token, UnexpectedToken

    if not isinstance(error, UnexpectedToken):
        rest = text.split("\n")[error.line - 1][error.column - 1 :].strip()
        what = "a closing quote" if rest[0] == '"' else "a name, a number or a sign"
        token = Token("REST", rest, None, error.line, error.column)
        reading.fail(token, what, "Correct it.", repr(rest))
    stack = error.interactive_parser.parser_state.value_stack
    since = [one for one in stack if isinstance(one, Token) and one.type != "_NL"]
    if [one.type for one in since] == ["NAME"]:  # a line that begins with an unknown word
        words = [one.name[1:].lower() for one in lark.terminals if one.name.startswith("_")]
        near = suggestion(since[0], words).strip()
        reading.fail(since[0], reading.statement, near or reading.advice["NAME"])
    advice = reading.advise(since)
    if not since:
        advice = "Begin the line with a name; comments begin with '#'."
        reading.fail(error.token, reading.statement, advice)
    if "_NL" in error.accepts:
        reading.fail(error.token, "the end of the line", "Write one statement a line.")
    if "RPAR" in error.accepts:
        reading.fail(error.token, "')'", "Close the bracket.")
    accepted = sorted(error.accepts - reading.behind or error.accepts)
    told = (_expected(name, lark, reading) for name in accepted)
    reading.fail(error.token, " or ".join(dict.fromkeys(told)), advice)


def _expected(name: str, lark: Lark, reading: Reading) -> str:
    """Return what a terminal is called in a message."""
    pattern = lark.get_terminal(name).pattern
    if name in reading.expected:
        return reading.expected[name]
    if name.lower() in UNITS:
        return f"a unit of {name.lower()} ({', '.join(UNITS[name.lower()])})"
    if pattern.type == "str":
        return repr(pattern.value)
    return repr(name.removeprefix("_").lower())


class Reading:
    """What was read of a text; a rule of its grammar is a method, or the tuple of its parts."""

    statement = "a statement"
    advice: ClassVar[
        Mapping[str, str]
    ] = {}  # What to do about an error, by the word that stands before it
    expected: ClassVar[Mapping[str, str]] = {}  # What messages call a terminal
    behind: ClassVar[frozenset[str]] = frozenset()  # What follows any first name

    def __init__(self, where: str, is_kept: bool = False) -> None:
        self.where = where
        self.is_kept = (
            is_kept  # Whether an earlier version accepted the text: no slip is looked for
        )
        self.tokens: list[Token] = []
        self.said: dict[Hashable, int] = {}

    def advise(self, before: list[Token]) -> str:
        """Return what to do about an error behind some tokens of a statement."""
        known = (self.advice[t.type] for t in before[::-1] if t.type in self.advice)
        return next(known, "See the format.")

    def fail(self, token: Token, expected: str, advice: str, found: str = "") -> NoReturn:
        """Refuse a token, or what was ``found`` at its place."""
        found = found or ("the end of the line" if token == _END else repr(token.strip('"')))
        fault = Fault(expected, found, advice, token.line or 0, token.column or 0)
        raise SceneError(fault, where=self.where)

    def once(self, token: Token, key: Hashable, what: str) -> None:
        """Refuse a token if the same thing was stated before."""
        if key in self.said and not self.is_kept:
            advice = f"Line {self.said[key]} says it already: leave one of them out."
            self.fail(token, what, advice)
        self.said[key] = token.line or 0

    def slip(self, word: str, keywords: Collection[str]) -> str:
        """Return the keyword of which a word is a slip (:func:`slip`), or ""."""
        return "" if self.is_kept else slip(word, keywords)

    def unknown(
        self, token: Token, what: str, known: Collection[str], advice: str = ""
    ) -> NoReturn:
        """Refuse a name that is none of the known ones, and say which is spelt alike."""
        near = suggestion(token, known).strip() or advice or self.advice.get("NAME", "")
        self.fail(token, f"{what} ({', '.join(known)})", near)

    def number(self, token: Token) -> float:
        """Return a finite number."""
        if math.isinf(float(token)):
            what = self.expected.get(token.type, "a number")
            self.fail(token, f"{what}: a finite number", "Correct it.")
        return float(token)

    def _extent(self, *sizes: Token) -> tuple[float, ...]:
        for size in sizes:
            if not SMALLEST <= self.number(size) <= LARGEST:
                self.fail(size, f"{SMALLEST:g} to {LARGEST:g} metres", "Lengths are metres.")
        return tuple(map(float, sizes))

    def _spot(self, x: Token, z: Token) -> Spot:
        return Spot(self.number(x), self.number(z))

    def _bounds(self, first: Token | Quantity, second: Quantity) -> tuple[float, float]:
        """Return the least and the largest distance, m."""
        if isinstance(first, tuple):
            (near, token), (far, _) = first, second
        else:
            size, token = second
            near, far = (0.0, size) if first[0] == "<" else (size, math.inf)
        if not 0.0 <= near <= far:
            self.fail(token, "distances of 0 or more, the nearer first", HOW_FAR)
        return near, far

    def _length(self, number: Token, unit: Token) -> Quantity:
        """Return a quantity."""
        return self.number(number) * UNITS[unit.type.lower()][unit], number

    _angle = _time = _length
