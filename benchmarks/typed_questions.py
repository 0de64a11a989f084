"""Questions as people type them, asked of the CMU captures; prints how many answers are right.

    python benchmarks/typed_questions.py DATABASE [--half development|aside] [--show]

``question_tasks/questions.tsv`` was written before it was run: 300 questions of nine forms, each
with the captures that are right to show, by captions and by facts of the motion
(``question_tasks/key.py``). Half of every form is set aside by a seed, to be looked at in the end.

A question is *right* if its first answer is right and of the first three (fewer where fewer are
right) all are that have a probability of one half or more, and at least half; if nothing matches,
or something cannot be measured, the answer must say so and have no probability above one half.
*Partly*: some of the first three are right, or only the place is wrong. *Sure and wrong*: a wrong
capture among the first three has a probability of one half or more.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from question_tasks.key import Shown, captures_of, is_right

import motiondb
from motiondb.database import MotionDB
from motiondb.errors import MotionDBError

TABLE = Path(__file__).with_name("question_tasks") / "questions.tsv"
SEED, LIKELY, ROOM = 300, 0.5, 4.0  # ROOM: seconds by which a place may be longer than the event
VERDICTS = ("right", "partly", "wrong")


@dataclass(frozen=True)
class Verdict:
    verdict: str
    sure_and_wrong: bool
    said: str


def questions(half: str) -> list[dict[str, str]]:
    """The rows of one half: of every form, a random half is set aside."""
    rows = list(csv.DictReader(TABLE.open(encoding="utf-8"), delimiter="\t"))
    rng, chosen = np.random.default_rng(SEED), []
    for form in dict.fromkeys(row["form"] for row in rows):
        of_form = [row for row in rows if row["form"] == form]
        aside = set(rng.permutation(len(of_form))[: len(of_form) // 2].tolist())
        chosen += [row for n, row in enumerate(of_form) if (n in aside) == (half == "aside")]
    return chosen


def judge(db: MotionDB, row: dict[str, str], captures: dict[str, Shown]) -> Verdict:
    """What is right of the answer to a question."""
    key, is_unmeasured = row["right"].lstrip("~ "), row["right"].startswith("~")
    try:
        answer = db.search(row["question"], limit=3)
    except MotionDBError as fault:
        if key == "nothing" or is_unmeasured:
            return Verdict("right", False, str(fault)[:100])
        return Verdict("wrong", False, str(fault)[:100])
    right = {name for name in captures if key != "nothing" and is_right(key, captures[name])}
    first = answer.matches[: min(3, max(len(right), 1))]
    hits = [match.capture in right for match in first]
    sure = [(match.probability or 0.0) >= LIKELY for match in answer.matches]
    wrong_but_sure = any(s and m.capture not in right for s, m in zip(sure, answer.matches))
    said = (
        f"{answer.understood} | {answer.not_understood or answer.nothing} {answer.remarks} | "
        + "; ".join(f"{left.text}: {left.reason}" for left in answer.not_used)
        + " | "
        + ", ".join(
            f"{'+' if m.capture in right else '-'}{m.capture} {m.start:.1f}-{m.end:.1f} "
            f"{'-' if m.probability is None else format(m.probability, '.2f')}"
            f"{'!' if m.contradicted else ''}"
            for m in answer.matches
        )
    )
    is_told = bool(answer.nothing or answer.not_understood or answer.remarks)
    if key == "nothing":
        verdict = "wrong" if any(sure) else "right" if is_told or not first else "partly"
        return Verdict(verdict, any(sure), said)
    if is_unmeasured:
        told = is_told or bool(answer.not_used or answer.unmeasured or answer.taken)
        verdict = "wrong" if any(sure) else "right" if told else "partly"
        return Verdict(verdict, any(sure), said)
    if not right:
        raise SystemExit(f"{row['question']}: no capture is right by {key!r}")
    if not any(match.capture in right for match in answer.matches):
        return Verdict("wrong", wrong_but_sure, said)
    is_placed = all(_is_at(match.start, match.end, row["at"], match.capture) for match in first)
    good = hits[0] and 2 * sum(hits) >= len(hits) and not wrong_but_sure and is_placed
    denied = bool(answer.nothing or answer.not_understood)
    return Verdict("right" if good and not denied else "partly", wrong_but_sure, said)


def _is_at(start: float, end: float, at: str, capture: str) -> bool:
    """Whether an interval is about where the key says that the event is."""
    if not at or not at.startswith(f"{capture} "):
        return True
    first, last = map(float, at.split(" ")[1].split("-"))
    return start <= (first + last) / 2 <= end and end - start <= last - first + ROOM


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("database", type=Path)
    parser.add_argument("--half", choices=("development", "aside"), default="development")
    parser.add_argument("--show", action="store_true", help="print the answers that are not right")
    args = parser.parse_args()
    counts, sure = dict[str, Counter[str]](), 0
    with motiondb.open(args.database) as db:
        captures = {one.name: one for one in captures_of(db)}
        for row in questions(args.half):
            found = judge(db, row, captures)
            counts.setdefault(row["form"], Counter())[found.verdict] += 1
            sure += found.sure_and_wrong
            if args.show and (found.verdict != "right" or found.sure_and_wrong):
                mark = " SURE" if found.sure_and_wrong else ""
                print(f"{found.verdict}{mark} [{row['form']}] {row['question']}\n    {found.said}")
    print("form        " + "".join(f"{verdict:>8}" for verdict in VERDICTS))
    for form, of_form in [*counts.items(), ("all", sum(counts.values(), Counter()))]:
        print(f"{form:12}" + "".join(f"{of_form[verdict]:8}" for verdict in VERDICTS))
    total = sum(map(Counter.total, counts.values()))
    print(f"right {sum(c['right'] for c in counts.values()) / total:.2f}", end="; ")
    print(f"sure and wrong {sure} of {total}")


if __name__ == "__main__":
    main()
