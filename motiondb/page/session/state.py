"""The state of a running server: the database, uploads, jobs, and motions that were made."""

from __future__ import annotations

import re
import threading
from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path

from motiondb.database.generating import Generated
from motiondb.database.grammars.grammar_sequences import GrammarSequence
from motiondb.page.answers import PageError, unknown
from motiondb.page.facts.scene_facts import FACTS_FILE
from motiondb.page.files.uploads import Uploads
from motiondb.page.long_work.jobs import Jobs
from motiondb.page.session.held import HeldDatabase
from motiondb.page.session.memory import Shelf
from motiondb.page.session.watching import Watch
from motiondb.page.settings import PageSettings
from motiondb.records import Caption

MOST_UNDONE = 100  # Largest number of edits of words that can be undone


@dataclass(frozen=True, eq=False)
class MadeMotion:
    """A motion generated from a sentence."""

    generated: Generated
    saved: str = ""  # Name of the capture that holds it, or ""


@dataclass(frozen=True, eq=False)
class MadeSequence:
    """A sequence of a grammar."""

    sequence: GrammarSequence
    seed: int  # The seed it was made from
    parent: str = ""  # Id of the sequence of which it is an edit, or ""
    edited: tuple[int, int] | None = None  # Positions that differ from the parent
    # Parameters of the edit, which are stored with the sequence when it is saved
    how: dict[str, object] = field(default_factory=dict)
    saved: str = ""  # Name of the capture that holds it, or ""

    def saved_as(self, name: str) -> MadeSequence:
        """Return a copy with the name of the capture that holds it."""
        return replace(self, saved=name)


@dataclass(frozen=True)
class WordEdit:
    """An edit of the captions of one capture, which can be undone."""

    capture: str  # Name of the capture
    before: tuple[Caption, ...]
    after: tuple[Caption, ...]


class Page:
    """The state of a running server."""

    def __init__(self, settings: PageSettings, folder: Path) -> None:
        self.settings = settings
        self.folder = folder
        for name in ("uploads", "scenes", "work"):
            (folder / name).mkdir(mode=0o700, exist_ok=True)
        self.held = HeldDatabase(settings.database, settings.read_only, settings.wait)
        self.uploads = Uploads(folder / "uploads", settings.limits)
        self.jobs = Jobs(settings.database, settings.read_only, folder / "work")
        self.made: Shelf[MadeMotion] = Shelf("m", "generated motion")
        self.sequences: Shelf[MadeSequence] = Shelf("q", "sequence")
        self.edits: deque[WordEdit] = deque(maxlen=MOST_UNDONE)
        self.editing = threading.Lock()
        self.closing = threading.Event()
        self.watch = Watch(self.held, settings.warm)

    def check_writable(self) -> None:
        """Refuse a change if the page was started read-only."""
        if self.settings.read_only:
            raise PageError(
                "page: expected to change the database, found a page that was started with"
                " --read-only. Start motiondb serve without it.",
                403,
                "ReadOnlyError",
            )

    def scene_folder(self, scene_id: str, file: str = FACTS_FILE) -> Path:
        """Return the folder of a scene that a job made.

        `file`: The file that must be there: the facts, which a job writes last, or an earlier one.
        """
        folder = self.folder / "scenes" / scene_id
        if not re.fullmatch(r"s[0-9a-f]{10}", scene_id) or not (folder / file).is_file():
            raise unknown("scene", scene_id, "Make it again.")
        return folder

    def scene_ids(self) -> list[str]:
        """Return the ids of the scenes that jobs made, newest first."""
        folders = [
            path for path in (self.folder / "scenes").iterdir() if (path / FACTS_FILE).is_file()
        ]
        return [p.name for p in sorted(folders, key=lambda p: -(p / FACTS_FILE).stat().st_mtime)]

    def close(self) -> None:
        """End jobs and close the database."""
        self.closing.set()
        self.watch.stop()
        self.jobs.close()
        self.held.close()
