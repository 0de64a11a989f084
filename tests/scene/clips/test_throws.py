"""Where somebody throws, by hands that come together, rise and sink: frames made by hand."""

from __future__ import annotations

import numpy as np

from motiondb.scene.clips.clip_cutting import AROUND, HELD, LANDED, WRISTS, BodyFrames, throw_frames


def hands(heights: np.ndarray, gaps: np.ndarray) -> BodyFrames:
    """Wrists at heights and so far apart, metres; all other joints are at 1 m."""
    joints = np.zeros((len(heights), 21, 3))
    joints[..., 1] = 1.0
    joints[:, WRISTS, 1] = heights[:, None]
    joints[:, WRISTS[0], 0] = gaps
    still = np.zeros((len(heights), 2), dtype=bool)
    return BodyFrames(np.zeros((len(heights), 3)), joints, np.zeros_like(joints), still)


def play(together: int = 60, n_frames: int = 160) -> BodyFrames:
    """Hands apart, together from a frame, up until 90 and apart from there, down from 120."""
    frame = np.arange(n_frames)
    heights = np.where(frame < 120, 0.8 + np.clip((frame - 70) / 20.0, 0.0, 1.0), 0.7)
    heights[90] += 0.1  # the highest
    gaps = np.where((frame >= together) & (frame < 90), HELD - 0.1, HELD + 0.3)
    return hands(heights, gaps)


def test_a_throw_lasts_from_the_hands_coming_together_to_their_sinking() -> None:
    assert throw_frames(play(), 0, 160) == (60, 120)
    assert throw_frames(play(), 65, 100) == (65, 100)  # nothing outside of what is asked about


def test_it_lasts_no_longer_than_clips_do() -> None:
    assert throw_frames(play(together=5), 0, 160) == (90 - AROUND, 120)
    up = play()
    up.joints[91:, WRISTS, 1] = 1.5
    assert throw_frames(up, 0, 160) == (60, 90 + AROUND)


def test_hands_that_were_together_before_do_not_count() -> None:
    """A catch at 10 to 20, a dribble, and then the shot."""
    frames = play()
    frames.joints[10:20, WRISTS[0], 0] = HELD
    assert throw_frames(frames, 0, 160) == (60, 120)


def test_one_hand_throws_too() -> None:
    frames = play(together=90)
    assert throw_frames(frames, 0, 160) == (90 - AROUND, 120)


def test_who_jumps_is_given_time_to_land() -> None:
    frames = play()
    frames.joints[95:, WRISTS, 1] = 0.7
    assert throw_frames(frames, 0, 160) == (60, 90 + LANDED)
