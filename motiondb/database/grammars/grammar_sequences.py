"""New sequences that a grammar allows, as motion: derived, edited, kept with their derivation.

A derivation gives a string of terminals; every terminal is played by one of its segments, chosen so
that all seams together cost least; the segments are stitched. What is kept is the tree and the
segments, so the sequence can be edited later: a region is derived anew, and everything outside
keeps its terminals and its segments.
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
"""Letters of the name of a kept sequence, so that it can be the name of a file."""
LONGEST_STRING = 1000
"""Most terminals of a string that a user gives. Parsing takes time in proportion to the cube of the
length; 1,000 terminals take some seconds with the grammars that were tried."""


@dataclass(frozen=True, eq=False)
class GrammarSequence:
    """A sentence of a grammar as motion.

    Attributes
    ----------
    grammar : its name. tree : the derivation. choice : the segments and J, the cost of their seams;
    greedy : J of the paper's greedy choice. made : the motion with its frames' sources.
    provenance : per frame, with licences.
    """

    grammar: str
    tree: context_free.Tree
    choice: synthesis.Choice
    greedy: float
    made: synthesis.Synthesis
    provenance: store.Provenance

    @property
    def string(self) -> tuple[str, ...]:
        """The terminals."""
        return self.tree.leaves()

    @property
    def motion(self) -> Motion:
        """The motion on the canonical body."""
        return self.made.motion


@dataclass(frozen=True, eq=False)
class Material:
    """A grammar and the motion of its takes, as far as their captures are there.

    numbers : take -> capture.
    """

    database: store.Store
    learned: store.LearnedGrammar
    numbers: Mapping[int, int]

    @cached_property
    def motions(self) -> dict[int, Motion]:
        """The takes' motions."""
        return {take: store.load_motion(self.database, n) for take, n in self.numbers.items()}

    @cached_property
    def source(self) -> synthesis.ClipSource:
        """What synthesis needs of them."""
        return synthesis.clip_source(self.motions)

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the captures that are gone: their segments cannot be played."""
        return tuple(
            source.name
            for take, source in enumerate(self.learned.sources)
            if take not in self.numbers
        )


def load_material(database: store.Store, name: str) -> Material:
    """Return the grammar of a name with its takes (QueryError: no such grammar)."""
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
    rng : draws the first segment of the greedy choice that the optimal one is compared with.
    pinned : position -> the segment that plays it.

    Raises
    ------
    QueryError : the sentence is empty, or all captures that show a terminal are gone.
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
    """Save a sequence as a generated capture with its derivation; all or nothing.

    how : what made it, for the run's parameters.

    Raises
    ------
    QueryError : a capture has this name.
    """
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
    if len(name) > MAX_NAME or not name.isprintable():
        shown = name if len(name) <= MAX_NAME else f"{name[:MAX_NAME]}..."
        raise QueryError(
            f"{shown!r}: expected a name of at most {MAX_NAME} printable letters, found"
            f" {len(name)}. Choose a shorter one."
        )


def load_sequence(database: store.Store, name: str) -> tuple[context_free.Tree, store.Derivation]:
    """Return the derivation of a kept sequence.

    Raises
    ------
    QueryError : no such capture, or one that no grammar derived.
    """
    info = store.load_capture(database, name)
    derivation = store.load_derivation(database, info.capture_id)
    if derivation is None:
        raise QueryError(
            f"{info.name}: expected a capture that a grammar derived, found none such (or its"
            " grammar was learned anew or removed). Generate one: motiondb grammar generate."
        )
    learned = store.load_grammar(database, derivation.grammar)
    return context_free.derive_by(learned.grammar, derivation.rules), derivation


def terminals_of(grammar: context_free.Grammar, text: str | Sequence[str]) -> tuple[str, ...]:
    """Terminals of a string such as ``"a b c"``.

    Raises
    ------
    QueryError : a name that is no terminal of the grammar (suggests the nearest); more than 1,000.

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
