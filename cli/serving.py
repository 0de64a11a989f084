"""Command serve: the page in the browser."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import motiondb
from motiondb.cli import options, printing

app = options.Commands()


@app.command()
def serve(
    shared: options.Shared,
    host: Annotated[
        str, "Address to listen at; other computers need the token that is printed."
    ] = "127.0.0.1",
    port: Annotated[
        int, options.option("Port to listen at; 0 for a free one.", min=0, max=65_535)
    ] = 8765,
    read_only: Annotated[bool, "The page cannot change anything."] = False,
    folders: Annotated[
        list[Path] | None,
        options.option(
            "A folder from which the page may add captures; may be repeated.", "--folder"
        ),
    ] = None,
    boards: Annotated[
        Path | None, "Folder of your tactics diagrams.  [default: boards, by the database]"
    ] = None,
    names: Annotated[
        list[str] | None,
        options.option(
            "A further name by which browsers reach this computer; may be repeated.", "--name"
        ),
    ] = None,
    token: Annotated[
        bool, "Require the token that is printed also from this computer, where others use it."
    ] = False,
    open_browser: Annotated[
        bool, options.option("Whether to open the page in the browser.", "--open/--no-open")
    ] = True,
) -> None:
    """Serve the page: the database in the browser, until Ctrl-C.

    The database is held only while a request is answered, so commands work beside it.
    """
    settings = motiondb.PageSettings(
        shared.db,
        host,
        port,
        read_only,
        folders=tuple(folders or ()),
        boards=boards,
        wait=shared.wait,
        allowed_hosts=tuple(names or ()),
        always_token=token,
    )

    def told(address: str) -> None:
        if not printing.as_json(shared, {"address": address}):
            printing.say(f"The page is at {address}  (Ctrl-C ends it)")

    try:
        motiondb.serve(settings, told, lambda text: printing.warn(f"note: {text}"), open_browser)
    except SystemExit as ended:  # by a signal; a question may still be computed, for minutes
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(int(ended.code or 0))
