"""Does it pay to write words in the suggested order? A simulation on real captures.

The captions of a part of the captures are hidden and shown one by one, in the order that
``motiondb words suggest`` gives and in random order; after each number of captions the word map is
solved, and every word is searched among the held-out captures. Symbols are
learned from all motion, words are known only from the revealed captions.

    python benchmarks/suggest.py --data DIR        # DIR holds cmu/ and cmu-captions.tsv
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb.learn.learned import Learned
from motiondb.meaning import counting
from motiondb.meaning.caption_evidence import whole_vectors
from motiondb.meaning.word_map import solve_word_map, word_moments
from motiondb.records import FloatArray, IntArray
from motiondb.search.suggestion import suggest

STEPS = (5, 10, 15, 20, 30, 40, 60, 80, 100)
"""Numbers of captions at which the curves are measured."""
RANDOM_ORDERS = 10
"""Random orders whose mean is compared."""
RIDGE = 1.0
"""Ridge of the word map, the same for both orders. Chosen by hand; not tuned."""
FIRST_SEED = 100
"""First split of the page; splits 0 to 11 were used to choose the method."""
LEAST = 2
"""A word takes part where it is written about this many captures on either side."""


@dataclass(frozen=True, eq=False)
class Captures:
    """vectors (n, symbols), presence (n, words), performers (n,) of the captures with words."""

    vectors: FloatArray
    presence: np.ndarray
    performers: np.ndarray


def load_captures(learned: Learned) -> Captures:
    """Captures with words, and the words of each."""
    captions = learned.captions
    described = counting.described_intervals(learned.segments, captions, learned.synonyms)
    words = sorted({word for d in described for word in d.words})
    number = {word: n for n, word in enumerate(words)}
    ids = sorted({d.capture_id for d in described})
    presence = np.zeros((len(ids), len(words)), dtype=bool)
    for d in described:
        presence[ids.index(d.capture_id), [number[w] for w in d.words]] = True
    performers = np.array([learned.captures[c].tags.get("performer", "") for c in ids])
    return Captures(
        whole_vectors(learned.standardised, learned.segments, {n: learned.rows[n] for n in ids}),
        presence, performers,
    )  # fmt: skip


def average_precisions(truth: np.ndarray, scores: FloatArray) -> FloatArray:
    """Average precision of every column: arrays (n, words) -> (words,)."""
    order = np.argsort(-scores, axis=0, kind="stable")
    hits = np.take_along_axis(truth, order, axis=0)
    precision = np.cumsum(hits, axis=0) / np.arange(1, len(hits) + 1)[:, None]
    return (precision * hits).sum(axis=0) / hits.sum(axis=0)


def curve(
    captures: Captures, order: IntArray, gallery: IntArray, words: IntArray, steps: Sequence[int]
) -> FloatArray:
    """Mean average precision after the first ``steps`` captions of an order."""
    precisions = []
    for n in steps:
        shown = order[:n]
        moments = word_moments(captures.vectors[shown], captures.presence[shown][:, words])
        fitted = solve_word_map(moments, RIDGE, np.array([1.0, 1.0, 0.0]))
        scores = fitted.evidence(captures.vectors[gallery])
        truth = captures.presence[gallery][:, words]
        precisions.append(float(average_precisions(truth, scores).mean()))
    return np.array(precisions)


def suggested_order(captures: Captures, pool: IntArray, n: int) -> IntArray:
    """The pool in the order of ``words suggest`` when nothing has words, the rest by number."""
    none = np.zeros((0, captures.vectors.shape[1]))
    first = [s.index for s in suggest(captures.vectors[pool], none, n)]
    rest = [i for i in range(len(pool)) if i not in set(first)]
    return pool[np.array(first + rest)]


def split_captures(captures: Captures, rng: np.random.Generator) -> np.ndarray:
    """A third of the captures is held out."""
    return rng.random(len(captures.vectors)) < 1 / 3


def split_performers(captures: Captures, rng: np.random.Generator) -> np.ndarray:
    """A third of the performers is held out."""
    everyone = rng.permutation(np.unique(captures.performers))
    return np.isin(captures.performers, everyone[: len(everyone) // 3])


def simulate(
    captures: Captures,
    split: Callable[[Captures, np.random.Generator], np.ndarray],
    seeds: int,
) -> tuple[FloatArray, FloatArray]:
    """Curves (seeds, steps) of the suggested order, and of the mean of random orders."""
    ours, chance = [], []
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        rng = np.random.default_rng(seed)
        held_out = split(captures, rng)
        pool, gallery = np.flatnonzero(~held_out), np.flatnonzero(held_out)
        inside, outside = captures.presence[pool].sum(0), captures.presence[gallery].sum(0)
        words = np.flatnonzero((inside >= LEAST) & (outside >= LEAST) & (outside < len(gallery)))
        if len(words) < 5 or len(pool) < STEPS[-1]:
            continue
        order = suggested_order(captures, pool, STEPS[-1])
        ours.append(curve(captures, order, gallery, words, STEPS))
        shuffled = [rng.permutation(pool) for _ in range(RANDOM_ORDERS)]
        chance.append(np.mean([curve(captures, o, gallery, words, STEPS) for o in shuffled], 0))
    return np.array(ours), np.array(chance)


def interval(values: FloatArray, rng: np.random.Generator) -> tuple[float, float]:
    """Bootstrap 95 % interval of the mean."""
    draws = rng.integers(len(values), size=(2000, len(values)))
    low, high = np.quantile(values[draws].mean(axis=1), [0.025, 0.975])
    return float(low), float(high)


def as_many(ours: FloatArray, chance: FloatArray, n: int) -> str:
    """The number of random captions with the same result as the first ``n`` suggested ones."""
    value = ours.mean(0)[STEPS.index(n)]
    mean = np.maximum.accumulate(chance.mean(0))
    if value > mean[-1]:
        return f"more than {STEPS[-1]}"
    return f"{np.interp(value, mean, STEPS):.0f}"


def verdict(ours: FloatArray, chance: FloatArray) -> str:
    """Whether the mean over all numbers of captions is above chance."""
    low, high = interval((ours - chance).mean(axis=1), np.random.default_rng(0))
    if low > 0:
        return "The suggested order is better than a random one."
    if high < 0:
        return "The suggested order is worse than a random one."
    return "The suggested order is no better and no worse than a random one."


def table(ours: FloatArray, chance: FloatArray) -> list[str]:
    """A Markdown table: captions, both orders, their difference with its paired interval."""
    rng = np.random.default_rng(0)
    lines = ["| captions | suggested | random | difference (95 %) |", "|---|---|---|---|"]
    for n, a, b in zip(STEPS, ours.T, chance.T):
        low, high = interval(a - b, rng)
        lines.append(
            f"| {n} | {a.mean():.3f} | {b.mean():.3f} | "
            f"{(a - b).mean():+.3f} ({low:+.3f} to {high:+.3f}) |"
        )
    a, b = ours.mean(axis=1), chance.mean(axis=1)
    low, high = interval(a - b, rng)
    lines.append(
        f"| mean | {a.mean():.3f} | {b.mean():.3f} | "
        f"{(a - b).mean():+.3f} ({low:+.3f} to {high:+.3f}) |"
    )
    return lines


def draw(curves: dict[str, tuple[FloatArray, FloatArray]], path: Path) -> None:
    """Both orders over the number of captions, a panel a split."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(curves), figsize=(9, 3.4), squeeze=False)
    for axis, (name, (ours, chance)) in zip(axes[0], curves.items()):
        for label, values, colour in (
            ("suggested", ours, "#1b6ca8"),
            ("random", chance, "#8a8a8a"),
        ):
            axis.plot(STEPS, values.mean(0), marker="o", ms=3, color=colour, label=label)
            error = values.std(0) / np.sqrt(len(values))
            axis.fill_between(
                STEPS, values.mean(0) - error, values.mean(0) + error, color=colour, alpha=0.2, lw=0
            )
        axis.set(title=name, xlabel="captions written", ylabel="mean average precision")
        axis.legend(frameon=False)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def report(curves: dict[str, tuple[FloatArray, FloatArray]], n: int, picture: str) -> str:
    """The page."""
    lines = [
        "# What to caption next",
        "",
        "`motiondb words suggest` ranks the captures without words by how much a caption of each "
        "would reduce the uncertainty about all of them (expected reduction of variance, greedy; "
        "see `motiondb/search/suggestion.py`). This page measures it on real captures.",
        "",
        f"Made by `python benchmarks/suggest.py --data DIR`. {n} captures of the CMU database with "
        "words; symbols learned from all motion, without words. A third of the captures is held "
        "out; captions of the others are revealed one by one. After each number of captions, "
        f"every word that describes at least {LEAST} captures on both sides is searched among the "
        f"held-out captures. Each random curve is the mean of {RANDOM_ORDERS} orders; intervals "
        "are paired, bootstrap over the splits. The splits share captures, so the intervals show "
        "the effect of the choice of the split, not of another database. Kernel and noise were "
        f"chosen on splits 0 to 11; this page uses splits from {FIRST_SEED} on.",
        "",
        f"![Mean average precision over the number of captions]({picture})",
    ]
    for name, (ours, chance) in curves.items():
        lines += ["", f"## {name} ({len(ours)} splits)", "", *table(ours, chance), ""]
        lines += [
            f"The first 30 suggested captions are worth {as_many(ours, chance, 30)} random ones, "
            f"the first 60 are worth {as_many(ours, chance, 60)}. {verdict(ours, chance)}"
        ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the simulation and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--db", type=Path, help="a database that has learned from the data")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--out", type=Path, default=Path("docs/suggest.md"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = options.db or Path(folder) / "captures.duckdb"
        with motiondb.open(path, read_only=options.db is not None) as db:
            if options.db is None:
                db.add(options.data / "cmu", options.data / "cmu-captions.tsv")
                db.learn()
            captures = load_captures(db.learned)
    curves = {
        "Other captures": simulate(captures, split_captures, options.seeds),
        "Other performers": simulate(captures, split_performers, options.seeds),
    }
    picture = options.out.parent / "pictures" / "suggest.png"
    draw(curves, picture)
    text = report(curves, len(captures.vectors), f"pictures/{picture.name}")
    options.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
