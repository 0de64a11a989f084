"""Steps at seams: a foot that would slide from one place to another is lifted there.

Where two clips are blended in which the feet stand differently, a foot moves from the place of the
one to that of the other within a few frames, on the ground. People take a step. So every slide, a
run of frames in which the foot moves without being lifted, becomes a step: the foot stays where it
was, is lifted, and is set down within 0.3 s where the next clip has it. If both feet slide at once,
the one that has farther to go steps first, and the other as soon as it is down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget
from motiondb.body.features import runs
from motiondb.generate.contact import foot_heights
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.polish.stepping import APART, LIFT, SWING, move_ankles

LIFTED = 0.025  # Height, m, above which a foot is seen to be lifted
SLIDE = 0.05  # Shortest slide that becomes a step, m: shorter ones are hardly visible
_STILL = 0.3
"""Speed of a foot, m/s, up to which it does not slide. With .15, a slide could not be told from a
slow lift of the foot after it."""
_PAUSE = 2  # Frames of rest between two slides that are one step
_QUICKEST = 4  # Fewest frames between the ends of a step; a slide with less time is left
ANKLES = [body.INDEX["l_ankle"], body.INDEX["r_ankle"]]
TOES = [body.INDEX["l_toe"], body.INDEX["r_toe"]]


@dataclass(frozen=True)
class Slide:
    """A slide of a foot."""

    foot: int  # 0 for the left foot, 1 for the right
    start: int  # Last frame at the old place
    end: int  # First frame at the new place
    # Horizontal distance between the places: that of the ankle or the toe, whichever is smaller
    metres: float


def find_slides(joints: FloatArray, blended: NDArray[np.bool_]) -> list[Slide]:
    """Find where feet slide in blends, in the order of time.

    Shapes: `joints` (frames, 21, 3), m; `blended` (frames,), bool.
    """
    heights, slides = foot_heights(joints), []
    for foot in range(2):
        ends = joints[:, [ANKLES[foot], TOES[foot]]][:, :, [0, 2]]
        steps = np.linalg.norm(np.diff(ends, axis=0), axis=-1).min(axis=1) * MOTION_FPS
        moving = steps > _STILL  # from each frame to the next
        for start, end in runs(~moving):
            if start > 0 and end < len(moving) and end - start <= _PAUSE:
                moving[start:end] = True
        for start, end in runs(moving):
            inside = slice(start, end + 1)
            far = float(np.linalg.norm(ends[end] - ends[start], axis=-1).min())
            on_ground = heights[inside, foot].max() <= LIFTED
            short = end - start <= SWING  # a longer one is a low swing of a capture
            if on_ground and short and far > SLIDE and blended[inside].any():
                slides.append(Slide(foot, start, end, far))
    return sorted(slides, key=lambda slide: (slide.start, slide.foot))


def step_at_seams(motion: Motion, blended: NDArray[np.bool_]) -> Motion:
    """Return the motion with a step in place of each slide of a foot; `blended` (frames,), bool."""
    if not blended.any():
        return motion
    positions, world = retarget.motion_positions(motion)
    target = positions[:, ANKLES].astype(np.float64)
    slides = find_slides(positions, blended)
    for slide, (start, end) in zip(slides, _times(slides, foot_heights(positions) > LIFTED)):
        if end - start >= _QUICKEST:
            _lift(target[:, slide.foot], slide, start, end)
    moved = (target != positions[:, ANKLES]).any(axis=(1, 2))
    return move_ankles(motion, (positions, world), target, moved) if moved.any() else motion


def _times(slides: list[Slide], lifted: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and the last frame of the step for each slide.

    A step takes SWING frames around its slide, or as many as the slide. Where both feet slide at
    once, each has SWING frames, before and after the middle. A step keeps to the frames around the
    slide in which its foot is not lifted.
    """
    times = []
    for slide in slides:
        middle = (slide.start + slide.end) // 2
        half = max(SWING, slide.end - slide.start) / 2.0
        start, end = round(middle - half), round(middle + half)
        for other in slides:
            if other.foot != slide.foot and other.start < slide.end and slide.start < other.end:
                middle = (slide.start + slide.end + other.start + other.end) // 4
                is_first = (-slide.metres, slide.foot) < (-other.metres, other.foot)
                start, end = (middle - SWING, middle) if is_first else (middle, middle + SWING)
        up = np.flatnonzero(lifted[:, slide.foot])
        before, after = up[up < slide.start], up[up > slide.end]
        least = int(before[-1]) + 1 if len(before) else 0
        most = int(after[0]) - 1 if len(after) else len(lifted) - 1
        times.append((max(start, least), min(end, most)))
    return times


def _lift(ankle: FloatArray, slide: Slide, start: int, end: int) -> None:
    """Hold an ankle, array (frames, 3), up to ``start``, and set it down again at ``end``."""
    first, last = min(slide.start, start), max(slide.end, end)
    frames = slice(first, last + 1)
    share = np.clip((np.arange(first, last + 1) - start) / (end - start), 0.0, 1.0)
    smooth = (share * share * (3.0 - 2.0 * share))[:, None]
    away = ankle[last, [0, 2]] - ankle[first, [0, 2]]
    ankle[frames, 0::2] = ankle[first, 0::2] + smooth * away
    ankle[frames, 1] += LIFT * min(1.0, slide.metres / APART) * np.sin(np.pi * share)
