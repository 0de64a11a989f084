"""Values that callers give, checked where a mistake is likely; former names of verbs."""

from __future__ import annotations

import operator
import reprlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from motiondb.errors import QueryError, suggestion

if TYPE_CHECKING:
    import numpy as np

    from motiondb.records import Clip, Motion

    Example: TypeAlias = str | Path | Clip | Motion

T = TypeVar("T")
Where: TypeAlias = str | Iterable[str]
"""A filter on the catalogue, or the names of captures."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60


def check_least(name: str, value: int, least: int) -> None:
    """Refuse a whole number that is smaller than the least."""
    if value < least:
        raise QueryError(
            f"{name}: expected a whole number from {least} on, found {_SHORT.repr(value)}."
        )


def check_text(name: str, value: object) -> None:
    """Refuse what is no text, such as words in a list."""
    if not isinstance(value, str):
        raise QueryError(f"{name}: expected a text, found {_SHORT.repr(value)}.")


def listed(name: str, values: Iterable[T]) -> list[T]:
    """Return several texts or others as a list; a single text is refused: its letters are texts."""
    if isinstance(values, str):
        found = _SHORT.repr(values)
        raise QueryError(f"{name}: expected several texts, found {found}. Put it in a list.")
    return list(values)


def is_compiled(function: Any) -> bool:  # noqa: ANN401  (numba's functions have no type)
    """Return whether numba kept the machine code of a function in an earlier process."""
    return any(Path(function.stats.cache_path).glob(f"*.{function.__name__}-*.nbi"))


def seeded(seed: int) -> np.random.Generator:
    """A generator of random numbers from the seed of a user."""
    import numpy as np

    check_least("seed", seed, 0)
    return np.random.default_rng(seed)


def seeds_from(seed: int, number: int) -> range:
    """The seeds of some motions: that of the user, and the following ones."""
    check_least("seed", seed, 0)
    return range(operator.index(seed), seed + number)


_SAME_NAME: Mapping[str, str] = MappingProxyType(
    {
        "captures": "activities all_events animate browse browsed check_name_free draw "
        "draw_matches draw_reasons duplicates event_rows events export_matches facets "
        "faulty_files features import_events provenance relations remove rename same_files "
        "save_generated segments set_tags show tag_rows taken_in_filter unlearned",
        "words": "all_captions captions set_captions set_synonyms vocabulary why_unchecked",
        "symbols": "drift export_knowledge start_facts start_knowledge",
    }
)
FORMER: Mapping[str, str] = MappingProxyType(
    {name: f"{space}.{name}" for space, names in _SAME_NAME.items() for name in names.split()}
    | {"set_words": "words.set", "add_words": "words.add", "caption_history": "words.history"}
    | {"export_words": "words.export", "import_words": "words.import_sheet"}
    | {"word_rows": "words.rows", "word_sources": "words.sources"}
    | {"symbol_rows": "symbols.rows", "symbol_segments": "symbols.segments"}
    | {"draw_symbols": "symbols.draw", "damage_note": "session.damage_note"}
    | {"log_note": "session.store.log_note", "file_notes": "session.store.notes"}
)
"""Name -> attribute of :class:`MotionDB` that it stands for."""


FOLDER = "/"  # How the name of a folder of captures ends
ANY = "*"  # In a pattern of names: any letters


def folder_names(everyone: Iterable[str], old: str, new: str) -> dict[str, str]:
    """The captures of a folder with their names in another one."""
    if new and not new.endswith(FOLDER):
        raise QueryError(
            f"{new!r}: expected a folder, as {old!r} is one, found no {FOLDER!r} at its end. "
            f"Give {new + FOLDER!r}."
        )
    names = [name for name in everyone if name.startswith(old)]
    if not names:
        folders = {n[: n.rindex(FOLDER) + 1] for n in everyone if FOLDER in n}
        raise QueryError(
            f"{old!r}: expected a folder of captures, found none whose name begins so."
            f"{suggestion(old, folders)}"
        )
    return {name: new + name.removeprefix(old) for name in names}


def names_by_pattern(names: Iterable[str], old: str, new: str) -> dict[str, str]:
    """The names that fit a pattern, with what the other pattern makes of them."""
    for pattern in (old, new):
        if pattern.count(ANY) != 1:
            raise QueryError(
                f"{pattern!r}: expected a pattern with one {ANY!r}, which stands for any letters,"
                f" found {pattern.count(ANY)}. Nothing was renamed."
            )
    (before, after), (head, tail) = old.split(ANY), new.split(ANY)
    least = len(before) + len(after)
    fitting = [
        name
        for name in names
        if name.startswith(before) and name.endswith(after) and len(name) >= least
    ]
    if not fitting:
        raise QueryError(f"{old!r}: expected a pattern of names, found no capture that fits.")
    return {name: head + name[len(before) : len(name) - len(after)] + tail for name in fitting}
