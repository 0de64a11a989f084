"""Files of a generated motion: the motion itself, and beside it where every frame comes from."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from motiondb import store
from motiondb.database.catalogue.parts import write_bytes, write_clip
from motiondb.database.generate.generating import Generated
from motiondb.pose import retarget
from motiondb.records import MOTION_FPS


def write(made: Generated, words: str, seed: int, method: str, path: Path) -> dict[str, Any]:
    """Write ``path`` and ``path``'s name with ``.provenance.json``; gives the facts, for JSON."""
    facts = describe(made, words, seed, method)
    beside = path.with_name(f"{path.stem}.provenance.json")
    write_clip(retarget.to_clip(made.motion), path)
    write_bytes(beside, json.dumps(facts | {"frames": frame_runs(made)}, indent=1).encode())
    return facts | {"output": str(path), "provenance": str(beside)}


def describe(made: Generated, words: str, seed: int, method: str) -> dict[str, Any]:
    """What was asked, decoded and used."""
    return {
        "words": words,
        "seed": seed,
        "method": method,
        "seconds": round(made.motion.n_frames / MOTION_FPS, 3),
        "actions": [list(action) for action in made.actions],
        "symbols": list(made.symbols),
        "recognised": list(made.recognised),
        "decodings": [
            {
                "symbols": list(d.symbols), "log_probability": d.log_probability,
                "nodes_expanded": d.nodes_expanded, "certificate": d.certificate,
            }
            for d in made.decodings
        ],
        "sources": source_facts(made),
    }  # fmt: skip


def source_facts(made: Made) -> list[dict[str, Any]]:
    """The captures that frames come from, with licence, digest and number of frames."""
    found = made.provenance
    return [
        {
            "capture": s.name, "licence": s.licence or "unknown", "sha256": s.sha256,
            "frames": int((found.source_numbers == n).sum()),
        }
        for n, s in enumerate(found.sources)
    ]  # fmt: skip


class Made(Protocol):
    """What was generated in any way: it knows where its frames come from."""

    @property
    def provenance(self) -> store.Provenance:
        """The origin of every frame."""


def frame_runs(made: Made) -> list[dict[str, Any]]:
    """Runs of frames that follow one another in one source: [start, end), first frame there."""
    found = made.provenance
    steps = np.diff(found.source_frames)
    breaks = (np.diff(found.source_numbers) != 0) | (np.abs(steps - 1.0) > 1e-6)
    breaks |= np.array([a != b for a, b in zip(found.edits[:-1], found.edits[1:])], dtype=bool)
    starts = [0, *(np.flatnonzero(breaks) + 1).tolist()]
    ends = [*starts[1:], len(found.source_frames)]
    return [
        {
            "start": a,
            "end": b,
            "capture": found.sources[n].name if (n := int(found.source_numbers[a])) >= 0 else None,
            "source_start": float(found.source_frames[a]),
            "edit": found.edits[a],
        }
        for a, b in zip(starts, ends)
    ]


def source_spans(made: Made) -> list[tuple[float, float, str, str]]:
    """Spans (seconds) of the sources, for a timeline."""
    numbers = made.provenance.source_numbers
    cuts = [0, *(np.flatnonzero(np.diff(numbers)) + 1).tolist(), len(numbers)]
    names = [s.name for s in made.provenance.sources]
    spans = []
    for a, b in pairwise(cuts):
        name = names[numbers[a]] if numbers[a] >= 0 else "model"
        spans.append((a / MOTION_FPS, b / MOTION_FPS, name, name))
    return spans
