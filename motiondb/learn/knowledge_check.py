"""Whether arrays make sense as knowledge: shapes that agree, numbers within their ranges.

Files of knowledge may come from untrusted sources. Everything that learning with them relies on is
checked here: a file that passes may be useless, but it cannot make a calculation fail or run for
hours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import N_FEATURES
from motiondb.meaning.movement import block_sizes
from motiondb.records import FloatArray

MOST_SYMBOLS, MOST_STATES, MOST_DIMENSIONS = 1_000, 64, 64
"""Bounds on sizes, so that memory and time stay small. ``learn`` makes at most 240 symbols of 6
states in 24 dimensions."""
MOST_WORDS = 5_000  # Bound on the number of words
LONGEST = 400  # Bound on symbols and words of a described interval
LARGEST = 1e9  # Bound on every number

Arrays = Mapping[str, FloatArray]

OPTIONAL = frozenset(
    {
        "context_features",
        "context_mean",
        "context_projection",
        "certainty_words",
        "certainty_example",
        "certainty_interval",
        "certainty_single",
        "certainty_without",
        "certainty_without_part",
        "certainty_either",
        "certainty_either_part",
    }
)
"""Arrays that knowledge may lack."""


def array_faults(arrays: Arrays, n_words: int) -> list[str]:
    """The faults of the arrays of knowledge; empty for valid ones."""
    for step in (_names, _finite, _sizes, _shapes):
        faults = list(step(arrays, n_words))
        if faults:
            return faults
    return [*_ranges(arrays), *_tables(arrays)] or list(_equations(arrays))


def _names(arrays: Arrays, _n_words: int) -> Iterator[str]:
    expected = set(_expected(1, 1, 1, 1, 1))
    missing = expected - OPTIONAL - set(arrays)
    if missing:
        yield f"expected the array {min(missing)!r}, found none of this name"
    extra = set(arrays) - expected
    if extra:
        yield f"expected known arrays only, found {min(extra)!r}"
    context = {name for name in OPTIONAL if name.startswith("context")}
    if context & set(arrays) and not context <= set(arrays):
        yield f"expected all of {', '.join(sorted(context))}, found only some"


def _finite(arrays: Arrays, _n_words: int) -> Iterator[str]:
    for name, values in arrays.items():
        if name.startswith("certainty") and np.isnan(values[-1:]).all():
            values = values[:-1]  # a threshold may be unknown
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > LARGEST:
            yield f"expected finite numbers up to {LARGEST:g} in {name!r}, found others"


def _sizes(arrays: Arrays, n_words: int) -> Iterator[str]:
    means = arrays["symbol_means"]
    if means.ndim != 3:
        yield f"expected 'symbol_means' with 3 axes, found {means.ndim}"
        return
    bounds = (MOST_SYMBOLS, MOST_STATES, MOST_DIMENSIONS)
    names = ("symbols", "states", "dimensions")
    for what, size, most in zip(names, means.shape, bounds):
        if not 1 <= size <= most:
            yield f"expected 1 to {most} {what}, found {size}"
    if not 1 <= n_words <= MOST_WORDS:
        yield f"expected 1 to {MOST_WORDS} words, found {n_words}"
    if arrays["space_coordinates"].ndim != 2 or arrays["space_weights"].ndim != 1:
        yield "expected coordinates with 2 axes and weights of clusters with 1, found others"


def _shapes(arrays: Arrays, n_words: int) -> Iterator[str]:
    symbols, states, dims = arrays["symbol_means"].shape
    columns = len(np.atleast_1d(arrays["score_mean"]))
    axes = arrays["space_coordinates"].shape[1]
    expected = _expected(symbols, states, dims, columns, n_words)
    n_clusters = len(arrays["space_weights"])
    expected["space_coordinates"] = (symbols, axes)
    expected["space_means"] = (n_clusters, axes)
    expected["space_covars"] = (n_clusters, axes, axes)
    for name, shape in expected.items():
        if name not in arrays:
            continue
        actual = arrays[name].shape
        if len(actual) != len(shape) or any(
            want not in (-1, have) for want, have in zip(shape, actual)
        ):
            wanted = tuple("any" if n == -1 else n for n in shape)
            yield f"expected {name!r} of shape {wanted}, found {actual}"
    sizes = block_sizes(columns - symbols) if columns > symbols else ()
    if columns < symbols or sum(sizes) != columns - symbols:
        yield f"expected columns of movement after {symbols} symbols, found {columns - symbols}"


def _expected(
    symbols: int, states: int, dims: int, columns: int, words: int
) -> dict[str, tuple[int, ...]]:
    """Shapes by name; -1 stands for any size."""
    n, w = columns, words
    return {
        "feature_mean": (N_FEATURES,),
        "feature_projection": (N_FEATURES, dims),
        "score_mean": (n,),
        "score_spread": (n,),
        "cutting": (2,),
        "symbol_n_states": (symbols,),
        "symbol_self_loops": (symbols, states),
        "symbol_means": (symbols, states, dims),
        "symbol_covars": (symbols, states, dims),
        "space_distances": (symbols, symbols),
        "space_variances": (symbols, symbols),
        "space_coordinates": (symbols, -1),
        "space_stress": (-1,),
        "space_clusters": (symbols,),
        "space_weights": (-1,),
        "space_means": (-1, -1),
        "space_covars": (-1, -1, -1),
        "context_features": (N_FEATURES,),
        "context_mean": (2 * N_FEATURES,),
        "context_projection": (2 * N_FEATURES, -1),
        "said": (w,),
        "seconds": (w,),
        "transitions": (symbols + 1, symbols + 1),
        "lengths": (-1, 3),
        "translation": (symbols + 1, w),
        "alignment_shapes": (-1, 2),
        "alignment": (-1,),
        "counted": (2,),
        "moment_vectors": (n,),
        "moment_words": (w,),
        "moment_gram": (n * (n + 1) // 2,),
        "moment_cross": (n, w),
        "ridge": (1,),
        "calibration": (3,),
        "information": (3, 3),
        "certainty_words": (3,),
        "certainty_example": (4,),
        "certainty_interval": (10,),
        "certainty_single": (8,),
        "certainty_without": (4,),
        "certainty_without_part": (4,),
        "certainty_either": (3,),
        "certainty_either_part": (3,),
    }


def _ranges(arrays: Arrays) -> Iterator[str]:
    states = arrays["symbol_means"].shape[1]
    is_used = np.arange(states) < arrays["symbol_n_states"][:, None]
    n_clusters = len(arrays["space_weights"])
    covars, loops = arrays["symbol_covars"][is_used], arrays["symbol_self_loops"][is_used]
    whole: Callable[[FloatArray], bool] = lambda v: bool((v == np.rint(v)).all())  # noqa: E731
    said, intervals = arrays["said"], float(arrays["counted"][1])
    rules = [
        (
            _within(arrays["symbol_n_states"], 1, states) and whole(arrays["symbol_n_states"]),
            f"numbers of states from 1 to {states}",
        ),
        (_within(loops, 0.0, 1.0) and bool((loops < 1.0).all()), "self-loops from 0 to below 1"),
        (_within(covars, 1e-6, LARGEST), "variances of symbols above 0"),
        (_within(arrays["score_spread"], 1e-12, LARGEST), "spreads of scores above 0"),
        (_within(arrays["cutting"], 1, 1e6), "a switch cost and a shortest length of at least 1"),
        (
            _within(arrays["space_clusters"], 0, n_clusters - 1)
            and whole(arrays["space_clusters"]),
            "clusters that there are",
        ),
        (_within(arrays["space_distances"], 0.0, LARGEST), "distances of at least 0"),
        (_within(arrays["transitions"], 0.0, LARGEST), "counts of transitions of at least 0"),
        (_within(arrays["translation"], 0.0, LARGEST), "expected counts of at least 0"),
        (_within(said, 1, LARGEST) and whole(said), "words that some caption holds"),
        (_within(arrays["seconds"], 0.01, 1e5), "durations of actions above 0"),
        (_within(arrays["counted"], 1, LARGEST), "at least one described interval"),
        (
            _within(arrays["moment_words"], 0.0, intervals + 0.5),
            "no word in more intervals than there are",
        ),
        (_within(arrays["ridge"], 1e-3, 1e3), "a ridge from 0.001 to 1000"),
        (_within(arrays["calibration"][:1], 1e-3, 1e3), "a calibration that rises"),
    ]
    yield from (f"expected {what}, found others" for sound, what in rules if not sound)


def _within(values: FloatArray, low: float, high: float) -> bool:
    return bool(((values >= low) & (values <= high)).all())


def _tables(arrays: Arrays) -> Iterator[str]:
    """Faults of the tables of shapes (symbols l, words m)."""
    shapes: NDArray[np.float64] = arrays["alignment_shapes"]
    lengths = arrays["lengths"]
    pairs = np.concatenate([shapes, lengths[:, :2]])
    if not ((pairs >= 1) & (pairs <= LONGEST) & (pairs == np.rint(pairs))).all():
        yield f"expected intervals of 1 to {LONGEST} symbols and words, found others"
        return
    if len(np.unique(shapes, axis=0)) != len(shapes):
        yield "expected every shape of an alignment once, found one twice"
    cells = int((shapes[:, 1] * (shapes[:, 0] + 1)).sum())
    if cells != len(arrays["alignment"]):
        yield f"expected {cells} numbers in 'alignment', found {len(arrays['alignment'])}"
    if not _within(arrays["alignment"], 0.0, LARGEST):
        yield "expected counts of alignments of at least 0, found others"
    counts = lengths[:, 2]
    if not (_within(counts, 1, LARGEST) and (counts == np.rint(counts)).all()):
        yield "expected counts of intervals of at least 1, found others"


def _equations(arrays: Arrays) -> Iterator[str]:
    """Whether the systems of equations of the word map and of the calibration can be solved."""
    n, vectors = float(arrays["counted"][1]), arrays["moment_vectors"]
    if len(vectors) * (len(vectors) + 1) // 2 != len(arrays["moment_gram"]):
        return
    gram = np.zeros((len(vectors), len(vectors)))
    gram[np.triu_indices(len(vectors))] = arrays["moment_gram"]
    gram = gram + np.triu(gram, 1).T - np.outer(vectors, vectors) / n
    information = arrays["information"]
    try:
        np.linalg.cholesky(gram + 0.05 * np.eye(len(gram)))
        np.linalg.cholesky(0.5 * (information + information.T) + 1e-6 * np.eye(3))
    except np.linalg.LinAlgError:
        yield "expected sums of squares of score vectors, found a matrix that cannot be one"
