"""Damaged copies of a learned database: is one called sound though a question fails?

The runs are those of ``tests/store/damage_runs.py``: five kinds of damage for each seed.
A copy is checked by ``motiondb check`` and asked for the catalogue, captions, searches by words and
by example, a description and captures; the answers are compared with those of the undamaged
database.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import damage_runs


@dataclass(frozen=True)
class Outcome:
    """What became of a damaged database.

    Attributes
    ----------
    seed, kind : the damage.
    said : what ``check`` says: "sound", "faults", or "refused" if the file cannot be opened.
    questions : "as before", "refused", "differs", "crashed", "hangs" or "raw ERROR".
    """

    seed: int
    kind: str
    said: str
    questions: str

    @property
    def is_failure(self) -> bool:
        """Called sound though a question fails; or an error that is not the project's."""
        wrong = self.questions != "as before"
        return (self.said == "sound" and wrong) or self.questions.startswith("raw")


def run(seeds: Sequence[int], database: Path) -> Iterator[Outcome]:
    """Damage, check and ask; five kinds for each seed."""
    kinds = damage_runs.KINDS
    for runs in damage_runs.runs(database, seeds, kinds):
        said = "refused" if runs.faults is None else "faults" if runs.faults else "sound"
        yield Outcome(runs.seed, runs.kind, said, runs.wrong or "as before")
