"""Compilation of the short functions that the compiled programs of grammars call most often."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., object])


def kernel(function: F) -> F:
    """Compile a function that gets arrays and returns numbers, without counting references.

    Otherwise a function with a tuple of arrays as its argument counts references to each of them
    when it is called and when it returns, which takes longer than most of these functions. Without
    counting, a function may read and write the arrays it gets; it must not make arrays, copy slices
    or return an array.
    """
    made = njit(cache=True, _nrt=False)(function)  # type: ignore[call-overload]  # not in its types
    return cast(F, made)
