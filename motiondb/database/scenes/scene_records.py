"""The record of a scene, which the store and a folder's ``scene.json`` keep, and back to a state.

The record names captures and not entries of a library, so that it remains valid when the library
changes. When a scene is read back, every clip is identified by its capture, frames and edit. If the
library no longer has it, it is replaced by the most similar entry of the same action.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from itertools import groupby, pairwise
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from motiondb import answers, store
from motiondb.answers import plain
from motiondb.database.scenes.scene_making import MadeScene, SceneSettings
from motiondb.database.scenes.scene_texts import SceneText, stored_text
from motiondb.errors import SceneError
from motiondb.files.json_text import JSONError, parse_json, to_record
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Tree, choices_of, derive_by
from motiondb.grammar.cfg.parse import ParseError, parse
from motiondb.records import MOTION_FPS, Caption
from motiondb.scene.clips.clips import ClipLibrary, ClipSource
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.polish.placed import Placed

Record = TypeVar("Record")

FORMAT = "motiondb scene 1"  # Marks the files of records


def scene_record(
    made: MadeScene, name: str, digests: Mapping[str, str], sources: tuple[answers.Source, ...]
) -> store.StoredScene:
    """Return the record of a made scene."""
    frames = [[rule.start, rule.end] for rule in made.report.rules]
    details = _details(made, sources)
    measured = {k: v for k, v in plain.to_json(details).items() if v is not None or k != "cut_at"}
    ball = made.polished.ball
    return store.StoredScene(
        name=name,
        diagram=made.text.diagram_text,
        grammar=made.text.grammar_text,
        settings=asdict(made.settings),
        error=float(made.error),
        n_frames=made.n_frames,
        players=_players(made, digests),
        rules=tuple(
            plain.extended(
                store.SceneRule,
                row,
                clip=row.token,
                before=float(row.before),
                after=float(row.after),
                threshold=float(row.threshold),
                frame=int(row.frame),
                kept=bool(row.kept),
            )
            for row in made.report.rules
        ),
        ball=np.zeros((0, 3)) if ball is None else np.asarray(ball.positions, dtype=float),
        report={"rule_frames": frames, **measured},
    )


def _players(made: MadeScene, digests: Mapping[str, str]) -> tuple[store.ScenePlayer, ...]:
    library, players = made.clips.library, []
    for who, state in zip(made.text.diagram.players, made.state.players, strict=True):
        entries = np.asarray(state.entries).tolist()
        begins = state.delay + np.concatenate([[0], np.cumsum(library.n_frames[entries])])
        clips = tuple(
            plain.extended(
                store.SceneClip,
                s,
                terminal=action,
                sha256=digests.get(s.capture, ""),
                begin=int(begin),
            )
            for action, s, begin in zip(
                state.tree.leaves(), (library.source[e] for e in entries), begins, strict=False
            )
        )
        x, z, heading = (float(value) for value in state.origin)
        rules = choices_of(state.tree)
        players.append(
            store.ScenePlayer(who.name, who.team, rules, (x, z, heading), int(state.delay), clips)
        )
    return tuple(players)


def record_text(record: store.StoredScene) -> SceneText:
    """Read the diagram and grammar of a record again."""
    return stored_text(record.diagram, record.grammar, record.name)


def record_state(record: store.StoredScene, text: SceneText, library: ClipLibrary) -> SceneState:
    """Return the state of a record with the entries of a library."""
    players = []
    for who in text.diagram.players:
        kept = next((player for player in record.players if player.name == who.name), None)
        if kept is None:
            raise SceneError(
                f"{record.name}: expected the player {who.name} of its diagram, found none."
                " The scene was changed by hand: make it again."
            )
        grammar = text.grammar.started(text.grammar.start_of(who.team))
        tree = _tree(grammar, kept.rules, tuple(clip.terminal for clip in kept.clips))
        if tree is None:
            raise SceneError(
                f"{record.name}: expected clips of the actions of {who.name}, found others."
                " The scene was changed by hand: make it again."
            )
        entries = [_entry(library, clip) for clip in kept.clips]
        players.append(PlayerState(tree, np.array(entries), kept.origin, kept.delay))
    return SceneState(tuple(players))


def _tree(grammar: Grammar, rules: Sequence[int], actions: tuple[str, ...]) -> Tree | None:
    """Return the tree of a player, parsed again where earlier versions numbered rules otherwise."""
    with suppress(GrammarError):
        tree = derive_by(grammar, rules)
        if tree.leaves() == actions:
            return tree
    with suppress(ParseError):
        return parse(grammar, actions)
    return None


_OTHER_CAPTURE = 100.0
"""What an entry of another capture is unlike by. Chosen by hand: more than most shifts in time."""


def _entry(library: ClipLibrary, clip: store.SceneClip) -> int:
    """Return the entry that a clip came from, or the most similar one of its action."""
    if clip.terminal not in library.terminals or not len(library.of(clip.terminal)):
        raise SceneError(
            f"{clip.terminal}: expected clips of this action, found none. Add captures that show"
            " it."
        )
    entries = np.array(library.of(clip.terminal)).tolist()
    near = [entry for entry in entries if library.source[entry].capture == clip.capture]
    for some in (near, entries):  # most entries need not be compared
        costs = [_unlike(library.source[entry], clip) for entry in some]
        if costs and (some is entries or min(costs) < _OTHER_CAPTURE):
            break
    return int(some[int(np.argmin(costs))])


def _unlike(source: ClipSource, clip: store.SceneClip) -> float:
    """Return how much an entry differs from a clip."""
    other = _OTHER_CAPTURE * (source.capture != clip.capture) + 10.0 * (
        source.mirrored != clip.mirrored
    )
    frames = abs(source.start - clip.start) + abs(source.end - clip.end)
    return other + 0.1 * frames + abs(source.bend - clip.bend) + abs(source.stretch - clip.stretch)


def to_json(record: store.StoredScene) -> str:
    """Return the record as text."""
    facts = asdict(replace(record, ball=np.zeros((0, 3)))) | {
        "format": FORMAT,
        "ball": np.round(record.ball, 4).tolist(),
    }
    return json.dumps(facts, indent=1, ensure_ascii=False)


def from_json(text: str, where: str) -> store.StoredScene:
    """Read a record from its text."""
    try:
        facts = parse_json(text)
        if not isinstance(facts, dict) or facts.pop("format", None) != FORMAT:
            raise JSONError(f"the format {FORMAT!r}", "another")
        record = to_record(store.StoredScene, facts)
        to_record(SceneSettings, dict(record.settings), "settings")
        return replace(record, ball=record.ball.reshape(-1, 3))
    except (ValueError, SceneError) as error:
        raise SceneError(
            f"{where}: expected a scene as motiondb scene make writes it, found something else"
            f" ({error}). Make it again."
        ) from None


def action_captions(placed: Placed, actions: tuple[str, ...]) -> list[Caption]:
    """Return the actions of a player as captions with times; consecutive equal actions are joined.

    Waiting has no caption.
    """
    clips, waits = np.asarray(placed.clips).tolist(), waiting(placed.edits).tolist()
    words = [
        "" if wait else actions[clip].replace("_", " ")
        for clip, wait in zip(clips, waits, strict=True)
    ]
    bounds = [0]
    for _, run in groupby(words):
        bounds.append(bounds[-1] + len(list(run)))
    return [
        Caption(words[start], start / MOTION_FPS, end / MOTION_FPS)
        for start, end in pairwise(bounds)
        if words[start]
    ]


def _details(made: MadeScene, sources: tuple[answers.Source, ...]) -> answers.SceneDetails:
    """Return what a report says beside the values of rules, with rounded numbers."""
    report = made.report
    cut_at = dict(zip(("try", "rounds", "of"), made.cut_at)) if made.cut_short else None
    return answers.SceneDetails(
        collisions=tuple(map(_rounded, report.collisions)),
        collisions_before=len(report.collisions_before),
        feet={f.player: (round(f.slip, 4), round(f.source_slip, 4)) for f in report.feet},
        paces=tuple(_rounded(pace, 3) for pace in report.paces),
        impossible=tuple(map(_rounded, report.impossible)),
        planted_feet=tuple(map(_rounded, report.jumps)),
        near_limbs=tuple(map(_rounded, report.limbs)),
        guards=tuple(map(_rounded, report.guards)),
        seen=tuple(map(_rounded, report.seen)),
        bone_error=round(report.bone_error, 6),
        ball_gap=None if np.isnan(report.ball_gap) else round(report.ball_gap, 4),
        too_fast=made.too_fast,
        settled=bool(made.polished.settled),
        tries=made.tries,
        cut_short=made.cut_short,
        cut_at=cut_at,
        sources=sources,
    )


def _rounded(record: Record, digits: int = 4) -> Record:
    """Return a record with its floats rounded."""
    values = vars(record).items()
    rounded = {name: round(value, digits) for name, value in values if isinstance(value, float)}
    return replace(cast(Any, record), **rounded)


def waiting(edits: Sequence[str]) -> NDArray[np.bool_]:
    """Return the frames in which a player waits, by their edits: array (frames,)."""
    return np.array(["waits" in edit.split(", ") for edit in edits], dtype=bool)
