"""The verbs of grammars: ``db.grammars.learn``, ``show``, ``parse``, ``generate``, ...

The session keeps a loaded grammar until the database changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, pictures, store
from motiondb.database.catalogue.parts import cut_motion, load_example
from motiondb.database.generated_files import source_spans, sources_of, write_with_provenance
from motiondb.database.grammars import (
    grammar_asking,
    grammar_editing,
    grammar_facts,
    grammar_learning,
    grammar_sequences,
    grammar_words,
)
from motiondb.database.grammars.grammar_facts import ParsedMotion
from motiondb.database.grammars.grammar_learning import GrammarSettings, Progress
from motiondb.database.grammars.grammar_sequences import Edit, GrammarSequence, Material
from motiondb.database.loading import LearnedGrammar
from motiondb.database.session import Topic
from motiondb.database.values import listed, seeded
from motiondb.errors import QueryError
from motiondb.grammar.cfg import parse as parsing
from motiondb.grammar.cfg.context_free import GrammarError, Tree, derive_by
from motiondb.grammar.cfg.loops import with_loops, with_loops_around
from motiondb.grammar.derivation.complete import Completions, complete, sample_completions
from motiondb.grammar.derivation.derive import derive, draw_chain
from motiondb.grammar.derivation.edit import alternatives, narrower, region_at, wider
from motiondb.grammar.derivation.plan import Plan, plan
from motiondb.learn.learned import Learned
from motiondb.records import MOTION_FPS, CaptureInfo, Motion
from motiondb.search.takings import Taking

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FORESEES = 0.65  # Right of two of a grammar whose probabilities are trusted to judge an order
SHOWN_TREES = 12  # Most trees in a picture of the sentences


class Grammars(Topic):
    """The grammars of a database, available as ``db.grammars``.

    ``name`` is the name of a grammar; a QueryError is raised if there is no such grammar. Strings
    of terminals are texts with spaces between them, or sequences of terminals; a QueryError is
    raised for a name that is not a terminal, and a ParseError for a string that the grammar does
    not derive. The same ``seed`` gives the same result. ``exact`` refuses words that no caption
    holds, which are otherwise taken as known ones. ``path`` of a picture is a file with the ending
    .png; the method returns it.
    """

    def material(self, name: str) -> Material:
        """Return a grammar with its takes, as far as their captures are in the database."""
        return self.session.kept(
            ("grammar", name), lambda: grammar_sequences.load_material(self.store, name)
        )

    def learn(
        self,
        captures: Iterable[str],
        name: str | None = None,
        settings: GrammarSettings | None = None,
        progress: Progress | None = None,
    ) -> tuple[LearnedGrammar, list[str]]:
        """Learn a grammar from captures, replacing a grammar of the same name.

        Also returns the names of the generated captures that can no longer be edited, because the
        grammar that derived them was replaced.

        Parameters
        ----------
        name : str, optional
            Name of the grammar. None takes the last part of the first capture's name.
        settings : GrammarSettings, optional
            Settings that decide what is learned.
        progress : callable, optional
            Called with the name of the step, the amount done and the total amount.

        Raises
        ------
        QueryError
            When the captures, the name or a setting are not valid, or no grammar can be learned
            from the captures. Nothing is saved then.
        """
        names, settings = listed("captures", captures), settings or GrammarSettings()
        return grammar_learning.learn_grammar(self.store, names, name, settings, progress)

    def names(self) -> list[str]:
        """Return the names of all grammars."""
        return store.load_grammar_names(self.store)

    def sizes(self) -> list[store.GrammarSize]:
        """Return the size of each grammar, ordered by name."""
        return store.load_grammar_sizes(self.store)

    def size(self, name: str) -> store.GrammarSize:
        """Return the size of a grammar."""
        name = self.load(name).name
        return next(size for size in self.sizes() if size.name == name)

    def load(self, name: str) -> LearnedGrammar:
        """Return a grammar with its terminals, sentences and parses."""
        return self.material(name).learned

    def remove(self, name: str) -> list[str]:
        """Remove a grammar; return the names of generated captures that can no longer be edited."""
        with store.running(self.store, "grammar remove", {"name": name}):
            return store.remove_grammar(self.store, name)

    def edit_rules(self, name: str, text: str) -> list[str]:
        """Replace the rules of a grammar by edited ones, a text as ``show(name).text``.

        The terminals, their segments and the sentences stay. Returns the names of the generated
        captures that can no longer be edited, because the new rules do not derive them. The edit
        can be taken back (:meth:`undo_edit`). Rules that are the present ones are no edit.

        Raises
        ------
        QueryError
            When the rules cannot be read, use unknown terminals, or do not derive a sentence of the
            captures. Nothing is changed then.
        """
        return grammar_editing.edit_rules(self.store, self.load(name).name, text)

    def rename_terminal(self, name: str, terminal: str, to: str) -> list[str]:
        """Give a terminal another name, also in the rules and in saved sequences.

        The new name has at most 60 letters (a-z, A-Z), digits, ``_``, ``'``, ``.`` and ``-``, and
        begins with a letter or ``_``. Returns what :meth:`edit_rules` does: no name, as the strings
        stay the same.
        """
        database = self.store
        return grammar_editing.rename_terminal(database, self.load(name).name, terminal, to)

    def undo_edit(self, name: str) -> str:
        """Take the last edit of a grammar back; return what it had changed.

        Sequences that could no longer be edited can be edited again, but not those that were
        removed in between: these come back (``MotionDB.undo``) as captures without derivation.
        QueryError is raised if the grammar was not edited since it was learned.
        """
        return grammar_editing.undo_edit(self.store, self.load(name).name)

    def edits(self, name: str) -> tuple[str, ...]:
        """Return what the edits of a grammar changed that can be taken back, the last first."""
        runs = {run.run_id: run for run in store.load_runs(self.store)}
        return grammar_editing.edits_of(runs, self.load(name).run_id)

    def questions(self, name: str, n: int = 10) -> list[answers.GrammarQuestion]:
        """Return questions to a person: whether a terminal can come straight after another.

        The first ones say most about unseen captures. Those that were answered are left out.
        """
        learned = self.load(name)
        known = grammar_asking.load_answers(self.store, learned.name)
        words = {t: m.text for t, m in zip(learned.terminals.names, self.meanings(name))}
        return grammar_asking.questions(learned, known, n, words)

    def answer(self, name: str, first: str, then: str, said: str, author: str) -> bool:
        """Keep an answer ("yes", "no", "unknown"); the next :meth:`learn` of ``name`` keeps to it.

        Returns False where rules cannot: the captures show a pair that is answered with "no".
        QueryError is raised for an unknown terminal, another answer, or an author without a name.
        """
        learned = self.load(name)
        return grammar_asking.save_answer(self.store, learned, (first, then), said, author)

    def draw_questions(
        self,
        name: str,
        asked: Sequence[answers.GrammarQuestion],
        path: str | Path | None = None,
    ) -> Path | Figure:
        """Draw the terminals of each question: strips of figures as PNG, or moving as GIF.

        In a GIF the second terminal comes straight after the first. Questions of removed captures
        are left out.
        """
        material = self.material(name)
        if path is not None and Path(path).suffix.lower() == ".gif":
            return grammar_asking.animate(material, asked, path)
        takes = {source.name: take for take, source in enumerate(material.learned.sources)}
        cards: list[pictures.TerminalCard] = []
        for number, one in enumerate(asked, start=1):
            for shown, text in (
                (one.first_shown, f"{number}: first {one.first} {one.first_words}".strip()),
                (one.then_shown, f"{number}: then {one.then} {one.then_words}".strip() + "?"),
            ):
                motion = material.motions.get(takes[shown.capture])
                if motion is not None:
                    part = cut_motion(motion, shown.start, shown.end)
                    cards.append(pictures.TerminalCard(text, shown.capture, len(cards), part))
        return pictures.save_png(pictures.strings_figure(cards, [], name), path)

    def meanings(self, name: str) -> tuple[grammar_words.Meaning, ...]:
        """Return the meaning of each terminal; empty meanings if the database has not learned."""
        material = self.material(name)
        return grammar_words.terminal_meanings(self._learned(), material.learned, material.numbers)

    def _learned(self) -> Learned | None:
        with self.session.reading():
            return self.session.learned if store.is_learned(self.store) else None

    def show(self, name: str) -> answers.GrammarAnswer:
        """Return the facts of a grammar, for printing or JSON; times in seconds."""
        return grammar_facts.grammar_facts(self.material(name), self.meanings(name))

    def draw_trees(self, name: str, path: str | Path | None = None) -> Path | Figure:
        """Draw the trees of the sentences: each different one once, the most frequent first."""
        learned = self.load(name)
        counts: dict[tuple[int, ...], list[int]] = {}
        for number, rules in enumerate(learned.parses, start=1):
            counts.setdefault(rules, []).append(number)
        order = sorted(counts.items(), key=lambda pair: (-len(pair[1]), pair[1][0]))
        trees = [
            pictures.TreePicture(_caption(numbers), with_loops(derive_by(learned.grammar, rules)))
            for rules, numbers in order[:SHOWN_TREES]
        ]
        n, kinds = len(learned.sentences), len(order)
        title = f"{learned.name}: {n} sentence{'s' * (n != 1)}, "
        title += f"{kinds} different tree{'s' * (kinds != 1)}"
        if len(order) > SHOWN_TREES:
            title += f", {SHOWN_TREES} of them here"
        return pictures.save_png(pictures.trees_figure(trees, title, learned.tints), path)

    def draw_strings(self, name: str, path: str | Path | None = None) -> Path | Figure:
        """Draw the terminals with figures and words, and the captures as strings, as PNG.

        A terminal is left out above the strings if the capture of its medoid was removed.
        """
        material, meanings = self.material(name), self.meanings(name)
        learned, terminals = material.learned, material.learned.terminals
        starts, ends = terminals.starts / MOTION_FPS, terminals.ends / MOTION_FPS
        cards, bars = [], []
        for k, (terminal, meaning) in enumerate(zip(terminals.names, meanings)):
            clip = int(terminals.medoids[k])
            motion = material.motions.get(int(terminals.takes[clip]))
            if motion is not None:
                count = int((terminals.labels == k).sum())
                text = f"{meaning.text}  {count}x" if meaning.text else f"{count}x"
                part = cut_motion(motion, starts[clip], ends[clip])
                cards.append(pictures.TerminalCard(terminal, text, k, part))
        for take, source in enumerate(learned.sources):
            rows = np.flatnonzero(terminals.takes == take)
            spans = [
                (starts[r], ends[r], terminals.names[terminals.labels[r]], int(terminals.labels[r]))
                for r in rows
            ]
            sentences = [
                (starts[a], ends[b - 1], str(number), 11 if number % 2 else 6)
                for number, (a, b) in enumerate(learned.sentences.tolist(), start=1)
                if rows[0] <= a <= rows[-1]
            ]
            lines = [
                pictures.Timeline("terminals", spans),
                pictures.Timeline("sentences", sentences),
            ]
            bars.append(pictures.StringBar(source.name, source.n_frames / MOTION_FPS, lines))
        return pictures.save_png(pictures.strings_figure(cards, bars, learned.name), path)

    def draw_parse(
        self, name: str, parsed: ParsedMotion, path: str | Path | None = None
    ) -> Path | Figure:
        """Draw the trees of a parsed motion, at least one, as PNG."""
        learned = self.load(name)
        trees = [
            pictures.TreePicture(f"sentence {n}", with_loops(tree))
            for n, tree in enumerate(parsed.trees, start=1)
        ]
        return pictures.save_png(pictures.trees_figure(trees, learned.name, learned.tints), path)

    def draw_edit(self, name: str, edited: Edit, path: str | Path | None = None) -> Path | Figure:
        """Draw a sequence and the alternatives of its region, which is marked, as trees."""
        learned, region = self.load(name), edited.region
        numbers = range(len(edited.alternatives))
        drawn = {"as it is": edited.before, **{str(n + 1): edited.tree(n) for n in numbers}}
        trees = [
            pictures.TreePicture(caption, *with_loops_around(tree, region.path))
            for caption, tree in drawn.items()
        ]
        title = f"{learned.name}: what {region.symbol} may derive"
        return pictures.save_png(pictures.trees_figure(trees, title, learned.tints), path)

    def draw_sequence(
        self, sequence: GrammarSequence, path: str | Path | None = None
    ) -> Path | Figure:
        """Draw a sequence as a strip of figures over its terminals and sources, as PNG."""
        tints = self.load(sequence.grammar).tints
        spans = [
            (a / MOTION_FPS, b / MOTION_FPS, terminal, tints[terminal])
            for terminal, (a, b) in zip(sequence.string, sequence.made.spans)
        ]
        lines = [
            pictures.Timeline("terminals", spans),
            pictures.Timeline("sources", source_spans(sequence)),
        ]
        title = f"{sequence.grammar}: {' '.join(sequence.string)}"
        return pictures.save_png(pictures.strip_figure(sequence.motion, title, lines), path)

    def parse(self, name: str, example: str | Path | Motion) -> ParsedMotion:
        """Return the sentences of a capture, a motion file or a motion, stored or newly parsed.

        The sentences are the stored ones if the grammar was learned from the motion. Otherwise the
        motion is read, which assigns a terminal to every segment, even if the motion shows
        something else. ``unlike`` of the result gives the segments that are unlike everything from
        which the grammar was learned. QueryError is raised also if the motion is too short for a
        terminal.
        """
        with self.session.reading():
            material = self.material(name)
            take = grammar_facts.take_of(material, example)
            if take is not None:
                return grammar_facts.as_learned(material.learned, take)
            motion = load_example(self.session, example)
            transcription = grammar_facts.read(self.session, material, motion)
            model = grammar_facts.model_of(self.session, material)
            judged = grammar_facts.foresight_of(grammar_facts.run_of(material))
        foresees = judged is not None and judged.right_of_two >= FORESEES
        grammar = material.learned.grammar
        return grammar_facts.parse_transcription(grammar, transcription, model, foresees)

    def suggest(
        self, name: str, beginning: str | Sequence[str] = ""
    ) -> tuple[tuple[str | None, float], ...]:
        """Return the terminals that may come next, with their probabilities; None is the end."""
        grammar = self.load(name).grammar
        return parsing.suggest(grammar, grammar_sequences.terminals_of(grammar, beginning))

    def plan(
        self, name: str, beginning: str | Sequence[str], goal: str, shortest: bool = False
    ) -> Plan:
        """Return the most probable, or shortest, continuation of a beginning to a terminal.

        GrammarError is raised if no sentence leads there.
        """
        grammar = self.load(name).grammar
        before, (wanted,) = (
            grammar_sequences.terminals_of(grammar, beginning),
            grammar_sequences.terminals_of(grammar, [goal]),
        )
        return plan(grammar, before, wanted, shortest=shortest)

    def complete(self, name: str, like: str, n: int = 5, exact: bool = False) -> Completions:
        """Return the ``n`` most probable sentences that match a pattern and that captures can show.

        Parameters
        ----------
        like : str
            Terminals and words, ``?`` for any one terminal, ``...`` for any number of them; or a
            sentence in words, which may follow each other with anything between.

        Raises
        ------
        GrammarError
            When no sentence matches; with the first place of the pattern that none reaches.
        """
        if n < 1:
            raise QueryError(f"number: expected 1 sentence or more, found {n}. Ask for more.")
        material = self.material(name)
        pattern = grammar_words.pattern_of(material, self._learned(), like, exact)
        allowed = grammar_words.playable(material)
        return complete(material.learned.grammar, pattern, n, allowed=allowed)

    def generate(
        self,
        name: str,
        seed: int = 0,
        length: int | None = None,
        like: str | None = None,
        exact: bool = False,
    ) -> GrammarSequence:
        """Return a sentence as motion; a new one, where one of some draws is new.

        A sentence that no take has is preferred, where one of 20 draws is new, and a motion from
        several places of the takes to a replay of one (:meth:`facts` says which).

        Parameters
        ----------
        length : int, optional
            Wanted number of terminals. If no sentence has this length, the nearest possible one is
            used.
        like : str, optional
            A pattern that the sentence must match, see :meth:`complete`. The sentence is drawn from
            those that match, by their probabilities in the grammar.

        Raises
        ------
        QueryError
            Also when the length is below 1 or given beside a pattern, or all captures that show one
            of the terminals were removed.
        """
        if like is not None and length is not None:
            raise QueryError(
                f"length: expected none with a pattern, found {length}. Write the number of "
                "terminals as positions: '? ? ?'."
            )
        if length is not None and length < 1:
            raise QueryError(f"length: expected at least 1 terminal, found {length}. Ask for more.")
        material = self.material(name)
        grammar = material.learned.grammar
        rng = seeded(seed)
        if like is None:
            drawn: Iterator[Tree] = (derive(grammar, rng, length=length) for _ in count())
        else:
            pattern = grammar_words.pattern_of(material, self._learned(), like, exact)
            allowed = grammar_words.playable(material)
            drawn = sample_completions(grammar, pattern, rng, allowed=allowed)
        return grammar_sequences.play(material, grammar_sequences.new_or_first(material, drawn))

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
        sequence : str, sequence of str or GrammarSequence
            The name of a saved sequence, a string of terminals, or a generated sequence.
        at : int
            The picked position, from 0.
        levels : tuple of (int, int)
            Number of ancestors by which the region is widened, then of descendants by which it is
            narrowed.
        n : int
            Most alternatives.
        """
        material = self.material(name)
        tree, clips = grammar_sequences.before(material, sequence)
        try:
            region = region_at(tree, at)
            region = wider(tree, region, levels[0])
            region = narrower(tree, region, levels[1])
        except GrammarError as error:  # the region was asked for by the user
            raise QueryError(str(error)) from None
        rng = seeded(seed)
        return Edit(
            tree, clips, region, alternatives(material.learned.grammar, tree, region, n, rng)
        )

    def play(self, name: str, edited: Edit, number: int) -> GrammarSequence:
        """Return the sequence with alternative ``number`` (from 0) in its region, as motion."""
        material, tree, pinned = self.material(name), edited.tree(number), edited.pinned(number)
        if gone := grammar_sequences.gone(material, pinned.values()):
            raise QueryError(
                f"{' '.join(edited.before.leaves())}: expected the captures that play what is not"
                f" edited, found {', '.join(gone)} removed. Add them again, or edit the string "
                f"instead of the sequence: then all of it is assembled again."
            )
        return grammar_sequences.play(material, tree, pinned)

    def compare(self, name: str, seed: int = 0) -> tuple[grammar_facts.ComparedGrammar, ...]:
        """Compare a grammar with the finite state machine of its sentences."""
        return grammar_facts.compare(self.load(name), seed)

    def facts(self, sequence: GrammarSequence, seed: int = 0) -> answers.SequenceAnswer:
        """Return how a sequence was generated, for JSON.

        String, tree, whether it is new or a replay, costs of the joins, foot slip (m/s), the time
        of each terminal (seconds) and the sources of the frames.
        """
        made, known = sequence.made, frozenset(self.load(sequence.grammar).strings)
        new = sum(tree.leaves() not in known for tree in sequence.trees)
        return answers.extended(
            answers.SequenceAnswer,
            sequence,
            seed=seed,
            tree=" ".join(map(str, sequence.trees)),
            sentences=len(sequence.trees),
            new_sentences=new,
            changes=len(made.stretches) - 1,
            longest_stretch=round(max(made.stretches) / MOTION_FPS, 3),
            says=grammar_facts.say_new(new, len(sequence.trees), made.stretches),
            seconds=round(sequence.motion.n_frames / MOTION_FPS, 3),
            join_cost=float(sequence.choice.cost),
            foot_slip=float(made.slip),
            foot_slip_of_sources=float(made.source_slip),
            spans=tuple(
                answers.TerminalSpan(terminal, float(a) / MOTION_FPS, float(b) / MOTION_FPS)
                for terminal, (a, b) in zip(sequence.string, made.spans)
            ),
            sources=sources_of(sequence.provenance),
        )

    def write(
        self, sequence: GrammarSequence, path: str | Path, seed: int = 0
    ) -> answers.WrittenSequence:
        """Write a sequence (.bvh, .glb or .gltf), and beside it ``FILE.provenance.json``."""
        facts = self.facts(sequence, seed)
        files = write_with_provenance(sequence, facts, Path(path))
        return answers.extended(
            answers.WrittenSequence, facts, output=files["output"], provenance=files["provenance"]
        )

    def save(
        self,
        name: str,
        sequence: GrammarSequence,
        seed: int = 0,
        how: Mapping[str, object] | None = None,
    ) -> CaptureInfo:
        """Save a sequence as a generated capture with its derivation, so that it can be edited.

        ``name`` is that of the new capture, ``seed`` the one of the sequence, and ``how`` holds
        further parameters that are saved with the run.
        """
        material = self.material(sequence.grammar)
        return grammar_sequences.keep(material, sequence, name, seed, how or {})

    def taken_in_pattern(self, name: str, like: str) -> dict[str, Taking]:
        """Return what the words of a pattern are taken as that no caption holds."""
        material, learned = self.material(name), self._learned()
        if learned is None:
            return {}
        return grammar_words.takings(material, learned, grammar_words.tokens_of(like))

    def strip(self, sequence: GrammarSequence) -> tuple[grammar_facts.StripTerminal, ...]:
        """Return the terminals of a sequence with their times and the segments that play them."""
        return grammar_facts.strip(self.material(sequence.grammar), sequence)

    def saved(self, name: str) -> list[str]:
        """Return the names of the saved sequences that a grammar derived."""
        opened = self.store
        with self.session.reading():
            infos = [i for i in store.load_captures(opened) if i.kind == "generated"]
            derived = [(i.name, store.load_derivation(opened, i.capture_id)) for i in infos]
        return [
            capture for capture, derivation in derived if derivation and derivation.grammar == name
        ]

    def chain(self, name: str, seconds: float, seed: int = 0) -> GrammarSequence:
        """Return sentences that follow one another, as motion of about a wanted duration.

        A take is a chain of sentences, and so is the result. Sentences are drawn one by one by
        their probabilities, whatever the sentence before; their number is the one whose mean
        duration is nearest. The segments are chosen for the whole chain, so that the cost of its
        joins is least. QueryError is raised also for a duration that is not above 0 or too long.
        """
        material, rng = self.material(name), seeded(seed)
        terminals, longest = material.learned.terminals, grammar_sequences.LONGEST_CHAIN
        lengths = (terminals.ends - terminals.starts) / MOTION_FPS
        if not 0.0 < seconds <= longest:
            raise QueryError(
                f"seconds: expected more than 0 and at most {longest:g}, found {seconds:g}."
            )
        of_each = {
            terminal: float(lengths[terminals.labels == k].mean())
            for k, terminal in enumerate(terminals.names)
        }
        drawn = draw_chain(material.learned.grammar, of_each, seconds, rng)
        return grammar_sequences.play(material, drawn)

    def open(self, name: str) -> GrammarSequence:
        """Return a saved sequence, assembled again from its segments.

        QueryError is raised if no capture has this name, it has no derivation by a grammar of the
        database, or a capture that plays one of its terminals was removed.
        """
        with self.session.reading():
            tree, derivation = grammar_sequences.load_sequence(self.store, name)
            material = self.material(derivation.grammar)
            if gone := grammar_sequences.gone(material, derivation.clips):
                raise QueryError(
                    f"{name}: expected the captures that play it, found {', '.join(gone)} removed."
                    " Add them again."
                )
            return grammar_sequences.play(material, tree, dict(enumerate(derivation.clips)))


def _caption(numbers: Sequence[int]) -> str:
    """The caption of a tree from the numbers of its sentences."""
    shown = ", ".join(map(str, numbers[:6])) + (", ..." if len(numbers) > 6 else "")
    return f"sentence{'s' if len(numbers) > 1 else ''} {shown}"
