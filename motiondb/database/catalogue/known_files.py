"""Files that are as they were when ``add`` read them last: they are not read again.

What is compared are path, size, time of modification and access of a file and its skeleton file,
and how it is to be read. Where size and options are the same and the time is not, the bytes are
compared, by their digest. A file that was changed in place with the same size and time is not
noticed, unless it is asked to look at the bytes (``AddSettings.check_bytes``).
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.body.world import Found
from motiondb.database.catalogue.file_reading import FileToRead, ReadFile, Readings, read_all
from motiondb.errors import CaptureError
from motiondb.files.formats import read_file
from motiondb.files.packed_files import Source, digest

if TYPE_CHECKING:
    from motiondb.database.cluster import Cluster

_OF_ADD = ("joint_map", "keep_implausible", "outside_skeletons", "skeleton")
"""Settings that decide, too."""


@dataclass
class KnownFiles:
    """The files to add, with what is known of them from before."""

    opened: store.Store
    jobs: Sequence[FileToRead]
    noted: dict[str, store.KnownFile] = field(default_factory=dict)  # New rows, not yet saved

    def __post_init__(self) -> None:
        """Look at the files before any is read: what changes later is read next time."""
        self._now = {job.name: (_state(job), _options(job)) for job in self.jobs}
        with store.reading(self.opened):
            self._rows = store.load_known_files(self.opened, [_path(job) for job in self.jobs])
            there = set(store.load_digests(self.opened))
            found = {job.name: self._find(job, there) for job in self.jobs}
            held = sorted({digest for readings in found.values() for digest in _digests(readings)})
            left_out = store.load_left_out(self.opened, held)
        self._same = {
            job.name: found[job.name]
            for job in self.jobs
            if found[job.name]
            and not (job.settings.originals and left_out & _digests(found[job.name]))
        }

    def read(self, n_jobs: int, workers: Cluster | None) -> Iterator[Readings]:
        """What the files hold, in order of the jobs; only those that may be new are read."""
        new = read_all(self.lacking, n_jobs, workers)
        for job in self.jobs:  # no name here holds readings: they take memory
            yield self._note(job, self._same.get(job.name) or next(new))

    def _note(self, job: FileToRead, readings: Readings) -> Readings:
        """Note what a file holds, to be saved with the batch; gives it."""
        row = store.KnownFile(*self._now[job.name], _to_text(job, readings))
        if self._rows.get(_path(job)) != row and job.settings.within is None:  # a folder that stays
            self.noted[_path(job)] = row
        return readings

    @property
    def lacking(self) -> list[FileToRead]:
        """The files that must be read."""
        return [job for job in self.jobs if job.name not in self._same]

    def _find(self, job: FileToRead, there: set[str]) -> Readings:
        """What a file held when it was read; nothing if it may hold something else now.

        `there`: Digests of the captures.
        """
        row, (state, options) = self._rows.get(_path(job)), self._now[job.name]
        if row is None or row.options != options or job.settings.reads_again:
            return ()
        readings = _from_text(job, row.readings)
        if not _digests(readings) <= there:
            return ()
        if row.state != state or job.settings.check_bytes:
            is_same = _sizes(row.state) == _sizes(state) and _digests(readings) == {_digest(job)}
            return readings if is_same else ()
        return readings


def _path(job: FileToRead) -> str:
    return os.path.abspath(job.path)  # noqa: PTH100  links stay


def _files(job: FileToRead) -> list[Path]:
    """A file and its skeleton file."""
    skeleton = job.skeleton()
    return [job.path] if skeleton is None else [job.path, skeleton]


def _state(job: FileToRead) -> str:
    """Name, access, size and time of a file and its skeleton file; "" where there is none."""
    try:
        stats = [(p.name, os.access(p, os.R_OK), p.stat()) for p in _files(job)]
    except (OSError, CaptureError):
        return ""
    return json.dumps([(name, may, stat.st_size, stat.st_mtime_ns) for name, may, stat in stats])


def _digests(readings: Readings) -> set[str]:
    return {each.source.sha256 for each in readings if each.source}


def _sizes(state: str) -> list[int]:
    return [size for _, _, size, _ in json.loads(state or "[]")]


def _options(job: FileToRead) -> str:
    """How a file is to be read, and by which version."""
    values = vars(job.options()) | {name: getattr(job.settings, name) for name in _OF_ADD}
    del values["within"]
    return json.dumps([store.motiondb_version(), values], default=str, sort_keys=True)


def _digest(job: FileToRead) -> str:
    """The digest of a file of one capture; "" if it cannot be read."""
    try:
        parts = [read_file(path, job.options()) for path in _files(job)]
        return digest(parts[0], parts[1] if parts[1:] else None)
    except CaptureError:
        return ""


def _to_text(job: FileToRead, readings: Readings) -> str:
    """Takes, digests, problems, skeletons and axes up of a file, as JSON."""
    return json.dumps(
        [
            (
                each.name[len(job.name) :],
                each.source.sha256 if each.source else "",
                each.problem,
                each.skeleton,
                vars(each.found) if each.found else None,
            )
            for each in readings
        ]
    )


def _from_text(job: FileToRead, text: str) -> Readings:
    """The same readings, without bytes and motion."""
    return tuple(
        ReadFile(
            job.name + take,
            f"{job.path}{take}" if problem else str(job.path),
            Source(sha256, "", "", b"") if sha256 else None,
            skeleton=skeleton,
            found=found and Found(**found | {k: tuple(found[k]) for k in ("scores", "notes")}),
            problem=problem,
            is_known=True,
        )
        for take, sha256, problem, skeleton, found in json.loads(text)
    )
