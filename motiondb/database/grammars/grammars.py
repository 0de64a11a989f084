"""The verbs of grammars: ``db.grammars.learn``, ``show``, ``parse``, ``generate``, ...

The session keeps a loaded grammar until the database changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.answers.grammars import GrammarAnswer, SequenceAnswer, WrittenSequence
from motiondb.answers.plain import extended
from motiondb.database.arguments import seeded
from motiondb.database.captures import Captures
from motiondb.database.generated_files import write_with_provenance
from motiondb.database.grammars import (
    grammar_editing,
    grammar_facts,
    grammar_learning,
    grammar_parsing,
    grammar_pictures,
    grammar_sequences,
    grammar_words,
)
from motiondb.database.grammars.grammar_learning import GrammarSettings, Progress
from motiondb.database.grammars.grammar_parsing import ParsedMotion
from motiondb.database.grammars.grammar_sequences import (
    Edit,
    GrammarSequence,
    Material,
    terminals_of,
)
from motiondb.database.learned_grammar import LearnedGrammar
from motiondb.errors import QueryError
from motiondb.grammar.cfg import prefix
from motiondb.grammar.derivation.complete import Completions
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.derivation.plan import Plan, plan
from motiondb.records import CaptureInfo, Motion
from motiondb.search.takings import Taking

if TYPE_CHECKING:
    from motiondb.database.session import Session


class Grammars:
    """The grammars of a database, available as ``db.grammars``.

    ``name`` is the name of a grammar; a QueryError is raised if there is no such grammar. ``path``
    of a picture is a file with the ending .png; the method returns it.

    Parameters
    ----------
    session : Session
        The open database.
    """

    def __init__(self, session: Session) -> None:
        self._session = session

    def material(self, name: str) -> Material:
        """Return a grammar with its takes, as far as their captures are in the database."""
        return self._session.kept(
            ("grammar", name), lambda: grammar_sequences.load_material(self._session.store, name)
        )

    def learn(
        self,
        captures: Iterable[str],
        name: str | None = None,
        settings: GrammarSettings | None = None,
        progress: Progress | None = None,
    ) -> tuple[LearnedGrammar, list[str]]:
        """Learn a grammar from captures, replacing a grammar of the same name.

        Parameters
        ----------
        captures : iterable of str
            Names of the captures.
        name : str, optional
            Name of the grammar. None takes the last part of the first capture's name.
        settings : GrammarSettings, optional
            Settings that decide what is learned.
        progress : callable, optional
            Called with the name of the step, the amount done and the total amount.

        Returns
        -------
        grammar : LearnedGrammar
            The grammar.
        lost : list of str
            Names of the generated captures that can no longer be edited, because the grammar that
            derived them was replaced.

        Raises
        ------
        QueryError
            When the captures, the name or a setting are not valid, or no grammar can be learned
            from the captures. Nothing is saved then.
        """
        return grammar_learning.learn_grammar(
            self._session.store, list(captures), name, settings or GrammarSettings(), progress
        )

    def names(self) -> list[str]:
        """Return the names of all grammars."""
        return store.load_grammar_names(self._session.store)

    def sizes(self) -> list[store.GrammarSize]:
        """Return the size of each grammar, ordered by name."""
        return store.load_grammar_sizes(self._session.store)

    def size(self, name: str) -> store.GrammarSize:
        """Return the size of a grammar."""
        name = self.load(name).name
        return next(size for size in self.sizes() if size.name == name)

    def load(self, name: str) -> LearnedGrammar:
        """Return a grammar with its terminals, sentences and parses."""
        return self.material(name).learned

    def remove(self, name: str) -> list[str]:
        """Remove a grammar; return the names of generated captures that can no longer be edited."""
        with store.transaction(self._session.store):
            run_id = store.start_run(self._session.store, "grammar remove", {"name": name})
            lost = store.remove_grammar(self._session.store, name)
            store.finish_run(self._session.store, run_id)
        return lost

    def edit_rules(self, name: str, text: str) -> list[str]:
        """Replace the rules of a grammar by edited ones.

        The terminals, their segments and the sentences stay. The edit can be taken back, see
        :meth:`undo_edit`. Rules that are the present ones are no edit.

        Parameters
        ----------
        name : str
            Name of the grammar.
        text : str
            All rules, as in ``show(name).text``.

        Returns
        -------
        list of str
            Names of the generated captures that can no longer be edited, because the new rules do
            not derive them.

        Raises
        ------
        QueryError
            When the rules cannot be read, use unknown terminals, or do not derive a sentence of the
            captures. Nothing is changed then.
        """
        return grammar_editing.edit_rules(self._session.store, self.load(name).name, text)

    def rename_terminal(self, name: str, terminal: str, to: str) -> list[str]:
        """Give a terminal another name, also in the rules and in saved sequences.

        Parameters
        ----------
        name : str
            Name of the grammar.
        terminal : str
            Present name of the terminal.
        to : str
            New name, of at most 60 letters (a-z, A-Z), digits, ``_``, ``'``, ``.`` and ``-``. It
            begins with a letter or ``_``.

        Returns
        -------
        list of str
            As for :meth:`edit_rules`; no name, as the strings stay the same.

        Raises
        ------
        QueryError
            When there is no such terminal, or the new name is not valid or taken.
        """
        database = self._session.store
        return grammar_editing.rename_terminal(database, self.load(name).name, terminal, to)

    def undo_edit(self, name: str) -> str:
        """Take the last edit of a grammar back; return what it had changed.

        Sequences that could no longer be edited can be edited again, but not those that were
        removed in between: these come back (``MotionDB.undo``) as captures without derivation.

        Parameters
        ----------
        name : str
            Name of the grammar.

        Raises
        ------
        QueryError
            When the grammar was not edited since it was learned.
        """
        return grammar_editing.undo_edit(self._session.store, self.load(name).name)

    def edits(self, name: str) -> tuple[str, ...]:
        """Return what the edits of a grammar changed that can be taken back, the last first."""
        runs = {run.run_id: run for run in store.load_runs(self._session.store)}
        return grammar_editing.edits_of(runs, self.load(name).run_id)

    def meanings(self, name: str) -> tuple[grammar_words.Meaning, ...]:
        """Return the meaning of each terminal; empty meanings if the database has not learned."""
        material = self.material(name)
        with self._session.reading():
            learned = self._session.learned if store.is_learned(self._session.store) else None
        return grammar_words.terminal_meanings(learned, material.learned, material.numbers)

    def show(self, name: str) -> GrammarAnswer:
        """Return the facts of a grammar, for printing or JSON; times in seconds."""
        return grammar_facts.grammar_facts(self.material(name), self.meanings(name))

    def draw_trees(self, name: str, path: str | Path) -> Path:
        """Draw the derivation trees of the grammar's sentences as PNG."""
        return grammar_pictures.draw_sentences(self.material(name), path)

    def draw_strings(self, name: str, path: str | Path) -> Path:
        """Draw the terminals with figures and words, and the captures as strings, as PNG."""
        return grammar_pictures.draw_strings(self.material(name), self.meanings(name), path)

    def draw_parse(self, name: str, parsed: ParsedMotion, path: str | Path) -> Path:
        """Draw the trees of a parsed motion as PNG."""
        return grammar_pictures.draw_parse(self.material(name), parsed.trees, path)

    def draw_edit(self, name: str, edited: Edit, path: str | Path) -> Path:
        """Draw a sequence and the alternatives of its region as trees, as PNG."""
        return grammar_pictures.draw_edit(self.material(name), edited, path)

    def draw_sequence(self, sequence: GrammarSequence, path: str | Path) -> Path:
        """Draw a sequence as a strip of figures over its terminals and sources, as PNG."""
        return grammar_pictures.draw_sequence(self.material(sequence.grammar), sequence, path)

    def parse(self, name: str, example: str | Path | Motion) -> ParsedMotion:
        """Return the sentences of a motion, stored or newly parsed.

        The sentences are the stored ones if the grammar was learned from the motion. Otherwise the
        motion is read, which assigns a terminal to every segment, even if the motion shows
        something else. ``unlike`` of the result gives the segments that are unlike everything from
        which the grammar was learned.

        Parameters
        ----------
        name : str
            Name of the grammar.
        example : str, Path or Motion
            Name of a capture, a motion file, or a motion.

        Raises
        ------
        QueryError
            When there is no such grammar or capture, or the motion is too short for a terminal.
        """
        with self._session.reading():
            material = self.material(name)
            take = grammar_parsing.take_of(material, example)
            if take is not None:
                return grammar_parsing.as_learned(material.learned, take)
            motion = Captures(self._session).motion(example)
            transcription = grammar_parsing.read(self._session, material, motion)
        return grammar_parsing.parse_transcription(material.learned.grammar, transcription)

    def suggest(
        self, name: str, beginning: str | Sequence[str] = ""
    ) -> tuple[tuple[str | None, float], ...]:
        """Return the terminals that may come next, with their probabilities; None is the end.

        Parameters
        ----------
        name : str
            Name of the grammar.
        beginning : str or sequence of str
            Terminals separated by spaces, or a sequence of terminals.

        Raises
        ------
        QueryError
            When there is no such grammar, or a name is not a terminal of it.
        ParseError
            When no sentence begins with these terminals.
        """
        grammar = self.load(name).grammar
        return prefix.suggest(grammar, terminals_of(grammar, beginning))

    def plan(
        self, name: str, beginning: str | Sequence[str], goal: str, shortest: bool = False
    ) -> Plan:
        """Return the most probable continuation of a beginning that reaches a terminal.

        Parameters
        ----------
        name : str
            Name of the grammar.
        beginning : str or sequence of str
            Terminals separated by spaces, or a sequence of terminals.
        goal : str
            The terminal to reach.
        shortest : bool
            Whether to return the shortest continuation instead.

        Raises
        ------
        QueryError
            When there is no such grammar, or a name is not a terminal of it.
        ParseError
            When no sentence begins with these terminals.
        GrammarError
            When no sentence leads from there to the goal.
        """
        grammar = self.load(name).grammar
        before, (wanted,) = terminals_of(grammar, beginning), terminals_of(grammar, [goal])
        return plan(grammar, before, wanted, shortest=shortest)

    def complete(self, name: str, like: str, n: int = 5, exact: bool = False) -> Completions:
        """Return the most probable sentences that match a pattern and that captures can show.

        Parameters
        ----------
        name : str
            Name of the grammar.
        like : str
            Terminals and words, ``?`` for any one terminal, ``...`` for any number of them; or a
            sentence in words, which may follow each other with anything between.
        n : int
            How many sentences.
        exact : bool
            Whether words that no caption holds are refused rather than taken as known ones.

        Raises
        ------
        QueryError
            When there is no such grammar, or the pattern is not valid.
        GrammarError
            When no sentence matches; with the first place of the pattern that none reaches.
        """
        return grammar_words.best_completions(self._session, self.material(name), like, n, exact)

    def generate(
        self,
        name: str,
        seed: int = 0,
        length: int | None = None,
        like: str | None = None,
        exact: bool = False,
    ) -> GrammarSequence:
        """Return a new sentence as motion; the same seed gives the same motion.

        Parameters
        ----------
        name : str
            Name of the grammar.
        seed : int
            Seed of the derivation.
        length : int, optional
            Wanted number of terminals. If no sentence has this length, the nearest possible one is
            used.
        like : str, optional
            A pattern that the sentence must match, see :meth:`complete`. The sentence is drawn from
            those that match, by their probabilities in the grammar.
        exact : bool
            As in :meth:`complete`.

        Raises
        ------
        QueryError
            When there is no such grammar, the length is below 1 or given beside a pattern, the
            pattern is not valid, or all captures that show one of the terminals were removed.
        GrammarError
            When no sentence matches the pattern.
        """
        if like is not None:
            return grammar_words.generate_completion(
                self._session, self.material(name), like, length, seed, exact
            )
        if length is not None and length < 1:
            raise QueryError(f"length: expected at least 1 terminal, found {length}. Ask for more.")
        material, rng = self.material(name), seeded(seed)
        return grammar_sequences.play(
            material, derive(material.learned.grammar, rng, length=length)
        )

    def edit(
        self,
        name: str,
        sequence: str | Sequence[str] | GrammarSequence,
        at: int,
        levels: tuple[int, int] = (0, 0),
        n: int = grammar_sequences.N_ALTERNATIVES,
        seed: int = 0,
    ) -> Edit:
        """Return alternatives for the region around a position of a sequence.

        Parameters
        ----------
        name : str
            Name of the grammar.
        sequence : str, sequence of str or GrammarSequence
            The name of a saved sequence, a string of terminals, or a generated sequence.
        at : int
            The picked position, from 0.
        levels : tuple of (int, int)
            Number of ancestors by which the region is widened, then of descendants by which it is
            narrowed.
        n : int
            Most alternatives.
        seed : int
            Seed of the search for alternatives.

        Raises
        ------
        QueryError
            When the capture does not exist, the sequence belongs to another grammar, a name is not
            a terminal, or the region lies outside the sequence.
        ParseError
            When the grammar does not derive the string.
        """
        return grammar_sequences.offer(self.material(name), sequence, at, levels, n, seed)

    def play(self, name: str, edited: Edit, number: int) -> GrammarSequence:
        """Return the sequence with alternative ``number`` (from 0) in its region, as motion."""
        return grammar_sequences.play_alternative(self.material(name), edited, number)

    def compare(self, name: str, seed: int = 0) -> tuple[grammar_facts.ComparedGrammar, ...]:
        """Compare a grammar with the finite state machine of its sentences."""
        return grammar_facts.compare(self.load(name), seed)

    def facts(self, sequence: GrammarSequence, seed: int = 0) -> SequenceAnswer:
        """Return how a sequence was generated, for JSON: string, tree, joins and sources.

        Parameters
        ----------
        sequence : GrammarSequence
            The sequence.
        seed : int
            The seed that the facts name.
        """
        return grammar_facts.sequence_facts(sequence, seed)

    def write(self, sequence: GrammarSequence, path: str | Path, seed: int = 0) -> WrittenSequence:
        """Write a sequence, and the origin of its frames to ``FILE.provenance.json``.

        Parameters
        ----------
        sequence : GrammarSequence
            The sequence.
        path : str or Path
            The file; its ending gives the format: .bvh, .glb or .gltf.
        seed : int
            The seed that the facts name.

        Returns
        -------
        WrittenSequence
            The facts, with the names of both files.

        Raises
        ------
        MotionDBError
            When the ending is another one, or a file cannot be written.
        """
        facts = self.facts(sequence, seed)
        files = write_with_provenance(sequence, facts, Path(path))
        return extended(
            WrittenSequence, facts, output=files["output"], provenance=files["provenance"]
        )

    def save(
        self,
        name: str,
        sequence: GrammarSequence,
        seed: int = 0,
        how: Mapping[str, object] | None = None,
    ) -> CaptureInfo:
        """Save a sequence as a generated capture with its derivation, so that it can be edited.

        Parameters
        ----------
        name : str
            Name of the new capture.
        sequence : GrammarSequence
            The sequence.
        seed : int
            The seed from which the sequence was generated.
        how : mapping of str to object, optional
            Further parameters that are saved with the run.

        Raises
        ------
        QueryError
            When the name is not valid, or a capture of this name exists.
        """
        material = self.material(sequence.grammar)
        return grammar_sequences.keep(material, sequence, name, seed, how or {})

    def taken_in_pattern(self, name: str, like: str) -> dict[str, Taking]:
        """Return what the words of a pattern are taken as that no caption holds.

        Parameters
        ----------
        name : str
            Name of the grammar.
        like : str
            The pattern, see ``complete``.
        """
        return grammar_words.taken_words(self._session, self.material(name), like)

    def strip(self, sequence: GrammarSequence) -> tuple[grammar_facts.StripTerminal, ...]:
        """Return the terminals of a sequence with their times and the segments that play them."""
        return grammar_facts.strip(self.material(sequence.grammar), sequence)

    def saved(self, name: str) -> list[str]:
        """Return the names of the saved sequences that a grammar derived."""
        opened = self._session.store
        with self._session.reading():
            infos = [i for i in store.load_captures(opened) if i.kind == "generated"]
            derived = [(i.name, store.load_derivation(opened, i.capture_id)) for i in infos]
        return [
            capture for capture, derivation in derived if derivation and derivation.grammar == name
        ]

    def chain(self, name: str, seconds: float, seed: int = 0) -> GrammarSequence:
        """Return sentences that follow one another, as motion of about a wanted duration.

        A take is a chain of sentences, and so is the result. Sentences are drawn one by one by
        their probabilities, whatever the sentence before. The segments are chosen for the whole
        chain, so that the cost of its joins is least.

        Parameters
        ----------
        name : str
            Name of the grammar.
        seconds : float
            Wanted duration. The number of sentences is the one whose mean duration is nearest.
        seed : int
            Seed of the derivations; the same seed gives the same motion.

        Raises
        ------
        QueryError
            When there is no such grammar, the duration is not above 0 or too long, or all captures
            that show one of the terminals were removed.
        """
        return grammar_sequences.chain(self.material(name), seconds, seed)

    def open(self, name: str) -> GrammarSequence:
        """Return a saved sequence, assembled again from its segments.

        Parameters
        ----------
        name : str
            Name of the capture.

        Raises
        ------
        QueryError
            When there is no such capture, it has no derivation by a grammar of the database, or a
            capture that plays one of its terminals was removed.
        """
        with self._session.reading():
            _, derivation = grammar_sequences.load_sequence(self._session.store, name)
            material = self.material(derivation.grammar)
            return grammar_sequences.play_saved(material, name)
