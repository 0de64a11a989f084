"""Answers in the part of a take that a question names: "at the end", "in the first 2 s".

A place stays if it lies there, and so does its event, where the take has one. Otherwise the part
is looked for there: its event, or frames that reach half of the largest evidence of the take.
Answers carry no probabilities, since none was calibrated for parts of takes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP, runs
from motiondb.language.question.readings import KnownQuestion, Reading
from motiondb.language.question.tokens import WHOLE, time_of_take
from motiondb.language.vocabulary import MODIFIERS
from motiondb.meaning.edge_map import HALF
from motiondb.meaning.occurrences import event_of
from motiondb.meaning.postures import is_held
from motiondb.meaning.travelled import GOES, REST
from motiondb.search.asked_words import AskedWords
from motiondb.search.placing import PartPlace, unsure
from motiondb.search.seen_frames import SeenFrames

WHOLLY = 0.7  # Share of a take shown the whole time: who walks may rest before and after
LEAST_INSIDE = 9  # Frames (0.3 s), or half of a place, that lie in the part of the take


def asked_time(question: KnownQuestion, read: Sequence[Reading]) -> str:
    """The part of a take that a question of one action names; "" if it names none, or several."""
    times = [one.text for one in question.not_used if time_of_take(one.text, 1.0) is not None]
    is_one = len(times) == len(read) == len(read[0].parts) == 1
    part = read[0].parts[0]
    is_plain = is_one and not (read[0].exclusions or read[0].unseen)
    asked = part.said or part.actions
    is_open = bool(times) and _is_whole(times[0]) and not all(map(_goes_on, asked))
    return times[0] if is_plain and asked and not is_open else ""


def _is_whole(time: str) -> bool:
    """Whether a part of a question names a whole take."""
    return re.fullmatch(WHOLE, time, re.IGNORECASE) is not None


def _goes_on(action: Sequence[str]) -> bool:
    """Whether how long an action goes on is measured: of who travels, rests or holds a posture."""
    return not (GOES | REST).isdisjoint(action) or is_held(event_of(action))


def room_asked(seen: SeenFrames, time: str, room: slice) -> slice:
    """The feature frames of some that a question names; all of them without a time."""
    seconds = seen.n_frames / FEATURE_FPS
    start, end = time_of_take(time, seconds) or (0.0, seconds)
    first, behind = round(FEATURE_FPS * start), round(FEATURE_FPS * end)
    return slice(max(room.start, first), min(room.stop, behind))


def seconds_from_edge(seen: SeenFrames, time: str, place: PartPlace) -> float | None:
    """Whole seconds between a place and the beginning or end of a take that a question names."""
    if not time.lower().startswith("at the"):
        return None
    first, behind = place.start // FEATURE_STEP, -(-place.end // FEATURE_STEP)
    asked = room_asked(seen, time, slice(0, seen.n_frames))
    return float((first if asked.start == 0 else seen.n_frames - behind) // FEATURE_FPS)


def place_in_time(
    asked: AskedWords,
    seen: SeenFrames,
    time: str,
    actions: Sequence[Sequence[str]],
    place: PartPlace,
) -> tuple[PartPlace, list[str]]:
    """Where the actions of a part are in a part of the take, and what speaks against it."""
    room = room_asked(seen, time, slice(0, seen.n_frames))
    low, high = FEATURE_STEP * room.start, FEATURE_STEP * room.stop
    if _is_whole(time):
        lasting = min(seen.longest_going(action)[0] for action in actions)
        whole = replace(unsure(place), start=low, end=high, unknown=False)
        is_shown = lasting * FEATURE_FPS >= WHOLLY * seen.n_frames
        return (whole, []) if is_shown else (unsure(place), [f"not {time}"])

    def inside(one: tuple[int, int]) -> int:
        return min(one[1], high) - max(one[0], low)

    def lies_there(one: tuple[int, int]) -> bool:
        return inside(one) >= min(LEAST_INSIDE, max((one[1] - one[0]) // 2, 1))

    here = place.start, place.end
    event = event_of(actions[0]) if len(actions) == 1 else ""
    events = seen.events(event) if event and not seen.is_away else []
    if not place.unknown and lies_there(here) and not events:
        return unsure(place), []
    action = [word for words in actions for word in words]
    shown = events or _frames(runs(frames_that_show(asked, seen, action)))
    found = [one for one in shown if lies_there(one)]
    if not found:
        return unsure(place), [f"not {time}"]
    if any(a < place.end and b > place.start for a, b in found) and lies_there(here):
        return unsure(place), []
    start, end = max(found, key=inside)
    return replace(unsure(place), start=start, end=end, unknown=False), []


def _frames(times: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Frames [a, b) of times in feature frames."""
    return [(FEATURE_STEP * a, FEATURE_STEP * b) for a, b in times]


def frames_that_show(
    asked: AskedWords, seen: SeenFrames, action: Sequence[str]
) -> NDArray[np.bool_]:
    """Which feature frames reach half of the evidence of an action: array (frames,).

    Directions and limbs are left out of the evidence; of words whose places were not learned there
    is none.
    """
    known = [word for word in action if word in asked.numbers and word not in MODIFIERS]
    smooth = seen.smooth([asked.numbers[word] for word in known])
    if smooth is None:
        return np.zeros(seen.n_frames, dtype=bool)
    return np.asarray(smooth >= HALF * max(float(smooth.max()), 0.0))
