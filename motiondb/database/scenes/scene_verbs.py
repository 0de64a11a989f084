"""The verbs of scenes: ``db.scenes.make``, ``update``, ``report``, ``names``, ``remove``.

A diagram says what is to happen, a motion grammar how, the database's captures move. What is made
can be written into a folder, and kept in the store under a name; every player's motion is then a
capture, ``NAME/PLAYER``, with the origin of its frames.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import groupby, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import pictures, store
from motiondb.database.catalogue.cataloguing import check_name_free
from motiondb.database.generate.keeping import keep_generated
from motiondb.database.learn import updating
from motiondb.database.scenes.scene_folder import (
    check_scene_folder,
    fill_scene_folder,
    read_scene_folder,
    waiting,
    whole_folder,
)
from motiondb.database.scenes.scene_library import scene_clips
from motiondb.database.scenes.scene_making import (
    MadeScene,
    SceneProgress,
    SceneSettings,
    SceneText,
    make,
    read_scene_text,
)
from motiondb.database.scenes.scene_records import record_state, record_text, scene_record
from motiondb.database.scenes.scene_reports import source_list
from motiondb.errors import QueryError, suggestion
from motiondb.pose import body
from motiondb.records import MOTION_FPS, Caption
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.polish.placed import Placed

if TYPE_CHECKING:
    from motiondb.database.session import Session


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene that was made: the work, its record, and where every frame comes from."""

    made: MadeScene
    record: store.StoredScene
    provenance: Mapping[str, store.Provenance]

    @property
    def broken(self) -> tuple[store.SceneRule, ...]:
        """The rules that are not kept."""
        return tuple(rule for rule in self.record.rules if not rule.kept)


def _quiet(_what: str, _share: float, _error: float) -> None:
    """Tell nobody."""


class Scenes:
    """The scenes of a database; reached as ``db.scenes``."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def make(
        self,
        diagram: str | Path,
        settings: SceneSettings | None = None,
        progress: SceneProgress = _quiet,
        name: str = "",
    ) -> Scene:
        """A scene of a diagram: a tactics file, or the name of a shipped one. Nothing is kept.

        Raises
        ------
        SceneError : the diagram or its grammar is wrong, or an action has no clips.
        """
        text = read_scene_text(diagram)
        progress("loading", 0.0, np.nan)
        clips = scene_clips(self._session, text.grammar)
        progress("loading", 1.0, np.nan)
        made = make(text, clips, settings or SceneSettings(), progress)
        return self._finished(made, name or text.diagram.name)

    def update(
        self,
        earlier: store.StoredScene,
        diagram: str | Path,
        settings: SceneSettings | None = None,
        progress: SceneProgress = _quiet,
    ) -> Scene:
        """The scene of a changed diagram, begun from an earlier one; what did not change stays.

        Raises
        ------
        SceneError : as :meth:`make`.
        """
        old, new = record_text(earlier), read_scene_text(diagram)
        settings = settings or SceneSettings(**earlier.settings)
        if new.grammar_text != old.grammar_text:
            return self.make(diagram, settings, progress, earlier.name)
        clips = scene_clips(self._session, new.grammar)
        state = record_state(earlier, old, clips.library)
        made = make(new, clips, settings, progress, (old.diagram, state))
        return self._finished(made, earlier.name)

    def _finished(self, made: MadeScene, name: str) -> Scene:
        infos = {info.name: info for info in store.load_captures(self._session.store)}
        provenance = {
            player.player: self._provenance(player, {n: i.capture_id for n, i in infos.items()})
            for player in made.polished.players
        }
        facts: dict[str, Any] = {
            **_report_rest(made),
            "sources": source_list(list(provenance.values())),
        }
        digests = {n: info.sha256 for n, info in infos.items()}
        return Scene(made, scene_record(made, name, digests, facts), provenance)

    def _provenance(self, player: Placed, numbers: Mapping[str, int]) -> store.Provenance:
        captures = np.array([numbers[capture] for capture in player.captures], dtype=np.int64)
        return store.to_provenance(
            self._session.store,
            captures[player.source_numbers],
            player.source_frames,
            player.warps,
            player.edits,
        )

    def write(
        self,
        scene: Scene,
        folder: str | Path,
        progress: SceneProgress = _quiet,
        drawn: bool = True,
        kept: bool = False,
    ) -> None:
        """Write a scene's folder, in place of an earlier scene's; ``kept``: keep it as well.

        Whatever goes wrong, the folder stays as it was, and so does the database.

        Raises
        ------
        MotionDBError : the folder cannot be written. QueryError : as :meth:`keep`.
        """
        with whole_folder(Path(folder)) as part:
            fill_scene_folder(scene.made, scene.record, scene.provenance, part, progress, drawn)
            if kept:
                self.keep(scene)

    def keep(self, scene: Scene) -> store.StoredScene:
        """Keep a scene under its name, with its players' motions as captures; all or nothing.

        A scene of the same name is replaced, with its captures.

        Raises
        ------
        QueryError : a player's capture would have the name of another capture.
        """
        database, name = self._session.store, scene.record.name
        made = scene.made
        parameters = {"scene": name, "diagram": made.text.diagram.name, **scene.record.settings}
        with store.transaction(database):
            if name in store.load_scene_names(database):
                self.remove(name)
            run_id = store.start_run(database, "scene make", parameters, made.settings.seed)
            kept = []
            for who, placed in zip(scene.record.players, made.polished.players, strict=True):
                capture = f"{name}/{who.name}"
                check_name_free(database, capture)
                motion = replace(placed.motion, leg_length=body.LEG_LENGTH)
                captions = action_captions(placed, tuple(clip.terminal for clip in who.clips))
                origin = scene.provenance[who.name]
                info = keep_generated(database, capture, motion, origin, captions, run_id)
                kept.append(replace(who, capture_id=info.capture_id))
            record = replace(scene.record, players=tuple(kept), run_id=run_id)
            store.save_scene(database, record, run_id)
            store.finish_run(database, run_id)
        return record

    def check_name(self, name: str, players: Iterable[str]) -> None:
        """Refuse a name under which a scene with these players cannot be kept (QueryError)."""
        if not name.strip():
            raise QueryError("name: expected a name for the scene, found nothing. Give one.")
        store.check_new_name(name, "scene")
        database = self._session.store
        replaced = (
            store.load_scene_captures(database, name)
            if name in store.load_scene_names(database)
            else ()
        )
        for player in players:
            if (capture := f"{name}/{player}") not in replaced:
                check_name_free(database, capture)

    def names(self) -> list[str]:
        """The names of the scenes that are kept."""
        return store.load_scene_names(self._session.store)

    def load(self, name: str) -> store.StoredScene:
        """A kept scene (QueryError)."""
        return store.load_scene(self._session.store, name)

    def find(self, place: str | Path) -> store.StoredScene:
        """The scene of a folder, or the kept one of this name.

        Raises
        ------
        QueryError, SceneError : there is neither.
        """
        if Path(place).is_dir():
            return read_scene_folder(Path(place))
        names = self.names()
        if str(place) not in names:
            there = suggestion(str(place), names) or (
                f" There are: {', '.join(names)}." if names else " No scene is kept."
            )
            raise QueryError(
                f"{place}: expected the folder of a scene, or the name of a kept one, found"
                f" neither.{there}"
            )
        return self.load(str(place))

    def remove(self, name: str) -> list[str]:
        """Take a kept scene out with its players' captures; gives their names (QueryError)."""
        database = self._session.store
        captures = store.load_scene_captures(database, name)
        numbers = [store.load_capture(database, capture).capture_id for capture in captures]
        with updating.changing(database, "scene remove", {"scene": name}, numbers):
            store.remove_scene(database, name)
            for number in numbers:
                store.remove_capture(database, number)
        return captures

    def draw(self, name: str, png: Path) -> Path:
        """Draw the ways of a kept scene's characters over its diagram.

        Raises
        ------
        QueryError : no such scene, or captures of its players were removed.
        """
        record = self.load(name)
        gone = [player.name for player in record.players if player.capture_id == -1]
        if gone:
            raise QueryError(
                f"{name}: expected the motions of its players, found that the captures of"
                f" {', '.join(gone)} were removed. Make the scene anew."
            )
        motions = {
            player.name: store.load_motion(self._session.store, player.capture_id)
            for player in record.players
        }
        return pictures.draw_scene_paths(
            read_diagram(record.diagram, name), motions, png, record.ball
        )


def check_folder(folder: str | Path) -> None:
    """Refuse a folder that cannot hold a scene (MotionDBError)."""
    check_scene_folder(Path(folder))


def action_captions(placed: Placed, actions: tuple[str, ...]) -> list[Caption]:
    """What a player does when, neighbours of one action together, seconds; nothing in waiting."""
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


def _report_rest(made: MadeScene) -> dict[str, Any]:
    """Frames that rules looked at, collisions, feet, bones and the ball, for the report."""
    report = made.report
    return {
        "rule_frames": [[rule.start, rule.end] for rule in report.rules],
        "collisions": [_rounded(asdict(touch)) for touch in report.collisions],
        "collisions_before": len(report.collisions_before),
        "feet": {f.player: [round(f.slip, 4), round(f.source_slip, 4)] for f in report.feet},
        "paces": [_rounded(asdict(pace), 3) for pace in report.paces],
        "impossible": [_rounded(asdict(motion)) for motion in report.impossible],
        "planted_feet": [_rounded(asdict(jump)) for jump in report.jumps],
        "near_limbs": [_rounded(asdict(pair)) for pair in report.limbs],
        "guards": [_rounded(asdict(guard)) for guard in report.guards],
        "bone_error": round(report.bone_error, 6),
        "ball_gap": None if np.isnan(report.ball_gap) else round(report.ball_gap, 4),
        "too_fast": list(made.too_fast),
        "settled": bool(made.polished.settled),
        "tries": made.tries,
        "cut_short": made.cut_short,
        **({"cut_at": dict(zip(("try", "rounds", "of"), made.cut_at))} if made.cut_short else {}),
    }


def _rounded(facts: dict[str, Any], digits: int = 4) -> dict[str, Any]:
    """Return facts for JSON: floats rounded, tuples as lists."""
    return {
        key: round(value, digits)
        if isinstance(value, float)
        else list(value)
        if isinstance(value, tuple)
        else value
        for key, value in facts.items()
    }


__all__ = ["Scene", "SceneSettings", "SceneText", "Scenes", "check_folder"]
