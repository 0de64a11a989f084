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


def open(path: str | Path = "motions.duckdb", *, read_only: bool = False) -> MotionDB:
    """Open a motion database, or make a new one.

    Parameters
    ----------
    path : str or Path, optional
        The DuckDB file.
    read_only : bool, optional
        Whether to ask questions only; then several processes may open the file at once.

    Raises
    ------
    MotionDBError
        If another process holds the file, or if it is not a motion database, or a newer one.
    """
    from motiondb.database import MotionDB

    return MotionDB(path, read_only=read_only)


def __getattr__(name: str) -> Any:  # noqa: ANN401  each public name has a type of its own
    """Public names are imported when they are first used: the command line starts fast."""
    if name in _PUBLIC:
        from importlib import import_module

        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'motiondb' has no attribute {name!r}")
