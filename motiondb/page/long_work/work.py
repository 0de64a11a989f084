"""The commands of a worker: add, learn, learn a grammar, make and keep scenes."""

from __future__ import annotations

import json
import pickle
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from motiondb.database import MotionDB
from motiondb.page.answers import Json, to_json

if TYPE_CHECKING:
    from motiondb.database.scenes.scene_verbs import Scene
    from motiondb.scene.polish.polish import PolishedScene
    from motiondb.store import StoredScene

Parameters = Mapping[str, Any]
SCENE_FILE = "scene.pickle"
MOST_SCENES = 8  # Largest number of scenes in memory; others are read from their folders


class Progress(Protocol):
    """Receives the progress of a command."""

    def progress(self, what: str, share: float, error: float | None = None) -> None:
        """Report the current step, the share of it that is done, and the error of a scene."""

    def preview(self, ref: str) -> None:
        """Report the ref of a first motion, which can be played before the work ends."""


class Workshop:
    """Runs commands on one database."""

    def __init__(self, database: Path, read_only: bool, wait: float) -> None:
        self._path, self._read_only, self._wait = database, read_only, wait
        self._opened: dict[bool, MotionDB] = {}
        self._scenes: OrderedDict[str, Scene] = OrderedDict()
        self._does = {
            "add": self._add,
            "learn": self._learn,
            "grammar": self._learn_grammar,
            "scene": self._make_scene,
            "scene-update": self._update_scene,
            "scene-keep": self._keep_scene,
            "scene-files": self._write_scene,
        }

    def do(self, kind: str, parameters: Parameters, progress: Progress) -> Json:
        """Run a command, release the database at its end, and return the result for JSON."""
        try:
            return self._does[kind](parameters, progress)
        finally:
            for database in self._opened.values():
                database.release()

    @property
    def reading(self) -> MotionDB:
        """The database, opened for reading; other processes may read at the same time."""
        return self._open(True)

    @property
    def database(self) -> MotionDB:
        """The database, opened for changes."""
        return self._open(self._read_only)

    def _open(self, read_only: bool) -> MotionDB:
        """Return the database, opened in a mode; its cache is kept for later commands."""
        if read_only not in self._opened:
            for other in self._opened.values():  # DuckDB allows one mode at a time
                other.release()
            self._opened[read_only] = MotionDB(self._path, read_only=read_only, wait=self._wait)
        return self._opened[read_only]

    def _add(self, parameters: Parameters, progress: Progress) -> dict[str, Any]:
        from motiondb.database.catalogue.file_reading import AddSettings
        from motiondb.files import unit_from_name

        unit, place = parameters["unit"], str(Path(parameters["folder"]).absolute())
        settings = AddSettings(
            unit=unit_from_name(unit) if unit else None,
            fps=parameters["fps"],
            skip_bad_frames=parameters["skip_bad_frames"],
            keep_implausible=parameters["keep_implausible"],
        )
        before = {info.name for info in self.database.captures()}
        report = self.database.add(
            parameters["folder"],
            parameters["words"],
            settings,
            lambda what, done, total: progress.progress(what, done / max(total, 1e-9)),
        )
        names = [info.name for info in self.database.captures() if info.name not in before]
        return {
            "added": len(report.added),
            "known": len(report.known),
            "captures": names,
            "problems": [_without_folder(problem, place) for problem in report.problems],
            "notes": [_without_folder(note, place) for note in report.notes],
            "new_words": report.new_words,
            "counted": report.counted,
            "seconds": round(report.seconds, 2),
        }

    def _learn(self, parameters: Parameters, progress: Progress) -> dict[str, Any]:
        from motiondb.learn.symbol_fitting import LearnSettings

        settings = LearnSettings(n_symbols=parameters["symbols"], seed=parameters["seed"])
        learned = self.database.learn(settings, progress.progress)
        return {
            "captures": len(set(learned.segments.capture_ids.tolist())),
            "segments": len(learned.segments.symbols),
            "symbols": learned.symbols.n_symbols,
            "clusters": len(learned.space.weights),
            "dimensions": learned.space.coordinates.shape[1],
            "words": len(learned.association.words),
        }

    def _learn_grammar(self, parameters: Parameters, progress: Progress) -> dict[str, Any]:
        from motiondb.database.grammars.grammar_learning import GrammarSettings

        settings = GrammarSettings(**parameters["settings"])
        learned, lost = self.database.grammars.learn(
            parameters["captures"],
            parameters["name"],
            settings,
            lambda what, done, total: progress.progress(what, done / max(total, 1e-9)),
        )
        return {"grammar": learned.name, "lost": lost}

    def _make_scene(self, parameters: Parameters, progress: Progress) -> dict[str, Any]:
        from motiondb.database.scenes.scene_making import SceneSettings

        settings = SceneSettings(**parameters["settings"])
        course = _Course(progress)
        scene = self.reading.scenes.make(parameters["diagram"], settings, course.tell)
        return self._finished(scene, parameters, course)

    def _update_scene(self, parameters: Parameters, progress: Progress) -> dict[str, Any]:
        from motiondb.database.scenes.scene_making import SceneSettings
        from motiondb.database.scenes.scene_texts import read_scene_text
        from motiondb.page.facts import scene_facts

        course, first = _Course(progress), f"first:{parameters['scene']}"
        diagram = read_scene_text(parameters["diagram"]).diagram

        def show(polished: PolishedScene) -> None:
            data = scene_facts.first_motion(polished, diagram, first)
            (Path(parameters["folder"]) / scene_facts.FIRST_FILE).write_bytes(data)
            progress.preview(first)

        earlier = self._earlier(parameters["earlier"])
        settings = replace(SceneSettings(**earlier.settings), **parameters["settings"])
        scene = self.reading.scenes.update(
            earlier, parameters["diagram"], settings, course.tell, show
        )
        return self._finished(scene, parameters, course)

    def _earlier(self, earlier: Parameters) -> StoredScene:
        if earlier["folder"] is None:
            return self.reading.scenes.load(earlier["name"])
        return self._scene(earlier["name"], Path(earlier["folder"])).record

    def _finished(self, scene: Scene, parameters: Parameters, course: _Course) -> dict[str, Any]:
        """Write the files of a scene for the server; the motions first, to be played early."""
        from motiondb.page.facts import scene_facts

        folder, name = Path(parameters["folder"]), parameters["scene"]
        folder.mkdir(mode=0o700, exist_ok=True)
        (folder / scene_facts.MOTION_FILE).write_bytes(
            scene_facts.made_scene_motion(scene, f"scene:{name}")
        )
        facts = to_json(scene_facts.made_scene_facts(scene, course.points))
        (folder / scene_facts.FACTS_FILE).write_text(json.dumps(facts), encoding="utf-8")
        (folder / SCENE_FILE).write_bytes(pickle.dumps(scene))
        self._remember(name, scene)
        return {"scene": name, "ref": f"scene:{name}"}

    def _scene(self, name: str, folder: Path) -> Scene:
        """Return a scene that this process or an earlier process of this server made."""
        if name not in self._scenes:
            # written above, into a folder that only this user can write
            self._remember(name, pickle.loads((folder / SCENE_FILE).read_bytes()))
        return self._scenes[name]

    def _remember(self, name: str, scene: Scene) -> None:
        self._scenes[name] = scene
        while len(self._scenes) > MOST_SCENES:
            self._scenes.popitem(last=False)

    def _keep_scene(self, parameters: Parameters, _progress: Progress) -> dict[str, Any]:
        scene = self._scene(parameters["scene"], Path(parameters["folder"]))
        name = parameters["name"]
        self.database.scenes.check_name(name, [player.name for player in scene.record.players])
        self.database.scenes.keep(replace(scene, record=replace(scene.record, name=name)))
        return {"ref": f"kept:{name}"}

    def _write_scene(self, parameters: Parameters, _progress: Progress) -> dict[str, Any]:
        scene = self._scene(parameters["scene"], Path(parameters["folder"]))
        self.reading.scenes.write(scene, parameters["output"], drawn=False)
        return {"output": parameters["output"]}


class _Course:
    """Records the error of a scene while it is sampled, and passes it on."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self.points: list[tuple[float, float]] = []

    def tell(self, what: str, share: float, error: float) -> None:
        """Record a step of the sampling."""
        known = error if error == error else None  # NaN where it is unknown
        if known is not None and what.startswith("sampling"):
            self.points.append((share, known))
        self._progress.progress(what, share, known)


def _without_folder(sentence: str, folder: str) -> str:
    """Return a sentence of a report without the server's private folder."""
    return sentence.replace(f"{folder}/", "").replace(folder, "upload")
