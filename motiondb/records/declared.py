"""What a record declares about its fields: axes of arrays and ranges of numbers.

A field is declared in its type, as in ``means: Annotated[FloatArray, Axes("symbols", "states")]``.
:mod:`motiondb.learn.codec` reads these declarations, and :mod:`motiondb.learn.knowledge_check`
refuses files whose numbers do not keep to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

LARGEST = 1e9  # Bound on every number of a file


class Axes:
    """Sizes of the axes of an array: numbers, names that mean one size throughout, or any (None).

    The half above the diagonal of a symmetric matrix is not stored.
    """

    def __init__(self, *sizes: int | str | None, symmetric: bool = False) -> None:
        self.sizes = sizes
        self.symmetric = symmetric


@dataclass(frozen=True)
class Within:
    """Bounds of the numbers of a field, and what a message says is expected of them."""

    low: float
    high: float
    what: str
    is_whole: bool = False  # Whether the numbers are integers


@dataclass(frozen=True)
class Sizes:
    """Sizes by name that hold in one field's record."""

    by_name: Mapping[str, int]


class MayBeUnknown:
    """A number that may be NaN."""
