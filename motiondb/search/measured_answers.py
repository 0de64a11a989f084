"""What of a question is measured in the motion of an answer.

Words alone hardly tell it: captions rarely say which way, which hand, how often or how long.
Measured are directions (:mod:`motiondb.meaning.travelled`), sides of limbs
(:mod:`motiondb.meaning.limb_sides`), events, their number and where they are
(:mod:`motiondb.meaning.occurrences`), how long somebody goes on travelling, rests or leaves,
postures meanwhile, and how fast, high or far (:mod:`motiondb.meaning.amounts`). Then:

* The motion contradicts the question: no frame of the part goes in the direction, the other limb
  moves, there are more or fewer events, or it shows what the question excludes ("walk, but not
  forward"; "sit down without standing up afterwards"). The answer says so and has no probability.
* The limb of the side moves, but not clearly more than the other (``CLEAR_SIDE``), or a take of
  more events holds as many in a row. The answer comes after clear ones, and has no probability.
* The action goes in the direction elsewhere in the take, or its event is elsewhere: then the part
  is moved there. The place of an event is where it is; its probability is only told where the
  evidence of words agrees.
* A degree orders the answers, which have no probability. Otherwise an answer stays as it is.

A word that a caption of the capture says of the same action is believed, unless the take goes in
the direction only where the action cannot be, before or after other actions of the question. In a
question of one action, requested words that no caption of the database holds are measured too.
Of alternatives ("or", and "and", which is at once or in order) every reading is measured by itself.
Answers to what is not measured have no probability
(:func:`motiondb.search.asking.unmeasured_words`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP, runs
from motiondb.language.lemmas import VERBS
from motiondb.language.question.readings import Exclusion, Part, say_count, say_duration
from motiondb.language.vocabulary import IN_PLACE, MODIFIERS, as_said
from motiondb.meaning.direction import trodden_anywhere, vertical_ways
from motiondb.meaning.limb_sides import (
    is_at_rest,
    limb_speeds,
    limbs_to_measure,
    moves_otherwise,
    say_other_limb,
    side_amount,
)
from motiondb.meaning.occurrences import event_of, seen_event
from motiondb.meaning.postures import frames_without, posture_of, say_posture
from motiondb.meaning.travelled import (
    STEADY,
    directions_to_measure,
    say_not_gone,
    share_of_full,
    turning,
)
from motiondb.records import MOTION_FPS, FloatArray
from motiondb.search.asked_times import (
    frames_that_show,
    place_in_time,
    room_asked,
    seconds_from_edge,
)
from motiondb.search.asked_words import AskedWords
from motiondb.search.asking import (
    AskedQuestion,
    excluded_event,
    excluded_words,
    is_repeated,
    lasts_going,
    measured_words,
)
from motiondb.search.measured_amounts import gauge, gauged_action
from motiondb.search.measured_postures import (
    AT_ONCE,
    CLEAR_SIDE,
    events_in_groups,
    events_of_side,
    goes_anywhere,
    held_inside,
    held_meanwhile,
    is_flown,
    lacks_posture,
    leaves_posture_open,
    not_aimed,
    not_flown,
    on_other_foot,
    other_posture,
    posture_though_excluded,
)
from motiondb.search.placing import PartPlace, Placed, is_labelled, unsure
from motiondb.search.said_together import STANDING
from motiondb.search.seen_frames import SeenFrames

LEAST_LOOKED_AT = 30  # Feature frames (2 s) in which "in place" is measured
MOST_OF_PLACE = 0.6  # Share of a place that goes in a direction of which it is said as a whole
LEAVES = 1.0  # Seconds for which somebody who walks away must at least walk
RESTS = 1.0  # Seconds for which somebody who does not move must at least be still


def compare_with_motion(
    question: AskedQuestion, seen: SeenFrames, placed: Placed, n: int = 0
) -> Placed:
    """Places of a reading with what the motion contradicts.

    Parts go where it shows what they ask for.
    """
    reading, actions_of = question.readings[n], question.compared[n]
    places, contradicted, gauged, unclear = list(placed.parts), list[str](), list[str](), False
    miscounted, amount = set[str](), None
    for k, part in enumerate(reading.parts):
        is_next = k + 1 < len(places) and bool(reading.parts[k + 1].actions)
        room = slice(
            -(-places[k - 1].end // FEATURE_STEP) if k else 0,
            places[k + 1].start // FEATURE_STEP if is_next else seen.n_frames,
        )
        room = room_asked(seen, question.time, room)
        places[k], against, is_whole = _at_events(
            question, seen, part, actions_of[k], places[k], room, reading.exclusions
        )
        contradicted += against
        miscounted.update(against if is_repeated(part) else ())
        unclear = unclear or not is_whole
        for action in actions_of[k]:
            places[k], against = _meanwhile(question.asked, seen, part, action, places[k], room)
            contradicted += against
            if measured_words(action):
                places[k], against, is_unclear = _goes(
                    question, seen, part, action, places[k], room
                )
                contradicted += against
                unclear = unclear or is_unclear
        gauging = gauged_action(part, actions_of[k])
        if part.measure is not None and gauging:
            places[k], against, told = gauge(seen, part.measure, gauging, places[k], room)
            contradicted, gauged = [*contradicted, *against], [*gauged, *told]
    if question.time:
        places[0], against = place_in_time(
            question.asked, seen, question.time, actions_of[0], places[0]
        )
        contradicted += against
        amount = seconds_from_edge(seen, question.time, places[0])
    for exclusion in (*reading.exclusions, *reading.unseen):
        for k in range(exclusion.first, exclusion.last):
            places[k], against, is_unclear = _without(
                question.asked, seen, actions_of[k], exclusion, places[k]
            )
            contradicted, unclear = [*contradicted, *against], unclear or is_unclear
    if question.degree is not None:
        amount = question.degree.amount(seen.track, places[0].start, places[0].end)
    elif question.by_length:
        amount = float(places[0].end - places[0].start)
    spoken = tuple(dict.fromkeys(contradicted))
    return replace(
        placed,
        parts=tuple(places),
        contradicted=spoken,
        is_miscounted=bool(spoken)
        and miscounted == {*spoken}
        and not is_surely_against(question, seen, n),
        is_unclear=unclear,
        amount=amount,
        gauged=tuple(gauged),
    )


def is_surely_against(question: AskedQuestion, seen: SeenFrames, n: int = 0) -> bool:
    """Whether a take contradicts a reading of a question as measured, wherever its parts may be.

    Then it need not be placed to be told from an answer.
    """
    for part, actions in zip(question.readings[n].parts, question.compared[n]):
        event = _counted_event(question.asked, part, actions)
        if event and is_repeated(part):
            room = room_asked(seen, question.time, slice(0, seen.n_frames))
            found = _found(seen, event, part, actions[0], room)
            if len(found) < part.least:
                return True
        for action in actions:
            if _lacks(question.asked, seen, part, action):
                return True
    return False


def _lacks(asked: AskedWords, seen: SeenFrames, part: Part, action: Sequence[str]) -> bool:
    """Whether a take nowhere goes on, leaves, sits down, rises or goes as an action asks for."""
    is_event = seen_event(action, asked.numbers)
    if lasts_going(part, action) or (part.is_seen and not is_event):
        least = part.seconds if lasts_going(part, action) else LEAVES
        if seen.longest_going(action)[0] < least:
            return True
    if lacks_posture(asked, seen, action):
        return True
    if not measured_words(action):
        return False
    believed = _believed(asked, seen.capture, action)
    event = event_of(action)
    is_told = event in ("seat", "rise") and {"up", "down"}.isdisjoint(believed)
    if is_told and not seen.is_away and not seen.events(event):
        return True
    return any(
        direction not in believed and not goes_anywhere(seen, action, direction)
        for direction in directions_to_measure(action)
        if direction != IN_PLACE
    )


def _counted_event(asked: AskedWords, part: Part, actions: Sequence[Sequence[str]]) -> str:
    """The event of a part of one action, which is counted or gives it its place; "" for others."""
    if not actions or (part.seconds > 0.0 and (part.actions or lasts_going(part, actions[0]))):
        return ""
    if "stop" in map(event_of, actions):  # who stops while running does so at the end of it
        return "stop"
    if len(actions) != 1:
        return ""
    # of words that no caption says together, one may be another action: "stand up" and "chair" not
    n_acting = sum(not VERBS.isdisjoint(words) for words in part.actions)
    seen = seen_event(actions[0], asked.numbers)
    return seen or (event_of(actions[0]) if n_acting < 2 else "")


def _believed(asked: AskedWords, capture: int, action: Sequence[str]) -> set[str]:
    """The directions, limbs and sizes that captions of a capture say of an action.

    "Dribble, turn left" says nothing of the hand that dribbles.
    """
    if asked.evidence.written.get(capture) is None:
        return set()
    done, said = set(action) - MODIFIERS, asked.learned.said_actions(capture)
    of_it = [words for words in said if not done or not done.isdisjoint(words)]
    return set().union(*of_it) & MODIFIERS


def _meanwhile(
    asked: AskedWords,
    seen: SeenFrames,
    part: Part,
    action: Sequence[str],
    place: PartPlace,
    room: slice,
) -> tuple[PartPlace, list[str]]:
    """The place of a part that goes on, leaves, or has a posture, and what speaks against it."""
    event = asked.sure_event(action)
    if event and len(part.actions) > 1 and lacks_posture(asked, seen, action):
        return unsure(place), [f"does not {say_posture(event)}"]
    if lasts_going(part, action):
        return _gone_on(seen, part, action, place, room)
    if len(part.said) > 1 and {*action} <= STANDING:
        return place, other_posture(seen, action, place)
    is_event = seen_event(action, asked.numbers)
    if len(part.said) > 1 and is_event:
        return held_meanwhile(asked, seen, action, place)
    if part.is_seen and not is_event:
        return _leaves(seen, action, place, room)
    return place, []


def _goes(
    question: AskedQuestion,
    seen: SeenFrames,
    part: Part,
    action: Sequence[str],
    place: PartPlace,
    room: slice,
) -> tuple[PartPlace, list[str], bool]:
    """The place of an action that names directions or limbs, and what speaks against it.

    And whether the motion leaves it open which limb moves.
    """
    asked = question.asked
    believed = _believed(asked, seen.capture, action)
    shown = np.zeros((2, seen.n_frames), dtype=bool)
    shown[1, room] = True
    shown[0] = shown[1] & frames_that_show(asked, seen, action)
    shown[0, _inside(place)] = shown[1, _inside(place)]
    sides = [
        (side, limb, limb_speeds(seen.limbs, limb, action))
        for side, limb in limbs_to_measure(action)
        if side not in believed and not posture_of(action)
    ]
    against, now = _compare_action(seen, action, sides, believed, place, shown, part.seconds)
    alone = len(part.said or part.actions) == 1 and len(directions_to_measure(action)) == 1
    # of several directions, one place would have to show all
    if not alone and (now.start, now.end) != (place.start, place.end):
        now = replace(now, start=place.start, end=place.end, right=None)
    unclear = any(side_amount(speeds[_inside(now)], side) < CLEAR_SIDE for side, _, speeds in sides)
    unclear = unclear or leaves_posture_open(
        asked, seen, action, now.start, now.end, question.is_silent
    )
    # seen somewhere in a take, a direction may be that of another action
    unclear = unclear or bool(now.unknown and {*directions_to_measure(action)} - believed)
    if "sideways" in {*directions_to_measure(action)} - believed:
        aside, ahead, _ = np.abs(seen.speeds[_inside(now)]).sum(axis=0)
        unclear = unclear or bool(aside < ahead)
    return now, against, unclear


def _found(
    seen: SeenFrames, event: str, part: Part, action: Sequence[str], room: slice
) -> list[tuple[int, int]]:
    """Where the event of an action occurs in feature frames; jumps for a hop that is not seen."""
    low, high, events = FEATURE_STEP * room.start, FEATURE_STEP * room.stop, seen.events(event)
    if event == "hop" and not events and not is_repeated(part):
        events = seen.events("jump")  # on which foot is not always seen
    if event.startswith(("land", "takeoff")):
        is_after = bool(low) and event.startswith("land")
        high = min(high, low + AT_ONCE) if is_after else high  # that of the jump before it
    elif posture_of(action) or event in ("walk", "run"):
        return events_of_side(seen, action, held_inside(events, low, high))
    return events_of_side(seen, action, [t for t in events if low <= sum(t) / 2 < high])


def _at_events(
    question: AskedQuestion,
    seen: SeenFrames,
    part: Part,
    actions: Sequence[Sequence[str]],
    place: PartPlace,
    room: slice,
    exclusions: Sequence[Exclusion],
) -> tuple[PartPlace, list[str], bool]:
    """The place of a part where its event occurs, and what speaks against how often it does.

    And whether what is counted is all of it: a take of seven jumps may hold two in a row.
    """
    event = _counted_event(question.asked, part, actions)
    if not event:
        return place, [], True
    if not is_repeated(part) and is_labelled(question.asked, seen.capture, part):
        return place, [], True  # captions say where it is
    if not is_repeated(part) and seen.is_away:
        return place, [], True  # words alone say where it is
    posture = seen_event(actions[0], question.asked.numbers)
    found = _found(seen, event, part, actions[0], room)
    groups = (
        [[one] for one in found] if posture and not is_repeated(part) else events_in_groups(found)
    )
    if is_repeated(part):
        groups = [g for g in (found, *groups) if _fits(part, len(g))]
        if not groups:
            n, least = len(found), 0 if part.least == 1 and part.most else part.least
            return (
                unsure(place),
                [f"{as_said(event)} {say_count(n, n)}, not {say_count(least, part.most)}"],
                True,
            )
    if not found:
        lacks = lacks_posture(question.asked, seen, actions[0], found)
        there = " then" if posture and seen.events(event) else ""
        return place, [f"does not {say_posture(posture or event)}{there}"] * lacks, True
    inside = [g for g in groups if g[-1][1] > place.start and g[0][0] < place.end]
    words = [question.asked.numbers[word] for action in part.actions[:1] for word in action]
    evidence = seen.evidence(words) if words else None

    def strength(group: Sequence[tuple[int, int]]) -> float:
        first, behind = (f // FEATURE_STEP for f in (group[0][0], group[-1][1]))
        if posture:
            return float(behind - first)  # held for longest
        return 0.0 if evidence is None else float(evidence[first : behind + 1].mean())

    best = max(groups if place.unknown or not inside else inside, key=strength)
    if any(exclusion.later for exclusion in exclusions):
        best = groups[-1]
    first, behind = best[0][0], best[-1][1]
    common = min(behind, place.end) - max(first, place.start)
    agree = 2 * common >= max(behind, place.end) - min(first, place.start)
    return (
        replace(
            place,
            start=first,
            end=behind,
            right=place.right if agree and not place.unknown else None,
            unknown=False,
        ),
        [],
        not is_repeated(part) or _fits(part, len(found)),
    )


def _fits(part: Part, n: int) -> bool:
    """Whether an event occurs as often as a part asks for."""
    return part.least <= n and (part.most is None or n <= part.most)


def _leaves(
    seen: SeenFrames, action: Sequence[str], place: PartPlace, room: slice
) -> tuple[PartPlace, list[str]]:
    """Where somebody leaves, after another action and before the next."""
    lasting, first, behind = seen.longest_going(action, room)
    if lasting < LEAVES:
        return unsure(place), [f"does not {action[0]} away"]
    return _moved(place, first, behind), []


def _gone_on(
    seen: SeenFrames, part: Part, action: Sequence[str], place: PartPlace, room: slice
) -> tuple[PartPlace, list[str]]:
    """Where a motion goes on as long as it is asked for, and what speaks against it."""
    lasting, first, behind = seen.longest_going(action, room)
    if math.isinf(lasting):
        return place, []  # it cannot be measured
    is_long = part.longest is not None and lasting >= part.longest + STEADY / 2.0
    if lasting < part.seconds or is_long:
        asked = say_duration(part.seconds, part.longest).removeprefix("for ")
        return unsure(place), [f"goes on for {lasting:.1f} s, not {asked}"]
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
        *on_other_foot(seen, action, place),
        *not_aimed(seen, action, place, believed),
        *_not_vertical(seen, action, place, believed),
    ]
    against += [
        say_other_limb(side, limb)
        for side, limb, speeds in sides
        if _is_otherwise(speeds, side, place, shown[0])
    ]
    for direction in directions_to_measure(action):
        is_said = direction in believed
        if is_flown(direction, action) and not is_said and not seen.is_away:
            against += not_flown(seen, action, place)
            continue
        ways = _ways(seen, direction, action, place, shown[int(is_said)], seconds)
        if ways is not None:
            place = place if place.unknown else _moved(place, *ways)
        elif not is_said or seen.goes_once(direction, turning(action)):
            lasting = f" {say_duration(seconds, None)}" if seconds > 0.0 else ""
            against.append(say_not_gone(direction, turning(action)) + lasting)
    return against, unsure(place) if against else place


def _not_vertical(
    seen: SeenFrames, action: Sequence[str], place: PartPlace, believed: Collection[str]
) -> list[str]:
    """That somebody does not sit down, stand up, or walk up where this is asked for."""
    event, lasting = event_of(action), [w for w in vertical_ways(action) if w not in believed]
    is_change = event in ("seat", "rise") and {"up", "down"}.isdisjoint(believed)
    if not (is_change or lasting) or seen.is_away:  # of takes away words alone say what is done
        return []
    if is_change:
        found = seen.events(event)
        if not any(a < place.end + AT_ONCE and b > place.start - AT_ONCE for a, b in found):
            return [f"does not {'sit down' if event == 'seat' else 'stand up'}"]
    return [f"does not go {w}" for w in lasting if trodden_anywhere(seen.track, w) < 1.0]


def _without(
    asked: AskedWords,
    seen: SeenFrames,
    actions: Sequence[Sequence[str]],
    exclusion: Exclusion,
    place: PartPlace,
) -> tuple[PartPlace, list[str], bool]:
    """The place of a part without what is excluded, what speaks against it, and whether it may."""
    if excluded_event(exclusion) == "move" and not actions:
        return *_unmoved(seen, place), True
    done = _done_though_excluded(asked, seen, actions, exclusion, place)
    return unsure(place) if done else place, done, False


def _done_though_excluded(
    asked: AskedWords,
    seen: SeenFrames,
    actions: Sequence[Sequence[str]],
    exclusion: Exclusion,
    place: PartPlace,
) -> list[str]:
    """What of "walk, but not backward" or "sit, without standing up" a place clearly shows."""
    done = list[str]()
    end = math.inf if exclusion.later else place.end
    for action, excluded in product(actions or ((),), exclusion.actions):
        event = seen_event(excluded, asked.numbers)  # which the action need not have
        posture = excluded if event else excluded_words(action, excluded)
        posed = posture_though_excluded(asked, seen, posture, place.start, place.end)
        if posed is not None:
            done += posed
        elif MODIFIERS.issuperset(excluded) and not place.unknown:
            done += _goes_though_excluded(seen, _inside(place), action, excluded)
    event = excluded_event(exclusion)
    is_seen = bool(event) and bool(seen_event(exclusion.actions[0], asked.numbers))
    is_event = event == "move" or (bool(event and actions) and not is_seen)
    is_direction = bool(exclusion.actions) and MODIFIERS.issuperset(exclusion.actions[0])
    if is_event and not is_direction:
        found = events_of_side(seen, exclusion.actions[0], seen.events(event))
        if any(place.start < (a + b) / 2 < end for a, b in found):
            words = " ".join(map(as_said, exclusion.actions[0]))
            done.append(f"{words} is seen, which is excluded")
    return done


def _unmoved(seen: SeenFrames, place: PartPlace) -> tuple[PartPlace, list[str]]:
    """Where somebody does not move for longest, and whether that is too short to be a rest."""
    still = frames_without(seen.events("move"), len(seen.track))
    first, behind = max(runs(still), key=lambda run: run[1] - run[0], default=(0, 0))
    if behind - first < RESTS * MOTION_FPS:
        return unsure(place), ["does not stop moving"]
    return replace(unsure(place), start=first, end=behind, unknown=False), []


def _goes_though_excluded(
    seen: SeenFrames, inside: slice, action: Sequence[str], excluded: Sequence[str]
) -> list[str]:
    """The directions and sides of an action that feature frames show though excluded."""
    words, turn = excluded_words(action, excluded), turning(action)
    gone = [
        f"{'stays' if direction == IN_PLACE else f'{turn}s' if turn else 'goes'} "
        f"{as_said(direction)}, which is excluded"
        for direction in directions_to_measure(words)
        if share_of_full(seen.furthest(direction, turn, inside)[0], direction, turn) >= 1.0
    ]
    moved = [
        f"moves the {side} {limb}, which is excluded"
        for side, limb in limbs_to_measure(words)
        if side in ("left", "right")
        and _moves_side(limb_speeds(seen.limbs[inside], limb, words), side)
    ]
    return gone + moved


def _moves_side(speeds: FloatArray, side: str) -> bool:
    """Whether the limb of a side moves, alone or with the other one."""
    return not is_at_rest(speeds) and side_amount(speeds, side) >= 1.0


def _inside(place: PartPlace) -> slice:
    """The feature frames of a place."""
    return slice(place.start // FEATURE_STEP, -(-place.end // FEATURE_STEP))


def _is_otherwise(
    speeds: FloatArray, side: str, place: PartPlace, shown: NDArray[np.bool_]
) -> bool:
    """Whether another limb moves, both in a place and wherever the action is shown."""
    return all(moves_otherwise(part, side) for part in (speeds[_inside(place)], speeds[shown]))


def _ways(
    seen: SeenFrames,
    direction: str,
    action: Sequence[str],
    place: PartPlace,
    shown: NDArray[np.bool_],
    seconds: float,
) -> tuple[int, int] | None:
    """The feature frames [a, b) that go in a direction while the action is shown; None: none do.

    They are the place's, or its part that does, if that is less than most; others last `seconds`.
    """
    turn, inside = turning(action), _inside(place)
    looked_at = _looked_at(inside, direction, len(shown))
    amount, first, behind = seen.furthest(direction, turn, looked_at, least=1.0)
    if amount >= 1.0:
        long = max(seconds * FEATURE_FPS, MOST_OF_PLACE * (inside.stop - inside.start))
        if direction == IN_PLACE or not seconds * FEATURE_FPS <= behind - first < long:
            return inside.start, inside.stop
        return looked_at.start + first, looked_at.start + behind
    amount, first, behind = seen.furthest(direction, turn, shown, least=1.0)
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
