"""Facts of captures: rows of the catalogue, and everything about one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from motiondb import store
from motiondb.database import MotionDB
from motiondb.database.catalogue.browsing import BrowsedCapture, Facet
from motiondb.database.generated_files import stretches
from motiondb.records import MOTION_FPS, Caption, Relation

_LABELS = {"kind": "kind", "format": "format"}
MOST_SHOWN = 50
"""Largest number of values of a facet that are sent. Chosen by hand: users search longer lists
instead of reading them."""


def caption_facts(captions: Iterable[Caption]) -> list[dict[str, Any]]:
    """Return captions with their times (seconds; null for the whole capture)."""
    return [{"words": c.words, "start": c.start, "end": c.end} for c in captions]


def row_facts(row: BrowsedCapture) -> dict[str, Any]:
    """Return a row of the catalogue."""
    info = row.info
    return {
        "name": info.name,
        "ref": f"capture:{info.name}",
        "kind": info.kind,
        "format": info.format,
        "fps": info.fps,
        "frames": info.n_frames,
        "duration": round(info.duration, 3),
        "performer": info.tags.get("performer"),
        "licence": info.tags.get("licence"),
        "tags": dict(info.tags),
        "words": caption_facts(row.captions),
        "notes": list(info.notes),
        "learned": row.learned,
        "copies": row.copies,
    }


def facet_facts(facet: Facet) -> dict[str, Any]:
    """Return the number of captures for each value, and the filter that selects them."""
    return {
        "column": facet.column,
        "label": _LABELS.get(facet.column, facet.column),
        "values": [
            {"value": value, "count": count, "where": _condition(facet.column, value)}
            for value, count in facet.values[:MOST_SHOWN]
        ],
        "more": max(len(facet.values) - MOST_SHOWN, 0),
        "missing": facet.missing,
    }


def _condition(column: str, value: str) -> str | None:
    """Return the filter for a value; None if the filter language cannot quote it.

    >>> _condition("performer", "ana")
    'performer="ana"'
    >>> print(_condition("licence", 'a "b" and c'))
    licence='a "b" and c'
    """
    quotes = [quote for quote in "\"'" if quote not in value]
    return f"{column}={quotes[0]}{value}{quotes[0]}" if quotes else None


def relation_facts(relation: Relation) -> dict[str, Any]:
    """Return how one capture repeats another."""
    return {
        "capture": relation.capture,
        "kind": relation.kind,
        "other": relation.other,
        "start": relation.start,
        "end": relation.end,
        "distance": relation.distance,
    }


def source_facts(provenance: store.Provenance) -> list[dict[str, Any]]:
    """Return the captures that frames come from."""
    counts = Counter(provenance.source_numbers.tolist())
    return [
        {
            "capture": source.name,
            "licence": source.licence or "unknown",
            "sha256": source.sha256,
            "frames": counts[number],
        }
        for number, source in enumerate(provenance.sources)
    ]


def stretch_facts(provenance: store.Provenance) -> list[dict[str, Any]]:
    """Return the stretches of a motion with source and licence."""
    return [
        {
            "start": round(each.start, 3),
            "end": round(each.end, 3),
            "capture": each.capture or None,
            "source_start": round(each.source_start, 3),
            "licence": each.licence if each.capture else None,
            "edit": ", ".join(each.edits),
        }
        for each in stretches(provenance)
    ]


def capture_facts(db: MotionDB, row: BrowsedCapture) -> dict[str, Any]:
    """Return everything about one capture."""
    info = row.info
    name = info.name
    facts = row_facts(row) | {
        "leg_length": info.leg_length,
        "path": info.path,
        "sha256": info.sha256,
        "events": [
            {
                "time": round(event.frame / MOTION_FPS, 3),
                "name": event.name,
                "joint": event.joint,
                "other": event.other,
            }
            for event in db.events(name)
        ],
        "copies": [relation_facts(relation) for relation in db.relations(name)],
        "segments": db.segments(name),
        "activities": db.activities(name),
        "recognised": [],
        "sources": [],
        "stretches": [],
        "grammar": None,
        "string": None,
    }
    if db.is_learned() and db.learned.has_words:
        facts["recognised"] = description_facts(db.describe(name))
    if info.kind == "generated":
        provenance = db.provenance(name)
        facts["sources"], facts["stretches"] = source_facts(provenance), stretch_facts(provenance)
        shown = db.show(name)
        if "string" in shown:
            facts["grammar"], facts["string"] = shown["grammar"], shown["string"].split()
    return facts


def description_facts(described: Iterable[Any]) -> list[dict[str, Any]]:
    """Return the words of a motion over time."""
    return [
        {
            "start": d.start,
            "end": d.end,
            "words": [{"word": word, "probability": p} for word, p in d.words],
            "symbols": list(d.symbols),
        }
        for d in described
    ]
