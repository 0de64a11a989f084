"""Editing a sequence: a terminal is picked, its region named, other derivations of it offered.

Outside the region terminals and segments stay, so the motion there is the same up to the blends at
the region's ends; it may stand at another place and face another way, for what comes before it has
changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb import store
from motiondb.database.grammars.grammar_sequences import (
    GrammarSequence,
    Material,
    load_sequence,
    play,
    terminals_of,
)
from motiondb.errors import QueryError
from motiondb.grammar.cfg import context_free, parse
from motiondb.grammar.derivation import edit

N_ALTERNATIVES = 4


@dataclass(frozen=True, eq=False)
class Edit:
    """A region of a sequence and what could stand there instead.

    Attributes
    ----------
    before : the derivation that is edited; clips : its segments, empty where it is only a string.
    region : the nonterminal and the positions it covers.
    alternatives : most probable first; each may be played.
    """

    before: context_free.Tree
    clips: tuple[int, ...]
    region: edit.Region
    alternatives: tuple[edit.Alternative, ...]

    def tree(self, number: int) -> context_free.Tree:
        """Return the derivation with alternative ``number`` (from 0) in the region.

        Raises
        ------
        QueryError : there is no such alternative.
        """
        if not 0 <= number < len(self.alternatives):
            raise QueryError(
                f"alternative {number + 1}: expected 1 to {len(self.alternatives)}, found another"
                " number. Choose one of those that are offered."
            )
        return edit.replace_region(self.before, self.region, self.alternatives[number].tree)

    def pinned(self, number: int) -> dict[int, int]:
        """Position -> segment, outside the region, in the string with alternative ``number``."""
        shift = len(self.alternatives[number].string) - (self.region.end - self.region.start)
        return {
            position + (shift if position >= self.region.end else 0): clip
            for position, clip in enumerate(self.clips)
            if not self.region.start <= position < self.region.end
        }


def offer(
    material: Material,
    sequence: str | Sequence[str] | GrammarSequence,
    at: int,
    levels: tuple[int, int] = (0, 0),
    n: int = N_ALTERNATIVES,
    seed: int = 0,
) -> Edit:
    """Alternatives for the region around a position of a sequence.

    Parameters
    ----------
    sequence : the name of a kept sequence, a string of terminals, or a sequence at hand.
    at : the picked position, from 0. levels : how many wider, then narrower.

    Raises
    ------
    QueryError : no such capture, one of another grammar, a region outside the sequence. ParseError
        : a string that is no sentence.
    """
    tree, clips = _before(material, sequence)
    try:
        region = edit.region_at(tree, at)
        region = edit.wider(tree, region, levels[0])
        region = edit.narrower(tree, region, levels[1])
    except context_free.GrammarError as error:  # it is the question that does not fit
        raise QueryError(str(error)) from None
    rng = np.random.default_rng(seed)
    found = edit.alternatives(material.learned.grammar, tree, region, n, rng)
    return Edit(tree, clips, region, found)


def play_alternative(material: Material, edited: Edit, number: int, seed: int) -> GrammarSequence:
    """Return the whole sequence with an alternative (from 0) in its region, as motion.

    Raises
    ------
    QueryError : there is no such alternative, or a capture is gone that plays what lies outside
        the region.
    """
    tree, pinned = edited.tree(number), edited.pinned(number)
    takes = {int(material.learned.terminals.takes[clip]) for clip in pinned.values()}
    gone = sorted(material.learned.sources[t].name for t in takes if t not in material.numbers)
    if gone:
        raise QueryError(
            f"{' '.join(edited.before.leaves())}: expected the captures that play what is not"
            f" edited, found {', '.join(gone)} removed. Add them again, or edit the string instead"
            " of the sequence: then all of it is played anew."
        )
    return play(material, tree, np.random.default_rng(seed), pinned)


def _before(
    material: Material, sequence: str | Sequence[str] | GrammarSequence
) -> tuple[context_free.Tree, tuple[int, ...]]:
    name, grammar = material.learned.name, material.learned.grammar
    if isinstance(sequence, GrammarSequence):
        _check_same(sequence.grammar, name, "sequence")
        return sequence.tree, sequence.choice.clips
    words = sequence.split() if isinstance(sequence, str) else list(sequence)
    if isinstance(sequence, str) and _is_kept(material.database, sequence, words, grammar):
        tree, derivation = load_sequence(material.database, sequence)
        _check_same(derivation.grammar, name, sequence)
        return tree, derivation.clips
    return parse.parse(grammar, terminals_of(grammar, words)), ()


def _is_kept(
    database: store.Store, sequence: str, words: Sequence[str], grammar: context_free.Grammar
) -> bool:
    """Whether a text names a capture: it does unless all its words are terminals."""
    if any(info.name == sequence for info in store.load_captures(database)):
        return True
    return len(words) == 1 and words[0] not in grammar.terminals


def _check_same(found: str, wanted: str, what: str) -> None:
    if found != wanted:
        raise QueryError(
            f"{what}: expected a sequence of the grammar {wanted}, found one of {found}."
            f" Edit it by that one: motiondb grammar edit {found} ..."
        )
