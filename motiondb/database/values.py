"""Values that callers give, checked where a mistake is likely."""

from __future__ import annotations

import operator
import reprlib
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from motiondb.errors import QueryError

if TYPE_CHECKING:
    import numpy as np

    from motiondb.records import Clip, Motion

    Example: TypeAlias = str | Path | Clip | Motion
    Where: TypeAlias = str | Iterable[str]
    """A filter on the catalogue, or the names of captures."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60


def check_least(name: str, value: int, least: int) -> None:
    """Refuse a whole number that is smaller than the least."""
    if value < least:
        raise QueryError(
            f"{name}: expected a whole number from {least} on, found {_SHORT.repr(value)}."
        )


def check_text(name: str, value: object) -> None:
    """Refuse what is no text, such as words in a list."""
    if not isinstance(value, str):
        raise QueryError(f"{name}: expected a text, found {_SHORT.repr(value)}.")


def listed(name: str, values: Iterable[str]) -> list[str]:
    """Return several texts as a list; a single text is refused, since its letters are texts too."""
    if isinstance(values, str):
        found = _SHORT.repr(values)
        raise QueryError(f"{name}: expected several texts, found {found}. Put it in a list.")
    return list(values)


def seeded(seed: int) -> np.random.Generator:
    """A generator of random numbers from the seed of a user."""
    import numpy as np

    check_least("seed", seed, 0)
    return np.random.default_rng(seed)


def seeds_from(seed: int, number: int) -> range:
    """The seeds of some motions: that of the user, and the following ones."""
    check_least("seed", seed, 0)
    return range(operator.index(seed), seed + number)
