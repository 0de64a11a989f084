"""The process that runs long jobs for the page: add, learn, learn a grammar, make and keep scenes.

It is started as ``python -m motiondb.page.worker DATABASE MODE``.

It reads commands from standard input, one JSON object a line: ``{"kind", "parameters"}``. It writes
events to standard output: ``{"what", "share", "error"}`` while it works, then ``{"done": result}``
or ``{"failed": message, "kind": name of the error}``. It ends when standard input is closed, so
that it does not outlive the server.
"""

from __future__ import annotations

import json
import os
import pickle
import sys
import tempfile
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from queue import Queue
from typing import TYPE_CHECKING, Any, TextIO

from motiondb import answers
from motiondb.database import MotionDB
from motiondb.errors import MotionDBError
from motiondb.page.jobs import FACTS_FILE, FIRST_FILE, MOTION_FILE
from motiondb.page.motion import pack_scene
from motiondb.store import StoredScene

if TYPE_CHECKING:
    from motiondb.database.scenes.scenes import Scene
    from motiondb.scene.polish.polish import PolishedScene

WAIT = 300.0  # Seconds to wait for a process that holds the database
EVERY = 0.05  # Seconds between two events of one step
Parameters = Mapping[str, Any]
SCENE_FILE = "scene.pickle"
MOST_SCENES = 8  # Largest number of scenes in memory; others are read from their folders


class Events:
    """Writes events, at most one every ``EVERY`` seconds for the same step."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._what, self._told = "", 0.0

    def progress(self, what: str, share: float, error: float | None = None) -> None:
        """Report the progress of a step."""
        now = time.monotonic()
        if what == self._what and now - self._told < EVERY and share < 1.0:
            return
        self._what, self._told = what, now
        self.write({"what": what, "share": share, "error": error})

    def counted(self, what: str, done: float, total: float) -> None:
        """Report the progress of a step by the number that is done."""
        self.progress(what, done / max(total, 1e-9))

    def write(self, event: dict[str, Any]) -> None:
        """Write an event."""
        text = json.dumps(answers.to_json(event), ensure_ascii=False)
        # names of files may hold lone surrogates, which the answers of the server cannot
        self._out.write(text.encode("utf-8", "replace").decode() + "\n")
        self._out.flush()


def _first_motion(parameters: Parameters, progress: Events) -> Callable[[PolishedScene], None]:
    """What writes a first motion of a scene for the server, and tells it."""
    from motiondb.database.scenes.scene_texts import read_scene_text

    ref = f"first:{parameters['scene']}"
    diagram = read_scene_text(parameters["diagram"]).diagram

    def show(polished: PolishedScene) -> None:
        folder = Path(parameters["folder"])
        folder.mkdir(mode=0o700, exist_ok=True)
        (folder / FIRST_FILE).write_bytes(pack_scene(polished, diagram, ref))
        progress.write({"preview": ref})

    return show


class Workshop:
    """Runs commands on one database."""

    def __init__(self, database: Path, read_only: bool, wait: float) -> None:
        self._path, self._read_only, self._wait = database, read_only, wait
        self._opened: dict[bool, MotionDB] = {}
        self._scenes: OrderedDict[str, Scene] = OrderedDict()
        self._does = {
            "add": self._add,
            "learn": self._learn,
            "sample": self._add_sample,
            "grammar": self._learn_grammar,
            "scene": self._make_scene,
            "scene-update": self._update_scene,
            "scene-keep": self._keep_scene,
            "scene-files": self._write_scene,
        }

    def do(self, kind: str, parameters: Parameters, progress: Events) -> Any:  # noqa: ANN401
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

    def _add(self, parameters: Parameters, progress: Events) -> answers.AddResult:
        from motiondb.database.catalogue.file_reading import AddSettings
        from motiondb.files.units import unit_from_name

        unit, places = parameters["unit"], [str(Path(parameters["folder"]).absolute())]
        words, within = parameters["words"], parameters["within"]
        if words and within:
            words = _copied(Path(words), Path(within))
            places.append(str(words.parent))
        read: dict[str, Any] = {"unit": unit_from_name(unit) if unit else None}
        read["within"] = Path(within) if within else None
        others = {"folder", "words", *read}
        settings = AddSettings(**{k: v for k, v in parameters.items() if k not in others}, **read)
        before = {info.name for info in self.database.captures()}
        report = self.database.add(parameters["folder"], words, settings, progress.counted)
        names = [info.name for info in self.database.captures() if info.name not in before]
        return answers.AddResult(
            added=len(report.added),
            known=len(report.known),
            captures=names,
            problems=[_without_folders(problem, places) for problem in report.problems],
            notes=[_without_folders(note, places) for note in report.notes],
            new_words=list(report.new_words),
            counted=report.counted,
            seconds=round(report.seconds, 2),
        )

    def _add_sample(self, _parameters: Parameters, progress: Events) -> answers.LearnResult:
        self.database.captures.add_sample(progress.counted)
        return self._learn({"symbols": None, "seed": 0, "start": None}, progress)

    def _learn(self, parameters: Parameters, progress: Events) -> answers.LearnResult:
        from motiondb.learn.recognition import LearnSettings

        settings = LearnSettings(n_symbols=parameters["symbols"], seed=parameters["seed"])
        learned = self.database.learn(settings, progress.progress, parameters["start"])
        first = self.database.symbols.start_facts()
        size = answers.learned_summary(learned)
        return answers.extended(answers.LearnResult, size, start=first.name if first else None)

    def _learn_grammar(self, parameters: Parameters, progress: Events) -> answers.GrammarLearned:
        from motiondb.database.grammars.grammar_learning import GrammarSettings

        settings, captures = GrammarSettings(**parameters["settings"]), parameters["captures"]
        learned, lost = self.database.grammars.learn(
            captures, parameters["name"], settings, progress.counted
        )
        return answers.GrammarLearned(grammar=learned.name, no_longer_editable=list(lost))

    def _make_scene(self, parameters: Parameters, progress: Events) -> answers.SceneMade:
        from motiondb.database.scenes.scene_making import SceneSettings

        settings = SceneSettings(**parameters["settings"])
        course = _Course(progress)
        show = _first_motion(parameters, progress)
        scene = self.reading.scenes.make(parameters["diagram"], settings, course.tell, "", show)
        return self._finished(scene, parameters, course)

    def _update_scene(self, parameters: Parameters, progress: Events) -> answers.SceneMade:
        from motiondb.database.scenes.scene_making import SceneSettings

        course, show = _Course(progress), _first_motion(parameters, progress)
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

    def _finished(self, scene: Scene, parameters: Parameters, course: _Course) -> answers.SceneMade:
        """Write the files of a scene for the server; the motions first, to be played early."""
        folder, name = Path(parameters["folder"]), parameters["scene"]
        folder.mkdir(mode=0o700, exist_ok=True)
        from motiondb.page.replies import made_scene_reply

        ref = f"scene:{name}"
        data = pack_scene(scene.made.polished, scene.made.text.diagram, ref)
        (folder / MOTION_FILE).write_bytes(data)
        facts = answers.to_json(made_scene_reply(ref, scene, course.points))
        (folder / FACTS_FILE).write_text(json.dumps(facts), encoding="utf-8")
        (folder / SCENE_FILE).write_bytes(pickle.dumps(scene))
        self._remember(name, scene)
        return answers.SceneMade(scene=name, ref=ref)

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

    def _keep_scene(self, parameters: Parameters, _progress: Events) -> dict[str, Any]:
        scene = self._scene(parameters["scene"], Path(parameters["folder"]))
        name = parameters["name"]
        self.database.scenes.check_name(name, [player.name for player in scene.record.players])
        self.database.scenes.keep(replace(scene, record=replace(scene.record, name=name)))
        return {"ref": f"kept:{name}"}

    def _write_scene(self, parameters: Parameters, _progress: Events) -> dict[str, Any]:
        scene = self._scene(parameters["scene"], Path(parameters["folder"]))
        self.reading.scenes.write(scene, parameters["output"], drawn=False)
        return {"output": parameters["output"]}


class _Course:
    """Records the error of a scene while it is sampled, and passes it on."""

    def __init__(self, progress: Events) -> None:
        self._progress = progress
        self.points: list[tuple[float, float]] = []

    def tell(self, what: str, share: float, error: float) -> None:
        """Record a step of the sampling."""
        known = error if error == error else None  # NaN where it is unknown
        if known is not None and what.startswith("sampling"):
            self.points.append((share, known))
        self._progress.progress(what, share, known)


def _copied(sheet: Path, within: Path) -> Path:
    """Copy a sheet into this server's own folder, so that it is read from no other place."""
    from motiondb.files.formats import read_file
    from motiondb.files.limits import ReadOptions

    copy = Path(tempfile.mkdtemp(dir=Path.cwd())) / sheet.name
    copy.write_bytes(read_file(sheet, ReadOptions(within=within)))
    return copy


def _without_folders(sentence: str, folders: Sequence[str]) -> str:
    """Return a sentence of a report without the folders that it was made from."""
    for folder in folders:
        sentence = sentence.replace(f"{folder}/", "").replace(folder, "upload")
    return sentence


def _read(commands: Queue[dict[str, Any]]) -> None:
    """Queue the commands of standard input; end the process when the input ends."""
    for line in sys.stdin:
        commands.put(json.loads(line))
    os._exit(0)


def main() -> None:
    """Run commands until standard input ends."""
    database, mode = Path(sys.argv[1]), sys.argv[2]
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # output of libraries must not mix with the events
    commands: Queue[dict[str, Any]] = Queue()
    threading.Thread(target=_read, args=(commands,), daemon=True).start()
    events = Events(out)
    workshop = Workshop(database, mode == "read-only", WAIT)
    while True:
        command = commands.get()
        try:
            events.write({"done": workshop.do(command["kind"], command["parameters"], events)})
        except MotionDBError as error:
            events.write({"failed": str(error), "kind": type(error).__name__})
        except MemoryError:
            events.write({"failed": "expected enough memory, found too little.", "kind": "Memory"})
        except Exception as error:  # a bug; the server must be informed
            events.write({"failed": f"{type(error).__name__}: {error}", "kind": "ProgramError"})


if __name__ == "__main__":
    main()
