"""Motion from a grammar: derive a sentence, assemble its motion, save both, and edit a region.

A derivation gives a string of terminals, and a chain of derivations a longer one. Each terminal is
played by one of its segments. The segments are chosen so that the total cost of all joins is least,
and are then stitched together. The tree and the segments of a single sentence are saved with the
motion, so that it can be edited later: the region around a picked terminal is derived again.
Terminals and segments outside the region do not change. The motion there is therefore the same,
except for the blends at the ends of the region. Its position and heading may change, because they
depend on the motion that precedes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice

import numpy as np

from motiondb import answers, store
from motiondb.database.catalogue.cataloguing import check_name_free
from motiondb.database.generated_files import keep_generated
from motiondb.database.loading import LearnedGrammar, load_learned_grammar
from motiondb.errors import QueryError, suggestion
from motiondb.grammar import synthesis
from motiondb.grammar.cfg import context_free, parse
from motiondb.grammar.derivation import edit
from motiondb.records import MOTION_FPS, CaptureInfo, Motion
from motiondb.tabled import Tabled

MAX_NAME = 200
"""Most characters in the name of a saved sequence, so that it can be the name of a file."""
LONGEST_STRING = 1000
"""Most terminals of a string that a user gives. The time for parsing grows with the cube of the
length; 1,000 terminals take some seconds with the grammars that were tried."""

N_ALTERNATIVES = 4  # Default number of alternatives for a region

DRAWS = 20  # Sentences that are drawn until one is new

LONGEST_CHAIN = 600.0  # Longest chain of sentences, in seconds; it bounds the time and memory


@dataclass(frozen=True, eq=False, repr=False)
class GrammarSequence(Tabled):
    """Sentences of a grammar as motion."""

    grammar: str
    """Name of the grammar."""
    trees: tuple[context_free.Tree, ...]
    """The derivations of the sentences in order; one unless the sequence is a chain."""
    choice: synthesis.Choice
    """The segment that plays each terminal, and the total cost of their joins."""
    made: synthesis.Synthesis
    """The motion with the sources of its frames."""
    provenance: store.Provenance
    """Source of each frame, with the licence of its capture."""

    @property
    def tree(self) -> context_free.Tree:
        """The derivation of a single sentence; QueryError for a chain."""
        if len(self.trees) > 1:
            raise QueryError(
                f"sequence: expected one sentence, found {len(self.trees)} that follow one another."
                " A chain has no single derivation: generate one sentence (without --seconds)."
            )
        return self.trees[0]

    @property
    def string(self) -> tuple[str, ...]:
        """The terminals of the sentences."""
        return tuple(name for tree in self.trees for name in tree.leaves())

    @property
    def motion(self) -> Motion:
        """The motion on the canonical body."""
        return self.made.motion


@dataclass(frozen=True, eq=False)
class Material:
    """A grammar with the motions of its takes, as far as their captures are in the database."""

    database: store.Store
    learned: LearnedGrammar
    # Take -> number of its capture, for the takes whose captures are in the database
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
    """Load a grammar with its takes; the motions are loaded when they are first needed."""
    learned = load_learned_grammar(database, name)
    return Material(database, learned, store.load_source_numbers(database, learned.sources))


def shown_at(learned: LearnedGrammar, first: int, end: int | None = None) -> answers.Medoid:
    """Where a segment is, or segments [first, end) of one take."""
    terminals = learned.terminals
    last = first if end is None else end - 1
    return answers.Medoid(
        learned.sources[int(terminals.takes[first])].name,
        round(float(terminals.starts[first]) / MOTION_FPS, 3),
        round(float(terminals.ends[last]) / MOTION_FPS, 3),
    )


def new_or_first(material: Material, drawn: Iterator[context_free.Tree]) -> context_free.Tree:
    """Return the first of some draws whose string no take has, else the first one."""
    known, draws = frozenset(material.learned.strings), islice(drawn, DRAWS)
    first = next(draws)
    return next((tree for tree in chain([first], draws) if tree.leaves() not in known), first)


def play(
    material: Material,
    trees: context_free.Tree | tuple[context_free.Tree, ...],
    pinned: Mapping[int, int] | None = None,
) -> GrammarSequence:
    """Return the motion of a derivation, or of several that follow one another.

    The first segment is one that begins a sentence of the takes, and the last one ends one, where
    the terminals have such segments. A motion from several places of the takes is preferred to a
    replay of one.

    `pinned` maps positions in the string to the segments that play them; the others are chosen.
    """
    terminals, source = material.learned.terminals, material.source
    trees = trees if isinstance(trees, tuple) else (trees,)
    string = [name for tree in trees for name in tree.leaves()]
    sentences = material.learned.sentences
    ends = {len(string) - 1: sentences[:, 1] - 1, 0: sentences[:, 0]}
    candidates, numbers = synthesis.clip_candidates(terminals, string, source, pinned, ends)
    choice = synthesis.choose_clips(candidates, numbers)
    if not pinned and choice.cost == 0.0:  # a replay
        choice = synthesis.choose_clips(candidates, numbers, synthesis.CONTINUING)
    made = synthesis.synthesise(terminals, choice.clips, source)
    captures = np.array([material.numbers[int(take)] for take in made.takes])
    provenance = store.to_provenance(
        material.database, captures, made.frames.astype(float), edits=made.edits
    )
    return GrammarSequence(material.learned.name, trees, choice, made, provenance)


def keep(
    material: Material, sequence: GrammarSequence, name: str, seed: int, how: Mapping[str, object]
) -> CaptureInfo:
    """Save a sequence in one transaction, as ``Grammars.save`` does.

    A single sentence is saved with its derivation, a chain without.
    """
    database, learned = material.database, material.learned
    _check_name(name)
    check_name_free(database, name)
    parameters = {"grammar": learned.name, "string": " ".join(sequence.string), **how}
    with store.running(database, "grammar generate", parameters, seed) as run_id:
        info = keep_generated(database, name, sequence.motion, sequence.provenance, (), run_id)
        if len(sequence.trees) == 1:  # a chain is no sentence of the grammar
            choices = context_free.choices_of(sequence.tree)
            derivation = store.Derivation(learned.name, choices, sequence.choice.clips)
            store.save_derivation(database, info.capture_id, learned.grammar_id, derivation, run_id)
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
    """Load the derivation of a saved sequence."""
    info = store.load_capture(database, name)
    derivation = store.load_derivation(database, info.capture_id)
    if derivation is None:
        raise QueryError(
            f"{info.name}: expected a capture that a grammar derived, found no such capture (or it "
            "is a chain of sentences, or its grammar was learned again or removed). Generate one: "
            "motiondb grammar generate."
        )
    learned = load_learned_grammar(database, derivation.grammar)
    return context_free.derive_by(learned.grammar, derivation.rules), derivation


def terminals_of(grammar: context_free.Grammar, text: str | Sequence[str]) -> tuple[str, ...]:
    """Return the terminals of a string such as ``"a b c"``.

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
                f"{suggestion(name, grammar.terminals) or ' motiondb grammar show lists them.'}"
            )
    return names


@dataclass(frozen=True, eq=False, repr=False)
class Edit(Tabled):
    """A region of a sequence with its alternatives."""

    before: context_free.Tree
    """The derivation that is edited."""
    clips: tuple[int, ...]
    """The segment that plays each terminal, as row numbers of the grammar's segments. Empty if the
    edited string has no motion."""
    region: edit.Region
    """The nonterminal and the positions that it covers."""
    alternatives: tuple[edit.Alternative, ...]
    """Other derivations of the region, most probable first."""

    def tree(self, number: int) -> context_free.Tree:
        """Return the derivation with an alternative, from 0, in the region."""
        if not 0 <= number < len(self.alternatives):
            raise QueryError(
                f"alternative {number + 1}: expected 1 to {len(self.alternatives)}, found another"
                " number. Choose one of those that are offered."
            )
        return edit.replace_region(self.before, self.region, self.alternatives[number].tree)

    def pinned(self, number: int) -> dict[int, int]:
        """Return the segments outside the region: position in the string -> segment that plays it.

        The positions are those in the string with an alternative (from 0), whose length shifts
        those after the region.
        """
        shift = len(self.alternatives[number].string) - (self.region.end - self.region.start)
        return {
            position + (shift if position >= self.region.end else 0): clip
            for position, clip in enumerate(self.clips)
            if not self.region.start <= position < self.region.end
        }


def gone(material: Material, clips: Iterable[int]) -> list[str]:
    """Return the names of removed captures among those that play some segments."""
    takes = {int(material.learned.terminals.takes[clip]) for clip in clips}
    return sorted(material.learned.sources[t].name for t in takes if t not in material.numbers)


def before(
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
