"""Options shared by several commands, and opening the database."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

import typer

if TYPE_CHECKING:
    from motiondb import MotionDB

Function = TypeVar("Function", bound=Callable[..., Any])

Db = Annotated[
    Path, typer.Option("--db", envvar="MOTIONDB", help="The database file.", show_default=True)
]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]
Where = Annotated[
    str,
    typer.Option(
        "--where", help="Only captures that match, such as 'performer in (14, 16) and not fps<60'."
    ),
]
Exact = Annotated[
    bool,
    typer.Option(
        "--exact",
        help="Leave out words that are in no caption, instead of replacing them by known words.",
    ),
]
Limit = Annotated[int, typer.Option("--limit", min=1, help="Largest number of answers.")]
GrammarName = Annotated[str, typer.Argument(metavar="NAME", help="Name of a grammar.")]
MOST_SECONDS = 1e7  # Largest time that is accepted, seconds: some months, longer than any take


def finite(value: float | None) -> float | None:
    """Refuse NaN and infinity, which the ranges of options let pass."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"expected a finite number, found {value}.")
    return value


From = Annotated[
    float | None,
    typer.Option("--from", min=0.0, max=MOST_SECONDS, callback=finite, help="Start, in seconds."),
]
To = Annotated[
    float | None,
    typer.Option("--to", min=0.0, max=MOST_SECONDS, callback=finite, help="End, in seconds."),
]


def picture_name(path: Path | None) -> Path | None:
    """Check that the name of a picture ends in .png, before anything is computed."""
    if path is not None and path.suffix.lower() != ".png":
        from motiondb import QueryError

        raise QueryError(
            f"{path}: expected a name that ends in .png, found {path.suffix or 'no ending'!r}. "
            "Pictures are written as PNG."
        )
    return path


Png = Annotated[
    Path | None,
    typer.Option("--png", callback=picture_name, help="Draw a picture into this file (.png)."),
]


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
Seed = Annotated[
    int,
    typer.Option(
        "--seed", min=0, max=2**63 - 1, help="Random seed; the same seed gives the same result."
    ),
]
DEFAULT_DB = Path("motions.duckdb")
# Seconds that a command waits for the database by default: most commands that hold it alone take
# less time, and after a longer wait the user should see which process holds it
DEFAULT_WAIT = 5.0
LONGEST_WAIT = 86_400.0  # Largest number of seconds to wait: a day. A larger one is a mistake
Wait = Annotated[
    float,
    typer.Option(
        "--wait",
        envvar="MOTIONDB_WAIT",
        min=0.0,
        max=LONGEST_WAIT,
        help="Seconds to wait for a database that another process holds.",
    ),
]
_WAIT: ContextVar[float] = ContextVar("seconds to wait", default=DEFAULT_WAIT)


class Commands(typer.Typer):
    """A Typer app in which every command that opens a database has the option ``--wait``."""

    def command(self, *args: Any, **options: Any) -> Callable[[Function], Function]:
        """Register a function as a command."""
        register = super().command(*args, **options)

        def decorate(function: Function) -> Function:
            register(_waiting(function) if "db" in signature(function).parameters else function)
            return function

        return decorate

    def callback(self, *args: Any, **options: Any) -> Callable[[Function], Function]:
        """Register the function that a group runs before its commands, or alone."""
        register = super().callback(*args, **options)

        def decorate(function: Function) -> Function:
            register(_waiting(function) if "db" in signature(function).parameters else function)
            return function

        return decorate


def _waiting(function: Function) -> Function:
    """Add the parameter ``wait`` to a function; :func:`seconds_to_wait` returns its value."""

    @wraps(function)
    def command(*args: Any, wait: float = DEFAULT_WAIT, **values: Any) -> Any:
        _WAIT.set(wait)
        return function(*args, **values)

    known = signature(function, eval_str=True)
    last = Parameter("wait", Parameter.KEYWORD_ONLY, default=DEFAULT_WAIT, annotation=Wait)
    described: Any = command
    described.__signature__ = known.replace(parameters=[*known.parameters.values(), last])
    described.__annotations__ = {**function.__annotations__, "wait": Wait}
    return cast("Function", command)


def seconds_to_wait() -> float:
    """Return the value of --wait of the running command."""
    return _WAIT.get()


@contextmanager
def database(path: Path, *, writing: bool = False, create: bool = False) -> Iterator[MotionDB]:
    """Open the database and close it at the end.

    `writing`: Whether the command changes the database; then no other process can open the file.
    """
    from motiondb import MotionDB

    with MotionDB(path, read_only=not writing, create=create, wait=seconds_to_wait()) as db:
        _tell(db.log_note)
        yield db
    _tell(db.log_note)


def _tell(note: str) -> None:
    """Print a note, if there is one, on standard error."""
    if note:
        typer.echo(f"note: {note}", err=True)
