"""Answer the questions of a table as ``motiondb batch`` does, of a database that no other opens.

    python benchmarks/cluster_tasks/ask_sent.py DATABASE QUESTIONS [--cluster ADDRESS]

The database is opened to be changed, so that workers cannot open it, and shares of it are sent.
"""

from __future__ import annotations

import argparse
import csv
from contextlib import nullcontext
from pathlib import Path

import motiondb


def main() -> None:
    """Print every answer as Python shows it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("database", type=Path)
    parser.add_argument("questions", type=Path)
    parser.add_argument("--cluster")
    arguments = parser.parse_args()
    with arguments.questions.open(newline="") as file:
        questions = [
            motiondb.Question(row["question"])
            if row["question"]
            else motiondb.Question(
                like=row["like"], start=float(row["start"]), end=float(row["end"])
            )
            for row in csv.DictReader(file, delimiter="\t")
        ]
    cluster = motiondb.Cluster(arguments.cluster) if arguments.cluster else nullcontext()
    with cluster as workers, motiondb.open(arguments.database) as database:
        for answer in database.ask_many(questions, workers):
            print(repr(answer))


if __name__ == "__main__":
    main()
