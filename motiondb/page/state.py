"""The state of a running server: the database, uploads, jobs, motions that were made; refs.

Refs are names by which the browser requests anything that can be played: ``capture:NAME`` is a
stored capture, ``upload:ID/FILE`` an uploaded file, ``made:ID`` a motion generated from a sentence,
``sequence:ID`` one from a grammar, ``scene:ID`` a scene that was made, ``kept:NAME`` a scene in the
database. ``first:ID`` is the first motion of a scene that is being made or updated.

The database is held only while requests are answered. DuckDB lets one process write or several
read. The page holds the file only while it answers, so that commands can use the database as well;
new requests wait while another process waits for the file. Loaded values stay in memory until the
database changes.
"""

from __future__ import annotations

import re
import secrets
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar

from motiondb.answers.database import DatabaseInfo
from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.database.catalogue.browsing import BrowsedCapture
from motiondb.database.catalogue.parts import cut_motion
from motiondb.database.generating import Generated
from motiondb.database.grammars.grammar_sequences import GrammarSequence
from motiondb.database.loading import make_frames
from motiondb.database.scenes.scene_records import record_text
from motiondb.database.session import Lent
from motiondb.errors import MotionDBError
from motiondb.files.safe_files import link_target, log_of
from motiondb.learn.drift import Drift
from motiondb.page.errors import PageError, unknown
from motiondb.page.jobs import FACTS_FILE, FIRST_FILE, MOTION_FILE, Jobs
from motiondb.page.motion import Track, part_of, read_tracks, scene_tracks
from motiondb.page.settings import PageSettings
from motiondb.page.uploads import Uploads
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.language.activity import Thing
from motiondb.store import StoredScene, somebody_waits

T = TypeVar("T")

MOST_UNDONE = 100  # Largest number of edits of words that can be undone


class Shelf(Generic[T]):
    """The most recently used values of one kind, each under a random id.

    Ids are random, so that a page that was loaded before a restart of the server does not get a
    wrong value. A value that is requested counts as new again.
    """

    def __init__(self, prefix: str, what: str, most: int = 200) -> None:
        self._prefix, self._what, self._most = prefix, what, most
        self._values: OrderedDict[str, T] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, value: T) -> str:
        """Keep a value, and return its id."""
        with self._lock:
            name = f"{self._prefix}{secrets.token_hex(5)}"
            self._values[name] = value
            while len(self._values) > self._most:
                self._values.popitem(last=False)
            return name

    def find(self, name: str) -> T | None:
        """Return the value of an id, or None. It counts as new again."""
        with self._lock:
            if name in self._values:
                self._values.move_to_end(name)
            return self._values.get(name)

    def get(self, name: str) -> T:
        """Return the value of an id. It counts as new again."""
        value = self.find(name)
        if value is None:
            raise unknown(
                self._what, name, f"The server keeps the newest {self._most}. Make it again."
            )
        return value

    def replace(self, name: str, value: T) -> None:
        """Replace the value of an id, if it is still there."""
        with self._lock:
            if name in self._values:
                self._values[name] = value


@dataclass(frozen=True, eq=False)
class Moment:
    """The part of a capture in which most happens, and the pose that shows it; seconds."""

    start: float
    end: float
    pose: float
    speed: float  # Mean speed of the body against its pelvis, metres per second
    shape: FloatArray  # The pose as numbers, as `best_moment` gives them


@dataclass(frozen=True)
class Block:
    """An action of a sentence on its timeline: what is asked for, and where it is taken from."""

    phrase: str
    seconds: float | None = None  # How long it is to take; None where only the phrase says so
    place: int | None = None  # Number of one of the places that show it about as clearly
    capture: str | None = None  # Name of the capture of an excerpt that was picked by hand
    start: float | None = None  # The picked excerpt, seconds of the capture
    end: float | None = None


@dataclass(frozen=True, eq=False)
class MadeMotion:
    """A motion generated from a sentence."""

    generated: Generated
    saved: str = ""  # Name of the capture that holds it, or ""
    blocks: tuple[Block, ...] = ()  # The blocks that it was asked for with, or none


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
    run: int = 0  # The run that learned or edited its grammar


@dataclass(frozen=True)
class Edit:
    """An edit of captures, which can be undone."""

    captures: tuple[str, ...]  # Names as they were before it
    run: int  # Number of the run that made it
    what: str  # "words", "tags", "selection", "name" or "removal"


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
        self.edits: deque[Edit] = deque(maxlen=MOST_UNDONE)
        # Number and digest of a capture -> the part in which most happens, once looked for
        self.moments: dict[tuple[int, str], Moment | None] = {}
        self.editing = threading.Lock()
        self.closing = threading.Event()
        self.watch = Watch(self.held, settings.warm)

    @contextmanager
    def reading(self) -> Iterator[MotionDB]:
        """Yield the database in one state, even if others save changes."""
        with self.held.use() as db, db.session.reading():
            yield db

    @contextmanager
    def changing(self) -> Iterator[MotionDB]:
        """Yield the database for a change, one at a time; refuse it if the page is read-only."""
        self.check_writable()
        with self.held.use() as db, self.editing:
            yield db

    def check_writable(self) -> None:
        """Refuse a change if the page was started read-only."""
        if self.settings.read_only:
            raise PageError(
                "page: expected to change the database, found a page that was started with"
                " --read-only. Start motiondb serve without it.",
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
        facts = (self.folder / "scenes").glob(f"*/{FACTS_FILE}")
        return [p.parent.name for p in sorted(facts, key=lambda p: -p.stat().st_mtime)]

    def close(self) -> None:
        """End jobs and close the database."""
        self.closing.set()
        self.watch.stop()
        self.jobs.close()
        self.held.close()


KINDS = ("capture", "upload", "made", "sequence", "scene", "first", "kept")


@dataclass(frozen=True)
class Ref:
    """A ref in its parts."""

    kind: str
    name: str

    def __str__(self) -> str:
        """Return the ref as text."""
        return f"{self.kind}:{self.name}"


def read_ref(text: str) -> Ref:
    """Return the parts of a ref."""
    kind, colon, name = text.partition(":")
    if not colon or kind not in KINDS or not name:
        raise PageError(
            f"ref: expected one of {', '.join(f'{k}:NAME' for k in KINDS)}, found {text[:100]!r}."
        )
    return Ref(kind, name)


def find_row(db: MotionDB, name: str) -> BrowsedCapture:
    """Return the row of a stored capture."""
    row = db.captures.browsed(name)
    if row is None:
        raise unknown("capture", name, "It may have been removed or renamed.")
    return row


def find_kept(db: MotionDB, name: str) -> StoredScene:
    """Return a scene that is kept in the database."""
    if name not in db.scenes.names():
        raise unknown("scene", name, "It may have been removed.")
    return db.scenes.load(name)


def load_motion(
    page: Page, db: MotionDB, ref: Ref, start: float | None = None, end: float | None = None
) -> Motion:
    """Return the motion of a ref, or the part of it from start to end (seconds)."""
    if ref.kind == "capture":
        return db.motion(find_row(db, ref.name).info.name, start, end)
    if ref.kind == "upload":
        upload_id, _, file = ref.name.partition("/")
        return db.motion(page.uploads.path(upload_id, file or "/"), start, end)
    if ref.kind == "made":
        return cut_motion(page.made.get(ref.name).generated.motion, start, end, FEATURE_STEP)
    if ref.kind == "sequence":
        return cut_motion(page.sequences.get(ref.name).sequence.motion, start, end, FEATURE_STEP)
    raise PageError(f"{ref}: expected one motion, found a scene with several. Name a capture.")


def load_scene(
    page: Page, db: MotionDB, ref: Ref, start: float | None, end: float | None, fps: float
) -> list[Track]:
    """Return the tracks of a scene, or of a part of it."""
    made = made_scene(page, ref)
    if made is not None:
        tracks = read_tracks(made)
    else:
        record = find_kept(db, ref.name)
        motions = db.scenes.motions(record)
        teams = {player.name: player.team for player in record.players}
        thing = record_text(record).grammar.activity.thing or Thing("ball")
        tracks = scene_tracks(motions, teams, record.ball, str(ref), thing.size)
    return [_part(track, start, end, fps) for track in tracks]


def made_scene(page: Page, ref: Ref) -> bytes | None:
    """Return the whole motion of a scene that a job of this server made, as binary.

    None for a scene that is kept in the database.
    """
    if ref.kind == "scene":
        return (page.scene_folder(ref.name) / MOTION_FILE).read_bytes()
    if ref.kind == "first":
        return (page.scene_folder(ref.name, FIRST_FILE) / FIRST_FILE).read_bytes()
    return None


def _part(track: Track, start: float | None, end: float | None, fps: float) -> Track:
    """Return the part of a track from start to end (seconds), at the same or a lower frame rate."""
    n_frames = len(track.points)
    low = min(round((start or 0.0) * MOTION_FPS), n_frames)
    high = n_frames if end is None else min(round(end * MOTION_FPS), n_frames)
    return part_of(track, low, high, fps)


_LEAVE, _PAUSE = 1.0, 0.01
"""Seconds for which the file is left to a process that waits for it, which tries five times a
second or more often; and between two checks whether it still waits."""
EXAMPLE = 2.0  # Longest example, in seconds, by which the data for examples are loaded


def info_and_drift(db: MotionDB) -> tuple[DatabaseInfo, Drift | None]:
    """Return what ``info`` and ``drift`` give, computed once a revision; drift may be None."""

    def load() -> tuple[DatabaseInfo, Drift | None]:
        info = db.info()
        return info, db.symbols.drift() if info.learned else None

    return db.session.kept("info and drift", load)


class HeldDatabase:
    """A database that is opened for requests, and released when the last running one has ended."""

    def __init__(self, path: Path, read_only: bool, wait: float) -> None:
        self.path = path
        self._database = MotionDB(path, read_only=read_only, create=not read_only, wait=wait)
        self._lent = Lent(self._database, self._database.release)

    @property
    def log_note(self) -> str:
        """That the file was brought up to date, or came without its log, when opened; or ""."""
        return "\n".join(filter(None, (*self._database.store.notes, self._database.store.log_note)))

    @contextmanager
    def use(self) -> Iterator[MotionDB]:
        """Yield the database; it stays open for the length of the ``with`` block.

        Blocks of one thread must not be nested: the inner one would wait for the outer one if
        another process waits for the file.
        """
        self._give_way()
        with self._lent.use() as db:
            yield db

    def _give_way(self) -> None:
        """Wait until a process that waits for the file has had it, for ``_LEAVE`` s at most."""
        free_since = None
        while somebody_waits(self.path):
            now = time.monotonic()
            if self._lent.is_used:  # running requests end first
                free_since = None
            elif free_since is None:
                free_since = now
            elif now - free_since > _LEAVE:
                return
            time.sleep(_PAUSE)

    def warm_view(self) -> None:
        """Load what the first view of the page needs."""
        with suppress(MotionDBError), self.use() as db:  # the first request will tell
            db.captures.browse()
            info_and_drift(db)

    def warm(self) -> None:
        """Load the data that questions need, so that the first user does not wait for it."""
        self.warm_view()
        with suppress(MotionDBError):
            self._warm_frames()
            with self.use() as db:
                learned = db.learned
                if learned.has_words:
                    db.search(db.words.vocabulary()[0], limit=1)
                if learned.rows:
                    first = learned.captures[min(learned.rows)]
                    db.like(first.name, 0.0, min(first.duration, EXAMPLE), limit=1)

    def _warm_frames(self) -> None:
        """Compute the frames of all captures, while the file is free.

        Of all data they take longest.
        """
        with self.use() as db:
            learned = db.session.without_rows if db.is_learned() else None
            motions = db.session.lacking_frames() if learned else {}
        if learned and motions:
            made = dict(zip(motions, make_frames(learned, list(motions.values()))))
            with self.use() as db:
                db.session.keep_frames(made, learned)

    def close(self) -> None:
        """Close the file."""
        self._database.close()


EVERY = 0.5  # Seconds between two checks of the file
# Number of checks without a change after which the data for questions are loaded: a command that
# follows another immediately can open the file first
QUIET = 3


class Watch:
    """The revision of a database, watched by a thread.

    Only the size and the modification time of the file are checked, so that the file is not held.
    """

    def __init__(self, held: HeldDatabase, warm: bool) -> None:
        self._held, self._warms = held, warm
        self._ended = threading.Event()
        self._mark = self._stamp()
        self.revision = self._read()

    def start(self) -> None:
        """Start the thread."""
        threading.Thread(target=self._look, daemon=True).start()

    def stop(self) -> None:
        """Stop the thread."""
        self._ended.set()

    def _look(self) -> None:
        if self._warms:  # whoever starts the server opens the page next
            self._held.warm_view()
        quiet, is_warm = 0, not self._warms
        while not self._ended.wait(EVERY):
            mark = self._stamp()
            if mark != self._mark:
                quiet, is_warm = 0, not self._warms
                with suppress(MotionDBError):  # held by another process: try again later
                    revision = self._read()
                    self._mark, self.revision = mark, revision
            elif not is_warm:
                quiet += 1
                if quiet >= QUIET:
                    is_warm = True
                    self._held.warm()

    def _read(self) -> int:
        with self._held.use() as db:
            return db.revision()

    def _stamp(self) -> tuple[int, ...]:
        """Return size, time and inode of the file and of DuckDB's write-ahead log."""
        stamp: list[int] = []
        file = link_target(self._held.path)
        for path in (file, log_of(file)):
            with suppress(OSError):
                facts = path.stat()
                stamp += [facts.st_size, facts.st_mtime_ns, facts.st_ino]
        return tuple(stamp)
