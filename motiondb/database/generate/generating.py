"""``generate``: a motion from a sentence, with the origin of every frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from motiondb import store
from motiondb.database.generate.generated_files import (
    draw_generated,
    source_facts,
    write_with_provenance,
)
from motiondb.database.nearby_words import nearby_table
from motiondb.database.session import Session
from motiondb.learning.making.motion_making import METHODS, make_motion
from motiondb.learning.taken_words import replace_unknown
from motiondb.records import MOTION_FPS, Motion
from motiondb.words.nearby.taking import Taking
from motiondb.words.question.known import KnownQuestion
from motiondb.words.question.tree import NotUsed
from motiondb.words.translation import decoding

__all__ = ["METHODS", "Generated", "generate"]


@dataclass(frozen=True, eq=False)
class Generated:
    """A motion that was made from a sentence, and how.

    Attributes
    ----------
    motion : Motion
        On the canonical body, at 30 frames a second.
    symbols : tuple of int
        Decoded symbols.
    positions : tuple of int
        Per symbol the number of its action.
    actions : tuple of tuple of str
        Known words of every action.
    decodings : tuple of Decoding
        Per action.
    recognised : tuple of int
        Symbols recognised in the motion.
    provenance : Provenance
        Origin and licence of every frame.
    question : KnownQuestion
        The sentence as it was understood.
    spans : tuple of (int, int)
        First frame and last frame + 1 of every action.
    not_used : tuple of NotUsed
        What of the sentence the motion takes no account of.
    words : str
        The sentence.
    seed : int
        The seed.
    method : str
        One of ``METHODS``.
    taken : dict
        Word that no caption holds -> what it was taken as; the likeliest was used.
    suggested : dict
        Word that no caption holds -> what is made of it where it was not taken.
    """

    motion: Motion
    symbols: tuple[int, ...]
    positions: tuple[int, ...]
    actions: tuple[tuple[str, ...], ...]
    decodings: tuple[decoding.Decoding, ...]
    recognised: tuple[int, ...]
    provenance: store.Provenance
    question: KnownQuestion
    spans: tuple[tuple[int, int], ...] = ()
    not_used: tuple[NotUsed, ...] = ()
    words: str = ""
    seed: int = 0
    method: str = "stitched"
    taken: Mapping[str, Taking] = field(default_factory=dict)
    suggested: Mapping[str, Taking] = field(default_factory=dict)

    @property
    def unknown(self) -> Mapping[str, tuple[str, ...]]:
        """Words of the sentence that are not known -> nearest known words."""
        return self.question.unknown

    def facts(self) -> dict[str, Any]:
        """What was asked, decoded and used, for JSON; times in seconds."""
        return {
            "words": self.words,
            "seed": self.seed,
            "method": self.method,
            "seconds": round(self.motion.n_frames / MOTION_FPS, 3),
            "actions": [list(action) for action in self.actions],
            "symbols": list(self.symbols),
            "recognised": list(self.recognised),
            "decodings": [
                {
                    "symbols": list(d.symbols),
                    "log_probability": d.log_probability,
                    "nodes_expanded": d.nodes_expanded,
                    "certificate": d.certificate,
                }
                for d in self.decodings
            ],
            "sources": source_facts(self),
        }

    def write(self, path: str | Path) -> dict[str, Any]:
        """Write the motion, and beside it ``NAME.provenance.json`` with the origin of its frames.

        Parameters
        ----------
        path : str or Path
            The ending says the format: .bvh, .glb or .gltf.

        Returns
        -------
        dict
            The facts (:meth:`facts`), with the names of both files.

        Raises
        ------
        MotionDBError
            When the ending is another one, or a file cannot be written.
        """
        return write_with_provenance(self, self.facts(), Path(path))

    def draw(self, path: str | Path) -> Path:
        """Draw a strip of stick figures over the sources of the frames, as PNG.

        Raises
        ------
        MotionDBError
            When the file cannot be written.
        """
        return draw_generated(self, self.words, path)


def generate(
    session: Session, words: str, seed: int, method: str, exact: bool = False
) -> Generated:
    """Make a motion that shows what a sentence says.

    Parameters
    ----------
    session : Session
        The open database.
    words : str
        The sentence.
    seed : int
        The same seed gives the same motion.
    method : str
        One of ``METHODS``.
    exact : bool
        Whether words that no caption holds are left out; otherwise a word that may be taken as a
        known one is replaced by the likeliest.

    Raises
    ------
    QueryError
        For an unknown method, no known word, or words that no symbols can show.
    NotLearnedError
        When the database has not learned, or learned no words.
    """
    with session.reading():
        learned, takings = session.learned, dict[str, Taking]()
        if not exact:
            learned, takings = replace_unknown(learned, words, nearby_table())
        found = make_motion(learned, session.takes, words, np.random.default_rng(seed), method)
        made = found.made
        provenance = store.to_provenance(
            session.store, made.captures, made.frames, edits=made.edits
        )
    return Generated(
        motion=made.motion,
        symbols=tuple(int(s) for s in found.plan.symbols),
        positions=found.plan.positions,
        actions=found.plan.actions,
        decodings=found.decodings,
        recognised=tuple(int(s) for s in found.recognised),
        provenance=provenance,
        question=found.question,
        taken={word: taking for word, taking in takings.items() if taking.is_taken},
        suggested={word: taking for word, taking in takings.items() if not taking.is_taken},
        spans=found.spans,
        not_used=found.not_used,
        words=words,
        seed=seed,
        method=method,
    )
