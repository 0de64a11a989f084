"""How the loops over scenes are compiled: cached, without the global lock or reference counts.

numba counts references to each array of a tuple when a function is called and when it returns,
which takes ten times as long as most of these functions. Without counting, a compiled function may
read, write and slice the arrays it is given, and return numbers. It must not create arrays or
return them.
"""

from __future__ import annotations

from numba import njit

compiled = njit(cache=True, nogil=True, _nrt=False)  # type: ignore[call-overload]  # no _nrt there
"""Decorator of functions over a scene's arrays."""
