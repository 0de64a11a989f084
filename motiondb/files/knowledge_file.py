"""Files of knowledge: text and arrays of numbers, checked on reading, never executed.

A file has three parts. The first line names the format,

    motiondb knowledge 1

The second line is a JSON object in ASCII:

=========  =========================================================================
``origin``  name, version, captures, captions, performers, seconds, licences, runs, credit
``words``   the words, sorted
``arrays``  for every array its name and shape, in the order of the data
``size``    number of bytes of the data
``sha256``  SHA-256 of the data, hexadecimal
=========  =========================================================================

The rest is a zlib stream of the data: the arrays one after another, in C order, as little-endian
float32. The same knowledge gives the same bytes with the same version of zlib.

Reading bounds every size before it allocates, and checks the numbers
(:mod:`motiondb.learn.knowledge`). A digest shows damage, not who wrote the file.
"""

from __future__ import annotations

import hashlib
import json
import re
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motiondb.errors import KnowledgeError
from motiondb.files.json_text import JSONError, parse_json, to_record
from motiondb.files.safe_files import read_bounded, write_bytes
from motiondb.learn.codec import from_values, to_values
from motiondb.learn.knowledge import APART, MOST_WORDS, Knowledge, Origin, array_faults
from motiondb.records import FloatArray

HEADING = b"motiondb knowledge 1\n"
MOST_BYTES = 16_000_000
"""Largest file that is read; what ``export`` writes has less than 2 MB for 100 symbols."""
MOST_HEADER = 1_000_000  # Largest second line
MOST_DATA = 64_000_000  # Largest number of bytes of the data
_WORD = re.compile(r"[^\W_][\w'-]{0,63}")
_TEXT = 2_000  # characters of a text of the origin
_GET_AGAIN = "The file is damaged, or not a file of knowledge: get it again."
_Arrays = tuple[tuple[str, tuple[int, ...]], ...]


@dataclass(frozen=True)
class _Header:
    """The second line of a file."""

    origin: Origin
    words: tuple[str, ...]
    arrays: _Arrays
    size: int
    sha256: str


def write_knowledge(knowledge: Knowledge, path: str | Path) -> Path:
    """Write knowledge; the file appears whole or not at all."""
    return write_bytes(Path(path), to_bytes(knowledge), KnowledgeError)


def to_bytes(knowledge: Knowledge) -> bytes:
    """The bytes of a file of knowledge."""
    values = to_values(knowledge, without=APART)
    arrays = {name: np.asarray(value, dtype=np.float64) for name, value in values.items()}
    data = b"".join(np.ascontiguousarray(v, dtype="<f4").tobytes() for v in arrays.values())
    header = {
        "origin": knowledge.origin.facts(),
        "words": list(knowledge.taught.words),
        "arrays": [[name, list(values.shape)] for name, values in arrays.items()],
        "size": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
    }
    line = json.dumps(header, sort_keys=True, separators=(",", ":")).encode("ascii")
    return HEADING + line + b"\n" + zlib.compress(data, 9)


def read_knowledge(path: str | Path) -> Knowledge:
    """Read a file of knowledge."""
    path = Path(path)
    try:
        content = read_bounded(path, MOST_BYTES)
    except OSError as error:
        raise KnowledgeError(
            f"{path}: expected a file of knowledge, found: {error.strerror or error}. "
            "Name a file that motiondb knowledge export wrote, or cmu."
        ) from None
    return from_bytes(content, str(path))


def from_bytes(content: bytes, source: str) -> Knowledge:
    """Knowledge from the bytes of a file."""
    if not content.startswith(HEADING):
        raise _fault(source, f"the line {HEADING.decode().strip()!r}", repr(content[:30])[1:])
    if len(content) > MOST_BYTES:
        raise _fault(source, f"at most {MOST_BYTES:,} bytes", "more")
    line, _, stream = content[len(HEADING) :].partition(b"\n")
    header = _read_header(line, source)
    data = _inflate(stream, header, source)
    arrays = _read_arrays(data, header.arrays, source)
    faults = array_faults(arrays, len(header.words))
    if faults:
        raise KnowledgeError(
            "\n".join(f"{source}: {fault}." for fault in faults[:5])
            + " The file is damaged or was not written by motiondb: get it again."
        )
    digest = hashlib.sha256(content).hexdigest()
    given = dict(zip(APART, (replace(header.origin, digest=digest), header.words, None)))
    return from_values(Knowledge, arrays, given=given)


def read_summary(content: bytes, source: str) -> tuple[Origin, tuple[str, ...]]:
    """Origin and words of the bytes of a file, without its numbers; parameters as `from_bytes`."""
    if not content.startswith(HEADING):
        raise _fault(source, f"the line {HEADING.decode().strip()!r}", repr(content[:30])[1:])
    header = _read_header(content[len(HEADING) :].partition(b"\n")[0], source)
    return header.origin, header.words


def _fault(source: str, expected: str, actual: str) -> KnowledgeError:
    return KnowledgeError(f"{source}: expected {expected}, found {actual}. {_GET_AGAIN}")


def _read_header(line: bytes, source: str) -> _Header:
    if len(line) > MOST_HEADER:
        raise _fault(source, f"a second line of at most {MOST_HEADER:,} bytes", "a longer one")
    try:
        header = to_record(_Header, parse_json(line))
    except JSONError as fault:
        raise KnowledgeError(f"{source}: {fault}. {_GET_AGAIN}") from None
    _check_origin(header.origin, source)
    _check_words(header.words, source)
    return header


def _check_origin(origin: Origin, source: str) -> None:
    texts = (origin.name, origin.version, origin.credit, *origin.licences)
    texts = (*texts, *(json.dumps(run) for run in origin.runs))
    numbers = (origin.captures, origin.captions, origin.performers, origin.seconds)
    sound = (
        all(len(text) <= _TEXT and text.isprintable() for text in texts)
        and all(0 <= number <= 1e12 for number in (*numbers, *origin.licences.values()))
        and len(origin.runs) <= 100
        and len(origin.licences) <= 100
        and not origin.digest
    )
    if not sound:
        raise _fault(source, "an origin of short texts and numbers", "others")


def _check_words(words: tuple[str, ...], source: str) -> None:
    if len(words) > MOST_WORDS:
        raise _fault(source, f"at most {MOST_WORDS} words", str(len(words)))
    if not all(_WORD.fullmatch(word) for word in words):
        raise _fault(source, "words of letters", "others")
    if list(words) != sorted(set(words)):
        raise _fault(source, "sorted words, each once", "others")


def _inflate(stream: bytes, header: _Header, source: str) -> bytes:
    size = header.size
    if not 0 < size <= MOST_DATA:
        raise _fault(source, f"1 to {MOST_DATA:,} bytes of data", str(size)[:20])
    unpack = zlib.decompressobj()
    try:
        data = unpack.decompress(stream, size + 1)
    except zlib.error:
        raise _fault(source, "a zlib stream after the second line", "something else") from None
    if len(data) != size or not unpack.eof or unpack.unused_data:
        raise _fault(source, f"{size:,} bytes of data", "more or fewer")
    if hashlib.sha256(data).hexdigest() != header.sha256:
        raise _fault(source, "data with the SHA-256 that its header gives", "other data")
    return data


def _read_arrays(data: bytes, listed: _Arrays, source: str) -> dict[str, FloatArray]:
    numbers = len(data) // 4
    if len(listed) > 100:
        raise _fault(source, "at most 100 arrays", str(len(listed)))
    arrays: dict[str, FloatArray] = {}
    place = 0
    for name, shape in listed:
        usual = len(name) <= 60 and name.isprintable() and len(shape) <= 4
        if not usual or not all(0 <= n <= MOST_DATA for n in shape):
            raise _fault(source, "a name and a shape for every array", "something else")
        size = int(np.prod(shape, dtype=object)) if shape else 1
        if name in arrays or size > numbers - place:
            raise _fault(source, "every array once, and data for it", f"{name!r} otherwise")
        flat = np.frombuffer(data, "<f4", size, 4 * place)
        arrays[name] = flat.astype(np.float64).reshape(shape)
        place += size
    if 4 * place != len(data):
        raise _fault(source, f"{4 * place:,} bytes of data for its arrays", f"{len(data):,}")
    return arrays
