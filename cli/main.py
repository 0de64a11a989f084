"""The Typer app, and the one place where an error becomes a sentence and an exit code."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from motiondb.cli import asking, cataloguing, keeping, learning, words

app = typer.Typer(
    name="motiondb",
    help="A motion-capture database that understands what is in it.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        from motiondb import __version__

        typer.echo(f"motiondb {__version__}")
        raise typer.Exit()


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version.")
    ] = False,
) -> None:
    pass


INTERRUPTED = 130

for module in (cataloguing, learning, asking, words, keeping):
    module.register(app)


def main() -> None:
    """Run the command line: 0 done, 1 wrong data, 2 wrong use, 130 interrupted."""
    try:
        sys.exit(_run())
    except KeyboardInterrupt:  # while ending or importing
        sys.exit(_interrupted())


def _run() -> int:
    from motiondb.errors import MotionDBError, NotLearnedError, QueryError

    try:
        app()
    except (QueryError, NotLearnedError) as error:
        typer.echo(f"error: {error}", err=True)
        return 2
    except MotionDBError as error:
        typer.echo(f"error: {error}", err=True)
        return 1
    except SystemExit as ended:  # Typer ends every command so, an interrupted one with 130
        if ended.code == INTERRUPTED:
            return _interrupted()
        raise
    return 0


def _interrupted() -> int:
    typer.echo("interrupted: the database is as it was", err=True)
    return INTERRUPTED
