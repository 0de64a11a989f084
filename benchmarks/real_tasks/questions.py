"""Questions about the real captures: words, examples and sentences, with the right answers.

A hit of a word search is right where the people who described the capture used all the asked words;
Verdicts in ``notes.md`` take precedence. A hit of a search by example is
right where the description holds one of ``words``; in the four long takes, whose parts are known,
at least half of it must lie in parts with one of ``labels``.
"""

from __future__ import annotations

from dataclasses import dataclass

WORDS = (
    "walk",
    "run",
    "jump",
    "kick",
    "punch",
    "sit",
    "dance",
    "dribble",
    "climb",
    "cartwheel",
    "wave",
    "box",
    "wash window",
    "turn left",
    "reach up",
    "walk then jump",
    "run, turn left",
    "sit, stand up",
    "run, jump, run",
    "jumping jacks, jog, squats",
)


@dataclass(frozen=True)
class Example:
    """A stored capture, or a part of it (seconds), to look for; and what would be right."""

    name: str
    capture: str
    start: float | None
    end: float | None
    words: tuple[str, ...]
    labels: tuple[str, ...] = ()


EXAMPLES = (
    Example("walking", "07/07_01", None, None, ("walk",), ("walk",)),
    Example("running", "16/16_35", None, None, ("run", "jog"), ("Jog",)),
    Example("jumping forward", "16/16_05", None, None, ("jump", "hop"), ("jump",)),
    Example("dribbling", "06/06_08", 0.0, 4.0, ("dribble",)),
    Example("salsa", "60/60_05", 6.0, 11.0, ("dance", "salsa")),
    Example("washing windows", "14/14_10", 3.0, 9.0, ("wash", "window")),
    Example("jumping jacks", "14/14_06", 0.0, 3.6, ("jack",), ("JumpJack",)),
    Example("boxing", "14/14_06", 38.0, 43.0, ("box", "punch"), ("Box", "punch")),
    Example("a jump in a long take", "86/86_01", 5.0, 9.0, ("jump", "hop"), ("jump",)),
    Example("kicking", "86/86_01", 27.0, 33.5, ("kick",), ("leg_kick",)),
)
"""Captures and seconds. Chosen by hand."""

SENTENCES = (
    "a person walks then kicks",
    "run, jump",
    "sit down, stand up",
    "walk, turn left, walk",
    "boxing",
)
SEED = 7
"""Seed of generated motion."""

PARTS = (
    ("walk", ("walk",)),
    ("jump", ("jump",)),
    ("kick", ("leg_kick",)),
    ("punch", ("punch",)),
    ("jumping jacks", ("JumpJack",)),
    ("jog", ("Jog",)),
    ("squat", ("Squat",)),
    ("twist", ("Twist",)),
)
"""(words, labels of the right parts), searched in each long take alone."""
