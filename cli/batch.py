"""Command batch: many questions in one process."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import motiondb
from motiondb.cli import options, printing

app = options.Commands()

COLUMNS = ("question", "like", "start", "end", "where", "limit")

HEADER = (
    *("line", "question", "rank", "capture", "start", "end"),
    *("score", "probability", "matches_anything"),
)


@dataclass(frozen=True)
class _Question:
    """A line of the file: a question in words, or an example."""

    line: int
    text: str
    is_example: bool = False
    start: float | None = None
    end: float | None = None
    where: str = ""
    limit: int | None = None
    fault: str = ""  # Why the line is no question


@app.command()
def batch(
    shared: options.Shared,
    file: Annotated[
        Path,
        options.argument(
            "A question in words in every line, or a table (TSV or CSV) with a header: "
            "question or like, and any of start, end, where, limit.",
            "FILE",
        ),
    ],
    where: options.Where = "",
    limit: options.Limit = 10,
    exact: options.Exact = False,
    cluster: options.Cluster = None,
) -> None:
    """Answer many questions in one process, which loads the database once.

    The answers are one table (TSV); with --json, every question has one line. Empty lines and lines
    that begin with # are left out. A question that cannot be answered is named, and the exit code
    is 1 then. With --cluster, workers answer, which open the database under the same path.
    """
    questions = list(_read(file))
    if not questions:
        raise motiondb.MotionDBError(
            f"{file}: expected a question in a line, found none. Write some."
        )
    problems = []
    asked = [each for each in questions if not each.fault]
    with printing.cluster(cluster) as workers, shared.database() as base:
        printing.note_unlearned(base)
        if not shared.json:
            printing.say_tsv(HEADER)
        answers = base.ask_many([_posed(each, where, limit, exact) for each in asked], workers)
        for each in questions:
            answer = motiondb.QueryError(each.fault) if each.fault else next(answers)
            if isinstance(answer, motiondb.MotionDBError):
                problems.append(f"{file}:{each.line}: {answer}")
                _print_line(shared, each, {"error": str(answer)})
            elif shared.json:
                _print_line(shared, each, _facts(answer, each.is_example))
            else:
                _print_rows(each, answer)
    printing.refuse(problems)


def _posed(each: _Question, where: str, limit: int, exact: bool) -> motiondb.Question:
    words, like = ("", each.text) if each.is_example else (each.text, "")
    both = " and ".join(f"({f})" for f in (where, each.where) if f.strip())
    return motiondb.Question(words, like, each.start, each.end, both, each.limit or limit, exact)


def _facts(answer: Any, is_example: bool) -> dict[str, Any]:  # noqa: ANN401  of either kind
    facts: dict[str, Any] = motiondb.to_json(
        motiondb.like_answer(answer) if is_example else motiondb.search_answer(answer, False)
    )
    return facts


def _print_line(shared: options.Shared, each: _Question, facts: dict[str, Any]) -> None:
    """Print the answer to a question as one line of JSON."""
    if shared.json:
        asked = {"like": each.text} if each.is_example else {"question": {"text": each.text}}
        printing.say(json.dumps({"line": each.line, **asked, **facts}))


def _print_rows(each: _Question, answer: motiondb.WordAnswer | motiondb.ExampleAnswer) -> None:
    """Print the matches of a question as rows of TSV; a question without any has one row."""
    sure = {True: "yes", False: "no", None: ""}[answer.matches_anything]
    head = [str(each.line), _cell(each.text)]
    for match in answer.matches:
        probability = "" if match.probability is None else f"{match.probability:.4f}"
        times = [f"{match.start:.2f}", f"{match.end:.2f}", f"{match.score:.4f}"]
        printing.say_tsv([*head, str(match.rank), match.capture, *times, probability, sure])
    if not answer.matches:
        printing.say_tsv([*head, "", "", "", "", "", "", "no"])


def _cell(text: str) -> str:
    return " ".join(text.split())


def _read(file: Path) -> Iterator[_Question]:
    """The questions of a file; a header with the column question or like makes it TSV."""
    text = motiondb.read_user_text(file, "a file of questions")
    lines = [
        (number, line)
        for number, line in enumerate(text.split("\n"), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    first = lines[0][1] if lines else ""
    sign = "\t" if "\t" in first or "," not in first else ","
    header = [name.strip().lower() for name in next(csv.reader([first], delimiter=sign), [])]
    wrong = [name for name in header if name not in COLUMNS]
    is_asked = bool({"question", "like"} & set(header))
    if {"question", "like"} & {name.strip(' "').lower() for name in first.split(";")} - {*header}:
        raise motiondb.QueryError(
            f"{file}:{lines[0][0]}: expected columns divided by commas or tabs, found semicolons. "
            "Save the sheet as TSV, or as CSV with commas."
        )
    if not (is_asked or "\t" in first):  # questions have commas, but no tabs
        yield from (_Question(number, line.strip()) for number, line in lines)
        return
    if wrong or len(set(header)) < len(header) or not is_asked:
        raise motiondb.QueryError(
            f"{file}:{lines[0][0]}: expected any of the columns {', '.join(COLUMNS)}, each once, "
            f"found {', '.join(header)}."
        )
    for number, line in lines[1:]:
        cells = next(csv.reader(io.StringIO(line), delimiter=sign))
        one = _to_question(number, dict(zip(header, (cell.strip() for cell in cells))))
        opened = [cell for cell in line.split(sign) if cell.startswith('"')]
        if opened and line.count('"') % 2:  # csv would take the rest of the line for one cell
            one = replace(one, fault='expected quotation marks in pairs, found one alone (").')
        elif len(cells) > len(header):
            why = f"expected at most {len(header)} cells, as in the header, found {len(cells)}."
            one = replace(one, fault=why)
        yield one


NUMBERS = {
    "limit": (int, "a whole number"),
    "start": (float, "a number of seconds"),
    "end": (float, "a number of seconds"),
}  # Columns that hold numbers


def _to_question(number: int, cells: dict[str, str]) -> _Question:
    """A row of a table of questions."""
    words, like = cells.get("question", ""), cells.get("like", "")
    one = _Question(number, words or like, bool(like), where=cells.get("where", ""))
    if bool(words) == bool(like):
        found = "both." if words else "neither."
        fault = f"expected a question or a capture in the column like, found {found}"
        return replace(one, is_example=False, fault=fault)
    numbers: dict[str, Any] = {}
    for column, (kind, said) in NUMBERS.items():
        try:
            numbers[column] = kind(cells[column]) if cells.get(column) else None
        except ValueError:
            fault = f"expected {said} in the column {column}, found {cells[column]!r}."
            return replace(one, fault=fault)
    one = replace(one, **numbers)
    if words and (one.start is not None or one.end is not None):
        fault = "expected start and end for an example only, found them with a question."
        return replace(one, fault=fault)
    if one.limit is not None and one.limit < 1:
        return replace(one, fault="expected a limit of at least 1.")
    return one
