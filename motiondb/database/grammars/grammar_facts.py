"""A grammar, and what it generates, as plain facts for print and JSON, and as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motiondb import store
from motiondb.database.generate.generated_files import source_facts, write_with_provenance
from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material
from motiondb.database.grammars.grammar_words import Meaning
from motiondb.grammar.baselines.language_measures import finite_language
from motiondb.grammar.cfg import context_free
from motiondb.records import MOTION_FPS


def grammar_facts(material: Material, meanings: Sequence[Meaning]) -> dict[str, Any]:
    """Everything known of a grammar; times in seconds."""
    learned = material.learned
    runs = {run.run_id: run for run in store.load_runs(material.database)}
    run = runs[learned.run_id]
    grammar = learned.grammar
    lengths = [len(string) for string in learned.strings]
    return {
        "grammar": learned.name,
        "run": learned.run_id,
        "seed": run.seed,
        "settings": {k: v for k, v in run.parameters.items() if k not in ("name", "captures")},
        "captures": [
            {
                "capture": source.name,
                "sha256": source.sha256,
                "seconds": round(source.n_frames / MOTION_FPS, 3),
                "there": take in material.numbers,
            }
            for take, source in enumerate(learned.sources)
        ],
        "frames": sum(source.n_frames for source in learned.sources),
        "segments": len(learned.terminals.takes),
        "terminals": terminal_facts(learned, meanings),
        "objective": None if np.isnan(learned.terminals.objective) else learned.terminals.objective,
        "sentences": len(learned.sentences),
        "sentence_lengths": [min(lengths), float(np.mean(lengths)), max(lengths)],
        "nonterminals": len(grammar.nonterminals),
        "rules": len(grammar.rules),
        "derives_new": derives_new(grammar, learned.strings),
        "bits": {**learned.bits, "sum": sum(learned.bits.values())},
        "text": context_free.format_grammar(grammar),
    }


def derives_new(grammar: context_free.Grammar, sentences: Sequence[tuple[str, ...]]) -> bool:
    """Whether a grammar derives a string that is none of the sentences.

    If not, it is a list of the sentences, and new sequences repeat them.

    >>> derives_new(context_free.read_grammar("S -> a | b b"), [("a",), ("b", "b")])
    False
    """
    known = frozenset(sentences)
    language = finite_language(grammar, len(known))
    return language is None or not language <= known


def terminal_facts(
    learned: store.LearnedGrammar, meanings: Sequence[Meaning]
) -> list[dict[str, Any]]:
    """Every terminal: how often, how long, its medoid, its words and motion symbols."""
    terminals = learned.terminals
    facts = []
    for k, (name, meaning) in enumerate(zip(terminals.names, meanings)):
        own = terminals.labels == k
        medoid = int(terminals.medoids[k])
        facts.append(
            {
                "terminal": name,
                "count": int(own.sum()),
                "seconds": round(
                    float((terminals.ends - terminals.starts)[own].mean()) / MOTION_FPS, 3
                ),
                "words": [{"word": w, "probability": p} for w, p in meaning.words],
                "symbols": [{"symbol": s, "share": p} for s, p in meaning.symbols],
                "medoid": {
                    "capture": learned.sources[int(terminals.takes[medoid])].name,
                    "start": round(float(terminals.starts[medoid]) / MOTION_FPS, 3),
                    "end": round(float(terminals.ends[medoid]) / MOTION_FPS, 3),
                },
            }
        )
    return facts


def format_tree(tree: context_free.Tree) -> str:
    r"""Return a tree on one line, every nonterminal with what it derives in brackets.

    >>> toy = context_free.read_grammar("S -> a B c\nB -> b | empty")
    >>> format_tree(context_free.derive_by(toy, (0, 1)))
    'S(a B(b) c)'
    """
    parts: list[str] = []
    waiting: list[context_free.Tree | str] = [tree]
    while waiting:  # no recursion, for derivations can be deep
        item = waiting.pop()
        if isinstance(item, str):
            parts.append(item)
        elif item.is_leaf:
            parts.append(item.symbol)
        else:
            inner: list[context_free.Tree | str] = [f"{item.symbol}("]
            for number, child in enumerate(item.children):
                inner += [" ", child] if number else [child]
            waiting.extend(reversed([*inner, ")"]))
    return "".join(parts)


def sequence_facts(sequence: GrammarSequence, seed: int) -> dict[str, Any]:
    """How a sequence came about: string, tree, seams, sources."""
    made = sequence.made
    return {
        "grammar": sequence.grammar,
        "seed": seed,
        "string": list(sequence.string),
        "tree": format_tree(sequence.tree),
        "seconds": round(sequence.motion.n_frames / MOTION_FPS, 3),
        "join_cost": sequence.choice.cost,
        "greedy_join_cost": sequence.greedy,
        "foot_slip": made.slip,
        "foot_slip_of_sources": made.source_slip,
        "spans": [
            {"terminal": terminal, "start": a / MOTION_FPS, "end": b / MOTION_FPS}
            for terminal, (a, b) in zip(sequence.string, made.spans)
        ],
        "sources": source_facts(sequence),
    }


def write_sequence(sequence: GrammarSequence, seed: int, path: Path) -> dict[str, Any]:
    """Write the motion and, beside it, where every frame comes from; gives the facts, for JSON."""
    return write_with_provenance(sequence, sequence_facts(sequence, seed), path)
