"""Knowledge as arrays by name and a plain record of its origin and words, and back.

Both the file of knowledge and the store use this form. The symmetric matrix of the word map is kept
as its upper triangle, the alignment tables end to end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.learn.knowledge import Knowledge, Origin, Taught
from motiondb.meaning.calibration import certainties_from, certainty_arrays
from motiondb.meaning.extents import ContextSpace
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import WordMoments
from motiondb.records import FloatArray, MotionSymbols, SymbolSpace
from motiondb.symbols.acquisition import AcquisitionSettings
from motiondb.symbols.feature_space import FeatureSpace

Arrays = Mapping[str, FloatArray]

_SPACE = ("distances", "variances", "coordinates", "stress", "clusters", "weights", "means")
_SYMBOLS = ("n_states", "self_loops", "means", "covars")
_CONTEXT = ("features", "mean", "projection")


def knowledge_arrays(knowledge: Knowledge) -> dict[str, FloatArray]:
    """The numbers of knowledge, as arrays by name; :func:`knowledge_from` is the inverse."""
    taught, space = knowledge.taught, knowledge.space
    arrays: dict[str, Any] = {
        "feature_mean": knowledge.feature_space.mean,
        "feature_projection": knowledge.feature_space.projection,
        "score_mean": knowledge.score_space.mean,
        "score_spread": knowledge.score_space.spread,
        "cutting": [knowledge.cutting.switch_cost, knowledge.cutting.shortest],
        **{f"symbol_{name}": getattr(knowledge.symbols, name) for name in _SYMBOLS},
        **{f"space_{name}": getattr(space, name) for name in (*_SPACE, "covars")},
        **_taught_arrays(taught),
    }
    if knowledge.context_space is not None:
        context = vars(knowledge.context_space)
        arrays |= {f"context_{name}": context[name] for name in _CONTEXT}
    arrays |= certainty_arrays(taught.certainties)
    return {name: np.asarray(values, dtype=np.float64) for name, values in arrays.items()}


def _taught_arrays(taught: Taught) -> dict[str, Any]:
    moments, expected = taught.moments, taught.expected
    shapes = sorted(expected.alignment)
    flat = [np.zeros(0), *(expected.alignment[shape].ravel() for shape in shapes)]
    return {
        "said": taught.said,
        "seconds": taught.seconds,
        "transitions": taught.transitions,
        "lengths": np.array(
            [(*shape, n) for shape, n in sorted(taught.shapes.items())], dtype=float
        ).reshape(-1, 3),
        "translation": expected.translation,
        "alignment_shapes": np.array(shapes, dtype=float).reshape(-1, 2),
        "alignment": np.concatenate(flat),
        "counted": [expected.n_pairs, moments.n],
        "moment_vectors": moments.vectors,
        "moment_words": moments.words,
        "moment_gram": moments.gram[np.triu_indices(len(moments.gram))],
        "moment_cross": moments.cross,
        "ridge": [taught.ridge],
        "calibration": taught.calibration,
        "information": taught.information,
    }


def knowledge_from(origin: Origin, words: tuple[str, ...], arrays: Arrays) -> Knowledge:
    """Knowledge from its arrays, its words and its origin."""
    switch_cost, shortest = arrays["cutting"]
    symbols = [arrays[f"symbol_{name}"] for name in _SYMBOLS[1:]]
    space = {name: arrays[f"space_{name}"] for name in (*_SPACE, "covars") if name != "clusters"}
    return Knowledge(
        origin=origin,
        feature_space=FeatureSpace(arrays["feature_mean"], arrays["feature_projection"]),
        symbols=MotionSymbols(arrays["symbol_n_states"].astype(np.int64), *symbols),
        cutting=replace(
            AcquisitionSettings(), switch_cost=float(switch_cost), shortest=int(shortest)
        ),
        space=SymbolSpace(clusters=arrays["space_clusters"].astype(np.int64), **space),
        score_space=ScoreSpace(arrays["score_mean"], arrays["score_spread"]),
        context_space=(
            ContextSpace(*(arrays[f"context_{name}"] for name in _CONTEXT))
            if "context_mean" in arrays
            else None
        ),
        taught=_taught_from(words, arrays),
    )


def _taught_from(words: tuple[str, ...], arrays: Arrays) -> Taught:
    shapes = [(int(length), int(m)) for length, m in arrays["alignment_shapes"]]
    ends = np.cumsum([m * (length + 1) for length, m in shapes])
    parts = np.split(arrays["alignment"], ends[:-1]) if shapes else []
    alignment = {(n, m): part.reshape(m, n + 1) for (n, m), part in zip(shapes, parts)}
    n_pairs, n_intervals = arrays["counted"]
    vectors = arrays["moment_vectors"]
    gram = np.zeros((len(vectors), len(vectors)))
    gram[np.triu_indices(len(vectors))] = arrays["moment_gram"]
    gram = gram + np.triu(gram, 1).T
    return Taught(
        words=words,
        said=arrays["said"].astype(np.int64),
        seconds=arrays["seconds"],
        transitions=arrays["transitions"],
        shapes={(int(n), int(m)): int(count) for n, m, count in arrays["lengths"]},
        expected=ExpectedCounts(arrays["translation"], alignment, int(n_pairs)),
        moments=WordMoments(
            float(n_intervals), vectors, arrays["moment_words"], gram, arrays["moment_cross"]
        ),
        ridge=float(arrays["ridge"][0]),
        calibration=arrays["calibration"],
        information=arrays["information"],
        certainties=certainties_from(arrays),
    )
