"""Options that several commands share, and how commands open the database and end."""

from __future__ import annotations

import json as jsonlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

import typer

if TYPE_CHECKING:
    from motiondb.database import MotionDB
    from motiondb.learning.drift import Drift
    from motiondb.words.nearby.taking import Taking

Function = TypeVar("Function", bound=Callable[..., Any])

Db = Annotated[
    Path, typer.Option("--db", envvar="MOTIONDB", help="The database file.", show_default=True)
]
Json = Annotated[bool, typer.Option("--json", help="Answer in JSON, for programs.")]
Where = Annotated[
    str, typer.Option("--where", help="Only captures like this, such as 'performer=14 and fps>60'.")
]
Exact = Annotated[
    bool,
    typer.Option("--exact", help="Leave words out that no caption holds; take none as others."),
]
Limit = Annotated[int, typer.Option("--limit", min=1, help="How many answers at most.")]
GrammarName = Annotated[str, typer.Argument(metavar="NAME", help="A grammar's name.")]
From = Annotated[float | None, typer.Option("--from", min=0.0, help="Start, seconds.")]
To = Annotated[float | None, typer.Option("--to", min=0.0, help="End, seconds.")]


def finite(value: float | None) -> float | None:
    """Refuse nan and infinity, which compare with no range (typer.BadParameter)."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"expected a finite number, found {value}.")
    return value


def picture_name(path: Path | None) -> Path | None:
    """Refuse a picture's name before anything else is done."""
    if path is not None and path.suffix.lower() != ".png":
        from motiondb.errors import QueryError

        raise QueryError(
            f"{path}: expected a name that ends in .png, found {path.suffix or 'no ending'!r}. "
            "Pictures are written as PNG."
        )
    return path


Png = Annotated[
    Path | None,
    typer.Option("--png", callback=picture_name, help="Draw a picture into this file (.png)."),
]
Seed = Annotated[
    int, typer.Option("--seed", min=0, max=2**63 - 1, help="The same seed gives the same result.")
]
DEFAULT_DB = Path("motions.duckdb")
DEFAULT_WAIT = 5.0
"""Seconds that a command waits for the database. Chosen by hand: commands that hold it alone are
mostly done sooner, and a user who waits longer wants to know for whom."""
LONGEST_WAIT = 86_400.0
"""Seconds: a day. A longer one is a mistake."""
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
    """A function with a further parameter ``wait``, which :func:`seconds_to_wait` tells."""

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
    """What the running command was told with --wait."""
    return _WAIT.get()


@contextmanager
def database(path: Path, *, writing: bool = False, create: bool = False) -> Iterator[MotionDB]:
    """The open database; only writing needs the file to itself, only adding makes a new one."""
    from motiondb.database import MotionDB

    with MotionDB(path, read_only=not writing, create=create, wait=seconds_to_wait()) as db:
        yield db


def note_unlearned(db: MotionDB) -> None:
    """Say on standard error how many captures the answers leave out."""
    count = len(db.unlearned())
    if count:
        what = "1 capture is" if count == 1 else f"{count} captures are"
        typer.echo(f"note: {what} not yet learned: run motiondb learn to include them", err=True)


def note_drift(found: Drift | None) -> None:
    """Say whether learning again is worthwhile, where captures or words changed."""
    if found and found.relearn:
        typer.echo(f"Learning again is worthwhile (motiondb learn): {'; '.join(found.reasons)}.")
    elif found and found.words:
        typer.echo(f"New words, counted at the next motiondb learn: {', '.join(found.words)}.")


def note_unknown(unknown: Mapping[str, Sequence[str]]) -> None:
    """Say on standard error which words of a question were left out, and what is near them."""
    for word, near in unknown.items():
        hint = f"; the nearest known: {', '.join(near)}" if near else ""
        typer.echo(f"unknown word {word!r} left out{hint}", err=True)


def note_taken(
    taken: Mapping[str, Taking],
    suggested: Mapping[str, Taking],
    unknown: Mapping[str, Sequence[str]],
) -> None:
    """Say on standard error what was made of the words of a question that no caption holds."""
    for taking in taken.values():
        typer.echo(taking.sentence(), err=True)
    for word, taking in suggested.items():
        if word in unknown and taking.words:
            typer.echo(f"{taking.sentence()}; left out", err=True)
    told = {word for word, taking in suggested.items() if taking.words}
    note_unknown({word: near for word, near in unknown.items() if word not in told})


def taken_facts(taken: Mapping[str, Taking]) -> dict[str, Any]:
    """What words were taken as, for programs."""
    return {
        word: [{"word": known, "probability": p} for known, p in taking.words]
        for word, taking in taken.items()
    }


def print_json(value: Any) -> None:
    """JSON on standard output, floats as they are."""
    typer.echo(jsonlib.dumps(value, indent=2, ensure_ascii=False, default=str))


def print_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """A table as wide as it needs to be; plain where the output is no terminal."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title or None, title_justify="left", box=None, pad_edge=False)
    for column in columns:
        right = column.lstrip("-") in (
            "rank", "start", "end", "score", "probability", "seconds", "fps", "count",
        )  # fmt: skip
        table.add_column(column, justify="right" if right else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    console.print(table, markup=False, emoji=False)


@contextmanager
def progress(enabled: bool) -> Iterator[Callable[[str, float, float], None]]:
    """A progress bar on standard error: call with what, how many done, how many there are."""
    if not enabled:
        yield lambda _what, _done, _total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:22}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
    )
    with Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True)) as bar:
        tasks: dict[str, Any] = {}

        def tell(what: str, done: float, total: float) -> None:
            for name, task in tasks.items():
                if name != what:
                    bar.update(task, completed=1.0)
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=1.0)
            bar.update(tasks[what], completed=done / max(total, 1e-9))

        yield tell
        for task in tasks.values():
            bar.update(task, completed=1.0)
