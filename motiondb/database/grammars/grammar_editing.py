"""Edit a sequence: replace the region around a picked terminal by another derivation.

Terminals and segments outside the region do not change. The motion there is therefore the same,
except for the blends at the ends of the region. Its position and heading may change, because they
depend on the motion that precedes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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

N_ALTERNATIVES = 4  # Default number of alternatives


@dataclass(frozen=True, eq=False)
class Edit:
    """A region of a sequence with its alternatives.

    Attributes
    ----------
    before : Tree
        The derivation that is edited.
    clips : tuple of int
        The segment that plays each terminal, as row numbers of the grammar's segments. Empty if the
        edited string has no motion.
    region : Region
        The nonterminal and the positions that it covers.
    alternatives : tuple of Alternative
        Other derivations of the region, most probable first.
    """

    before: context_free.Tree
    clips: tuple[int, ...]
    region: edit.Region
    alternatives: tuple[edit.Alternative, ...]

    def tree(self, number: int) -> context_free.Tree:
        """Return the derivation with an alternative in the region.

        Parameters
        ----------
        number : int
            Number of the alternative, from 0.

        Returns
        -------
        Tree
            The derivation of the whole sequence.

        Raises
        ------
        QueryError
            When there is no such alternative.
        """
        if not 0 <= number < len(self.alternatives):
            raise QueryError(
                f"alternative {number + 1}: expected 1 to {len(self.alternatives)}, found another"
                " number. Choose one of those that are offered."
            )
        return edit.replace_region(self.before, self.region, self.alternatives[number].tree)

    def pinned(self, number: int) -> dict[int, int]:
        """Return the segments outside the region.

        Parameters
        ----------
        number : int
            Number of the alternative, from 0. Its length shifts the positions after the region.

        Returns
        -------
        dict of int to int
            Position in the string with the alternative -> segment that plays it.
        """
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
    """Find alternatives for a region of a sequence, as ``Grammars.edit`` does."""
    tree, clips = _before(material, sequence)
    try:
        region = edit.region_at(tree, at)
        region = edit.wider(tree, region, levels[0])
        region = edit.narrower(tree, region, levels[1])
    except context_free.GrammarError as error:  # the region was asked for by the user
        raise QueryError(str(error)) from None
    rng = np.random.default_rng(seed)
    offered = edit.alternatives(material.learned.grammar, tree, region, n, rng)
    return Edit(tree, clips, region, offered)


def play_alternative(material: Material, edited: Edit, number: int, seed: int) -> GrammarSequence:
    """Return the whole sequence, with an alternative in its region, as motion."""
    tree, pinned = edited.tree(number), edited.pinned(number)
    gone = _gone(material, pinned.values())
    if gone:
        raise QueryError(
            f"{' '.join(edited.before.leaves())}: expected the captures that play what is not"
            f" edited, found {', '.join(gone)} removed. Add them again, or edit the string "
            f"instead of the sequence: then all of it is assembled again."
        )
    return play(material, tree, np.random.default_rng(seed), pinned)


def play_saved(material: Material, name: str, seed: int) -> GrammarSequence:
    """Return a saved sequence as motion, assembled again from its segments."""
    tree, derivation = load_sequence(material.database, name)
    gone = _gone(material, derivation.clips)
    if gone:
        raise QueryError(
            f"{name}: expected the captures that play it, found {', '.join(gone)} removed."
            " Add them again."
        )
    return play(material, tree, np.random.default_rng(seed), dict(enumerate(derivation.clips)))


def _gone(material: Material, clips: Iterable[int]) -> list[str]:
    """Return the names of removed captures among those that play some segments."""
    takes = {int(material.learned.terminals.takes[clip]) for clip in clips}
    return sorted(material.learned.sources[t].name for t in takes if t not in material.numbers)


def _before(
    material: Material, sequence: str | Sequence[str] | GrammarSequence
) -> tuple[context_free.Tree, tuple[int, ...]]:
    """Return the derivation of a sequence and its segments (none for a string of terminals)."""
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
    """Whether a text is the name of a capture.

    It is if a capture has this name, or if it is a single word that is not a terminal.
    """
    if any(info.name == sequence for info in store.load_captures(database)):
        return True
    return len(words) == 1 and words[0] not in grammar.terminals


def _check_same(actual: str, wanted: str, what: str) -> None:
    """Raise QueryError if a sequence belongs to another grammar."""
    if actual != wanted:
        raise QueryError(
            f"{what}: expected a sequence of the grammar {wanted}, found one of {actual}. Edit it "
            f"with that grammar: motiondb grammar edit {actual} ..."
        )
