"""Everything on the real CMU captures, from a folder of files to pictures; writes a report.

    python benchmarks/real_captures.py --data DIR [--database FILE] [--output docs]

DIR holds ``cmu/``, ``cmu-captions.tsv`` and, for the long takes, ``cmu-segments.tsv``. Runs
``motiondb add`` and ``motiondb learn`` in processes of their own (times and peak memory, children
included), then asks what ``real_tasks/questions.py`` lists, judges the answers by the captions
and by ``real_tasks/notes.md``, measures generated motion, and writes ``real-captures.md`` and
``pictures/`` below the output folder. An existing --database that has learned is used as it is.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

from measured_run import motiondb_command, run_measured

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from real_tasks import answers
from real_tasks.findings import Findings, Stages
from real_tasks.measures import hears_unseen_performers, load_parts, word_precision
from real_tasks.notes import read_notes
from real_tasks.real_page import write_report

NOTES = Path(__file__).with_name("real_tasks") / "notes.md"
STRIP = "14/14_06"


def build(data: Path, database: Path) -> Stages:
    """Add and learn from the command line, unless the database has learned already."""
    settings = {"MOTIONDB": str(database)}
    if database.exists():
        return Stages(None, None)
    sheet = data / "cmu-captions.tsv"
    add = run_measured(
        motiondb_command(
            "add", str(data / "cmu"), "--words", str(sheet), "--skip-bad-frames", "--json"
        ),
        settings,
    )
    print(f"add: {add.seconds:.0f} s, exit code {add.exit_code}", flush=True)
    learn = run_measured(motiondb_command("learn", "--json"), settings)
    print(f"learn: {learn.seconds:.0f} s, exit code {learn.exit_code}", flush=True)
    if learn.exit_code:
        raise SystemExit(f"{add.complaints}{learn.complaints}")
    return Stages(add, learn)


def count(db: MotionDB, database: Path) -> dict[str, float]:
    """Sizes of the contents of the database."""
    learned = db.learned
    infos = db.captures()
    space = store.load_space(db.store)
    return {
        "captures": len(infos),
        "seconds": sum(info.duration for info in infos),
        "performers": len({info.tags.get("performer") for info in infos}),
        "bytes": database.stat().st_size,
        "segments": len(learned.segments.symbols),
        "symbols": learned.symbols.n_symbols,
        "clusters": len(space.weights),
        "dimensions": space.coordinates.shape[1],
        "words": len(learned.association.words),
        "words twice": int((learned.association.counts > 1).sum()),
    }


def find(data: Path, database: Path, stages: Stages, output: Path) -> Findings:
    """Ask, judge, draw."""
    began = time.perf_counter()
    folder = output / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    notes = read_notes(NOTES)
    with motiondb.open(database, read_only=True) as db:
        learned = db.learned
        parts = load_parts(data / "cmu-segments.tsv", [i.name for i in db.captures()])
        words = answers.ask_words(db, notes, folder)
        print("words asked", flush=True)
        precision = {
            "motion alone, the performer's words known": word_precision(
                learned, learned.evidence.by_motion.takes
            ),
            "motion alone, performer's words never seen": word_precision(
                learned, hears_unseen_performers(learned)
            ),
        }
        examples = answers.ask_examples(db, parts, notes, folder)
        print("examples asked", flush=True)
        made = answers.make_sentences(db, folder)
        print("sentences made", flush=True)
        db.symbols.draw(folder / "symbols.png")
        db.captures.draw(STRIP, folder / "take-14-06.png")
        for name in ("symbols.png", "take-14-06.png"):
            answers.shrink(folder / name)
        return Findings(
            stages,
            count(db, database),
            *_refusals(stages, data),
            [f"{r.capture} {r.kind} {r.other}" for r in db.captures.relations()],
            words,
            precision,
            answers.find_parts(db, parts),
            examples,
            made,
            answers.measure_captures(db),
            notes,
            time.perf_counter() - began,
        )


def _refusals(stages: Stages, data: Path) -> tuple[list[str], list[str]]:
    """What ``add`` left out, without this machine's folders: problems, and files known already."""
    if stages.add is None:
        return [], []
    report = json.loads(stages.add.output)
    problems = [problem.replace(str(data), "DIR") for problem in report["problems"]]
    return problems, [f"{name} is {other}" for name, other in report["known"]]


def main() -> int:
    """Run everything; 0 when the report is written."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--database", type=Path, help="kept; used as it is where it exists")
    parser.add_argument("--output", type=Path, default=Path("docs/measured"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        database = arguments.database or Path(scratch) / "motions.duckdb"
        stages = build(arguments.data, database)
        findings = find(arguments.data, database, stages, arguments.output)
    path = write_report(findings, arguments.output / "real-captures.md")
    print(f"{path} written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
