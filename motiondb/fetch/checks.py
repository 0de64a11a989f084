"""Check that a downloaded ASF or AMC file is whole, by its ends, without reading the motion.

A transfer can be cut, or answered by an error page. Either would otherwise be taken for a capture.
Every check gives None for a whole file, or the end of a sentence: ``expected ..., found ...``.

>>> check_amc(b"<html>Not here</html>")
'expected an AMC file, found a web page'
"""

from __future__ import annotations

import re
from itertools import pairwise

_FRAME = re.compile(rb"^[ \t]*0{0,9}([0-9]{1,9})[ \t\r]*$", re.MULTILINE)
_ASF_SECTIONS = (b":root", b":bonedata", b":hierarchy")


def check_amc(data: bytes) -> str | None:
    """Return the fault of the bytes of an AMC file, or None.

    A whole file has a header and frames that are numbered one after the other. Its last frame has
    the bones of the first, each with as many values, and ends with a line end.
    """
    fault = _wrong_kind(data, "an AMC file", (b"#", b":"))
    if fault:
        return fault
    frames = list(_FRAME.finditer(data))
    if not frames:
        return "expected frames after the header, found none"
    numbers = [int(frame[1]) for frame in frames]
    for before, after in pairwise(numbers):
        if after != before + 1:
            return f"expected frame {before + 1} after frame {before}, found frame {after}"
    first_end = frames[1].start() if len(frames) > 1 else len(data)
    first = _bone_sizes(data[frames[0].end() : first_end])
    last = _bone_sizes(data[frames[-1].end() :])
    if not first or last != first:
        return (
            f"expected {_size(first)} in the last frame (number {numbers[-1]}), found {_size(last)}"
        )
    if not data.endswith((b"\n", b"\r")):
        return "expected a line end at the end of the file, found a line cut short"
    return None


def check_asf(data: bytes) -> str | None:
    """Return the fault of the bytes of an ASF file, or None.

    A whole file has the sections root, bonedata and hierarchy, an ``end`` for every ``begin``, and
    the ``end`` of the hierarchy last.
    """
    fault = _wrong_kind(data, "an ASF file", (b"#", b":"))
    if fault:
        return fault
    for section in _ASF_SECTIONS:
        if not re.search(rb"^[ \t]*" + section, data, re.MULTILINE):
            return f"expected a section {section.decode()}, found none"
    words = data.split()
    opened, closed = words.count(b"begin"), words.count(b"end")
    if opened != closed or words[-1] != b"end":
        return f"expected an end for each of {opened} begin, found {closed} end"
    return None


def _wrong_kind(data: bytes, kind: str, starts: tuple[bytes, ...]) -> str | None:
    text = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if not text:
        return f"expected {kind}, found an empty file"
    if text.startswith(b"<"):
        return f"expected {kind}, found a web page"
    if not text.startswith(starts):
        return f"expected {kind}, found something else"
    return None


def _bone_sizes(frame: bytes) -> list[tuple[bytes, int]]:
    """Names of the bones of a frame, each with its number of values."""
    rows = (line.split() for line in frame.splitlines())
    return [(row[0], len(row) - 1) for row in rows if row]


def _size(bones: list[tuple[bytes, int]]) -> str:
    return f"{len(bones)} bones with {sum(size for _, size in bones)} values"
