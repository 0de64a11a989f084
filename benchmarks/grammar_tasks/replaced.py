"""Task ``errors`` of ``benchmarks/grammar.py``: which error of the terminals limits the language.

On the long takes of known grammars, the true sentences are given, and one property of the terminals
after the other is replaced by the truth: the boundaries of segments, or their labels. So the
figures differ by terminals only, not by the search for sentences.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from grammar_tasks import truth as known
from grammar_tasks.long_takes import long_takes
from grammar_tasks.tables import table, table_rows
from motiondb.grammar.induction.induction import induce_with_bits
from motiondb.grammar.terminals.distances import make_poses, segment_distances
from motiondb.grammar.terminals.medoids import group_by_medoids
from motiondb.grammar.terminals.terminals import Terminals, find_terminals, terminal_names
from motiondb.records import IntArray

SHARES = (1.5, 2.0)
"""Terminals for each label. 1.5 is the number of the table of more terminals."""


@dataclass(frozen=True, eq=False)
class Variant:
    """Strings of some terminals, and what they are."""

    what: str
    strings: known.Strings


def error_rows(names: Sequence[str], before: str) -> str:
    """A row for each grammar and replaced property; rows of other grammars are as before."""
    grammars, _ = known.load_truth()
    rows = [row for row in table_rows(before) if row[0] not in names]
    for name in names:
        takes, begins = long_takes(name)
        for variant in _variants(takes):
            _, strings, starts, meaning = variant.strings
            given = known.given_sentences(strings, starts, begins)
            learned = induce_with_bits(given)
            labelled = known.as_labels(learned.grammar, meaning, grammars[name])
            measures = known.match_row([labelled], grammars[name])
            rows.append([name, variant.what, f"{learned.bits.total:.0f}", *measures])
            print(" ", *rows[-1], flush=True)
    heads = ["takes", "terminals, true sentences given", "bits", "precision", "recall", "F1"]
    return table(heads, sorted(rows, key=lambda row: row[0]))


def _variants(takes: Sequence[known.TrueTake]) -> Iterator[Variant]:
    n_labels = len(known.label_names(takes))
    motions = [take.motion for take in takes]
    for share in SHARES:
        number = round(share * n_labels)
        terminals = find_terminals(motions, number, np.random.default_rng(0))
        strings = known.strings_found(takes, terminals)
        yield Variant(f"{number} found", strings)
        grouped = known.strings_found(takes, _true_segments(takes, number))
        yield Variant(f"{number} on true boundaries", grouped)
    yield Variant(f"{n_labels} true labels", known.true_strings(takes))


def _true_segments(takes: Sequence[known.TrueTake], number: int) -> Terminals:
    """The true segments, grouped by their motion; all segments weigh alike."""
    poses = make_poses([take.motion for take in takes])
    starts = np.concatenate([take.cuts[:-1] for take in takes])
    ends = np.concatenate([take.cuts[1:] for take in takes])
    of_take: IntArray = np.repeat(np.arange(len(takes)), [len(take.labels) for take in takes])
    offsets = poses.bounds[of_take]
    apart = segment_distances(poses.values, starts + offsets, ends + offsets)
    ones = np.ones(len(starts))
    medoids, labels = group_by_medoids(apart, number, weights=ones, prices=0.0 * ones)
    return Terminals(terminal_names(number), of_take, starts, ends, labels, medoids, 0.0)
