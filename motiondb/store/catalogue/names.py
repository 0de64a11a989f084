"""What is said of a name that the store does not have."""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.errors import suggestion
from motiondb.store.connection.handle import Store


def unknown_name(store: Store, name: str, kind: str, known: Sequence[str], remedy: str) -> str:
    """The sentence: the nearest known name, or those there are; ``remedy`` where there is none."""
    if not known:
        more = f" {remedy}"
    else:
        more = suggestion(name, known) or f" There are: {', '.join(known[:8])}."
    return f"{name!r}: expected the name of a {kind}, found none in {store.path}.{more}"
