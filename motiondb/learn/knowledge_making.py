"""Knowledge from the model of a database, for other databases to start from.

It contains no motion and no caption: the symbols are models, captions enter only as sums over all
of them, and words are kept only as lemmas.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motiondb.errors import KnowledgeError, NotLearnedError
from motiondb.learn.knowledge import Knowledge, Origin, Taught
from motiondb.learn.learned import Learned
from motiondb.meaning import counting
from motiondb.meaning.word_map import calibration_information
from motiondb.records import MOTION_FPS, FloatArray

LEAST_CAPTIONS = 2
"""Smallest number of described intervals for an export: sums over one interval would reveal it."""


def make_knowledge(
    learned: Learned, name: str, runs: Sequence[Mapping[str, object]], credit: str, version: str
) -> Knowledge:
    """Everything that was learned, without motion and captions."""
    _check(learned)
    return Knowledge(
        origin=_origin(learned, name, runs, credit, version),
        feature_space=learned.feature_space,
        symbols=learned.symbols,
        cutting=learned.cutting,
        space=learned.space,
        score_space=learned.score_space,
        context_space=learned.context_space,
        taught=_taught(learned),
    )


def _check(learned: Learned) -> None:
    if learned.started is not None:
        raise KnowledgeError(
            f"{learned.source}: expected a database that learned from its own captures alone, "
            f"found one that started from {learned.started.knowledge.origin.name!r}. Run motiondb "
            "learn --start none first; its words are then learned from its captions only."
        )
    n = int(learned.counted.counts.moments.n)
    if learned.fitted_word_map is None or not learned.has_words:
        raise NotLearnedError(
            f"{learned.source}: expected captures with words, found none when it learned. "
            'Add words (motiondb words set CAPTURE "...") and run motiondb learn first.'
        )
    if n < LEAST_CAPTIONS:
        raise KnowledgeError(
            f"{learned.source}: expected at least {LEAST_CAPTIONS} described captures, found {n}. "
            "Describe more (motiondb words set) and run motiondb learn."
        )


def _origin(
    learned: Learned, name: str, runs: Sequence[Mapping[str, object]], credit: str, version: str
) -> Origin:
    infos = [learned.captures[c] for c in learned.rows if c in learned.captures]
    licences: dict[str, int] = {}
    for info in infos:
        licence = info.tags.get("licence", "") or "not given"
        licences[licence] = licences.get(licence, 0) + 1
    return Origin(
        name=name,
        version=version,
        captures=len(infos),
        captions=int(learned.counted.counts.moments.n),
        performers=len({i.tags["performer"] for i in infos if "performer" in i.tags}),
        seconds=round(sum(info.duration for info in infos), 2),
        licences=dict(sorted(licences.items())),
        runs=tuple(dict(run) for run in runs),
        credit=credit,
    )


def _taught(learned: Learned) -> Taught:
    counts, fit = learned.counted.counts, learned.word_map
    words = learned.association.words
    kept = np.flatnonzero(counts.said > 0)
    described = counting.known_only(list(learned.described), learned.word_numbers)
    vectors, _, _ = counting.training_rows(
        learned.segments, described, learned.score_space, learned.word_numbers
    )
    moments, expected = counts.moments, counts.expected
    return Taught(
        words=tuple(words[w] for w in kept),
        said=counts.said[kept],
        seconds=_seconds(learned, described)[kept],
        transitions=counts.transitions,
        shapes=dict(counts.shapes),
        expected=type(expected)(
            expected.translation[:, kept], expected.alignment, expected.n_pairs
        ),
        moments=moments.of_words(kept),
        ridge=fit.ridge,
        calibration=fit.calibration,
        information=calibration_information(fit, vectors),
        certainties=learned.certainties,
    )


def _seconds(learned: Learned, described: Sequence[counting.Described]) -> FloatArray:
    """Median duration of an action that captions describe with each word: array (words,)."""
    lengths: dict[str, list[float]] = {}
    for d in described:
        for word in set(d.words):
            lengths.setdefault(word, []).append((d.end - d.start) / d.n_actions / MOTION_FPS)
    usual = float(np.median([s for each in lengths.values() for s in each]))
    words = learned.association.words
    return np.array([max(float(np.median(lengths.get(w, [usual]))), 0.01) for w in words])
