"""Does anything get lost, or fail without a word? The attack on motiondb, kept; writes a page.

    python benchmarks/robustness.py fuzz --out DIR [--cases 50000] [--start 0] [--processes 2]
    python benchmarks/robustness.py kills --out DIR [--cases 200] [--start 0]
    python benchmarks/robustness.py damage --out DIR [--cases 200] [--start 0]
    python benchmarks/robustness.py together --out DIR
    python benchmarks/robustness.py questions --out DIR
    python benchmarks/robustness.py page --out DIR > docs/robustness.md

Each part appends what became of its cases to ``DIR/PART.jsonl``, a line a case, so that a part can
run in pieces (``--start`` is the first seed). ``page`` counts them. The databases that are attacked
are learned from the sample data once and kept in DIR; every case has a copy of its own.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

_TESTS = Path(__file__).resolve().parents[1] / "tests"
sys.path[:0] = [str(_TESTS / name) for name in ("capture", "store", "fetch")]  # odd files, sites

PARTS = ("fuzz", "kills", "damage", "together", "questions")
CASES = {"fuzz": 50_000, "kills": 200, "damage": 200}
"""Cases that docs/robustness.md reports."""


def main() -> None:
    """Run a part, or print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=[*PARTS, "page"])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", type=int)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    if asked.part == "page":
        from robustness_tasks.page import page

        print(page(asked.out), end="")
        return
    began, count = time.time(), 0
    with (asked.out / f"{asked.part}.jsonl").open("a", encoding="utf-8") as log:
        for outcome in outcomes(asked):
            facts = asdict(outcome) | {"failed": outcome.is_failure}
            log.write(json.dumps(facts) + "\n")
            log.flush()
            count += 1
            if outcome.is_failure:
                print(outcome, flush=True)
    print(f"{asked.part}: {count} cases in {time.time() - began:.0f} s", flush=True)


def outcomes(asked: argparse.Namespace) -> Iterator[Any]:
    """What became of the cases of a part."""
    from robustness_tasks.databases import small_database

    small = small_database(asked.out)
    count = asked.cases or CASES.get(asked.part, 0)
    seeds = range(asked.start, asked.start + count)
    task = importlib.import_module(f"robustness_tasks.{asked.part}")
    if asked.part == "fuzz":
        return task.run(seeds, small, asked.processes)
    return task.run(seeds, small) if count else task.run(small)


if __name__ == "__main__":
    main()
