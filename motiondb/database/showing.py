"""What is known of a capture and of the symbols, as plain facts and as pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import pictures, store
from motiondb.records import MOTION_FPS

if TYPE_CHECKING:
    from motiondb.database.motion_db import MotionDB


def describe_capture(database: MotionDB, name: str) -> dict[str, Any]:
    """Facts of one capture, for print or JSON; times in seconds."""
    info = store.load_capture(database.store, name)
    facts: dict[str, Any] = {
        "capture": info.name,
        "kind": info.kind,
        "format": info.format,
        "seconds": round(info.duration, 3),
        "fps": info.fps,
        "frames": info.n_frames,
        "leg length": f"{info.leg_length:.3f} m",
        "path": info.path,
        "sha256": info.sha256,
        **{k: v for k, v in info.tags.items() if k not in ("capture", "segments")},
        "words": [_timed(c.words, c.start, c.end) for c in database.captions(info.name)],
        "copies": [
            f"{r.capture} {r.kind} {r.other} {r.start:.2f}-{r.end:.2f} s"
            for r in database.relations(info.name)
        ],
        "notes": list(info.notes),
        "segments": [],
    }
    if info.kind == "generated":
        facts["sources"] = _sources(database, info.capture_id)
    if store.is_learned(database.store):
        facts["segments"] = capture_segments(database, info.capture_id)
    return facts


def capture_segments(database: MotionDB, capture_id: int) -> list[dict[str, Any]]:
    """Symbols of a capture with their times (seconds) and log-likelihoods (nats per frame)."""
    table = store.load_segments(database.store, scores=False)
    rows = np.flatnonzero(table.capture_ids == capture_id)
    return [
        {
            "symbol": int(table.symbols[r]),
            "start": round(float(table.starts[r]) / MOTION_FPS, 3),
            "end": round(float(table.ends[r]) / MOTION_FPS, 3),
            "log_likelihood": round(float(table.log_likelihoods[r]), 3),
            "known": bool(table.log_likelihoods[r] > table.backgrounds[r]),
        }
        for r in rows
    ]


def draw_capture(database: MotionDB, name: str, path: str | Path) -> Path:
    """A strip of stick figures with the timelines of symbols and words under it."""
    info = store.load_capture(database.store, name)
    motion = store.load_motion(database.store, info.capture_id)
    timelines = []
    captions = database.captions(info.name)
    if store.is_learned(database.store):
        spans = [
            (s["start"], s["end"], str(s["symbol"]), s["symbol"])
            for s in capture_segments(database, info.capture_id)
        ]
        timelines.append(pictures.Timeline("symbols", spans))
    if captions:
        end = motion.n_frames / MOTION_FPS
        written = [(c.start or 0.0, c.end or end, c.words, c.words) for c in captions]
        timelines.append(pictures.Timeline("words", written))
    if store.is_learned(database.store) and "word_weights" in database.learned.parameters:
        said = [
            (d.start, d.end, " ".join(w for w, p in d.words[:3] if p > 0.2), d.words[0][0])
            for d in database.describe(motion)
        ]
        timelines.append(pictures.Timeline("recognised", [span for span in said if span[2]]))
    return pictures.draw_strip(motion, path, title=info.name, timelines=timelines)


def symbol_rows(database: MotionDB, n_words: int = 3) -> list[dict[str, Any]]:
    """Every symbol: cluster, segments, captures, mean length (seconds), likeliest words."""
    learned = database.learned
    table, association = learned.segments, learned.association
    rows = []
    for s in range(learned.symbols.n_symbols):
        mine = table.symbols == s
        lengths = (table.ends - table.starts)[mine] / MOTION_FPS
        t = association.translation[s + 1]
        order = [w for w in np.argsort(-t, kind="stable")[:n_words] if t[w] > 0]
        rows.append(
            {
                "symbol": s,
                "cluster": int(learned.clusters[s]),
                "count": int(mine.sum()),
                "captures": len(np.unique(table.capture_ids[mine])),
                "seconds": round(float(lengths.mean()), 2) if mine.any() else 0.0,
                "words": [
                    {"word": association.words[w], "probability": float(t[w])} for w in order
                ],
            }
        )
    return rows


def draw_symbols(database: MotionDB, path: str | Path) -> Path:
    """The symbol space with its clusters, every symbol with its likeliest word."""
    labels = [row["words"][0]["word"] if row["words"] else "" for row in symbol_rows(database, 1)]
    return pictures.draw_symbol_space(store.load_space(database.store), labels, path)


def _timed(words: str, start: float | None, end: float | None) -> str:
    if start is None and end is None:
        return words
    return f"{start or 0:g}-{'end' if end is None else f'{end:g}'} s: {words}"


def _sources(database: MotionDB, capture_id: int) -> list[str]:
    found = store.load_provenance(database.store, capture_id)
    return [
        f"{s.name} (frames {int((found.source_numbers == n).sum())}, licence {s.licence or '?'})"
        for n, s in enumerate(found.sources)
    ]
