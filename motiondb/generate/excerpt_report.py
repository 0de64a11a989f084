"""Report on an action: which counts, durations and speeds the motion has, and which it does not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.body.contacts import MAX_HEIGHT
from motiondb.generate.excerpt_motion import ShownExcerpt
from motiondb.generate.excerpts import counted_word
from motiondb.generate.sentence_plan import Amount, PlannedAction, is_within, say_times
from motiondb.language.question.amounts import adverb_of
from motiondb.language.question.readings import say_duration
from motiondb.language.question.tree import NotUsed
from motiondb.learn.learned import Learned
from motiondb.meaning.amounts import amounts_of, is_gauged, off, outside, say_amount
from motiondb.meaning.direction import FULLY, gone, say_measured
from motiondb.meaning.occurrences import FLIGHTS, KICKED, find_occurrences
from motiondb.meaning.place_certainty import count_performers, cues_of
from motiondb.meaning.regression import probability
from motiondb.records import MOTION_FPS, FloatArray

SEAM = 0.6  # Seconds that a seam, which bends half a second, may take from a posture


def say_amounts(action: PlannedAction) -> list[str]:
    """Count, duration and speed of an action as words; those that are not asked for are left out.

    >>> from motiondb.generate.sentence_plan import Amount
    >>> say_amounts(PlannedAction((("walk",),), "slow", (), Amount(3, 3), Amount(2.0, None)))
    ['3 times', 'for at least 2 s', 'slowly']
    """
    said = []
    if action.times is not None:
        said.append(say_times(action.times))
    if action.seconds is not None:
        said.append(say_duration(action.seconds.least, action.seconds.most))
    if action.speed:
        said.append(adverb_of(action.speed))
    return said


def report_excerpt(
    learned: Learned, shown: ShownExcerpt, track: FloatArray
) -> tuple[tuple[str, ...], tuple[NotUsed, ...]]:
    """Return the counts, durations and speeds that an action has, and those that were not met.

    `track` (frames, 16): What is measured in its part of the motion.
    """
    action, layout = shown.action, shown.layout
    name = learned.captures[shown.excerpt.capture].name
    first, behind = source_span(shown)
    done = [f"{name} {first:.1f}-{behind:.1f} s"]
    left = []
    seconds = shown.n_frames / MOTION_FPS
    if layout.said:
        done.append(layout.said)
    if shown.rate != 1.0 and not action.speed:
        done.append(f"played at {shown.rate:.2f} of its speed, so that it lasts {seconds:.1f} s")
    done += [
        f"{learned.captures[piece.capture].name} {piece.start / MOTION_FPS:.1f}-"
        f"{piece.end / MOTION_FPS:.1f} s"
        for piece in shown.between
    ]
    does = [word for word in shown.directions if gone(track, word) >= FULLY]
    done += [f"{say_measured(word)}: measured in the motion" for word in does]
    left += _cut_off(shown.directions, track)
    if action.seconds is not None and not is_within(seconds, action.seconds):
        text = say_duration(action.seconds.least, action.seconds.most)
        why = "whole repetitions" if action.times is not None else "whole performances"
        left.append(NotUsed(text, f"{why} last {seconds:.1f} s"))
    left += held_otherwise(action, track)
    gauged, not_met = gauged_otherwise(action, track)
    done, left = done + gauged, left + not_met
    if action.speed:
        said, not_said = _report_speed(shown)
        done += said
        left += not_said
    return (*done, *_say_places(shown)), tuple(left)


def held_otherwise(action: PlannedAction, track: FloatArray) -> list[NotUsed]:
    """The count and the duration of a posture that are measured to be others."""
    if not action.posture:
        return []
    left, held = [], find_occurrences(track, action.posture)
    longest = max((end - start for start, end in held), default=0) / MOTION_FPS
    times, seconds = action.times, action.seconds
    if times is not None and not is_within_count(len(held), times):
        left.append(NotUsed(say_times(times), f"{len(held)} measured in the motion"))
    if seconds is not None and longest < seconds.least - min(SEAM, seconds.least / 3.0) - 1e-6:
        text = say_duration(seconds.least, seconds.most)
        left.append(NotUsed(text, f"the posture is held for {longest:.1f} s"))
    return left


def gauged_otherwise(action: PlannedAction, track: FloatArray) -> tuple[list[str], list[NotUsed]]:
    """The angle, way, speed or steps of an action that were asked for, as measured, and if not."""
    measure = action.measure
    if measure is None:
        return [], []
    if action.times is not None or not is_gauged(measure, action.words):
        return [], [NotUsed(measure.say(), "it is measured of one turn, way or walk alone")]
    found = [amount for amount, *_ in amounts_of(measure, action.words, track)]
    if not found:
        return [], [NotUsed(measure.say(), "nothing of it is measured in the motion")]
    amount = min(found, key=lambda one: off(measure, action.words, one))
    told = say_amount(measure, action.words, amount)
    if outside(measure, action.words, amount) > 0.0:
        return [], [NotUsed(measure.say(), f"it {told}")]
    return [f"{measure.say()}: it {told}"], []


def is_within_count(count: float, times: Amount) -> bool:
    """Whether something was counted as often as was asked for."""
    return times.least <= count <= (np.inf if times.most is None else times.most)


def _cut_off(directions: Sequence[str], track: FloatArray) -> list[NotUsed]:
    """Flights and kicks that the first or the last frame is in the middle of.

    >>> track = np.zeros((60, 6)); track[:8, 4:] = 0.2
    >>> [(one.text, one.reason) for one in _cut_off(["jump", "left"], track)]
    [('jump', 'its beginning is cut off')]
    """
    left = []
    for word in directions:
        for frame, which in ((0, "beginning"), (-1, "end")):
            feet = track[frame, 4:6]
            is_up = word in FLIGHTS and feet.min() > MAX_HEIGHT
            if is_up or (word == "kick" and feet.max() > KICKED):
                left.append(NotUsed(word, f"its {which} is cut off"))
    return left


def miscounted(shown: ShownExcerpt, track: FloatArray) -> tuple[NotUsed, ...]:
    """The count that was asked for, if another one is measured in the motion."""
    times = shown.action.times
    word = counted_word(shown.action)
    if times is None or word is None:
        return ()
    count = len(find_occurrences(track, word)) / shown.layout.each
    if is_within_count(count, times):
        return ()
    return (NotUsed(say_times(times), f"{count:g} measured in the motion"),)


def _say_places(shown: ShownExcerpt) -> list[str]:
    """How many places show an action about as clearly, or that its excerpt was picked.

    Nothing for an excerpt that does not do what is measured and therefore is none of them.
    """
    if shown.is_picked:
        return ["the excerpt that was picked"]
    if shown.place < 0 and not shown.does:
        return []
    if shown.place < 0 and shown.n_places == 1:
        return ["1 other excerpt shows it more clearly, but joins less well"]
    if shown.place < 0:
        return [f"{shown.n_places} other excerpts show it more clearly, but join less well"]
    if shown.n_places == 1:
        return ["only one good excerpt, so --seed changes nothing here"]
    number = f"this is number {shown.place + 1}. --seed picks others"
    return [f"{shown.n_places} similar excerpts found; {number}"]


def source_span(shown: ShownExcerpt) -> tuple[float, float]:
    """First and last second of the capture that is played."""
    first = min(start for start, _ in shown.layout.parts) * shown.rate / MOTION_FPS
    return first, max(end for _, end in shown.layout.parts) * shown.rate / MOTION_FPS


def place_probability(learned: Learned, shown: ShownExcerpt) -> float | None:
    """Probability that an excerpt is the right place of its capture for its action.

    None where it was not learned, and where the capture is described with this action alone.
    """
    capture, sure = shown.excerpt.capture, learned.certainties.place
    placed = learned.placed
    take = None if placed is None else placed.take(capture)
    words = [learned.word_numbers[w] for w in shown.action.words if w in learned.word_numbers]
    n_actions = max((d.n_actions for d in learned.described if d.capture_id == capture), default=1)
    if sure is None or placed is None or take is None or not words or n_actions == 1:
        return None
    first, last = (MOTION_FPS * second for second in source_span(shown))
    inside = np.flatnonzero(np.minimum(take.ends, last) - np.maximum(take.starts, first) > 0.0)
    values = take.windows[:, words].mean(axis=1)
    support = count_performers(placed.listed_by, words, [learned.performers[capture]])
    if not support:
        return None
    cues = cues_of(values, int(inside[0]), int(inside[-1]) + 1, support)
    return float(probability(sure.log_odds(cues)))


def segments_of(learned: Learned, shown: ShownExcerpt) -> list[int]:
    """Symbols of the segments of which the parts of an excerpt play at least half."""
    segments: list[int] = []
    parts = [(shown.excerpt.capture, a * shown.rate, b * shown.rate) for a, b in shown.layout.parts]
    parts[1:1] = [(piece.capture, piece.start, piece.end) for piece in shown.between]
    for capture, low, high in parts:
        rows = learned.rows[capture]
        starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
        symbols = learned.segments.symbols[rows]
        inside = np.minimum(ends, high) - np.maximum(starts, low)
        which = np.flatnonzero(2.0 * inside >= ends - starts)
        if len(which) == 0:
            which = np.array([int(np.argmax(inside))])
        segments += symbols[which].tolist()
    return segments


def compare_speed(
    asked: str, how: str, speeds: tuple[float, float, float] | None
) -> tuple[list[str], list[NotUsed]]:
    """Whether a motion is "slow" or "fast" as asked: what is done, and what is not.

    `speeds`: Its speed, and the least and largest of the captures of its action, m/s.

    >>> compare_speed("fast", "as recorded", (2.0, 1.0, 2.5))
    (['fast: as recorded, 2.00 m/s; captures 1.00 to 2.50'], [])
    """
    text = adverb_of(asked)
    if speeds is None or speeds[1] >= speeds[2]:
        return [], [NotUsed(text, "one capture alone shows the action: its range is not known")]
    speed, least, most = speeds
    if ((speed - least) / (most - least) > 0.5) == (asked == "fast"):
        return [f"{text}: {how}, {speed:.2f} m/s; captures {least:.2f} to {most:.2f}"], []
    reason = f"{how}, {speed:.2f} m/s; the captures' range is {least:.2f} to {most:.2f}"
    return [], [NotUsed(text, reason)]


def _report_speed(shown: ShownExcerpt) -> tuple[list[str], list[NotUsed]]:
    how = f"played at {shown.rate:.2f} of its speed" if shown.rate != 1.0 else "as recorded"
    speeds = shown.speeds and (shown.speeds[0] * shown.rate, *shown.speeds[1:])
    return compare_speed(shown.action.speed, how, speeds)
