"""Serve the page until the user ends it."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import signal
import socket
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from types import FrameType

from motiondb.errors import MotionDBError
from motiondb.page.settings import NO_BUNDLE, PageSettings, is_built

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]  # Windows has other locks

END = 2  # Seconds that the server waits for open streams when it ends
_PREFIX = "motiondb-page-"  # Of the names of private folders


@contextmanager
def private_folder() -> Iterator[Path]:
    """Yield a folder that only this user can read, and remove it at the end.

    A server locks its folder as long as it runs. Folders without a lock were left by servers that
    were killed, and are removed.
    """
    try:
        lefts = [*Path(tempfile.gettempdir()).glob(f"{_PREFIX}*")]
    except OSError as error:
        raise _no_folder(error) from None
    for left in lefts:
        with _locked(left, fcntl.LOCK_NB if fcntl else 0) as is_unused:
            if is_unused:
                shutil.rmtree(left, ignore_errors=True)
    while True:
        try:
            folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
        except OSError as error:
            raise _no_folder(error) from None
        with _locked(folder):
            if not folder.exists():
                continue  # another server has just taken it for one that was left
            try:
                yield folder
            finally:
                shutil.rmtree(folder, ignore_errors=True)
            return


def _no_folder(error: OSError) -> MotionDBError:
    return MotionDBError(
        f"serve: expected a folder for temporary files, found: {error.strerror or error}. Set"
        " TMPDIR (on Windows TEMP) to one that has room and can be written."
    )


@contextmanager
def _locked(folder: Path, how: int = 0) -> Iterator[bool]:
    """Lock a folder of this user while the block runs; gives whether that could be done."""
    try:
        descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
    except OSError:
        yield False
        return
    is_locked = False
    try:
        with suppress(OSError):
            if fcntl is not None and os.fstat(descriptor).st_uid == os.getuid():
                fcntl.flock(descriptor, fcntl.LOCK_EX | how)
                is_locked = True
        yield is_locked
    finally:
        os.close(descriptor)


@contextmanager
def _handled(end: Callable[[int, FrameType | None], None], *names: str) -> Iterator[None]:
    """Call a function at signals that would end the process while the block runs."""
    # a signal that is ignored, as nohup does, stays so; Windows has no SIGHUP
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    numbers = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():
        numbers = []
    for number in numbers:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)


def check_settings(settings: PageSettings) -> None:
    """Check the settings before anything is opened."""
    for folder in settings.folders:
        if not folder.is_dir():
            raise MotionDBError(
                f"{folder}: expected a folder to add captures from, found none. Name another."
            )


def with_token(settings: PageSettings) -> PageSettings:
    """Return settings that have a token if it is asked for, or other computers reach the server."""
    if (settings.is_local and not settings.always_token) or settings.token:
        return settings
    return replace(settings, token=secrets.token_urlsafe(24))


def listen(settings: PageSettings) -> socket.socket:
    """Return a socket that listens at the address of the settings."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(
            settings.host, settings.port, type=socket.SOCK_STREAM
        )[0]
        listening = socket.socket(family, kind)
        # on Windows, the option that lets others have an address again would let them share it
        alone = getattr(socket, "SO_EXCLUSIVEADDRUSE", None)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR if alone is None else alone, 1)
        listening.bind(address)
    except OSError as error:
        taken = error.errno == errno.EADDRINUSE
        advice = (
            "Choose another with --port, or 0 for any." if taken else "Check --host and --port."
        )
        raise MotionDBError(
            f"{settings.host}:{settings.port}: expected an address to listen at, found:"
            f" {error.strerror or error}. {advice}"
        ) from None
    return listening


def address_of(settings: PageSettings, port: int) -> str:
    """Return the address to open in a browser, with the token if there is one."""
    host = f"[{settings.host}]" if ":" in settings.host else settings.host
    host = {"0.0.0.0": socket.gethostname(), "[::]": socket.gethostname()}.get(host, host)
    return f"http://{host}:{port}/" + (f"?token={settings.token}" if settings.token else "")


def _to_open(address: str, settings: PageSettings, folder: Path) -> str:
    """Return what a browser is started with: the address, or a file of this user that leads to it.

    All users of a computer can see the arguments of its processes, and must not see the token.
    """
    if not settings.token:
        return address
    page = folder / "open.html"
    page.touch(mode=0o600)
    page.write_text(f'<meta http-equiv="refresh" content="0; url={address}">', "utf-8")
    return page.as_uri()


def serve(
    settings: PageSettings,
    announce: Callable[[str], None],
    warn: Callable[[str], None],
    open_browser: bool = True,
) -> None:
    """Serve the page until the process is interrupted.

    Parameters
    ----------
    settings : PageSettings
        What the user decided.
    announce : callable
        Called with the address once it can be opened.
    warn : callable
        Called with instructions if the page was not built, and with what is missing beside the
        database.
    open_browser : bool
        Whether to open it in the user's browser, if the page was built.

    Raises
    ------
    MotionDBError
        The database cannot be opened, or the address is already in use.
    """
    import uvicorn

    from motiondb.page.app import make_application

    check_settings(settings)
    settings = with_token(settings)
    if not is_built():
        warn(NO_BUNDLE)
    server: uvicorn.Server | None = None

    def end(number: int, frame: FrameType | None) -> None:
        if server is None or server.should_exit:  # before it runs, and again when it has ended
            raise SystemExit(128 + number)
        server.handle_exit(number, frame)

    with (
        _handled(end, "SIGTERM", "SIGHUP"),
        private_folder() as folder,
        listen(settings) as listening,
    ):
        application = make_application(settings, folder)
        if note := application.state.page.held.log_note:
            warn(note)
        address = address_of(settings, listening.getsockname()[1])
        config = uvicorn.Config(
            application,
            log_level="warning",
            access_log=False,
            server_header=False,
            date_header=False,
            timeout_graceful_shutdown=END,
            lifespan="on",
        )
        listening.listen(128)
        announce(address)
        if open_browser and is_built():
            shown = _to_open(address, settings, folder)
            threading.Timer(0.5, webbrowser.open, [shown]).start()
        server = uvicorn.Server(config)
        server.run(sockets=[listening])
