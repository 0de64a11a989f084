"""Names of captures, grammars and scenes: check a new one, and tell of one that is not there."""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.errors import QueryError, suggestion
from motiondb.store.connection.handle import Store

LONGEST_NAME = 200
"""Bytes of a name in UTF-8. File systems allow 255 for the name of a file, and a name gets endings
such as ``.provenance.json``, or a player's name behind it."""


def check_new_name(name: str, kind: str) -> None:
    """Refuse a name that could not be the name of a file on every system, or would lead elsewhere.

    A name may have parts with ``/`` between them. No part is empty, consists of dots alone, or
    begins or ends with a space; there is no backslash and no control character.

    Parameters
    ----------
    name : str
        What a user wants to call something new.
    kind : str
        What it is: "capture", "grammar" or "scene".

    Raises
    ------
    QueryError
        Says what is wrong with it.
    """
    fault = _fault(name)
    if fault:
        raise QueryError(
            f"{name[:60]!r}: expected a name for the {kind}, found {fault}. Choose another name, "
            "such as walk_2 or demo/walk_2."
        )


def _fault(name: str) -> str | None:
    """What is wrong with a new name, or None."""
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
    """Say that the store has no such name.

    Parameters
    ----------
    store : Store
        Where it was looked up.
    name : str
        What was asked for.
    kind : str
        What it should name: "grammar" or "scene".
    known : sequence of str
        The names that there are; the nearest are suggested.
    remedy : str
        What to do where there is none at all, a sentence.
    """
    if not known:
        more = f" {remedy}"
    else:
        more = suggestion(name, known) or f" There are: {', '.join(known[:8])}."
    return f"{name!r}: expected the name of a {kind}, found none in {store.path}.{more}"
