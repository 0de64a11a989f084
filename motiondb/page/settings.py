"""The settings with which the page is started."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from motiondb.files.folder import CAPTURE_ENDINGS

VERSION = version("motiondb")  # The installed version of motiondb
LOOPBACK = ("127.0.0.1", "::1", "localhost")  # Addresses that only this computer can reach
SKELETON_ENDINGS = (".asf",)
SHEET_ENDINGS = (".tsv", ".csv")


@dataclass(frozen=True)
class UploadLimits:
    """Limits for the data that a browser may send."""

    # Of one file. Chosen by hand: ten minutes of a large BVH at 120 frames a second have 60 MB
    file_bytes: int = 100 * 2**20
    request_bytes: int = 500 * 2**20  # Of all files of one request. Chosen by hand
    # Files of one request. Chosen by hand: a data set such as that of CMU has 2,500
    files: int = 3000
    # Of all uploads that the server keeps; the oldest are dropped. Chosen by hand
    kept_bytes: int = 2 * 2**30
    # Of a request that is not an upload. Chosen by hand: boards have some kilobytes
    body_bytes: int = 2 * 2**20


@dataclass(frozen=True)
class PageSettings:
    """How the page is served.

    Attributes
    ----------
    database : Path
        The database file.
    host : str
        Address to listen on.
    port : int
        Port to listen on; 0 for a free one.
    read_only : bool
        Whether the page refuses all changes, of the database and of boards.
    token : str
        Token that a browser must present; "" for none, which is allowed for loopback addresses
        only.
    folders : tuple of Path
        Folders on this computer from which captures may be added.
    boards : Path or None
        Folder of the user's tactics diagrams; None: ``boards`` beside the database.
    wait : float
        Seconds to wait for a process that holds the database.
    limits : UploadLimits
        Limits of uploads.
    allowed_hosts : tuple of str
        Further names by which browsers may reach the server.
    warm : bool
        Whether to load the data that questions need before the first question.
    """

    database: Path
    host: str = "127.0.0.1"
    port: int = 8765
    read_only: bool = False
    token: str = ""
    folders: tuple[Path, ...] = ()
    boards: Path | None = None
    wait: float = 5.0
    limits: UploadLimits = UploadLimits()
    allowed_hosts: tuple[str, ...] = ()
    warm: bool = True

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
    kinds = (("capture", CAPTURE_ENDINGS), ("skeleton", SKELETON_ENDINGS), ("sheet", SHEET_ENDINGS))
    return next((kind for kind, endings in kinds if ending in endings), "")
