"""What grammars reach: times, known truth, real takes, pictures; see docs/measured/grammar.md.

    python benchmarks/grammar.py --data DIR [--task speed truth recursive ...]
                                 [--style salsa ...] [--language brackets ...] [--sentences 20]
                                 [--part boundaries ...]

DIR holds ``cmu`` and ``cmu-captions.tsv``; ``truth`` needs the sample data only,
``recursive`` and ``development`` need none. Of these two, a part may be run: some languages, or one
number of sentences; the rows of other languages stay. ``--part`` runs some parts of ``truth``.
Sections of tasks that are not run stay as they are on the page. Observations from the pictures, and
limits, are in ``grammar_tasks/notes.md`` and are put under the section of the same heading.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from grammar_tasks.completion import completion_rows
from grammar_tasks.curve import LANGUAGES as CURVES
from grammar_tasks.curve import curve_rows
from grammar_tasks.foresight_table import ACTIVITIES, ask_rows, foresight_rows
from grammar_tasks.long_takes import PERFORMERS
from grammar_tasks.pictures import pictures
from grammar_tasks.real_takes import STYLES, real
from grammar_tasks.recursive import SIZES, development_rows, error_rows, recursive_rows
from grammar_tasks.recursive_languages import DEVELOPMENT, LANGUAGES
from grammar_tasks.speed_table import speed
from grammar_tasks.tables import sections, write_sections
from grammar_tasks.truth import PARTS, truth

NOTES = Path(__file__).with_name("grammar_tasks") / "notes.md"
TASKS = (
    "speed", "truth", "recursive", "development", "curve", "completion", "real", "pictures",
    "foresight", "errors", "ask",
)  # fmt: skip
WITHOUT_DATA = ("truth", "recursive", "development", "curve", "completion", "errors")
RECURSIVE = "Known truth: languages that repeat and nest"
DEVELOPED = "Known truth: languages of development"
ERRORS = "Known truth: wrong sentences"
CURVE = "Known truth: held-out sentences by number of sentences"
FORESIGHT = "Real takes: foresight and freedom"
ASKED = "Real takes: answers to ten questions"
COMPLETION = "Completion of patterns"
COMMAND = "python benchmarks/grammar.py --data DIR"


Jobs = dict[str, tuple[str, Callable[[], str]]]
"""Title of each section, its command, and what makes its body."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run tasks and write their sections."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path)
    parser.add_argument("--task", nargs="+", choices=TASKS, default=TASKS)
    parser.add_argument("--style", nargs="+", choices=tuple(STYLES), default=tuple(STYLES))
    parser.add_argument("--language", nargs="+", choices=(*LANGUAGES, *DEVELOPMENT))
    parser.add_argument(
        "--grammar", nargs="+", choices=tuple(PERFORMERS), default=tuple(PERFORMERS)
    )
    parser.add_argument(
        "--activity", nargs="+", choices=tuple(ACTIVITIES), default=tuple(ACTIVITIES)
    )
    parser.add_argument("--part", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--sentences", nargs="+", type=int, choices=SIZES, default=SIZES)
    parser.add_argument("--output", type=Path, default=Path("docs/measured"))
    chosen = parser.parse_args(arguments)
    if chosen.data is None and set(chosen.task) - set(WITHOUT_DATA):
        free = ", ".join(WITHOUT_DATA)
        parser.error(f"--data: expected the folder of the captures. Only {free} need none.")
    page = chosen.output / "grammar.md"
    known = sections(page.read_text(encoding="utf-8")) if page.exists() else {}
    for title, (command, job) in {**_made_up(chosen, known), **_from_data(chosen, known)}.items():
        print(title, flush=True)
        _write(page, title, f"`{command}`\n\n{job()}")


def _made_up(chosen: argparse.Namespace, known: dict[str, str]) -> Jobs:
    """The jobs that need no captures."""
    jobs: Jobs = {}
    for part in chosen.part if "truth" in chosen.task else ():
        command = "python benchmarks/grammar.py --task truth"
        jobs[f"Known truth: {part}"] = command, partial(truth, part)
    if "curve" in chosen.task:
        command = "python benchmarks/grammar.py --task curve"
        names = [name for name in CURVES if name.split(",")[0] in chosen.grammar]
        jobs[CURVE] = command, partial(curve_rows, names, known.get(CURVE, ""))
    for n in chosen.sentences if "recursive" in chosen.task else ():
        names = [name for name in LANGUAGES if name in (chosen.language or LANGUAGES)]
        title = f"{RECURSIVE}, {n} sentences"
        command = f"python benchmarks/grammar.py --task recursive --sentences {n}"
        jobs[title] = command, partial(recursive_rows, n, names, known.get(title, ""))
    if "development" in chosen.task:
        names = [name for name in DEVELOPMENT if name in (chosen.language or DEVELOPMENT)]
        command = "python benchmarks/grammar.py --task development"
        jobs[DEVELOPED] = command, partial(development_rows, names, known.get(DEVELOPED, ""))
    if "errors" in chosen.task:
        jobs[ERRORS] = "python benchmarks/grammar.py --task errors", error_rows
    if "completion" in chosen.task:
        jobs[COMPLETION] = "python benchmarks/grammar.py --task completion", completion_rows
    return jobs


def _from_data(chosen: argparse.Namespace, known: dict[str, str]) -> Jobs:
    """The jobs that need captures."""
    jobs: Jobs = {}
    if "foresight" in chosen.task:
        command = f"{COMMAND} --task foresight"
        section = known.get(FORESIGHT, "")
        jobs[FORESIGHT] = command, lambda: foresight_rows(chosen.data, chosen.activity, section)
    if "ask" in chosen.task:
        jobs[ASKED] = f"{COMMAND} --task ask", lambda: ask_rows(chosen.data)
    if "speed" in chosen.task:
        jobs["Speed"] = f"{COMMAND} --task speed", lambda: speed(chosen.data)
    for style in chosen.style if "real" in chosen.task else ():
        command = f"{COMMAND} --task real --style {style}"
        jobs[_title(style)] = command, partial(real, chosen.data, style)
    if "pictures" in chosen.task:
        folder = chosen.output / "pictures"
        command = f"{COMMAND} --task pictures"
        jobs["Pictures"] = command, lambda: pictures(chosen.data, tuple(STYLES), folder)
    return jobs


def _title(style: str) -> str:
    return f"Real takes: {style}"


def _write(page: Path, title: str, body: str) -> None:
    """Write a section at once, so that a run that is stopped keeps what it has."""
    notes = sections(NOTES.read_text(encoding="utf-8"))
    known = [f"Known truth: {part}" for part in PARTS]
    loops = [*(f"{RECURSIVE}, {n} sentences" for n in SIZES), DEVELOPED, ERRORS, CURVE]
    order = [
        "Speed",
        *known,
        *loops,
        COMPLETION,
        FORESIGHT,
        ASKED,
        *(_title(style) for style in STYLES),
        "Pictures",
    ]
    parts = [body, notes.get(title, "")]
    write_sections(page, notes[""], order, {title: "\n\n".join(part for part in parts if part)})


if __name__ == "__main__":
    main()
