"""The clips of a motion grammar's terminals, from the captures of a database.

The captions determine which parts of captures show an action
(:mod:`motiondb.scene.clips.caption_actions`). The annotated events, or else the motion, determine
the time of its event and where it can be cut. The rest is done by
:mod:`motiondb.scene.clips.clips`. Making a library takes a second or two, so the session keeps it
until the database changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motiondb import store
from motiondb.database.loading import nearby_table
from motiondb.errors import SceneError
from motiondb.records import MOTION_FPS, Motion
from motiondb.scene.clips.caption_actions import THROW, FoundActions, ShownAction
from motiondb.scene.clips.caption_actions import find_actions as actions_of_captions
from motiondb.scene.clips.clip_cutting import (
    SHORTEST,
    BodyFrames,
    ShownMotion,
    body_frames,
    throw_frames,
)
from motiondb.scene.clips.clips import ClipLibrary, VariantSettings, make_library
from motiondb.scene.language.motion_grammar import MotionGrammar

if TYPE_CHECKING:
    from motiondb.database.session import Session


def find_actions(session: Session, grammar: MotionGrammar, exact: bool = False) -> FoundActions:
    """Return the parts of captures that show each terminal, and what unknown words are taken as.

    `exact`: Whether words that no caption holds match nothing rather than being taken as known
    ones.
    """
    captions = store.load_captions(session.store)
    captioned = [
        (info.name, captions.get(info.capture_id, ()))
        for info in store.load_captures(session.store)
    ]
    table = None if exact else nearby_table()
    return actions_of_captions(captioned, grammar, store.load_synonyms(session.store), table)


@dataclass(frozen=True, eq=False)
class SceneClips:
    """The clips of a grammar, and the motions of their captures by name."""

    library: ClipLibrary
    motions: Mapping[str, Motion]


def scene_clips(
    session: Session,
    grammar: MotionGrammar,
    settings: VariantSettings | None = None,
    exact: bool = False,
) -> SceneClips:
    """Return the clips of all terminals of a grammar.

    `exact`: Whether words that no caption holds match nothing rather than being taken as known
    ones.
    """
    chosen = settings or VariantSettings()
    return session.kept(
        ("scene clips", grammar, chosen, exact),
        lambda: _make(session, grammar, chosen, exact),
    )


def _make(
    session: Session, grammar: MotionGrammar, settings: VariantSettings, exact: bool
) -> SceneClips:
    events = store.load_events(session.store)
    infos = {info.name: info for info in store.load_captures(session.store) if info.is_captured}
    actions = {
        terminal: _evenly([part for part in parts if part.capture in infos], settings.most)
        for terminal, parts in find_actions(session, grammar, exact).parts.items()
    }
    names = sorted({part.capture for parts in actions.values() for part in parts})
    motions = {n: store.load_motion(session.store, infos[n].capture_id) for n in names}
    shown, seen = [], dict[str, BodyFrames]()
    for terminal in grammar.terminals:
        for part in actions[terminal.name]:
            start, end = _frames(part, motions[part.capture], seen)
            if end - start >= SHORTEST:
                info = infos[part.capture]
                shown.append(
                    ShownMotion(
                        terminal.name,
                        part.capture,
                        motions[part.capture],
                        start,
                        end,
                        terminal.event,
                        events.get(info.capture_id, ()),
                        info.tags.get("licence", ""),
                    )
                )
    _check_terminals(grammar, {one.terminal for one in shown})
    library = make_library(shown, [terminal.name for terminal in grammar.terminals], settings)
    used = sorted({source.capture for source in library.source})
    return SceneClips(library, {name: motions[name] for name in used})


def _evenly(parts: list[ShownAction], most: int) -> list[ShownAction]:
    """Return at most ``most`` of the parts, evenly spaced; each gives a piece or more."""
    chosen = np.linspace(0, len(parts) - 1, min(len(parts), max(most, 1))).round().astype(int)
    return [parts[k] for k in chosen]


def _frames(part: ShownAction, motion: Motion, seen: dict[str, BodyFrames]) -> tuple[int, int]:
    """Return the frames that show an action; ``seen`` keeps analysed captures with throws."""
    start = 0 if part.start is None else round(part.start * MOTION_FPS)
    end = motion.n_frames if part.end is None else round(part.end * MOTION_FPS)
    end = min(end, motion.n_frames)
    if not part.stretch or end - start < SHORTEST:
        return start, end
    if part.capture not in seen:
        seen[part.capture] = body_frames(motion)
    first, last = throw_frames(seen[part.capture], start, end)
    return (first, last) if part.stretch == THROW else (start, first)


def _check_terminals(grammar: MotionGrammar, shown: set[str]) -> None:
    """Refuse a grammar with terminals that no capture shows."""
    missing = [terminal for terminal in grammar.terminals if terminal.name not in shown]
    if not missing:
        return
    asked = "; ".join(
        f"{terminal.name} ({', '.join(map(repr, terminal.phrases)) or 'no phrase'}"
        + (f" without {', '.join(map(repr, terminal.without))}" if terminal.without else "")
        + ")"
        for terminal in missing
    )
    count = "a terminal" if len(missing) == 1 else f"{len(missing)} terminals"
    raise SceneError(
        f"{grammar.name}: expected captures for every terminal, found none for {count}: {asked}."
        " Add captures whose words say so, one action a caption (motiondb words set CAPTURE), or"
        " change the phrases in the grammar's file."
    )
