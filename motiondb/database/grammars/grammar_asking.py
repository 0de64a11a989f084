"""Questions about pairs of terminals to a person, and the answers that the next learning keeps.

Answers are runs (``grammar answer``): with author, version and time, and never changed; the last
answer about a pair counts. Each holds the medoids of both terminals, by the digest of their
captures and their frames. So an answer also counts after learning anew with other terminals: a
terminal is the one whose segment shares the most frames with the medoid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from motiondb import answers, pictures, store
from motiondb.database.grammars.grammar_sequences import Material, shown_at
from motiondb.database.loading import LearnedGrammar
from motiondb.errors import QueryError, suggestion
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, choices_of
from motiondb.grammar.cfg.parse import accepts, parse
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.pair_questions import Pair, find_questions, spliced, without_pairs
from motiondb.grammar.rules.description_length import description_length
from motiondb.grammar.synthesis import synthesise

ANSWER = "grammar answer"  # Kind of the run of an answer
SAID = ("yes", "no", "unknown")


@dataclass(frozen=True)
class KnownAnswer:
    """An answer of a person, with the segments that showed both terminals."""

    said: str  # One of SAID
    segments: tuple[tuple[str, int, int], ...]  # For each terminal, digest, first frame, end


def questions(
    learned: LearnedGrammar, known: Sequence[KnownAnswer], n: int, words: Mapping[str, str]
) -> list[answers.GrammarQuestion]:
    """Return the ``n`` questions whose answers say most; those that were answered are left out.

    `words`: What each terminal shows.
    """
    labels = learned.terminals.labels
    same_take = np.diff(learned.terminals.takes) == 0
    repeats = bool(((np.diff(labels) == 0) & same_take).any())  # runs of poses never repeat
    names = learned.terminals.names
    answered = terminal_answers(learned, known, SAID).keys()
    found = find_questions(learned.takes, names, answered, n, repeats)
    medoids = dict(zip(names, learned.terminals.medoids.tolist(), strict=True))
    return [
        answers.GrammarQuestion(
            one.first, one.then, one.observed, round(one.gain, 3),
            shown_at(learned, medoids[one.first]), shown_at(learned, medoids[one.then]),
            words.get(one.first, ""), words.get(one.then, ""),
        )
        for one in found
    ]  # fmt: skip


def _segment(learned: LearnedGrammar, name: str) -> tuple[str, int, int]:
    """The medoid of a terminal: digest of its capture, first frame and end."""
    terminals = learned.terminals
    clip = int(terminals.medoids[terminals.names.index(name)])
    digest = learned.sources[int(terminals.takes[clip])].sha256
    return digest, int(terminals.starts[clip]), int(terminals.ends[clip])


def save_answer(
    database: store.Store, learned: LearnedGrammar, pair: Sequence[str], said: str, author: str
) -> bool:
    """Save an answer; QueryError where a terminal or the answer is none.

    Returns whether rules can keep to it: a pair that the sentences hold cannot be ruled out.
    """
    for name in pair:
        if name not in learned.terminals.names:
            near = suggestion(name, learned.terminals.names)
            near = near or f" There are: {', '.join(learned.terminals.names)}."
            raise QueryError(f"answer: expected terminals of {learned.name}, found {name!r}.{near}")
    if len(pair) != 2 or said not in SAID:
        raise QueryError(
            f"answer: expected two terminals and {', '.join(SAID[:-1])} or {SAID[-1]}, found"
            f" {' '.join((*pair, said))!r}. Write it as 'a b yes'."
        )
    if not author.strip() or len(author) > 80 or not author.isprintable():
        raise QueryError("author: expected a name of 1 to 80 letters, found another. Give one.")
    parameters: dict[str, Any] = {
        "name": learned.name,
        "pair": list(pair),
        "said": said,
        "author": author,
        "segments": [_segment(learned, name) for name in pair],
    }
    with store.running(database, ANSWER, parameters):
        pass
    return said != "no" or tuple(pair) not in _held(learned)


def animate(material: Material, asked: Sequence[answers.GrammarQuestion], path: str | Path) -> Path:
    """Write a GIF in which, for each question, the second terminal comes straight after the first.

    Each is played by its medoid; questions whose captures were removed are left out.
    """
    terminals = material.learned.terminals
    medoids = dict(zip(terminals.names, terminals.medoids.tolist(), strict=True))
    takes, shown = terminals.takes, list[tuple[str, tuple[int, int]]]()
    for n, one in enumerate(asked, start=1):
        clips = medoids[one.first], medoids[one.then]
        if all(int(takes[clip]) in material.numbers for clip in clips):
            shown.append((f"{n}: {one.first}, then {one.then}?", clips))
    if not shown:
        raise QueryError(
            f"{material.learned.name}: expected captures of its questions, found all of them"
            " removed. Add them again."
        )
    motions = [synthesise(terminals, clips, material.source).motion for _, clips in shown]
    return pictures.draw_animations(motions, [title for title, _ in shown], path)


def load_answers(database: store.Store, name: str) -> list[KnownAnswer]:
    """Load the answers about a grammar in the order in which they were given."""
    given = [run.parameters for run in store.load_runs(database) if run.kind == ANSWER]
    return [
        KnownAnswer(
            str(one["said"]),
            tuple((str(d), int(a), int(b)) for d, a, b in cast("list[Any]", one["segments"])),
        )
        for one in given
        if one["name"] == name
    ]


def terminal_answers(
    learned: LearnedGrammar, known: Sequence[KnownAnswer], said: Sequence[str]
) -> dict[Pair, str]:
    """Return answers by the present terminals; the last one about a pair counts."""
    found: dict[Pair, str] = {}
    for one in known:
        names = [_terminal_at(learned, *segment) for segment in one.segments]
        if names[0] is not None and names[1] is not None:
            found[names[0], names[1]] = one.said
    return {pair: what for pair, what in found.items() if what in said}


def _terminal_at(learned: LearnedGrammar, digest: str, start: int, end: int) -> str | None:
    """The terminal whose segment shares most frames with others of a capture; None: no capture."""
    terminals = learned.terminals
    takes = [n for n, source in enumerate(learned.sources) if source.sha256 == digest]
    if not takes:
        return None
    shared = np.minimum(terminals.ends, end) - np.maximum(terminals.starts, start)
    shared[terminals.takes != takes[0]] = 0
    best = int(np.argmax(shared))
    return terminals.names[terminals.labels[best]] if shared[best] > 0 else None


def _held(learned: LearnedGrammar) -> set[Pair]:
    """The pairs that the sentences hold."""
    return {pair for sentence in learned.strings for pair in pairwise(sentence)}


def kept_answers(learned: LearnedGrammar, known: Sequence[KnownAnswer]) -> dict[Pair, bool]:
    """Return the answers that rules can keep to: whether a pair may occur.

    A pair that the sentences hold cannot be ruled out: such an answer is left out.
    """
    said, held = terminal_answers(learned, known, ("yes", "no")), _held(learned)
    return {pair: what == "yes" for pair, what in said.items() if what == "yes" or pair not in held}


def with_answers(
    learned: LearnedGrammar, known: Sequence[KnownAnswer]
) -> tuple[LearnedGrammar, Mapping[Pair, bool]]:
    """Return a grammar whose rules keep to the answers, and the answers that they keep to."""
    kept = kept_answers(learned, known)
    if not kept:
        return learned, {}
    examples = spliced(learned.strings, [pair for pair, can in kept.items() if can])
    grammar = learned.grammar
    if not all(accepts(grammar, example) for example in examples):
        grammar = induce([*learned.strings, *examples])
    try:
        grammar = without_pairs(grammar, [pair for pair, can in kept.items() if not can])
    except GrammarError as error:
        raise QueryError(str(error)) from None
    grammar = Grammar(grammar.start, grammar.rules, learned.terminals.names)
    bits = description_length(Grammar(grammar.start, grammar.rules), learned.strings)
    answered = replace(
        learned,
        grammar=grammar,
        parses=tuple(choices_of(parse(grammar, sentence)) for sentence in learned.strings),
        bits={"sentences": bits.sentences, "rules": bits.grammar},
    )
    return answered, kept
