"""The shipped table of nearby words, and questions in words that no caption holds."""

from __future__ import annotations

from functools import lru_cache
from importlib import resources

from motiondb.language.nearby.table import NearbyTable, read_table

_FILE = "words.table"


@lru_cache(maxsize=1)
def nearby_table() -> NearbyTable:
    """The table that is shipped with motiondb; read once."""
    return read_table(
        resources.files("motiondb.language.nearby").joinpath(_FILE).read_bytes(), _FILE
    )
