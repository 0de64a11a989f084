"""Measure the benefit of a start, across studios and on unseen performers: docs/measured/start.md.

    python benchmarks/start_quality.py TASK [TASK ...] --data DIR [--parts FOLDER]
    python benchmarks/start_quality.py page

Tasks: ``cmu`` (knowledge of the CMU captures for the Bandai-Namco captures), ``bandai`` (back),
``unseen`` (knowledge of CMU performers for other CMU performers, without captions). Every task
writes its results to ``benchmarks/start_tasks/TASK.json``; ``page`` makes the page and the pictures
of all of them. With ``--parts`` a run that was ended goes on where it stopped; the folder is for
one state of the code only.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from start_tasks.page import write_page
from start_tasks.parts import Parts
from start_tasks.studios import across_studios, unseen_performers

RESULTS = Path(__file__).parent / "start_tasks"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="+", choices=["cmu", "bandai", "unseen", "page"])
    parser.add_argument("--data", type=Path, help="Folder of the real captures.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--parts", type=Path, help="Folder that keeps what an ended run has made.")
    told = parser.parse_args()
    parts = Parts(told.parts)
    for task in told.tasks:
        if task == "page":
            write_page(RESULTS, Path(__file__).parents[1] / "docs" / "measured")
            continue
        if told.data is None:
            parser.error("expected --data DIR, found none")
        if task == "unseen":
            results = unseen_performers(told.data, told.seed, parts)
        else:
            results = across_studios(told.data, task, told.seed, parts)
        text = json.dumps(results, indent=1) + "\n"
        (RESULTS / f"{task}.json").write_text(text, encoding="utf-8")
        print(text)


if __name__ == "__main__":
    main()
