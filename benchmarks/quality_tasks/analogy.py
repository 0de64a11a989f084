"""Word sequences never seen in training: how many decode, with and without clusters of symbols."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb.language.translation import transition
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import decode
from motiondb.meaning.counting import described_intervals
from motiondb.records import FloatArray
from quality_protocol.confidence import mean_of, statistic_of
from quality_protocol.learned_database import learned_database
from quality_protocol.report import Measure, TaskReport

LENGTHS = (2, 3, 4)
"""Words of a sequence."""
N_SEQUENCES = 1000
"""Sequences drawn. Chosen by hand; not tuned."""
LEAST_CAPTIONS = 4
"""Captions that must hold a word for it to be drawn. Chosen by hand; not tuned."""
CLEAR = 0.05
"""t(word | symbol) from which a symbol explains a word; the mean over all words is about 0.003."""


@dataclass(frozen=True)
class Decoded:
    """Per sequence of words and kind of bigram: usable as defined, and usable in order."""

    plain: tuple[bool, bool]
    clustered: tuple[bool, bool]


def run(data: Path, seed: int) -> TaskReport:
    """Sequences of two to four words, both bigrams."""
    return measure(learned_database(data, seed), seed)


def measure(database: Path, seed: int) -> TaskReport:
    """The same on a database that has learned."""
    rows: list[tuple[str | float | Measure, ...]] = []
    with motiondb.open(database, read_only=True) as db:
        for length in LENGTHS:
            answers = [
                _decode(db.learned, words) for words in unseen(db.learned, length, seed + length)
            ]
            rows += _rows(length, answers, seed)
        notes = (_left_out_note(db.learned),)
    return TaskReport(
        "Analogy: word sequences never seen",
        f"{N_SEQUENCES} random sequences of two, three and four words that never occur together "
        f"in one description; each word is in at least {LEAST_CAPTIONS} descriptions. They are "
        f"decoded to as many symbols as words, with the plain bigram of symbols and with the "
        f"bigram interpolated by clusters. *Usable*: the probability is above 0, and every word "
        f"has a symbol in the sequence with t(word | symbol) of at least {CLEAR} (as learned, not "
        f"smoothed: 0 for symbols that never occur with the word). *Usable in order*: the symbol "
        f"is at the position of its word.",
        ("words", "bigram", "usable", "usable in order", "usable, times the plain bigram's"),
        tuple(rows),
        notes,
    )


def _left_out_note(learned: Learned) -> str:
    """How probable the transitions of each capture are by those of all others: in nats."""
    n_symbols = learned.symbols.n_symbols
    counted = [
        transition.count_transitions([learned.segments.symbols[rows]], n_symbols)
        for rows in learned.rows.values()
    ]
    total = np.sum(counted, axis=0)
    shares = (0.5, 0.7, 0.8, 0.9)
    sums = np.zeros(len(shares) + 1)
    for counts in counted:
        others = total - counts
        plain = np.exp(transition.log_bigram(others))
        clustered = np.exp(transition.log_clustered_bigram(others, learned.clusters))
        followed = others.sum(axis=1, keepdims=True) > 0
        mixed = [np.where(followed, s, 0.0) for s in shares]
        rows = [m * plain + (1.0 - m) * clustered for m in mixed]
        rows.append(np.exp(transition.log_interpolated_bigram(others, learned.clusters)))
        seen = counts > 0
        sums += [float((counts[seen] * np.log(row[seen] + 1e-300)).sum()) for row in rows]
    means = sums / total.sum()
    fixed = ", ".join(f"{share}: {mean:.3f}" for share, mean in zip(shares, means))
    return (
        f"{learned.clusters.max() + 1} clusters. The weight of the plain bigram (a share for each "
        f"row, after Witten and Bell) was chosen by leaving captures out, not by this task. Nats "
        f"per transition, each capture by the transitions of all others: {means[-1]:.3f}; with one "
        f"share for all rows {fixed}."
    )


def unseen(learned: Learned, length: int, seed: int) -> list[tuple[str, ...]]:
    """Sequences of different words, no two of which occur in one description."""
    described = described_intervals(learned.segments, learned.captions, learned.synonyms)
    together = {(a, b) for d in described for a in d.words for b in d.words}
    counts = learned.association.counts
    known = [w for w, n in zip(learned.association.words, counts) if n >= LEAST_CAPTIONS]
    rng = np.random.default_rng(seed)
    sequences: dict[tuple[str, ...], None] = {}
    for _ in range(100_000):
        words = tuple(known[n] for n in rng.choice(len(known), length, replace=False))
        if all((a, b) not in together for a in words for b in words if a != b):
            sequences[words] = None
        if len(sequences) == N_SEQUENCES:
            break
    return list(sequences)


def _decode(learned: Learned, words: Sequence[str]) -> Decoded:
    usable = []
    for clustered in (False, True):
        answer = decode(learned, words, clustered=clustered, length=len(words))
        if answer is None or not np.isfinite(answer.log_probability):
            usable.append((False, False))
            continue
        clear = _explains(learned, words, answer.symbols) >= CLEAR
        usable.append((bool(clear.any(axis=1).all()), bool(np.diag(clear).all())))
    return Decoded(*usable)


def _explains(learned: Learned, words: Sequence[str], symbols: Sequence[int]) -> FloatArray:
    """t(word | symbol), array (words, symbols)."""
    number = {word: n for n, word in enumerate(learned.association.words)}
    t = learned.association.translation[1:]
    return np.asarray(t[np.ix_(np.array(symbols), np.array([number[w] for w in words]))].T)


def _rows(
    length: int, answers: Sequence[Decoded], seed: int
) -> list[tuple[str | float | Measure, ...]]:
    usable = np.array([(a.plain[0], a.clustered[0]) for a in answers], dtype=float)
    times = statistic_of(lambda units: _times(usable[units]), len(usable), seed)
    rows: list[tuple[str | float | Measure, ...]] = []
    for name, columns, factor in (
        ("plain", [a.plain for a in answers], Measure(1.0)),
        ("interpolated by clusters", [a.clustered for a in answers], times),
    ):
        values = np.array(columns, dtype=float)
        measured = (mean_of(values[:, 0], seed), mean_of(values[:, 1], seed))
        rows.append((str(length), name, *measured, factor))
    return rows


def _times(usable: FloatArray) -> float:
    """Second column's sum in the first's."""
    return float(usable[:, 1].sum() / max(usable[:, 0].sum(), 1.0))
