r"""Text captures as clean bytes, and blocks of numbers with the line of every fault.

A text capture may come with a byte order mark, as UTF-16, with CRLF or bare CR line ends. The
readers see UTF-8 or Latin-1 bytes with ``\n`` (a ``\r`` before it counts as white space).

Numbers are written in plain decimal notation with ASCII digits. Other forms that Python's ``float``
accepts (``1_0``, ``nan``, ``inf``, digits of other scripts) are faults.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence

import numpy as np

from motiondb.errors import CaptureError
from motiondb.records import FloatArray

Faults = list[tuple[int | None, str]]  # (line number or None, sentence) for every fault

MAX_FAULTS = 20
"""Faults that a message lists; the rest are counted, so that a message stays readable."""
CUT_SHORT = (  # advice for frames with too few values
    "The file may be cut short: export it again, or pass --skip-bad-frames to leave this frame out."
)
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
MAX_DIGITS = 100
"""Characters of a number. Exact float64 values have up to 25; the time to read a number grows with
the square of its length."""


def csv_bytes(rows: Iterable[Iterable[object]], delimiter: str = ",") -> bytes:
    """The rows of a table as the bytes of a CSV or TSV file."""
    text = io.StringIO(newline="")
    csv.writer(text, delimiter=delimiter, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def clean_bytes(data: bytes, path: object) -> bytes:
    """Return the bytes of a text file in an ASCII-compatible encoding, without byte order mark."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        data = data.decode("utf-16", errors="replace").encode("utf-8", errors="replace")
    data = data.removeprefix(b"\xef\xbb\xbf")
    if not data.strip():
        raise CaptureError(path, "expected a capture, found an empty file. Export it again.")
    if b"\0" in data:
        raise CaptureError(
            path, "expected text, found binary data. Check the file's ending, or export it as text."
        )
    return data if b"\n" in data else data.replace(b"\r", b"\n")


def decode(data: bytes) -> str:
    """Return the text of cleaned bytes: UTF-8, or Latin-1 if that fails."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def line_number(data: bytes, offset: int) -> int:
    r"""Return the number, from 1, of the line that holds a byte offset.

    >>> line_number(b"a\nb\nc", 4)
    3
    """
    return data.count(b"\n", 0, offset) + 1


def read_number_block(
    block: bytes, first_line: int, width: int, expected: str, skip_bad: bool
) -> tuple[FloatArray, Faults]:
    """Read a table of numbers with one frame a line.

    A frame may also be wrapped over several lines, when no line is longer than a frame and the
    total is right.

    Shapes: result (frames, width).

    `expected`: What a frame holds, for messages, such as "63 values (6 for the root, 57 for 19
    joints)".
    """
    from motiondb.files.number_words import count_values, read_words  # compiled code

    lines, counts = count_values(block)
    good = counts == width
    total = int(counts.sum())
    several = len(lines) > total / max(width, 1) and total % max(width, 1) == 0
    wrapped = not good.all() and several and counts.max() <= width and not skip_bad
    if good.all() or wrapped:
        values = read_words(block)[2]
        if len(values) == total and not np.isnan(values).any():
            return values.reshape(-1, width), []
    rows, faults = [], []
    text_lines = block.split(b"\n")
    for line, count in zip(lines.tolist(), counts.tolist()):
        row, fault = _read_row(text_lines[line], count, width, expected)
        if row is not None:
            rows.append(row)
        if fault:
            faults.append((first_line + line, fault))
    return np.array(rows, dtype=float).reshape(-1, width), faults


def shorten(faults: Faults) -> Faults:
    """Return the first ``MAX_FAULTS`` faults, and how many more there are."""
    if len(faults) <= MAX_FAULTS:
        return faults
    more = len(faults) - MAX_FAULTS
    return [*faults[:MAX_FAULTS], (None, f"... and {more} more faults like these.")]


def quoted(text: str, length: int = 40) -> str:
    """Return a text from a file as a message shows it: quoted, and cut where it is long.

    >>> quoted("Hips"), quoted("x" * 50, 3)
    ("'Hips'", "'xxx...'")
    """
    return repr(cut(text, length))


def cut(text: str, length: int) -> str:
    """Return a text, or its beginning where it is longer than ``length``."""
    return text if len(text) <= length else f"{text[:length]}..."


def number(token: str) -> float | None:
    """Return a finite number in plain decimal notation, or None.

    >>> number("-1.5e-3"), number("nan"), number("1_0")
    (-0.0015, None, None)
    """
    if len(token) > MAX_DIGITS or not _NUMBER.fullmatch(token):
        return None
    value = float(token)
    return value if np.isfinite(value) else None


def comma_advice(token: str) -> str:
    """Return what to do about a number with a decimal comma, "" for any other text.

    >>> comma_advice("0,0333"), comma_advice("abc")
    ('Export the file with decimal points: it has decimal commas.', '')
    """
    is_number = "," in token and number(token.replace(",", ".", 1)) is not None
    return "Export the file with decimal points: it has decimal commas." if is_number else ""


def whole_number(token: str) -> int | None:
    """Return a whole number of at most 15 ASCII digits, or None.

    >>> whole_number("12"), whole_number("²"), whole_number("9" * 5000), whole_number("-1")
    (12, None, None, None)
    """
    return int(token) if re.fullmatch(r"0*[0-9]{1,15}", token) and len(token) < 40 else None


def _read_row(
    line: bytes, count: int, width: int, expected: str
) -> tuple[list[float] | None, str | None]:
    """Return the values of a frame, or its fault."""
    if count != width:
        return None, f"expected {expected}, found {count}. {CUT_SHORT}"
    tokens = line.split()
    if len(tokens) != count:  # control characters, which separate values nowhere else
        return None, f"expected {expected}, found {len(tokens)}. {CUT_SHORT}"
    values = []
    for place, token in enumerate(map(decode, tokens)):
        value = number(token)
        if value is None:
            problem = f"expected numbers, found {token[:20]!r} as value {place + 1}"
            advice = (
                comma_advice(token)
                or "Correct the line, or pass --skip-bad-frames to leave it out."
            )
            return None, f"{problem}. {advice}"
        values.append(value)
    return values, None


def take_name(name: str) -> str:
    """Name of a take as part of a capture's name; Blender writes the object before it.

    >>> take_name("Armature|walk"), take_name("Take 001"), take_name("a/b#1")
    ('walk', 'Take 001', 'a-b-1')
    """
    text = re.sub(r"[/\\#]", "-", plain(name).rpartition("|")[2]).strip(" .")
    return text or "take"


def distinct(names: Sequence[str]) -> list[str]:
    """Return names with a number after those that others have before them.

    >>> distinct(["walk", "run", "walk"])
    ['walk', 'run', 'walk-2']
    """
    given: list[str] = []
    for name in names:
        number, new = 2, name
        while new in given:
            number, new = number + 1, f"{name}-{number}"
        given.append(new)
    return given


def plain(name: str) -> str:
    """Return the name of a node without what would break a line."""
    return " ".join("".join(c if c.isprintable() else " " for c in name).split()) or "node"
