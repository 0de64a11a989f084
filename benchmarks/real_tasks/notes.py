"""What people who looked at the answers wrote: ``notes.md``.

    ## words: walk then jump
    Text below the answers.
    - 86/86_01 yes: walks, jumps, walks on.
    - 16/16_07 no: steps up to the line, but does not walk.

A verdict (yes, no or half) belongs to a question and a capture and overrules what the captions say.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

_VERDICT = re.compile(r"^- (?P<capture>\S+) (?P<verdict>yes|no|half): (?P<reason>.+)$")


@dataclass(frozen=True)
class Notes:
    """prose: under the answers. verdicts: capture -> (yes, no or half; why)."""

    prose: str = ""
    verdicts: dict[str, tuple[str, str]] = field(default_factory=dict)


def read_notes(path: Path) -> dict[str, Notes]:
    """Question ("words: ...", "like: ...", "made: ..." or another heading) -> notes."""
    notes: dict[str, Notes] = {}
    for block in re.split(r"^## ", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        key, _, body = block.partition("\n")
        prose, verdicts = [], {}
        for line in body.splitlines():
            matched = _VERDICT.match(line)
            if matched:
                verdicts[matched["capture"]] = (matched["verdict"], matched["reason"])
            else:
                prose.append(line)
        notes[key.strip()] = Notes("\n".join(prose).strip(), verdicts)
    return notes
