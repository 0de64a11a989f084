"""Learning in the order of names, so that it does not depend on the order of arrival.

Captures have numbers in the order in which they were added, and much of learning goes through them
in order of number: random starts, sums, ties. While it learns, the captures therefore exchange
numbers: the first by name has the smallest. Where they were added in the order of their names,
nothing changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.recognition import FeaturePool
from motiondb.learn.word_fitting import TaughtWords
from motiondb.meaning.place_fitting import Places
from motiondb.records import IntArray

T = TypeVar("T")


def numbers_by_name(names: Mapping[int, str]) -> dict[int, int]:
    """Capture number -> its number while learning, from the names by number.

    >>> numbers_by_name({3: "b", 5: "a", 9: "c"})
    {5: 3, 3: 5, 9: 9}
    """
    return dict(zip(sorted(names, key=lambda capture: names[capture]), sorted(names)))


def renumber_taught(taught: TaughtWords, numbers: Mapping[int, int]) -> TaughtWords:
    """Captions and performers under other numbers."""
    return TaughtWords(
        _renumber(taught.captions, numbers), taught.synonyms, _renumber(taught.performers, numbers)
    )


def renumber_pool(pool: FeaturePool, numbers: Mapping[int, int]) -> FeaturePool:
    """Features under other numbers, in their order."""
    captures = np.array([numbers[int(c)] for c in pool.capture_ids], dtype=np.int64)
    if np.array_equal(captures, pool.capture_ids):
        return pool
    order = np.argsort(captures)
    parts = [slice(a, b) for a, b in pairwise(pool.bounds)]
    return FeaturePool(
        captures[order],
        np.concatenate([[0], np.cumsum(np.diff(pool.bounds)[order])]).astype(np.int64),
        np.concatenate([pool.features[parts[n]] for n in order]),
        np.asarray(pool.lengths)[order],
    )


def renumber_model(model: LearnedModel, numbers: Mapping[int, int]) -> LearnedModel:
    """The learned model under other numbers of captures."""
    captures = _renumber_all(model.segments.capture_ids, numbers)
    order = np.argsort(captures, kind="stable")
    rows = {name: column[order] for name, column in vars(model.segments).items()}
    places = model.places
    return replace(
        model,
        segments=replace(model.segments, **rows | {"capture_ids": captures[order]}),
        drift_baseline=replace(
            model.drift_baseline,
            captures=np.sort(_renumber_all(model.drift_baseline.captures, numbers)),
        ),
        places=None
        if places is None
        else Places(**{name: _renumber(of_one, numbers) for name, of_one in vars(places).items()}),
    )


def _renumber_all(captures: IntArray, numbers: Mapping[int, int]) -> IntArray:
    return np.array([numbers[int(capture)] for capture in captures], dtype=np.int64)


def _renumber(values: Mapping[int, T], numbers: Mapping[int, int]) -> dict[int, T]:
    """Values by capture under other numbers, rising."""
    renamed = {numbers[capture]: value for capture, value in values.items()}
    return {capture: renamed[capture] for capture in sorted(renamed)}
