"""Ask an open database, and print what that took: run as a process of its own.

    python benchmarks/growth_tasks/asking.py FILE

Prints one JSON object: processor seconds, and the largest resident size in bytes, which includes
the pages of mapped files that were read.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import motiondb
from motiondb import MotionDB, MotionDBError

WARM_UP = ("throw", "swim", "crawl", "stretch", "turn right", "walk, sit", "bend then reach")
"""Questions that are not timed. No other is asked before it is timed: its frames would be kept."""
WORDS = (
    *("walk", "run", "jump", "kick", "punch", "sit", "dance", "dribble", "climb", "wave", "box"),
    *("turn left", "reach up", "walk then jump", "run, turn left", "sit, stand up", "jump, run"),
)
SENTENCES = ("walk then run", "walk then jump", "run then kick", "jump then walk")
N_EXAMPLES = 12
EXAMPLE_SECONDS = 3.0


def peak() -> int:
    """Largest resident size of this process, bytes; ``getrusage`` counts that of its parent."""
    lines = Path("/proc/self/status").read_text().splitlines()
    (size,) = (line.split()[1] for line in lines if line.startswith("VmHWM"))
    return int(size) * 1024


def timed(
    asks: Sequence[Callable[[], object]], unless: tuple[type[Exception], ...] = ()
) -> list[float]:
    """Processor seconds of each question; those that end in some errors are left out."""
    seconds = []
    for ask in asks:
        began = time.process_time()
        try:
            ask()
        except unless:
            continue
        seconds.append(time.process_time() - began)
    return seconds


def main() -> None:
    """Ask, and print the figures."""
    figures: dict[str, float] = {}
    began = time.process_time()
    with motiondb.open(sys.argv[1], read_only=True) as db:
        db.search(WORDS[0])
        figures["first question, s"] = time.process_time() - began
        figures["first question, peak bytes"] = peak()
        warm_up, asks = ([lambda w=w: db.search(w) for w in some] for some in (WARM_UP, WORDS[1:]))
        timed(warm_up, (MotionDBError,))  # for words that are not known
        figures["word question, s"] = float(np.median(timed(asks, (MotionDBError,))))
        figures["word questions, peak bytes"] = peak()
        rows = [i for i in db.captures() if i.duration > EXAMPLE_SECONDS + 1.0]
        rows = rows[:: max(1, len(rows) // N_EXAMPLES)][:N_EXAMPLES]
        motions = [db.motion(i.name, 0.5, 0.5 + EXAMPLE_SECONDS) for i in rows]
        (figures["first example, s"],) = timed([lambda: db.like(motions[0])])
        likes = [lambda m=m: db.like(m) for m in motions[1:]]
        figures["example of 3 s, s"] = float(np.median(timed(likes)))
        figures["examples, peak bytes"] = peak()
        made = [lambda s=s: _generate(db, s) for s in SENTENCES]
        figures["first generated, s"] = timed(made[:1])[0]
        figures["two actions generated, s"] = float(np.median(timed(made[1:])))
        figures["peak bytes"] = peak()
    print(json.dumps(figures))


def _generate(db: MotionDB, words: str) -> None:
    db.generate(words, 7, anyway=True)


if __name__ == "__main__":
    main()
