"""The verbs of grammars: ``db.grammars.learn``, ``show``, ``parse``, ``suggest``, ``generate``, ...

As with the other verbs, each loads, computes by the pure stages, and saves; a grammar that was
loaded is kept by the session until the database changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import store
from motiondb.database.catalogue.catalogue_verbs import CatalogueVerbs
from motiondb.database.grammars import (
    grammar_comparing,
    grammar_editing,
    grammar_facts,
    grammar_learning,
    grammar_parsing,
    grammar_pictures,
    grammar_sequences,
)
from motiondb.database.grammars.grammar_editing import Edit
from motiondb.database.grammars.grammar_learning import GrammarSettings, Progress
from motiondb.database.grammars.grammar_parsing import ParsedMotion
from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material, terminals_of
from motiondb.database.grammars.grammar_words import Meaning, terminal_meanings
from motiondb.errors import QueryError
from motiondb.grammar.cfg import prefix
from motiondb.grammar.cfg.context_free import Tree
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.terminals.labelling import Reader, Reading, make_reader, read_string
from motiondb.records import CaptureInfo, Motion

if TYPE_CHECKING:
    from motiondb.database.session import Session


class Grammars:
    """The grammars of a database; reached as ``db.grammars``."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def learn(
        self,
        captures: Iterable[str],
        name: str | None = None,
        settings: GrammarSettings | None = None,
        progress: Progress | None = None,
    ) -> tuple[store.LearnedGrammar, list[str]]:
        """Learn a grammar from captures, in place of one of the same name.

        Returns
        -------
        The grammar, and the generated captures that can no longer be edited since the grammar that
        derived them was replaced.
        """
        return grammar_learning.learn_grammar(
            self._session.store, list(captures), name, settings or GrammarSettings(), progress
        )

    def names(self) -> list[str]:
        """The names of all grammars."""
        return store.load_grammar_names(self._session.store)

    def sizes(self) -> list[store.GrammarSize]:
        """How much each grammar holds, by name."""
        return store.load_grammar_sizes(self._session.store)

    def size(self, name: str) -> store.GrammarSize:
        """How much a grammar holds (QueryError: none of this name)."""
        name = self.load(name).name
        return next(size for size in self.sizes() if size.name == name)

    def load(self, name: str) -> store.LearnedGrammar:
        """Return a grammar with terminals, sentences and parses (QueryError: none of this name)."""
        return self.material(name).learned

    def remove(self, name: str) -> list[str]:
        """Take a grammar out; gives the generated captures that can no longer be edited."""
        with store.transaction(self._session.store):
            run_id = store.start_run(self._session.store, "grammar remove", {"name": name})
            lost = store.remove_grammar(self._session.store, name)
            store.finish_run(self._session.store, run_id)
        return lost

    def material(self, name: str) -> Material:
        """A grammar with the captures it rests on, as far as they are there."""
        return self._session.kept(
            ("grammar", name), lambda: grammar_sequences.load_material(self._session.store, name)
        )

    def meanings(self, name: str) -> tuple[Meaning, ...]:
        """Words and motion symbols of the terminals; empty where the database has not learned."""
        material = self.material(name)
        with self._session.reading():
            learned = self._session.learned if store.is_learned(self._session.store) else None
        return terminal_meanings(learned, material.learned, material.numbers)

    def show(self, name: str) -> dict[str, Any]:
        """Everything known of a grammar, for print or JSON; times in seconds."""
        return grammar_facts.grammar_facts(self.material(name), self.meanings(name))

    def draw_trees(self, name: str, path: str | Path) -> Path:
        """Return the derivation trees of the grammar's sentences, as PNG."""
        return grammar_pictures.draw_sentences(self.material(name), path)

    def draw_strings(self, name: str, path: str | Path) -> Path:
        """Terminals with their figures and words, and the captures as strings of them, as PNG."""
        return grammar_pictures.draw_strings(self.material(name), self.meanings(name), path)

    def draw_parse(self, name: str, found: ParsedMotion, path: str | Path) -> Path:
        """Return the trees of what was parsed, as PNG."""
        return grammar_pictures.draw_parse(self.material(name), found.trees, path)

    def draw_edit(self, name: str, edited: Edit, path: str | Path) -> Path:
        """Return a region's alternatives as trees, as PNG."""
        return grammar_pictures.draw_edit(self.material(name), edited, path)

    def draw_sequence(self, sequence: GrammarSequence, path: str | Path) -> Path:
        """Return a sequence as a strip of figures over its terminals and sources, as PNG."""
        return grammar_pictures.draw_sequence(self.material(sequence.grammar), sequence, path)

    def parse(self, name: str, example: str | Path | Motion) -> ParsedMotion:
        """Return the sentences of a capture, as learned, or read now if it was not learned from.

        A capture that is read anew gets terminals whatever it shows: ``unlike`` of the answer names
        the segments that are like nothing the grammar was learned from.

        Raises
        ------
        QueryError : no such grammar or capture, or one that is too short to hold a terminal.
        """
        with self._session.reading():
            material = self.material(name)
            take = self._take(material, example)
            if take is not None:
                return grammar_parsing.as_learned(material.learned, take)
            reading = self._read(material, CatalogueVerbs(self._session).motion(example))
        return grammar_parsing.parse_reading(material.learned.grammar, reading)

    def _take(self, material: Material, example: str | Path | Motion) -> int | None:
        """Return the take that an example is, be it a capture or a file with the same bytes."""
        if isinstance(example, Motion):
            return None
        if _is_file(example):
            sha256 = store.digest(Path(example).read_bytes())
            sources = enumerate(material.learned.sources)
            return next((take for take, source in sources if source.sha256 == sha256), None)
        info = store.load_capture(self._session.store, str(example), or_file=True)
        return next((take for take, n in material.numbers.items() if n == info.capture_id), None)

    def _read(self, material: Material, motion: Motion) -> Reading:
        reader: Reader = self._session.kept(
            ("reader", material.learned.name),
            lambda: make_reader(material.learned.terminals, material.motions),
        )
        return read_string(reader, motion)

    def suggest(
        self, name: str, beginning: str | Sequence[str] = ""
    ) -> tuple[tuple[str | None, float], ...]:
        """Return the terminals that may come next with their probabilities; None is the end.

        Raises
        ------
        QueryError : a terminal that the grammar does not know. ParseError : no sentence begins so.
        """
        grammar = self.load(name).grammar
        return prefix.suggest(grammar, terminals_of(grammar, beginning))

    def generate(self, name: str, seed: int = 0, length: int | None = None) -> GrammarSequence:
        """Return a new sentence as motion; the same seed gives the same motion.

        length : terminals wished; where no sentence has so many, the nearest number that one has.
        """
        if length is not None and length < 1:
            raise QueryError(f"length: expected at least 1 terminal, found {length}. Ask for more.")
        material, rng = self.material(name), np.random.default_rng(seed)
        return grammar_sequences.play(
            material, derive(material.learned.grammar, rng, length=length), rng
        )

    def edit(
        self,
        name: str,
        sequence: str | Sequence[str] | GrammarSequence,
        at: int,
        levels: tuple[int, int] = (0, 0),
        n: int = grammar_editing.N_ALTERNATIVES,
        seed: int = 0,
    ) -> Edit:
        """Return what else could stand in the region around a position of a sequence.

        Parameters
        ----------
        sequence : the name of a kept sequence, a string of terminals, or a sequence at hand.
        at : position from 0. levels : how many ancestors wider, then descendants narrower.
        """
        return grammar_editing.offer(self.material(name), sequence, at, levels, n, seed)

    def play(self, name: str, edited: Edit, number: int, seed: int = 0) -> GrammarSequence:
        """Return the sequence with alternative ``number`` (from 0) in place, as motion."""
        return grammar_editing.play_alternative(self.material(name), edited, number, seed)

    def compare(self, name: str, seed: int = 0) -> tuple[grammar_comparing.ComparedGrammar, ...]:
        """Compare a grammar with a finite state machine, Sequitur and flat rules."""
        return grammar_comparing.compare(self.load(name), seed)

    def facts(self, sequence: GrammarSequence, seed: int = 0) -> dict[str, Any]:
        """How a sequence came about, for JSON: string, tree, seams and sources.

        Parameters
        ----------
        sequence : GrammarSequence
            The sequence.
        seed : int
            The seed that the facts name.
        """
        return grammar_facts.sequence_facts(sequence, seed)

    def write(self, sequence: GrammarSequence, path: str | Path, seed: int = 0) -> dict[str, Any]:
        """Write a sequence, and beside it ``NAME.provenance.json`` with the origin of its frames.

        Parameters
        ----------
        sequence : GrammarSequence
            The sequence.
        path : str or Path
            The ending says the format: .bvh, .glb or .gltf.
        seed : int
            The seed that the facts name.

        Returns
        -------
        dict
            The facts, with the names of both files.

        Raises
        ------
        MotionDBError
            When the ending is another one, or a file cannot be written.
        """
        return grammar_facts.write_sequence(sequence, seed, Path(path))

    @staticmethod
    def format_tree(tree: Tree) -> str:
        """A derivation tree on one line, every nonterminal with what it derives in brackets."""
        return grammar_facts.format_tree(tree)

    def save(
        self,
        name: str,
        sequence: GrammarSequence,
        seed: int = 0,
        how: Mapping[str, object] | None = None,
    ) -> CaptureInfo:
        """Keep a sequence as a generated capture, with its derivation, so that it can be edited."""
        material = self.material(sequence.grammar)
        return grammar_sequences.keep(material, sequence, name, seed, how or {})


def _is_file(example: str | Path) -> bool:
    """Whether a text is the path of a file; a text that cannot be a path is none."""
    try:
        return Path(example).is_file()
    except (OSError, ValueError):  # too long for a path, or with a null character
        return False
