"""Command serve: the page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from motiondb.cli.options import DEFAULT_DB, Db, Json, seconds_to_wait
from motiondb.cli.printing import print_json


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command()(serve)


def serve(
    host: Annotated[
        str,
        typer.Option(
            "--host", help="Address to listen at; other computers need the token that is printed."
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option("--port", min=0, max=65_535, help="Port to listen at; 0 for a free one.")
    ] = 8765,
    read_only: Annotated[
        bool, typer.Option("--read-only", help="The page cannot change anything.")
    ] = False,
    folders: Annotated[
        list[Path] | None,
        typer.Option(
            "--folder", help="A folder from which the page may add captures; may be repeated."
        ),
    ] = None,
    boards: Annotated[
        Path | None,
        typer.Option(
            "--boards", help="Folder of your tactics diagrams.  [default: boards, by the database]"
        ),
    ] = None,
    names: Annotated[
        list[str] | None,
        typer.Option(
            "--name", help="A further name by which browsers reach this computer; may be repeated."
        ),
    ] = None,
    open_browser: Annotated[
        bool, typer.Option("--open/--no-open", help="Whether to open the page in the browser.")
    ] = True,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Serve the page: the database in the browser, until Ctrl-C.

    The database is held only while a request is answered, so commands work beside it.
    """
    from motiondb import PageSettings
    from motiondb import serve as run

    settings = PageSettings(
        db,
        host,
        port,
        read_only,
        folders=tuple(folders or ()),
        boards=boards,
        wait=seconds_to_wait(),
        allowed_hosts=tuple(names or ()),
    )

    def told(address: str) -> None:
        if json:
            print_json({"address": address})
        else:
            typer.echo(f"The page is at {address}  (Ctrl-C ends it)")

    run(settings, told, lambda text: typer.echo(f"note: {text}", err=True), open_browser)
