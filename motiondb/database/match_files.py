"""The intervals of an answer as files, each with a file beside it that says where it comes from."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from motiondb import store
from motiondb.answers.catalogue import MatchFile
from motiondb.answers.plain import to_json
from motiondb.database.catalogue.parts import write_bytes
from motiondb.errors import QueryError
from motiondb.files.own_files import WRITER, check_overwriting, digest_of, provenance_path
from motiondb.records import Match

Export = Callable[[str, Path, float, float], object]
"""Writes the part of a capture from start to end (seconds) into a file."""
_UNUSUAL = re.compile(r"[^\w.-]+")


def write_matches(
    opened: store.Store, matches: Sequence[Match], folder: Path, question: str, export: Export
) -> list[MatchFile]:
    """Write a BVH file for every match, and beside it where it comes from."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise QueryError(
            f"{folder}: expected a folder that can be made, found: {error.strerror}. Name another."
        ) from None
    paths = [folder / f"{_name(match)}.bvh" for match in matches]
    for path in paths:  # before any is written
        check_overwriting(path)
        check_overwriting(provenance_path(path))
    return [_write(opened, match, path, question, export) for match, path in zip(matches, paths)]


def _write(
    opened: store.Store, match: Match, path: Path, question: str, export: Export
) -> MatchFile:
    """Write one match and its origin."""
    info = store.load_capture(opened, match.capture)
    sources = store.load_provenance(opened, info.capture_id).sources
    licence = info.tags.get("licence", "unknown")
    export(match.capture, path, match.start, match.end)
    origin = {
        "written_by": WRITER,
        "sha256": digest_of(path),
        "question": question,
        "rank": match.rank,
        "capture": match.capture,
        "start": match.start,
        "end": match.end,
        "place": match.place,
        "score": match.score,
        "probability": match.probability,
        "kind": info.kind,
        "licence": licence,
        "performer": info.tags.get("performer", "unknown"),
        "file": info.path,
        "file_sha256": info.sha256,
        "made_of": [vars(source) for source in sources],
    }
    beside = provenance_path(path)
    write_bytes(beside, json.dumps(to_json(origin), indent=1).encode())
    return MatchFile(match.rank, match.capture, path, beside, licence)


def _name(match: Match) -> str:
    """The name of a file: rank, capture and interval."""
    plain = _UNUSUAL.sub("-", match.capture.replace("/", "-"))[:100]
    return f"{match.rank:03d}_{plain}_{match.start:.2f}-{match.end:.2f}"
