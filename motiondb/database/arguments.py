"""Arguments of public verbs that are of the wrong kind or size, told before any work."""

from __future__ import annotations

import operator
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb.errors import QueryError
from motiondb.records import Clip, Motion

if TYPE_CHECKING:
    import numpy as np

Example = str | Path | Clip | Motion
"""A file, the name of a stored capture, or a motion."""


def check_example(value: object) -> None:
    """Refuse an argument that is no example."""
    if not isinstance(value, Example):
        raise QueryError(
            "example: expected a file, the name of a capture, a motiondb.Clip or a "
            f"motiondb.Motion, found {type(value).__name__}."
        )


def check_text(name: str, value: object) -> None:
    """Refuse an argument that is no text."""
    if not isinstance(value, str):
        raise QueryError(f"{name}: expected a text, found {_said(value)}.")


def check_whole(name: str, value: object, least: int) -> None:
    """Refuse an argument that is no whole number, or smaller than the least."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]  # tells what is no whole number
    except TypeError:
        number = least - 1
    if number < least:
        raise QueryError(f"{name}: expected a whole number from {least} on, found {_said(value)}.")


def seeded(seed: int) -> np.random.Generator:
    """A generator of random numbers from the seed of a user."""
    import numpy as np

    check_whole("seed", seed, 0)
    return np.random.default_rng(seed)


def seeds_from(seed: int, number: int) -> range:
    """The seeds of some motions: that of the user, and the following ones."""
    check_whole("seed", seed, 0)
    return range(seed, seed + number)


def _said(value: object) -> str:
    """A value and its type, short enough for a message."""
    return f"{str(value)[:60]} ({type(value).__name__})"
