"""Which files motiondb wrote itself, so that it does not overwrite those of others.

A file of motiondb says so in its first bytes, where its format has a place for that: the text
``Software`` of a PNG, the comment of a GIF, the generator of a glTF file or of a page, the heading
of knowledge. Those of pictures and pages hold the digest of what follows them, too. A BVH file has
no such place. Its digest stands in ``FILE.provenance.json`` beside it. A picture, a page or a BVH
file that was changed since counts as another's.
"""

from __future__ import annotations

import filecmp
import hashlib
import re
import zlib
from pathlib import Path

from motiondb.errors import QueryError
from motiondb.files.json_text import parse_json
from motiondb.files.safe_files import check_output, check_replacing, open_file, read_bounded

WRITER = "motiondb"
SEAL = f"{WRITER} {'0' * 64}"
"""Mark of a picture or page before :func:`sealed` puts the digest into it."""
_SEAL = re.compile(rb"(tEXtSoftware\0|\x21\xfe\x49|generator\" content=\")motiondb ([0-9a-f]{64})")
_CHECKSUM = 4  # Bytes after the mark that no digest covers: in a PNG, the checksum of the mark
MARKS = (
    (b"glTF", b'"generator":"motiondb"'),
    (b'{"asset":', b'"generator":"motiondb"'),
    (b"motiondb knowledge ", b""),
    (b'{\n "written_by": "motiondb"', b""),
    (b"<!-- written by motiondb -->", b""),
)  # How files of a kind begin, and what stands in those of motiondb
_HEAD = 4096  # Bytes in which a mark stands


def protect_others(protected: bool = True) -> None:
    """Let no file of others be overwritten in this context, or let all be.

    Parameters
    ----------
    protected : bool
        Whether a file that motiondb did not write stays: writing it is then a QueryError.
    """
    check_replacing.set(_refuse_others if protected else _let_replace)


def check_overwriting(path: Path) -> None:
    """Refuse the name of an output that may not be written, before it is made.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    QueryError
        It is a folder, or belongs to a database; or files of others are protected
        (:func:`protect_others`), and this is one.
    """
    try:
        check_output(path)
    except OSError as error:
        raise QueryError(
            f"{path}: expected a file that can be written, found: {error.strerror}."
        ) from None
    check_replacing.get()(path, path)


def _let_replace(_path: Path, _draft: Path) -> None:
    """Let any file be replaced."""


def _refuse_others(path: Path, draft: Path) -> None:
    """Refuse to replace a file of others by a draft, unless both have the same content."""
    if is_own(path) or (draft != path and filecmp.cmp(path, draft, shallow=False)):
        return
    raise QueryError(
        f"{path}: expected a new file, or one that motiondb is known to have written, found "
        "another. It stays as it is; give another name, or --force to overwrite it."
    )


PROVENANCE = ".provenance.json"  # After the name of a motion's file: that of its origin


def provenance_path(path: Path) -> Path:
    """Return the file with the origin of every frame of a motion, beside the motion's file."""
    return path.with_name(f"{path.name}{PROVENANCE}")


def sealed(data: bytes) -> bytes:
    """Return a picture or page with the digest of what follows its mark in place of the zeros."""
    found = _SEAL.search(data, 0, _HEAD)
    if found is None:
        return data
    end = found.end()
    digest = hashlib.sha256(data[end + _CHECKSUM :]).hexdigest().encode()
    marked = data[: found.start(2)] + digest
    if not data.startswith(b"\x89PNG"):
        return marked + data[end:]
    checksum = zlib.crc32(marked[found.start() :]).to_bytes(_CHECKSUM, "big")
    return marked + checksum + data[end + _CHECKSUM :]


def seal(draft: Path) -> None:
    """Put its digest into the mark of a picture that was just written."""
    with open_file(draft) as file:
        data = file.read()
    draft.write_bytes(sealed(data))


def is_own(path: Path) -> bool:
    """Whether there is no file of this name, an empty one, or one that motiondb wrote."""
    try:
        with open_file(path) as file:
            head = file.read(_HEAD)
    except OSError:
        return True  # nothing to lose, or the writer says what is wrong
    is_marked = any(head.startswith(start) and mark in head for start, mark in MARKS)
    return not head or is_marked or _is_sealed(path, head) or _has_provenance(path)


def _is_sealed(path: Path, head: bytes) -> bool:
    """Whether a picture or page holds the digest of what follows its mark."""
    found = _SEAL.search(head)
    return found is not None and digest_of(path, found.end() + _CHECKSUM) == found[2].decode()


def digest_of(path: Path, start: int = 0) -> str:
    """Return the SHA-256 of a file from a byte on."""
    digest = hashlib.sha256()
    with open_file(path) as file:
        file.seek(start)
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def _has_provenance(path: Path) -> bool:
    """Whether the file beside a motion holds the motion's digest."""
    try:
        said = parse_json(read_bounded(provenance_path(path)))
        return bool(said["sha256"] == digest_of(path))
    except (OSError, ValueError, TypeError, KeyError):
        return False
