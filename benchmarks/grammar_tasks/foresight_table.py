"""Task ``foresight`` of ``benchmarks/grammar.py``: what foresees takes that are held out.

The takes of an activity are held out in up to five parts; two takes are cut in the middle. Nothing
is known of a part: clusters, their number and length, cuts into sentences, rules, and the weight of
the rules come from the other parts. Only the terminals of *whole actions*, with which pose runs are
compared, are found in all takes.

*Foreseen* is the share of windows of five terminals above 95 % of their shuffles; *strict* counts
only shuffles without equal neighbours, which runs never have. The finite state machine and ALERGIA
accept windows or do not; at *equal freedom* the share of windows is compared for which at most as
many shuffles are as probable as they accept of all. Intervals of 95 % are of 1000 draws of blocks
of ten windows in a row.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np

from grammar_tasks.recursive import _has_aalpy, alergia
from grammar_tasks.tables import table, table_rows
from motiondb.database.grammars.grammar_learning import default_terminals
from motiondb.grammar import foresight
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.foresight import ABOVE, String, Take
from motiondb.grammar.induction.induction import induce_quickly
from motiondb.grammar.languages import finite_state_grammar
from motiondb.grammar.pair_questions import PairQuestion, find_questions
from motiondb.grammar.sentences.partition import find_sentences
from motiondb.grammar.terminals.distances import pose_vectors
from motiondb.grammar.terminals.pose_runs import choose_clusters, divided, find_clusters
from motiondb.grammar.terminals.terminals import find_terminals, strings_of
from motiondb.records import FloatArray
from quality_protocol.captures import Capture, load_cmu

ACTIVITIES: dict[str, Callable[[Capture], bool]] = {
    "boxing": lambda c: c.name in ("14/14_02", "17/17_10"),
    "basketball": lambda c: c.performer == "06" and any("basketball" in s for s in c.captions),
    "kata": lambda c: c.performer == "135",
    "salsa": lambda c: c.performer == "60",
    "break-dance": lambda c: c.performer == "85",
    "Indian dance": lambda c: c.performer == "94",
}
BLOCK, DRAWS = 10, 1000  # Windows of a block, and draws, of the intervals
ASKED_TERMINALS, ASKED_SECONDS = 12, 0.65  # The middle of what is tried
HEADS = ["activity", "terminals", "model", "windows", "foreseen", "strict", "right of two",
         "accepts", "freedom", "motiondb at this freedom"]  # fmt: skip


def foresight_rows(data: Path, names: Sequence[str], known: str) -> str:
    """The section: every model on some of the activities; other rows are taken from ``known``."""
    rows: dict[str, list[list[str]]] = {}
    for row in table_rows(known):
        rows.setdefault(row[0], []).append(row)
    captures = load_cmu(data)
    for name in names:
        rows[name] = _activity([c for c in captures if ACTIVITIES[name](c)], name)
        for row in rows[name]:
            print("  " + " | ".join(row), flush=True)
    return table(HEADS, [row for name in ACTIVITIES for row in rows.get(name, [])])


def _activity(captures: Sequence[Capture], name: str) -> list[list[str]]:
    motions = [capture.motion for capture in captures]
    number = default_terminals(sum(motion.n_frames for motion in motions))
    actions = strings_of(find_terminals(motions, number, np.random.default_rng(0)))
    halves = [half for s in actions for half in (s[: len(s) // 2], s[len(s) // 2 :])]
    takes = [[string] for string in (halves if len(actions) < foresight.MOST_FOLDS else actions)]
    folds = np.array_split(np.random.default_rng(0).permutation(len(takes)), foresight.MOST_FOLDS)
    judged = [
        _ranks(
            _pairs([takes[n] for n in range(len(takes)) if n not in held]), [takes[n] for n in held]
        )
        for held in (fold.tolist() for fold in folds if len(fold))
    ]
    rows = [_row(name, f"whole actions ({number})", "pairs", np.concatenate(judged), None)]
    parts = divided([pose_vectors(motion) for motion in motions], np.random.default_rng(0))
    found: dict[str, list[FloatArray]] = {}
    sizes = []
    for held in parts:
        training = [take for part in parts if part is not held for take in part]
        clusters, _ = choose_clusters(training, np.random.default_rng(0))
        sizes.append(len(clusters.centres))
        strings = [clusters.string(take) for take in training]
        partition = find_sentences(strings, np.random.default_rng(0))
        cut = [
            [s[a:b] for a, b in pairwise((0, *inner, len(s)))]
            for s, inner in zip(strings, partition.cuts, strict=True)
        ]
        tested = [[clusters.string(take)] for take in held]
        for kind, model in _models(cut, partition.grammar).items():
            found.setdefault(kind, []).append(_ranks(model, tested))
    ours = np.concatenate(found["motiondb"])
    runs = f"pose runs ({min(sizes)} to {max(sizes)})"
    return rows + [_row(name, runs, kind, np.concatenate(f), ours) for kind, f in found.items()]


def _models(cut: Sequence[Take], grammar: Grammar) -> dict[str, foresight.Model]:
    """The models that are learned from a training part: its takes as sentences, and their rules."""
    inner = np.array_split(np.arange(len(cut)), min(3, len(cut)))[0].tolist()
    weight = foresight.choose_weight(induce_quickly, cut, inner)
    sentences = [tuple(sentence) for take in cut for sentence in take]
    models = {
        "motiondb": foresight.make_model(grammar, cut, weight),
        "pairs": _pairs(cut),
        "finite state machine": foresight.make_model(finite_state_grammar(sentences), cut, 1.0),
    }
    if _has_aalpy():
        models["ALERGIA"] = foresight.make_model(alergia(sentences), cut, 1.0)
    return models


def _pairs(
    takes: Sequence[Take], answers: Mapping[tuple[str, str], bool] = MappingProxyType({})
) -> foresight.Model:
    sentences = [tuple(sentence) for take in takes for sentence in take]
    return foresight.make_model(finite_state_grammar(sentences), takes, 0.0, answers)


def _ranks(model: foresight.Model, takes: Sequence[Take]) -> FloatArray:
    """Those of ``foresight.ranks``, and two columns with strict shuffles (NaN: there are none)."""
    windows = [w for take in takes for w in foresight.windows_of(foresight.passage(take))]
    strict = np.array([_strict(model, window) for window in windows]).reshape(-1, 1)
    return np.concatenate([foresight.ranks(model, windows), strict], axis=1)


def _strict(model: foresight.Model, window: String) -> float:
    orders = [o for o in foresight.shuffles_of(window) if all(a != b for a, b in pairwise(o))]
    own = model.log_probability(window)
    return (
        float(np.mean([model.log_probability(o) < own - 1e-9 for o in orders]))
        if orders
        else np.nan
    )


def ask_rows(data: Path) -> str:
    """The section of ``grammar ask``: pairs with the answers to ten questions.

    A held-out part is cut in two. A pair that its first half shows is answered with yes, one that
    it does not show after three of its first terminal with no, others are unknown; windows of the
    second half are judged. The others have answers of the whole part, as of somebody who knows
    it, to ten questions and to thirty.
    """
    rows = []
    captures = load_cmu(data)
    for name, is_one in ACTIVITIES.items():
        poses = [pose_vectors(capture.motion) for capture in captures if is_one(capture)]
        parts = divided(poses, np.random.default_rng(0))
        found: dict[str, list[bool]] = {"before": [], "half": [], "all": [], "thirty": []}
        for held in parts:
            training = [take for part in parts if part is not held for take in part]
            clusters = find_clusters(training, ASKED_TERMINALS, ASKED_SECONDS, 0)
            strings = [clusters.string(take) for take in training]
            names = [str(k) for k in range(ASKED_TERMINALS)]
            tested = [clusters.string(take) for take in held]
            halves = [(s[: len(s) // 2], s[len(s) // 2 :]) for s in tested]
            more = find_questions([[s] for s in strings], names, (), 30, repetitions=False)
            windows = [w for _, s in halves for w in foresight.windows_of(s)]
            for kind, known, asked in (
                ("before", [], more), ("half", [first for first, _ in halves], more[:10]),
                ("all", tested, more[:10]), ("thirty", tested, more),
            ):  # fmt: skip
                model = _pairs([[s] for s in strings], _answers(asked, known))
                found[kind] += (foresight.ranks(model, windows)[:, 0] > ABOVE).tolist()
        values = {kind: np.array(seen, float) for kind, seen in found.items()}
        cells = [f"{seen.mean():.2f}" for seen in values.values()]
        for kind in ("all", "thirty"):
            low, high = _interval(values[kind] - values["before"])
            cells.append(f"{low:+.2f} to {high:+.2f}")
        rows.append([name, str(len(values["before"])), *cells])
        print("  " + " | ".join(rows[-1]), flush=True)
    heads = ["activity", "windows", "before", "ten, answered by half", "ten", "thirty",
             "gain by ten", "gain by thirty"]  # fmt: skip
    said = f"{ASKED_TERMINALS} terminals of {ASKED_SECONDS} s; foreseen by smoothed pairs."
    return f"{table(heads, rows)}\n\n{said}"


def _answers(
    asked: Sequence[PairQuestion], strings: Sequence[String]
) -> dict[tuple[str, str], bool]:
    """What strings say about questions."""
    observed = Counter(pair for string in strings for pair in pairwise(string))
    often = Counter(symbol for string in strings for symbol in string[:-1])
    return {
        (one.first, one.then): observed[one.first, one.then] > 0
        for one in asked
        if observed[one.first, one.then] or often[one.first] >= 3
    }


def _row(
    name: str, terminals: str, kind: str, rows: FloatArray, ours: FloatArray | None
) -> list[str]:
    strict = rows[~np.isnan(rows[:, 4]), 4]
    accepts, freedom = rows[:, 2].mean(), rows[:, 3].mean()
    cells = [
        _with_interval((rows[:, 0] > ABOVE).astype(float)),
        f"{np.mean(strict > ABOVE):.2f}",
        f"{rows[:, 1].mean():.2f}",
        f"{accepts:.2f}",
        f"{freedom:.2f}",
    ]
    equal = ""
    if ours is not None and kind not in ("motiondb", "pairs"):
        gain = (1.0 - ours[:, 0] <= freedom).astype(float) - rows[:, 2]
        low, high = _interval(gain)
        equal = f"{np.mean(1.0 - ours[:, 0] <= freedom):.2f} ({low:+.2f} to {high:+.2f})"
    return [name, terminals, kind, str(len(rows)), *cells, equal]


def _with_interval(seen: FloatArray) -> str:
    low, high = _interval(seen)
    return f"{seen.mean():.2f} ({low:.2f} to {high:.2f})"


def _interval(values: FloatArray) -> tuple[float, float]:
    """The interval of 95 % of the mean, by draws of blocks."""
    blocks = np.array_split(values, max(1, len(values) // BLOCK))
    rng = np.random.default_rng(0)
    means = [
        np.concatenate([blocks[n] for n in rng.integers(len(blocks), size=len(blocks))]).mean()
        for _ in range(DRAWS)
    ]
    low, high = np.quantile(means, (0.025, 0.975)).tolist()
    return low, high
