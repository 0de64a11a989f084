"""Facts of a grammar and of the sequences that it generates, for printing, JSON and files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motiondb import store
from motiondb.answers.asking import DescribedWord
from motiondb.answers.grammars import (
    GrammarAnswer,
    GrammarRow,
    LearnedTake,
    Medoid,
    SequenceAnswer,
    TerminalRow,
    TerminalSpan,
    TerminalSymbol,
)
from motiondb.answers.plain import to_json
from motiondb.database.generate.generated_files import sources_of, write_with_provenance
from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material
from motiondb.database.grammars.grammar_words import Meaning
from motiondb.grammar.baselines.language_measures import finite_language
from motiondb.grammar.cfg import context_free
from motiondb.grammar.cfg.loops import format_loops
from motiondb.records import MOTION_FPS


def grammar_facts(material: Material, meanings: Sequence[Meaning]) -> GrammarAnswer:
    """Return the facts of a grammar."""
    learned = material.learned
    runs = {run.run_id: run for run in store.load_runs(material.database)}
    run = runs[learned.run_id]
    grammar = learned.grammar
    lengths = [len(string) for string in learned.strings]
    return GrammarAnswer(
        grammar=learned.name,
        run=learned.run_id,
        seed=run.seed,
        settings={k: v for k, v in run.parameters.items() if k not in ("name", "captures")},
        captures=tuple(
            LearnedTake(
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
        bits={**learned.bits, "sum": sum(learned.bits.values())},
        text=context_free.format_grammar(grammar),
        text_with_loops=format_loops(grammar),
    )


def grammar_row(size: store.GrammarSize) -> GrammarRow:
    """Return the size of a grammar, for JSON."""
    counts = vars(size) | {"bits": size.bits | {"sum": sum(size.bits.values())}}
    run = counts.pop("run_id")
    return GrammarRow(counts.pop("name"), run, **counts, seconds=round(size.seconds, 3))


def derives_new(grammar: context_free.Grammar, sentences: Sequence[tuple[str, ...]]) -> bool:
    """Whether a grammar derives a string that is not among the sentences.

    If it does not, the grammar only lists the sentences, and every new sequence repeats one of
    them.

    >>> derives_new(context_free.read_grammar("S -> a | b b"), [("a",), ("b", "b")])
    False
    """
    known = frozenset(sentences)
    language = finite_language(grammar, len(known))
    return language is None or not language <= known


def terminal_rows(
    learned: store.LearnedGrammar, meanings: Sequence[Meaning]
) -> tuple[TerminalRow, ...]:
    """Return the facts of each terminal."""
    terminals = learned.terminals
    rows = []
    for k, (name, meaning) in enumerate(zip(terminals.names, meanings)):
        members = terminals.labels == k
        medoid = int(terminals.medoids[k])
        length = float((terminals.ends - terminals.starts)[members].mean()) / MOTION_FPS
        rows.append(
            TerminalRow(
                name,
                int(members.sum()),
                round(length, 3),
                tuple(DescribedWord(w, p) for w, p in meaning.words),
                tuple(TerminalSymbol(s, p) for s, p in meaning.symbols),
                Medoid(
                    learned.sources[int(terminals.takes[medoid])].name,
                    round(float(terminals.starts[medoid]) / MOTION_FPS, 3),
                    round(float(terminals.ends[medoid]) / MOTION_FPS, 3),
                ),
            )
        )
    return tuple(rows)


def sequence_facts(sequence: GrammarSequence, seed: int) -> SequenceAnswer:
    """Return how a sequence was generated, for JSON.

    String, tree, costs of the joins, foot slip (m/s), the time of each terminal (seconds) and the
    sources of the frames.
    """
    made = sequence.made
    return SequenceAnswer(
        grammar=sequence.grammar,
        seed=seed,
        string=sequence.string,
        tree=" ".join(map(str, sequence.trees)),
        sentences=len(sequence.trees),
        seconds=round(sequence.motion.n_frames / MOTION_FPS, 3),
        join_cost=float(sequence.choice.cost),
        foot_slip=float(made.slip),
        foot_slip_of_sources=float(made.source_slip),
        spans=tuple(
            TerminalSpan(terminal, float(a) / MOTION_FPS, float(b) / MOTION_FPS)
            for terminal, (a, b) in zip(sequence.string, made.spans)
        ),
        sources=sources_of(sequence.provenance),
    )


def write_sequence(sequence: GrammarSequence, seed: int, path: Path) -> dict[str, Any]:
    """Write a sequence, and the origin of its frames, as ``Grammars.write`` does."""
    return write_with_provenance(sequence, to_json(sequence_facts(sequence, seed)), path)
