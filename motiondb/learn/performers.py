"""The performer of captures for which none is given.

If every capture counted as a separate performer, near copies (repeats of one exercise, cuts of one
take) would be used to predict one another wherever performers are left out. Captures without a
given performer therefore count as one performer if they are in one folder or, if all of them are in
the same folder, if their names are the same up to the last number (``14_06`` and ``14_20``).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from motiondb.records import CaptureInfo

_LAST_NUMBER = re.compile(r"[ _-]*\d+$")


def performers_of(captures: Mapping[int, CaptureInfo]) -> dict[int, str]:
    """Performer of every capture of a catalogue, from its tag or its name."""
    said = {c: i.tags["performer"] for c, i in captures.items() if "performer" in i.tags}
    return group_performers({c: info.name for c, info in captures.items()}, said)


def group_performers(names: Mapping[int, str], performers: Mapping[int, str]) -> dict[int, str]:
    """Performer of every capture, as given or from its name.

    >>> group_performers({1: "a/x_1", 2: "a/y_1", 3: "b/x_1", 4: "c/x"}, {4: "ana"})
    {1: '#a/', 2: '#a/', 3: '#b/', 4: 'ana'}
    >>> group_performers({1: "14_06", 2: "14_20", 3: "16_01"}, {})
    {1: '#14', 2: '#14', 3: '#16'}
    """
    unsaid = {capture: name for capture, name in names.items() if capture not in performers}
    folders = {capture: name.rpartition("/")[0] for capture, name in unsaid.items()}
    if len(set(folders.values())) > 1:
        groups = {capture: f"#{folder}/" for capture, folder in folders.items()}
    else:
        groups = {capture: f"#{family_of(name)}" for capture, name in unsaid.items()}
    return {capture: performers.get(capture, groups.get(capture, "")) for capture in names}


def family_of(name: str) -> str:
    """A name up to its last number; a name that is only a number is not changed.

    >>> family_of("cmu/14_06"), family_of("walk"), family_of("12")
    ('cmu/14', 'walk', '12')
    """
    stem = _LAST_NUMBER.sub("", name)
    return stem if stem and not stem.endswith("/") else name
