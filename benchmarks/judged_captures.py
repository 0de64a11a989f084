"""How often ``judge`` is right about real captures, each left out of its evidence.

    python benchmarks/judged_captures.py motions.duckdb --captures 90 --seed 1

Each capture is judged by its own shortest caption, and by that of a capture with none of its words.
The database has learned from all of them; a capture and its copies are no evidence about itself,
but other takes of its performer are.
"""

from __future__ import annotations

import argparse
import random
from collections import Counter
from pathlib import Path

import motiondb

SAID = {True: "shown", None: "not sure", False: "not shown"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("database", type=Path)
    parser.add_argument("--captures", type=int, default=90)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    with motiondb.open(asked.database, read_only=True) as db:
        words: dict[int, set[str]] = {}
        for described in db.learned.described:
            words.setdefault(described.capture_id, set()).update(described.words)
        captions = {i: c for i, c in db.words.all_captions().items() if c and i in words}
        sentence = {i: min((one.words for one in c), key=len) for i, c in captions.items()}
        names = {info.capture_id: info.name for info in db.captures()}
        numbers = sorted(sentence)
        told: dict[str, Counter[str]] = {"its own": Counter(), "another's": Counter()}
        for number in rng.sample(numbers, min(asked.captures, len(numbers))):
            others = [n for n in numbers if not words[n] & words[number]]
            for whose, of in (("its own", number), ("another's", rng.choice(others))):
                answer = db.judge(names[number], sentence[of])
                told[whose][SAID[answer.shown]] += 1
                if answer.shown is (whose != "its own"):
                    print(
                        f"{names[number]}: {sentence[of]!r} {SAID[answer.shown]}: {answer.reason}"
                    )
    print("| caption | shown | not sure | not shown |\n|---|---|---|---|")
    for whose, counts in told.items():
        print("|", " | ".join([whose, *(str(counts[said]) for said in SAID.values())]), "|")


if __name__ == "__main__":
    main()
