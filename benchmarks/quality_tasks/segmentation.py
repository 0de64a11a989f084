"""Segmentation without labels: the four long takes, and captures joined with known cuts.

Every method sees one take at a time, its motion alone. motiondb groups it into activities
(``symbols.activities``), with its own number of them and with the true one; the baselines are given
the true number. Whatever draws random numbers is run with ``N_SEEDS`` seeds, and their mean counts.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from motiondb.body.features import FEATURE_FPS
from motiondb.records import FloatArray, IntArray
from motiondb.symbols import activities, feature_space
from motiondb.symbols.segmentation import context
from quality_protocol.captures import Capture, load_cmu
from quality_protocol.confidence import mean_of
from quality_protocol.report import Measure, TaskReport
from quality_protocol.takes import LongTake, agreement, load_takes, make_take

WINDOW = 31
"""Feature frames (2 s) of the baselines' windows."""
N_JOINED = 16
"""Joined takes. Chosen by hand for the time that it takes."""
N_SEEDS = 3
"""Seeds over which random methods are averaged."""
SHORT, LONG = 45, 120
"""Feature frames that a joined part lasts."""

Method = Callable[[FloatArray, int | None, int], IntArray]
"""Values (frames, n), number of groups, seed -> label of every frame."""


def run(data: Path, seed: int) -> TaskReport:
    """Four long takes and joined captures, five methods."""
    captures = load_cmu(data)
    space = feature_space.fit_feature_space([c.features for c in captures])
    takes = load_takes(data, captures)
    joined = join_captures(captures, {t.capture.name for t in takes}, seed)
    parts = (_report("Joined captures", _joined_protocol(joined), joined, space, seed),)
    report = _report(
        "Segmentation without labels",
        "The four long takes, without labels. Frame accuracy after the best one-to-one matching "
        "of groups and labels, purity, and F1 of changes at +-0.5 s; means over takes and three "
        "seeds, with 95 % intervals over takes. *Own number*: motiondb chooses the number of "
        "activities; *true number*: it is given. Baselines work on windows of 2 s (mean and "
        "spread of whitened features) and are given the true number. motiondb's windows, "
        "mixtures and rounds were chosen on other joined captures (32 of CMU, 14 of "
        "Bandai-Namco). The cost of one more activity is that of BIC; results with other costs "
        "were known when it was chosen, so the first row is slightly optimistic.",
        takes,
        space,
        seed,
    )
    return TaskReport(
        report.title, report.protocol, report.columns, report.rows, _notes(takes, seed), (), parts
    )


def by_activities(features: FloatArray, n_activities: int | None, seed: int) -> IntArray:
    """motiondb's activities as a label per frame."""
    rng = np.random.default_rng(seed)
    labels = np.empty(len(features), dtype=np.int64)
    for start, end, activity in activities.find_activities(features, rng, n_activities):
        labels[start:end] = activity
    return labels


def by_kmeans(windows: FloatArray, n_groups: int | None, seed: int) -> IntArray:
    """k-means on windows."""
    from sklearn.cluster import KMeans

    return KMeans(n_groups, n_init=10, random_state=seed).fit_predict(windows).astype(np.int64)


def by_gaussian_hmm(windows: FloatArray, n_groups: int | None, seed: int) -> IntArray:
    """hmmlearn's Gaussian HMM, one state a group, on the windows' first axes."""
    from hmmlearn.hmm import GaussianHMM

    centred = windows - windows.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2][:16]
    logging.getLogger("hmmlearn").setLevel(logging.ERROR)
    model = GaussianHMM(n_groups, covariance_type="diag", n_iter=50, random_state=seed)
    values = centred @ axes.T
    return np.asarray(model.fit(values).predict(values), dtype=np.int64)


def by_change_points(windows: FloatArray, n_groups: int | None, _seed: int) -> IntArray:
    """Kernel change points (ruptures, radial basis), the parts' means clustered."""
    import ruptures
    from sklearn.cluster import AgglomerativeClustering

    thinned = windows[::3]
    penalty = 2.0 * np.log(len(thinned))
    ends = ruptures.KernelCPD(kernel="rbf", min_size=7).fit(thinned).predict(pen=penalty)
    cuts = [0, *(3 * c for c in ends[:-1]), len(windows)]
    labels = np.repeat(np.arange(len(cuts) - 1), np.diff(cuts))
    if n_groups and len(cuts) - 1 > n_groups:
        means = np.array([windows[a:b].mean(axis=0) for a, b in pairwise(cuts)])
        groups = AgglomerativeClustering(n_groups).fit_predict(means)
        labels = groups[labels]
    return labels.astype(np.int64)


METHODS: dict[str, tuple[Method, bool, bool]] = {
    "motiondb, own number": (by_activities, False, False),
    "motiondb, true number": (by_activities, False, True),
    "k-means on 2 s windows, true number": (by_kmeans, True, True),
    "Gaussian HMM (hmmlearn), true number": (by_gaussian_hmm, True, True),
    "kernel change points (ruptures) + clustering, true number": (by_change_points, True, True),
}
"""Method, whether it uses windows, whether it is given the true number."""


def join_captures(captures: Sequence[Capture], left_out: set[str], seed: int) -> list[LongTake]:
    """Parts of three or four differently described captures of one performer, in a row, some of
    them twice; the label is the capture."""
    rng = np.random.default_rng(seed + 5)
    of: dict[str, list[Capture]] = {}
    for c in captures:
        if c.name not in left_out and c.captions and len(c.features) >= 60:
            of.setdefault(c.performer, []).append(c)
    performers = sorted(p for p, captures_of in of.items() if len(captures_of) >= 5)
    joined = []
    for number in range(N_JOINED):
        captures_of = of[performers[number % len(performers)]]
        chosen: list[Capture] = []
        for n in rng.permutation(len(captures_of)):
            if all(
                captures_of[n].captions[0].lower()[:6] != c.captions[0].lower()[:6] for c in chosen
            ):
                chosen.append(captures_of[n])
            if len(chosen) == 4:
                break
        if len(chosen) >= 3:
            joined.append(_join(chosen, rng))
    return joined


def _join(chosen: Sequence[Capture], rng: np.random.Generator) -> LongTake:
    order = [*range(len(chosen)), *rng.permutation(len(chosen))[:3].tolist()]
    pieces, parts, at = [], [], 0
    for before, k in zip([-1, *order], order):
        if k == before:
            continue
        features = chosen[k].features
        length = min(int(rng.integers(SHORT, LONG)), len(features))
        first = int(rng.integers(0, len(features) - length + 1))
        pieces.append(features[first : first + length])
        parts.append((at / FEATURE_FPS, (at + length) / FEATURE_FPS, chosen[k].name))
        at += length
    motion = chosen[0].motion
    capture = Capture("joined", chosen[0].performer, (), "", motion, np.concatenate(pieces))
    return make_take(capture, parts)


def _report(
    title: str,
    protocol: str,
    takes: Sequence[LongTake],
    space: feature_space.FeatureSpace,
    seed: int,
) -> TaskReport:
    rows: list[tuple[str | float | Measure, ...]] = []
    for name, method in METHODS.items():
        values = [
            np.mean([_judge(take, method, space, seed + n) for n in range(N_SEEDS)], axis=0)
            for take in takes
        ]
        rows.append((name, *_measures(values, seed)))
    columns = ("method", "frame accuracy", "purity", "boundary F1", "groups found - true")
    return TaskReport(title, protocol, columns, tuple(rows))


def _judge(
    take: LongTake,
    method: tuple[Method, bool, bool],
    space: feature_space.FeatureSpace,
    seed: int,
) -> tuple[float, float, float, float]:
    find, on_windows, is_told = method
    values = np.asarray(take.capture.features, dtype=float)
    if on_windows:
        values = context(space.project(take.capture.features).astype(float), WINDOW)
    n_true = int(take.labels.max()) + 1
    result = find(values, n_true if is_told else None, seed)
    return (*agreement(take.labels, result), float(len(np.unique(result)) - n_true))


def _measures(values: Sequence[FloatArray], seed: int) -> tuple[Measure, ...]:
    return tuple(mean_of(column, seed) for column in zip(*values))


def _joined_protocol(joined: Sequence[LongTake]) -> str:
    return (
        f"{len(joined)} takes joined from three or four captures of one performer, cut and "
        f"repeated at random. The label of a part is its capture, though a capture may show "
        f"several activities."
    )


def _notes(takes: Sequence[LongTake], seed: int) -> tuple[str, ...]:
    """The activities that motiondb found in every take, with the true ones."""
    notes = []
    for take in takes:
        ours, true = (
            activities.find_activities(take.capture.features, np.random.default_rng(seed), k)
            for k in (None, int(take.labels.max()) + 1)
        )
        notes.append(
            f"{take.capture.name}: true {_list_parts(take)}; true number "
            f"{_list_runs(true)}; own number {_list_runs(ours)}."
        )
    return tuple(notes)


def _list_parts(take: LongTake) -> str:
    return ", ".join(f"{label} {a:.1f}-{b:.1f}" for a, b, label in take.parts)


def _list_runs(runs: Sequence[tuple[int, int, int]]) -> str:
    return ", ".join(f"{k} {a / FEATURE_FPS:.1f}-{b / FEATURE_FPS:.1f}" for a, b, k in runs)


if __name__ == "__main__":
    import sys

    from quality_protocol.report import to_markdown

    print(to_markdown(run(Path(sys.argv[1]), 0)))
