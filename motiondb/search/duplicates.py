"""Groups of captures that repeat one another: copies, cuts and mirror images.

A relation connects two captures of which one repeats the other. Groups are the connected components
of all relations. The first capture of a group is the one to keep: the longest, and of equally long
ones the one that was added first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from motiondb.records import Relation


@dataclass(frozen=True)
class DuplicateGroup:
    """Captures that repeat one another."""

    # Names: first the one to keep, then the others in the order in which they were added
    captures: tuple[str, ...]
    relations: tuple[Relation, ...]


def group_duplicates(
    relations: Sequence[Relation], durations: Mapping[str, float]
) -> tuple[DuplicateGroup, ...]:
    """Connected components of relations, the largest first.

    >>> cut = Relation("b", "a", "cut", 1.0, 2.0, 0.0)
    >>> group_duplicates([cut], {"b": 1.0, "a": 5.0, "c": 5.0})[0].captures
    ('a', 'b')
    """
    parent: dict[str, str] = {}

    def root(name: str) -> str:
        parent.setdefault(name, name)
        while parent[name] != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    for relation in relations:
        parent[root(relation.capture)] = root(relation.other)
    order = {name: n for n, name in enumerate(durations)}
    members: dict[str, list[str]] = {}
    for name in sorted(parent, key=order.__getitem__):
        members.setdefault(root(name), []).append(name)
    groups = []
    for key, names in members.items():
        keep = max(names, key=lambda name: (round(durations[name], 1), -order[name]))
        inside = tuple(r for r in relations if root(r.capture) == key)
        groups.append(DuplicateGroup((keep, *(n for n in names if n != keep)), inside))
    return tuple(sorted(groups, key=lambda g: (-len(g.captures), order[g.captures[0]])))
