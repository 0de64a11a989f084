r"""Output of the commands: JSON, tables, progress, notes, problems. No other module prints.

Names, captions and licences come from files of others. A terminal obeys the control characters in
them, which may set its title or the clipboard; bidirectional overrides reorder what is read. All of
these are printed as escapes, such as ``\x1b``, and so are line ends within a text.
"""

from __future__ import annotations

import codecs
import csv
import io
import json
import math
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import typer

import motiondb

if TYPE_CHECKING:
    from rich.progress import Progress

    from motiondb.cli.options import Shared, SharedOfClips


Record = TypeVar("Record")

_CONTROLS = (*range(0x20), *range(0x7F, 0xA0))
_BIDIRECTIONAL = (0x061C, 0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2066, 0x206A))
_VISIBLE = {n: chr(n).encode("unicode_escape").decode() for n in _CONTROLS + _BIDIRECTIONAL}
_IN_JSON = {n: f"\\u{n:04x}" for n in _VISIBLE if n >= 0x20}


def visible(text: str) -> str:
    r"""Return a text in which control characters are escapes.

    >>> visible("walk" + chr(27) + "[2J")
    'walk\\x1b[2J'
    """
    return text if text.isprintable() else text.translate(_VISIBLE)


def visible_lines(text: str) -> str:
    """Return a text of several lines in which other control characters are escapes."""
    return "\n".join(map(visible, text.split("\n")))


def number(count: int, noun: str) -> str:
    """Return a number of things.

    >>> number(1, "capture"), number(2, "capture")
    ('1 capture', '2 captures')
    """
    return f"{count} {noun}{'' if count == 1 else 's'}"


def say(*lines: str) -> None:
    """Print lines on standard output."""
    for line in lines:
        print(visible(line), flush=True)


def warn(*lines: str) -> None:
    """Print lines on standard error."""
    for line in lines:
        print(visible(line), file=sys.stderr, flush=True)


def accept_any_text() -> None:
    """Let characters that the encoding of the output lacks be printed as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def note_unlearned(db: motiondb.MotionDB) -> None:
    """Print on standard error how many captures the answers leave out."""
    count = len(db.captures.unlearned())
    if count:
        what = "1 capture is" if count == 1 else f"{count} captures are"
        warn(f"note: {what} not yet learned: run motiondb learn to include them")


def note_drift(drift: motiondb.Drift | None) -> None:
    """Print whether learning again is worthwhile after changes of captures or words."""
    if drift and drift.relearn:
        say(f"Learning again is worthwhile (motiondb learn): {'; '.join(drift.reasons)}.")
    elif drift and drift.words:
        say(f"New words, counted at the next motiondb learn: {', '.join(drift.words)}.")


def note_taken(takings: Iterable[motiondb.Taking], where: str = "") -> None:
    """Print on standard error how words that no caption holds were replaced.

    `where`: What held them, if not the question.
    """
    for taking in takings:
        warn(f"{where}: {taking.sentence()}" if where else taking.sentence())


def note_words(answer: motiondb.WordAnswer | motiondb.Generated) -> None:
    """Print on standard error how the words of a question that no caption holds were replaced."""
    near = (answer.suggested[word] for word in answer.unknown if word in answer.suggested)
    note_taken([*answer.taken.values(), *near])


def note_filter(db: motiondb.MotionDB, where: str, exact: bool) -> None:
    """Print on standard error the replacements of those words of a filter that occur nowhere."""
    for taking in () if exact else db.captures.taken_in_filter(where).values():
        warn(f"filter: {taking.sentence('there')}")


def print_question(
    understood: str, unknown: Iterable[str], not_used: Sequence[motiondb.NotUsed], what: str
) -> None:
    """The interpretation of a question, and a line for every part that ``what`` does not use.

    Unknown words are printed separately, on standard error.
    """
    say(f"read as: {understood}")
    for left in not_used:
        if left.text not in unknown:
            say(f"{left.text!r} is not used in {what}: {left.reason}")


def say_word(word: str, probability: float | None) -> str:
    """A word with its probability, or alone where no own caption has checked the probability.

    >>> say_word("walk", 0.957), say_word("walk", None)
    ('walk 0.96', 'walk')
    """
    return word if probability is None else f"{word} {probability:.2f}"


def say_relation(relation: motiondb.Relation) -> str:
    """A sentence on a capture that repeats another."""
    what = {"same": "is the same motion as", "mirror": "is a mirror image of", "cut": "is a cut of"}
    return (
        f"{relation.capture} {what[relation.kind]} {relation.other} "
        f"({relation.start:.2f}-{relation.end:.2f} s)"
    )


def say_caption(caption: motiondb.Caption) -> str:
    """A caption with its interval in seconds, where it has one."""
    if caption.start is None and caption.end is None:
        return caption.words
    end = "end" if caption.end is None else f"{caption.end:g}"
    return f"{caption.words} ({caption.start or 0:g}-{end} s)"


def note(text: str) -> None:
    """Print a note, if there is one, on standard error."""
    if text:
        warn(f"note: {text}")


def read_example(base: motiondb.MotionDB, example: str, up: str) -> str | motiondb.Motion:
    """Return the motion of a file, after notes on how it was read; a capture's name as it is."""
    file = example.rpartition("#")[0] if ".fbx#" in example.lower() else example
    is_file = False
    with suppress(OSError, ValueError):  # what is no name of a file may be one of a capture
        is_file = Path(file).is_file()
    if not (up or is_file):
        return example
    clip = motiondb.read_capture(example, up=motiondb.check_up(up, "--up"))
    motion = base.motion(clip)
    for sentence in (*clip.notes, *motion.notes):
        note(f"{example}: {sentence}")
    return motion


def confirmed(question: str, otherwise: str) -> bool:
    """Ask a question of yes or no; `otherwise`: the error where there is no answer."""
    try:
        return typer.confirm(question, err=True)
    except typer.Abort:  # the end of the input, or Ctrl-C
        raise motiondb.QueryError(otherwise) from None


@contextmanager
def cluster(address: str | None) -> Iterator[motiondb.Cluster | None]:
    """Workers of a cluster, if there is an address; where they are, on standard error."""
    if address is None:
        yield None
        return
    with motiondb.Cluster(address, note) as workers:
        if workers.warning:
            warn(f"warning: {workers.warning}")
        page = f"; progress of its work: {workers.dashboard}" if workers.dashboard else ""
        note(f"{number(workers.n_workers, 'worker')} of {address}{page}")
        yield workers


def note_sources(sources: Sequence[motiondb.WordSource]) -> None:
    """Print on standard error from which captions words were learned, if a start was used."""
    alone: dict[str, list[str]] = {}
    for source in sources:
        if source.own_captions and source.start_captions:
            warn(source.sentence())
        elif source.start_captions:
            listed = alone.setdefault(source.start, [])
            listed.append(f"{source.word} ({source.start_captions})")
    for start, words in alone.items():
        warn(f"known from the start {start} alone (captions there): {', '.join(words)}")


def as_json(shared: Shared | SharedOfClips, answer: object, **more: object) -> bool:
    """Print an answer as JSON if that is asked for, and return whether it is.

    `more`: What this command says beside the answer, as further keys.
    """
    if shared.json:
        encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
        plain = codecs.lookup(encoding).name != "utf-8"
        facts = (
            motiondb.to_json(answer) | motiondb.to_json(more) if more else motiondb.to_json(answer)
        )
        text = json.dumps(facts, indent=2, ensure_ascii=plain)
        say(*text.translate(_IN_JSON).split("\n"))
    return shared.json


def say_tsv(cells: Sequence[str]) -> None:
    """Print a row of TSV; control characters in cells are escapes, formulas become text."""
    print("\t".join(motiondb.plain_cell(visible(cell)) for cell in cells), flush=True)


def print_csv(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print CSV; control characters in cells are escapes, formulas become text."""
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow([motiondb.plain_cell(visible(column)) for column in columns])
    writer.writerows([motiondb.plain_cell(visible(str(cell))) for cell in row] for row in rows)


_NUMBERS = (
    *("rank", "start", "end", "score", "probability"),
    *("interval", "seconds", "duration", "fps", "count"),
)  # Columns that are aligned at the right


def print_table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table; it is 160 columns wide if the output is not a terminal.

    Rich lays out what must be folded: a millisecond a row, too slow for a whole catalogue.
    """
    at_right = [column.lstrip("-") in _NUMBERS for column in columns]
    texts = [[visible(str(cell)) for cell in column] for column in zip(columns, *rows)]
    head, *lines = map("  ".join, zip(*map(_padded, at_right, texts)))
    room = shutil.get_terminal_size().columns if sys.stdout.isatty() else 160
    if _width(head) > room:
        _print_folded(columns, list(zip(*texts))[1:], at_right)
        return
    head = typer.style(head, bold=True) if sys.stdout.isatty() else head
    print(head, *lines, sep="\n", flush=True)


def print_rows(
    shared: Shared,
    records: Sequence[Record],
    columns: Sequence[str],
    cells: Callable[[Record], Sequence[object]],
) -> None:
    """Print records as JSON, or as a table with a row of cells for each."""
    if not as_json(shared, records):
        print_table(columns, map(cells, records))


def _padded(right: bool, texts: Sequence[str]) -> list[str]:
    """The texts of a column, all as wide as the widest of them."""
    widths = [_width(text) for text in texts]
    widest, pad = max(widths), str.rjust if right else str.ljust
    return [pad(text, widest - width + len(text)) for text, width in zip(texts, widths)]


def _width(text: str) -> int:
    """Columns that a text takes in a terminal."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def _print_folded(
    columns: Sequence[str], rows: Iterable[Sequence[str]], at_right: list[bool]
) -> None:
    """Print a table that is wider than the output, its cells in several lines."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for column, right in zip(columns, at_right):
        table.add_column(column, justify="right" if right else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    console.print(table, markup=False, emoji=False)


@contextmanager
def progress(shared: Shared) -> Iterator[Callable[[str, float, float], None]]:
    """Show progress bars on standard error."""
    with _bars(not shared.json) as show:
        yield lambda what, done, total: show(what, done / max(total, 1e-9), "")


@contextmanager
def scene_progress(shared: Shared) -> Iterator[Callable[[str, float, float], None]]:
    """Show the progress of making a scene on standard error."""
    with _bars(not shared.json) as show:
        yield lambda what, share, error: show(
            what, share, "" if math.isnan(error) else f"error {error:8.2f}"
        )


@contextmanager
def _bars(enabled: bool) -> Iterator[Callable[[str, float, str], None]]:
    """A bar for every step; call with its name, the fraction that is done, and a remark."""
    if not enabled:
        yield lambda _what, _share, _remark: None
        return
    with ExitStack() as shown:
        started = cache(lambda: shown.enter_context(_progress_bar()))  # with the first step
        tasks: dict[str, Any] = {}

        def show(what: str, share: float, remark: str) -> None:
            bar = started()
            for name, task in tasks.items():
                if name != what:
                    bar.update(task, completed=1.0)
                    bar.stop_task(task)
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=1.0, remark=remark)
            bar.update(tasks[what], completed=min(share, 1.0), remark=remark)

        yield show
        for task in tasks.values():
            started().update(task, completed=1.0)


def _progress_bar() -> Progress:
    """Bars on standard error, which begin with a block."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:22}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TextColumn("{task.fields[remark]}"),
    )
    return Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True))


def print_sources(sources: Sequence[motiondb.Source]) -> None:
    """Print the captures from which a generated motion was made."""
    for source in sources:
        say(f"from {source.capture}, {source.frames} frames, licence {source.licence}")


def print_notes(notes: Sequence[str]) -> None:
    """Print notes on unusual properties of files that were read."""
    for note in notes:
        say(f"  note: {note}")


def print_problems(problems: Sequence[str]) -> None:
    """Print problems on standard error."""
    for problem in problems:
        warn(*(f"  {line}" for line in problem.split("\n")))


def refuse(problems: Sequence[str]) -> None:
    """Print problems on standard error, and exit with 1 if there are any."""
    print_problems(problems)
    if problems:
        raise typer.Exit(1)


def say_pictures(*paths: Path | None) -> None:
    """Print the names of the pictures that were drawn."""
    say(*(f"picture: {path}" for path in paths if path))


def write_html(path: Path, page: motiondb.StandalonePage) -> None:
    """Write the page of --html, and say so on standard error."""
    page.write(path)
    warn(f"page: {path}")


NOT_MEASURED = "-"  # Stands for a number that was not measured


def write_rows(
    columns: Sequence[str], rows: Sequence[Sequence[str]], path: Path, what: str
) -> None:
    """Write a table into a file, or print it (-)."""
    if str(path) == "-":
        print_csv(columns, rows)
    else:
        motiondb.write_table(path, columns, rows)
        warn(f"{number(len(rows), what)} in {path}")
