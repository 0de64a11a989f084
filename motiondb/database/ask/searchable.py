"""What search and likeness look through: the learned captures, and those that were generated.

``learn`` passes over generated captures, so that the database does not learn from itself, and
nothing else that is learned may rest on them either: they take no part in counts, in what symbols
show, or as material for further generation. But whoever keeps a generated motion wants to find it
again. So they are cut and scored by the stored symbols when they are first looked for, in memory,
beside what was learned.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motiondb.database.learn.learned import Learned
from motiondb.database.learn.updating import recognise_captures
from motiondb.records import SegmentTable


def with_generated(learned: Learned) -> Learned:
    """What was learned, with segments of the generated captures; the same where there are none."""
    made = [i.capture_id for i in learned.captures.values() if i.kind == "generated"]
    if not made:
        return learned
    found = recognise_captures(learned.database, learned.symbols, learned.parameters, sorted(made))
    old = learned.segments
    movement = found.movement[:, : old.movement.shape[1]]  # none, where an older motiondb learned
    found = replace(found, movement=movement)
    order = np.argsort(np.concatenate([old.capture_ids, found.capture_ids]), kind="stable")
    columns = {
        name: np.concatenate([column, vars(found)[name]])[order]
        for name, column in vars(old).items()
    }
    return replace(learned, segments=SegmentTable(**columns))
