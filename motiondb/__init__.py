"""motiondb: a motion-capture database that understands what is in it.

>>> import motiondb
>>> motiondb.open  # doctest: +ELLIPSIS
<function open at ...>
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motiondb.database import MotionDB

__all__ = [
    "MotionDB",
    "MotionDBError",
    "__version__",
    "open",
    "read_capture",
    "write_bvh",
    "write_gltf",
]
__version__ = "0.1.0"

_PUBLIC = {
    "MotionDB": "motiondb.database",
    "MotionDBError": "motiondb.errors",
    "read_capture": "motiondb.capture",
    "write_bvh": "motiondb.capture",
    "write_gltf": "motiondb.capture",
}


def open(
    path: str | Path = "motions.duckdb", *, read_only: bool = False, wait: float = 0.0
) -> MotionDB:
    """Open a motion database, or make a new one.

    Parameters
    ----------
    path : str or Path
        The DuckDB file.
    read_only : bool
        Whether only to ask; several processes may do so at once.
    wait : float
        Seconds to wait for another process that holds the file.

    Raises
    ------
    MotionDBError
        when another process holds the file, or it is no motion database, or a newer one.
    """
    from motiondb.database import MotionDB

    return MotionDB(path, read_only=read_only, wait=wait)


def __getattr__(name: str) -> Any:
    """Public names are imported when they are first used: the command line starts fast."""
    if name in _PUBLIC:
        from importlib import import_module

        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'motiondb' has no attribute {name!r}")
