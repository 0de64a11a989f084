"""The verbs of a whole library: what to train on, what it holds and lacks, what another one has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers
from motiondb.database.session import Topic

if TYPE_CHECKING:
    from motiondb.database.curating import CurateSettings
    from motiondb.database.selections import Selections
    from motiondb.database.values import Where
    from motiondb.records import CaptureInfo

    Progress = Callable[[str, float, float], None]


class Library(Topic):
    """The verbs of a whole library, which :class:`MotionDB` has."""

    @cached_property
    def selections(self) -> Selections:
        """The verbs of selections: list (``db.selections()``), show, add, take, remove, export."""
        from motiondb.database.selections import Selections

        return Selections(self.session)

    def curate(
        self,
        settings: CurateSettings,
        where: Where = "",
        folder: str | Path | None = None,
        progress: Progress | None = None,
    ) -> answers.CurateAnswer:
        """Choose the part of a library that is worth training on, and write it.

        Intervals of 2 to 10 s are chosen that cover all plausible motion best (facility location,
        lazy greedy). What a choice of that length can reach at most is told as a bound on the mean
        distance. Every second that is not chosen has a reason.

        Parameters
        ----------
        settings : CurateSettings
            How much, what is left out, and how files are written.
        where : str or names
            Only these captures, such as "licence=CMU".
        folder : str or Path, optional
            A new or empty folder for the intervals and ``manifest.csv`` and ``.json``; it is there
            whole or not at all. None: nothing is written.

        Raises
        ------
        QueryError
            When settings mean nothing, or nothing may be chosen.
        """
        from motiondb.database import curating

        path = None if folder is None else Path(folder)
        return curating.curate(self.session, self._bodies(where), settings, path, progress)

    def coverage(
        self,
        where: Where = "",
        words: Sequence[str] | Path = (),
        png: str | Path | None = None,
        progress: Progress | None = None,
    ) -> answers.CoverageAnswer:
        """What a library holds and lacks, and what to record next.

        Kinds of going by turns, starts, stops and changes by the foot ahead, in seconds or times
        and performers; symbols by what comes before, if the database has learned; and words.

        Parameters
        ----------
        words : sequence of str, or Path
            Questions in words, such as "kick", or a file with one a line; the database must have
            learned.
        png : str or Path, optional
            Draw the tables of going into this file.
        """
        from motiondb.database import covered

        return covered.coverage(self.session, self._bodies(where), words, png, progress)

    def diff(
        self,
        other: str | Path,
        where: Where = "",
        wait: float = 0.0,
        progress: Progress | None = None,
    ) -> answers.DiffAnswer:
        """Which captures another library has too: as they are, copied, cut, mirrored, resampled.

        The other database is only read, and not brought up to date.

        Parameters
        ----------
        wait : float
            Seconds to wait for another process that holds the other database.
        """
        from motiondb.database.catalogue import merging

        return merging.diff(self.session, self._infos(where), Path(other), wait, progress)

    def _bodies(self, where: Where) -> list[CaptureInfo]:
        """Captures of a body; markers without one show no motion."""
        return [info for info in self._infos(where) if info.has_body]

    def _infos(self, where: Where) -> list[CaptureInfo]:
        from motiondb.database.captures import Captures

        return list(Captures(self.session)(where))
