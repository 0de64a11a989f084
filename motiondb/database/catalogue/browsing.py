"""The catalogue page by page: filtered, sorted, with the numbers of captures by value.

A program that shows thousands of captures asks for some rows at a time. The rows of all captures
are loaded once for a revision of the database; every request filters and sorts these.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from motiondb import answers, store
from motiondb.database.session import Session
from motiondb.errors import QueryError, suggestion
from motiondb.records import Caption, CaptureInfo

PAYS, LEAST_UNUSED = 0.25, 10_000_000
"""Share of the file and bytes that are unused from which on compacting pays. Chosen by hand."""
MOST_VALUES = 50
"""Different values of a tag up to which it is counted by value. Chosen by hand: longer lists are
names or numbers, which are not useful as a filter."""
FACET_COLUMNS = ("kind", "format")
FIRST_TAGS = ("performer", "licence")
TAG = "tag."  # Prefix of a tag as a column to sort by


@dataclass(frozen=True, eq=False)
class BrowsedCapture:
    """A row of the catalogue with its tags and captions."""

    info: CaptureInfo
    captions: tuple[Caption, ...]  # What people wrote about it
    learned: bool  # Whether questions search it
    copies: int  # Number of relations to captures that repeat it


@dataclass(frozen=True, eq=False)
class BrowsedPage:
    """Some rows of the catalogue."""

    rows: tuple[BrowsedCapture, ...]  # The rows, in the order that was asked for
    total: int  # Number of captures that the filter lets through
    offset: int  # Number of the first row, from 0


@dataclass(frozen=True)
class Facet:
    """How many captures have each value of a column or tag."""

    column: str  # Its name in filters
    values: tuple[tuple[str, int], ...]  # Value and number of captures, most captures first
    missing: int  # Number of captures without a value


def browse(session: Session, where: str, sort: str, offset: int, limit: int) -> BrowsedPage:
    """Return some rows of the catalogue.

    `sort`: Column or ``tag.NAME`` to sort by, with ``-`` in front for the largest first. Captures
    without a value come last.
    """
    with session.reading():
        rows = _filtered(session, where)
        ordered = session.kept(("browsed", where, sort), lambda: _sorted(rows, sort))
    return BrowsedPage(tuple(ordered[offset : offset + limit]), len(ordered), offset)


def facets(session: Session, where: str) -> tuple[Facet, ...]:
    """Return how many of the captures have each value of columns and tags."""
    with session.reading():
        rows = _filtered(session, where)
    keys = dict.fromkeys(key for row in rows for key in row.info.tags)
    tags = [*(t for t in FIRST_TAGS if t in keys), *sorted(set(keys) - set(FIRST_TAGS))]
    chosen = [
        _facet(column, [[str(getattr(r.info, column))] for r in rows]) for column in FACET_COLUMNS
    ]
    for tag in tags:
        facet = _facet(tag, [_tag_values(row, tag) for row in rows])
        if tag in (*FIRST_TAGS, store.SELECTION) or 2 <= len(facet.values) <= MOST_VALUES:
            chosen.append(facet)
    return tuple(chosen)


def rows_by_name(session: Session) -> dict[str, BrowsedCapture]:
    """Return the rows of all captures by name."""
    return session.kept("browsed by name", lambda: {r.info.name: r for r in _all_rows(session)})


def _tag_values(row: BrowsedCapture, tag: str) -> list[str]:
    value = row.info.tags.get(tag, "")
    return list(store.read_selections(value)) if tag == store.SELECTION else [value]


def _facet(column: str, values: Sequence[Sequence[str]]) -> Facet:
    """How many captures have each value; `values`: those of each capture."""
    counts = Counter(value for of_one in values for value in of_one if value)
    ordered = sorted(counts.items(), key=lambda pair: (-pair[1], _natural(pair[0])))
    return Facet(column, tuple(ordered), sum(not any(of_one) for of_one in values))


def _all_rows(session: Session) -> list[BrowsedCapture]:
    return session.kept("browsed", lambda: _load_rows(session))


def _load_rows(session: Session) -> list[BrowsedCapture]:
    opened = session.store
    captions = store.load_captions(opened)
    copies: Counter[str] = Counter()
    for relation in store.load_relations(opened):
        copies.update((relation.capture, relation.other))
    learned = store.load_learned_captures(opened)
    return [
        BrowsedCapture(
            info,
            captions.get(info.capture_id, ()),
            info.capture_id in learned or (bool(learned) and info.kind == "generated"),
            copies[info.name],
        )
        for info in store.load_captures(opened)
    ]


def _filtered(session: Session, where: str) -> list[BrowsedCapture]:
    rows = _all_rows(session)
    if not where.strip():
        return rows
    names = {info.capture_id for info in store.load_captures(session.store, where)}
    return [row for row in rows if row.info.capture_id in names]


def sort_captures(session: Session, infos: Sequence[CaptureInfo], sort: str) -> list[CaptureInfo]:
    """Return captures sorted by a column or tag, as :func:`browse` sorts them."""
    rows = rows_by_name(session)
    return [row.info for row in _sorted([rows[info.name] for info in infos], sort)]


_COLUMNS: dict[str, Callable[[BrowsedCapture], object]] = {
    "name": lambda row: row.info.name,
    "added": lambda row: row.info.capture_id,
    "duration": lambda row: row.info.duration,
    "format": lambda row: row.info.format,
    "fps": lambda row: row.info.fps,
    "kind": lambda row: row.info.kind,
    "performer": lambda row: row.info.tags.get("performer", ""),
    "licence": lambda row: row.info.tags.get("licence", ""),
    "caption": lambda row: " ".join(caption.words for caption in row.captions),
    "copies": lambda row: row.copies,
    **{name: attrgetter(f"info.{name}") for name in store.COLUMNS},
}  # Column to sort by -> its value in a row; "" where a row has none


def _sorted(rows: Sequence[BrowsedCapture], sort: str) -> list[BrowsedCapture]:
    column = sort.removeprefix("-") or "name"
    is_tag = any(column in row.info.tags for row in rows)
    if not is_tag:  # as in filters
        column = store.HEADS.get(column.casefold(), column)
    if column.startswith(TAG) or (column not in _COLUMNS and is_tag):
        tag = column.removeprefix(TAG)
        value: Callable[[BrowsedCapture], object] = lambda row: row.info.tags.get(tag, "")  # noqa: E731
    elif column in _COLUMNS:
        value = _COLUMNS[column]
    else:
        raise QueryError(
            f"sort: expected one of {', '.join((*_COLUMNS, *store.HEADS))}, or a tag, found "
            f"{column!r}.{suggestion(column, (*store.HEADS, *_COLUMNS))}"
        )
    there = [row for row in rows if value(row) != ""]
    missing = [row for row in rows if value(row) == ""]
    if column != "name":
        there.sort(key=lambda row: _natural(row.info.name))
    there.sort(key=lambda row: _natural(value(row)), reverse=sort.startswith("-"))
    return there + missing


def _natural(value: object) -> tuple[object, ...]:
    """Return a key that sorts numbers within names by value.

    >>> sorted(["take 10", "take 9"], key=_natural)
    ['take 9', 'take 10']
    """
    if not isinstance(value, str):
        return (value,)
    runs = _RUNS.findall(value.casefold())
    return tuple((0, int(run), "") if run[0] in "0123456789" else (1, 0, run) for run in runs)


_RUNS = re.compile("[0-9]+|[^0-9]+")  # Numbers, and what stands between them


def database_info(session: Session) -> answers.DatabaseInfo:
    """What is in the database: numbers of captures, grammars, symbols and words."""
    opened = session.store
    totals = store.load_totals(opened)
    learned: dict[str, Any] = {"learned": store.is_learned(opened)}
    if learned["learned"]:
        size = store.load_learning_size(opened)
        learned |= {
            "symbols": size.n_symbols,
            "clusters": size.n_clusters,
            "words": size.n_words,
            "current": store.learning_is_current(opened),
            "not_yet_learned": len(unlearned_captures(session)),
        }
        if store.has_parameter(opened, "started"):
            from motiondb.database.learn.start import start_facts

            learned["start"] = start_facts(session)
    n_bytes, unused = opened.path.stat().st_size, store.unused_bytes(opened)
    files = store.load_parquet_files(opened)
    return answers.extended(
        answers.DatabaseInfo,
        totals,
        database=str(opened.path),
        bytes=n_bytes,
        seconds=round(totals.seconds, 2),
        copies=len(store.load_relations(opened)),
        grammars=len(store.load_grammar_names(opened)),
        cache_bytes=store.cache_bytes(opened),
        parquet_bytes=sum(file.n_bytes for file in files) or None,
        motions_at=sorted({file.place for file in files}) or None,
        unused_bytes=unused,
        removed=len(store.load_trash(opened)),
        compact_pays=unused >= max(PAYS * n_bytes, LEAST_UNUSED),
        faulty_files=len(store.load_faulty(opened)),
        **learned,
    )


def unlearned_captures(session: Session) -> list[str]:
    """Names of captured captures that no question searches: added and not counted."""
    return list(session.kept("unlearned", lambda: store.load_unlearned(session.store)))
