"""Task ``number`` of ``benchmarks/grammar.py``: how many terminals ``auto`` takes, and chance.

On takes of the sample data, whose kinds of action are known: the number of fewest bits and the
smallest within one standard error of it, from the same tries; and how far apart the bits of one
number lie when only the seed differs. The share of the noise that is allowed was chosen on one take
of each grammar, as the other settings of terminals were.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammar_tasks.tables import table
from grammar_tasks.truth import Found, TrueTake, judge_segments, label_names, load_truth
from motiondb.grammar.selection.ledger import make_ledger
from motiondb.grammar.selection.terminal_number import Trial, choose_terminals
from motiondb.grammar.sentences.partition import find_sentences
from motiondb.grammar.terminals.terminals import find_terminals, strings_of

SEEDS, FIRST_SEED = 2, 100
"""Number of seeds, and the first one. Chosen by hand; not tuned."""
NUMBERS, TRIES = (5, 6, 7, 8, 10, 12), 5
"""Numbers of terminals whose bits are measured several times, and how often. Chosen by hand."""


def number_rows() -> str:
    """The two tables."""
    _, takes = load_truth()
    rows = []
    for what, part in (
        ("chosen on", slice(0, 1)),
        ("held out", slice(1, None)),
        ("both takes", slice(None)),
    ):
        for name, motions in takes.items():
            rows.append([f"{name}, {what}", *_chosen(motions[part])])
            print(" ", *rows[-1], flush=True)
    heads = ["takes", "kinds of action", "of fewest bits", "auto", "noise, bits",
             "adjusted Rand index, fewest", "auto"]  # fmt: skip
    spread = [[name, *_spread(motions[:1])] for name, motions in takes.items()]
    said = (
        f"{SEEDS} seeds each. Below: mean and standard deviation of the bits of one number over"
        f" {TRIES} seeds, on the takes that were chosen on."
    )
    return "\n\n".join([table(heads, rows), said, table(["take", *map(str, NUMBERS)], spread)])


def _chosen(takes: Sequence[TrueTake]) -> list[str]:
    motions = [take.motion for take in takes]
    fewest, auto, noise, judged = [], [], [], []
    for seed in range(FIRST_SEED, FIRST_SEED + SEEDS):
        choice = choose_terminals(motions, np.random.default_rng(seed))
        least = min(choice.ledgers, key=lambda number: choice.ledgers[number].total)
        fewest.append(least)
        auto.append(choice.number)
        noise.append(choice.noise)
        judged.append([_index(takes, choice.trials[k]) for k in (least, choice.number)])
    both = [f"{index:.2f}" for index in np.mean(judged, axis=0)]
    numbers = ", ".join(map(str, fewest)), ", ".join(map(str, auto))
    return [str(len(label_names(takes))), *numbers, f"{np.mean(noise):.0f}", *both]


def _index(takes: Sequence[TrueTake], trial: Trial) -> float:
    terminals = trial.terminals
    return judge_segments(takes, Found(terminals.takes, terminals.starts, terminals.labels))[1]


def _spread(takes: Sequence[TrueTake]) -> list[str]:
    motions = [take.motion for take in takes]
    cells = []
    for number in NUMBERS:
        bits = []
        for seed in range(TRIES):
            rng = np.random.default_rng(seed)
            terminals = find_terminals(motions, number, rng)
            sentences = find_sentences(strings_of(terminals), rng)
            bits.append(make_ledger(motions, terminals, sentences).total)
        cells.append(f"{np.mean(bits):.0f} ± {np.std(bits, ddof=1):.0f}")
    return cells
