"""Parts of answers that are as far or as fast as a question asks (:mod:`motiondb.meaning.amounts`).

Answers carry no probabilities, since none was calibrated for measures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motiondb.body.features import FEATURE_STEP
from motiondb.language.question.amounts import Measure
from motiondb.language.question.readings import Part
from motiondb.meaning.amounts import is_gauged, off, outside, say_amount
from motiondb.meaning.travelled import turning
from motiondb.search.placing import PartPlace, unsure
from motiondb.search.seen_frames import SeenFrames


def gauged_action(part: Part, actions: Sequence[Sequence[str]]) -> Sequence[str]:
    """The only action of a part that its measure is measured of, of angles the turn; () if none is.

    >>> turn = Part((("turn", "left"), ("walk",)), measure=Measure("angle", 90, 90))
    >>> gauged_action(turn, turn.actions), gauged_action(turn, [("wave",)])
    (('turn', 'left'), ())
    """
    measured = [a for a in actions if part.measure is not None and is_gauged(part.measure, a)]
    if part.measure is not None and part.measure.what == "angle" and len(measured) > 1:
        measured = [action for action in measured if turning(action)]
    return measured[0] if len(measured) == 1 else ()


def gauge(
    seen: SeenFrames, measure: Measure, action: Sequence[str], place: PartPlace, room: slice
) -> tuple[PartPlace, list[str], list[str]]:
    """Where a part is as far or fast as asked, what speaks against it, and what was measured.

    `room`: The feature frames in which the part may be.
    """
    if seen.is_away:
        return unsure(place), [], []
    found = seen.amounts(measure, action)
    inside = [one for one in found if room.start <= (one[1] + one[2]) / 2 <= room.stop]
    if not inside:
        return unsure(place), [f"no {'turn' if measure.what == 'angle' else 'way'} is seen"], []

    def rank(one: tuple[float, int, int]) -> tuple[float, bool, float]:
        beyond, apart = off(measure, action, one[0])
        here = one[1] < place.end / FEATURE_STEP and one[2] > place.start / FEATURE_STEP
        return beyond, not here, apart

    amount, first, behind = min(inside, key=rank)
    told = say_amount(measure, action, amount)
    if outside(measure, action, amount) > 0.0:
        return unsure(place), [f"{told}, not {measure.say()}"], []
    first, behind = max(first, room.start), min(behind, room.stop)
    moved = replace(place, start=FEATURE_STEP * first, end=FEATURE_STEP * behind, unknown=False)
    return unsure(moved), [], [told]
