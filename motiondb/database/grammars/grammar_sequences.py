"""Generate motion from a grammar: derive a sentence, assemble its motion, and save both.

A derivation gives a string of terminals. Each terminal is played by one of its segments. The
segments are chosen so that the total cost of all joins is least, and are then stitched together.
The tree and the segments are saved with the motion, so that the sequence can be edited later: a
region is derived again, and everything outside the region keeps its terminals and its segments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motiondb import store
from motiondb.database.catalogue.cataloguing import check_name_free
from motiondb.database.generate.keeping import keep_generated
from motiondb.errors import QueryError, suggestion
from motiondb.grammar import synthesis
from motiondb.grammar.cfg import context_free
from motiondb.records import CaptureInfo, Motion

MAX_NAME = 200
"""Most characters in the name of a saved sequence, so that it can be the name of a file."""
LONGEST_STRING = 1000
"""Most terminals of a string that a user gives. The time for parsing grows with the cube of the
length; 1,000 terminals take some seconds with the grammars that were tried."""


@dataclass(frozen=True, eq=False)
class GrammarSequence:
    """A sentence of a grammar as motion.

    Attributes
    ----------
    grammar : str
        Name of the grammar.
    tree : Tree
        The derivation.
    choice : Choice
        The segment that plays each terminal, and the total cost of their joins.
    greedy : float
        Total cost of the joins of the greedy choice of segments, for comparison.
    made : Synthesis
        The motion with the sources of its frames.
    provenance : Provenance
        Source of each frame, with the licence of its capture.
    """

    grammar: str
    tree: context_free.Tree
    choice: synthesis.Choice
    greedy: float
    made: synthesis.Synthesis
    provenance: store.Provenance

    @property
    def string(self) -> tuple[str, ...]:
        """The terminals of the sentence."""
        return self.tree.leaves()

    @property
    def motion(self) -> Motion:
        """The motion on the canonical body."""
        return self.made.motion


@dataclass(frozen=True, eq=False)
class Material:
    """A grammar with the motions of its takes, as far as their captures are in the database.

    Attributes
    ----------
    database : Store
        The open store.
    learned : LearnedGrammar
        The grammar.
    numbers : mapping of int to int
        Take -> number of its capture, for the takes whose captures are in the database.
    """

    database: store.Store
    learned: store.LearnedGrammar
    numbers: Mapping[int, int]

    @cached_property
    def motions(self) -> dict[int, Motion]:
        """The motion of each take in ``numbers``."""
        return {take: store.load_motion(self.database, n) for take, n in self.numbers.items()}

    @cached_property
    def source(self) -> synthesis.ClipSource:
        """The motions in the form that the synthesis needs."""
        return synthesis.clip_source(self.motions)

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the captures that were removed; their segments cannot be played."""
        return tuple(
            source.name
            for take, source in enumerate(self.learned.sources)
            if take not in self.numbers
        )


def load_material(database: store.Store, name: str) -> Material:
    """Load a grammar with its takes; the motions are loaded when they are first needed.

    Raises
    ------
    QueryError
        When there is no grammar of this name.
    """
    learned = store.load_grammar(database, name)
    return Material(database, learned, store.load_source_numbers(database, learned))


def play(
    material: Material,
    tree: context_free.Tree,
    rng: np.random.Generator,
    pinned: Mapping[int, int] | None = None,
) -> GrammarSequence:
    """Return the motion of a derivation.

    Parameters
    ----------
    material : Material
        The grammar with its takes.
    tree : Tree
        The derivation.
    rng : Generator
        Draws the first segment of the greedy choice, with which the optimal choice is compared.
    pinned : mapping of int to int, optional
        Position in the string -> segment that plays it. The other segments are chosen.

    Returns
    -------
    GrammarSequence
        The sequence.

    Raises
    ------
    QueryError
        When the sentence is empty, or all captures that show one of its terminals were removed.
    """
    terminals, source = material.learned.terminals, material.source
    candidates, numbers = synthesis.clip_candidates(terminals, tree.leaves(), source, pinned)
    choice = synthesis.choose_clips(candidates, numbers)
    greedy = synthesis.choose_greedily(candidates, numbers, rng)
    made = synthesis.synthesise(terminals, choice.clips, source)
    captures = np.array([material.numbers[int(take)] for take in made.takes])
    provenance = store.to_provenance(
        material.database, captures, made.frames.astype(float), edits=made.edits
    )
    return GrammarSequence(material.learned.name, tree, choice, greedy.cost, made, provenance)


def keep(
    material: Material, sequence: GrammarSequence, name: str, seed: int, how: Mapping[str, object]
) -> CaptureInfo:
    """Save a sequence with its derivation in one transaction, as ``Grammars.save`` does."""
    database, learned = material.database, material.learned
    _check_name(name)
    check_name_free(database, name)
    parameters = {"grammar": learned.name, "string": " ".join(sequence.string), **how}
    with store.transaction(database):
        run_id = store.start_run(database, "grammar generate", parameters, seed)
        info = keep_generated(database, name, sequence.motion, sequence.provenance, (), run_id)
        derivation = store.Derivation(
            learned.name, context_free.choices_of(sequence.tree), sequence.choice.clips
        )
        store.save_derivation(database, info.capture_id, learned.grammar_id, derivation, run_id)
        store.finish_run(database, run_id)
    return info


def _check_name(name: str) -> None:
    """Raise QueryError if a name is too long or not printable."""
    if len(name) > MAX_NAME or not name.isprintable():
        shown = name if len(name) <= MAX_NAME else f"{name[:MAX_NAME]}..."
        raise QueryError(
            f"{shown!r}: expected a name of at most {MAX_NAME} printable letters, found"
            f" {len(name)}. Choose a shorter one."
        )


def load_sequence(database: store.Store, name: str) -> tuple[context_free.Tree, store.Derivation]:
    """Load the derivation of a saved sequence.

    Parameters
    ----------
    database : Store
        The open store.
    name : str
        Name of the capture.

    Returns
    -------
    tree : Tree
        The derivation as a tree.
    derivation : Derivation
        The derivation as it is stored, with the segments.

    Raises
    ------
    QueryError
        When there is no such capture, or it has no derivation by a grammar of the database.
    """
    info = store.load_capture(database, name)
    derivation = store.load_derivation(database, info.capture_id)
    if derivation is None:
        raise QueryError(
            f"{info.name}: expected a capture that a grammar derived, found no such capture (or "
            f"its grammar was learned again or removed). Generate one: motiondb grammar generate."
        )
    learned = store.load_grammar(database, derivation.grammar)
    return context_free.derive_by(learned.grammar, derivation.rules), derivation


def terminals_of(grammar: context_free.Grammar, text: str | Sequence[str]) -> tuple[str, ...]:
    """Return the terminals of a string such as ``"a b c"``.

    Parameters
    ----------
    grammar : Grammar
        The grammar.
    text : str or sequence of str
        Terminals separated by spaces, or a sequence of terminals.

    Returns
    -------
    tuple of str
        The terminals.

    Raises
    ------
    QueryError
        When a name is not a terminal of the grammar (the message suggests the nearest one), or when
        there are more than ``LONGEST_STRING`` names.

    >>> terminals_of(context_free.read_grammar("S -> a b"), "b  a")
    ('b', 'a')
    """
    names = tuple(text.split()) if isinstance(text, str) else tuple(text)
    if len(names) > LONGEST_STRING:
        raise QueryError(
            f"string: expected at most {LONGEST_STRING} terminals, found {len(names)}. "
            "Ask for a shorter one."
        )
    for name in names:
        if name not in grammar.terminals:
            shown = ", ".join(grammar.terminals[:30])
            raise QueryError(
                f"{name!r}: expected terminals of the grammar ({shown}) with spaces between them,"
                " found another name."
                f"{suggestion(name, grammar.terminals) or ' motiondb grammar show tells them.'}"
            )
    return names
