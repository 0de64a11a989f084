"""motiondb: a motion-capture database that understands what is in it.

Open a database with :func:`open`; everything that the commands do is a method of the
:class:`MotionDB` that it gives.

>>> import motiondb
>>> [name for name in dir(motiondb) if name.startswith("write")]
['write_bvh', 'write_gltf']
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.capture import read_capture
    from motiondb.database import MotionDB
    from motiondb.database.catalogue.file_reading import AddSettings
    from motiondb.database.grammars.grammar_learning import GrammarSettings
    from motiondb.database.scenes.scene_making import SceneSettings
    from motiondb.errors import MotionDBError
    from motiondb.learning.symbol_fitting import LearnSettings
    from motiondb.records import Clip, Motion

__all__ = [
    "AddSettings",
    "Clip",
    "GrammarSettings",
    "LearnSettings",
    "Motion",
    "MotionDB",
    "MotionDBError",
    "SceneSettings",
    "__version__",
    "compact",
    "open",
    "read_capture",
    "write_bvh",
    "write_gltf",
]
__version__ = "0.1.0"

_PUBLIC = {
    "AddSettings": "motiondb.database.catalogue.file_reading",
    "Clip": "motiondb.records",
    "GrammarSettings": "motiondb.database.grammars.grammar_learning",
    "LearnSettings": "motiondb.learning.symbol_fitting",
    "Motion": "motiondb.records",
    "MotionDB": "motiondb.database",
    "MotionDBError": "motiondb.errors",
    "SceneSettings": "motiondb.database.scenes.scene_making",
    "read_capture": "motiondb.capture",
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
        When another process holds the file, or it is no database of motiondb, or one of a newer
        motiondb.
    """
    from motiondb.database import MotionDB

    return MotionDB(path, read_only=read_only, wait=wait)


def compact(path: str | Path) -> tuple[int, int]:
    """Rewrite a database file without the space that removed rows left.

    Parameters
    ----------
    path : str or Path
        The DuckDB file; nobody may have it open.

    Returns
    -------
    tuple of int
        Size in bytes before and after.

    Raises
    ------
    MotionDBError
        When the file is held, or is no database of motiondb.
    """
    from motiondb import store

    return store.compact(Path(path))


def write_bvh(motion: Clip | Motion, path: str | Path) -> None:
    """Write a clip or a motion as BVH; the file appears whole or not at all.

    Parameters
    ----------
    motion : Clip or Motion
        A motion is written on the canonical body in the performer's size, 30 frames a second.
    path : str or Path
        The file.

    Raises
    ------
    MotionDBError
        When it is neither, has no frames or numbers that are not finite, or the file cannot be
        written.
    """
    from motiondb import capture

    capture.write_bvh(_to_clip(motion), path)


def write_gltf(motion: Clip | Motion, path: str | Path) -> None:
    """Write a clip or a motion as glTF (.glb or .gltf); the file appears whole or not at all.

    Parameters
    ----------
    motion : Clip or Motion
        A motion is written on the canonical body in the performer's size, 30 frames a second.
    path : str or Path
        The file.

    Raises
    ------
    MotionDBError
        When it is neither, has no frames or numbers that are not finite, or the file cannot be
        written.
    """
    from motiondb import capture

    capture.write_gltf(_to_clip(motion), path)


def _to_clip(motion: object) -> Clip:
    from motiondb.errors import MotionDBError
    from motiondb.pose import retarget
    from motiondb.records import Clip, Motion

    if isinstance(motion, Motion):
        return retarget.to_clip(motion)
    if isinstance(motion, Clip):
        return motion
    raise MotionDBError(
        f"motion: expected a motiondb.Clip or a motiondb.Motion, found {type(motion).__name__}. "
        "What db.generate gives is written by its own method write, or by its attribute motion."
    )


def __getattr__(name: str) -> object:
    """Import a public name when it is first used, so that the command line starts fast."""
    if name in _PUBLIC:
        from importlib import import_module

        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'motiondb' has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names, and those that every module has."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
