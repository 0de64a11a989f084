"""Does anything get lost, or fail without a word? The attack on motiondb, kept; writes a page.

    python benchmarks/robustness.py fuzz --out DIR [--cases 50000] [--processes 2]
    python benchmarks/robustness.py kills --out DIR [--cases 200] [--start 0] [--minutes 14]
    python benchmarks/robustness.py damage --out DIR [--cases 200]
    python benchmarks/robustness.py together --out DIR
    python benchmarks/robustness.py questions --out DIR
    python benchmarks/robustness.py model --out DIR [--cases 20000] [--processes 2]
    python benchmarks/robustness.py page --out DIR

Each part appends what became of its cases to ``DIR/PART.jsonl``, a line a case. ``fuzz``,
``kills``, ``damage`` and ``model`` leave out the seeds that are there already, and begin no
further case after ``--minutes``: the same command, given again, goes on where it stopped.
``--start`` is the first seed. The databases that are attacked are learned from the sample data once
and kept in DIR; every case has a copy of its own. ``model`` runs chains of 200 steps, a chain a
seed; it waits less with the environment variable TMPDIR in a file system in memory. ``page`` counts
the cases of all pieces, and writes ``docs/measured/robustness.md`` anew; parts without cases in DIR
stay as they are there.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import time
from collections import Counter
from collections.abc import Generator
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

_TESTS = Path(__file__).resolve().parents[1] / "tests"
_SHARED = ("files", "store", "fetch")  # odd files, damage, sites
sys.path[:0] = [str(_TESTS / name) for name in _SHARED]

PAGE = Path(__file__).resolve().parents[1] / "docs" / "measured" / "robustness.md"
PARTS = ("fuzz", "kills", "damage", "together", "questions", "model")
CASES = {"fuzz": 50_000, "kills": 200, "damage": 200, "model": 20_000}
CASES_OF_A_SEED = {"damage": 5, "model": 200}
"""Where a seed stands for more than one case."""


def main() -> None:
    """Run a part, or print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=[*PARTS, "page"])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", type=int)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    if asked.part == "page":
        from robustness_tasks.page import page

        PAGE.write_text(page(asked.out, PAGE.read_text(encoding="utf-8")), encoding="utf-8")
        return
    began, count = time.time(), 0
    with (
        (asked.out / f"{asked.part}.jsonl").open("a", encoding="utf-8") as log,
        closing(outcomes(asked)) as cases,
    ):
        for outcome in cases:
            facts = asdict(outcome) | {"failed": outcome.is_failure}
            log.write(json.dumps(facts) + "\n")
            log.flush()
            count += 1
            if outcome.is_failure:
                print(outcome, flush=True)
            if time.time() - began > 60.0 * asked.minutes:
                break
    print(f"{asked.part}: {count} cases in {time.time() - began:.0f} s", flush=True)


def outcomes(asked: argparse.Namespace) -> Generator[Any, None, None]:
    """What became of the cases of a part that have not run."""
    from robustness_tasks.databases import small_database
    from robustness_tasks.page import load

    has_own = asked.part == "model"
    small = asked.out / "small.duckdb" if has_own else small_database(asked.out)
    count = asked.cases or CASES.get(asked.part, 0)
    task = importlib.import_module(f"robustness_tasks.{asked.part}")
    if not count:
        yield from task.run(small)
        return
    times = Counter(case["seed"] for case in load(asked.out, asked.part))
    each = CASES_OF_A_SEED.get(asked.part, 1)
    seeds = range(asked.start // each, (asked.start + count) // each)
    left = [seed for seed in seeds if times[seed] < each]
    several = [asked.processes] if asked.part in ("fuzz", "model") else []
    yield from task.run(left, small, *several)


if __name__ == "__main__":
    main()
