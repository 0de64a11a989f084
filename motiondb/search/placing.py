"""Where an answer shows each part of a question, with its certainty.

The word map determines which captures answer, and their scores
(:mod:`motiondb.meaning.by_question`). The position in the capture follows from the evidence of
places (:mod:`motiondb.meaning.place_fitting`) and the captions of intervals. Two probabilities
belong to a part: that the capture shows it, and that the interval does, which is the first times
the probability that the place is right where the capture shows it
(:mod:`motiondb.meaning.place_certainty`). The second is that of the interval before its boundaries
are refined; an interval that is the whole take has the probability of the take.

The place is unknown under two conditions: the interval is more likely wrong than right, or no other
capture's captions list the words; and a caption of the whole capture is the only evidence for the
part, which by the motion alone is more likely not shown.

The evidence for each frame (:mod:`motiondb.meaning.edge_map`) gives actions in order their
intervals, because a short take is one segment; they have no probability. Other intervals end where
this evidence falls to half of its peak, so that a short action has the boundaries of the movement
and not of the segments. If more than ``NARROW`` of the interval would remain, it is not narrowed:
then it shows one long activity, and not a short action with something else around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.language.question.readings import Part, Reading, is_order
from motiondb.meaning import by_question
from motiondb.meaning.by_question import PlacedReading, QuestionHit
from motiondb.meaning.edge_map import HALF, around_half, lay_in_order
from motiondb.meaning.place_certainty import PlaceCertainty, count_performers, interval_cues
from motiondb.records import FloatArray
from motiondb.search.asked_words import AskedWords
from motiondb.search.chances import LIKELY, PartChance
from motiondb.search.seen_frames import SeenFrames

AROUND = 15  # Feature frames (1 s) around the segments of an order that may belong to it
NARROW = 0.6
"""Largest share of its interval that a short action fills. An activity that fills more keeps the
boundaries of segments: people mark its preparation and its end as parts of it. Chosen among .3 to
.7 with the marked actions and the parts of long takes in view (``docs/measured/quality.md``,
"Boundaries of short actions" and "By word")."""


@dataclass(frozen=True)
class PartPlace:
    """Where a capture shows one part of a question."""

    start: int  # First frame; that of the whole capture if the place is unknown
    end: int  # Last frame + 1; that of the whole capture if the place is unknown
    # Probability that the capture shows the part; None if it is not known
    probability: float | None
    # Probability that the interval is right, given that the capture shows the part; None if it is
    # not known. Whether the capture shows one action throughout is judged mostly by its length
    # (:mod:`motiondb.meaning.place_certainty`)
    right: float | None = None
    unknown: bool = False  # Whether the place is unknown

    @property
    def interval_probability(self) -> float | None:
        """Probability that the interval shows the part; None if this or the place is not known."""
        if self.unknown or self.probability is None or self.right is None:
            return None
        return self.probability * self.right


def unsure(place: PartPlace) -> PartPlace:
    """A place that something speaks against: how probable it is was not measured."""
    return replace(place, probability=None, right=None)


@dataclass(frozen=True)
class Placed:
    """Where a capture shows a reading of a question."""

    parts: tuple[PartPlace, ...]
    # Whether the actions are seen in the order that the question asks for (``edge_map``); None
    # if it asks for no order, or the evidence for each frame does not tell
    in_order: bool | None = None
    # What was measured against the question: "not backward", or "backward" where it is excluded
    contradicted: tuple[str, ...] = ()
    is_miscounted: bool = False  # Whether all that was measured against it is how often it occurs
    # Whether the motion neither contradicts nor clearly shows something that was measured
    is_unclear: bool = False
    # How fast, high or far, if the question names a degree; NaN if that cannot be measured
    amount: float | None = None
    gauged: tuple[str, ...] = ()  # The angle, way, speed or steps that a question names, measured


def place_answer(
    asked: AskedWords,
    capture: int,
    hit: QuestionHit,
    reading: Reading,
    said: Sequence[PartChance | None],
) -> tuple[PartPlace, ...]:
    """Where a capture shows every part of a reading."""
    sure = [None if one is None else one.probability for one in said]
    placed = _placed(asked, capture, reading)
    if placed is None:
        return tuple(
            _unplaced(asked, capture, part, span, one)
            for part, span, one in zip(reading.parts, hit.parts, said)
        )
    ends = int(placed.starts[0]), int(placed.ends[-1])
    places = []
    for k, (first, behind) in enumerate(placed.spans):
        span = int(placed.starts[first]), int(placed.ends[behind - 1])
        part = reading.parts[k]
        right = None if sure[k] is None else _right(asked, capture, placed, part, k)
        labelled = is_labelled(asked, capture, part)
        unknown = (
            not labelled
            and _only_by_caption(said[k])
            and (
                not _is_placed_elsewhere(asked, capture, part) if right is None else right < LIKELY
            )
        )
        places.append(PartPlace(*(ends if unknown else span), sure[k], right, unknown))
    return tuple(places)


def refine_places(
    asked: AskedWords, seen: SeenFrames, reading: Reading, places: Sequence[PartPlace]
) -> Placed:
    """Places with the boundaries that the evidence for each frame gives.

    A part keeps its frames where its place is unknown or labelled by a person, and where it asks
    for nothing, for a least length, or for words whose places were not learned, and where more than
    ``NARROW`` of it would remain. No part is extended into another one.

    Actions in order are placed anew, near their places by segments, unless one of them keeps its
    frames.
    """
    capture, edges, placed = seen.capture, asked.learned.edges, asked.learned.placed
    known = frozenset[int]() if placed is None else placed.words
    groups = [_words(asked, part) for part in reading.parts]
    fixed = [
        edges is None
        or not part.actions
        or part.seconds > 0.0
        or not known.issuperset(words)
        or is_labelled(asked, capture, part)
        for part, words in zip(reading.parts, groups)
    ]
    ordered = is_order(reading) and not any(fixed)
    kept = [not ordered and (fix or place.unknown) for fix, place in zip(fixed, places)]
    if edges is None or (all(kept) and not is_order(reading)):
        return Placed(tuple(places))
    each = {k: seen.smooth(words) for k, words in enumerate(groups)}
    evidence = {k: found for k, found in each.items() if found is not None}
    if ordered:
        return _ordered(places, np.stack([*evidence.values()]))
    bounds = [0, *(place.start for place in places[1:]), FEATURE_STEP * seen.n_frames]
    refined, end = [], 0
    for k, place in enumerate(places):
        if k in evidence and not kept[k]:
            start, stop = _refined(evidence[k], (place.start, place.end), (end, bounds[k + 1]))
            place = replace(place, start=start, end=stop)
        refined.append(place)
        end = place.end
    not_seen = is_order(reading) and not all(
        _reaches_half(found, refined[k])
        or _is_labelled_there(asked, capture, reading.parts[k], refined[k])
        for k, found in evidence.items()
    )
    if not_seen:
        return Placed(tuple(replace(place, right=None) for place in refined), False)
    return Placed(tuple(refined))


def sure_of_whole(placed: Placed, length: int) -> Placed:
    """Places of which one that is the whole take is right wherever the take shows the part.

    `length`: Frames of the take at 30 a second.
    """
    if len(placed.parts) > 1:  # of several parts, none has the take to itself
        return placed
    (place,) = placed.parts
    is_whole = place.start == 0 and length - place.end <= FEATURE_STEP and not place.unknown
    return replace(placed, parts=(replace(place, right=1.0),)) if is_whole else placed


def _ordered(places: Sequence[PartPlace], evidence: FloatArray) -> Placed:
    """Places by averaged evidence, around those of segments; `evidence` (parts, frames)."""
    n = evidence.shape[1]
    low = max(min(place.start for place in places) // FEATURE_STEP - AROUND, 0)
    high = min(-(-max(place.end for place in places) // FEATURE_STEP) + AROUND, n)
    order = lay_in_order(evidence, (low, high))
    if order is None:
        return Placed(tuple(places))
    if not order.is_seen:
        return Placed(tuple(replace(place, right=None) for place in places), False)
    parts = tuple(
        place
        if place.unknown
        else replace(place, start=FEATURE_STEP * a, end=FEATURE_STEP * b, right=None)
        for place, (a, b) in zip(places, order.spans)
    )
    return Placed(parts, True)


def _refined(evidence: FloatArray, span: tuple[int, int], room: tuple[int, int]) -> tuple[int, int]:
    """Frames of the motion, from those of an interval and of its room, by averaged evidence."""
    last = len(evidence)
    low, high = span[0] // FEATURE_STEP, min(-(-span[1] // FEATURE_STEP), last)
    limits = -(-room[0] // FEATURE_STEP), min(room[1] // FEATURE_STEP, last)
    if low >= high:
        return span
    start, end = around_half(evidence, (low, high), limits)
    if NARROW * (high - low) < end - start <= high - low:
        return span
    return (
        span[0] if start == low else FEATURE_STEP * start,
        span[1] if end == high else FEATURE_STEP * end,
    )


def interval_probability(
    probability: float | None, parts: Sequence[PartPlace], reading: Reading
) -> float | None:
    """Probability that the interval of an answer shows the requested action; None: not known.

    It was learned from single actions. Those of several parts are not independent, and how often
    all of them are right was never measured.
    """
    asked = [place for place, part in zip(parts, reading.parts) if part.actions]
    if probability is None or len(asked) != 1 or asked[0].unknown or asked[0].right is None:
        return None
    return probability * asked[0].right


def _placed(asked: AskedWords, capture: int, reading: Reading) -> PlacedReading | None:
    """Places by the evidence of places; None without it, or where it has no room for the parts.

    There is no such evidence for words that no caption held when the database learned.
    """
    known = asked.learned.placed
    take = None if known is None else known.take(capture)
    words = {asked.numbers[w] for part in reading.parts for a in part.actions for w in a}
    if known is None or take is None or not words <= known.words:
        return None
    windows = take.windows
    if asked.added:  # in exclusions; of their places nothing is known
        unplaced = np.zeros((len(take.starts), len(asked.added)))
        windows = np.concatenate([windows, unplaced], axis=1)
    said = asked.said_places.get(capture)
    take = replace(take, windows=windows if said is None else windows + said)
    return by_question.place_reading(take, reading, asked.numbers)


def _unplaced(
    asked: AskedWords,
    capture: int,
    part: Part,
    span: tuple[int, int],
    said: PartChance | None,
) -> PartPlace:
    """The interval of an answer without evidence of places.

    It is unknown where only a caption of the whole capture has the words, and own captions have not
    checked what the motion says.
    """
    unchecked = said is not None and said.probability is None and _only_by_caption(said)
    if unchecked and not is_labelled(asked, capture, part):
        take = asked.evidence.takes[capture]
        return PartPlace(int(take.starts[0]), int(take.ends[-1]), None, None, True)
    return PartPlace(*span, None if said is None else said.probability)


def _right(
    asked: AskedWords, capture: int, placed: PlacedReading, part: Part, k: int
) -> float | None:
    """Probability that the interval of part k is right; None if it was not learned.

    Nor is it known if no captions of other performers hold the words.
    """
    certainties = asked.learned.certainties
    sure, single = certainties.place, certainties.single
    known = asked.learned.placed
    if sure is None or single is None or known is None:
        return None
    performer = [known.performers[capture]]
    support = count_performers(known.listed_by, _words(asked, part), performer)
    if not support:
        return None
    cues = interval_cues(placed.values[k], placed.ends, *placed.spans[k], support)
    return PlaceCertainty(sure, single).probability(cues)


def _only_by_caption(said: PartChance | None) -> bool:
    """Whether only a caption of the whole capture speaks for a part."""
    return said is not None and said.by_caption and said.by_motion < LIKELY


def _is_placed_elsewhere(asked: AskedWords, capture: int, part: Part) -> bool:
    """Whether captions of other captures list all words of a part."""
    places = {} if asked.learned.places is None else asked.learned.places.words
    others = [words for other, words in places.items() if other != capture]
    return all(any(word in words for words in others) for word in _words(asked, part))


def is_labelled(asked: AskedWords, capture: int, part: Part) -> bool:
    """Whether captions of intervals say all words of a part."""
    said, words = asked.said_places.get(capture), _words(asked, part)
    return said is not None and bool(words) and bool((said[:, words].max(axis=0) > 0.0).all())


def _words(asked: AskedWords, part: Part) -> list[int]:
    """Numbers of the words that a part asks for."""
    return [asked.numbers[word] for action in part.actions for word in action]


def _reaches_half(evidence: FloatArray, place: PartPlace) -> bool:
    """Whether the averaged evidence of a take reaches half of its peak in a place."""
    first = place.start // FEATURE_STEP
    inside = evidence[first : max(place.end // FEATURE_STEP, first + 1)]
    return float(inside.max(initial=0.0)) >= HALF * float(evidence.max())


def _is_labelled_there(asked: AskedWords, capture: int, part: Part, place: PartPlace) -> bool:
    """Whether captions of intervals say the words of a part inside a place."""
    said, rows = asked.said_places.get(capture), asked.learned.rows[capture]
    if said is None:
        return False
    table = asked.learned.segments
    inside = (table.starts[rows] < place.end) & (table.ends[rows] > place.start)
    return bool((said[inside][:, _words(asked, part)] > 0.0).all(axis=1).any())
