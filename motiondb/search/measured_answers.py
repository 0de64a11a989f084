"""What of a question is measured in the motion of an answer: directions and sides of limbs.

Words alone hardly tell them: captions rarely say which way, or which hand. Three things can follow.

* The motion contradicts a word: no frame of the part goes in the direction
  (:mod:`motiondb.meaning.travelled`), or the other limb moves (:mod:`motiondb.meaning.limb_sides`).
  The answer says so and has no probability.
* The action goes in the direction elsewhere in the take: then the part is moved there.
* Otherwise the answer stays as it is.

A word that a caption of the capture says of the same action is believed. In a question of one
action, words that no caption of the database holds are measured too.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_STEP
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import KnownQuestion, Part, Reading
from motiondb.language.question.tree import Action
from motiondb.language.vocabulary import MODIFIERS
from motiondb.learn.learned import Learned
from motiondb.meaning.edge_map import HALF, averaged
from motiondb.meaning.limb_sides import limb_speeds, limbs_to_measure, moves_otherwise
from motiondb.meaning.travelled import TURNS, directions_to_measure, furthest, speeds_of
from motiondb.records import FloatArray
from motiondb.search.asked_words import AskedWords
from motiondb.search.placing import Features, PartPlace, Placed


def measured_words(action: Sequence[str]) -> set[str]:
    """The words of an action that are measured.

    >>> sorted(measured_words(("wave", "both", "hand"))), measured_words(("wave",))
    (['both', 'hand'], set())
    """
    limbs = chain.from_iterable(limbs_to_measure(action))
    return {*directions_to_measure(action), *limbs}


def only_action(text: str, learned: Learned) -> tuple[str, ...]:
    """The words, known or not, of a question of one action; () if it asks for more."""
    tree = parse(text, learned.synonyms, learned.lemmas).tree
    return tree.words if isinstance(tree, Action) else ()


def without_measured(question: KnownQuestion, words: Collection[str]) -> KnownQuestion:
    """A question whose unknown words are used where they are measured."""
    return replace(
        question,
        unknown={word: near for word, near in question.unknown.items() if word not in words},
        not_used=tuple(left for left in question.not_used if left.text not in words),
    )


def actions_of_part(part: Part, only: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """The actions of a part, of which the only one of a question has its unknown words."""
    return (only,) if only and part.actions else part.actions


def is_measured(reading: Reading, only: tuple[str, ...] = ()) -> bool:
    """Whether a reading, or the only action of a question, names what is measured."""
    return any(
        measured_words(action) for part in reading.parts for action in actions_of_part(part, only)
    )


def compare_with_motion(
    asked: AskedWords,
    capture: int,
    reading: Reading,
    placed: Placed,
    features: Features,
    written: bool = True,
    only: tuple[str, ...] = (),
) -> Placed:
    """Places with what the motion contradicts; parts go where their directions are seen.

    `only`: The words of the only action of the question, known or not.
    """
    said = asked.evidence.written.get(capture) if written else None
    believed = {
        word
        for word in MODIFIERS.intersection(asked.numbers)
        if said is not None and said[:, asked.numbers[word]].max() > 0.0
    }
    frames, places, contradicted = features(capture), list(placed.parts), list[str]()
    for k, part in enumerate(reading.parts):
        for action in actions_of_part(part, only):
            directions = [d for d in directions_to_measure(action) if d not in believed]
            limbs = [pair for pair in limbs_to_measure(action) if pair[0] not in believed]
            if not directions and not limbs:
                continue
            shown = _frames_that_show(asked, capture, action, places[k], features)
            if k:
                shown[: places[k - 1].end // FEATURE_STEP] = False
            if k + 1 < len(places):
                shown[places[k + 1].start // FEATURE_STEP :] = False
            against = [
                f"{side} {limb}"
                for side, limb in limbs
                if _is_otherwise(limb_speeds(frames, limb), side, places[k], shown)
            ]
            for direction in directions:
                ways = _ways(speeds_of(frames), direction, action, places[k], shown)
                if ways is None:
                    against.append(direction)
                elif not places[k].unknown:
                    places[k] = _moved(places[k], *ways)
            if against:
                places[k] = replace(places[k], probability=None, right=None)
                contradicted += against
    return replace(placed, parts=tuple(places), contradicted=tuple(dict.fromkeys(contradicted)))


def _inside(place: PartPlace) -> slice:
    """The feature frames of a place."""
    return slice(place.start // FEATURE_STEP, -(-place.end // FEATURE_STEP))


def _is_otherwise(
    speeds: FloatArray, side: str, place: PartPlace, shown: NDArray[np.bool_]
) -> bool:
    """Whether another limb moves, both in a place and wherever the action is shown."""
    return all(moves_otherwise(part, side) for part in (speeds[_inside(place)], speeds[shown]))


def _ways(
    speeds: FloatArray,
    direction: str,
    action: Sequence[str],
    place: PartPlace,
    shown: NDArray[np.bool_],
) -> tuple[int, int] | None:
    """The feature frames [a, b) that go in a direction while the action is shown; None: none do.

    They are those of the place, if the place does.
    """
    turns, inside = not TURNS.isdisjoint(action), _inside(place)
    if furthest(speeds[inside], direction, turns)[0] >= 1.0:
        return inside.start, inside.stop
    amount, first, behind = furthest(speeds * shown[:, None], direction, turns)
    return (first, behind) if amount >= 1.0 else None


def _moved(place: PartPlace, first: int, behind: int) -> PartPlace:
    """A place at other feature frames; the same where these are its own."""
    if (first, behind) == (_inside(place).start, _inside(place).stop):
        return place
    return replace(place, start=FEATURE_STEP * first, end=FEATURE_STEP * behind, right=None)


def _frames_that_show(
    asked: AskedWords, capture: int, action: Sequence[str], place: PartPlace, features: Features
) -> NDArray[np.bool_]:
    """Which feature frames are those of a place, or reach half of the evidence of an action.

    Directions and limbs are left out of the evidence; of words whose places were not learned there
    is none.
    """
    frames = asked.learned.frames_of(capture, features)
    shown = np.zeros(len(frames), dtype=bool)
    shown[_inside(place)] = True
    edges, placed = asked.learned.edges, asked.learned.placed
    known = [word for word in action if word in asked.numbers and word not in MODIFIERS]
    words = [asked.numbers[word] for word in known]
    if words and edges is not None and placed is not None and placed.words.issuperset(words):
        evidence = averaged(edges.evidence(frames, words))
        shown |= evidence >= HALF * max(float(evidence.max()), 0.0)
    return shown
