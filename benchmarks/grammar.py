"""What grammars of movement reach: times, known truth, real takes, pictures; docs/grammar.md.

    python benchmarks/grammar.py --data DIR [--task speed truth recursive number real pictures]
                                 [--style salsa ...]

DIR holds ``cmu`` and ``cmu-captions.tsv``; ``truth`` and ``number`` need the sample data only,
``recursive`` needs none.
Sections of tasks that are not run stay as they are on the page. Observations from the pictures, and
limits, are in ``grammar_tasks/notes.md`` and are put under the section of the same heading.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from grammar_tasks.number import number_rows
from grammar_tasks.pictures import pictures
from grammar_tasks.real_takes import STYLES, real
from grammar_tasks.recursive import recursive_rows
from grammar_tasks.speed_table import speed
from grammar_tasks.tables import sections, write_sections
from grammar_tasks.truth import PARTS, truth

NOTES = Path(__file__).with_name("grammar_tasks") / "notes.md"
TASKS = ("speed", "truth", "recursive", "number", "real", "pictures")
RECURSIVE = "Known truth: languages that repeat and nest"
NUMBER = "Known truth: the number of terminals"
COMMAND = "python benchmarks/grammar.py --data DIR"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run tasks and write their sections."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path)
    parser.add_argument("--task", nargs="+", choices=TASKS, default=TASKS)
    parser.add_argument("--style", nargs="+", choices=tuple(STYLES), default=tuple(STYLES))
    parser.add_argument("--output", type=Path, default=Path("docs"))
    chosen = parser.parse_args(arguments)
    if chosen.data is None and set(chosen.task) - {"truth", "recursive", "number"}:
        parser.error(
            "--data: expected the folder of the captures. Truth, recursive and number need none."
        )
    jobs: dict[str, tuple[str, Callable[[], str]]] = {}
    if "speed" in chosen.task:
        jobs["Speed"] = f"{COMMAND} --task speed", lambda: speed(chosen.data)
    for part in PARTS if "truth" in chosen.task else ():
        command = "python benchmarks/grammar.py --task truth"
        jobs[f"Known truth: {part}"] = command, partial(truth, part)
    if "recursive" in chosen.task:
        jobs[RECURSIVE] = "python benchmarks/grammar.py --task recursive", recursive_rows
    if "number" in chosen.task:
        jobs[NUMBER] = "python benchmarks/grammar.py --task number", number_rows
    for style in chosen.style if "real" in chosen.task else ():
        command = f"{COMMAND} --task real --style {style}"
        jobs[_title(style)] = command, partial(real, chosen.data, style)
    if "pictures" in chosen.task:
        folder = chosen.output / "pictures"
        command = f"{COMMAND} --task pictures"
        jobs["Pictures"] = command, lambda: pictures(chosen.data, tuple(STYLES), folder)
    for title, (command, job) in jobs.items():
        print(title, flush=True)
        _write(chosen.output / "grammar.md", title, f"`{command}`\n\n{job()}")


def _title(style: str) -> str:
    return f"Real takes: {style}"


def _write(page: Path, title: str, body: str) -> None:
    """Write a section at once, so that a run that is stopped keeps what it has."""
    notes = sections(NOTES.read_text(encoding="utf-8"))
    known = [f"Known truth: {part}" for part in PARTS]
    order = ["Speed", *known, RECURSIVE, NUMBER, *(_title(style) for style in STYLES), "Pictures"]
    parts = [body, notes.get(title, "")]
    write_sections(page, notes[""], order, {title: "\n\n".join(part for part in parts if part)})


if __name__ == "__main__":
    main()
