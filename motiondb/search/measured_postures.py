"""Postures of answers as the motion shows them: raised hands, lying, kneeling, one leg."""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.meaning.occurrences import posture_of, say_posture
from motiondb.search.asked_words import AskedWords
from motiondb.search.seen_frames import SeenFrames


def lacks_posture(
    asked: AskedWords,
    seen: SeenFrames,
    action: Sequence[str],
    found: Sequence[tuple[int, int]] | None = None,
) -> bool:
    """Whether a take does not show the posture of an action, and no caption of it says so.

    `found`: Where it was found; None: look for it in the whole take.
    """
    posture = posture_of(action)
    if not posture or seen.is_away or _is_said(asked, seen, posture):
        return False
    return not (seen.events(posture) if found is None else found)


def leaves_posture_open(
    asked: AskedWords, seen: SeenFrames, action: Sequence[str], start: int, end: int
) -> bool:
    """Whether the posture of an action is seen alone, or both hands are up in place of one.

    How probable an answer is was never measured of what no caption of it says. [start, end): its
    frames.
    """
    posture = posture_of(action)
    what, _, side = posture.partition(" ")
    if not posture or seen.is_away:
        return False
    both = seen.events(f"{what} both") if side in ("left", "right") and what != "on" else []
    return not _is_said(asked, seen, posture) or any(a < end and b > start for a, b in both)


def _is_said(asked: AskedWords, seen: SeenFrames, posture: str) -> bool:
    """Whether a caption of a take says a posture."""
    if asked.evidence.written.get(seen.capture) is None:
        return False
    return any(posture_of(words) == posture for words in asked.learned.said_actions(seen.capture))


def posture_though_excluded(
    seen: SeenFrames, action: Sequence[str], start: int, end: int
) -> list[str] | None:
    """That frames [start, end) show the posture of an excluded action; None if it is no posture."""
    posture = posture_of(action)
    if not posture or seen.is_away:
        return None
    is_seen = any(a < end and b > start for a, b in seen.events(posture))
    return [f"does {say_posture(posture)}, which is excluded"] if is_seen else []
