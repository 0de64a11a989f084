"""Results that are kept on disk between runs: what takes minutes, for the same input and code.

A result is kept under the digest of its arguments and of the source of the packages that it
depends on, so that it is computed again when either changes. The folder may be deleted at any time.
"""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

import motiondb

T = TypeVar("T")
FOLDERS = ("body", "symbols")
"""Folders of the package on whose source symbols and segments depend."""
MODULES = ("recognition.py", "score_vectors.py", "records.py")
"""Single modules beside them."""


def kept(name: str, parts: Sequence[str | NDArray[np.generic]], compute: Callable[[], T]) -> T:
    """The result of ``compute``, from disk where it was computed before.

    Parameters
    ----------
    name : str
        First part of the name of the file.
    parts : sequence of str or array
        Everything that the result depends on, in addition to the source of the package.
    compute : callable
        Computes the result, which can be pickled.
    """
    digest = hashlib.sha256(source_digest().encode())
    for part in parts:
        if isinstance(part, str):
            digest.update(part.encode())
        else:
            digest.update(f"{part.dtype} {part.shape}".encode())
            digest.update(np.ascontiguousarray(part).tobytes())
    file = cache_folder() / f"{name}-{digest.hexdigest()[:16]}.pickle"
    if file.exists():
        with file.open("rb") as stream:
            result: T = pickle.load(stream)
        return result
    result = compute()
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_suffix(f".{os.getpid()}.part")
    with partial.open("wb") as stream:
        pickle.dump(result, stream)
    partial.replace(file)
    return result


def cache_folder() -> Path:
    """The user's cache folder of the benchmarks."""
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return home / "motiondb"


def source_digest() -> str:
    """Digest of the source that symbols and segments depend on."""
    package = Path(motiondb.__file__).parent
    digest = hashlib.sha256()
    for pattern in [*(f"{folder}/**/*.py" for folder in FOLDERS), *(f"**/{m}" for m in MODULES)]:
        paths = sorted(package.glob(pattern))
        assert paths, f"{pattern} matches no file of the package"
        for path in paths:
            digest.update(path.relative_to(package).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()
