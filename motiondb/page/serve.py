"""Serve the page until the user ends it."""

from __future__ import annotations

import errno
import secrets
import shutil
import socket
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from motiondb.errors import MotionDBError
from motiondb.page.settings import NO_BUNDLE, PageSettings, is_built

END = 2  # Seconds that the server waits for open streams when it ends


@contextmanager
def private_folder() -> Iterator[Path]:
    """Yield a folder that only this user can read, and remove it at the end."""
    folder = Path(tempfile.mkdtemp(prefix="motiondb-page-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def check_settings(settings: PageSettings) -> None:
    """Check the settings before anything is opened."""
    for folder in settings.folders:
        if not folder.is_dir():
            raise MotionDBError(
                f"{folder}: expected a folder to add captures from, found none. Name another."
            )


def with_token(settings: PageSettings) -> PageSettings:
    """Return settings that have a token if other computers can reach the server."""
    if settings.is_local or settings.token:
        return settings
    return replace(settings, token=secrets.token_urlsafe(24))


def listen(settings: PageSettings) -> socket.socket:
    """Return a socket that listens at the address of the settings."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(
            settings.host, settings.port, type=socket.SOCK_STREAM
        )[0]
        listening = socket.socket(family, kind)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
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
        Called with instructions if the page was not built.
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
    with private_folder() as folder, listen(settings) as listening:
        application = make_application(settings, folder)
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
            threading.Timer(0.5, webbrowser.open, [address]).start()
        uvicorn.Server(config).run(sockets=[listening])
