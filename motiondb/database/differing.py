"""Which captures another database has too."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, store
from motiondb.database import loading
from motiondb.database.catalogue import merging
from motiondb.errors import QueryError
from motiondb.files.safe_files import check_file_name
from motiondb.records import MOTION_FPS, CaptureInfo, Float32Array, IntArray
from motiondb.search import copies
from motiondb.search.copy_outlines import N_AXES, Int16Array

if TYPE_CHECKING:
    from motiondb.database.session import Session

Progress = Callable[[str, float, float], None]


def diff(
    session: Session,
    infos: Sequence[CaptureInfo],
    path: Path,
    wait: float,
    progress: Progress | None,
) -> answers.DiffAnswer:
    """Compare captures with those of another database, as :meth:`MotionDB.diff` says."""
    tell = progress or (lambda _what, _done, _total: None)
    check_file_name(path)
    if path.exists() and path.samefile(session.store.path):
        raise QueryError(f"{path}: expected another database, found this one. Name another.")
    merging.check(path, "", wait)
    with (
        store.open_store(path, read_only=True, wait=wait, is_others=True) as other,
        store.reading(other),
        session.reading(),
    ):
        tell("comparing", 0, 1)
        both = _Both(session.store, infos, other)
        shared = both.same_files()
        known = {(each.capture, each.other) for each in shared}
        shared += [each for each in both.same_motions() if (each.capture, each.other) not in known]
        tell("comparing", 1, 1)
        notes = [other.loss_note] if other.loss_note else []
        notes += [f"{name}: its motion cannot be read, it was not compared" for name in both.unread]
    shared.sort(key=lambda each: (each.capture, each.distance, each.other))
    return answers.DiffAnswer(
        path,
        len(infos),
        len(both.there),
        tuple(shared),
        len({info.name for info in infos} - {each.capture for each in shared}),
        len({info.name for info in both.there} - {each.other for each in shared}),
        tuple(notes),
    )


class _Part:
    """The captures of one database that can be compared."""

    def __init__(self, opened: store.Store, infos: Iterable[CaptureInfo]) -> None:
        held = loading.load_outlines(opened)
        place = {number: n for n, number in enumerate(held.capture_ids.tolist())}
        every = list(infos)
        self.opened = opened
        self.infos = [info for info in every if info.capture_id in place]
        self.unread = [info.name for info in every if info.capture_id not in place]
        places = np.array([place[info.capture_id] for info in self.infos], dtype=np.int64)
        self.firsts, self.ends = held.bounds[places], held.bounds[places + 1]
        self.reaches = held.values[places]
        self.rows = held.rows if len(held.rows) else np.zeros((0, N_AXES), dtype=np.int16)
        self.n_rows = int(held.bounds[-1])


class _Rows:
    """Outlines of two databases, one after another, read where they are looked at."""

    def __init__(self, first: _Part, second: _Part) -> None:
        self.parts, self.edge = (first, second), first.n_rows

    def __getitem__(self, which: slice | IntArray, /) -> Int16Array:
        """Rows between two numbers of one database, or of an array of numbers."""
        if isinstance(which, slice):
            if which.start >= self.edge:
                moved = slice(which.start - self.edge, which.stop - self.edge)
                return np.asarray(self.parts[1].rows[moved])
            below = self.parts[0].rows[which.start : min(which.stop, self.edge)]
            more = self.parts[1].rows[0 : max(0, which.stop - self.edge)]
            return np.concatenate([below, more])
        out = np.empty((*which.shape, N_AXES), dtype=np.int16)
        there = which >= self.edge
        out[~there] = self.parts[0].rows[which[~there]]
        out[there] = self.parts[1].rows[which[there] - self.edge]
        return out


class _Both:
    """Captures here and those of another database."""

    def __init__(
        self, opened: store.Store, here: Sequence[CaptureInfo], other: store.Store
    ) -> None:
        self.here, self.there = here, store.load_captures(other)
        self.mine, self.theirs = _Part(opened, here), _Part(other, self.there)
        self.unread = [*self.mine.unread, *self.theirs.unread]

    def same_files(self) -> list[answers.SharedCapture]:
        """Captures of equal bytes."""
        by_digest: Mapping[str, CaptureInfo] = {info.sha256: info for info in self.there}
        pairs = [(info, by_digest.get(info.sha256)) for info in self.here if info.sha256]
        return [_shared(a, b, "same file", 0.0, a.duration, 0.0) for a, b in pairs if b is not None]

    def same_motions(self) -> list[answers.SharedCapture]:
        """Captures of equal motion, whole or in part, as it is or mirrored."""
        mine, theirs = self.mine, self.theirs
        n = len(mine.infos)
        infos = [*mine.infos, *theirs.infos]

        def poses_of(place: int) -> Float32Array:
            opened = mine.opened if place < n else theirs.opened
            return copies.copy_poses(store.load_motion(opened, infos[place].capture_id))

        library = copies.Library(
            np.concatenate([mine.ends - mine.firsts, theirs.ends - theirs.firsts]),
            np.concatenate([mine.reaches, theirs.reaches]),
            np.concatenate([mine.firsts, theirs.firsts + mine.n_rows]),
            _Rows(mine, theirs),
            poses_of,
        )
        first, second = list(range(n)), list(range(n, len(infos)))
        found = copies.find_copies(library, first, second)
        found += copies.find_copies(library, second, first)
        out = []
        for each in found:
            is_mine = each.query < n
            a, b = (each.query, each.take) if is_mine else (each.take, each.query)
            kinds = {"same": "same motion", "mirror": "mirrored"}
            kind = kinds.get(each.kind, "part of it" if is_mine else "contains it")
            start, end = each.start / MOTION_FPS, each.end / MOTION_FPS
            out.append(_shared(infos[a], infos[b], kind, start, end, each.distance))
        as_it_is = {(each.capture, each.other) for each in out if each.kind != "mirrored"}
        return [  # motion that is alike on both sides is its own mirror image
            e for e in out if e.kind != "mirrored" or (e.capture, e.other) not in as_it_is
        ]


def _shared(
    here: CaptureInfo, there: CaptureInfo, kind: str, start: float, end: float, distance: float
) -> answers.SharedCapture:
    return answers.SharedCapture(
        here.name,
        there.name,
        kind,
        abs(here.fps - there.fps) > 0.01 * here.fps,
        round(start, 3),
        round(end, 3),
        round(distance, 5),
        here.fps,
        there.fps,
        here.tags.get("licence", "unknown"),
        there.tags.get("licence", "unknown"),
    )
