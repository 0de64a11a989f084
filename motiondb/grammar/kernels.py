"""Compiled functions: how they are compiled, and how their compiling is kept short.

numba compiles a function once for each kind of arguments, with all that it calls, and keeps the
result on disk. The first call in a new install waits for it, a quarter of a second for a function.
Two things that it would make by itself are left out here: a second entry for programs in C, and a
further version for each integer that is written out in a call, such as ``since=0``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from numba import njit, types

F = TypeVar("F", bound=Callable[..., object])


def maker(function: F) -> F:
    """Compile a function that makes arrays."""
    return _made(function)


def kernel(function: F) -> F:
    """Compile a function that gets arrays and returns numbers, without counting references.

    Otherwise a function with a tuple of arrays as its argument counts references to each of them
    when it is called and when it returns, which takes longer than most of these functions. Without
    counting, a function may read, write and slice the arrays it gets; it must not make arrays,
    return an array or call a :func:`maker`.
    """
    return _made(function, _nrt=False)


def inlined(function: F) -> F:
    """Compile a small kernel into those that call it: a call passes all arrays of a scene."""
    return _made(function, _nrt=False, forceinline=True)


def merged(function: F) -> F:
    """Compile a function into the one kernel that calls it, which takes less time than two."""
    return _made(function, inline="always")


def _made(function: F, **options: bool | str) -> F:
    settings: Any = {"cache": True, "nogil": True, "no_cfunc_wrapper": True, **options}
    made: Any = njit(**settings)(function)
    template = getattr(made, "get_call_template", None)
    if template is None:  # not compiled at all, as NUMBA_DISABLE_JIT asks for
        return function

    def without_literals(args: Sequence[Any], kws: Mapping[str, Any]) -> object:
        return template(
            [types.unliteral(one) for one in args],
            {name: types.unliteral(one) for name, one in kws.items()},
        )

    made.get_call_template = without_literals
    result: F = made
    return result
