"""Sentences of findings."""

from __future__ import annotations


def times(start: float, end: float) -> str:
    """When something is, in words.

    >>> times(2.94, 8.71), times(0.0, 0.008)
    ('2.9 to 8.7 s', '0.00 to 0.01 s')
    """
    places = 1 if end - start >= 0.1 else 2
    return f"{start:.{places}f} to {end:.{places}f} s"
