"""Make the knowledge that is shipped for ``motiondb learn --start cmu``, or compare with it.

    python benchmarks/start_knowledge.py --data DIR [-o FILE | --check]

``DIR`` holds the captures ``cmu/`` and the sheet ``cmu-captions.tsv``. Of the sheet, only the words
of the CMU index are used: the first row of a capture, unless it is a sentence about a person. The
further rows, and those sentences, come from the KIT Motion-Language annotations, whose terms do not
allow every use. Captures are added as a user would add them, ``learn`` runs with seed 0, and what
it learned is exported. ``--check`` does the same and compares it with the shipped file: the bytes,
and where they differ, by how much the numbers do. The last bits of the projections depend on the
linear algebra library and its number of threads; only larger differences are an error (exit 1).
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import motiondb
from motiondb.files.knowledge_file import read_knowledge
from motiondb.learn.codec import to_values
from motiondb.learn.knowledge import APART, Knowledge

SHIPPED = Path(motiondb.__file__).parent / "files" / "cmu.knowledge"
CREDIT = (
    "The data used in this project was obtained from mocap.cs.cmu.edu. "
    "The database was created with funding from NSF EIA-0196217."
)
ROUNDING = 1e-9
"""Difference that counts as rounding, as a share of the largest number of an array. The projections
that one thread and two threads made differed by 3e-13; chosen by hand."""
SENTENCE = re.compile(
    r"(while \w+, )?(the |a |an )?(person|peron|human|man|woman|someone|subject|dancer)\b", re.I
)
"""How sentences of the KIT annotations begin; the CMU index names no person."""


def index_rows(sheet: Path) -> list[dict[str, str]]:
    """A row for every capture of the sheet, with the words of the CMU index or none."""
    rows: dict[str, dict[str, str]] = {}
    with sheet.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            if row["file"] not in rows:
                said = "" if SENTENCE.match(row["words"]) else row["words"]
                rows[row["file"]] = {**row, "words": said}
    return list(rows.values())


def write_index(data: Path, sheet: Path) -> Path:
    """Write the sheet of index words."""
    rows = index_rows(data / "cmu-captions.tsv")
    with sheet.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), delimiter="\t", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return sheet


def make(data: Path, output: Path) -> Knowledge:
    """Add, learn with seed 0, export."""
    with tempfile.TemporaryDirectory() as folder:
        sheet = write_index(data, Path(folder) / "index.tsv")
        with motiondb.open(Path(folder) / "cmu.duckdb") as db:
            db.add(data / "cmu", sheet, motiondb.AddSettings(skip_bad_frames=True))
            db.learn(motiondb.LearnSettings(seed=0))
            return db.symbols.export_knowledge(output, name="cmu", credit=CREDIT)


def differences(made: Knowledge, shipped: Knowledge) -> tuple[list[str], bool]:
    """What differs; none if the files are the same to the last byte. Whether it is rounding."""
    if made.origin.digest == shipped.origin.digest:
        return [], True
    lines = [f"sha256 {made.origin.digest} in place of {shipped.origin.digest}"]
    same = replace(made.origin, digest="") == replace(shipped.origin, digest="")
    if not same:
        lines.append(f"origin: {made.origin} in place of {shipped.origin}")
    if made.taught.words != shipped.taught.words:
        lines.append(f"words: {sorted(set(made.taught.words) ^ set(shipped.taught.words))}")
        return lines, False
    ours = to_values(shipped, without=APART)
    for name, value in to_values(made, without=APART).items():
        values, theirs = np.asarray(value), np.asarray(ours.get(name, np.zeros(0)))
        if theirs.shape != values.shape:
            lines.append(f"{name}: shape {values.shape} in place of {theirs.shape}")
            same = False
        elif not np.array_equal(values, theirs, equal_nan=True):
            gap, scale = np.nanmax(np.abs(values - theirs)), np.nanmax(np.abs(theirs))
            lines.append(f"{name}: largest difference {gap:.3g}, largest number {scale:.3g}")
            same &= bool(gap <= ROUNDING * scale)
            same &= bool(np.array_equal(np.isnan(values), np.isnan(theirs)))
    return lines, same


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("-o", "--output", type=Path, default=SHIPPED)
    parser.add_argument("--check", action="store_true", help="Compare with the shipped file.")
    told = parser.parse_args()
    if told.check:
        with tempfile.TemporaryDirectory() as folder:
            made = make(told.data, Path(folder) / "cmu.knowledge")
        lines, same = differences(made, read_knowledge(SHIPPED))
        print("\n".join(lines) if lines else "the same, to the last byte")
        if same and lines:
            print("the same up to rounding")
        sys.exit(not same)
    made = make(told.data, told.output)
    print(f"{told.output}: {told.output.stat().st_size:,} bytes, sha256 {made.origin.digest}")
    print(
        f"{made.origin.captures} captures, {made.origin.captions} described, "
        f"{made.symbols.n_symbols} symbols, {len(made.taught.words)} words"
    )


if __name__ == "__main__":
    main()
