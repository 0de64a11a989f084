"""The page ``docs/measured/robustness.md``: the cases and the failures, counted from the logs."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from measured_run import machine, versions

from grammar_tasks.tables import table
from robustness_tasks.fuzz import MOST_MEGABYTES, MOST_SECONDS

Case = dict[str, Any]
HEAD = """# Robustness: data loss and silent failures

Measured: odd files and texts, killed commands, damaged databases, many threads and processes at
once, and large questions, on databases learned from the sample data. `python
benchmarks/robustness.py PART --out DIR` runs a part (`fuzz`, `kills`, `damage`, `together`,
`questions`, `model`), and `python benchmarks/robustness.py page --out DIR` writes this page. The
tables count the cases that were run; a target with more cases than were run is listed as not met.
Short versions run with the tests (`tests/robustness`)."""

UNKNOWN = """## Limits

* **A log that was cut off.** Changes that are not yet in the database file are in a log beside it
  (`.wal`). DuckDB replays the log up to its last complete transaction and does not report what
  follows. After a full disk, or a copy of the log made while a command writes, the database is
  therefore in a consistent earlier state, and `check` reports no fault. A log with flipped bits is
  refused, and a log that is missing as a whole is reported.
* **A file that is not a log.** DuckDB ignores a file of that name that does not begin like one of
  its logs, and `check` reports no fault.
* **Learning while others change captures.** `learn` computes without holding the file, and saves
  only if captures and words are as it read them; otherwise it begins again. After three attempts it
  stops with a message and changes nothing. If another process writes all the time, this is always
  the result.
* **Processes of a killed command.** The processes that read files for `add` end within a second or
  two. On systems other than Linux, a library that blocks Python delays this; on Windows they end
  after the file that they are reading.
* **Power failures.** The kills end processes, not the computer. Data that the disk had not yet
  written are not tested.
* **The system's temporary folder** is not examined after kills. Reading of FBX files uses it, as
  does `rescue` of a database with a damaged log."""


def page(folder: Path, before: str) -> str:
    """The page of the logs in a folder; parts without a log are as in the page before."""
    parts: list[tuple[str, str, Callable[[list[Case]], str]]] = [
        ("fuzz", "Odd files and texts", _fuzz),
        ("kills", "Kills", _kills),
        ("damage", "Damaged databases", _damage),
        ("together", "Threads and processes", _together),
        ("questions", "Large questions", _questions),
        ("model", "Chains of steps", _model),
    ]
    cases = {name: load(folder, name) for name, _, _ in parts}
    sections = [HEAD, f"{machine()}; {versions('numpy', 'duckdb')}."]
    earlier = [title for name, title, _ in parts if not cases[name]]
    if earlier:
        sections.append(
            "Measured with an earlier state of the program, and not again with the rest:"
            f" {', '.join(earlier).lower()}."
        )
    sections.append(_targets(cases, before))
    for name, title, write in parts:
        of_part = cases[name]
        sections.append(f"## {title}\n\n{write(of_part) if of_part else _section(before, title)}")
    sections.append(UNKNOWN)
    return "\n\n".join(sections) + "\n"


def _section(before: str, title: str) -> str:
    """The text of a section of a page."""
    found = re.search(rf"^## {title}\n\n(.*?)\n*(?=^## |\Z)", before, re.MULTILINE | re.DOTALL)
    return found[1] if found else "Not run."


def load(folder: Path, part: str) -> list[Case]:
    """The cases of a part, by seed; of a seed or a question that ran twice, the later run."""
    path = folder / f"{part}.jsonl"
    if not path.exists():
        return []
    cases = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    if cases and "seed" in cases[0]:
        place = "step" if part == "model" else "kind"
        cases = list({(case["seed"], case[place]): case for case in cases}.values())
        cases.sort(key=lambda case: (case["seed"], case[place]))
    if part == "questions":
        cases = list({case["kind"]: case for case in cases}.values())
    return cases


def seeds_of(cases: Sequence[Case]) -> str:
    """The seeds of cases as ranges.

    >>> seeds_of([{"seed": n} for n in (0, 1, 1, 2, 7)])
    '0 to 2, 7'
    """
    seeds = sorted({case["seed"] for case in cases})
    starts = [n for n in seeds if n - 1 not in set(seeds)]
    ends = [n for n in seeds if n + 1 not in set(seeds)]
    return ", ".join(f"{a} to {b}" if a < b else f"{a}" for a, b in zip(starts, ends))


def _targets(cases: dict[str, list[Case]], before: str) -> str:
    """The targets of the tests, with the results; those of the page before for parts not run."""
    lines = [line.strip("| ").split(" | ") for line in before.splitlines() if line.startswith("|")]
    known = {line[0]: tuple(line) for line in lines}
    wanted = {
        "fuzz": ("no failure in 50,000 odd files and texts", 50_000),
        "kills": ("nothing lost and nothing left over in 200 kills", 200),
        "damage": ("none of 200 damaged databases passes `check` although a question fails", 200),
        "together": ("16 threads and 20 processes without a false message", 36),
        "questions": ("large questions answered or refused, within 10 s and 1 GB", 1),
        "model": ("20,000 random steps of two processes and a server without a difference", 20_000),
    }
    rows = []
    for name, (target, least) in wanted.items():
        if not cases[name] and target in known:
            rows.append(known[target])
            continue
        ran, failed = len(cases[name]), sum(case["failed"] for case in cases[name])
        met = "yes" if ran >= least and not failed else "no" if failed else f"no: {ran} ran"
        rows.append((target, f"{ran:,}", f"{failed:,}", met))
    return table(("target", "ran", "failed", "met"), rows)


def _failures(cases: Sequence[Case], tell: Callable[[Case], str]) -> str:
    failed = [case for case in cases if case["failed"]]
    if not failed:
        return "No failures."
    lines = [f"* {tell(case)}" for case in failed[:40]]
    more = [f"* and {len(failed) - 40} more"] if len(failed) > 40 else []
    return "\n".join(["Failures:", "", *lines, *more])


def _fuzz(cases: list[Case]) -> str:
    kinds = sorted({case["kind"] for case in cases})
    rows = []
    for kind in [*kinds, ""]:
        of_kind = [case for case in cases if kind in ("", case["kind"])]
        results = Counter(case["result"] for case in of_kind)
        rows.append(
            (
                kind or "all",
                f"{len(of_kind):,}",
                *(f"{results[name]:,}" for name in ("read", "refused", "caught")),
                f"{sum(case['failed'] for case in of_kind)}",
                f"{max(case['seconds'] for case in of_kind):.1f}",
                f"{max(case['megabytes'] for case in of_kind):.0f}",
            )
        )
    heads = ("kind", "cases", "read", "refused", "caught", "failed", "slowest, s", "most, MB")
    failures = _failures(
        cases,
        lambda case: (
            f"seed {case['seed']}, {case['kind']}: {case['message'][:200] or case['result']}"
            f" ({case['seconds']:.1f} s, {case['megabytes']:.0f} MB)"
        ),
    )
    return (
        f"`python benchmarks/robustness.py fuzz --out DIR`, seeds {seeds_of(cases)}. The"
        " outcome of a case is *read*; *refused* by a reader with one of the project's errors; or"
        " *caught*: refused by the general handler around all readers, which names the exception."
        " A case fails with any other exception, if its process dies, above"
        f" {MOST_SECONDS:g} s of processor time or above {MOST_MEGABYTES:g} MB. `add`,"
        " `words import`, `words synonyms` and `events import` write to a copy of the database;"
        " their times include copying and opening it.\n\n"
        f"{table(heads, rows)}\n\n{failures}"
    )


def _kills(cases: list[Case]) -> str:
    rows = []
    for kind in [*sorted({case["kind"] for case in cases}), ""]:
        of_kind = [case for case in cases if kind in ("", case["kind"])]
        rows.append(
            (
                kind or "all",
                f"{len(of_kind)}",
                f"{sum(case['ended'] for case in of_kind)}",
                f"{sum(case['rows'] == 'before' for case in of_kind)}",
                f"{sum(case['rows'] == 'after' for case in of_kind)}",
                f"{sum(case['failed'] for case in of_kind)}",
            )
        )
    heads = ("command", "kills", "had ended", "as before", "done", "failed")
    failures = _failures(
        cases,
        lambda case: (
            f"seed {case['seed']}, {case['kind']}, killed after {case['moment']:.2f} s of"
            f" {case['usual']:.2f} s: {'; '.join(case['faults'])[:300]}"
        ),
    )
    return (
        f"`python benchmarks/robustness.py kills --out DIR`, seeds {seeds_of(cases)}. SIGKILL is"
        " sent after a random fraction, up to 1.1, of the time that the command takes without it."
        " Then the database must open; `check` must report nothing; its rows must be those from"
        " before or after the command (after, if the command had reported success); files that the"
        " command writes must be complete or absent; and after one further command no file and no"
        " process may be left. `compact` and `rescue` change no rows and are counted in the column"
        " *as before*.\n\n"
        f"{table(heads, rows)}\n\n{failures}"
    )


def _damage(cases: list[Case]) -> str:
    counts = Counter((case["kind"], case["said"], case["questions"]) for case in cases)
    rows = [(*key, f"{n}") for key, n in sorted(counts.items())]
    failures = _failures(cases, lambda case: f"seed {case['seed']}, {case['kind']}: {case}")
    return (
        f"`python benchmarks/robustness.py damage --out DIR`, seeds {seeds_of(cases)}, each with"
        " every kind of damage: `flip` 1 to 8 bits, `zero` a block of DuckDB's, `page` random bytes"
        " in place of 4096, `cut` the file anywhere, `tail` a few bytes off its end.\n\n"
        f"{table(('damage', '`check`', 'questions', 'databases'), rows)}\n\n{failures}"
    )


def _together(cases: list[Case]) -> str:
    kinds = list(dict.fromkeys(case["kind"] for case in cases))
    rows = []
    for kind in kinds:
        of_kind = [case for case in cases if case["kind"] == kind]
        done, told = (
            sum(case["done"] for case in of_kind),
            [m for c in of_kind for m in c["messages"]],
        )
        rows.append((kind, f"{len(of_kind)}", f"{done}", f"{len(told)}"))
    failures = _failures(cases, lambda case: f"{case['kind']}: {'; '.join(case['messages'])[:300]}")
    return (
        "`python benchmarks/robustness.py together --out DIR`: 16 threads that share an open"
        " database, then 20 commands that start at the same moment, repeatedly; finally "
        "`check`.\n\n"
        f"{table(('what', 'threads or processes', 'answers', 'messages'), rows)}\n\n{failures}"
    )


def _questions(cases: list[Case]) -> str:
    rows = [
        (case["kind"], case["answer"], f"{case['seconds']:.1f}", f"{case['megabytes']:.0f}",
         case["message"][:120].replace("|", "\\|").replace("\n", " "))
        for case in cases
    ]  # fmt: skip
    heads = ("question", "answer", "s", "MB", "message")
    return (
        "`python benchmarks/robustness.py questions --out DIR`: each in a separate process; the "
        "time"
        f" includes opening the database.\n\n{table(heads, rows)}"
    )


def _model(cases: list[Case]) -> str:
    harms = list(dict.fromkeys(["", "at once", *sorted({case["harm"] for case in cases})]))
    rows = []
    for harm in [*harms, "all"]:
        of_kind = [case for case in cases if harm in ("all", case["harm"])]
        ended = Counter(case["ended"] for case in of_kind)
        unknown = [case["happened"] for case in of_kind if case["ended"] == "unknown"]
        rows.append(
            (
                harm or "nothing",
                f"{len(of_kind):,}",
                *(f"{ended[name]:,}" for name in ("done", "refused")),
                f"{len(unknown) - sum(unknown):,}",
                f"{sum(unknown):,}",
                f"{sum(case['by'] == 'server' for case in of_kind):,}",
                f"{sum(case['failed'] for case in of_kind)}",
            )
        )
    heads = (
        "disturbed by", "steps", "done", "refused", "interrupted: absent", "interrupted: there",
        "of the server", "failed",
    )  # fmt: skip
    verbs = Counter(case["kind"] for case in cases)
    counts = ", ".join(f"{verb} {n:,}" for verb, n in verbs.most_common())
    failures = _failures(
        cases,
        lambda case: (
            f"seed {case['seed']}, step {case['step']}, {case['kind']} by {case['by']}"
            f" ({case['harm'] or 'undisturbed'}): {'; '.join(case['faults'])[:300]}"
        ),
    )
    n_kills = sum(case["harm"] in ("kill", "late kill") for case in cases)
    return (
        f"`python benchmarks/robustness.py model --out DIR`, {len({c['seed'] for c in cases}):,}"
        f" chains of up to 200 steps, {n_kills:,} kills. Two processes that use the class and a"
        " server share a database of captures of half a second; a plain model of dictionaries says"
        " after every step what must be there. *kill*: at a random system call; *late kill*: right"
        " after the answer; *full disk*: from a random system call on; *clock*: the clock and the"
        " times of files jump by up to 25 years, back or ahead; *rights*: those to the database,"
        " its cache, its folder or a folder of files are taken away for the step; *at once*: both"
        " processes work at the same moment."
        " An interrupted step must be wholly there or wholly absent. After each of these, `check`"
        " must find nothing and the counts of the learned model must be those of the words. Verbs:"
        f" {counts}.\n\n{table(heads, rows)}\n\n{failures}"
    )
