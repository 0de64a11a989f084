"""What of a question is measured in the motion of an answer: directions and sides of limbs.

Words alone hardly tell them: captions rarely say which way, or which hand. Four things can follow.

* The motion contradicts a word: no frame of the part goes in the direction
  (:mod:`motiondb.meaning.travelled`), or the other limb moves (:mod:`motiondb.meaning.limb_sides`).
  Or it clearly shows one that the question excludes ("walk, but not forward"). The answer says so
  and has no probability.
* The limb of the side moves, but not clearly more than the other (:data:`CLEAR_SIDE`). The answer
  comes after clear ones, and has no probability.
* The action goes in the direction elsewhere in the take: then the part is moved there.
* Otherwise the answer stays as it is.

A word that a caption of the capture says of the same action is believed, unless the take goes in
the direction only where the action cannot be, before or after other actions of the question. In a
question of one action, requested words that no caption of the database holds are measured too.
Alternatives ("or", and "and", which is at once or in order) are not measured; answers to what is
not measured have no probability (:func:`motiondb.search.asking.unmeasured_words`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP
from motiondb.language.question.readings import Part, say_duration
from motiondb.language.vocabulary import IN_PLACE, MODIFIERS, as_said
from motiondb.meaning.edge_map import HALF, averaged
from motiondb.meaning.limb_sides import (
    limb_speeds,
    limbs_to_measure,
    moves_otherwise,
    say_other_limb,
    side_amount,
)
from motiondb.meaning.travelled import (
    directions_to_measure,
    furthest,
    longest_going,
    say_not_gone,
    share_of_full,
    speeds_of,
    turning,
)
from motiondb.records import Float32Array, FloatArray
from motiondb.search.asked_words import AskedWords
from motiondb.search.asking import (
    AskedQuestion,
    actions_of_part,
    excluded_words,
    lasts_going,
    measured_words,
)
from motiondb.search.placing import PartPlace, Placed
from motiondb.search.seen_frames import SeenFrames

LEAST_LOOKED_AT = 30  # Feature frames (2 s) in which "in place" is measured
CLEAR_SIDE = 2.0  # Least shares of a limb from which it clearly moves: two thirds, or .3 each
OTHER = {"left": "right", "right": "left"}


def compare_with_motion(question: AskedQuestion, seen: SeenFrames, placed: Placed) -> Placed:
    """Places with what the motion contradicts; parts go where their directions are seen."""
    asked, (reading,) = question.asked, question.readings
    said = asked.evidence.written.get(seen.capture)
    believed = {
        word
        for word in MODIFIERS.intersection(asked.numbers)
        if said is not None and said[:, asked.numbers[word]].max() > 0.0
    }
    frames, places, contradicted = seen.features, list(placed.parts), list[str]()
    unclear = False
    for k, part in enumerate(reading.parts):
        room = slice(
            -(-places[k - 1].end // FEATURE_STEP) if k else 0,
            places[k + 1].start // FEATURE_STEP if k + 1 < len(places) else len(frames),
        )
        for action in actions_of_part(asked, part, question.only):
            if lasts_going(part, action):
                places[k], short = _gone_on(seen, part, action, places[k], room)
                contradicted += short
            if not measured_words(action):
                continue
            shown = np.zeros((2, len(frames)), dtype=bool)
            shown[0, room] = _frames_that_show(asked, seen, action, places[k])[room]
            shown[1, room] = True
            sides = [
                (side, limb, limb_speeds(frames, limb, action))
                for side, limb in limbs_to_measure(action)
                if side not in believed
            ]
            against, place = _compare_action(
                seen, action, sides, believed, places[k], shown, part.seconds
            )
            alone = len(part.actions) == 1 and len(directions_to_measure(action)) == 1
            # of several directions, one place would have to show all
            if not alone and (place.start, place.end) != (places[k].start, places[k].end):
                place = replace(place, start=places[k].start, end=places[k].end, right=None)
            places[k] = place
            contradicted += against
            unclear = unclear or any(
                side_amount(speeds[_inside(place)], side) < CLEAR_SIDE for side, _, speeds in sides
            )
    for exclusion in reading.exclusions:
        for k in range(exclusion.first, exclusion.last):
            inside = frames[_inside(places[k])]
            for action, excluded in product(reading.parts[k].actions, exclusion.actions):
                if not MODIFIERS.issuperset(excluded) or places[k].unknown:
                    continue
                done = _done_though_excluded(inside, action, excluded)
                places[k] = _unsure(places[k]) if done else places[k]
                contradicted += done
    spoken = tuple(dict.fromkeys(contradicted))
    return replace(placed, parts=tuple(places), contradicted=spoken, is_unclear=unclear)


def _gone_on(
    seen: SeenFrames, part: Part, action: Sequence[str], place: PartPlace, room: slice
) -> tuple[PartPlace, list[str]]:
    """Where a motion goes on travelling as long as it is asked for, and what speaks against it."""
    inside = np.zeros(len(seen.features), dtype=bool)
    inside[room] = True
    lasting, first, behind = longest_going(seen.speeds, action, inside)
    if lasting < part.seconds:
        asked = say_duration(part.seconds, None).removeprefix("for ")
        return _unsure(place), [f"goes on for {lasting:.1f} s, not {asked}"]
    return (place if place.unknown else _moved(place, first, behind)), []


def _compare_action(
    seen: SeenFrames,
    action: Sequence[str],
    sides: Sequence[tuple[str, str, FloatArray]],
    believed: Collection[str],
    place: PartPlace,
    shown: NDArray[np.bool_],
    seconds: float,
) -> tuple[list[str], PartPlace]:
    """What the motion has against an action of some seconds, and where its directions are seen.

    `sides`: those to measure, each with its limb and the speeds of both limbs. Shapes: `shown` (2,
    frames): which frames show the action by its evidence, and which may show it where captions say
    so.
    """
    against = [
        say_other_limb(side, limb)
        for side, limb, speeds in sides
        if _is_otherwise(speeds, side, place, shown[0])
    ]
    for direction in directions_to_measure(action):
        is_said = direction in believed
        ways = _ways(seen.speeds, direction, action, place, shown[int(is_said)], seconds)
        if ways is not None:
            place = place if place.unknown else _moved(place, *ways)
        elif not is_said or furthest(seen.speeds, direction, turning(action))[0] >= 1.0:
            lasting = f" {say_duration(seconds, None)}" if seconds > 0.0 else ""
            against.append(say_not_gone(direction, turning(action)) + lasting)
    return against, _unsure(place) if against else place


def _unsure(place: PartPlace) -> PartPlace:
    """A place that something speaks against: how probable it is was not measured."""
    return replace(place, probability=None, right=None)


def _done_though_excluded(
    frames: Float32Array, action: Sequence[str], excluded: Sequence[str]
) -> list[str]:
    """What of "walk, but not backward" the frames clearly show; `frames` (frames, 130)."""
    words, turn = excluded_words(action, excluded), turning(action)
    gone = [
        f"{'stays' if direction == IN_PLACE else f'{turn}s' if turn else 'goes'} "
        f"{as_said(direction)}, which is excluded"
        for direction in directions_to_measure(words)
        if share_of_full(furthest(speeds_of(frames), direction, turn)[0], direction, turn) >= 1.0
    ]
    moved = [
        f"moves the {side} {limb}, which is excluded"
        for side, limb in limbs_to_measure(words)
        if side in OTHER and moves_otherwise(limb_speeds(frames, limb, words), OTHER[side])
    ]
    return gone + moved


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
    seconds: float,
) -> tuple[int, int] | None:
    """The feature frames [a, b) that go in a direction while the action is shown; None: none do.

    They are those of the place, if the place does. Others must last `seconds`.
    """
    turn, inside = turning(action), _inside(place)
    looked_at = speeds[_looked_at(inside, direction, len(speeds))]
    if furthest(looked_at, direction, turn, least=1.0)[0] >= 1.0:
        return inside.start, inside.stop
    amount, first, behind = furthest(speeds, direction, turn, shown, least=1.0)
    return (first, behind) if amount >= 1.0 and behind - first >= seconds * FEATURE_FPS else None


def _looked_at(inside: slice, direction: str, n: int) -> slice:
    """The frames, of n, in which the direction of a place is measured.

    At least 2 s for "in place": who walks on stays in place for the half second of a step.

    >>> _looked_at(slice(40, 50), IN_PLACE, 90), _looked_at(slice(80, 90), IN_PLACE, 90)
    (slice(30, 60, None), slice(60, 90, None))
    >>> _looked_at(slice(0, 10), IN_PLACE, 20), _looked_at(slice(80, 90), "forward", 90)
    (slice(0, 20, None), slice(80, 90, None))
    """
    more = LEAST_LOOKED_AT - (inside.stop - inside.start)
    if direction != IN_PLACE or more <= 0:
        return inside
    start = max(min(inside.start - more // 2, n - LEAST_LOOKED_AT), 0)
    return slice(start, min(start + LEAST_LOOKED_AT, n))


def _moved(place: PartPlace, first: int, behind: int) -> PartPlace:
    """A place at other feature frames; the same where these are its own."""
    if (first, behind) == (_inside(place).start, _inside(place).stop):
        return place
    return replace(place, start=FEATURE_STEP * first, end=FEATURE_STEP * behind, right=None)


def _frames_that_show(
    asked: AskedWords, seen: SeenFrames, action: Sequence[str], place: PartPlace
) -> NDArray[np.bool_]:
    """Which feature frames are those of a place, or reach half of the evidence of an action.

    Directions and limbs are left out of the evidence; of words whose places were not learned there
    is none.
    """
    shown = np.zeros(len(seen.features), dtype=bool)
    shown[_inside(place)] = True
    known = [word for word in action if word in asked.numbers and word not in MODIFIERS]
    evidence = seen.evidence([asked.numbers[word] for word in known])
    if evidence is not None:
        smooth = averaged(evidence)
        shown |= smooth >= HALF * max(float(smooth.max()), 0.0)
    return shown
