"""Are the answers right? Every task of the quality benchmark on real captures; writes a report.

    python benchmarks/quality.py --data DIR [--task NAME ...] [--seed 0] [--output docs]

DIR holds ``cmu/``, ``bandai/`` and their sheets. Tasks are in ``quality_tasks/NAME.py``; without
--task all of them run. Sections of tasks that are not run stay as they are in ``quality.md``; the
table of targets at its top is read off all sections (``quality_protocol/targets.py``).
"""

from __future__ import annotations

import argparse
import importlib
import time
from pathlib import Path

from quality_protocol.report import pictures_of, to_markdown, write_section
from quality_protocol.targets import write_targets

TASKS = (
    "words", "hidden", "question", "by_symbols", "order", "order_frames", "directions", "example",
    "absent", "interval", "interval_certainty", "boundaries", "labelled", "segmentation", "analogy",
    "generation", "seams", "errors",
)  # fmt: skip
HEAD = """# Are the answers right?

Real captures (CMU, Bandai-Namco), measured by `python benchmarks/quality.py --data DIR`, for
motiondb and for simple baselines in the same run. No performer is in both the training part and the
test part, and copies and mirror images are left out (`14_36` repeats `14_31`). Settings are chosen
within the training part. Brackets hold bootstrap 95 % intervals. The columns "motiondb better by"
are paired differences on the same draws; a difference whose interval contains 0 does not count.
Unless stated otherwise, motiondb's symbols are also learned from the motion (never the words) of
the captures that are searched, as in a database; the variant without them is listed too.
"""


def main() -> None:
    """Run the tasks and write their sections and pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--task", nargs="+", choices=TASKS, default=TASKS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=Path("docs/measured"))
    args = parser.parse_args()
    (args.output / "pictures").mkdir(parents=True, exist_ok=True)
    for name in args.task:
        started = time.perf_counter()
        report = importlib.import_module(f"quality_tasks.{name}").run(args.data, args.seed)
        minutes = (time.perf_counter() - started) / 60.0
        text = to_markdown(report) + f"\n{minutes:.1f} minutes, seed {args.seed}.\n"
        write_section(args.output / "quality.md", name, text, HEAD)
        for picture in pictures_of(report):
            (args.output / "pictures" / picture.name).write_bytes(picture.png)
        print(text, flush=True)
    page = args.output / "quality.md"
    if all(f"<!-- task {name} -->" in page.read_text(encoding="utf-8") for name in TASKS):
        write_targets(page)


if __name__ == "__main__":
    main()
