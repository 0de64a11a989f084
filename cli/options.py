"""Options shared by several commands; opening the database; printing."""

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
    from motiondb.learning.answers.word_sources import WordSource
    from motiondb.learning.drift import Drift
    from motiondb.words.nearby.taking import Taking

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
    typer.Option("--exact", help="Leave out words that no caption holds; take none as others."),
]
Limit = Annotated[int, typer.Option("--limit", min=1, help="Largest number of answers.")]
GrammarName = Annotated[str, typer.Argument(metavar="NAME", help="Name of a grammar.")]
MOST_SECONDS = 1e7
"""Largest time that is accepted: some months, longer than any take."""


def finite(value: float | None) -> float | None:
    """Refuse what is no number: ranges of options let NaN pass.

    Parameters
    ----------
    value : float, optional
        Value of an option.

    Raises
    ------
    typer.BadParameter
        If the value is NaN or infinite.
    """
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
    """Refuse a name of a picture without the ending .png, before anything is computed.

    Parameters
    ----------
    path : Path, optional
        The file.

    Raises
    ------
    QueryError
        If the ending is not .png.
    """
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
    int,
    typer.Option(
        "--seed", min=0, max=2**63 - 1, help="Random seed; the same seed gives the same result."
    ),
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
    """Open the database and close it at the end.

    Parameters
    ----------
    path : Path
        The database file.
    writing : bool, optional
        Whether the command changes the database; then no other process can open the file.
    create : bool, optional
        Whether to make a missing file.
    """
    from motiondb.database import MotionDB

    with MotionDB(path, read_only=not writing, create=create, wait=seconds_to_wait()) as db:
        yield db


def note_unlearned(db: MotionDB) -> None:
    """Print on standard error how many captures the answers leave out.

    Parameters
    ----------
    db : MotionDB
        The database.
    """
    count = len(db.unlearned())
    if count:
        what = "1 capture is" if count == 1 else f"{count} captures are"
        typer.echo(f"note: {what} not yet learned: run motiondb learn to include them", err=True)


def note_drift(found: Drift | None) -> None:
    """Print whether learning again is worthwhile after changes of captures or words.

    Parameters
    ----------
    found : Drift, optional
        What changed since the database learned.
    """
    if found and found.relearn:
        typer.echo(f"Learning again is worthwhile (motiondb learn): {'; '.join(found.reasons)}.")
    elif found and found.words:
        typer.echo(f"New words, counted at the next motiondb learn: {', '.join(found.words)}.")


def note_unknown(unknown: Mapping[str, Sequence[str]]) -> None:
    """Print on standard error the unknown words of a query with the most similar known ones.

    Parameters
    ----------
    unknown : mapping of str to sequence of str
        Known words that are similar to each unknown word.
    """
    for word, near in unknown.items():
        hint = f"; the nearest known: {', '.join(near)}" if near else ""
        typer.echo(f"unknown word {word!r} left out{hint}", err=True)


def note_taken(
    taken: Mapping[str, Taking],
    suggested: Mapping[str, Taking],
    unknown: Mapping[str, Sequence[str]],
) -> None:
    """Say on standard error what was made of the words of a question that no caption holds.

    Parameters
    ----------
    taken : mapping of str to Taking
        Words that are taken as known ones.
    suggested : mapping of str to Taking
        Words for which known ones are suggested.
    unknown : mapping of str to sequence of str
        Words that are left out -> nearest known words.
    """
    for taking in taken.values():
        typer.echo(taking.sentence(), err=True)
    for word, taking in suggested.items():
        if word in unknown and taking.words:
            typer.echo(f"{taking.sentence()}; left out", err=True)
    told = {word for word, taking in suggested.items() if taking.words}
    note_unknown({word: near for word, near in unknown.items() if word not in told})


def note_filter(db: MotionDB, where: str, exact: bool) -> None:
    """Say on standard error what the words of a filter are taken as that nothing holds.

    Parameters
    ----------
    db : MotionDB
        The database.
    where : str
        The filter.
    exact : bool
        Whether words are not taken as others.
    """
    if not exact:
        for taking in db.taken_in_filter(where).values():
            typer.echo(f"filter: {taking.sentence('there')}", err=True)


def note_sources(sources: Sequence[WordSource]) -> None:
    """Print on standard error which captions taught the words, where a start has a part in them.

    Parameters
    ----------
    sources : sequence of WordSource
        Of the words of a question or an answer.
    """
    alone: dict[str, list[str]] = {}
    for source in sources:
        if source.own_captions and source.start_captions:
            typer.echo(source.sentence(), err=True)
        elif source.start_captions:
            told = alone.setdefault(source.start, [])
            told.append(f"{source.word} ({source.start_captions})")
    for start, words in alone.items():
        typer.echo(
            f"known from the start {start} alone (captions there): {', '.join(words)}", err=True
        )


def taken_facts(taken: Mapping[str, Taking]) -> dict[str, Any]:
    """What words were taken as, for JSON.

    Parameters
    ----------
    taken : mapping of str to Taking
        Words that are taken as known ones.
    """
    return {
        word: [{"word": known, "probability": p} for known, p in taking.words]
        for word, taking in taken.items()
    }


def print_json(value: object) -> None:
    """Print a value as JSON on standard output.

    Parameters
    ----------
    value : object
        What ``json`` can write; other objects are written as text.
    """
    typer.echo(jsonlib.dumps(value, indent=2, ensure_ascii=False, default=str))


def print_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """Print a table; it is 160 columns wide if the output is not a terminal.

    Parameters
    ----------
    title : str
        Title, or "".
    columns : list of str
        Names of the columns.
    rows : list of list of str
        Cells of every row.
    """
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title or None, title_justify="left", box=None, pad_edge=False)
    for column in columns:
        right = column.lstrip("-") in (
            "rank", "start", "end", "score", "probability", "interval", "seconds", "fps", "count",
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
    """Show progress bars on standard error.

    Parameters
    ----------
    enabled : bool
        Whether to show anything.

    Yields
    ------
    callable
        Call it with the name of the step, how much is done, and how much there is to do.
    """
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
