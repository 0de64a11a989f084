"""How sure a place is: the probability that the interval told for an action is the right one.

A word map says whether a capture shows an action; this says, where it does, whether the interval
that is told for it is right (intersection over union with the true one at least ``RIGHT``). It is
learned from questions whose true intervals are known without anybody marking them: short captures
of one action are put one after another, and each action is asked of the joined take. As many
questions are of the short captures themselves, where the whole is the truth. Every question is
judged by the map without the captures of its performer.

Cues of a told interval, of the evidence e at the segments of the take:

    the largest e in the interval,
    the largest e in the interval less the largest outside,
    the largest e in the interval less the lower quartile of the take,
    the share of the take that the interval covers,
    the logarithm of the number of segments.

Logistic regression (:mod:`motiondb.search.certainty`) weights them. It allows no negative weights,
so every cue whose sign is not known beforehand stands there twice, once with its sign turned. The
square of the share and products of cues made answers no surer on performers left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.learning import place_fitting
from motiondb.learning.counting import capture_rows
from motiondb.learning.place_fitting import Places, Written
from motiondb.records import MOTION_FPS, FloatArray, IntArray, SegmentTable
from motiondb.search.certainty import Certainty, fit_probability
from motiondb.search.questions import by_words
from motiondb.search.questions.by_words import WINDOW_MARGIN, TakeScores, lower_quartile
from motiondb.search.vectors.score_vectors import interval_vectors
from motiondb.symbols.models.hmm_jobs import one_blas_thread
from motiondb.words.maps.place_map import PlaceMap, fit_places

RIGHT = 0.5
"""Intersection over union from which on an interval is right, as in ``docs/quality.md``."""
SHORTEST, LONGEST = 2.0, 20.0
"""Seconds of a capture that can be joined: longer ones of one action often hold others too. Chosen
by hand; not tuned."""
FEWEST_PARTS, MOST_PARTS = 3, 6
"""Captures in a joined take, about as many as a real long take has exercises. Chosen by hand."""
DRAWS = 4
"""How often every capture may be joined with others: more draws give more questions. Chosen by
hand; not tuned."""
LEAST_QUESTIONS = 30
"""Questions below which nothing is fitted, as for answers (``asked_certainty``)."""


@dataclass(frozen=True, eq=False)
class ShortCapture:
    """A short capture of one action.

    Attributes
    ----------
    standardised : array (segments, columns)
        Standardised scores and movement.
    starts : array (segments,)
        First frames.
    ends : array (segments,)
        Last frames + 1.
    words : tuple of int
        Numbers of the words of its action.
    group : str
        Who performs.
    """

    standardised: FloatArray
    starts: IntArray
    ends: IntArray
    words: tuple[int, ...]
    group: str


@dataclass(frozen=True, eq=False)
class JoinedTake:
    """Short captures of one performer one after another, and where each lies.

    Attributes
    ----------
    standardised : array (segments, columns)
        Standardised scores and movement.
    starts : array (segments,)
        First frames.
    ends : array (segments,)
        Last frames + 1.
    parts : tuple of (int, int, tuple of int)
        First frame, last frame + 1, and words of every capture.
    group : str
        Who performs.
    """

    standardised: FloatArray
    starts: IntArray
    ends: IntArray
    parts: tuple[tuple[int, int, tuple[int, ...]], ...]
    group: str


@dataclass(frozen=True, eq=False)
class Judged:
    """One question: the cues of the interval that was told, and whether it is right."""

    cues: FloatArray
    right: bool


def cues_of(evidence: FloatArray, first: int, behind: int) -> FloatArray:
    """Cues of the interval of segments [first, behind) told for an action: array (7,).

    Parameters
    ----------
    evidence : array (segments,)
        Evidence for the action at every segment of the take.
    first : int
        First segment of the interval.
    behind : int
        Last segment + 1.
    """
    inside = evidence[first:behind]
    outside = np.concatenate([evidence[:first], evidence[behind:]])
    peak, low = float(inside.max()), lower_quartile(evidence)
    margin = peak - (float(outside.max()) if len(outside) else low)
    share = (behind - first) / len(evidence)
    signed = np.array([share, np.log(len(evidence))])
    return np.concatenate([[peak, margin, peak - low], signed, -signed])


def learn_certainty(
    table: SegmentTable,
    standardised: FloatArray,
    written: Written,
    places: Places,
    performers: Mapping[int, str],
    rng: np.random.Generator,
) -> Certainty | None:
    """How sure the place of an action is; None where too few short captures tell.

    Parameters
    ----------
    table : SegmentTable
        Segments of all captures.
    standardised : array (segments, columns)
        Standardised scores and movement of all segments.
    written : Written
        Captions and the vocabulary.
    places : Places
        Where the actions of captions happen.
    performers : dict
        Capture number -> who performs.
    rng : numpy.random.Generator
        Draws which captures are joined.
    """
    n_words = len(written.numbers)
    captures, takes, shown = place_fitting.placed_takes(places, table, standardised, n_words)
    groups = [performers[c] for c in captures]
    short = short_captures(table, standardised, written, performers)
    short = [c for c in short if _is_shown_elsewhere(c, places, performers)]
    owners = np.array(groups)[takes.owners]
    with one_blas_thread():  # many small systems
        fit = fit_places(takes, shown)
        maps = {g: fit.without(np.flatnonzero(owners == g)) for g in {c.group for c in short}}
        return fit_certainty(short, maps, rng)


def fit_certainty(
    captures: Sequence[ShortCapture], maps: Mapping[str, PlaceMap], rng: np.random.Generator
) -> Certainty | None:
    """How sure the place of an action is; None where too few questions tell.

    Parameters
    ----------
    captures : sequence of ShortCapture
        Captures of one action.
    maps : dict
        Performer -> the map without the captures of this performer.
    rng : numpy.random.Generator
        Draws which captures are joined, and which are asked as they are.
    """
    judged: list[Judged] = []
    for _ in range(DRAWS):
        joined = [
            one for take in join_captures(captures, rng) for one in judge(take, maps[take.group])
        ]
        some = rng.permutation(len(captures))[: len(joined)]
        whole = [captures[i] for i in sorted(some)]
        judged += joined
        judged += [one for each in whole for one in judge(join([each]), maps[each.group])]
    right = np.array([one.right for one in judged], dtype=bool)
    if len(right) < LEAST_QUESTIONS or right.all() or not right.any():
        return None
    weights, constant = fit_probability(np.array([one.cues for one in judged]), right)
    return Certainty(weights, constant, float("nan"))


def short_captures(
    table: SegmentTable,
    standardised: FloatArray,
    written: Written,
    performers: Mapping[int, str],
) -> list[ShortCapture]:
    """Captures whose shortest caption names one action, of a length that can be joined.

    Parameters
    ----------
    table : SegmentTable
        Segments of all captures.
    standardised : array (segments, columns)
        Standardised scores and movement.
    written : Written
        Actions that captions list.
    performers : dict
        Capture number -> who performs.
    """
    found = []
    for capture, rows in capture_rows(table).items():
        starts, ends = table.starts[rows], table.ends[rows]
        seconds = float(ends[-1] - starts[0]) / MOTION_FPS
        wholes = written.of_whole(capture)
        if not wholes or not SHORTEST <= seconds <= LONGEST or written.of_intervals(capture):
            continue
        actions = min(wholes, key=len)
        if len(actions) == 1:
            words = tuple(dict.fromkeys(actions[0]))
            found.append(ShortCapture(standardised[rows], starts, ends, words, performers[capture]))
    return found


def join_captures(captures: Sequence[ShortCapture], rng: np.random.Generator) -> list[JoinedTake]:
    """Join captures of one performer in random order, each at most once."""
    takes = []
    for group in sorted({capture.group for capture in captures}):
        own = [capture for capture in captures if capture.group == group]
        left = [own[i] for i in rng.permutation(len(own))]
        while len(left) >= FEWEST_PARTS:
            n = min(int(rng.integers(FEWEST_PARTS, MOST_PARTS + 1)), len(left))
            takes.append(join(left[:n]))
            left = left[n:]
    return takes


def questions_of(take: JoinedTake) -> list[tuple[tuple[int, ...], list[tuple[int, int]]]]:
    """Actions of a take with their true intervals, neighbours joined.

    An action that all of a take of several parts shows is left out: it has no place.
    """
    asked = []
    for words in dict.fromkeys(words for _, _, words in take.parts):
        true: list[tuple[int, int]] = []
        for low, high, said in take.parts:
            if set(words) <= set(said):
                if true and true[-1][1] == low:
                    low = true.pop()[0]
                true.append((low, high))
        if len(take.parts) == 1 or true[0] != (int(take.starts[0]), int(take.ends[-1])):
            asked.append((words, true))
    return asked


def judge(take: JoinedTake, fitted: PlaceMap) -> list[Judged]:
    """Ask every action of a take."""
    judged = []
    for words, true in questions_of(take):
        told, cues = tell_place(take, words, fitted)
        best = max(union_share(told, part) for part in true)
        judged.append(Judged(cues, best >= RIGHT))
    return judged


def tell_place(
    take: JoinedTake, words: Sequence[int], fitted: PlaceMap
) -> tuple[tuple[int, int], FloatArray]:
    """The interval (frames) that is told for an action, and its cues."""
    vectors = interval_vectors(
        take.standardised, take.starts, take.ends, take.starts - WINDOW_MARGIN,
        take.ends + WINDOW_MARGIN,
    )  # fmt: skip
    evidence = fitted.evidence(vectors)
    hit = by_words.search_take(
        TakeScores(take.starts, take.ends, evidence, evidence.max(axis=0)), [list(words)]
    )
    assert hit is not None  # a take has a segment
    first = int(np.searchsorted(take.starts, hit.start))
    behind = int(np.searchsorted(take.ends, hit.end)) + 1
    return (hit.start, hit.end), cues_of(evidence[:, list(words)].mean(axis=1), first, behind)


def union_share(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Intersection over union of two intervals.

    >>> union_share((0, 2), (1, 3))
    0.3333333333333333
    """
    shared = max(0, min(first[1], second[1]) - max(first[0], second[0]))
    return shared / (first[1] - first[0] + second[1] - second[0] - shared)


def _is_shown_elsewhere(
    capture: ShortCapture, places: Places, performers: Mapping[int, str]
) -> bool:
    """Whether captions of other performers hold all words of a capture's action."""
    others = (places.words[c] for c in places.words if performers[c] != capture.group)
    return set(capture.words) <= {word for words in others for word in words}


def join(captures: Sequence[ShortCapture]) -> JoinedTake:
    """Captures of one performer one after another as one take; one is a take of one part."""
    starts, ends, parts, at = [], [], [], 0
    for capture in captures:
        shift = at - int(capture.starts[0])
        starts.append(capture.starts + shift)
        ends.append(capture.ends + shift)
        behind = int(ends[-1][-1])
        parts.append((at, behind, capture.words))
        at = behind
    return JoinedTake(
        np.concatenate([capture.standardised for capture in captures]), np.concatenate(starts),
        np.concatenate(ends), tuple(parts), captures[0].group,
    )  # fmt: skip
