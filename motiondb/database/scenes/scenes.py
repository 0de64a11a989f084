"""The verbs of scenes: ``db.scenes.make``, ``update``, ``write``, ``keep``, ``find``, ``remove``.

A diagram specifies what happens, a motion grammar how, and the captures of the database provide the
motion. A scene can be written into a folder, and kept in the store under a name. Every player's
motion is then a capture, ``NAME/PLAYER``, with the origin of its frames.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import pictures, store
from motiondb.body import body
from motiondb.database.catalogue.cataloguing import check_name_free
from motiondb.database.generated_files import keep_generated
from motiondb.database.learn import updating
from motiondb.database.scenes import scene_folder, scene_making, scene_records, scene_texts
from motiondb.database.scenes.scene_making import FirstMotion, SceneProgress, SceneSettings
from motiondb.database.scenes.scene_records import record_text
from motiondb.database.scenes.scene_texts import SceneText, read_scene_text
from motiondb.database.session import Topic
from motiondb.errors import QueryError, SceneError, suggestion
from motiondb.files.safe_files import is_folder, whole_folder
from motiondb.records import Motion
from motiondb.scene.clips.caption_actions import FoundActions, ShownAction
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.polish.placed import Placed
from motiondb.scene.services import services
from motiondb.search.takings import Taking
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Scene(Tabled):
    """A made scene: how it was made, its record, and the origin of every frame of each player."""

    made: scene_making.MadeScene
    record: store.StoredScene
    provenance: Mapping[str, store.Provenance]

    @property
    def broken(self) -> tuple[store.SceneRule, ...]:
        """The rules that do not hold."""
        return tuple(rule for rule in self.record.rules if not rule.kept)


_CHANGING = ("add", "remove", "words", "events")
"""Kinds of runs after which the same diagram, seed and settings may give another scene."""


def _quiet(_what: str, _share: float, _error: float) -> None:
    """Ignore the progress."""


class Scenes(Topic):
    """The scenes of a database; reached as ``db.scenes``.

    Verbs on motion grammars, diagrams and folders need no database: ``Scenes.validate(...)``. There
    ``grammar`` is a file, the name of a shipped grammar, or a MotionGrammar, and ``diagram`` a
    tactics file or the name of a shipped one. Actions are given as names separated by spaces, or as
    a sequence of names; ``start`` is the start symbol, by default any that fits. ``progress`` is
    called with the step, the fraction that is done, and the error. A SceneError is raised if a file
    has a fault, and a QueryError if no kept scene has a name.
    """

    def make(
        self,
        diagram: str | Path,
        settings: SceneSettings | None = None,
        progress: SceneProgress = _quiet,
        name: str = "",
        shown: FirstMotion | None = None,
    ) -> Scene:
        """Make a scene of a diagram. Nothing is kept.

        Parameters
        ----------
        settings : SceneSettings or None
            Settings of the scene.
        name : str
            Name of the scene; by default the title of the diagram.
        shown : FirstMotion or None
            Called once with a first motion, after a few rounds.

        Raises
        ------
        SceneError
            Also when an action has no clips.
        """
        text = read_scene_text(diagram)
        progress("loading", 0.0, np.nan)
        settings = settings or SceneSettings()
        with self.session.reading():
            clips = scene_making.scene_clips(self.session, text.grammar, exact=settings.exact)
            digests = self._digests()
        progress("loading", 1.0, np.nan)
        with store.released(self.store):
            made = scene_making.make(text, clips, settings, progress, shown=shown)
        return self._finished(made, name or text.diagram.name, digests)

    def update(
        self,
        earlier: store.StoredScene,
        diagram: str | Path,
        settings: SceneSettings | None = None,
        progress: SceneProgress = _quiet,
        shown: FirstMotion | None = None,
    ) -> Scene:
        """Make the scene of a changed diagram from an earlier scene; unchanged parts stay.

        Parameters
        ----------
        earlier : store.StoredScene
            The record of the earlier scene.
        settings : SceneSettings or None
            Settings of the scene; by default the earlier ones.
        shown : FirstMotion or None
            Called with the motions of the first try, before its report is made.
        """
        old, new = record_text(earlier), read_scene_text(diagram)
        settings = settings or SceneSettings(**earlier.settings)
        if new.grammar_text != old.grammar_text:
            return self.make(diagram, settings, progress, earlier.name, shown)
        with self.session.reading():
            clips = scene_making.scene_clips(self.session, new.grammar, exact=settings.exact)
            digests = self._digests()
        state = scene_records.record_state(earlier, old, clips.library)
        with store.released(self.store):
            start = old.diagram, state
            made = scene_making.make(new, clips, settings, progress, start, shown)
        return self._finished(made, earlier.name, digests)

    def _digests(self) -> dict[str, str]:
        """Digests of all captures by name."""
        return {info.name: info.sha256 for info in store.load_captures(self.store)}

    def _finished(
        self, made: scene_making.MadeScene, name: str, digests: Mapping[str, str]
    ) -> Scene:
        """The scene with the origin of its frames.

        `digests`: Those of the captures when its clips were loaded; others may have changed the
        database while it was made.
        """
        with self.session.reading():
            infos = {info.name: info for info in store.load_captures(self.store)}
            used = {capture for player in made.polished.players for capture in player.captures}
            gone = {n for n in used if n not in infos or infos[n].sha256 != digests[n]}
            if gone:
                raise SceneError(
                    f"{name}: expected the captures of the scene to stay as they are while it is "
                    f"made, found that {', '.join(sorted(gone))} were removed or replaced. Make it "
                    "again."
                )
            provenance = {
                player.player: self._provenance(player, {n: i.capture_id for n, i in infos.items()})
                for player in made.polished.players
            }
        sources = scene_folder.source_list(list(provenance.values()))
        record = scene_records.scene_record(made, name, digests, sources)
        return Scene(made, record, provenance)

    def _provenance(self, player: Placed, numbers: Mapping[str, int]) -> store.Provenance:
        captures = np.array([numbers[capture] for capture in player.captures], dtype=np.int64)
        return store.to_provenance(
            self.store,
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
        """Write a scene's folder, in place of an earlier scene's; with ``kept``, keep it as well.

        If anything fails, folder and database do not change.

        Parameters
        ----------
        drawn : bool
            Whether pictures are made.
        kept : bool
            Whether to keep the scene in the database too, as :meth:`keep` does.
        """
        with whole_folder(Path(folder), self.check_folder) as part:
            origins = scene.provenance
            scene_folder.fill_scene_folder(scene.made, scene.record, origins, part, progress, drawn)
            if kept:
                self.keep(scene)

    def keep(self, scene: Scene) -> store.StoredScene:
        """Keep a scene under its name, with its players' motions as captures; all or nothing.

        A scene of the same name is replaced, with its captures. QueryError is raised if a player's
        capture would have the name of another capture.
        """
        database, name, made = self.store, scene.record.name, scene.made
        parameters = {"scene": name, "diagram": made.text.diagram.name, **scene.record.settings}
        if made.cut_at[2] != made.settings.rounds:  # it began with an earlier scene
            parameters["updated"] = True
        with store.transaction(database):
            if name in store.load_scene_names(database):
                self.remove(name)
            with store.running(database, "scene make", parameters, made.settings.seed) as run_id:
                kept = []
                for who, placed in zip(scene.record.players, made.polished.players, strict=True):
                    capture = f"{name}/{who.name}"
                    check_name_free(database, capture)
                    motion = replace(placed.motion, leg_length=body.LEG_LENGTH)
                    actions = tuple(clip.terminal for clip in who.clips)
                    captions = scene_records.action_captions(placed, actions)
                    origin = scene.provenance[who.name]
                    info = keep_generated(database, capture, motion, origin, captions, run_id)
                    kept.append(replace(who, capture_id=info.capture_id))
                record = replace(scene.record, players=tuple(kept), run_id=run_id)
                store.save_scene(database, record, run_id)
        return record

    def check_new(self, name: str, text: SceneText, settings: SceneSettings) -> None:
        """Refuse, before a scene is made, a name under which it could not be kept.

        QueryError is raised as for :meth:`check_name`, or if this very scene is kept under another
        name.
        """
        self.check_name(name, text.diagram.player)
        database = self.store
        runs = {run.run_id: run for run in store.load_runs(database)}
        changed = max((n for n, run in runs.items() if run.kind in _CHANGING), default=0)
        asked = (text.diagram_text, text.grammar_text, asdict(settings))
        for other in store.load_scene_names(database):
            kept = store.load_scene(database, other)
            same = asked == (kept.diagram, kept.grammar, dict(kept.settings))
            if other == name or not same or kept.run_id < changed:
                continue
            if kept.report["cut_short"] or "updated" in runs[kept.run_id].parameters:
                continue  # the seed alone does not determine it
            raise QueryError(
                f"{name}: expected a scene that is not kept yet, found the same diagram, seed and "
                f"settings kept as {other}. Give another --seed, or remove that one first: motiondb"
                f" scene remove {other}."
            )

    def check_name(self, name: str, players: Iterable[str]) -> None:
        """Refuse a name under which a scene with these players cannot be kept.

        QueryError is raised for an empty name, or where a capture has the name of a player's.
        """
        if not name.strip():
            raise QueryError("name: expected a name for the scene, found nothing. Give one.")
        store.check_new_name(name, "scene")
        database = self.store
        is_kept = name in store.load_scene_names(database)
        replaced = store.load_scene_captures(database, name) if is_kept else ()
        for player in players:
            if (capture := f"{name}/{player}") not in replaced:
                check_name_free(database, capture)

    def find_actions(
        self, grammar: str | Path | MotionGrammar, exact: bool = False
    ) -> dict[str, tuple[ShownAction, ...]]:
        """Parts of captures whose captions show the terminals of a grammar."""
        return dict(self._found(grammar, exact).parts)

    def _found(self, grammar: str | Path | MotionGrammar, exact: bool = False) -> FoundActions:
        with self.session.reading():
            return scene_making.find_actions(self.session, self.read_grammar(grammar), exact)

    def nearest_words(self, grammar: str | Path | MotionGrammar) -> dict[str, tuple[str, ...]]:
        """The words of captions that are nearest to those of every terminal without clips."""
        found = self._found(grammar)
        return {n: near for n, near in found.nearest().items() if not found.parts[n]}

    def taken_words(self, grammar: str | Path | MotionGrammar) -> dict[str, Taking]:
        """What words of a grammar's phrases are taken as that no caption holds."""
        return dict(self._found(grammar).takings)

    def names(self) -> list[str]:
        """Return the names of the kept scenes."""
        return store.load_scene_names(self.store)

    def load(self, name: str) -> store.StoredScene:
        """Return a kept scene."""
        return store.load_scene(self.store, name)

    def find(self, place: str | Path) -> store.StoredScene:
        """Return the scene of a folder, or the kept one of this name."""
        if self.is_folder(place):
            return self.read_folder(place)
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
        """Remove a kept scene with its players' captures, and return the names of these."""
        database = self.store
        with store.transaction(database):  # others may remove captures meanwhile
            captures = store.load_scene_captures(database, name)
            numbers = [info.capture_id for info in store.load_named(database, captures)]
            with updating.changing(database, "scene remove", {"scene": name}, numbers):
                store.remove_scene(database, name)
                store.remove_captures(database, numbers)
        return captures

    def motions(self, record: store.StoredScene) -> dict[str, Motion]:
        """Return the motions of a kept scene's players; QueryError if captures were removed."""
        gone = [player.name for player in record.players if player.capture_id == -1]
        if gone:
            raise QueryError(
                f"{record.name}: expected the motions of its players, found that the captures of"
                f" {', '.join(gone)} were removed. Make the scene again."
            )
        opened = self.store
        return {p.name: store.load_motion(opened, p.capture_id) for p in record.players}

    def draw(self, name: str, png: str | Path | None = None) -> Path | Figure:
        """Draw the paths of a kept scene's characters over its diagram."""
        record = self.load(name)
        diagram, motions = record_text(record).diagram, self.motions(record)
        return pictures.save_png(pictures.scene_paths_figure(diagram, motions, record.ball), png)

    @staticmethod
    def read_grammar(grammar: str | Path | MotionGrammar) -> MotionGrammar:
        """Read a motion grammar from a file, or the shipped one of this name."""
        return grammar if isinstance(grammar, MotionGrammar) else scene_texts.read_grammar(grammar)

    @classmethod
    def check_grammar(cls, grammar: str | Path | MotionGrammar) -> services.GrammarReport:
        """Report ambiguous strings, useless and empty symbols of a grammar."""
        return services.check(cls.read_grammar(grammar))

    @classmethod
    def validate(
        cls, grammar: str | Path | MotionGrammar, actions: str | Sequence[str], start: str = ""
    ) -> services.Validation:
        """Parse a string of actions: its tree, or the place and reason of the failure."""
        return services.validate(cls.read_grammar(grammar), _names(actions), start)

    @classmethod
    def suggest(
        cls, grammar: str | Path | MotionGrammar, actions: str | Sequence[str], start: str = ""
    ) -> services.Suggestions:
        """Return the actions that may come next, with the probabilities of the grammar's rules."""
        return services.suggest(cls.read_grammar(grammar), _names(actions), start)

    @classmethod
    def plan(
        cls,
        grammar: str | Path | MotionGrammar,
        actions: str | Sequence[str],
        goals: Sequence[str | Collection[str]],
        start: str = "",
    ) -> tuple[str, ...]:
        """Return the shortest string that continues some actions and reaches goals in order.

        Parameters
        ----------
        goals : sequence of str or collection of str
            Actions to reach, in this order; any member of a collection will do.

        Returns
        -------
        tuple of str
            The whole string, which begins with ``actions``.
        """
        wanted = [(goal,) if isinstance(goal, str) else tuple(goal) for goal in goals]
        return services.plan(cls.read_grammar(grammar), _names(actions), wanted, start).leaves()

    read_diagram = staticmethod(read_scene_text)

    @classmethod
    def draw_diagram(
        cls, diagram: str | Path | SceneText, path: str | Path | None = None
    ) -> Path | Figure:
        """Draw a tactics diagram as PNG."""
        text = diagram if isinstance(diagram, SceneText) else cls.read_diagram(diagram)
        return pictures.save_png(pictures.tactics_figure(text.diagram), path)

    is_folder = staticmethod(is_folder)
    check_folder = staticmethod(scene_folder.check_scene_folder)
    read_folder = staticmethod(scene_folder.read_scene_folder)
    draw_folder = staticmethod(scene_folder.draw_folder)
    facts = staticmethod(scene_folder.report_facts)
    report = staticmethod(scene_folder.report_text)

    @staticmethod
    def seen(scene: store.StoredScene) -> list[str]:
        """Return what a viewer of a scene sees at once although no rule is about it, as lines."""
        return scene_folder.seen_lines(scene_folder.report_facts(scene))

    @staticmethod
    def remarks(scene: store.StoredScene) -> list[str]:
        """Return one line for a sampling that was cut short, and for every impossible motion."""
        facts = scene_folder.report_facts(scene)
        return scene_folder.cut_short_lines(facts) + scene_folder.impossible_lines(facts)


def _names(actions: str | Sequence[str]) -> list[str]:
    return actions.split() if isinstance(actions, str) else list(actions)
