"""Parse a capture: by its stored sentences if the grammar was learned from it, else by reading.

Reading assigns a terminal to every segment, even if the motion shows something else. A motion that
has nothing in common with the grammar therefore also becomes a string, which may even parse. For
this reason the result gives the distance of each segment from its terminal, and the distance beyond
which a segment is unlike everything from which the grammar was learned (see
:mod:`motiondb.grammar.terminals.labelling`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import store
from motiondb.answers.grammars import ParseAnswer, ParsedSentence, ParseFault
from motiondb.answers.plain import extended
from motiondb.database.grammars.grammar_sequences import Material
from motiondb.database.learned_grammar import LearnedGrammar
from motiondb.files import packed_files
from motiondb.files.formats import read_file
from motiondb.files.limits import ReadOptions
from motiondb.files.safe_files import is_file
from motiondb.grammar.cfg import context_free
from motiondb.grammar.cfg.parse import ParseError, parse_passage
from motiondb.grammar.terminals.labelling import Reader, Transcription, make_reader, read_string
from motiondb.records import MOTION_FPS, Motion
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from motiondb.database.session import Session

MOST_UNLIKE = 0.5
"""Largest share of a motion's time that may be unlike all terminals before the whole motion is
reported as unlike."""


@dataclass(frozen=True, eq=False, repr=False)
class ParsedMotion(Tabled):
    """A motion as a string of terminals, with its sentences or the parse error."""

    string: tuple[str, ...]
    """The terminals."""
    starts: tuple[float, ...]
    """Start of each terminal, in seconds."""
    ends: tuple[float, ...]
    """End of each terminal, in seconds."""
    stored: bool
    """Whether the grammar was learned from the motion. The string and the sentences are then those
    that are stored."""
    trees: tuple[context_free.Tree, ...] = ()
    """The derivation of each sentence. Empty if the string does not parse."""
    fault: ParseError | None = None
    """Why the string does not parse."""
    distances: tuple[float, ...] = ()
    """Distance of each segment from the medoid of its terminal, in metres. Empty if ``stored``."""
    reach: float | None = None
    """Distance in metres beyond which a segment is unlike all terminals. None if ``stored``, or if
    the terminals have too few members to estimate it."""

    def facts(self) -> ParseAnswer:
        """The string with its sentences or its fault, for JSON."""
        fault = self.fault
        return extended(
            ParseAnswer,
            self,
            spans=list(zip(self.starts, self.ends)),
            learned_from=self.stored,
            usual_distance=self.reach,
            sentences=[ParsedSentence(tree.leaves(), str(tree)) for tree in self.trees],
            fault=fault and extended(ParseFault, fault, found=fault.symbol, says=str(fault)),
        )

    @property
    def unlike(self) -> tuple[int, ...]:
        """Positions of the segments that are farther from their terminal than ``reach``."""
        far = np.inf if self.reach is None else self.reach
        return tuple(n for n, distance in enumerate(self.distances) if distance > far)

    @property
    def share_unlike(self) -> float:
        """Share of the time taken by the segments in ``unlike``, from 0 to 1."""
        spent = sum(self.ends[n] - self.starts[n] for n in self.unlike)
        return spent / (self.ends[-1] - self.starts[0])

    @property
    def is_unlike(self) -> bool:
        """Whether most of the motion is unlike the grammar, so that its string has no meaning."""
        return self.share_unlike > MOST_UNLIKE


def take_of(material: Material, example: str | Path | Motion) -> int | None:
    """Return the take of a capture, or of a file with the same bytes; None if there is none."""
    if isinstance(example, Motion):
        return None
    if is_file(example):
        sha256 = packed_files.digest(read_file(Path(example), ReadOptions()))
        sources = enumerate(material.learned.sources)
        return next((take for take, source in sources if source.sha256 == sha256), None)
    info = store.load_capture(material.database, str(example), or_file=True)
    return next((take for take, n in material.numbers.items() if n == info.capture_id), None)


def read(session: Session, material: Material, motion: Motion) -> Transcription:
    """Read a motion as a string of terminals; the session keeps the reader."""
    reader: Reader = session.kept(
        ("reader", material.learned.name),
        lambda: make_reader(material.learned.terminals, material.motions),
    )
    return read_string(reader, motion)


def parse_transcription(
    grammar: context_free.Grammar, transcription: Transcription
) -> ParsedMotion:
    """Return the most probable sentences of a transcription, or the place where parsing fails."""
    starts, ends = (
        tuple((x / MOTION_FPS).tolist()) for x in (transcription.starts, transcription.ends)
    )
    trees: tuple[context_free.Tree, ...] = ()
    fault = None
    try:
        trees = parse_passage(grammar, transcription.string)
    except ParseError as found:
        fault = found
    reach = None if np.isnan(transcription.reach) else transcription.reach
    distances = tuple(transcription.distances.tolist())
    return ParsedMotion(transcription.string, starts, ends, False, trees, fault, distances, reach)


def as_learned(learned: LearnedGrammar, take: int) -> ParsedMotion:
    """Return the stored string, sentences and parses of a take."""
    terminals = learned.terminals
    rows = np.flatnonzero(terminals.takes == take)
    sentences_of_take = [
        n for n, (a, _) in enumerate(learned.sentences) if rows[0] <= a <= rows[-1]
    ]
    return ParsedMotion(
        learned.string(int(rows[0]), int(rows[-1]) + 1),
        tuple((terminals.starts[rows] / MOTION_FPS).tolist()),
        tuple((terminals.ends[rows] / MOTION_FPS).tolist()),
        True,
        tuple(
            context_free.derive_by(learned.grammar, learned.parses[n]) for n in sentences_of_take
        ),
    )
