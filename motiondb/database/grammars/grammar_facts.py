"""Facts of a grammar and of the sequences that it generates, for printing, JSON and files.

A sequence is also shown as a strip of terminals, as a tree, and as the path of its root on the
ground. A grammar is compared with the finite state machine of its sentences, which stores which
terminal follows which.

Source of the strip and of the machine: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic
Structures from Human Motion Data", Computer Graphics Forum 30 (2011), figure 4 and section 7.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from motiondb import answers, store
from motiondb.database.grammars import grammar_asking
from motiondb.database.grammars.grammar_editing import EDIT, FORESIGHT, UNDONE
from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material, shown_at
from motiondb.database.grammars.grammar_words import Meaning
from motiondb.database.loading import LearnedGrammar
from motiondb.database.session import Session
from motiondb.database.values import seeded
from motiondb.files import packed_files
from motiondb.files.formats import read_file
from motiondb.files.limits import ReadOptions
from motiondb.files.safe_files import is_file
from motiondb.grammar import foresight, languages
from motiondb.grammar.cfg import context_free
from motiondb.grammar.cfg.context_free import Grammar, Tree
from motiondb.grammar.cfg.loops import format_loops
from motiondb.grammar.cfg.parse import ParseError, parse_passage
from motiondb.grammar.foresight import Foresight, Model
from motiondb.grammar.induction.induction import induce_quickly
from motiondb.grammar.rules.description_length import description_length
from motiondb.grammar.sentences.doubtful import find_doubtful
from motiondb.grammar.terminals.labelling import Reader, Transcription, make_reader, read_string
from motiondb.records import MOTION_FPS, FloatArray, Motion, Run
from motiondb.tabled import Tabled

_NOT_SETTINGS = ("name", "captures", EDIT, UNDONE, FORESIGHT)  # Other parameters of a run
N_STRINGS = 500  # Number of strings that are derived at random from each compared grammar
FOLDS = 5  # Most parts of the sentences in the cross-validation
LIMIT = 10_000  # Largest language whose strings are counted

PATH_STEP = 3  # Frames from one point of a path to the next: ten points a second


def grammar_facts(material: Material, meanings: Sequence[Meaning]) -> answers.GrammarAnswer:
    """Return the facts of a grammar."""
    learned = material.learned
    run = run_of(material)
    grammar = learned.grammar
    lengths = [len(string) for string in learned.strings]
    return answers.GrammarAnswer(
        grammar=learned.name,
        run=learned.run_id,
        seed=run.seed,
        settings={k: v for k, v in run.parameters.items() if k not in _NOT_SETTINGS},
        captures=tuple(
            answers.LearnedTake(
                source.name,
                source.sha256,
                round(source.n_frames / MOTION_FPS, 3),
                take in material.numbers,
            )
            for take, source in enumerate(learned.sources)
        ),
        frames=sum(source.n_frames for source in learned.sources),
        segments=len(learned.terminals.takes),
        terminals=terminal_rows(learned, meanings),
        objective=None if np.isnan(learned.terminals.objective) else learned.terminals.objective,
        sentences=len(learned.sentences),
        sentence_lengths=(min(lengths), float(np.mean(lengths)), max(lengths)),
        nonterminals=len(grammar.nonterminals),
        rules=len(grammar.rules),
        derives_new=derives_new(grammar, learned.strings),
        doubtful=_doubtful_sentences(learned),
        left_out=_left_out(learned),
        foresight=(judged := foresight_of(run)),
        foresight_says=judged.says if judged else CANNOT_SAY,
        bits={**learned.bits, "sum": sum(learned.bits.values())},
        text=context_free.format_grammar(grammar),
        text_with_loops=format_loops(grammar),
    )


def _doubtful_sentences(learned: LearnedGrammar) -> tuple[answers.DoubtfulSentence, ...]:
    """The sentences that look like errors."""
    rows = []
    for one in find_doubtful(learned.grammar, learned.strings, learned.parses):
        first, end = learned.sentences[one.sentence].tolist()
        string = learned.string(first, end)
        if one.found and one.expected:
            fault = f"symbol {one.position}, {one.found}, where {one.expected} is expected"
        elif one.found:
            fault = f"symbol {one.position}, {one.found}, where none is expected"
        else:
            fault = f"no {one.expected} before symbol {one.position}"
        at = shown_at(learned, first, end)
        says = (
            f"sentence {one.sentence + 1} ({at.capture} {at.start:.2f}-{at.end:.2f} s) looks like"
            f" an error: {' '.join(string)}: {fault}"
        )
        rows.append(answers.DoubtfulSentence(at, string, one.instead, says))
    return tuple(rows)


def _left_out(learned: LearnedGrammar) -> tuple[answers.Medoid, ...]:
    """The segments that belong to no sentence."""
    takes = learned.terminals.takes
    edges = [0, *learned.sentences.ravel().tolist(), len(takes)]
    begins = (np.flatnonzero(np.diff(takes)) + 1).tolist()  # of the takes but the first
    return tuple(
        shown_at(learned, first, end)
        for low, high in zip(edges[::2], edges[1::2], strict=True)
        for first, end in pairwise((low, *(n for n in begins if low < n < high), high))
        if first < end
    )


def run_of(material: Material) -> Run:
    """The run that learned or edited a grammar."""
    return store.load_run(material.database, material.learned.run_id)


CANNOT_SAY = (
    "cannot say: too few takes, or the rules were edited. Foresight needs two captures or more"
    f" with {foresight.FEWEST_WINDOWS} windows of {foresight.WIDTH} terminals."
)


def foresight_of(run: Run) -> Foresight | None:
    """The foresight that was measured in the run that learned a grammar, if any."""
    told = cast("dict[str, Any] | None", run.parameters.get(FORESIGHT))
    return Foresight(**told) if told else None


def grammar_row(size: store.GrammarSize) -> answers.GrammarRow:
    """Return the size of a grammar, for JSON."""
    return answers.extended(
        answers.GrammarRow,
        size,
        grammar=size.name,
        run=size.run_id,
        bits=size.bits | {"sum": sum(size.bits.values())},
        seconds=round(size.seconds, 3),
    )


def derives_new(grammar: context_free.Grammar, sentences: Sequence[tuple[str, ...]]) -> bool:
    """Whether a grammar derives a string that is not among the sentences.

    If it does not, the grammar only lists the sentences, and every new sequence repeats one of
    them.

    >>> derives_new(context_free.read_grammar("S -> a | b b"), [("a",), ("b", "b")])
    False
    """
    known = frozenset(sentences)
    language = languages.finite_language(grammar, len(known))
    return language is None or not language <= known


def terminal_rows(
    learned: LearnedGrammar, meanings: Sequence[Meaning]
) -> tuple[answers.TerminalRow, ...]:
    """Return the facts of each terminal."""
    terminals = learned.terminals
    rows = []
    for k, (name, meaning) in enumerate(zip(terminals.names, meanings)):
        members = terminals.labels == k
        medoid = int(terminals.medoids[k])
        length = float((terminals.ends - terminals.starts)[members].mean()) / MOTION_FPS
        rows.append(
            answers.TerminalRow(
                name,
                int(members.sum()),
                round(length, 3),
                tuple(answers.DescribedWord(w, p) for w, p in meaning.words),
                tuple(answers.TerminalSymbol(s, p) for s, p in meaning.symbols),
                shown_at(learned, medoid),
            )
        )
    return tuple(rows)


@dataclass(frozen=True)
class ComparedGrammar:
    """A grammar with the measures by which it is compared."""

    kind: str  # Name of the method by which the grammar was learned
    nonterminals: int
    rules: int
    bits: float  # Description length in bits: the rules, and the sentences given the rules
    # Number of different strings that the grammar derives. None if there are more than ``LIMIT``,
    # or infinitely many
    strings: int | None
    # Share of the sentences that are derived by a grammar of this kind learned from the other
    # parts, by cross-validation with at most ``FOLDS`` parts. None if there is only one sentence
    held_out: float | None
    new: float  # Share of the strings derived at random that are not among the sentences
    # Share of the strings derived at random that the learned grammar does not derive
    outside: float
    mean_length: float  # Mean length of the strings derived at random, in terminals
    # How a grammar of this kind, learned from the other takes, judges held-out ones. None if there
    # are too few takes
    foresight: Foresight | None


def compare(learned: LearnedGrammar, seed: int = 0) -> tuple[ComparedGrammar, ...]:
    """Compare a learned grammar with the finite state machine of its sentences."""
    sentences = learned.strings
    machine = languages.finite_state_grammar(sentences)
    kinds: tuple[tuple[str, Grammar, Callable[[list[tuple[str, ...]]], Grammar]], ...] = (
        ("learned", learned.grammar, induce_quickly),
        ("finite state machine", machine, languages.finite_state_grammar),
    )
    folds, rows = min(FOLDS, len(sentences)), []
    for kind, grammar, learn in kinds:
        rng = seeded(seed)
        used = Grammar(grammar.start, grammar.rules)  # bits count the terminals that rules use
        language = languages.finite_language(grammar, LIMIT)
        strings = languages.derived_strings(grammar, rng, N_STRINGS)
        row = ComparedGrammar(
            kind,
            len(grammar.nonterminals),
            len(grammar.rules),
            description_length(used, sentences).total,
            None if language is None else len(language),
            languages.held_out_coverage(learn, sentences, rng, folds=folds) if folds > 1 else None,
            sum(string not in sentences for string in strings) / len(strings),
            1.0 - languages.coverage(learned.grammar, strings),
            float(np.mean([len(string) for string in strings])),
            foresight.foresee(learn, learned.takes, seeded(seed)),
        )
        rows.append(row)
    return tuple(rows)


@dataclass(frozen=True)
class StripTerminal:
    """A terminal of a sequence, and its segment."""

    terminal: str
    nonterminal: str  # The nonterminal that generates it
    start: float  # Seconds of the sequence
    end: float  # Seconds of the sequence
    capture: str  # Name of the capture whose segment plays it
    source_start: float  # Start of the segment in the capture, seconds
    source_end: float  # End of the segment, seconds


@dataclass(frozen=True)
class TreeNode:
    """A node of a derivation, in preorder."""

    symbol: str
    parent: int  # Number of its parent, -1 for the root
    start: int  # Its first position in the string
    end: int  # The position after its last one
    is_terminal: bool  # Whether it is a terminal


def strip(material: Material, sequence: GrammarSequence) -> tuple[StripTerminal, ...]:
    """Return the terminals of a sequence in order."""
    terminals, sources = material.learned.terminals, material.learned.sources
    nodes = tree_nodes(sequence.tree)
    above = [nodes[node.parent].symbol for node in nodes if node.is_terminal]
    rows = zip(sequence.string, above, sequence.made.spans, sequence.choice.clips, strict=True)
    return tuple(
        StripTerminal(
            name,
            nonterminal,
            round(start / MOTION_FPS, 3),
            round(end / MOTION_FPS, 3),
            sources[int(terminals.takes[clip])].name,
            round(float(terminals.starts[clip]) / MOTION_FPS, 3),
            round(float(terminals.ends[clip]) / MOTION_FPS, 3),
        )
        for name, nonterminal, (start, end), clip in rows
    )


def say_new(new: int, sentences: int, stretches: Sequence[int]) -> str:
    """Say how many sentences of a sequence are new, and how much of a take it replays.

    >>> say_new(1, 1, (60, 96, 30))
    'new sentence; 2 changes of source, at most 3.20 s of a take in a row'
    >>> say_new(0, 1, (60,))
    'a sentence of the takes; a replay: all of it is one stretch of a take'
    """
    if sentences == 1:
        novelty = "new sentence" if new else "a sentence of the takes"
    else:
        novelty = f"{new} of {sentences} sentences are new"
    if len(stretches) == 1:
        return f"{novelty}; a replay: all of it is one stretch of a take"
    n, longest = len(stretches) - 1, max(stretches) / MOTION_FPS
    changes = f"{n} change{'s' * (n > 1)} of source"
    return f"{novelty}; {changes}, at most {longest:.2f} s of a take in a row"


def root_path(sequence: GrammarSequence) -> FloatArray:
    """Return the path of the root on the ground: array (points, 2), x and z in metres.

    Points follow each other in :data:`PATH_STEP` frames.
    """
    return np.asarray(sequence.motion.root_positions[::PATH_STEP, [0, 2]], dtype=float)


def tree_nodes(tree: Tree) -> tuple[TreeNode, ...]:
    """Return the nodes of a derivation in preorder, each with the positions that it covers.

    >>> from motiondb.grammar.cfg.context_free import derive_by, read_grammar
    >>> toy = read_grammar("S -> a B c" + chr(10) + "B -> b | empty")
    >>> [(n.symbol, n.parent, n.start, n.end) for n in tree_nodes(derive_by(toy, (0, 1)))]
    [('S', -1, 0, 3), ('a', 0, 0, 1), ('B', 0, 1, 2), ('b', 2, 1, 2), ('c', 0, 2, 3)]
    """
    nodes: list[tuple[Tree, int]] = []
    starts: list[int] = []
    position = 0
    waiting = [(tree, -1)]
    while waiting:  # a loop, because derivations can be too deep for recursion
        node, parent = waiting.pop()
        number = len(nodes)
        nodes.append((node, parent))
        starts.append(position)
        position += node.is_leaf
        waiting.extend((child, number) for child in reversed(node.children))
    ends = [start + node.is_leaf for start, (node, _) in zip(starts, nodes)]
    for number in range(len(nodes) - 1, 0, -1):  # children come after their parents
        parent = nodes[number][1]
        ends[parent] = max(ends[parent], ends[number])
    return tuple(
        TreeNode(node.symbol, parent, start, end, node.is_leaf)
        for (node, parent), start, end in zip(nodes, starts, ends)
    )


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
    log_probability: float | None = None
    """Natural logarithm of the smoothed probability of the string, also where it does not parse.
    None if ``stored``."""
    order_rank: float | None = None
    """Share of shuffles of the string that are less probable. None if ``stored`` or too short."""
    foresees: bool = False
    """Whether the grammar foresees held-out takes, so that ``order_rank`` means something."""

    def facts(self) -> answers.ParseAnswer:
        """The string with its sentences or its fault, for JSON."""
        fault = self.fault
        return answers.extended(
            answers.ParseAnswer,
            self,
            spans=list(zip(self.starts, self.ends)),
            learned_from=self.stored,
            usual_distance=self.reach,
            sentences=[answers.ParsedSentence(tree.leaves(), str(tree)) for tree in self.trees],
            fault=fault
            and answers.extended(answers.ParseFault, fault, found=fault.symbol, says=str(fault)),
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

    @property
    def is_disordered(self) -> bool:
        """Whether the order of the terminals is no more probable than that of shuffles."""
        return self.foresees and self.order_rank is not None and self.order_rank < foresight.ABOVE

    @property
    def of_another_activity(self) -> str:
        """Why the motion is probably of another activity; empty if nothing says so."""
        if self.is_unlike:
            return f"{self.share_unlike:.0%} of its time is unlike every terminal"
        if self.is_disordered:
            return (
                f"its order is more probable than only {self.order_rank:.0%} of its shuffles, where"
                f" captures of the activity reach {foresight.ABOVE:.0%}"
            )
        return ""


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


def model_of(session: Session, material: Material) -> Model:
    """The smoothed probabilities of a grammar; the session keeps them."""
    learned = material.learned

    def make() -> Model:
        judged = foresight_of(run_of(material))
        weight = judged.weight if judged else foresight.DEFAULT_WEIGHT
        known = grammar_asking.load_answers(material.database, learned.name)
        kept = grammar_asking.kept_answers(learned, known)
        return foresight.make_model(learned.grammar, learned.takes, weight, kept)

    return session.kept(("foresight", learned.name), make)


def parse_transcription(
    grammar: context_free.Grammar, transcription: Transcription, model: Model, foresees: bool
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
    string = transcription.string
    return ParsedMotion(
        string, starts, ends, False, trees, fault, distances, reach,
        model.log_probability(string), foresight.order_rank(model, string, seeded(0)), foresees,
    )  # fmt: skip


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
