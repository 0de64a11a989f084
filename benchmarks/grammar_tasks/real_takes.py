"""Task ``real`` of ``benchmarks/grammar.py``: break-dance, boxing, salsa and basketball.

All takes of a style are used for one grammar; sentences never cross the end of a capture. For each
number of terminals, the ledger's bits are listed, and how many held-out sentences are foreseen; the
default number is marked. Basketball's captures are one sentence each, as the clips of the paper
are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from grammar_tasks.foreseen import Learn, foreseen_rows, held_out_ranks
from grammar_tasks.language_match import share_with_unseen_pairs
from grammar_tasks.ledger import Ledger, make_ledger
from grammar_tasks.tables import table
from grammar_tasks.truth import KINDS
from motiondb.body import body, retarget
from motiondb.database.grammars.grammar_learning import default_terminals
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.languages import (
    coverage,
    derived_strings,
    finite_language,
    finite_state_grammar,
    held_out_coverage,
)
from motiondb.grammar.sentences.partition import Sentences, find_sentences, sentences_between
from motiondb.grammar.terminals.terminals import Terminals, find_terminals, strings_of
from motiondb.records import IntArray
from quality_protocol.captures import Capture, load_cmu

CANDIDATES = (4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 30)
"""Numbers of terminals that are compared."""
STRINGS, FOLDS, LIMIT = 500, 5, 10_000
"""Strings drawn from a grammar, parts of the cross-validation, and strings at most that are
counted in a language. Chosen by hand; not tuned."""
ABOVE_HEAD = 0.0
"""Metres that a wrist must be above the head at the top of a shot."""
STYLES: dict[str, Callable[[Capture], bool]] = {
    "break-dance": lambda capture: capture.performer == "85",
    "boxing": lambda capture: capture.name in ("14/14_02", "17/17_10"),
    "salsa": lambda capture: capture.performer == "60",
    "basketball": lambda c: c.performer == "06" and any("basketball" in s for s in c.captions),
}


@dataclass(frozen=True, eq=False)
class Trial:
    """What is learned with a number of terminals."""

    terminals: Terminals
    sentences: Sentences
    ledger: Ledger


def real(data: Path, style: str) -> str:
    """The section of a style."""
    of_style = [capture for capture in load_cmu(data) if STYLES[style](capture)]
    return style_rows(of_style, style == "basketball")


def style_rows(captures: Sequence[Capture], are_sentences: bool) -> str:
    """Sizes, bits and foresight by K; the grammar of the default K compared with others; shots."""
    n_frames = sum(capture.motion.n_frames for capture in captures)
    default = default_terminals(n_frames)
    numbers = sorted({*CANDIDATES, default})
    tried = {k: try_number(captures, are_sentences, k) for k in numbers}
    rows = []
    for k, one in tried.items():
        ledger, grammar = one.ledger, one.sentences.grammar
        counts = len(one.terminals.starts), len(one.sentences.sentences), len(grammar.nonterminals)
        bits = ledger.motion, ledger.string, ledger.grammar, ledger.total
        rows.append(
            [f"{k} (default)" if k == default else str(k), *map(str, counts),
             str(len(grammar.rules)), *(f"{part:,.0f}" for part in bits),
             f"{one.terminals.objective:.2f}", _foreseen(induce, one.sentences),
             _foreseen(finite_state_grammar, one.sentences)]
        )  # fmt: skip
    heads = ["terminals", "segments", "sentences", "nonterminals", "rules", "motion bits",
             "string bits", "grammar bits", "all bits", "F", "held out among 100",
             "finite state machine"]  # fmt: skip
    said = f"{len(captures)} captures, {n_frames:,} frames ({n_frames / 30:.0f} s)."
    chosen = tried[default].sentences
    learners: dict[str, Learn] = {
        "motiondb": induce,
        "without loops": partial(induce, loops=False),
        "finite state machine": finite_state_grammar,
    }
    parts = [said, table(heads, rows), f"With {default} terminals:", kind_rows(chosen)]
    parts += [foreseen_rows(learners, chosen.sentences, FOLDS)]
    if are_sentences:
        parts += [shot_rows(captures, tried)]
    return "\n\n".join(parts)


def try_number(captures: Sequence[Capture], are_sentences: bool, number: int) -> Trial:
    """Learn with a number of terminals, as ``grammar learn`` does with seed 0."""
    motions, rng = [capture.motion for capture in captures], np.random.default_rng(0)
    terminals = find_terminals(motions, number, rng)
    strings = strings_of(terminals)
    if are_sentences:
        sentences = sentences_between(strings, [[] for _ in strings])
    else:
        sentences = find_sentences(strings, rng)
    print(f"  {number} terminals, {len(terminals.starts)} segments", flush=True)
    return Trial(terminals, sentences, make_ledger(motions, terminals, sentences))


def _foreseen(learn: Learn, partition: Sentences) -> str:
    """Share of the sentences among the 100 most probable strings of the language of the others."""
    sentences = partition.sentences
    if len(sentences) < 2:
        return ""
    ranks = held_out_ranks(learn, sentences, min(FOLDS, len(sentences)))
    return f"{np.mean([rank <= 100 for rank in ranks]):.0%}"


def kind_rows(partition: Sentences) -> str:
    """The grammar compared with a finite state machine."""
    sentences = list(partition.sentences)
    known, rows = set(sentences), []
    for kind, learn in KINDS.items():
        grammar = partition.grammar if kind == "motiondb" else learn(sentences)
        strings = derived_strings(grammar, np.random.default_rng(0), STRINGS)
        language = finite_language(grammar, LIMIT)
        held = _held_out(learn, sentences)
        rows.append(
            [kind, str(len(grammar.nonterminals)), str(len(grammar.rules)),
             "no end" if language is None else str(len(language)), held,
             f"{sum(s not in known for s in strings) / STRINGS:.0%}",
             f"{1.0 - coverage(partition.grammar, strings):.0%}",
             f"{share_with_unseen_pairs(strings, sentences):.0%}",
             f"{np.mean([len(s) for s in strings]):.1f}"]
        )  # fmt: skip
    heads = ["grammar", "nonterminals", "rules", "strings", "held out", "new", "outside",
             "unseen pairs", "mean length"]  # fmt: skip
    return table(heads, rows)


def _held_out(learn: Callable[[list[tuple[str, ...]]], Grammar], sentences: list) -> str:
    if len(sentences) < 2:
        return ""
    folds = min(FOLDS, len(sentences))
    return f"{held_out_coverage(learn, sentences, np.random.default_rng(0), folds=folds):.0%}"


def shot_rows(captures: Sequence[Capture], tried: dict[int, Trial]) -> str:
    """Shots a derived sentence, for every number of terminals.

    A terminal is a shot where one of its segments holds a moment at which both wrists are above
    the head (0.4 m and more below it in all captures without a shot).
    """
    high = [_hands_up(capture) for capture in captures]
    rows = []
    for k, one in tried.items():
        shots = shot_terminals(one.terminals, high)
        examples = [sum(s in shots for s in sentence) for sentence in one.sentences.sentences]
        kinds = {
            "motiondb": one.sentences.grammar,
            "finite state machine": finite_state_grammar(one.sentences.sentences),
        }
        derived = []
        for grammar in kinds.values():
            strings = derived_strings(grammar, np.random.default_rng(0), STRINGS)
            counts = [sum(s in shots for s in string) for string in strings]
            derived.append(f"{max(counts)} ({sum(c > 1 for c in counts) / STRINGS:.0%})")
        rows.append([str(k), " ".join(sorted(shots)) or "none", str(max(examples)), *derived])
    heads = ["terminals", "shots are", "most in an example", "most derived, motiondb (share above "
             "1)", "finite state machine"]  # fmt: skip
    return table(heads, rows)


def shot_terminals(terminals: Terminals, high: Sequence[IntArray]) -> set[str]:
    """Terminals with a segment that holds a frame of ``high``."""
    shots = set()
    for take, start, end, label in zip(
        terminals.takes, terminals.starts, terminals.ends, terminals.labels
    ):
        if ((high[take] >= start) & (high[take] < end)).any():
            shots.add(terminals.names[label])
    return shots


def _hands_up(capture: Capture) -> IntArray:
    """The frame in which both wrists are highest, where that is above the head; else none."""
    positions, _ = retarget.motion_positions(capture.motion)
    wrists = [body.INDEX[name] for name in ("l_wrist", "r_wrist")]
    above = positions[:, wrists, 1].min(axis=1) - positions[:, body.INDEX["head"], 1]
    highest = int(np.argmax(above))
    return np.array([highest] if above[highest] > ABOVE_HEAD else [], dtype=np.int64)
