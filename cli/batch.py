"""Command batch: many questions of a file."""

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
class _Line:
    """A line of the file."""

    number: int
    asked: motiondb.Question
    fault: str = ""  # Why it is no question

    @property
    def text(self) -> str:
        """The question, or the example."""
        return self.asked.words or self.asked.like


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
    where = f"({where})" if where.strip() else ""
    lines = list(_read(file, motiondb.Question(where=where, limit=limit, exact=exact)))
    if not lines:
        raise motiondb.MotionDBError(
            f"{file}: expected a question in a line, found none. Write some."
        )
    problems = []
    asked = [each.asked for each in lines if not each.fault]
    with printing.cluster(cluster) as workers, shared.database() as base:
        printing.note_unlearned(base)
        if not shared.json:
            printing.say_tsv(HEADER)
        answers = base.ask_many(asked, workers)
        for each in lines:
            answer = motiondb.QueryError(each.fault) if each.fault else next(answers)
            if isinstance(answer, motiondb.MotionDBError):
                problems.append(f"{file}:{each.number}: {answer}")
            if shared.json:
                _print_line(each, answer)
            elif not isinstance(answer, motiondb.MotionDBError):
                _print_rows(each, answer)
    printing.refuse(problems)


def _print_line(each: _Line, answer: Any) -> None:  # noqa: ANN401  an answer of any kind
    """Print the answer to a question as one line of JSON."""
    is_example = bool(each.asked.like)
    facts: object = {"error": str(answer)}
    if not isinstance(answer, motiondb.MotionDBError):
        is_words = not is_example
        facts = motiondb.search_answer(answer, False) if is_words else motiondb.like_answer(answer)
    asked = {"like": each.text} if is_example else {"question": {"text": each.text}}
    printing.say(json.dumps({"line": each.number, **asked, **motiondb.to_json(facts)}))


def _print_rows(each: _Line, answer: motiondb.WordAnswer | motiondb.ExampleAnswer) -> None:
    """Print the matches of a question as rows of TSV; a question without any has one row."""
    sure = {True: "yes", False: "no", None: ""}[answer.matches_anything]
    head = [str(each.number), " ".join(each.text.split())]
    for match in answer.matches:
        probability = "" if match.probability is None else f"{match.probability:.4f}"
        times = [f"{match.start:.2f}", f"{match.end:.2f}", f"{match.score:.4f}"]
        printing.say_tsv([*head, str(match.rank), match.capture, *times, probability, sure])
    if not answer.matches:
        printing.say_tsv([*head, "", "", "", "", "", "", "no"])


def _read(file: Path, usual: motiondb.Question) -> Iterator[_Line]:
    """The lines of a file; a header with the column question or like makes it TSV.

    `usual`: What holds where a line does not say otherwise.
    """
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
        yield from (_Line(number, replace(usual, words=line.strip())) for number, line in lines)
        return
    if wrong or len(set(header)) < len(header) or not is_asked:
        raise motiondb.QueryError(
            f"{file}:{lines[0][0]}: expected any of the columns {', '.join(COLUMNS)}, each once, "
            f"found {', '.join(header)}."
        )
    for number, line in lines[1:]:
        cells = next(csv.reader(io.StringIO(line), delimiter=sign))
        one = _to_line(number, dict(zip(header, (cell.strip() for cell in cells))), usual)
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


def _to_line(number: int, cells: dict[str, str], usual: motiondb.Question) -> _Line:
    """A row of a table of questions."""
    words, like = cells.get("question", ""), cells.get("like", "")
    own = f"({cells['where']})" if cells.get("where") else ""
    where = " and ".join(filter(None, (str(usual.where), own)))
    asked = replace(usual, words=words, like=like, where=where)
    if bool(words) == bool(like):
        found = "both." if words else "neither."
        fault = f"expected a question or a capture in the column like, found {found}"
        return _Line(number, replace(asked, like=""), fault)
    numbers: dict[str, Any] = {}
    for column, (kind, said) in NUMBERS.items():
        try:
            if cells.get(column):
                numbers[column] = kind(cells[column])
        except ValueError:
            fault = f"expected {said} in the column {column}, found {cells[column]!r}."
            return _Line(number, asked, fault)
    fault = "" if numbers.get("limit", 1) >= 1 else "expected a limit of at least 1."
    if words and not numbers.keys() <= {"limit"}:
        fault = "expected start and end for an example only, found them with a question."
    return _Line(number, replace(asked, **numbers), fault)
