"""Whether compiled code was kept by an earlier process, to say why a first call takes long."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def is_compiled(function: Any) -> bool:  # noqa: ANN401  (numba's dispatchers have no type)
    """Return whether numba has kept the machine code of a function on this machine."""
    return any(Path(function.stats.cache_path).glob(f"*.{function.__name__}-*.nbi"))
