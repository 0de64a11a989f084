"""Certainty of a place: the probability that the interval reported for an action is right.

An interval is right if its intersection over union with the true one is at least ``RIGHT``, given
that the capture shows the action. If the take shows the action throughout, the true interval is the
whole take. With s the estimate that it does,

    p = s [interval covers half of the take] + (1 - s) p_several.

s tells short captures of one action from joins of several, mostly by their length: on the sample
data, with even evidence, it is .99 for takes of 2.5 seconds, .8 for 5, .3 for 8 and .004 for 20. A
long walk therefore counts as several actions. Both are logistic regressions
(:mod:`motiondb.meaning.regression`) on these cues, from the evidence e at the segments:

    p_several   the largest e in the interval; the same less the largest outside, at least 0 (only
                the order of a question can put an interval where e is smaller); the same less the
                lower quartile of the take; log(1 + other performers whose captions hold the words;
                of several words, the fewest); the share of the take that the interval covers; the
                logarithm of the number of segments
    s           the logarithms of the number of segments and of the seconds of the take; the
                largest e less the lower quartile, as an action shown throughout has even evidence

A cue of unknown sign is included with both signs, because no weight is negative.

They are learned without manual labels: short captures of one action, of one performer or of two,
are joined, and each action is searched in the joined take and in the short captures themselves, by
the map without the captures of its performers. An action whose words are in no other performer's
captions is not used, and gets no probability. The same action of the same performer in several
takes has the weight of one question together. Among sets of cues this one had the least log-loss on
performers left out of the CMU captures; one regression for both cases had .22 on Bandai-Namco
captures as they are, and .48 on those of CMU; two have .03 and .10.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning import by_question
from motiondb.meaning.by_question import lower_quartile
from motiondb.meaning.counting import capture_rows
from motiondb.meaning.place_fitting import (
    PlaceEvidence,
    Places,
    Written,
    fit_arrays,
    place_evidence,
)
from motiondb.meaning.place_map import PlaceMap
from motiondb.meaning.regression import Certainty, fit_probability, probability
from motiondb.meaning.score_vectors import Rows, interval_vectors, some_of
from motiondb.meaning.word_evidence import WINDOW_MARGIN, TakeScores
from motiondb.records import MOTION_FPS, FloatArray, IntArray, SegmentTable
from motiondb.symbols.hmm_jobs import one_blas_thread

# Smallest intersection over union of a right interval, as in ``docs/measured/quality.md``
RIGHT = 0.5
DRAWS, LEAST_DRAWS, MOST_DRAWN = 20, 2, 8_000
"""Number of draws in which every capture may be joined with others: more draws give more
combinations of actions, not more weight. Of many captures fewer draws are made, so that about
MOST_DRAWN are joined in all, which bounds the duration of learning."""
SINGLE = 2  # Number of the kind of questions about a capture as it is
LEAST_QUESTIONS = 30
"""Smallest number of questions in joined takes for which a certainty is fitted, as for answers
(``asked_certainty``)."""
SHORTEST, LONGEST = 2.0, 20.0
"""Largest duration of a capture that is joined, seconds: longer ones often show other actions
too."""
FEWEST_PARTS, MOST_PARTS = 3, 6
"""Number of captures in a joined take, about the number of exercises in a real long take."""
MOST_OF_PAIR, MOST_PAIRS = 18, 30
"""Number of captures of two performers that are joined in one draw, and of pairs of performers in
one draw; bounds on the duration of learning."""


@dataclass(frozen=True, eq=False)
class ShortCapture:
    """A short capture of one action."""

    standardised: Rows  # (segments, columns): standardised scores and movement
    starts: IntArray  # (segments,): first frames
    ends: IntArray  # (segments,): last frames + 1
    words: tuple[int, ...]  # Numbers of the words of its action
    group: str


@dataclass(frozen=True)
class JoinedPart:
    """One capture of a joined take."""

    start: int
    end: int  # Last frame + 1
    words: tuple[int, ...]  # Numbers of the words of its action
    group: str


@dataclass(frozen=True, eq=False)
class JoinedTake:
    """Joined short captures, and the interval of each."""

    standardised: FloatArray  # (segments, columns): standardised scores and movement
    starts: IntArray  # (segments,): first frames
    ends: IntArray  # (segments,): last frames + 1
    parts: tuple[JoinedPart, ...]  # The captures, in order

    @property
    def groups(self) -> frozenset[str]:
        """The performer."""
        return frozenset(part.group for part in self.parts)


@dataclass(frozen=True)
class PlaceQuestion:
    """An action that is searched in a joined take."""

    words: tuple[int, ...]  # Numbers of its words
    group: str  # Performer of the first capture of the action
    true: tuple[tuple[int, int], ...]  # Frames [start, end) that show it, neighbours joined


def short_captures(
    table: SegmentTable,
    standardised: Rows,
    written: Written,
    performers: Mapping[int, str],
) -> list[ShortCapture]:
    """Captures whose shortest caption names one action, of a length that can be joined.

    Shapes: `standardised` (segments, columns).
    """
    chosen = []
    for capture, rows in capture_rows(table).items():
        starts, ends = table.starts[rows], table.ends[rows]
        seconds = float(ends[-1] - starts[0]) / MOTION_FPS
        wholes = written.of_whole(capture)
        if not wholes or not SHORTEST <= seconds <= LONGEST or written.of_intervals(capture):
            continue
        actions = min(wholes, key=len)
        if len(actions) == 1:
            words = tuple(dict.fromkeys(actions[0]))
            own = some_of(standardised, rows)
            chosen.append(ShortCapture(own, starts, ends, words, performers[capture]))
    return chosen


def join(captures: Sequence[ShortCapture]) -> JoinedTake:
    """Captures one after another as one take; one capture is a take of one part."""
    starts, ends, parts, at = [], [], [], 0
    for capture in captures:
        shift = at - int(capture.starts[0])
        starts.append(capture.starts + shift)
        ends.append(capture.ends + shift)
        behind = int(ends[-1][-1])
        parts.append(JoinedPart(at, behind, capture.words, capture.group))
        at = behind
    return JoinedTake(
        np.concatenate([capture.standardised[:] for capture in captures]),
        np.concatenate(starts),
        np.concatenate(ends),
        tuple(parts),
    )


def join_captures(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Join captures of one performer in random order, each at most once."""
    takes = []
    for group in sorted({capture.group for capture in captures}):
        takes += _deal([capture for capture in captures if capture.group == group], rng)
    return takes


def join_pairs(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Join captures of two performers each, drawn at random, each capture at most once."""
    groups = sorted({capture.group for capture in captures})
    order = [groups[i] for i in rng.permutation(len(groups))]
    takes = []
    for pair in list(zip(order[::2], order[1::2]))[:MOST_PAIRS]:
        of_pair = [capture for capture in captures if capture.group in pair]
        some = [of_pair[i] for i in rng.permutation(len(of_pair))[:MOST_OF_PAIR]]
        takes += _deal(some, rng)
    return takes


def questions_of(take: JoinedTake) -> list[PlaceQuestion]:
    """Actions of a take with their true intervals, neighbours joined.

    An action that every part of a take shows is left out, because it has no place in it.
    """
    asked = []
    for words in dict.fromkeys(part.words for part in take.parts):
        true: list[tuple[int, int]] = []
        for part in take.parts:
            if set(words) <= set(part.words):
                low = part.start
                if true and true[-1][1] == low:
                    low = true.pop()[0]
                true.append((low, part.end))
        group = next(part.group for part in take.parts if part.words == words)
        if len(take.parts) == 1 or true[0] != (int(take.starts[0]), int(take.ends[-1])):
            asked.append(PlaceQuestion(words, group, tuple(true)))
    return asked


def union_share(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Intersection over union of two intervals.

    >>> union_share((0, 2), (1, 3))
    0.3333333333333333
    """
    shared = max(0, min(first[1], second[1]) - max(first[0], second[0]))
    return shared / (first[1] - first[0] + second[1] - second[0] - shared)


def _deal(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Takes of some captures in random order, each capture at most once."""
    left = [captures[i] for i in rng.permutation(len(captures))]
    takes = []
    while len(left) >= FEWEST_PARTS:
        n = min(int(rng.integers(FEWEST_PARTS, MOST_PARTS + 1)), len(left))
        takes.append(join(left[:n]))
        left = left[n:]
    return takes


@dataclass(frozen=True, eq=False)
class IntervalCues:
    """Cues of the interval reported for an action, as in the module's docstring."""

    several: FloatArray  # (8,): cues of p_several
    single: FloatArray  # (6,): cues of s
    covers: bool  # Whether the interval covers at least half of the take


@dataclass(frozen=True, eq=False)
class PlaceCertainty:
    """The two regressions."""

    several: Certainty
    single: Certainty  # s, from :func:`single_cues`; mostly by the length of the take

    def probability(self, cues: IntervalCues) -> float:
        """Probability that an interval is right."""
        among = float(probability(self.several.log_odds(cues.several)))
        alone = float(probability(self.single.log_odds(cues.single)))
        return alone * float(cues.covers) + (1.0 - alone) * among


@dataclass(frozen=True, eq=False)
class Judged:
    """One question: the cues of the reported interval, and whether it is right."""

    cues: IntervalCues
    right: bool
    # Performer, action, and kind of take, which is ``SINGLE`` for captures as they are
    kind: tuple[str, tuple[int, ...], int]


def count_performers(
    listed: Mapping[str, Collection[int]], words: Sequence[int], left_out: Collection[str]
) -> int:
    """Number of performers whose captions hold a word; of several words, the fewest.

    >>> count_performers({"ana": {0, 1}, "ben": {0}, "cai": {0, 1}}, [0, 1], ["cai"])
    1
    """
    others = [held for performer, held in listed.items() if performer not in left_out]
    return min(sum(word in held for held in others) for word in words)


def cues_of(evidence: FloatArray, first: int, behind: int, support: int) -> FloatArray:
    """Cues of the interval of segments [first, behind) reported for an action: array (8,).

    Shapes: `evidence` (segments,).
    """
    values = evidence.tolist()
    peak, low = max(values[first:behind]), lower_quartile(values)
    margin = max(peak - max([*values[:first], *values[behind:]], default=low), 0.0)
    share, length = (behind - first) / len(values), math.log(len(values))
    cues = [peak, margin, peak - low, math.log1p(support), share, length, -share, -length]
    return np.array(cues)


def single_cues(evidence: FloatArray, seconds: float) -> FloatArray:
    """Cues of s, mostly the length of the take: array (6,); `evidence` (segments,)."""
    values = evidence.tolist()
    contrast = max(values) - lower_quartile(values)
    signed = [math.log(len(values)), math.log(seconds), contrast]
    return np.array([*signed, *(-cue for cue in signed)])


def interval_cues(
    evidence: FloatArray, ends: IntArray, first: int, behind: int, support: int
) -> IntervalCues:
    """Cues of the interval of segments [first, behind) reported for an action.

    Shapes: `evidence`, `ends` (segments,).
    """
    start = int(ends[first - 1]) if first else 0
    return IntervalCues(
        cues_of(evidence, first, behind, support),
        single_cues(evidence, float(ends[-1]) / MOTION_FPS),
        2 * (int(ends[behind - 1]) - start) >= int(ends[-1]),
    )


def learn_certainty(
    table: SegmentTable,
    standardised: Rows,
    written: Written,
    places: Places,
    performers: Mapping[int, str],
    rng: np.random.Generator,
) -> PlaceCertainty | None:
    """Certainty of the place of an action; None if there are too few short captures.

    Shapes: `standardised` (segments, columns).
    """
    short = short_captures(table, standardised, written, performers)
    with one_blas_thread():  # many small systems
        rows, n_words = (table, standardised), len(written.numbers)
        arrays = fit_arrays(places, *rows, n_words, {})
        known = place_evidence(places, *rows, n_words, performers, arrays)
        return fit_certainty(short, known, rng)


def fit_certainty(
    captures: Sequence[ShortCapture], known: PlaceEvidence, rng: np.random.Generator
) -> PlaceCertainty | None:
    """Certainty of the place of an action; None if there are too few questions."""
    judged = [one for each in captures for one in judge(join([each]), known)]
    for _ in range(int(np.clip(MOST_DRAWN // max(len(captures), 1), LEAST_DRAWS, DRAWS))):
        for take in (*join_captures(captures, rng), *join_pairs(captures, rng)):
            judged += judge(take, known)
    joined = [one for one in judged if one.kind[2] != SINGLE]
    right = {one.right for one in joined}
    if len(joined) < LEAST_QUESTIONS or len(right) < 2 or len(joined) == len(judged):
        return None
    return PlaceCertainty(
        _regression([one.cues.several for one in joined], [one.right for one in joined], joined),
        _regression(
            [one.cues.single for one in judged], [one.kind[2] == SINGLE for one in judged], judged
        ),
    )


def _regression(
    cues: Sequence[FloatArray], true: Sequence[bool], judged: Sequence[Judged]
) -> Certainty:
    """Logistic regression in which the questions of one kind have the weight of one together."""
    times = Counter(one.kind for one in judged)
    counts = np.array([1.0 / times[one.kind] for one in judged])
    weights, constant = fit_probability(np.array(cues), np.array(true, dtype=bool), counts)
    return Certainty(weights, constant, float("nan"))


def judge(take: JoinedTake, known: PlaceEvidence) -> list[Judged]:
    """Search for every action of a take whose words occur in captions of other performers."""
    judged = []
    kind = min(len(take.parts), 2) + len(take.groups)  # 3 joined, 4 of two performers
    scores: TakeScores | None = None
    for asked in questions_of(take):
        support = count_performers(known.listed_by, asked.words, take.groups)
        if support:
            scores = scores or hear(take, known.without(take.groups))
            interval, cues = tell_place(scores, asked.words, support)
            best = max(union_share(interval, part) for part in asked.true)
            judged.append(Judged(cues, best >= RIGHT, (asked.group, asked.words, kind)))
    return judged


def hear(take: JoinedTake, fitted: PlaceMap) -> TakeScores:
    """The evidence for all words in a joined take."""
    vectors = interval_vectors(
        take.standardised,
        take.starts,
        take.ends,
        take.starts - WINDOW_MARGIN,
        take.ends + WINDOW_MARGIN,
    )
    evidence = fitted.evidence(vectors)
    return TakeScores(take.starts, take.ends, evidence, evidence.max(axis=0))


def tell_place(
    take: TakeScores, words: Sequence[int], support: int
) -> tuple[tuple[int, int], IntervalCues]:
    """The interval (frames) reported for an action, and its cues."""
    hit = by_question.search_order(take, [list(words)])
    assert hit is not None  # a take has a segment
    first = int(np.searchsorted(take.starts, hit.start))
    behind = int(np.searchsorted(take.ends, hit.end)) + 1
    of_words = take.windows[:, list(words)].mean(axis=1)
    cues = interval_cues(of_words, take.ends, first, behind, support)
    return (hit.start, hit.end), cues
