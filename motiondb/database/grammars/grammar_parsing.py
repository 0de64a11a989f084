"""A capture as sentences of a grammar: as it was learned from it, or read anew.

A reading gives every segment the terminal it is least unlike, so a motion that has nothing to do
with the grammar becomes a string too, and may even parse. That is why each segment's distance from
its terminal is told beside how far the terminal's members usually are where they were learned
(``grammar.reading``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb import store
from motiondb.grammar.cfg import context_free
from motiondb.grammar.cfg.parse import ParseError, parse_passage
from motiondb.grammar.terminals.labelling import Reading
from motiondb.records import MOTION_FPS

MOST_UNLIKE = 0.5
"""Share of a motion's time that may be unlike all terminals before the whole is said to be."""


@dataclass(frozen=True, eq=False)
class ParsedMotion:
    """A motion as a string of a grammar's terminals, and its sentences or what is wrong.

    Attributes
    ----------
    string, starts, ends : the terminals and their times (seconds).
    stored : whether the grammar was learned from it: then string and sentences are those stored.
    trees : the sentences' derivations, none where it does not parse. fault : why not.
    distances : how far each segment is from its terminal's medoid (metres); none where stored.
    reach : how far members usually are (metres); None where stored, or where too few can tell.
    """

    string: tuple[str, ...]
    starts: tuple[float, ...]
    ends: tuple[float, ...]
    stored: bool
    trees: tuple[context_free.Tree, ...] = ()
    fault: ParseError | None = None
    distances: tuple[float, ...] = ()
    reach: float | None = None

    @property
    def unlike(self) -> tuple[int, ...]:
        """Positions of the segments that are unlike anything the grammar was learned from."""
        far = np.inf if self.reach is None else self.reach
        return tuple(n for n, distance in enumerate(self.distances) if distance > far)

    @property
    def share_unlike(self) -> float:
        """Their share of the time, 0 to 1."""
        spent = sum(self.ends[n] - self.starts[n] for n in self.unlike)
        return spent / (self.ends[-1] - self.starts[0])

    @property
    def is_unlike(self) -> bool:
        """Whether most of the motion is unlike: then its string and sentences mean nothing."""
        return self.share_unlike > MOST_UNLIKE


def parse_reading(grammar: context_free.Grammar, reading: Reading) -> ParsedMotion:
    """Return the most probable sentences of a reading, or the place where it fails."""
    starts, ends = (tuple((x / MOTION_FPS).tolist()) for x in (reading.starts, reading.ends))
    trees: tuple[context_free.Tree, ...] = ()
    fault = None
    try:
        trees = parse_passage(grammar, reading.string)
    except ParseError as found:
        fault = found
    reach = None if np.isnan(reading.reach) else reading.reach
    distances = tuple(reading.distances.tolist())
    return ParsedMotion(reading.string, starts, ends, False, trees, fault, distances, reach)


def as_learned(learned: store.LearnedGrammar, take: int) -> ParsedMotion:
    """Return the stored string, sentences and parses of a take."""
    terminals = learned.terminals
    rows = np.flatnonzero(terminals.takes == take)
    own = [n for n, (a, _) in enumerate(learned.sentences) if rows[0] <= a <= rows[-1]]
    return ParsedMotion(
        learned.string(int(rows[0]), int(rows[-1]) + 1),
        tuple((terminals.starts[rows] / MOTION_FPS).tolist()),
        tuple((terminals.ends[rows] / MOTION_FPS).tolist()),
        True,
        tuple(context_free.derive_by(learned.grammar, learned.parses[n]) for n in own),
    )
