"""Task ``real`` of ``benchmarks/grammar.py``: break-dance, boxing, salsa and basketball.

All takes of a style are used for one grammar; sentences never cross the end of a capture. For each
number of terminals, the ledger's bits are listed, and the choice of ``auto`` is marked.
Basketball's captures are one sentence each, as the clips of the paper are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from grammar_tasks.foreseen import Learn, foreseen_rows
from grammar_tasks.tables import table
from grammar_tasks.truth import KINDS
from motiondb.body import body, retarget
from motiondb.grammar.baselines.finite_state import finite_state_grammar
from motiondb.grammar.baselines.language_measures import (
    coverage,
    derived_strings,
    finite_language,
    held_out_coverage,
    share_with_unseen_pairs,
)
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.selection.terminal_number import CANDIDATES, Choice, Trial, choose_terminals
from motiondb.grammar.sentences.classes import induce_in_classes
from motiondb.grammar.sentences.partition import Sentences, find_sentences, sentences_between
from motiondb.grammar.terminals.likeness import class_levels
from motiondb.grammar.terminals.terminals import Terminals, strings_of
from motiondb.records import IntArray
from quality_protocol.captures import Capture, load_cmu

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


def real(data: Path, style: str, candidates: Sequence[int] = CANDIDATES) -> str:
    """The section of a style."""
    of_style = [capture for capture in load_cmu(data) if STYLES[style](capture)]
    return style_rows(of_style, style == "basketball", candidates)


def style_rows(captures: Sequence[Capture], are_sentences: bool, candidates: Sequence[int]) -> str:
    """Sizes and bits by K; the grammar of fewest bits compared with simpler ones; shots."""
    choice = try_all(captures, are_sentences, candidates)
    tried = choice.trials
    n_frames = sum(capture.motion.n_frames for capture in captures)
    best = choice.number
    rows = []
    for k, one in tried.items():
        ledger, grammar = one.ledger, one.sentences.grammar
        counts = len(one.terminals.starts), len(one.sentences.sentences), len(grammar.nonterminals)
        bits = ledger.motion, ledger.string, ledger.grammar, ledger.total
        rows.append(
            [f"{k} (auto)" if k == best else str(k), *map(str, counts), str(len(grammar.rules)),
             *(f"{part:,.0f}" for part in bits), f"{one.terminals.objective:.2f}"]
        )  # fmt: skip
    heads = ["terminals", "segments", "sentences", "nonterminals", "rules", "motion bits",
             "string bits", "grammar bits", "all bits", "F"]  # fmt: skip
    said = f"{len(captures)} captures, {n_frames:,} frames ({n_frames / 30:.0f} s)."
    parts = [said, table(heads, rows), f"With {best} terminals:", kind_rows(choice.sentences)]
    levels = class_levels([c.motion for c in captures], tried[best].terminals)
    learners: dict[str, Learn] = {
        "motiondb": lambda sentences: induce_in_classes(sentences, levels).grammar,
        "without classes": induce,
        "without loops": partial(induce, loops=False),
        "finite state machine": finite_state_grammar,
    }
    parts += [foreseen_rows(learners, choice.sentences.sentences, FOLDS)]
    if are_sentences:
        parts += [shot_rows(captures, tried)]
    return "\n\n".join(parts)


def try_all(captures: Sequence[Capture], are_sentences: bool, candidates: Sequence[int]) -> Choice:
    """Every number of terminals, and the choice among them."""
    motions = [capture.motion for capture in captures]

    def learn(terminals: Terminals, rng: np.random.Generator) -> Sentences:
        strings, levels = strings_of(terminals), class_levels(motions, terminals)
        if are_sentences:
            sentences = sentences_between(strings, [[] for _ in strings], levels)
        else:
            sentences = find_sentences(strings, rng, levels=levels)
        print(f"  {len(terminals.names)} terminals, {len(terminals.starts)} segments", flush=True)
        return sentences

    rng = np.random.default_rng(0)
    return choose_terminals(motions, rng, candidates=candidates, learn=learn)


def kind_rows(partition: Sentences) -> str:
    """The grammar compared with a finite state machine, Sequitur and flat rules."""
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
            "alignment only": induce(one.sentences.sentences, compacted=False),
            "finite state machine": finite_state_grammar(one.sentences.sentences),
        }
        derived = []
        for grammar in kinds.values():
            strings = derived_strings(grammar, np.random.default_rng(0), STRINGS)
            counts = [sum(s in shots for s in string) for string in strings]
            derived.append(f"{max(counts)} ({sum(c > 1 for c in counts) / STRINGS:.0%})")
        rows.append([str(k), " ".join(sorted(shots)) or "none", str(max(examples)), *derived])
    heads = ["terminals", "shots are", "most in an example", "most derived, motiondb (share above "
             "1)", "alignment only", "finite state machine"]  # fmt: skip
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
