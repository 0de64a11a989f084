"""Which files motiondb wrote itself, so that it does not overwrite those of others.

A file of motiondb says so in its first bytes, where its format has a place for that: the text
``Software`` of a PNG, the comment of a GIF, the generator of a glTF file or of a page, the heading
of knowledge. A BVH file has no such place. Its digest stands in ``NAME.provenance.json`` beside it,
so that a file that was changed since counts as another's.
"""

from __future__ import annotations

import filecmp
import hashlib
from pathlib import Path

from motiondb.errors import QueryError
from motiondb.files.json_text import parse_json
from motiondb.files.safe_files import check_replacing, open_file, read_bounded

WRITER = "motiondb"
MARKS = (
    (b"\x89PNG", b"tEXtSoftware\0motiondb"),
    (b"GIF8", b"\x21\xfe\x08motiondb\0"),
    (b"glTF", b'"generator":"motiondb"'),
    (b"<!doctype html>", b'<meta name="generator" content="motiondb">'),
    (b"motiondb knowledge ", b""),
    (b'{\n "written_by": "motiondb"', b""),
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
    """Refuse the name of a picture or page that may not be overwritten, before it is made.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    QueryError
        Files of others are protected (:func:`protect_others`), and this is one.
    """
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


def provenance_path(path: Path) -> Path:
    """Return the file with the origin of every frame of a motion, beside the motion's file."""
    return path.with_name(f"{path.stem}.provenance.json")


def is_own(path: Path) -> bool:
    """Whether there is no file of this name, an empty one, or one that motiondb wrote."""
    try:
        with open_file(path) as file:
            head = file.read(_HEAD)
    except OSError:
        return True  # nothing to lose, or the writer says what is wrong
    is_marked = any(head.startswith(start) and mark in head for start, mark in MARKS)
    return not head or is_marked or _has_provenance(path)


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    digest = hashlib.sha256()
    with open_file(path) as file:
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
