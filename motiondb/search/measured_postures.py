"""Postures of answers as the motion shows them, and events by their side.

Raised hands, lying, kneeling, one leg; turns and jumps to a side, hops on a leg.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.language.question.tree import SIDES
from motiondb.language.vocabulary import MODIFIERS, SINGLE, as_said
from motiondb.meaning.aims import aims_of, goes_there
from motiondb.meaning.limb_sides import (
    PLAIN,
    hop_on,
    limb_held,
    limb_speeds,
    limbs_to_measure,
    side_amount,
)
from motiondb.meaning.occurrences import FLIGHTS, event_of, flown, is_on_foot, seen_event
from motiondb.meaning.postures import posture_of, say_posture, sitting, standing
from motiondb.meaning.travelled import turning
from motiondb.search.asked_words import AskedWords
from motiondb.search.placing import PartPlace, unsure
from motiondb.search.seen_frames import SeenFrames

CLEAR_SIDE = 2.0  # Least shares of a limb from which it clearly moves: two thirds, or .3 each
WALKING, HOLDS = 0.6, 0.7  # m/s; share of a place in which a posture holds
FLOWN = 0.2  # Metres to a side of a jump that goes there, if it goes less far ahead or back
BESIDE = 15  # Frames (0.5 s) before or after an action in which it takes off or lands
AT_ONCE = 60  # Frames (2 s) between events that belong together
HELD_FOR = 9  # Frames (0.3 s) for which a posture is at least held while something else is done


def lacks_posture(
    asked: AskedWords,
    seen: SeenFrames,
    action: Sequence[str],
    found: Sequence[tuple[int, int]] | None = None,
) -> bool:
    """Whether a take does not show the posture of an action, and no caption of it says so.

    `found`: Where it was found; None: look for it in the whole take.
    """
    posture = seen_event(action, asked.numbers) or asked.sure_event(action)
    if not posture or seen.is_away or _is_said(asked, seen, action):
        return False
    return not (seen.events(posture) if found is None else found)


def leaves_posture_open(
    asked: AskedWords, seen: SeenFrames, action: Sequence[str], start: int, end: int, alone: bool
) -> bool:
    """Whether the posture of an action is seen and not said, or both hands are up in place of one.

    `alone`: Whether captions say it nowhere, so that no answer has a probability. [start, end): its
    frames.
    """
    posture = seen_event(action, asked.numbers)
    what, _, side = posture.partition(" ")
    if not posture or seen.is_away:
        return False
    both = seen.events(f"{what} both") if side in ("left", "right") and what != "on" else []
    is_said = alone or _is_said(asked, seen, action)
    return not is_said or any(a < end and b > start for a, b in both)


def _is_said(asked: AskedWords, seen: SeenFrames, action: Sequence[str]) -> bool:
    """Whether a caption of a take says the posture of an action, or where its hand is."""
    if asked.evidence.written.get(seen.capture) is None:
        return False
    posture, core = posture_of(action), {*action} - PLAIN
    said = asked.learned.said_actions(seen.capture)
    if not posture:
        return any(not {*action}.isdisjoint({*words} - MODIFIERS) for words in said)
    is_at = posture.startswith("at ") and len(core) > 1  # "sit, ankle on knee, hand on chin"
    return any(posture_of(words) == posture or (is_at and core <= {*words}) for words in said)


def posture_though_excluded(
    asked: AskedWords, seen: SeenFrames, action: Sequence[str], start: int, end: int
) -> list[str] | None:
    """That frames [start, end) show the posture of an excluded action; None if it is no posture."""
    posture = seen_event(action, asked.numbers)
    if not posture or seen.is_away:
        return None
    is_seen = any(a < end and b > start for a, b in seen.events(posture))
    return [f"does {say_posture(posture)}, which is excluded"] if is_seen else []


def held_inside(times: Sequence[tuple[int, int]], low: int, high: int) -> list[tuple[int, int]]:
    """The parts of some times that are in frames [low, high), but short ones of longer times.

    >>> held_inside([(0, 30), (50, 54), (95, 120)], 10, 100)
    [(10, 30), (50, 54)]
    """
    inside = ((max(a, low), min(b, high), b - a) for a, b in times)
    return [(start, end) for start, end, long in inside if end - start >= min(HELD_FOR, long)]


def held_meanwhile(
    asked: AskedWords, seen: SeenFrames, action: Sequence[str], place: PartPlace
) -> tuple[PartPlace, list[str]]:
    """Where in a place somebody holds a posture for longest; against it, if nowhere.

    A caption that says it is not contradicted: a short touch may be elsewhere in the take.
    """
    posture = seen_event(action, asked.numbers)
    around = BESIDE if posture.startswith(("land", "takeoff")) else 0  # which a flight adjoins
    held = held_inside(seen.events(posture), place.start - around, place.end + around)
    start, end = max(held, key=lambda run: run[1] - run[0], default=(0, 0))
    if end:
        flights = [(a, b) for a, b in seen.events("jump") if around and a < end and b > start]
        start, end = min([start, *(a for a, _ in flights)]), max([end, *(b for _, b in flights)])
        return replace(unsure(place), start=start, end=end), []
    if _is_said(asked, seen, action):
        return unsure(place), []
    return unsure(place), [f"does not {say_posture(posture)} meanwhile"]


def other_posture(seen: SeenFrames, action: Sequence[str], place: PartPlace) -> list[str]:
    """That somebody does not stand or sit in a place, if so for most of it."""
    inside = seen.track[place.start : place.end]
    slow = np.hypot(inside[:, 1], inside[:, 2]) < WALKING
    holds = sitting(inside) if "sit" in action else standing(inside) & slow
    return [] if len(inside) and holds.mean() >= HOLDS else [f"does not {action[0]} meanwhile"]


def on_other_foot(seen: SeenFrames, action: Sequence[str], place: PartPlace) -> list[str]:
    """That somebody does not stand on one foot, or on that of a side, or hop from and onto it."""
    held = limb_held(action)
    if not held:
        return []
    leg = f"one {held[1]}" if held[0] == SINGLE else f"the {' '.join(held)}"
    posture = posture_of(action)
    event = hop_on(action) or (posture if posture.startswith("takeoff") else "")
    if event:
        is_on = any(a < place.end and b > place.start for a, b in seen.events(event))
    else:
        is_on = is_on_foot(seen.track[place.start : place.end, 4:6], as_said(held[0]))
    return [] if is_on else [f"is not on {leg} alone"]


def flown_to(action: Sequence[str]) -> str:
    """The side to which an action jumps, "sideways" for either; "" if it names none.

    >>> flown_to(("jump", "left")), flown_to(("hop", "left", "leg")), flown_to(("walk", "left"))
    ('left', '', '')
    >>> flown_to(("jump", "left", "right"))
    'sideways'
    """
    sides = {"left", "right", "sideways"}.intersection(action)
    is_plain = not (turning(action) or limbs_to_measure(action) or hop_on(action))
    if not (is_plain and sides and {*FLIGHTS}.intersection(action)):
        return ""
    return min(sides) if len(sides) == 1 else "sideways"


def is_flown(direction: str, action: Sequence[str]) -> bool:
    """Whether a direction is the side to which an action jumps."""
    return bool(flown_to(action)) and direction in ("left", "right", "sideways")


def goes_anywhere(seen: SeenFrames, action: Sequence[str], direction: str) -> bool:
    """Whether a take goes in a direction of an action anywhere, of jumps to a side in a flight."""
    if is_flown(direction, action) and not seen.is_away:
        return bool(events_of_side(seen, action, seen.events("jump")))
    return seen.goes_once(direction, turning(action))


def not_aimed(
    seen: SeenFrames, action: Sequence[str], place: PartPlace, believed: Collection[str]
) -> list[str]:
    """That no kick or punch in a place goes where the action says, nor its trunk leans so."""
    aims = aims_of(action)
    if not aims or seen.is_away or not {*aims}.isdisjoint(believed):
        return []
    event = event_of(action)
    times = seen.events(event) if event in ("kick", "punch") else [(place.start, place.end)]
    inside = [time for time in times if time[0] < place.end and time[1] > place.start]
    is_seen = any(goes_there(seen.track, action, *time) for time in inside)
    verb = next(word for word in action if word not in MODIFIERS)
    return [] if is_seen else [f"does not {verb} {' '.join(map(as_said, aims))}"]


def not_flown(seen: SeenFrames, action: Sequence[str], place: PartPlace) -> list[str]:
    """That no flight in a place goes to the side to which an action jumps."""
    flights = events_of_side(seen, action, seen.events("jump"))
    is_seen = any(a < place.end and b > place.start for a, b in flights)
    return [] if is_seen else [f"does not jump {flown_to(action)}"]


def events_of_side(
    seen: SeenFrames, action: Sequence[str], found: list[tuple[int, int]]
) -> list[tuple[int, int]]:
    """The turns and jumps to the side, and hops on the leg.

    Of other events those in which its limb clearly moves, all if there is none.
    """
    if hop_on(action):
        hops = seen.events(hop_on(action))
        return [hop for hop in found if hop in hops]
    aside = flown_to(action)
    if aside and not seen.is_away:
        goes_ahead = not {"forward", "backward", "back"}.isdisjoint(action)
        ways = [flown(seen.track, flight) for flight in found]
        to_side = [{"left": left, "right": -left}.get(aside, abs(left)) for left, _ in ways]
        least = [FLOWN if goes_ahead else max(FLOWN, abs(ahead)) for _, ahead in ways]
        return [f for f, way, bound in zip(found, to_side, least) if way >= bound]
    if aims_of(action) and not seen.is_away:
        return [time for time in found if goes_there(seen.track, action, *time)]
    if turning(action) and len(SIDES.intersection(action)) == 1 and not seen.is_away:
        sign = 1.0 if "left" in action else -1.0
        return [(a, b) for a, b in found if sign * seen.track[a:b, 3].sum() > 0.0]
    for side, limb in limbs_to_measure(action):
        speeds = limb_speeds(seen.limbs, limb, action)
        inside = [speeds[a // FEATURE_STEP : -(-b // FEATURE_STEP)] for a, b in found]
        clear = [f for f, part in zip(found, inside) if side_amount(part, side) >= CLEAR_SIDE]
        found = clear or found
    return found


def events_in_groups(found: Sequence[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """Events in groups, of which each follows the one before at once.

    >>> events_in_groups([(0, 10), (20, 30), (200, 210)])
    [[(0, 10), (20, 30)], [(200, 210)]]
    """
    groups: list[list[tuple[int, int]]] = []
    for one in found:
        if groups and one[0] - groups[-1][-1][1] <= AT_ONCE:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups
