"""Names of captures, grammars and scenes: check a new name, and report an unknown one."""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.errors import QueryError, suggestion
from motiondb.store.connection.handle import Store

LONGEST_NAME = 200
"""Most bytes of a name in UTF-8.

File systems allow 255 bytes for the name of a file. The rest is left for appended text: an ending
such as ``.provenance.json``, or the name of a player.
"""


def check_new_name(name: str, kind: str) -> None:
    """Refuse a name that leads out of its folder, or that cannot be shown or written to.

    It need not be the name of a file: names come from files of other systems (``a:b``, ``con``),
    and no command names a file by one without the characters that some system refuses.

    A name may consist of several parts separated by ``/``. No part may be empty, consist only of
    dots, or begin or end with a space. A name has at most ``LONGEST_NAME`` bytes, no backslash and
    no character that cannot be printed.
    """
    fault = _fault(name)
    if fault:
        raise QueryError(
            f"{name[:60]!r}: expected a name for the {kind}, found {fault}. Choose another name, "
            "such as walk_2 or demo/walk_2."
        )


def _fault(name: str) -> str | None:
    """Return the fault of a new name, or None."""
    parts = name.split("/")
    if not name.strip():
        return "nothing"
    if len(name.encode(errors="replace")) > LONGEST_NAME:
        return f"more than {LONGEST_NAME} bytes"
    if "\\" in name:
        return "a backslash"
    if not name.isprintable():
        return "a character that cannot be printed"
    if any(not part.strip(".") for part in parts):
        return "an empty part, or one of dots alone"
    if any(part != part.strip() for part in parts):
        return "a space at the beginning or the end of a part"
    return None


def unknown_name(store: Store, name: str, kind: str, known: Sequence[str], remedy: str) -> str:
    """Return the message that the store has no entry of this name."""
    if not known:
        more = f" {remedy}"
    else:
        more = suggestion(name, known) or f" There are: {', '.join(known[:8])}."
    return f"{name!r}: expected the name of a {kind}, found none in {store.path}.{more}"
