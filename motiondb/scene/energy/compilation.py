"""How the loops of scenes are compiled: cached, without the interpreter's lock, nothing counted.

A function that is given a tuple of many arrays otherwise counts the references of each of them on
the way in and out, which takes ten times as long as what most of these functions do. Without
counting, a compiled function may read, write and slice the arrays it is given, and return numbers;
it must not make arrays, nor return one.
"""

from __future__ import annotations

from numba import njit

compiled = njit(cache=True, nogil=True, _nrt=False)  # type: ignore[call-overload]
"""Decorator of functions over a scene's arrays."""
