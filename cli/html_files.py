"""The option ``--html``: a file with the answer, its motions and a player, for any browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from motiondb import StandalonePage


def html_name(path: Path | None) -> Path | None:
    """Check ending of the file name, and that the page was built, before anything is computed."""
    if path is None:
        return None
    from motiondb import QueryError, StandalonePage

    if path.suffix.lower() not in (".html", ".htm"):
        raise QueryError(
            f"{path}: expected a name that ends in .html, found {path.suffix or 'no ending'!r}."
        )
    StandalonePage.check()
    return path


Html = Annotated[
    Path | None,
    typer.Option(
        "--html",
        callback=html_name,
        help="Write a page with the answer and a player into this file (.html).",
    ),
]


def write_html(path: Path, page: StandalonePage) -> None:
    """Write the page, and say so on standard error."""
    page.write(path)
    typer.echo(f"page: {path}", err=True)
