"""Compare the judge of generated motion with people who looked at pictures.

    python benchmarks/judged_pictures.py --database FILE --draw DIR
    python benchmarks/judged_pictures.py --database FILE
    python benchmarks/judged_pictures.py --database FILE --rule

FILE is a database that has learned all CMU captures with their captions. Each row of
``real_tasks/judged_pictures.tsv`` is a sentence that a motion was *made* for, and one that it is
*asked* for, often another one of a similar kind, so that many pictures are wrong. ``--draw`` makes
the motions, draws each under the sentence that is asked, and writes where the frames come from
into the table; what a person sees in a picture ("right", "wrong", "cannot tell") is then written by
hand, before the verdicts are seen. Without ``--draw`` the verdicts are compared with what was seen.
A row whose motion has changed since it was looked at does not count.

``--rule`` chooses the limits of the verdicts on pairs of real captures, those of the judge's
calibration, with the performer left out: the smallest probability from which on at most 1 in 16 of
the captures without a word would be shown (sentences have several actions); the largest below which
at most 1 in 15 of those with it would not be, where another capture says the word alone; and the
smallest of a measured action from which on at most 1 in 12 of the captures without the word, but
fully measured, would be shown."""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np

import motiondb
from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.database.generating import Generated
from motiondb.generate.action_sources import find_sources
from motiondb.generate.motion_making import SPEED_NAMES
from motiondb.generate.sentence_plan import plan_sentence
from motiondb.generate.shown_actions import Asked, is_mixed, judge_motion
from motiondb.language.question.heads import verbs_in
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import hold_to_known
from motiondb.meaning.direction import ACTIONS, FULLY, gone
from motiondb.meaning.motion_judge import (
    PARTS,
    WINDOW,
    _draw_pairs,
    judge_without,
    judging_table,
    pool_windows,
    said_words,
)
from motiondb.meaning.occurrences import measured_track
from motiondb.meaning.regression import fit_probability, probability
from motiondb.symbols.hmm_jobs import one_blas_thread
from quality_tasks.generation_page import draw_pages
from real_tasks.answers import shrink

TABLE = Path(__file__).with_name("real_tasks") / "judged_pictures.tsv"
LOOKS = ("right", "wrong", "cannot tell")
VERDICTS = ("shown", "not sure", "not shown")


@dataclass(frozen=True)
class Row:
    """A picture: made, asked, "old" or "new" sentence, where it comes from, how it looks, why."""

    made: str
    asked: str
    kind: str
    source: str
    looks: str
    remark: str


def read_rows() -> list[Row]:
    """The rows of the table."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [Row(**row) for row in csv.DictReader(file, delimiter="\t")]


def write_rows(rows: Sequence[Row]) -> None:
    """Write the table."""
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        names = [field.name for field in fields(Row)]
        writer = csv.DictWriter(file, names, delimiter="\t", lineterminator="\n")
        writer.writeheader()
        writer.writerows(map(asdict, rows))


def source_of(made: Generated) -> str:
    """The captures and times that a motion was made from."""
    return "; ".join(one.done[0] for one in made.shown if one.done)


def judged(db: MotionDB, made: Generated, sentence: str) -> str:
    """The verdict on a motion for another sentence of as many actions."""
    learned = db.learned
    counts = {w: int(n) for w, n in zip(learned.association.words, learned.association.counts)}
    counts |= dict.fromkeys(SPEED_NAMES, 1)
    tree = hold_to_known(parse(sentence, learned.synonyms, learned.lemmas), counts).tree
    actions = plan_sentence(tree, np.random.default_rng(0))[0]
    verbs = verbs_in(sentence, learned.synonyms, learned.lemmas)
    numbers = {info.name: number for number, info in learned.captures.items()}
    asked = []
    for action, shown in zip(actions, (one for one in made.shown if one.done), strict=True):
        name = shown.done[0].split()[0]
        of = find_sources(learned, action, verbs)
        asked.append(
            Asked(
                of.action, shown.start, shown.end,
                directions=of.directions, performer=learned.performers[numbers[name]], capture=name,
            )
        )  # fmt: skip
    sources = [numbers[source.name] for source in made.provenance.sources]
    return verdict_of([one.shown for one in judge_motion(learned, made.motion, asked, sources)])


def verdict_of(shown: Sequence[bool | None]) -> str:
    """The verdict on a sentence: that of its worst action."""
    if any(one is False for one in shown):
        return "not shown"
    return "shown" if all(shown) else "not sure"


def interval(count: int, number: int) -> str:
    """A share with its 90 % interval (Wilson)."""
    if not number:
        return "-"
    z, p = 1.645, count / number
    middle = (p + z * z / (2 * number)) / (1 + z * z / number)
    half = z * np.sqrt(p * (1 - p) / number + z * z / (4 * number**2)) / (1 + z * z / number)
    return f"{p:.3f} ({max(middle - half, 0):.3f} to {min(middle + half, 1):.3f})"


def tell(rows: Sequence[tuple[Row, str]], detailed: bool) -> None:
    """Print verdicts against what was seen."""
    for kinds in (("old", "new"), ("old",), ("new",)):
        counts = Counter((row.looks, verdict) for row, verdict in rows if row.kind in kinds)
        print(f"\n{' and '.join(kinds)} sentences\n| looks | {' | '.join(VERDICTS)} | number |")
        print("|---|---|---|---|---|")
        for looks in LOOKS:
            each = [counts[looks, verdict] for verdict in VERDICTS]
            print(f"| {looks} | {' | '.join(map(str, each))} | {sum(each)} |")
        for looks, verdict, most in (("right", "not shown", 15), ("wrong", "shown", 12)):
            number = sum(counts[looks, v] for v in VERDICTS)
            share = interval(counts[looks, verdict], number)
            print(f"{looks}, but {verdict}: {share}; wanted at most {1 / most:.3f}")
    for row, verdict in rows if detailed else ():
        print(f"{verdict:9}  {row.looks:11}  {row.asked}  [{row.made}]  {row.source}")


def choose_limits(db: MotionDB) -> None:
    """Print the limits that the rule of the module gives."""
    learned = db.learned
    judge = learned.judge
    assert judge is not None
    inside = set(judge.captures.tolist())
    said = said_words(learned.described, learned.word_numbers)
    table = judging_table(
        judge, {c: s for c, s in said.items() if c in inside}, len(learned.word_numbers)
    )
    rng = np.random.default_rng(0)
    # cues, performer, whether the word is said, is measured, is an action, is never said alone
    seen = []
    with one_blas_thread():
        for word, with_it, without in _draw_pairs(table, learned.performers, rng):
            left = judge_without(table, (with_it, without))
            if left is None or left.n_captures[word] < 1.0:
                continue
            name = learned.association.words[word]
            for capture in (with_it, without):
                rows = pool_windows(db.session.pool.whitened(capture))
                n_rows = min(int(rng.integers(1, PARTS + 1)), len(rows))
                start = int(rng.integers(len(rows) - n_rows + 1))
                scores = left.scores(rows[start : start + n_rows])
                begin = start * (WINDOW // 2) * FEATURE_STEP
                end = begin + ((n_rows - 1) * (WINDOW // 2) + WINDOW) * FEATURE_STEP
                done = False
                if name in ACTIONS:
                    track = measured_track(db.motion(learned.captures[capture].name))
                    done = gone(track[begin:end], name) >= FULLY
                said_here, is_action = capture == with_it, name in ACTIONS
                cues = left.cues(scores, word)
                performer = learned.performers[capture]
                mixed = is_mixed(learned, left, (name,), performer)
                seen.append((cues, performer, said_here, done, is_action, mixed))
    cues = np.array([one[0] for one in seen])
    performers = np.array([one[1] for one in seen])
    right, done, action, mixed = np.array([one[2:] for one in seen], dtype=bool).T
    p = np.zeros(len(seen))
    for performer in np.unique(performers):
        out = performers == performer
        weights, constant = fit_probability(cues[~out], right[~out])
        p[out] = probability(cues[out] @ weights + constant)
    limits = np.arange(0.0, 1.0, 0.01)
    shown = [t for t in limits if (p >= t)[~right].mean() <= 1 / 16]
    unshown = [t for t in limits if (p < t)[right & ~mixed].mean() <= 1 / 15]
    of_action = [t for t in limits if ((p >= t) & done)[action & ~right].mean() <= 1 / 12]
    print(f"{len(seen) // 2} pairs; of measured actions {action.sum() // 2}")
    print(f"shown from {shown[0]:.2f}, not shown below {unshown[-1]:.2f}")
    print(f"a measured action shown from {of_action[0]:.2f}")


def main() -> None:
    """Draw, or compare."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--database", type=Path, required=True)
    parser.add_argument("--draw", type=Path, default=None)
    parser.add_argument("--each", action="store_true", help="print every row")
    parser.add_argument("--rule", action="store_true", help="choose the limits of the verdicts")
    given = parser.parse_args()
    with motiondb.open(given.database, read_only=True) as db:
        if given.rule:
            choose_limits(db)
            return
        rows = read_rows()
        motions = {row.made: db.generate(row.made, anyway=True) for row in rows}
        current = [source_of(motions[row.made]) for row in rows]
        if given.draw is not None:
            given.draw.mkdir(parents=True, exist_ok=True)
            pictures = [(row.asked, motions[row.made].motion) for row in rows]
            for path in draw_pages(pictures, given.draw, "judged", 60):
                shrink(path, 24)
            write_rows(
                [
                    row if row.source == now else replace(row, source=now, looks="", remark="")
                    for row, now in zip(rows, current)
                ]
            )
            return
        verdicts = [
            (
                row,
                verdict_of([one.shown for one in motions[row.made].shown])
                if row.made == row.asked
                else judged(db, motions[row.made], row.asked),
            )
            for row, now in zip(rows, current)
            if row.source == now and row.looks
        ]
    tell(verdicts, given.each)
    print(f"{len(rows) - len(verdicts)} of {len(rows)} rows are to be looked at (again)")


if __name__ == "__main__":
    main()
